//! glTF: files of every kind against their known counts, features against small scenes written here, and bad files
//! against the sentences they must end in.

use boxwood_scene::{
    Alpha, Folder, Format, LightKind, NoFiles, Projection, Scene, SceneError, Source, Wrap,
};
use proptest::prelude::*;
use std::path::PathBuf;

mod gltf_files {
    //! Small files, written as JSON with their data inside.

    use std::fmt::Write as _;

    /// A file under construction: JSON without buffers, and the one buffer that goes with it.
    #[derive(Clone, Default)]
    pub struct File {
        pub data: Vec<u8>,
        views: Vec<String>,
        accessors: Vec<String>,
    }

    impl File {
        /// Adds a buffer view; returns its number.
        pub fn view(&mut self, bytes: &[u8], more: &str) -> usize {
            let offset = self.data.len();
            self.data.extend(bytes);
            self.views.push(format!(
                r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}{more}}}"#,
                bytes.len()
            ));
            self.views.len() - 1
        }

        /// Adds an accessor; returns its number.
        pub fn accessor(&mut self, json: String) -> usize {
            self.accessors.push(json);
            self.accessors.len() - 1
        }

        /// Adds an accessor of floats.
        pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
            let bytes: Vec<u8> = values
                .iter()
                .flatten()
                .flat_map(|x| x.to_le_bytes())
                .collect();
            let view = self.view(&bytes, "");
            let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"]
                .get(N)
                .unwrap_or(&"MAT4");
            self.accessor(format!(
                r#"{{"bufferView":{view},"componentType":5126,"count":{},"type":"{kind}"}}"#,
                values.len()
            ))
        }

        /// Adds an accessor of 16-bit indices.
        pub fn indices(&mut self, values: &[u16]) -> usize {
            let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
            let view = self.view(&bytes, "");
            self.accessor(format!(
                r#"{{"bufferView":{view},"componentType":5123,"count":{},"type":"SCALAR"}}"#,
                values.len()
            ))
        }

        /// The JSON, with `rest` between buffers and the end.
        pub fn json(&self, buffer: &str, rest: &str) -> String {
            format!(
                r#"{{"asset":{{"version":"2.0"}},"buffers":[{{{buffer}"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}],{rest}}}"#,
                self.data.len(),
                self.views.join(","),
                self.accessors.join(",")
            )
        }

        /// A text file with the data in a URI.
        pub fn text(&self, rest: &str) -> String {
            self.json(&format!(r#""uri":"{}","#, data_uri(&self.data)), rest)
        }

        /// A container with the data in a chunk.
        pub fn glb(&self, rest: &str) -> Vec<u8> {
            let mut json = self.json("", rest).into_bytes();
            json.resize(json.len().next_multiple_of(4), b' ');
            let mut data = self.data.clone();
            data.resize(data.len().next_multiple_of(4), 0);
            let length = 12 + 8 + json.len() + 8 + data.len();
            let mut file = b"glTF\x02\0\0\0".to_vec();
            file.extend((length as u32).to_le_bytes());
            for (kind, chunk) in [(b"JSON", json), (b"BIN\0", data)] {
                file.extend((chunk.len() as u32).to_le_bytes());
                file.extend(kind);
                file.extend(chunk);
            }
            file
        }
    }

    /// One triangle, its positions in accessor 0.
    pub fn triangle() -> File {
        let mut file = File::default();
        file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        file
    }

    /// One mesh of accessor 0 on one node; `more` is added to the JSON.
    pub fn one_mesh(more: &str) -> String {
        format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]{more}"#
        )
    }

    pub fn data_uri(bytes: &[u8]) -> String {
        const DIGITS: &[u8; 64] =
            b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let mut uri = "data:application/octet-stream;base64,".to_owned();
        for group in bytes.chunks(3) {
            let word = group.iter().enumerate();
            let word = word.fold(0_u32, |word, (i, &b)| word | u32::from(b) << (16 - 8 * i));
            for digit in 0..4 {
                if digit <= group.len() {
                    uri.push(char::from(DIGITS[(word >> (18 - 6 * digit)) as usize & 63]));
                } else {
                    uri.write_char('=').unwrap();
                }
            }
        }
        uri
    }
}

use gltf_files::{File, data_uri, one_mesh, triangle};

fn read(bytes: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    let source = Source {
        name: "test.gltf",
        files: &NoFiles,
    };
    Scene::from_bytes(Format::Gltf, bytes.as_ref(), source)
}

#[track_caller]
fn scene(bytes: impl AsRef<[u8]>) -> Scene {
    let scene = read(bytes).unwrap();
    check_promises(&scene);
    scene
}

#[track_caller]
fn error(bytes: impl AsRef<[u8]>) -> String {
    read(bytes).unwrap_err().to_string()
}

/// What [`Scene`] promises of every loader.
#[track_caller]
fn check_promises(scene: &Scene) {
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
        assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < n));
        let lengths = [
            mesh.normals.len(),
            mesh.tangents.len(),
            mesh.uvs.len(),
            mesh.uvs1.len(),
            mesh.colors.len(),
        ];
        assert!(lengths.iter().all(|&length| length == 0 || length == n));
        for [x, y, z] in &mesh.normals {
            assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5);
        }
        assert!((mesh.material as usize) < scene.materials.len());
    }
    let placed = |mesh| scene.instances.iter().any(|i| i.mesh as usize == mesh);
    assert!((0..scene.meshes.len()).all(placed));
    for material in &scene.materials {
        let maps = [
            material.base_color_map,
            material.metallic_roughness_map,
            material.normal_map,
            material.emissive_map,
            material.transmission_map,
        ];
        let images = scene.images.len();
        assert!(
            maps.iter()
                .flatten()
                .all(|map| (map.image as usize) < images)
        );
    }
}

// Real files.

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

/// The area of triangles in the plane z = 0, seen from above; what is seen from its back counts against it.
fn area_from_the_front(mesh: &boxwood_scene::Mesh) -> f32 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
    };
    mesh.triangles.iter().map(area).sum()
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

// Geometry.

#[test]
fn text_and_container_hold_the_same() {
    let file = triangle();
    let rest = one_mesh("");
    let (text, glb) = (scene(file.text(&rest)), scene(file.glb(&rest)));
    assert_eq!(text.meshes[0].positions, glb.meshes[0].positions);
    assert_eq!(text.meshes[0].triangles, [[0, 1, 2]]);
    assert!(!text.meshes[0].smooth && text.meshes[0].normals.is_empty());
    // Without a material, the specification's default one.
    assert_eq!(text.materials.len(), 1);
    assert_eq!(
        (text.materials[0].metallic, text.materials[0].roughness),
        (1.0, 1.0)
    );
    assert!(text.warnings.is_empty());
}

#[test]
fn strips_and_fans_face_the_same_way_as_triangles() {
    let mut file = File::default();
    file.floats(&[
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ]);
    let strip = file.indices(&[0, 1, 2, 3]);
    let fan = file.indices(&[0, 1, 3, 2]);
    let incomplete = file.indices(&[0, 1, 3, 0, 3, 2, 0, 60_000]);
    for (mode, indices) in [(5, strip), (6, fan), (4, incomplete)] {
        let rest = format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":{mode},"indices":{indices}}}]}}],"nodes":[{{"mesh":0}}]"#
        );
        let scene = scene(file.text(&rest));
        assert_eq!(scene.triangle_count(), 2);
        assert_eq!(area_from_the_front(&scene.meshes[0]), 1.0, "mode {mode}");
    }
}

#[test]
fn sparse_accessors_change_what_lies_below_or_zeros() {
    let mut file = triangle();
    let indices = file.view(&[1], "");
    let value: Vec<u8> = [7.0_f32, 8.0, 9.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let values = file.view(&value, "");
    let sparse = format!(
        r#""componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":1,"indices":{{"bufferView":{indices},"componentType":5121}},"values":{{"bufferView":{values}}}}}"#
    );
    let on_triangle = file.accessor(format!(r#"{{"bufferView":0,{sparse}}}"#));
    let on_zeros = file.accessor(format!("{{{sparse}}}"));
    let mesh = |n| format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{n}}}}}]}}"#);
    let rest = format!(
        r#""meshes":[{},{}],"nodes":[{{"mesh":0}},{{"mesh":1}}]"#,
        mesh(on_triangle),
        mesh(on_zeros)
    );
    let scene = scene(file.text(&rest));
    let changed = [7.0, 8.0, 9.0];
    assert_eq!(
        scene.meshes[0].positions,
        [[0.0; 3], changed, [0.0, 1.0, 0.0]]
    );
    assert_eq!(scene.meshes[1].positions, [[0.0; 3], changed, [0.0; 3]]);
}

#[test]
fn quantised_and_interleaved_attributes_become_floats() {
    let mut file = File::default();
    // Positions: 16 bits, not normalised, stride 8; normals: signed bytes; coordinates: 16 bits, normalised.
    let positions: Vec<u8> = [[0_i16, 0, 0, 99], [100, 0, 0, 99], [0, -100, 0, 99]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let view = file.view(&positions, r#","byteStride":8"#);
    file.accessor(format!(
        r#"{{"bufferView":{view},"componentType":5122,"count":3,"type":"VEC3"}}"#
    ));
    let view = file.view(
        &[0, 0, 127, 0, 0, 0, 0x81, 0, 0, 0, 0x80, 0],
        r#","byteStride":4"#,
    );
    file.accessor(format!(
        r#"{{"bufferView":{view},"componentType":5120,"normalized":true,"count":3,"type":"VEC3"}}"#
    ));
    let uvs: Vec<u8> = [0_u16, 65_535, 32_768, 0, 0, 0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let view = file.view(&uvs, "");
    file.accessor(format!(
        r#"{{"bufferView":{view},"componentType":5123,"normalized":true,"count":3,"type":"VEC2"}}"#
    ));
    let view = file.view(&[255, 0, 51, 0, 0, 0, 0, 0, 0], "");
    file.accessor(format!(
        r#"{{"bufferView":{view},"componentType":5121,"normalized":true,"count":3,"type":"VEC3"}}"#
    ));
    let rest = r#""extensionsRequired":["KHR_mesh_quantization"],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"TEXCOORD_1":2,"COLOR_0":3}}]}],"nodes":[{"mesh":0}]"#;
    let scene = scene(file.text(rest));
    let mesh = &scene.meshes[0];
    assert_eq!(
        mesh.positions,
        [[0.0; 3], [100.0, 0.0, 0.0], [0.0, -100.0, 0.0]]
    );
    assert_eq!(
        mesh.normals,
        [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, -1.0]]
    );
    assert_eq!(
        mesh.uvs,
        [[0.0, 1.0], [32_768.0 / 65_535.0, 0.0], [0.0, 0.0]]
    );
    assert_eq!(mesh.uvs1, mesh.uvs);
    assert_eq!(mesh.colors[0], [1.0, 0.0, 0.2, 1.0]);
}

#[test]
fn primitives_that_share_vertices_keep_only_their_own() {
    let mut file = File::default();
    file.floats(&[
        [0.0; 3],
        [1.0; 3],
        [2.0; 3],
        [3.0; 3],
        [f32::NAN; 3],
        [5.0; 3],
    ]);
    let indices = file.indices(&[5, 1, 3]);
    let rest = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":{indices}}}]}}],"nodes":[{{"mesh":0}}]"#
    );
    let scene = scene(file.text(&rest));
    assert_eq!(scene.meshes[0].positions, [[1.0; 3], [3.0; 3], [5.0; 3]]);
    assert_eq!(scene.meshes[0].triangles, [[2, 0, 1]]);
}

#[test]
fn morph_targets_are_blended_by_the_weights_of_the_mesh_or_the_node() {
    let mut file = triangle();
    file.floats(&[[0.0, 0.0, 4.0]; 3]);
    let rest = r#""meshes":[{"weights":[0.5],"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":1}]}]}],"nodes":[{"mesh":0,"weights":[1]},{"mesh":0}]"#;
    let scene = scene(file.text(rest));
    let heights: Vec<f32> = scene
        .instances
        .iter()
        .map(|i| scene.meshes[i.mesh as usize].positions[1][2])
        .collect();
    assert_eq!(heights, [4.0, 2.0]);
}

#[test]
fn skins_stand_as_their_joints_do() {
    let mut file = triangle();
    let joints = file.view(&[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0], "");
    file.accessor(format!(
        r#"{{"bufferView":{joints},"componentType":5121,"count":3,"type":"VEC4"}}"#
    ));
    file.floats(&[
        [0.5, 0.5, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0],
    ]);
    let mut bind = [[0.0; 16]; 2];
    for matrix in &mut bind {
        for diagonal in [0, 5, 10, 15] {
            matrix[diagonal] = 1.0;
        }
    }
    // The second joint's rest lies at y = 2.
    bind[1][13] = -2.0;
    file.floats(&bind);
    let rest = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],"skins":[{"joints":[1,2],"inverseBindMatrices":3}],"nodes":[{"mesh":0,"skin":0,"translation":[99,99,99]},{"translation":[10,0,0],"children":[2]},{"translation":[0,4,0]}]"#;
    let scene = scene(file.text(rest));
    // Joint 0 moves by (10, 0, 0), joint 1 by (10, 4, 0) after (0, -2, 0); the node itself does not count.
    let expected = [[10.0, 1.0, 0.0], [11.0, 2.0, 0.0], [10.0, 1.0, 0.0]];
    assert_eq!(scene.meshes[0].positions, expected);
    assert_eq!(scene.instances[0].transform, boxwood::Affine::IDENTITY);
    assert!(
        scene.warnings[0].contains("nodes[0].skin"),
        "{:?}",
        scene.warnings
    );
}

// Hierarchy.

#[test]
fn shared_meshes_are_instances_in_depth_first_order() {
    let file = triangle();
    let rest = r#""meshes":[{"name":"unused","primitives":[{"attributes":{"POSITION":0}}]},{"name":"two","primitives":[{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"mode":1},{"attributes":{"POSITION":0}}]},{"name":"one","primitives":[{"attributes":{"POSITION":0}}]}],
        "nodes":[{"mesh":2,"translation":[0,0,5]},{"mesh":1,"children":[3,2],"translation":[1,0,0]},{"mesh":2,"translation":[0,1,0]},{"mesh":1,"scale":[-1,1,1],"translation":[0,0,2]}],
        "scene":1,"scenes":[{"nodes":[0]},{"nodes":[1,0]}]"#;
    let scene = scene(file.text(rest));
    let names: Vec<&str> = scene.meshes.iter().map(|m| &*m.name).collect();
    assert_eq!(names, ["two.0", "two.2", "one"]);
    let found: Vec<_> = scene
        .instances
        .iter()
        .map(|i| {
            (
                i.mesh,
                i.transform.point([0.0; 3]).into(),
                i.transform.mirrors(),
            )
        })
        .collect();
    let expected: [(u32, [f32; 3], bool); 6] = [
        (0, [1.0, 0.0, 0.0], false),
        (1, [1.0, 0.0, 0.0], false),
        (0, [1.0, 0.0, 2.0], true),
        (1, [1.0, 0.0, 2.0], true),
        (2, [1.0, 1.0, 0.0], false),
        (2, [0.0, 0.0, 5.0], false),
    ];
    assert_eq!(found, expected);
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("meshes[1].primitives[1]"));
}

#[test]
fn the_first_scene_is_shown_when_none_is_named_and_all_roots_when_there_is_none() {
    let file = triangle();
    let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0},{"mesh":0},{"mesh":0}]"#;
    let first = format!(r#"{mesh},"scenes":[{{"nodes":[2]}},{{"nodes":[0,1]}}]"#);
    assert_eq!(scene(file.text(&first)).instances.len(), 1);
    let second = format!(r#"{first},"scene":1"#);
    assert_eq!(scene(file.text(&second)).instances.len(), 2);
    assert_eq!(scene(file.text(mesh)).instances.len(), 3);
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_is_no_trouble() {
    let length = 100_000;
    let link = |n: usize| format!(r#"{{"children":[{}],"translation":[0.25,0,0]}}"#, n + 1);
    let links: Vec<String> = (0..length).map(link).collect();
    let rest = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{},{{"mesh":0}}]"#,
        links.join(",")
    );
    let scene = scene(triangle().text(&rest));
    let [x, ..]: [f32; 3] = scene.instances[0].transform.point([0.0; 3]).into();
    assert_eq!(x, 25_000.0);
}

#[test]
fn nodes_on_rings_and_with_two_parents_are_refused() {
    let nodes = |nodes: &str| {
        error(format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}]}}"#
        ))
    };
    let ring = nodes(r#"{"children":[1]},{"children":[2]},{"children":[0]}"#);
    assert!(
        ring.contains("nodes[2].children[0]: node 0 is its own descendant"),
        "{ring}"
    );
    let itself = nodes(r#"{},{"children":[1]}"#);
    assert!(itself.contains("nodes[1].children[0]"), "{itself}");
    let shared = nodes(r#"{"children":[2]},{"children":[2]},{}"#);
    assert!(
        shared.contains("nodes[1].children[0]: node 2 already has a parent, nodes[0]"),
        "{shared}"
    );
    let absent = nodes(r#"{"children":[7]}"#);
    assert!(
        absent.contains("nodes[0].children[0]: names node 7, but there is only one"),
        "{absent}"
    );
}

// Cameras and lights.

#[test]
fn cameras_and_lights_stand_where_their_nodes_do() {
    // The second node looks along +x: a quarter turn about −y.
    let file = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual"],
        "cameras":[{"name":"near","type":"perspective","perspective":{"yfov":0.5,"znear":0.1}},{"type":"orthographic","orthographic":{"xmag":1,"ymag":3,"znear":0,"zfar":1}}],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0.5,0],"intensity":4,"range":9},{"name":"sun","type":"directional"},{"type":"spot","spot":{"outerConeAngle":0.5}}]}},
        "nodes":[{"camera":0,"translation":[1,2,3],"extensions":{"KHR_lights_punctual":{"light":0}}},
                 {"name":"side","camera":1,"rotation":[0,-0.7071067811865476,0,0.7071067811865476],"extensions":{"KHR_lights_punctual":{"light":1}}},
                 {"name":"spot","scale":[2,2,2],"extensions":{"KHR_lights_punctual":{"light":2}}}]}"#;
    let scene = scene(file);
    let [near, side] = &scene.cameras[..] else {
        panic!("two cameras expected")
    };
    assert_eq!(
        (&*near.name, near.eye, near.forward),
        ("near", [1.0, 2.0, 3.0], [0.0, 0.0, -1.0])
    );
    assert_eq!(near.projection, Projection::Perspective { vfov: 0.5 });
    assert_eq!((&*side.name, side.up), ("side", [0.0, 1.0, 0.0]));
    assert!((side.forward[0] - 1.0).abs() < 1e-6, "{:?}", side.forward);
    assert_eq!(side.projection, Projection::Orthographic { height: 6.0 });

    let [point, sun, spot] = &scene.lights[..] else {
        panic!("three lights expected")
    };
    let expected = LightKind::Point {
        position: [1.0, 2.0, 3.0],
        intensity: [4.0, 2.0, 0.0],
        range: 9.0,
    };
    assert_eq!(point.kind, expected);
    assert_eq!(sun.name, "sun");
    let LightKind::Directional {
        direction,
        irradiance,
    } = sun.kind
    else {
        panic!("{sun:?}")
    };
    assert!((direction[0] - 1.0).abs() < 1e-6);
    assert_eq!(irradiance, [1.0; 3]);
    let LightKind::Spot {
        inner,
        outer,
        range,
        direction,
        ..
    } = spot.kind
    else {
        panic!("{spot:?}")
    };
    assert_eq!(
        (&*spot.name, inner, outer, range),
        ("spot", 0.0, 0.5, f32::INFINITY)
    );
    assert_eq!(direction, [0.0, 0.0, -1.0]);
}

// Materials.

/// A picture of one pixel.
const PIXEL: &[u8] = b"BM\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\x18\0\0\0\0\0\x04\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xff\xff\xff\0";

fn materials(materials: &str, more: &str) -> Scene {
    let rest = format!(r#","materials":[{materials}],{more}"asset2":0"#);
    let pixel = data_uri(PIXEL);
    scene(triangle().text(&one_mesh(&rest.replace("PIXEL", &pixel))))
}

#[test]
fn materials_keep_what_the_file_says() {
    let scene = materials(
        r#"{"name":"glass","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,0.5],"metallicFactor":0,"roughnessFactor":0.125},"emissiveFactor":[1,0.5,0],"alphaMode":"MASK","alphaCutoff":0.25,"doubleSided":true,
            "extensions":{"KHR_materials_transmission":{"transmissionFactor":0.75},"KHR_materials_ior":{"ior":1.25},"KHR_materials_emissive_strength":{"emissiveStrength":4},"KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[1,0.5,0.5]},"KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[1,0.5,0]},"KHR_materials_clearcoat":{"clearcoatFactor":1}}},
           {"alphaMode":"BLEND","extensions":{"KHR_materials_unlit":{}}},
           {"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0.5,0,0,1],"glossinessFactor":0.75}}}"#,
        "",
    );
    let [glass, flat, old, default] = &scene.materials[..] else {
        panic!("{:?}", scene.materials)
    };
    assert_eq!(glass.name, "glass");
    assert_eq!(glass.base_color, [0.5, 0.25, 1.0, 0.5]);
    assert_eq!((glass.metallic, glass.roughness), (0.0, 0.125));
    assert_eq!(glass.emissive, [4.0, 2.0, 0.0]);
    assert_eq!(glass.alpha, Alpha::Mask { cutoff: 0.25 });
    assert_eq!(
        (glass.transmission, glass.ior, glass.thin),
        (0.75, 1.25, false)
    );
    assert_eq!(
        (glass.attenuation_distance, glass.attenuation_color),
        (2.0, [1.0, 0.5, 0.5])
    );
    assert_eq!(glass.specular, [0.5, 0.25, 0.0]);
    assert!(glass.double_sided && !flat.double_sided);
    assert_eq!(
        (flat.alpha, flat.unlit, flat.thin),
        (Alpha::Blend, true, true)
    );
    assert_eq!(
        (old.base_color, old.roughness, old.metallic),
        ([0.5, 0.0, 0.0, 1.0], 0.25, 0.0)
    );
    assert_eq!((default.base_color, default.metallic), ([1.0; 4], 1.0));
    assert_eq!(scene.warnings.len(), 1);
    assert!(
        scene.warnings[0].contains("specular-glossiness"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn textures_share_images_and_keep_transform_and_sampler() {
    let scene = materials(
        r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0.25],"rotation":1.5707963267948966,"scale":[2,3],"texCoord":1}}},"metallicRoughnessTexture":{"index":1,"texCoord":1}},"normalTexture":{"index":0,"scale":0.5,"extensions":{"KHR_texture_transform":{"scale":[4,4]}}}}"#,
        r#""textures":[{"source":0,"sampler":0},{"source":0},{"source":1}],"samplers":[{"magFilter":9728,"wrapS":33071,"wrapT":33648}],"images":[{"uri":"PIXEL"},{"uri":"never used"}],"#,
    );
    assert_eq!(scene.images.len(), 1);
    assert_eq!(scene.images[0].size, [1, 1]);
    let material = &scene.materials[0];
    let base = material.base_color_map.unwrap();
    assert_eq!((base.image, base.uv_set, base.smooth), (0, 1, false));
    assert_eq!(base.wrap, [Wrap::Clamp, Wrap::Mirror]);
    let expected = [[0.0, 3.0, 0.5], [-2.0, 0.0, 0.25]];
    for (found, expected) in base
        .transform
        .iter()
        .flatten()
        .zip(expected.iter().flatten())
    {
        assert!((found - expected).abs() < 1e-6, "{:?}", base.transform);
    }
    let rough = material.metallic_roughness_map.unwrap();
    assert_eq!((rough.image, rough.uv_set, rough.smooth), (0, 1, true));
    assert_eq!(rough.wrap, [Wrap::Repeat; 2]);
    let normal = material.normal_map.unwrap();
    assert_eq!((normal.transform[0][0], material.normal_scale), (4.0, 0.5));
}

#[test]
fn absent_and_broken_images_are_warnings() {
    let scene = materials(
        r#"{"normalTexture":{"index":0},"emissiveTexture":{"index":1},"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#,
        r#""textures":[{"source":0},{"source":1}],"images":[{"uri":"not%20here.png"},{"uri":"data:image/png;base64,AAAA"}],"#,
    );
    let material = &scene.materials[0];
    assert!(material.normal_map.is_none() && material.emissive_map.is_none());
    assert!(scene.images.is_empty());
    let [absent, broken] = &scene.warnings[..] else {
        panic!("{:?}", scene.warnings)
    };
    assert!(
        absent.starts_with("test.gltf, images[0].uri: not here.png cannot be read"),
        "{absent}"
    );
    assert!(broken.starts_with("test.gltf, images[1].uri:"), "{broken}");
}

#[test]
fn files_beside_the_scene_are_found_under_their_decoded_names() {
    let folder = std::env::temp_dir().join(format!("boxwood-gltf-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("my data")).unwrap();
    let file = triangle();
    std::fs::write(folder.join("my data/a b.bin"), &file.data).unwrap();
    let json = file.json(r#""uri":"my%20data/a%20b.bin","#, &one_mesh(""));
    let files = Folder(folder.clone());
    let source = Source {
        name: "test.gltf",
        files: &files,
    };
    let scene = Scene::from_bytes(Format::Gltf, json.as_bytes(), source);
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(scene.unwrap().triangle_count(), 1);
}

// Errors.

#[test]
fn required_extensions_that_are_unknown_are_named() {
    let sentence = error(
        r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_texture_transform","KHR_draco_mesh_compression"]}"#,
    );
    assert_eq!(
        sentence,
        "test.gltf, extensionsRequired[1]: the extension KHR_draco_mesh_compression is not supported"
    );
    let optional = scene(triangle().text(&one_mesh(
        r#","extensionsUsed":["KHR_materials_sheen","X_y"]"#,
    )));
    assert_eq!(
        optional.warnings,
        ["test.gltf, extensionsUsed[1]: the extension X_y is passed over"]
    );
}

#[test]
fn errors_say_where_and_what_was_expected() {
    let asset = r#""asset":{"version":"2.0"}"#;
    let cases = [
        (String::new(), "test.gltf: the file is empty"),
        ("{".to_owned(), "test.gltf, line 1: not JSON as expected"),
        ("nonsense".to_owned(), "test.gltf, line 1: not JSON as expected"),
        ("{}".to_owned(), "missing field `asset`"),
        (r#"{"asset":{"version":"1.0"},"meshes":{}}"#.to_owned(), "asset.version: glTF 1.0 is not supported"),
        (format!(r#"{{{asset},"nodes":[{{"scale":[1,2]}}]}}"#), "nodes[0].scale"),
        (format!(r#"{{{asset},"nodes":[{{"mesh":1.5}}]}}"#), "nodes[0].mesh: invalid value: floating point `1.5`, expected a whole number"),
        (format!(r#"{{{asset},"meshes":[{{}}]}}"#), "meshes[0]: missing field `primitives`"),
        (format!(r#"{{{asset},"nodes":[{{"mesh":3}}]}}"#), "nodes[0].mesh: names mesh 3, but there are none"),
        (format!(r#"{{{asset},"nodes":[{}}}"#, "[".repeat(100_000)), "recursion limit"),
        (
            format!(r#"{{{asset},"buffers":[{{"uri":"data:,abc","byteLength":4}}],"bufferViews":[{{"buffer":0,"byteLength":4}}]}}"#),
            "buffers[0].byteLength: 4 bytes were promised, but there are only 3",
        ),
        (
            triangle().text(r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],"nodes":[{"mesh":0}]"#),
            "meshes[0].primitives[0].material: names material 0, but there are none",
        ),
        (
            triangle().text(r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":0}]}],"nodes":[{"mesh":0}]"#),
            "accessors[0].type: SCALAR expected, but it is VEC3",
        ),
        (
            triangle().text(&one_mesh("").replace("}]}]", r#","mode":9}]}]"#)),
            "meshes[0].primitives[0].mode: mode 9 is not known",
        ),
        (
            triangle().text(&one_mesh("").replace("{\"mesh\":0}", r#"{"mesh":0,"scale":[1e38,1e38,1e38],"translation":[3.4e38,0,0]}"#)),
            "nodes[0]: the node takes its mesh beyond the range of numbers",
        ),
    ];
    for (file, expected) in cases {
        let sentence = error(&file);
        assert!(sentence.starts_with("test.gltf"), "{sentence}");
        assert!(
            sentence.contains(expected),
            "{expected} is not in: {sentence}"
        );
    }
}

#[test]
fn small_files_cannot_ask_for_much_memory() {
    // A billion positions of nothing.
    let zeros = r#"{"asset":{"version":"2.0"},"accessors":[{"componentType":5126,"count":1000000000,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]}"#;
    // Ten thousand meshes of ten thousand primitives each, by way of instances.
    let primitives = vec![r#"{"attributes":{"POSITION":0}}"#; 10_000].join(",");
    let nodes = vec![r#"{"mesh":0}"#; 10_000].join(",");
    let many = triangle().text(&format!(
        r#""meshes":[{{"primitives":[{primitives}]}}],"nodes":[{nodes}]"#
    ));
    for file in [zeros, &many] {
        let sentence = error(file);
        assert!(sentence.contains("more than 64 times"), "{sentence}");
    }
}

// Any bytes at all.

fn seeds() -> [Vec<u8>; 2] {
    let mut file = triangle();
    let indices = file.indices(&[0, 1, 2]);
    let value = file.view(&[0; 12], "");
    let sparse = file.accessor(format!(
        r#"{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":1,"indices":{{"bufferView":1,"componentType":5123}},"values":{{"bufferView":{value}}}}}}}"#
    ));
    let rest = format!(
        r#""meshes":[{{"weights":[1],"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":{sparse}}},"indices":{indices},"mode":5,"material":0,"targets":[{{"POSITION":{sparse}}}]}}]}}],"materials":[{{"normalTexture":{{"index":0}}}}],"textures":[{{"source":0}}],"images":[{{"bufferView":{value}}}],"cameras":[{{"type":"perspective","perspective":{{"yfov":1}}}}],"nodes":[{{"children":[1]}},{{"mesh":0,"camera":0,"scale":[1,2,3]}}],"scenes":[{{"nodes":[0]}}]"#
    );
    [file.text(&rest).into_bytes(), file.glb(&rest)]
}

#[test]
fn the_seeds_are_valid() {
    for seed in seeds() {
        assert_eq!(scene(seed).triangle_count(), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn changed_bytes_never_panic(
        which in 0..2_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        is_cut in prop::bool::weighted(0.1),
    ) {
        let mut bytes = seeds()[which].clone();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if is_cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(scene) = read(&bytes) {
            check_promises(&scene);
        }
    }

    /// Numbers are where the traps are: indices, counts, offsets.
    #[test]
    fn changed_numbers_never_panic(
        which in 0..2_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), number()), 1..4),
    ) {
        let seed = seeds()[which].clone();
        let start = if which == 1 { 20 } else { 0 };
        let end = if which == 1 { start + u32::from_le_bytes(seed[12..16].try_into().unwrap()) as usize } else { seed.len() };
        let mut json = String::from_utf8(seed[start..end].to_vec()).unwrap();
        for (place, new) in changes {
            let digits: Vec<(usize, usize)> = numbers(&json);
            let (from, to) = digits[place.index(digits.len())];
            json.replace_range(from..to, &new);
        }
        let bytes = if which == 1 {
            let mut bytes = seed[..12].to_vec();
            bytes.extend((json.len() as u32).to_le_bytes());
            bytes.extend(b"JSON");
            bytes.extend(json.as_bytes());
            bytes.resize(bytes.len().next_multiple_of(4), b' ');
            bytes.extend(&seed[end..]);
            let length = bytes.len() as u32;
            bytes[8..12].copy_from_slice(&length.to_le_bytes());
            bytes
        } else {
            json.into_bytes()
        };
        if let Ok(scene) = read(&bytes) {
            check_promises(&scene);
        }
    }
}

fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        (0..16_u32).prop_map(|n| n.to_string()),
        prop::sample::select(vec![
            "-1",
            "4294967295",
            "4294967296",
            "18446744073709551615",
            "1e308",
            "1e-300",
            "2.5",
            "null",
            "5120",
            "5121",
            "5122",
            "5123",
            "5125",
            "5126",
            "1000000000",
        ])
        .prop_map(str::to_owned),
    ]
}

/// Where the numbers of a JSON text are, those inside strings left out.
fn numbers(json: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut in_string = false;
    let mut start = None;
    for (at, c) in json.char_indices() {
        match (in_string, c) {
            (_, '"') => in_string = !in_string,
            (false, '0'..='9') => start = start.or(Some(at)),
            (false, '.' | 'e' | '-' | '+') if start.is_some() => {}
            _ => found.extend(start.take().map(|from| (from, at))),
        }
    }
    found
}
