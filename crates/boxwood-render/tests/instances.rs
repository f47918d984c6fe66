//! Scenes with repeated meshes look the same as instances and laid out, and take the memory of their meshes.

mod scenes;

use boxwood::{Affine, Ray, StructureKind};
use boxwood_render::{Film, Layout, Options, Renderer, Setup, View, camera};
use boxwood_scene::{Camera, Group, Instance, Material, PlacedGroup, Scene, builtin};
use scenes::{add, quad};

/// All things twice more: moved, turned over in a mirror, and in a group.
fn repeated() -> Scene {
    let mut scene = scenes::still_life();
    let glowing = add(
        &mut scene,
        Material {
            emissive: [3.0, 2.0, 1.0],
            ..Material::default()
        },
    );
    scene.meshes.push(quad(
        [-0.3, 1.9, 0.0],
        [0.6, 0.0, 0.0],
        [0.0, 0.0, 0.6],
        glowing,
    ));
    let copies = 1..scene.meshes.len() as u32;
    let mirrored = Affine::scale([-0.7, 0.7, 0.7]).then(&Affine::translation([0.3, 0.02, -1.2]));
    let smaller = Affine::scale([0.4, 0.6, 0.4]).then(&Affine::translation([-0.4, 0.03, 2.2]));
    for mesh in copies.clone() {
        scene.instances.push(Instance {
            mesh,
            transform: mirrored,
        });
    }
    scene.groups = vec![Group {
        instances: copies
            .map(|mesh| Instance {
                mesh,
                transform: smaller,
            })
            .collect(),
        groups: Vec::new(),
    }];
    scene.placed_groups = [0.0, 1.4]
        .map(|x| PlacedGroup {
            group: 0,
            transform: Affine::translation([x, 0.0, 0.0]),
        })
        .to_vec();
    // As flat as paper: no ray can be taken into its space, so it is laid out.
    scene.instances.push(Instance {
        mesh: 3,
        transform: Affine::scale([1.0, 1.0, 0.0]).then(&Affine::translation([0.0, 0.0, -2.5])),
    });
    scene
}

fn film(scene: &Scene, view: View, structure: &str, flatten: bool) -> Film {
    let camera: Camera =
        camera::look_at([0.6, 2.0, 5.0], [0.0, 0.7, 0.0], [0.0, 1.0, 0.0], 0.7).expect("a camera");
    let setup = Setup {
        structure: structure.parse().expect("a structure"),
        flatten,
        ..Setup::default()
    };
    let options = Options {
        size: [96, 64],
        spp: 4,
        view,
        ..Options::default()
    };
    let renderer = Renderer::new(scene, &setup).expect("a good scene");
    assert_eq!(renderer.layout().placements() > 0, !flatten);
    renderer.render(&camera, &options, &|_, _| ())
}

/// How many pixels differ by more than rounding does.
fn different(a: &Film, b: &Film) -> usize {
    let differ = |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > 0.02);
    let pairs = a.pixels().iter().zip(b.pixels());
    pairs
        .filter(|(a, b)| {
            differ(&a.radiance, &b.radiance)
                || differ(&a.normal, &b.normal)
                || differ(&a.albedo, &b.albedo)
                || a.primitive != b.primitive
        })
        .count()
}

#[test]
fn instances_look_as_if_laid_out() {
    let scene = repeated();
    for view in [View::Normals, View::Albedo] {
        let apart = film(&scene, view, "wide8", false);
        let flat = film(&scene, view, "wide8", true);
        let found = different(&apart, &flat);
        assert!(found < 20, "{view}: {found} of {} pixels", 96 * 64);
    }
    // Shaded, the chosen emitters differ; the light of the whole does not.
    let apart = film(&scene, View::Shaded, "wide8", false);
    let flat = film(&scene, View::Shaded, "wide8", true);
    let mean = |film: &Film| {
        let sum: f32 = film.pixels().iter().map(|p| p.radiance[1]).sum();
        sum / film.pixels().len() as f32
    };
    let [apart, flat] = [mean(&apart), mean(&flat)];
    assert!(
        flat > 0.05 && (apart / flat - 1.0).abs() < 0.02,
        "{apart} {flat}"
    );
}

#[test]
fn structures_change_no_bit_of_instances() {
    let scene = repeated();
    let light = |film: &Film| {
        let pixels = film.pixels().iter();
        pixels
            .map(|p| (p.radiance, p.primitive))
            .collect::<Vec<_>>()
    };
    let films = ["bvh:binned", "wide8", "wide16", "bvh:lbvh"]
        .map(|structure| light(&film(&scene, View::Shaded, structure, false)));
    assert!(films[1..].iter().all(|other| *other == films[0]));
}

#[test]
fn twenty_million_triangles_take_little_memory() {
    let plants = builtin::by_name("plants:200k").expect("it exists");
    assert!(
        plants.triangle_count() > 20_000_000,
        "{}",
        plants.triangle_count()
    );
    let layout = Layout::new(&plants, StructureKind::default(), false).expect("a good scene");
    assert!(layout.bytes() < 200 << 20, "{}", layout.bytes());
    let from = plants.cameras[0].eye;
    let down = Ray::new(from, [0.1, -1.0, -0.4]);
    let hit = layout
        .structure()
        .closest_hit(&down)
        .expect("the ground at least");
    assert!(layout.surface(&down, &hit).normal.is_finite());
}

#[test]
fn seven_hundred_million_triangles_are_no_matter() {
    let sponge = builtin::by_name("sponge:6").expect("it exists");
    assert!(sponge.triangle_count() > 700_000_000);
    let layout = Layout::new(&sponge, StructureKind::default(), false).expect("a good scene");
    assert_eq!(layout.placements(), 1 + 20_u32.pow(4));
    assert!(layout.bytes() < 2 << 20, "{}", layout.bytes());
    let ray = Ray::new([0.05, 3.0, 0.07], [0.0, -1.0, 0.0]);
    let hits = layout.structure().all_hits(&ray);
    // The floor lies below the shaft through the middle.
    assert_eq!(hits.first().map(|hit| hit.instance), Some(0));
    // In thirds, 0.999 is all twos: no level has a hole there.
    let ray = Ray::new([0.999, 3.0, 0.999], [0.0, -1.0, 0.0]);
    let hit = layout.structure().closest_hit(&ray).expect("a corner");
    assert!((hit.t - 2.0).abs() < 1.0e-5 && hit.instance > 0, "{hit:?}");
}
