//! Small scenes made in code.

use boxwood::Affine;
use boxwood_scene::{Image, Instance, Light, LightKind, Material, Mesh, Scene, TextureMap};

/// Adds a mesh where it stands.
pub fn place(scene: &mut Scene, mesh: Mesh) {
    let number = scene.meshes.len() as u32;
    scene.meshes.push(mesh);
    scene.instances.push(Instance {
        mesh: number,
        transform: Affine::IDENTITY,
    });
}

/// Adds a material and says its index.
pub fn add(scene: &mut Scene, material: Material) -> u32 {
    scene.materials.push(material);
    scene.materials.len() as u32 - 1
}

/// A parallelogram that faces `u × v`, the image once over it.
pub fn quad(corner: [f32; 3], u: [f32; 3], v: [f32; 3], material: u32) -> Mesh {
    let at = |a: f32, b: f32| std::array::from_fn(|i| corner[i] + a * u[i] + b * v[i]);
    Mesh {
        positions: vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        material,
        ..Mesh::default()
    }
}

/// A ball of flat triangles with the normals of a round one.
pub fn ball(center: [f32; 3], radius: f32, material: u32) -> Mesh {
    let (rows, columns) = (12_u32, 24_u32);
    let mut mesh = Mesh {
        material,
        ..Mesh::default()
    };
    for row in 0..=rows {
        for column in 0..=columns {
            let polar = std::f32::consts::PI * row as f32 / rows as f32;
            let around = std::f32::consts::TAU * column as f32 / columns as f32;
            let sin = libm::sinf(polar);
            let n = [
                sin * libm::cosf(around),
                libm::cosf(polar),
                sin * libm::sinf(around),
            ];
            mesh.positions
                .push(std::array::from_fn(|i| center[i] + radius * n[i]));
            mesh.normals.push(n);
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let b = a + columns + 1;
            mesh.triangles.push([a, a + 1, b + 1]);
            mesh.triangles.push([a, b + 1, b]);
        }
    }
    mesh
}

/// An image of colours as a PNG, row by row from the top.
pub fn image(size: [u32; 2], pixels: &[[u8; 4]]) -> Image {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&pixels.concat()).expect("pixels");
    writer.finish().expect("an end");
    Image::from_bytes("made in code", bytes).expect("a good image")
}

/// Glass, mirror, texture, cut-out and a soft lamp.
pub fn still_life() -> Scene {
    let mut scene = Scene::default();
    let (dark, bright) = ([40, 60, 90, 255], [230, 220, 200, 255]);
    let checks: Vec<_> = (0..64)
        .map(|i| {
            if (i % 8 + i / 8) % 2 == 0 {
                dark
            } else {
                bright
            }
        })
        .collect();
    let holes: Vec<_> = (0..64)
        .map(|i| [200, 60, 40, if i % 8 % 3 == 1 { 0 } else { 255 }])
        .collect();
    scene.images = vec![image([8, 8], &checks), image([8, 8], &holes)];
    let floor = add(
        &mut scene,
        Material {
            base_color_map: Some(TextureMap::new(0)),
            roughness: 0.6,
            ..Material::default()
        },
    );
    let mirror = add(
        &mut scene,
        Material {
            base_color: [0.95, 0.9, 0.8, 1.0],
            metallic: 1.0,
            roughness: 0.0,
            ..Material::default()
        },
    );
    let glass = add(
        &mut scene,
        Material {
            base_color: [1.0; 4],
            roughness: 0.0,
            transmission: 1.0,
            attenuation_color: [0.5, 0.9, 0.7],
            attenuation_distance: 0.8,
            ..Material::default()
        },
    );
    let fence = add(
        &mut scene,
        Material {
            base_color_map: Some(TextureMap {
                smooth: false,
                ..TextureMap::new(1)
            }),
            alpha: boxwood_scene::Alpha::Mask { cutoff: 0.5 },
            ..Material::default()
        },
    );
    let plaster = add(
        &mut scene,
        Material {
            base_color: [0.3, 0.5, 0.8, 1.0],
            roughness: 0.3,
            ..Material::default()
        },
    );
    place(
        &mut scene,
        quad([-4.0, 0.0, 4.0], [8.0, 0.0, 0.0], [0.0, 0.0, -8.0], floor),
    );
    place(
        &mut scene,
        quad([-2.5, 0.0, -2.0], [3.0, 0.0, -1.0], [0.0, 2.5, 0.0], mirror),
    );
    place(&mut scene, ball([0.4, 0.7, 0.6], 0.7, glass));
    place(&mut scene, ball([-1.3, 0.5, 0.4], 0.5, plaster));
    place(
        &mut scene,
        quad([1.2, 0.0, -0.2], [1.2, 0.0, 0.6], [0.0, 1.4, 0.0], fence),
    );
    scene.lights = vec![Light {
        name: String::new(),
        kind: LightKind::Sphere {
            center: [2.5, 5.0, 3.0],
            radius: 0.6,
            radiance: [70.0, 66.0, 60.0],
        },
    }];
    scene
}
