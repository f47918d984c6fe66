//! Real PLY and STL files have their known counts, and the damaged ones of the collection end in a sentence.

mod scene_files;

use boxwood_scene::Scene;
use scene_files::{bounds, degenerate, folder, only_sentence, with_extension};

#[test]
fn scans_have_their_counts() {
    let Some(folder) = folder() else { return };
    for (name, triangles, without_area) in [
        ("bunny/bunny.ply", 69_451, 0),
        ("dragon/dragon_vrip.ply", 871_414, 108),
        ("dragon/dragon_vrip_res4.ply", 11_102, 0),
        ("stl/Vase.stl", 10_910, 0),
        ("stl/featuretype.STL", 3_476, 0),
        ("stl/42400-IDGH.stl", 11_036, 3),
        ("stl/Spider_ascii.stl", 1_368, 56),
    ] {
        let scene = Scene::load(folder.join(name)).unwrap();
        assert_eq!(scene.triangle_count(), triangles, "{name}");
        assert_eq!(degenerate(&scene), without_area, "{name}");
        assert_eq!(scene.warnings, [""; 0], "{name}");
    }
}

#[test]
fn meshes_of_rendered_scenes_have_their_counts() {
    let Some(folder) = folder() else { return };
    // What is taken off stands in the scene files themselves: walls and lamps of two triangles each.
    for (name, triangles, without_area) in [
        ("kitchen", 1_443_517 - 8, 219),
        ("coffee", 235_271 - 6, 224),
        ("material-testball", 80_770 - 2, 128),
    ] {
        let mut sums = (0, 0);
        for path in with_extension(&folder.join(name).join("models"), "ply") {
            let scene = Scene::load(&path).unwrap();
            assert_eq!(scene.warnings, [""; 0]);
            sums.0 += scene.triangle_count();
            sums.1 += degenerate(&scene);
        }
        assert_eq!(sums, (triangles, without_area), "{name}");
    }
}

#[test]
fn places_are_right() {
    let Some(folder) = folder() else { return };
    // As the scan's authors and the tools that came after them have always printed them.
    let bunny = [
        [-0.0946899, 0.0329874, -0.0618736],
        [0.0610091, 0.187321, 0.0587997],
    ];
    let scene = Scene::load(folder.join("bunny/bunny.ply")).unwrap();
    assert_eq!(bounds(&scene), bunny);
    let vase = Scene::load(folder.join("stl/Vase.stl")).unwrap();
    assert_eq!(vase.up, [0.0, 0.0, 1.0]);
    let box_around = [
        [-42.425_194, -42.528_49, -10.735_826],
        [42.3433, 42.240_353, 88.264_17],
    ];
    assert_eq!(bounds(&vase), box_around);
}

#[test]
fn unusual_files_load() {
    let Some(folder) = folder() else { return };
    for (name, meshes) in [
        ("ply/points_emptyface.ply", &[][..]),
        ("stl/busted.STL", &[("busted", 3_878)]),
        ("stl/multibody.stl", &[("bodyB", 12), ("bodyA", 20)]),
        ("stl/triangle_with_empty_solid.stl", &[("testTriangle", 1)]),
        ("stl/formatDetection.stl", &[("testTriangle", 1)]),
    ] {
        let scene = Scene::load(folder.join("malformed").join(name)).unwrap();
        let found: Vec<_> = scene
            .meshes
            .iter()
            .map(|m| (m.name.as_str(), m.triangles.len()))
            .collect();
        assert_eq!(found, meshes, "{name}");
    }
}

#[test]
fn damaged_files_end_in_a_sentence() {
    let Some(folder) = folder() else { return };
    for (name, expected) in [
        ("ply/empty.ply", ": the file is empty; expected `ply`"),
        (
            "ply/huge_face_count.ply",
            ", line 7: 4294967295 rows of `face` take 4294967295 bytes or more, but the file has 13 left for them",
        ),
        (
            "ply/truncated_binary.ply",
            ", byte 889602: the file ends within row 35235 of `face`; the header promises 69451 rows",
        ),
        (
            "ply/index_out_of_range.ply",
            ", line 14: face 1 names vertex 3, but there are 3 (counted from 0)",
        ),
        (
            "ply/issue623.ply",
            ", line 13: the line of vertex 0 ends before `vertex_indices`, which line 11 of the header promises",
        ),
        (
            "stl/count_too_large.stl",
            ", byte 80: the count promises 4000000000 triangles, but the file has room for 200",
        ),
        (
            "stl/truncated_ascii.stl",
            ", line 686: the file ends within a solid; expected `endloop`, found `endl`",
        ),
    ] {
        let path = folder.join("malformed").join(name);
        let found = only_sentence(Scene::load(&path));
        assert_eq!(found, format!("{}{expected}", path.display()));
    }
}
