//! Waves against rays that travel alone.

#[path = "../../../tests/scenes/mod.rs"]
pub(crate) mod scenes;

use super::{Branch, Lamp, Seen, Sent, Tracer, WAVE};
use crate::camera::{Lens, look_at};
use crate::render::Setup;
use crate::sample::Samples;
use crate::world::World;
use boxwood::Vec3;
use boxwood_scene::{Alpha, LightKind, Material, Scene};
use scenes::{add, ball, place, quad};

/// Every kind of surface: glass, mirrors, cut-outs, blended layers, what glows and what is shown as it is.
pub(crate) fn everything() -> Scene {
    let mut scene = scenes::still_life();
    let mut veil = |height: f32, unlit: bool| {
        let material = Material {
            base_color: [0.9, 0.4, 0.2, 0.4],
            alpha: Alpha::Blend,
            unlit,
            ..Material::default()
        };
        let material = add(&mut scene, material);
        let sheet = quad(
            [-3.0, height, 2.5],
            [6.0, 0.0, 0.0],
            [0.0, 0.6, 0.1],
            material,
        );
        place(&mut scene, sheet);
    };
    veil(0.2, false);
    veil(0.4, true);
    veil(0.6, false);
    glow(&mut scene);
    scene
}

/// Nothing that a ray may pass.
pub(crate) fn solid() -> Scene {
    let mut scene = scenes::still_life();
    for material in &mut scene.materials {
        material.alpha = Alpha::Opaque;
        material.transmission = 0.0;
    }
    scene.lights[0].kind = LightKind::Point {
        position: [2.5, 5.0, 3.0],
        intensity: [60.0; 3],
        range: f32::INFINITY,
    };
    scene
}

/// Nothing that a ray may pass, lit by triangles.
pub(crate) fn glowing() -> Scene {
    let mut scene = solid();
    glow(&mut scene);
    scene
}

fn glow(scene: &mut Scene) {
    let material = Material {
        emissive: [6.0, 5.0, 3.0],
        ..Material::default()
    };
    let material = add(scene, material);
    place(scene, ball([-2.0, 2.5, 1.0], 0.3, material));
}

/// A wall of glass in front of the camera, so that every ray goes on in two ways.
fn glass() -> Scene {
    let mut scene = scenes::still_life();
    let glass = 2;
    place(
        &mut scene,
        quad([-9.0, -9.0, 3.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], glass),
    );
    scene
}

/// A wave from the camera, as long as any.
fn wave() -> Vec<Sent> {
    let size = [32, 32];
    let camera = look_at([0.6, 2.0, 5.0], [0.0, 0.7, 0.0], [0.0, 1.0, 0.0], 0.7);
    let lens = Lens::new(&camera.expect("a camera"), size);
    let sent = |i: u32| {
        let at = [i % size[0], i / size[0]];
        Sent {
            ray: lens.ray(at[0] as f32 + 0.5, at[1] as f32 + 0.5),
            branch: Branch::root(lens.footprint()),
            samples: Samples::new(at, i % 5),
        }
    };
    (0..WAVE as u32).map(sent).collect()
}

#[test]
fn company_changes_no_bit() {
    let wave = wave();
    for (name, scene) in [
        ("everything", everything()),
        ("solid", solid()),
        ("glowing", glowing()),
        ("glass", glass()),
    ] {
        for (structure, soft) in [("bvh:binned", 1), ("wide16", 0), ("wide8", 3)] {
            let setup = Setup {
                structure: structure.parse().expect("a structure"),
                ..Setup::default()
            };
            let world = World::new(&scene, &setup, &mut Vec::new()).expect("a good scene");
            let tracer = Tracer {
                world: &world,
                key: Some(Lamp::sun(Vec3::new(0.6, 0.8, 0.0), Vec3::splat(1.0), 0.05)),
                exposure: 1.0,
                depth: 5,
                soft,
                visible_lamps: true,
            };
            let together = tracer.trace(&wave);
            let alone = |sent: &Sent| tracer.trace(std::slice::from_ref(sent))[0];
            let alone: Vec<Seen> = wave.iter().map(alone).collect();
            assert!(together == alone, "{name}, {structure}");
            let looked = tracer.look(&wave);
            let alone = |sent: &Sent| tracer.look(std::slice::from_ref(sent))[0];
            assert!(
                looked == wave.iter().map(alone).collect::<Vec<Seen>>(),
                "{name}, {structure}"
            );
            let bright = together.iter().filter(|seen| seen.radiance.x > 0.05);
            assert!(bright.count() > 200, "{name}: nothing to compare");
        }
    }
}
