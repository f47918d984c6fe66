//! `boxwood compare`.

use crate::bench::{Bench, LAYERS};
use serde_json::Value;

/// Small and quick.
const QUICK: &str = "--count 400 --rounds 2 --size 48x27 --threads 1";

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    bench
}

/// A close look at both layers.
fn compare(words: &str) -> String {
    format!("compare layers.obj --eye 0.3,0.3,3 --look-at 0.3,0.3,0 {QUICK} {words}")
}

#[test]
fn every_structure_is_measured_and_every_column_won() {
    let bench = bench();
    let report = bench.json(&compare("--json"));
    assert_eq!(report["format_version"], 1);
    assert_eq!(report["settings"]["triangles"], 3);
    assert!(report["machine"]["cores"].as_u64() > Some(0));
    assert_eq!(report["sweep"], Value::Null);

    let kinds = ["primary", "shadow", "ao", "diffuse", "random"];
    let workloads = report["workloads"].as_array().expect("a list");
    let names: Vec<_> = workloads.iter().map(|w| w["kind"].as_str()).collect();
    assert_eq!(names, kinds.map(Some));
    assert_eq!(workloads[1]["question"], "occluded");
    assert!(
        workloads.iter().all(|w| w["rays"].as_u64() > Some(20)),
        "{workloads:?}"
    );

    let structures = report["structures"].as_array().expect("a list");
    assert!(structures.len() >= 3);
    assert_eq!(structures[0]["structure"], "brute");
    for structure in structures {
        assert_eq!(structure["failure"], Value::Null);
        let found = &structure["measured"];
        assert!(found["mrays_per_second"].as_f64() > Some(0.0));
        let shares = found["histogram"].as_array().expect("a list");
        let sum: f64 = shares.iter().filter_map(Value::as_f64).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        for (traced, workload) in found["rays"]
            .as_array()
            .expect("a list")
            .iter()
            .zip(workloads)
        {
            assert_eq!(traced["kind"], workload["kind"]);
            assert_eq!(traced["rays_asked"], workload["rays"]);
        }
    }
    // The mean is that of the kinds, and the speed-up over the first.
    let rate = |i: usize, kind: usize| {
        structures[i]["measured"]["rays"][kind]["mrays_per_second"]
            .as_f64()
            .expect("a rate")
    };
    let logs: f64 = (0..5).map(|kind| rate(1, kind).ln()).sum();
    let mean = structures[1]["measured"]["mrays_per_second"].as_f64();
    assert!((mean.expect("a mean") / (logs / 5.0).exp() - 1.0).abs() < 1e-9);
    let speedup = structures[1]["measured"]["rays"][0]["speedup"].as_f64();
    assert!((speedup.expect("a factor") / (rate(1, 0) / rate(0, 0)) - 1.0).abs() < 1e-9);

    // The winner of a column is the best there, and never the exhaustive test.
    let winners = report["winners"].as_object().expect("a table");
    for kind in kinds {
        assert!(winners.contains_key(kind));
    }
    for (column, names) in winners {
        let names = names.as_array().expect("a list");
        assert!(
            !names.is_empty() && !names.contains(&"brute".into()),
            "{column}: {names:?}"
        );
    }
    let best = (1..structures.len()).max_by(|&a, &b| rate(a, 0).total_cmp(&rate(b, 0)));
    let best = &structures[best.expect("one")]["structure"];
    assert!(
        winners["primary"]
            .as_array()
            .is_some_and(|names| names.contains(best))
    );
}

#[test]
fn a_choice_of_structures_and_rays() {
    let bench = bench();
    let report = bench.json(&compare(
        "--json --accel bvh:binned,leaf=2 --accel bvh:median --accel bvh:median --rays random,primary --closest",
    ));
    let names = |list: &str, key: &str| -> Vec<String> {
        let list = report[list].as_array().expect("a list");
        list.iter()
            .map(|s| s[key].as_str().expect("a name").to_string())
            .collect()
    };
    assert_eq!(
        names("structures", "structure"),
        ["brute", "bvh:binned,leaf=2", "bvh:median"]
    );
    assert_eq!(names("workloads", "kind"), ["primary", "random"]);
    assert_eq!(names("workloads", "question"), ["closest", "closest"]);
}

#[test]
fn presets_are_weighed_with_their_rays_and_held_against_the_model() {
    let bench = bench();
    let words = compare(
        "--presets --accel bvh:binned --accel wide16 --rays primary --html out.html --json",
    );
    let report = bench.json(&words);
    let structures = report["structures"].as_array().expect("a list");
    let names: Vec<_> = structures
        .iter()
        .filter_map(|s| s["structure"].as_str())
        .collect();
    let qualities = ["fast", "high", "ultra"].map(|quality| format!("wide16:quality={quality}"));
    let mut expected = vec!["brute", "bvh:binned", "wide16"];
    expected.extend(qualities.iter().map(String::as_str));
    assert_eq!(names, expected);
    for structure in structures {
        let wide = structure["structure"]
            .as_str()
            .is_some_and(|s| s.starts_with("wide"));
        assert_eq!(structure["forecast"]["peak_bytes"].as_u64() > Some(0), wide);
    }
    let jobs = report["jobs"].as_array().expect("a list");
    assert_eq!(jobs.len(), 7);
    for row in jobs {
        let seconds = |value: &Value| value.as_f64().expect("a number");
        let chosen = &row["chosen"];
        assert!(
            chosen["structure"]
                .as_str()
                .is_some_and(|s| s.starts_with("wide16"))
        );
        assert!(seconds(&row["seconds"]) <= seconds(&chosen["seconds"]));
        assert!(seconds(&chosen["expected_seconds"]) > 0.0);
    }
    let page = String::from_utf8(bench.read("out.html")).expect("text");
    well_formed(&page);
    assert!(page.contains("Build and rays together") && page.contains("nominal time"));
    // Alone it compares the default width, and without wide trees there is nothing to expect.
    let text = bench.good(&compare("--presets --rays primary"));
    for word in ["wide8:quality=fast", "done first", "by the model"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let report = bench.json(&compare("--accel bvh:median --rays primary --json"));
    assert_eq!(report["jobs"][0]["first"], "bvh:median");
    assert_eq!(report["jobs"][0]["chosen"], Value::Null);
    bench.misused(&compare("--presets --sweep bvh"));
}

#[test]
fn tables_mark_winners() {
    let text = bench().good(&compare("--rays primary"));
    for word in [
        "structure",
        "B/tri",
        "SAH cost",
        "Mrays/s",
        "speed-up",
        "bvh:median",
        " *",
        "same bits for every ray",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert!(
        text.lines().all(|line| line.chars().count() <= 120),
        "{text}"
    );
    let judge = text.lines().filter(|line| line.starts_with("brute "));
    assert!(
        judge.clone().count() == 2 && judge.clone().all(|line| !line.contains('*')),
        "{text}"
    );
}

#[test]
fn comma_separated_values_have_a_line_for_each_structure_and_kind() {
    let bench = bench();
    bench.good(&compare(
        "--accel bvh:median,leaf=2 --rays primary,ao --csv out.csv",
    ));
    let text = String::from_utf8(bench.read("out.csv")).expect("text");
    let lines: Vec<&str> = text.split("\r\n").collect();
    assert_eq!(lines.len(), 1 + 2 * 3 + 1, "{text}");
    assert!(lines[1].starts_with("brute,,primary,"));
    assert!(lines[6].starts_with("\"bvh:median,leaf=2\",,all,"));
    let fields = lines[0].split(',').count();
    assert!(
        lines[1..4]
            .iter()
            .all(|line| line.split(',').count() == fields),
        "{text}"
    );
    // To standard output, the table goes aside.
    let said = bench.run(&compare("--rays primary --csv -"));
    assert!(said.out.starts_with("structure,") && said.err.contains("machine"));
}

/// Every tag that is opened is closed, in order.
fn well_formed(html: &str) {
    let mut open = Vec::new();
    for tag in html.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("a whole tag");
        let name = tag.split([' ', '/']).next().unwrap_or_default();
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed), "</{closed}>");
        } else if !tag.ends_with('/') && !["!DOCTYPE", "meta", "img", "input"].contains(&name) {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn the_page_needs_nothing_else_and_holds_what_was_found() {
    let bench = bench();
    bench.good(&compare("--views --html out.html"));
    let page = String::from_utf8(bench.read("out.html")).expect("text");
    well_formed(&page);
    for word in [
        "prefers-color-scheme",
        "bvh:median",
        "class=\"won\"",
        "time to build",
        "measured mean",
        "id=\"ratio\"",
        "All pairs",
        "data:image/png;base64,",
        "boxwood compare layers.obj",
        "Processor",
    ] {
        assert!(page.contains(word), "{word}");
    }
    for word in ["<script", "http:", "https:", "NaN", "Infinity", "@import"] {
        assert!(!page.contains(word), "{word}");
    }
    // Every address is a picture in the page or a place in it.
    for address in page
        .split("url(")
        .skip(1)
        .chain(page.split("src=\"").skip(1))
    {
        assert!(
            address.starts_with("data:") || address.starts_with('#'),
            "{}",
            &address[..40]
        );
    }
    // Without pictures there is none.
    bench.good(&compare("--html out.html"));
    let page = String::from_utf8(bench.read("out.html")).expect("text");
    well_formed(&page);
    assert!(!page.contains("data:image") && page.contains("class=\"won\""));
}

#[test]
fn names_from_outside_are_text() {
    let bench = Bench::new();
    let evil = "<b>'x'&\"<script>.obj";
    bench.write(evil, LAYERS);
    let words = format!("--rays primary {QUICK} --html out.html");
    let output = bench
        .command("compare")
        .arg(evil)
        .args(words.split_whitespace())
        .output()
        .expect("it runs");
    assert!(output.status.success(), "{output:?}");
    let page = String::from_utf8(bench.read("out.html")).expect("text");
    well_formed(&page);
    assert!(!page.contains("<script") && !page.contains("<b>'x'"));
    assert!(page.contains("<h1>&lt;b&gt;&#39;x&#39;&amp;&quot;&lt;script&gt;.obj</h1>"));
}

#[test]
fn a_sweep_goes_from_end_to_end() {
    let bench = bench();
    let there = bench.misused(&compare("--sweep cube"));
    assert!(there.contains("bvh"), "{there}");
    for family in ["grid", "kd", "bvh"] {
        // Only families of which there are structures can be named.
        if !there.contains(family) {
            continue;
        }
        let words = format!("--sweep {family} --rays primary --json --html out.html --csv out.csv");
        let said = bench.run(&compare(&words));
        assert_eq!((said.code, said.err.as_str()), (Some(0), ""), "{family}");
        let report: Value = serde_json::from_str(&said.out).expect("JSON");
        let sweep = &report["sweep"];
        assert_eq!(sweep["family"], family);
        let lecture = sweep["lecture"].as_f64();
        for curve in sweep["curves"].as_array().expect("a list") {
            let points = curve["points"].as_array().expect("a list");
            let values: Vec<_> = points.iter().filter_map(|p| p["value"].as_f64()).collect();
            assert!(values.is_sorted() && values.len() >= 5, "{values:?}");
            assert!(values.iter().any(|v| Some(*v) == lecture), "{values:?}");
            let rate = |p: &Value| p["measured"]["mrays_per_second"].as_f64().unwrap_or(0.0);
            let best = curve["best"].as_u64().expect("a best") as usize;
            assert!(points.iter().all(|p| rate(p) <= rate(&points[best])));
        }
        let page = String::from_utf8(bench.read("out.html")).expect("text");
        well_formed(&page);
        assert!(page.contains("lecture: ") && page.contains(": best at "));
        assert!(bench.read("out.csv").len() > 1000);
    }
    let one = bench.json(&compare(
        "--sweep bvh --accel bvh:median,axes=xy --rays primary --json",
    ));
    let curves = one["sweep"]["curves"].as_array().expect("a list");
    assert_eq!(curves.len(), 1);
    assert_eq!(curves[0]["name"], "bvh:median,axes=xy");
    let text = bench.good(&compare("--sweep bvh --rays primary"));
    assert!(
        text.contains("<- best") && text.contains("<- lecture"),
        "{text}"
    );
}

#[test]
fn a_memory_cap_leaves_some_out() {
    let bench = bench();
    let words =
        compare("--accel bvh:median --rays primary --memory 16 --html out.html --csv out.csv");
    let text = bench.good(&words);
    let reason = "bvh:median: the structure needs at least ";
    assert!(text.contains(reason), "{text}");
    let page = String::from_utf8(bench.read("out.html")).expect("text");
    well_formed(&page);
    assert!(page.contains("16 are allowed"));
    let csv = String::from_utf8(bench.read("out.csv")).expect("text");
    assert!(csv.contains("16 are allowed"));
    let report = bench.json(&compare(
        "--accel bvh:median --rays primary --memory 16 --json",
    ));
    assert_eq!(report["structures"][1]["measured"], Value::Null);
    assert_eq!(report["winners"]["primary"], Value::Array(vec![]));
}

#[test]
fn a_scene_of_nothing_is_compared_too() {
    let bench = Bench::new();
    bench.write("empty.obj", "v 0 0 0\n");
    let said = bench.run(&format!(
        "compare empty.obj {QUICK} --views --html out.html --json"
    ));
    assert_eq!(said.code, Some(0), "{}", said.err);
    let report: Value = serde_json::from_str(&said.out).expect("JSON");
    let traced = &report["structures"][0]["measured"]["rays"];
    assert!(traced[0]["mrays_per_second"].is_number());
    assert_eq!(traced[1]["mrays_per_second"], Value::Null);
    well_formed(&String::from_utf8(bench.read("out.html")).expect("text"));
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_nothing() {
    let bench = bench();
    let nowhere = bench.refused(&compare("--html no/out.html"));
    assert!(nowhere.contains("there is no folder no"), "{nowhere}");
    let itself = bench.refused(&compare("--csv layers.obj"));
    assert!(itself.contains("it is what is to be read"), "{itself}");
    let both = bench.refused(&compare("--csv - --html -"));
    assert!(both.contains("only one of"), "{both}");
    let other = bench.refused(&compare("--sweep bvh --accel brute --rays primary"));
    assert!(other.contains("brute is not of the family bvh"), "{other}");
    let absent = bench.refused("compare nothing.obj");
    assert!(absent.contains("nothing.obj"), "{absent}");
    for words in [
        "--accel quadtree",
        "--rays xray",
        "--views",
        "--memory much",
        "--sweep cube",
        "--count 0",
        "--rounds 0",
    ] {
        bench.misused(&compare(words));
    }
    assert_eq!(bench.files(), ["layers.obj"]);
}
