//! `--cache`: the second run reads what the first one built, and nothing that is wrong with the folder is an error.

use crate::bench::{Bench, said};
use crate::numpy::npy;
use npyz::Order;
use std::fs;
use std::path::PathBuf;

const SCENE: &str = "terrain:10k";

/// Rays down onto a terrain.
fn bench() -> Bench {
    let bench = Bench::new();
    let rays: Vec<f64> = (0..200)
        .flat_map(|i| {
            let (x, z) = (
                f64::from(i % 20) / 10.0 - 1.0,
                f64::from(i / 20) / 5.0 - 1.0,
            );
            [50.0 * x, 900.0, 50.0 * z, 0.01 * z, -1.0, 0.02]
        })
        .collect();
    bench.write("rays.npy", npy(6, &rays, Order::C));
    bench
}

/// The saved trees in a folder.
fn trees(bench: &Bench, folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(bench.path(folder)).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut trees: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|e| e == "bxw"))
        .collect();
    trees.sort();
    trees
}

#[test]
fn the_second_run_reads_what_the_first_one_built() {
    let bench = bench();
    let cast = |more: &str| {
        let report = bench.json(&format!(
            "cast {SCENE} --rays rays.npy -o hits.npz --json {more}"
        ));
        (report, bench.read("hits.npz"))
    };
    let (plain, expected) = cast("");
    assert!(
        plain["cache"].is_null() && plain["hits"].as_u64() > Some(0),
        "{plain}"
    );
    for (loaded, kept) in [(0, 1), (1, 0)] {
        let (report, hits) = cast("--cache=trees");
        let cache = &report["cache"];
        assert_eq!(cache["folder"], "trees");
        assert_eq!(
            (&cache["loaded"], &cache["kept"]),
            (&loaded.into(), &kept.into())
        );
        assert!(hits == expected && report["bytes"] == plain["bytes"]);
    }
    assert!(bench.path("trees/CACHEDIR.TAG").exists());
    assert_eq!(trees(&bench, "trees").len(), 1);
    // The tree is the same for whoever walks it.
    let (report, hits) = cast("--cache=trees --accel wide8:isa=portable");
    assert!(report["cache"]["loaded"] == 1 && hits == expected);
    // Others are others.
    for (i, more) in ["--accel wide16", "--accel wide8:bins=8"]
        .into_iter()
        .enumerate()
    {
        let (report, hits) = cast(&format!("--cache=trees {more}"));
        assert!(report["cache"]["kept"] == 1 && hits == expected, "{more}");
        assert_eq!(trees(&bench, "trees").len(), 2 + i);
    }
    let other = bench.json(&format!(
        "cast {SCENE},seed=2 --rays rays.npy --cache=trees --json"
    ));
    assert_eq!(other["cache"]["kept"], 1);
}

#[test]
fn every_verb_finds_the_same_tree() {
    let bench = bench();
    bench.write("points.npy", npy(3, &[1.0, 2.0, 3.0], Order::C));
    let first = bench.good(&format!(
        "query {SCENE} --points points.npy --cache=trees closest"
    ));
    assert!(
        first.contains("\nbuilt   a tree and kept it in "),
        "{first}"
    );
    let again = bench.good(&format!(
        "query {SCENE} --points points.npy --cache=trees closest"
    ));
    assert!(
        again.contains("\ntook    a tree from the cache in "),
        "{again}"
    );
    let cast = bench.good(&format!("cast {SCENE} --rays rays.npy --cache=trees"));
    assert!(
        cast.contains("\ntook    wide8 from the cache in "),
        "{cast}"
    );
    let picture = bench.good(&format!(
        "render {SCENE} --size 16x16 --spp 1 --cache=trees -o with.png"
    ));
    assert!(
        picture.contains(", took wide8 from the cache in "),
        "{picture}"
    );
    bench.good(&format!(
        "render {SCENE} --size 16x16 --spp 1 -o without.png"
    ));
    assert!(bench.read("with.png") == bench.read("without.png"));
    let ray = "--ray 0,900,0,0,-1,0 --accel wide8 --json";
    let explained = bench.good(&format!("explain {SCENE} {ray} --cache=trees"));
    assert_eq!(explained, bench.good(&format!("explain {SCENE} {ray}")));
    assert_eq!(trees(&bench, "trees").len(), 1);
}

#[test]
fn damaged_trees_are_built_anew() {
    let bench = bench();
    let words = format!("cast {SCENE} --rays rays.npy -o hits.npz --cache=trees");
    bench.good(&words);
    let expected = bench.read("hits.npz");
    let tree = trees(&bench, "trees").remove(0);
    let whole = fs::read(&tree).expect("a tree");
    let mut changed = whole.clone();
    changed[5000] ^= 1;
    let damages: [(&[u8], &str); 4] = [
        (&changed, "the saved tree is damaged: its checksum is wrong"),
        (&whole[..9000], "the saved tree should have "),
        (&[], "this is no saved tree"),
        (
            b"nothing of the kind, but longer than a header. "
                .repeat(4)
                .leak(),
            "this is no saved tree",
        ),
    ];
    for (bytes, why) in damages {
        fs::write(&tree, bytes).expect("a file");
        let said = bench.run(&words);
        assert_eq!(said.code, Some(0));
        assert!(said.err.starts_with("note: trees"), "{}", said.err);
        assert!(
            said.err.contains(why) && said.err.ends_with("; built anew\n"),
            "{}",
            said.err
        );
        assert!(
            said.out.contains("built   wide8 and kept it"),
            "{}",
            said.out
        );
        assert!(bench.read("hits.npz") == expected && fs::read(&tree).expect("a tree") == whole);
    }
}

#[test]
fn the_folder_is_the_users_unless_named() {
    let bench = bench();
    let words = format!("cast {SCENE} --rays rays.npy --cache");
    let mut command = bench.command(&words);
    command.env("XDG_CACHE_HOME", bench.path("caches"));
    assert_eq!(said(command.output().expect("it runs")).code, Some(0));
    assert_eq!(trees(&bench, "caches/boxwood").len(), 1);
    if cfg!(target_os = "linux") {
        let mut command = bench.command(&words);
        command
            .env_remove("XDG_CACHE_HOME")
            .env("HOME", bench.path("home"));
        assert_eq!(said(command.output().expect("it runs")).code, Some(0));
        assert_eq!(trees(&bench, "home/.cache/boxwood").len(), 1);
        let mut command = bench.command(&words);
        command.env_remove("XDG_CACHE_HOME").env_remove("HOME");
        let said = said(command.output().expect("it runs"));
        let expected = "error: the user has no folder for caches; name one with --cache=DIR\n";
        assert_eq!((said.code, said.err.as_str()), (Some(1), expected));
    }
}

#[test]
fn what_cannot_be_kept_is_said_and_built() {
    let bench = bench();
    bench.write("a-file", "");
    let said = bench.run(&format!("cast {SCENE} --rays rays.npy --cache=a-file"));
    assert!(
        said.err.starts_with("note: the tree is not kept: "),
        "{}",
        said.err
    );
    assert!(said.code == Some(0) && said.err.lines().count() == 1);
    assert!(said.out.contains("built   wide8 in "), "{}", said.out);
    let said = bench.run(&format!(
        "cast {SCENE} --rays rays.npy --accel bvh:median --cache=trees"
    ));
    let expected = "note: only wide8 and wide16 are kept in the cache; bvh:median is built\n";
    assert_eq!((said.code, said.err.as_str()), (Some(0), expected));
}

#[test]
fn runs_at_the_same_time_do_not_disturb_each_other() {
    let bench = bench();
    for round in 0..3 {
        let runs: Vec<_> = (0..4)
            .map(|i| {
                let words =
                    format!("cast {SCENE} --rays rays.npy --cache=trees -o {i}.npz --threads 1");
                let mut command = bench.command(&words);
                command.stdout(std::process::Stdio::piped());
                command
                    .stderr(std::process::Stdio::piped())
                    .spawn()
                    .expect("it starts")
            })
            .collect();
        for run in runs {
            let said = said(run.wait_with_output().expect("it ends"));
            assert_eq!((said.code, said.err.as_str()), (Some(0), ""));
        }
        assert!((1..4).all(|i| bench.read(&format!("{i}.npz")) == bench.read("0.npz")));
        let left = fs::read_dir(bench.path("trees")).expect("a folder").count();
        assert_eq!(left, 2, "the tag and the tree");
        if round == 1 {
            fs::write(trees(&bench, "trees").remove(0), "damaged").expect("a file");
            bench.run(&format!("cast {SCENE} --rays rays.npy --cache=trees"));
        }
    }
}
