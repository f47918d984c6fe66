//! What cannot be read: sentences, and limits of memory.

use crate::files::{one_mesh, triangle};
use crate::{error, scene};
use boxwood_scene::{Folder, Format, Scene, Source};

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
        (format!(r#"{{{asset},"nodes":[{}}}"#, "[".repeat(100_000)), "test.gltf, line 1: not JSON as expected"),
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
