//! Files of the scenes folder: counts, and the sentences in which the malformed ones end.

use crate::{area_from_the_front, check_promises};
use boxwood_scene::Scene;
use std::path::PathBuf;

/// The folder of scenes, where there is one.
fn scenes_folder() -> Option<PathBuf> {
    let folder = std::env::var_os("BOXWOOD_SCENES").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: BOXWOOD_SCENES names no folder of scenes");
    }
    folder
}

fn degenerate_triangles(scene: &Scene) -> usize {
    let count = |mesh: &boxwood_scene::Mesh| {
        let flat = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize].map(f64::from));
            let edge = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
            let (e, f) = (edge(b), edge(c));
            (0..3).all(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                e[i] * f[j] - e[j] * f[i] == 0.0
            })
        };
        mesh.triangles.iter().filter(flat).count()
    };
    let instances = scene.instances.iter();
    instances
        .map(|i| count(&scene.meshes[i.mesh as usize]))
        .sum()
}

#[test]
fn real_files_have_their_known_counts() {
    let Some(folder) = scenes_folder() else {
        return;
    };
    // File, triangles, unique triangles, degenerate, meshes, instances, materials, images.
    let table = [
        ("balloon/scene.gltf", [35_698, 35_698, 0, 37, 37, 37, 17]),
        (
            "flight-helmet/FlightHelmet.gltf",
            [94_722, 94_722, 0, 6, 6, 6, 15],
        ),
        ("small-pine/scene.gltf", [1_650, 1_650, 0, 2, 2, 2, 5]),
        ("kenney/cakeBirthday.glb", [1_332, 444, 0, 14, 42, 7, 0]),
        ("kenney/alien.glb", [292, 292, 7, 18, 18, 5, 0]),
    ];
    for (name, expected) in table {
        let scene = Scene::load(folder.join(name)).unwrap();
        check_promises(&scene);
        let found = [
            scene.triangle_count() as usize,
            scene.unique_triangle_count() as usize,
            degenerate_triangles(&scene),
            scene.meshes.len(),
            scene.instances.len(),
            scene.materials.len(),
            scene.images.len(),
        ];
        assert_eq!(found, expected, "{name}");
        assert_eq!(scene.warnings, Vec::<String>::new(), "{name}");
    }
}

#[test]
fn every_primitive_mode_shows_the_same_square() {
    let Some(folder) = scenes_folder() else {
        return;
    };
    for number in 0..16 {
        let name = format!("gltf-primitive-modes/Mesh_PrimitiveMode_{number:02}.gltf");
        let scene = Scene::load(folder.join(&name)).unwrap();
        check_promises(&scene);
        let is_surface = matches!(number, 4..=6 | 11..=15);
        assert_eq!(
            scene.triangle_count(),
            if is_surface { 2 } else { 0 },
            "{name}"
        );
        assert_eq!(
            scene.warnings.is_empty(),
            is_surface,
            "{name}: {:?}",
            scene.warnings
        );
        let area: f32 = scene.meshes.iter().map(area_from_the_front).sum();
        assert_eq!(area, if is_surface { 1.0 } else { 0.0 }, "{name}");
    }
}

#[test]
fn malformed_files_end_in_a_clear_sentence() {
    let Some(folder) = scenes_folder() else {
        return;
    };
    let folder = folder.join("malformed/gltf");
    // File, and what the sentence must hold: the place, and what is wrong there.
    let table: &[(&str, &[&str])] = &[
        (
            "BoxWithInfinites.glb",
            &["accessors[", "position", "inf", "finite"],
        ),
        (
            "IndexOutOfRange/IndexOutOfRange.gltf",
            &["meshes[0].primitives[0].indices", "names vertex"],
        ),
        (
            "MissingBin/BoxTextured.gltf",
            &["buffers[0].uri", "BoxTextured0.bin", "cannot be read"],
        ),
        ("NoScene.gltf", &[", scene:", "there are none"]),
        (
            "RecursiveNodes/RecursiveNodes.gltf",
            &["nodes[1].children[0]", "own descendant"],
        ),
        (
            "SchemaFailures/sceneWrongType.gltf",
            &[", scene:", "\"hello\"", "line 6"],
        ),
        (
            "accessor_past_buffer.gltf",
            &["accessors[0].count", "1000000000", "36 bytes"],
        ),
        ("chunk_length_past_end.glb", &["byte 12", "follow"]),
        ("truncated.glb", &["byte 8", "ends after 49738"]),
        (
            "wrongTypes/badArray.gltf",
            &["meshes[0].primitives", "array", "line"],
        ),
        (
            "wrongTypes/badString.gltf",
            &["scenes[0].name", "42", "string", "line 12"],
        ),
        ("wrongTypes/badUint.gltf", &["-1", "index", "line 128"]),
    ];
    for (name, expected) in table {
        let path = folder.join(name);
        let sentence = Scene::load(&path).unwrap_err().to_string();
        println!("{}", sentence.replace(&*folder.to_string_lossy(), ""));
        assert!(sentence.starts_with(&*path.to_string_lossy()), "{sentence}");
        assert!(
            sentence.lines().count() == 1 && sentence.len() < 400,
            "{sentence}"
        );
        for part in *expected {
            assert!(
                sentence.contains(part),
                "{name}: {part} is not in: {sentence}"
            );
        }
    }
    let has_gltf = |entry: &PathBuf| entry.extension().is_some_and(|e| e == "gltf" || e == "glb");
    let entries = |folder: &PathBuf| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    };
    let top = entries(&folder);
    let below = top.iter().filter(|path| path.is_dir()).flat_map(entries);
    let files = top.iter().cloned().chain(below).filter(has_gltf).count();
    assert_eq!(files, table.len(), "a malformed file is not in the table");
}
