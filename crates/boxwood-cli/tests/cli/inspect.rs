//! `boxwood inspect`.

use crate::bench::{Bench, LAYERS, is_svg};
use boxwood_scene::Scene;
use serde_json::Value;

#[test]
fn json_counts_every_leaf() {
    let bench = Bench::new();
    let report = bench.json("inspect soup:300 --accel bvh:binned,leaf=2 --accel bvh:median --json");
    assert_eq!(report["triangles"], 300);
    let structures = report["structures"].as_array().expect("a list");
    assert_eq!(structures.len(), 2);
    assert_eq!(structures[0]["structure"], "bvh:binned,leaf=2");
    for s in structures {
        let pairs = |name: &str| -> Vec<[u64; 2]> {
            serde_json::from_value(s[name].clone()).expect("pairs")
        };
        let (depths, sizes) = (pairs("leaf_depths"), pairs("leaf_sizes"));
        let number = |name: &str| s[name].as_u64().expect("a number");
        let leaves = number("leaves");
        assert_eq!(depths.iter().map(|pair| pair[1]).sum::<u64>(), leaves);
        assert_eq!(sizes.iter().map(|pair| pair[1]).sum::<u64>(), leaves);
        assert_eq!(depths.last().expect("leaves")[0], number("depth"));
        assert_eq!(sizes.last().expect("leaves")[0], number("largest_leaf"));
        let named: u64 = sizes.iter().map(|[size, times]| size * times).sum();
        assert_eq!(named, number("references"));
        assert_eq!(number("nodes") + 1, leaves);
        assert!(s["sah_cost"].as_f64() > Some(1.0));
        assert!(s["bytes_per_primitive"].as_f64() > Some(4.0));
    }
}

#[test]
fn people_get_a_table_with_bars() {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    let table = bench.good("inspect layers.obj");
    for line in [
        "scene         layers.obj: 3 triangles\n",
        "structure     bvh:binned\n",
        "references    3 (1.00 per primitive)\n",
        "leaves by depth\n",
        "leaves by size\n",
        "# ",
    ] {
        assert!(table.contains(line), "{table}");
    }
    let table = bench.good("inspect layers.obj --accel brute");
    assert!(table.contains("no nodes or cells to show"), "{table}");
}

#[test]
fn drawings_hold_the_boxes_they_promise() {
    let bench = Bench::new();
    let boxes = |words: &str| {
        bench.good(&format!("inspect soup:200 --svg a.svg {words}"));
        let text = String::from_utf8(bench.read("a.svg")).expect("text");
        assert!(is_svg(&text), "{words}");
        text.matches("<title>").count()
    };
    let report = bench.json("inspect soup:200 --json");
    let numbers = &report["structures"][0];
    let all =
        numbers["nodes"].as_u64().expect("nodes") + numbers["leaves"].as_u64().expect("leaves");
    assert_eq!(boxes("") as u64, all);
    assert_eq!(boxes("--axis y") as u64, all);
    assert_eq!(boxes("--levels 0"), 1);
    assert_eq!(boxes("--levels ..2"), 7);
    assert_eq!(boxes("--levels 1..2"), 6);
    let cut = boxes("--slice z=50%");
    assert!(cut > 5 && (cut as u64) < all, "{cut}");
    assert_eq!(
        boxes("--accel bvh:median --accel bvh:binned --levels ..1"),
        6
    );
    assert_eq!(boxes("--accel brute"), 0);
    let said = bench.run("inspect soup:200 --svg a.svg --slice x=7");
    assert!(
        said.code == Some(0) && said.err.contains("the plane passes the scene"),
        "{}",
        said.err
    );
}

#[test]
fn names_are_escaped() {
    let bench = Bench::new();
    bench.write("a<b>&\".obj", LAYERS);
    let mut command = bench.command("inspect --svg -");
    command.arg("a<b>&\".obj");
    let text = String::from_utf8(command.output().expect("it runs").stdout).expect("text");
    assert!(is_svg(&text), "{text}");
    assert!(text.contains("a&lt;b&gt;&amp;&quot;.obj"), "{text}");
}

#[test]
fn nothing_is_drawn_of_nothing() {
    let bench = Bench::new();
    bench.write("none.obj", "v 0 0 0\n");
    bench.good("inspect none.obj --svg a.svg --obj a.obj --glb a.glb");
    assert!(is_svg(
        &String::from_utf8(bench.read("a.svg")).expect("text")
    ));
    let scene = Scene::load(bench.path("a.glb")).expect("a whole file");
    assert_eq!(scene.meshes.len(), 0);
}

#[test]
fn obj_lines_are_the_edges_of_boxes() {
    let bench = Bench::new();
    bench.good("inspect soup:50 --accel bvh:binned,leaf=1 --obj a.obj --levels ..3");
    let text = String::from_utf8(bench.read("a.obj")).expect("text");
    let rows = |letter: &str| -> Vec<Vec<f32>> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(letter));
        let numbers = |line: &str| {
            line.split_whitespace()
                .map(|x| x.parse().expect("a number"))
                .collect()
        };
        lines.map(numbers).collect()
    };
    let (points, edges) = (rows("v "), rows("l "));
    let boxes = points.len() / 8;
    assert!(boxes > 8 && points.len() == 8 * boxes && edges.len() == 12 * boxes);
    assert_eq!(text.matches("\no level_").count(), 4);
    for edge in edges {
        let [a, b] = [0, 1].map(|k| &points[edge[k] as usize - 1]);
        let changed = (0..3).filter(|&k| a[k] != b[k]).count();
        assert!(changed <= 1, "{a:?} to {b:?} is no edge");
    }
}

#[test]
fn glb_lines_are_whole_and_in_place() {
    let bench = Bench::new();
    bench.good("inspect soup:50 --accel bvh:binned,leaf=1 --glb a.glb --levels 2..4");
    let bytes = bench.read("a.glb");
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    assert_eq!(
        (&bytes[..4], word(4), word(8) as usize),
        (&b"glTF"[..], 2, bytes.len())
    );
    let json: Value = serde_json::from_slice(&bytes[20..20 + word(12) as usize]).expect("JSON");
    let nodes = json["nodes"].as_array().expect("nodes");
    let names: Vec<_> = nodes.iter().map(|node| node["name"].as_str()).collect();
    assert_eq!(names, [Some("level 2"), Some("level 3"), Some("level 4")]);
    for mesh in json["meshes"].as_array().expect("meshes") {
        let primitive = &mesh["primitives"][0];
        assert_eq!(primitive["mode"], 1);
        let accessor = |k: &Value| &json["accessors"][k.as_u64().expect("a number") as usize];
        let points = accessor(&primitive["attributes"]["POSITION"]);
        let indices = accessor(&primitive["indices"]);
        let count = |a: &Value| a["count"].as_u64().expect("a count");
        assert_eq!(count(points) * 3, count(indices));
        for k in 0..3 {
            assert!(points["min"][k].as_f64() < points["max"][k].as_f64());
        }
    }
    // The loader checks every offset and count, and says that lines are none of its business.
    let scene = Scene::load(bench.path("a.glb")).expect("a whole file");
    assert!(
        scene.warnings[0].contains("points and lines are left out"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn errors_are_one_sentence() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused("inspect soup:9 --accel brute --accel bvh --obj a.obj"),
        "a file of lines shows one structure, but several were named with --accel"
    );
    assert_eq!(
        bench.refused("inspect soup:9 --obj - --svg -"),
        "only one file can go to standard output"
    );
    for (words, part) in [
        ("inspect soup:9 --slice z=1", "--svg"),
        ("inspect soup:9 --svg a --slice z", "an axis and a place"),
        (
            "inspect soup:9 --svg a --slice z=1 --axis x",
            "cannot be used with",
        ),
        ("inspect soup:9 --levels 5..2", "expected levels"),
        (
            "inspect soup:9 --accel tree",
            "no structure is called `tree`",
        ),
    ] {
        let said = bench.misused(words);
        assert!(said.contains(part), "{words}: {said}");
    }
    assert_eq!(bench.files(), [""; 0]);
}
