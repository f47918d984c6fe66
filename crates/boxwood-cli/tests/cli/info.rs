//! `boxwood info`.

use crate::bench::{Bench, LAYERS, said};
use serde_json::json;
use std::io::Read;
use std::process::Stdio;

#[test]
fn json_has_all_fields() {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    let info = bench.json("info layers.obj --json");
    let mut fields: Vec<_> = info.as_object().expect("an object").keys().collect();
    fields.sort();
    assert_eq!(
        fields,
        [
            "bounds",
            "cameras",
            "degenerate",
            "file",
            "format",
            "instances",
            "lights",
            "materials",
            "memory_bytes",
            "meshes",
            "textures",
            "triangles",
            "unique_triangles",
            "warnings"
        ]
    );
    assert_eq!(info["file"], "layers.obj");
    assert_eq!(info["format"], "obj");
    assert_eq!(info["triangles"], 3);
    assert_eq!(info["unique_triangles"], 3);
    assert_eq!(info["degenerate"], 1);
    assert_eq!(info["meshes"], 1);
    assert_eq!(info["instances"], 1);
    assert_eq!(
        info["bounds"],
        json!({"min": [0.0, 0.0, -1.0], "max": [2.0, 2.0, 2.0]})
    );
    assert_eq!(info["cameras"], json!([]));
    assert_eq!(info["warnings"], json!([]));
    assert!(info["memory_bytes"].as_u64() >= Some(7 * 12 + 3 * 12));
}

#[test]
fn nothing_has_no_bounds() {
    let bench = Bench::new();
    bench.write("none.obj", "v 0 0 0\n");
    let info = bench.json("info none.obj --json");
    assert_eq!(
        (&info["triangles"], &info["bounds"]),
        (&json!(0), &json!(null))
    );
    assert!(bench.good("info none.obj").contains("bounds     empty\n"));
}

#[test]
fn people_get_a_table() {
    let bench = Bench::new();
    bench.write("layers.obj", format!("mtllib absent.mtl\n{LAYERS}"));
    let table = bench.good("info layers.obj");
    for line in [
        "file       layers.obj (obj)\n",
        "triangles  3 (1 of zero area)\n",
        "bounds     (0, 0, -1) to (2, 2, 2)\n",
        "size       2 x 2 x 3\n",
        "warnings   1\n  layers.obj",
    ] {
        assert!(table.contains(line), "{table}");
    }
}

#[test]
fn the_built_in_scene_has_a_name() {
    let info = Bench::new().json("info teapot-in-stadium --json");
    assert_eq!(info["format"], "built-in");
    assert!(info["triangles"].as_u64() > info["unique_triangles"].as_u64());
    assert!(
        info["cameras"]
            .as_array()
            .is_some_and(|names| names.contains(&json!("main")))
    );
}

#[test]
fn built_in_scenes_come_in_any_size() {
    let bench = Bench::new();
    let info = bench.json("info soup:2k,seed=3 --json");
    assert_eq!(info["triangles"], 2000);
    assert_eq!(info["degenerate"], 0);
    let names = boxwood_scene::builtin::names();
    for name in names.filter(|name| *name != "teapot-in-stadium") {
        // Levels of a sponge are fewer, and each has twenty times as much.
        let size = if name == "sponge" { 2 } else { 30 };
        let info = bench.json(&format!("info {name}:{size} --json"));
        assert!(info["triangles"].as_u64() > Some(15), "{name}: {info}");
    }
    // A file of that name comes first.
    bench.write("soup:7", "v 0 0 0\n");
    assert!(
        bench
            .refused("info soup:7")
            .contains("unknown kind of file")
    );
}

#[test]
fn errors_are_one_sentence() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused("info absent.obj"),
        "absent.obj: there is no such file"
    );
    assert_eq!(
        bench.refused("info teapot"),
        "teapot: there is no such file and no built-in scene of this name; built in: \
         teapot-in-stadium, even-spheres:N, long-thin:N, overlapping:N, plants:N, city:N, \
         terrain:N, soup:N, sponge:N"
    );
    assert_eq!(
        bench.refused("info city:0"),
        "city:0: `0` is no number of houses for `city`: expected 1 to 500000, such as 2000, 20k or 1M"
    );
    assert!(
        bench
            .refused("info soup:5,colour=red")
            .contains("no setting `colour=red`")
    );
    bench.write("scene.txt", "");
    assert_eq!(
        bench.refused("info scene.txt"),
        "scene.txt: unknown kind of file; Boxwood reads .obj, .ply, .stl, .gltf and .glb"
    );
    bench.write("bad.ply", "ply\nformat ascii 1.0\nelement vertex many\n");
    assert!(
        bench
            .refused("info bad.ply")
            .starts_with("bad.ply, line 3: ")
    );
    std::fs::create_dir(bench.path("folder.obj")).expect("a folder");
    assert!(
        bench
            .refused("info folder.obj")
            .starts_with("folder.obj: cannot be read: ")
    );
    assert!(bench.misused("info").contains("<SCENE>"));
}

/// As `boxwood info … | head -0`: the reader goes away before anything is said.
#[test]
fn a_closed_pipe_is_no_failure() {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    for words in [
        "info layers.obj",
        "info layers.obj --json",
        "man",
        "completions bash",
        "--help",
    ] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = bench.command(words);
        command.stdout(writer).stderr(Stdio::piped());
        let said = said(command.output().expect("it runs"));
        assert_eq!((said.code, said.err.as_str()), (Some(0), ""), "{words}");
    }
}

#[test]
fn there_is_no_colour_in_a_pipe() {
    let bench = Bench::new();
    let (mut reader, writer) = std::io::pipe().expect("a pipe");
    let mut child = bench.command("info absent.obj");
    child.stderr(writer);
    let status = child.status().expect("it runs");
    drop(child);
    let mut text = String::new();
    reader.read_to_string(&mut text).expect("text");
    assert_eq!(status.code(), Some(1));
    assert_eq!(text, "error: absent.obj: there is no such file\n");
}
