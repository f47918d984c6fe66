//! Materials, textures, images.

use crate::files::{data_uri, one_mesh, triangle};
use crate::scene;
use boxwood_scene::{Alpha, Scene, Wrap};

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
