//! `boxwood figure`.

use crate::bench::{Bench, is_svg};
use std::fs;
use std::path::Path;

/// The figures, and how many framed pictures each has.
const FIGURES: [(&str, usize); 13] = [
    ("slabs", 2),
    ("ray-box", 6),
    ("axis-aligned", 2),
    ("grid-build", 1),
    ("grid-walk", 1),
    ("grid-resolution", 3),
    ("teapot-in-stadium", 8),
    ("side-by-side", 3),
    ("kd-build", 0),
    ("kd-traversal", 0),
    ("bvh-build", 0),
    ("bvh-traversal", 0),
    ("spatial-split", 4),
];
/// More makes no slide.
const MOST_BYTES: usize = 150_000;

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).expect("text")
}

fn frames(text: &str) -> usize {
    text.matches("<svg ").count() - 1
}

#[test]
fn every_figure_is_a_drawing_of_its_own() {
    let bench = Bench::new();
    let list = bench.good("figure --list");
    assert_eq!(list.lines().count(), FIGURES.len());
    for (line, (name, pictures)) in list.lines().zip(FIGURES) {
        assert!(line.starts_with(name) && line.ends_with('?'), "{line}");
        let said = bench.good(&format!("figure {name}"));
        assert_eq!(said, format!("wrote {name}.svg\n"));
        let drawn = text(bench.read(&format!("{name}.svg")));
        assert!(is_svg(&drawn) && drawn.len() < MOST_BYTES, "{name}");
        assert!(drawn.contains("viewBox=\"0 0 900 "), "{name}");
        if pictures > 0 {
            assert_eq!(frames(&drawn), pictures, "{name}");
        }
        // A second time, to another place.
        assert_eq!(bench.good(&format!("figure {name} -o -")), drawn, "{name}");
    }
}

/// Builds and traversals have a frame for each level or step that they speak of.
#[test]
fn films_are_complete() {
    let bench = Bench::new();
    for name in ["kd-traversal", "bvh-traversal"] {
        let drawn = bench.good(&format!("figure {name} -o -"));
        let count = frames(&drawn);
        assert!(
            drawn.contains(&format!(" {count} steps, ")),
            "{name}: {count}"
        );
        assert!(drawn.contains(&format!(">{count}. ")), "{name}");
        assert!(drawn.contains("hit at t = "), "{name}");
    }
    for name in ["kd-build", "bvh-build"] {
        let drawn = bench.good(&format!("figure {name} -o -"));
        let count = frames(&drawn);
        assert!(count >= 4, "{name}: {count}");
        assert!(drawn.contains(&format!(">{}. ", count - 1)), "{name}");
        assert!(!drawn.contains(&format!(">{count}. ")), "{name}");
    }
}

/// What lies in the gallery is what the command makes today; `boxwood figure --all --dir gallery/figures` renews it.
#[test]
fn the_gallery_is_up_to_date() {
    let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gallery");
    let page = fs::read_to_string(gallery.join("README.md")).expect("a page");
    let bench = Bench::new();
    assert_eq!(
        bench.good("figure --all --dir some/folder"),
        "wrote 13 figures to some/folder\n"
    );
    for (name, _) in FIGURES {
        let made = text(bench.read(&format!("some/folder/{name}.svg")));
        let kept = fs::read_to_string(gallery.join(format!("figures/{name}.svg")));
        // Without the whole of both files in the message.
        assert!(kept.is_ok_and(|kept| kept == made), "{name} is stale");
        assert!(page.contains(&format!("(figures/{name}.svg)")), "{name}");
        assert!(page.contains(&format!("`boxwood figure {name}`")), "{name}");
    }
    let kept = fs::read_dir(gallery.join("figures")).expect("a folder");
    assert_eq!(kept.count(), FIGURES.len());
}

#[test]
fn other_words_are_usage_errors() {
    let bench = Bench::new();
    let said = bench.misused("figure kd");
    for (name, _) in FIGURES {
        assert!(said.contains(name), "{name}: {said}");
    }
    for words in [
        "figure",
        "figure --all",
        "figure slabs --all --dir x",
        "figure --all --list",
        "figure --dir x",
        "figure -o x.svg",
        "figure slabs --list",
    ] {
        bench.misused(words);
    }
    assert!(bench.files().is_empty());
    assert_eq!(
        bench.refused("figure slabs -o none/x.svg"),
        "none/x.svg: cannot be written: there is no folder none"
    );
}
