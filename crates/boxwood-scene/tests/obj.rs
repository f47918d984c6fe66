//! OBJ and MTL: real files against their counts, broken ones against their sentences.

use boxwood_scene::{Alpha, Files, Format, NoFiles, Scene, SceneError, Source};
use proptest::prelude::*;
use std::collections::HashMap;
use std::io;
use std::path::PathBuf;

fn read(text: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    read_with(text, &NoFiles)
}

fn read_with(text: impl AsRef<[u8]>, files: &dyn Files) -> Result<Scene, SceneError> {
    let name = "test.obj";
    let scene = Scene::from_bytes(Format::Obj, text.as_ref(), Source { name, files })?;
    assert_tables(&scene);
    Ok(scene)
}

fn problem(text: impl AsRef<[u8]>) -> String {
    read(text).expect_err("an error was expected").to_string()
}

/// What every loader guarantees.
fn assert_tables(scene: &Scene) {
    assert_eq!(scene.instances.len(), scene.meshes.len());
    for (i, mesh) in scene.meshes.iter().enumerate() {
        let count = mesh.positions.len();
        assert_eq!(scene.instances[i].mesh as usize, i);
        assert!(!mesh.triangles.is_empty());
        assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
        assert!(
            mesh.triangles
                .as_flattened()
                .iter()
                .all(|&v| (v as usize) < count)
        );
        assert!((mesh.material as usize) < scene.materials.len());
        for length in [mesh.normals.len(), mesh.uvs.len(), mesh.colors.len()] {
            assert!(length == 0 || length == count);
        }
        for n in &mesh.normals {
            let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            assert!((square - 1.0).abs() < 1e-5, "{n:?}");
        }
    }
    for material in &scene.materials {
        for map in [material.base_color_map, material.alpha_map]
            .into_iter()
            .flatten()
        {
            assert!((map.image as usize) < scene.images.len());
        }
    }
}

/// Files in memory.
struct Memory(HashMap<&'static str, &'static str>);

impl Files for Memory {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let text = self.0.get(name).ok_or(io::ErrorKind::NotFound)?;
        Ok(text.as_bytes().to_vec())
    }
}

fn areas(scene: &Scene) -> Vec<f64> {
    (scene.meshes.iter())
        .flat_map(|mesh| {
            mesh.triangles
                .iter()
                .map(|t| t.map(|v| mesh.positions[v as usize]))
        })
        .map(|triangle| {
            let [a, b, c] = triangle.map(|p| p.map(f64::from));
            let e = |k: usize| (b[k] - a[k], c[k] - a[k]);
            let n = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| e(i).0 * e(j).1 - e(j).0 * e(i).1);
            (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt() / 2.0
        })
        .collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn every_form_of_index_names_the_same_corner() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0\nvt 1 0\nvt 0 1\nvn 0 0 2\n";
    for (face, has_uvs, has_normals) in [
        ("f 1 2 3", false, false),
        ("f -3 -2 -1", false, false),
        ("f 1/1 2/2 3/3", true, false),
        ("f 1//1 2//1 3//-1", false, true),
        ("f 1/1/1 -2/-2/-1 +3/3/1", true, true),
        ("f 1// 2/ 3", false, false),
        ("fo 1 2 3 # old", false, false),
        ("f 1 \\\n 2\\\r\n\t3", false, false),
    ] {
        let scene = read(format!("{text}{face}")).unwrap();
        let mesh = &scene.meshes[0];
        assert_eq!(
            mesh.positions,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            "{face}"
        );
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(!mesh.uvs.is_empty(), has_uvs, "{face}");
        assert_eq!(!mesh.normals.is_empty(), has_normals, "{face}");
        if has_uvs {
            // `v` points down.
            assert_eq!(mesh.uvs, [[0.25, 1.0], [1.0, 1.0], [0.0, 0.0]]);
        }
        if has_normals {
            assert_eq!(mesh.normals[0], [0.0, 0.0, 1.0]);
        }
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}

#[test]
fn a_mesh_begins_where_object_group_or_material_change_between_faces() {
    let scene = read(format!(
        "{SQUARE}f 1 2 3\no a\nf 1 2 3\no a\nf 1 3 4\ng x\ng b\nf 1 2 3\nusemtl m\nf 1 2 3\nusemtl m\nf 1 3 4\n\
         usemtl n\nusemtl m\nf 1 2 3\ng b c\nusemtl\nf 1 2 4\no unused"
    ))
    .unwrap();
    let names: Vec<_> = (scene.meshes.iter())
        .map(|m| (m.name.as_str(), m.triangles.len()))
        .collect();
    assert_eq!(names, [("", 1), ("a", 2), ("a", 1), ("a", 3), ("a", 1)]);
    let materials: Vec<_> = scene.meshes.iter().map(|m| m.material).collect();
    assert_eq!(materials, [0, 0, 0, 1, 0]);
    assert_eq!(scene.materials[1].name, "m");
    // `n` has no faces, so nobody misses it.
    let sentence =
        "test.obj, line 13: no material library has the material \"m\"; a grey one takes its place";
    assert_eq!(scene.warnings, [sentence]);
}

#[test]
fn smoothing_is_on_unless_every_face_of_a_mesh_says_off() {
    let scene = read(format!(
        "{SQUARE}f 1 2 3\no a\ns off\nf 1 2 3\no b\ns 0\nf 1 2 3\ns 1\nf 1 3 4\no c\nf 1 2 3"
    ))
    .unwrap();
    let smooth: Vec<bool> = scene.meshes.iter().map(|m| m.smooth).collect();
    assert_eq!(smooth, [true, false, true, true]);
}

#[test]
fn colours_are_linear_and_weights_are_not_colours() {
    let scene =
        read("v 0 0 0 0.5\nv 1 0 0 1 0.5 0\nv 0 1 0\nv 9 9 9 nan 0 0\nf 1 2 3\nf 2 3 4").unwrap();
    let colors = &scene.meshes[0].colors;
    assert_eq!(
        (colors[0], colors[2], colors[3]),
        ([1.0; 4], [1.0; 4], [1.0; 4])
    );
    assert_eq!((colors[1][0], colors[1][2]), (1.0, 0.0));
    assert!((colors[1][1] - 0.214_041).abs() < 1e-5);
    assert!(scene.warnings[0].starts_with("test.obj, line 4: a vertex colour that is not finite"));
    assert!(
        read(format!("{SQUARE}f 1 2 3")).unwrap().meshes[0]
            .colors
            .is_empty()
    );
}

#[test]
fn errors_name_line_and_expectation() {
    let dent = |line: &str| problem(format!("{SQUARE}{line}\nf 1 2 3\n"));
    for (line, sentence) in [
        ("f 1 2 5", "a face names vertex 5, but 1 to 4 were expected"),
        ("f 1 2 0", "a face names vertex 0, but 1 to 4 were expected"),
        (
            "f 1 2 -5",
            "a face names vertex -5, but -4 to -1 were expected",
        ),
        (
            "f 1 2 99999999999999999999999",
            "a face names vertex 9223372036854775807, but 1 to 4 were expected",
        ),
        (
            "f 1 2 x",
            "a face corner has \"x\", but v, v/vt, v//vn or v/vt/vn with whole numbers was expected",
        ),
        (
            "f 1 2 3.5",
            "a face corner has \".5\", but v, v/vt, v//vn or v/vt/vn with whole numbers was expected",
        ),
        (
            "v 1 2",
            "the line ends after 2 numbers, but 3 coordinates were expected",
        ),
        (
            "v 1 2,5 3",
            "\"2,5\" is not a number, but 3 coordinates were expected",
        ),
        (
            "v 1 2 3.1+e2",
            "\"3.1+e2\" is not a number, but 3 coordinates were expected",
        ),
        (
            "v 1 2 1e400",
            "coordinate z is not a finite number that fits in 32 bits",
        ),
        (
            "v nan 2 3",
            "coordinate x is not a finite number that fits in 32 bits",
        ),
        (
            "v 1 2 3 red",
            "\"red\" is not a number, but a weight or a colour were expected",
        ),
        (
            "vt",
            "the line ends after 0 numbers, but 1 to 3 texture coordinates were expected",
        ),
        (
            "vn 0 1",
            "the line ends after 2 numbers, but 3 components of a normal were expected",
        ),
    ] {
        assert_eq!(dent(line), format!("test.obj, line 5: {sentence}"));
    }
    assert_eq!(
        problem(""),
        "test.obj: is empty, but OBJ statements such as \"v 0 0 0\" were expected"
    );
    assert_eq!(
        problem("<html>\n</html>"),
        "test.obj, line 1: \"<html>\" is no OBJ statement, and there is none in the whole file"
    );
    assert_eq!(
        problem("v 0 0\0"),
        "test.obj, byte 5: a zero byte; OBJ files are text, this one is binary"
    );
    assert_eq!(
        problem("\u{FEFF}v\\\n 0 0"),
        "test.obj, line 2: the line ends after 2 numbers, but 3 coordinates were expected"
    );
}

#[test]
fn what_can_be_passed_over_is_told_once() {
    let scene = read(format!(
        "{SQUARE}p 1\nl 1 2\nf 1\nf 1 2\nvn 0 0 0\nvt nan\nf 1/1/1 2/1/1 3/1/1\nf 1/2/3 2/2 3//-9\ncurv 0 1 2\nblah"
    ))
    .unwrap();
    assert_eq!(
        scene.warnings,
        [
            "test.obj, line 7: a face with 1 corner, but 3 or more were expected; passed over (and 1 more like this)",
            "test.obj, line 9: a normal without direction; that of the faces takes its place",
            "test.obj, line 10: a texture coordinate that is not finite; 0 takes its place",
            "test.obj, line 12: a face names texture coordinate 2, but 1 to 1 were expected; the corner goes without (and 1 more like this)",
            "test.obj, line 12: a face names normal 3, but 1 to 1 were expected; the corner goes without (and 1 more like this)",
            "test.obj, line 13: \"curv\" statements are not supported; passed over",
            "test.obj, line 14: \"blah\" is no OBJ statement; passed over",
        ]
    );
    assert_eq!(scene.triangle_count(), 2);
    assert!(scene.meshes[0].normals.is_empty());
}

#[test]
fn libraries_are_found_and_their_flaws_told() {
    let files = Memory(HashMap::from([
        (
            "my lib.mtl",
            "Kd 1 0 0\nnewmtl red\nKd 1 0 0\nKs one\nmap_Kd .\\gone.png\nnewmtl red\nd .5",
        ),
        ("sub/b.mtl", "newmtl glass\nillum 4\nmap_Kd text.png\n"),
        ("sub/text.png", "this is no image"),
    ]));
    let scene = read_with(
        format!("{SQUARE}mtllib my lib.mtl gone.mtl\nmtllib .\\sub\\b.mtl\nusemtl glass\nf 1 2 3\nusemtl red\nf 1 3 4\nusemtl blue\nf 1 3 4"),
        &files,
    )
    .unwrap();
    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["red", "red", "glass", "blue"]);
    let used: Vec<u32> = scene.meshes.iter().map(|m| m.material).collect();
    assert_eq!(used, [2, 0, 3]);
    assert_eq!(scene.materials[0].base_color, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(scene.materials[2].transmission, 1.0);
    let expected = [
        "test.obj, line 5: material library \"gone.mtl\" cannot be read (entity not found); grey materials take its place",
        "my lib.mtl, line 1: \"Kd\" stands before any newmtl; passed over",
        "my lib.mtl, line 4: \"Ks\": a finite number was expected, but \"one\" follows; the line is passed over",
        "my lib.mtl, line 5: image \"gone.png\" cannot be read (entity not found); the material goes without",
        "my lib.mtl, line 6: material \"red\" is defined again; the first one counts",
        "sub/b.mtl, line 3: image \"sub/text.png\" cannot be used",
    ];
    assert_eq!(
        scene.warnings.len(),
        expected.len(),
        "{:#?}",
        scene.warnings
    );
    for (warning, expected) in scene.warnings.iter().zip(expected) {
        assert!(warning.starts_with(expected), "{warning}");
    }
}

#[test]
fn one_face_may_have_any_number_of_corners() {
    let text = format!("{SQUARE}f {}", "1 2 3 4 ".repeat(50_000));
    assert_eq!(read(text).unwrap().triangle_count(), 199_998);
}

#[test]
fn names_and_libraries_named_over_and_over_cost_no_more_than_their_bytes() {
    let long = "x".repeat(1 << 20);
    let mut text = format!("{SQUARE}o {long}\n");
    for _ in 0..10_000 {
        text += "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nmtllib gone.mtl\n";
    }
    let scene = read(text).unwrap();
    assert_eq!(scene.meshes.len(), 20_000);
    assert_eq!(scene.materials.len(), 2);
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.meshes.iter().all(|mesh| mesh.name.len() <= 200));
}

/// The scenes folder, or `None` with a word about it.
fn scenes() -> Option<PathBuf> {
    let folder = std::env::var_os("BOXWOOD_SCENES").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: BOXWOOD_SCENES names no folder with scenes");
    }
    folder
}

#[test]
fn real_files_have_their_counts() {
    let Some(folder) = scenes() else { return };
    // Triangles, those without area, meshes, materials, warnings.
    for (file, triangles, degenerate, meshes, materials, warnings) in [
        ("teapot/teapot.obj", 6_320, 0, 1, 1, 0),
        ("bunny/stanford-bunny.obj", 69_451, 0, 1, 1, 0),
        ("sponza/sponza.obj", 262_205, 1, 381, 25, 0),
        ("obj-mixed/quadknot.obj", 2_880, 0, 1, 1, 1),
        ("obj-mixed/rabbit.obj", 1_252, 0, 9, 1, 0),
        ("obj-mixed/wallhole.obj", 66, 7, 1, 1, 1),
        ("obj-mixed/concave_polygon.obj", 64, 0, 1, 1, 0),
        ("obj-mixed/negative_indices.obj", 12, 0, 1, 1, 0),
        ("obj-mixed/spider.obj", 1_368, 56, 19, 5, 1),
        ("obj-mixed/testmixed.obj", 12, 0, 1, 1, 1),
    ] {
        let scene = Scene::load(folder.join(file)).unwrap();
        assert_tables(&scene);
        let zero = areas(&scene).iter().filter(|&&area| area == 0.0).count();
        assert_eq!(scene.triangle_count(), triangles, "{file}");
        assert_eq!(zero, degenerate, "{file}: without area");
        assert_eq!(scene.meshes.len(), meshes, "{file}: meshes");
        assert_eq!(scene.materials.len(), materials, "{file}: materials");
        assert_eq!(
            scene.warnings.len(),
            warnings,
            "{file}: {:?}",
            scene.warnings
        );
    }
}

#[test]
fn real_polygons_have_their_areas() {
    let Some(folder) = scenes() else { return };
    let area = |file: &str| {
        areas(&Scene::load(folder.join(file)).unwrap())
            .iter()
            .sum::<f64>()
    };
    assert!((area("obj-mixed/concave_polygon.obj") - 0.2455).abs() < 5e-5);
    assert!((area("obj-mixed/negative_indices.obj") - 24.0).abs() < 1e-9);
}

#[test]
fn real_materials_have_their_images() {
    let Some(folder) = scenes() else { return };
    let scene = Scene::load(folder.join("sponza/sponza.obj")).unwrap();
    let leaf = scene.materials.iter().find(|m| m.name == "leaf").unwrap();
    assert_eq!(leaf.alpha, Alpha::Mask { cutoff: 0.5 });
    let mask = &scene.images[leaf.alpha_map.unwrap().image as usize];
    assert_eq!(mask.name, "textures/sponza_thorn_mask.png");
    assert_eq!(scene.images.len(), 27);
    let spider = Scene::load(folder.join("obj-mixed/spider.obj")).unwrap();
    let skin = spider.materials.iter().find(|m| m.name == "Skin").unwrap();
    let image = &spider.images[skin.base_color_map.unwrap().image as usize];
    assert_eq!(image.name, "wal67ar_small.jpg");
}

#[test]
fn broken_files_say_what_is_wrong_and_where() {
    let Some(folder) = scenes() else { return };
    for (file, sentence) in [
        ("empty", ": is empty"),
        (
            "malformed",
            ", line 23: a face names vertex 12, but 1 to 8 were expected",
        ),
        (
            "zero_and_out_of_range_indices",
            ", line 4: a face names vertex 0, but 1 to 3 were expected",
        ),
        (
            "nan_inf_coordinates",
            ", line 1: coordinate x is not a finite number that fits in 32 bits",
        ),
        (
            "number_formats",
            ", line 11: \"3.1+e2\" is not a number, but 3 coordinates were expected",
        ),
        (
            "box_UTF16BE",
            ": text in UTF-16 (UTF-8 or ASCII was expected) is not supported",
        ),
    ] {
        let error = Scene::load(folder.join(format!("malformed/obj/{file}.obj"))).unwrap_err();
        let error = error.to_string();
        println!("{error}");
        assert!(error.contains(&format!("{file}.obj{sentence}")), "{error}");
    }
    let scene = Scene::load(folder.join("malformed/obj/notenoughindices.obj")).unwrap();
    println!("{}", scene.warnings.join("\n"));
    assert_eq!((scene.triangle_count(), scene.warnings.len()), (1, 2));
    assert!(scene.warnings[0].contains("line 9: a face with 2 corners"));
    assert!(scene.warnings[1].contains("line 1: material library \"surface.mtl\" cannot be read"));
}

#[test]
fn unusual_files_load() {
    let Some(folder) = scenes() else { return };
    for (file, triangles) in [
        ("nancolor", 12),
        ("box_longline", 944),
        ("box_without_lineending", 12),
        ("multiple_spaces", 1),
        ("point_cloud", 0),
        ("testline", 0),
    ] {
        let scene = Scene::load(folder.join(format!("malformed/obj/{file}.obj"))).unwrap();
        assert_tables(&scene);
        assert_eq!(scene.triangle_count(), triangles, "{file}");
        println!("{}", scene.warnings.join("\n"));
    }
}

/// A line that is nearly OBJ.
fn obj_line() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        (-9_i32..10).prop_map(|n| n.to_string()),
        any::<f32>().prop_map(|x| format!("{x:e}")),
        "[-+.0-9e]{0,6}",
    ];
    let corner = prop_oneof!["-?[0-9]{1,2}(/-?[0-9]?){0,2}", "[-/0-9\\\\]{0,5}"];
    prop_oneof![
        prop::collection::vec(number.clone(), 3..7).prop_map(|n| format!("v {}", n.join(" "))),
        (-9_i32..10, -9_i32..10, -9_i32..10).prop_map(|(x, y, z)| format!("v {x} {y} {z}")),
        prop::collection::vec(number, 0..4).prop_map(|n| format!("vt {}", n.join("\t"))),
        "vn -?[0-9] -?[0-9] -?[0-9]",
        prop::collection::vec(corner, 0..12).prop_map(|c| format!("f {}", c.join(" "))),
        prop::collection::vec(1..9, 3..9).prop_map(|c| format!(
            "f {}",
            c.iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(" ")
        )),
        "(o|g|usemtl|mtllib|s|p|l|#) ?[ab.]{0,3}",
        "[ -~]{0,12}",
    ]
}

proptest! {
    #[test]
    fn nearly_obj_never_panics(lines in prop::collection::vec(obj_line(), 0..40), end in prop_oneof![Just("\n"), Just("\r\n"), Just("\r"), Just("\\\n")]) {
        let _ = read(lines.join(end));
    }

    #[test]
    fn bytes_never_panic(bytes: Vec<u8>) {
        let _ = read(&bytes);
    }

    #[test]
    fn nearly_mtl_never_panics(lines in prop::collection::vec("(newmtl|K[dse]|N[si]|d|Tr|Tf|illum|map_[KBd]d?|norm|P[rm]) ?(-[sobm]{1,2} )?[-+.0-9a-e ]{0,9}", 0..30)) {
        struct One(String);
        impl Files for One {
            fn read(&self, _: &str) -> io::Result<Vec<u8>> {
                Ok(self.0.clone().into_bytes())
            }
        }
        let scene = read_with(format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3"), &One(lines.join("\n"))).unwrap();
        for material in &scene.materials {
            prop_assert!(material.base_color.iter().all(|c| (0.0..=1.0).contains(c)));
            prop_assert!((0.0..=1.0).contains(&material.roughness));
        }
    }
}
