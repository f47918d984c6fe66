//! What must be true of every picture: the same bits for any threads, nothing that is not a number, no leaks, no acne.

mod scenes;

use boxwood_render::{Film, Options, PngOptions, Renderer, Setup, View, camera};
use boxwood_scene::{Alpha, Camera, Light, LightKind, Material, Mesh, Scene};
use scenes::{add, ball, place, quad};

const UP: [f32; 3] = [0.0, 1.0, 0.0];

fn options(size: [u32; 2], spp: u32) -> Options {
    Options {
        size,
        spp,
        ..Options::default()
    }
}

fn picture(scene: &Scene, camera: &Camera, options: &Options) -> Film {
    let renderer = Renderer::new(scene, &Setup::default()).expect("a good scene");
    let film = renderer.render(camera, options, &|_, _| ());
    for pixel in film.pixels() {
        let all = pixel
            .radiance
            .iter()
            .chain(&pixel.albedo)
            .chain(&pixel.normal);
        assert!(
            all.chain([&pixel.coverage]).all(|x| x.is_finite()),
            "{pixel:?}"
        );
        assert!(pixel.radiance.iter().all(|&x| x >= 0.0), "{pixel:?}");
    }
    film
}

fn at(film: &Film, x: u32, y: u32) -> [f32; 3] {
    film.pixels()[(y * film.size()[0] + x) as usize].radiance
}

fn light(kind: LightKind) -> Light {
    Light {
        name: String::new(),
        kind,
    }
}

/// A box whose faces look outwards.
fn cuboid(lower: [f32; 3], upper: [f32; 3], material: u32) -> Mesh {
    let corner = |i: usize| {
        std::array::from_fn(|axis| {
            if i >> axis & 1 == 0 {
                lower[axis]
            } else {
                upper[axis]
            }
        })
    };
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ],
        material,
        ..Mesh::default()
    }
}

#[test]
fn threads_and_structures_change_no_bit() {
    let scene = scenes::still_life();
    let camera = camera::look_at([0.6, 2.0, 5.0], [0.0, 0.7, 0.0], UP, 0.7).expect("a camera");
    let options = options([70, 50], 3);
    let mut films = Vec::new();
    for structure in ["bvh:binned", "bvh:median", "wide8", "wide16"] {
        let setup = Setup {
            structure: structure.parse().expect("a structure"),
            ..Setup::default()
        };
        let renderer = Renderer::new(&scene, &setup).expect("a good scene");
        for threads in [1, 2, 4] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a pool");
            let film = pool.install(|| renderer.render(&camera, &options, &|_, _| ()));
            films.push((film.exr().expect("an EXR"), film));
        }
    }
    assert!(
        films[1..3].iter().all(|other| *other == films[0]),
        "threads"
    );
    let light = |film: &Film| {
        film.pixels()
            .iter()
            .map(|p| (p.radiance, p.primitive))
            .collect::<Vec<_>>()
    };
    for other in &films[3..] {
        assert!(light(&other.1) == light(&films[0].1), "structures");
    }
}

#[test]
fn nothing_shows_the_sky() {
    let scene = Scene::default();
    let camera = camera::frame(&scene.bounds(), UP, 0.7, 1.0);
    for view in View::ALL {
        let mut options = options([17, 9], 2);
        options.view = view;
        let film = picture(&scene, &camera, &options);
        assert!(
            film.pixels()
                .iter()
                .all(|p| p.coverage == 0.0 && p.primitive == u32::MAX && p.depth == f32::INFINITY)
        );
        let options = PngOptions {
            view,
            transparent: true,
            ..PngOptions::default()
        };
        film.png(&options).expect("a PNG");
        film.exr().expect("an EXR");
        if view == View::Shaded {
            assert!(film.pixels().iter().all(|p| p.radiance[2] > 0.1));
        }
    }
}

/// The camera sits in a closed box, a bright lamp outside: whatever the size, no light comes through edges and corners,
/// also not by way of mirrors.
#[test]
fn closed_boxes_are_dark_at_every_scale() {
    for scale in [1.0e-3, 1.0, 1.0e3, 1.0e5_f32] {
        for (metallic, roughness) in [(0.0, 1.0), (1.0, 0.0)] {
            let mut scene = Scene::default();
            let material = Material {
                metallic,
                roughness,
                ..Material::default()
            };
            let material = add(&mut scene, material);
            place(&mut scene, cuboid([-scale; 3], [scale; 3], material));
            let far = 5.0 * scale;
            let bright = 1.0e6 * scale * scale;
            scene.lights = vec![
                light(LightKind::Point {
                    position: [far, far, far],
                    intensity: [bright; 3],
                    range: f32::INFINITY,
                }),
                light(LightKind::Point {
                    position: [-far, 0.0, far],
                    intensity: [bright; 3],
                    range: f32::INFINITY,
                }),
            ];
            let camera =
                camera::look_at([0.0; 3], [scale, 0.8 * scale, -scale], UP, 1.6).expect("a camera");
            let mut options = options([40, 40], 4);
            // Even light is not traced and would reach inside; the sky it comes from is dim beside the lamps.
            options.soft_rays = 0;
            let film = picture(&scene, &camera, &options);
            let brightest = film
                .pixels()
                .iter()
                .map(|p| p.radiance[0])
                .fold(0.0, f32::max);
            assert!(
                brightest < 0.3,
                "scale {scale}, metal {metallic}: {brightest}"
            );
            assert!(
                film.pixels().iter().all(|p| p.coverage == 1.0),
                "scale {scale}: a hole"
            );
        }
    }
}

/// A lit floor far from the origin is evenly lit: it does not shadow itself.
#[test]
fn floors_have_no_acne_at_any_scale() {
    for scale in [1.0e-3, 1.0, 1.0e5_f32] {
        for shift in [0.0, 100.0 * scale] {
            let mut scene = Scene::default();
            let material = add(
                &mut scene,
                Material {
                    specular: [0.0; 3],
                    ..Material::default()
                },
            );
            let s = 4.0 * scale;
            place(
                &mut scene,
                quad(
                    [shift - s, shift, shift + s],
                    [2.0 * s, 0.3 * s, 0.0],
                    [0.0, 0.2 * s, -2.0 * s],
                    material,
                ),
            );
            scene.lights = vec![light(LightKind::Directional {
                direction: [0.6, -0.75, -0.28],
                irradiance: [3.0; 3],
            })];
            let at = [shift, shift + 0.25 * s, shift];
            let eye = [shift, shift + 1.5 * s, shift + 0.1 * s];
            let camera = camera::look_at(eye, at, UP, 0.6).expect("a camera");
            let film = picture(&scene, &camera, &options([32, 32], 2));
            let seen: Vec<f32> = film.pixels().iter().map(|p| p.radiance[1]).collect();
            let (low, high) = seen
                .iter()
                .fold((f32::MAX, 0.0_f32), |(a, b), &x| (a.min(x), b.max(x)));
            assert!(
                low > 0.3 && high < 1.02 * low,
                "scale {scale}, shift {shift}: {low} to {high}"
            );
        }
    }
}

/// Red stands right, green stands up, blue lies behind.
#[test]
fn pictures_are_not_mirrored() {
    let mut scene = Scene::default();
    let mut unlit = |colour: [f32; 4]| {
        add(
            &mut scene,
            Material {
                base_color: colour,
                unlit: true,
                ..Material::default()
            },
        )
    };
    let (red, green, blue) = (
        unlit([1.0, 0.0, 0.0, 1.0]),
        unlit([0.0, 1.0, 0.0, 1.0]),
        unlit([0.0, 0.0, 1.0, 1.0]),
    );
    place(&mut scene, cuboid([1.0, -0.5, -0.5], [2.0, 0.5, 0.5], red));
    place(
        &mut scene,
        cuboid([-0.5, 1.0, -0.5], [0.5, 2.0, 0.5], green),
    );
    place(
        &mut scene,
        cuboid([-9.0, -9.0, -5.0], [9.0, 9.0, -4.0], blue),
    );
    let camera = camera::look_at([0.0, 0.0, 9.0], [0.0; 3], UP, 0.6).expect("a camera");
    let film = picture(&scene, &camera, &options([60, 60], 1));
    let middle = 30;
    assert_eq!(at(&film, middle + 15, middle), [1.0, 0.0, 0.0]);
    assert_eq!(at(&film, middle, middle - 15), [0.0, 1.0, 0.0]);
    assert_eq!(at(&film, middle - 15, middle), [0.0, 0.0, 1.0]);
    let png = film.png(&PngOptions::default()).expect("a PNG");
    assert!(!png.is_empty());
}

/// Through a hole a shadow falls only where the mask is solid, and light through coloured sheets is coloured.
#[test]
fn shadows_know_holes_and_colours() {
    let shadow_of = |sheet: Material, images: Vec<boxwood_scene::Image>| {
        let mut scene = Scene {
            images,
            ..Scene::default()
        };
        let floor = add(
            &mut scene,
            Material {
                specular: [0.0; 3],
                ..Material::default()
            },
        );
        let sheet = add(&mut scene, sheet);
        place(
            &mut scene,
            quad([-9.0, 0.0, 9.0], [18.0, 0.0, 0.0], [0.0, 0.0, -18.0], floor),
        );
        place(
            &mut scene,
            quad([-2.0, 3.0, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, -4.0], sheet),
        );
        scene.lights = vec![light(LightKind::Directional {
            direction: [0.0, -1.0, 0.0],
            irradiance: [3.0; 3],
        })];
        let camera = camera::look_at([0.0, 2.0, 0.01], [0.0; 3], UP, 1.2).expect("a camera");
        picture(&scene, &camera, &options([40, 40], 1))
    };
    let solid = at(&shadow_of(Material::default(), vec![]), 10, 20)[0];
    let half = scenes::image([2, 1], &[[255, 255, 255, 255], [255, 255, 255, 0]]);
    let mask = Material {
        base_color_map: Some(boxwood_scene::TextureMap {
            smooth: false,
            ..boxwood_scene::TextureMap::new(0)
        }),
        alpha: Alpha::Mask { cutoff: 0.5 },
        ..Material::default()
    };
    let masked = shadow_of(mask, vec![half]);
    let (left, right) = (at(&masked, 10, 20)[0], at(&masked, 30, 20)[0]);
    assert!(
        (left - solid).abs() < 0.15 && right > solid + 0.5,
        "{solid}: {left} {right}"
    );

    let red = Material {
        base_color: [0.9, 0.05, 0.05, 1.0],
        roughness: 0.0,
        transmission: 1.0,
        thin: true,
        ..Material::default()
    };
    let [r, g, _] = at(&shadow_of(red, vec![]), 10, 20);
    assert!(r > g + 0.5, "{r} {g}");
    let veil = Material {
        base_color: [0.5, 0.5, 0.5, 0.5],
        alpha: Alpha::Blend,
        ..Material::default()
    };
    let veiled = at(&shadow_of(veil, vec![]), 10, 20)[0];
    assert!(
        veiled > solid + 0.2 && veiled < right - 0.2,
        "{solid} {veiled} {right}"
    );
}

/// Glass without difference to air and without colour is not there.
#[test]
fn glass_like_air_is_invisible() {
    let mut scene = Scene::default();
    let air = Material {
        base_color: [1.0; 4],
        roughness: 0.0,
        ior: 1.0,
        transmission: 1.0,
        ..Material::default()
    };
    let air = add(&mut scene, air);
    place(&mut scene, ball([0.0; 3], 1.0, air));
    let camera = camera::look_at([0.0, 0.0, 5.0], [0.0; 3], UP, 0.5).expect("a camera");
    let with = picture(&scene, &camera, &options([24, 24], 1));
    let without = picture(&Scene::default(), &camera, &options([24, 24], 1));
    for (a, b) in with.pixels().iter().zip(without.pixels()) {
        for c in 0..3 {
            assert!((a.radiance[c] - b.radiance[c]).abs() < 0.02, "{a:?} {b:?}");
        }
    }
}

#[test]
fn odd_meshes_and_materials_stay_sound() {
    let mut scene = Scene::default();
    let odd = Material {
        base_color: [f32::NAN, -1.0, 1.0e30, 0.5],
        roughness: f32::NAN,
        metallic: 7.0,
        ior: 0.0,
        transmission: 0.7,
        attenuation_distance: 0.0,
        emissive: [f32::INFINITY, 0.0, 0.0],
        normal_scale: f32::NAN,
        ..Material::default()
    };
    let odd = add(&mut scene, odd);
    place(&mut scene, ball([0.0; 3], 1.0, odd));
    // Without area, without normals that are any, with a material that is not there.
    let flat = Mesh {
        positions: vec![[0.0; 3], [1.0; 3], [1.0; 3]],
        triangles: vec![[0, 1, 2], [0, 0, 0]],
        smooth: true,
        ..Mesh::default()
    };
    place(&mut scene, flat);
    let mut wild = quad([-3.0, -1.0, 3.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0], 99);
    wild.normals = vec![
        [0.0; 3],
        [f32::NAN, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [1.0, 0.0, 0.0],
    ];
    wild.uvs = vec![[f32::NAN, 0.0]; 4];
    place(&mut scene, wild);
    for eye in [[0.0, 1.0, 5.0], [0.0, 0.0, 0.0]] {
        let camera = camera::look_at(eye, [0.1, -0.1, 0.0], UP, 0.8).expect("a camera");
        picture(&scene, &camera, &options([24, 24], 2));
    }
}

#[test]
fn images_that_cannot_be_read_are_warned_of() {
    let mut scene = scenes::still_life();
    let half = scene.images[0].bytes.len() / 2;
    scene.images[0].bytes = scene.images[0].bytes[..half].into();
    let renderer = Renderer::new(&scene, &Setup::default()).expect("shown without it");
    assert_eq!(renderer.warnings().len(), 1, "{:?}", renderer.warnings());
    assert!(
        renderer.warnings()[0].starts_with("made in code"),
        "{}",
        renderer.warnings()[0]
    );
}

#[test]
fn sizes_beyond_reason_are_refused() {
    assert!(Options::default().check().is_ok());
    for size in [[0, 5], [5, 0], [40_000, 5], [32_768, 32_768]] {
        let error = options(size, 1)
            .check()
            .expect_err("no such image")
            .to_string();
        assert!(error.starts_with("an image of"), "{error}");
    }
}
