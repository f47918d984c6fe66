//! Primitives, accessors, morph targets and skins.

use crate::files::{File, one_mesh, triangle};
use crate::{area_from_the_front, scene};

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
