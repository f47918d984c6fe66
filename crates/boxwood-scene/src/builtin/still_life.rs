//! What it is all about: a teapot on a tiled table on the centre spot, with glass and mirrors around it.

use super::solids::{ball, cuboid, set_down};
use super::stage::{Stage, paint};
use super::teapot::teapot;
use crate::material::Material;

/// Height of the table.
const TABLE: f32 = 0.5;
/// The tiles of the table, along x and z; they end where the frame begins.
const TILES: [i32; 2] = [14, 10];
const TILE: f32 = 0.11;

/// Sets the table.
pub(super) fn still_life(stage: &mut Stage) {
    table(stage);

    let glaze = stage.material(paint("glaze", [0.62, 0.035, 0.015], 0.06));
    let mirror = stage.material(metal("mirror", [0.95, 0.95, 0.95], 0.0));
    let brass = stage.material(metal("brass", [0.91, 0.68, 0.29], 0.12));
    let glass = stage.material(Material {
        transmission: 1.0,
        attenuation_color: [0.75, 0.95, 0.82],
        attenuation_distance: 0.3,
        ..paint("glass", [1.0, 1.0, 1.0], 0.0)
    });
    let pot = stage.mesh("teapot", teapot(16), glaze);
    stage.place(pot, set_down(22.0, 0.084, [-0.02, TABLE, 0.0]));

    let mut set = |name: &str, level: u32, material: u32, radius: f32, [x, z]: [f32; 2]| {
        let mesh = stage.mesh(name, ball(level), material);
        stage.place(mesh, set_down(0.0, radius, [x, TABLE + radius, z]));
    };
    set("mirror ball", 5, mirror, 0.15, [0.47, -0.24]);
    set("glass ball", 5, glass, 0.085, [-0.3, 0.26]);
    set("brass ball", 4, brass, 0.04, [0.19, 0.28]);

    // Half a millimetre of air keeps the faces of cube and tiles apart.
    let cube = cuboid([-0.055, 0.0, -0.055], [0.055, 0.11, 0.055]);
    let cube = stage.mesh("glass cube", cube, glass);
    stage.place(cube, set_down(35.0, 1.0, [0.56, TABLE + 0.0005, 0.2]));
}

/// A block of stone with a wooden frame, and tiles with open joints on top.
fn table(stage: &mut Stage) {
    let stone = stage.material(paint("stone", [0.35, 0.33, 0.3], 0.9));
    let wood = stage.material(paint("wood", [0.24, 0.1, 0.035], 0.5));
    let light = stage.material(paint("tile, light", [0.8, 0.77, 0.7], 0.6));
    let dark = stage.material(paint("tile, dark", [0.035, 0.04, 0.05], 0.6));

    let [x, z] = TILES.map(|count| 0.5 * count as f32 * TILE);
    let block = cuboid(
        [0.12 - x, -0.1, 0.12 - z],
        [x - 0.12, TABLE - 0.045, z - 0.12],
    );
    stage.build("plinth", block, stone);
    let slab = cuboid([-x, TABLE - 0.05, -z], [x, TABLE - 0.004, z]);
    stage.build("mortar", slab, stone);
    // The frame stands a little higher than the tiles and reaches a little lower than the slab.
    let (low, high, wide) = (TABLE - 0.06, TABLE + 0.004, 0.04);
    for s in [-1.0f32, 1.0] {
        let long = cuboid(
            [-x - wide, low, (s * z).min(s * (z + wide))],
            [x + wide, high, (s * z).max(s * (z + wide))],
        );
        stage.build("frame", long, wood);
        let short = cuboid(
            [(s * x).min(s * (x + wide)), low, -z],
            [(s * x).max(s * (x + wide)), high, z],
        );
        stage.build("frame", short, wood);
    }
    let half = 0.5 * TILE - 0.001;
    let tile = |stage: &mut Stage, name: &str, material: u32| {
        let tile = cuboid([-half, TABLE - 0.01, -half], [half, TABLE, half]);
        stage.mesh(name, tile, material)
    };
    let tiles = [
        tile(stage, "tile, light", light),
        tile(stage, "tile, dark", dark),
    ];
    for i in 0..TILES[0] {
        for j in 0..TILES[1] {
            let at = [i, j].map(|k| (k as f32 + 0.5) * TILE);
            let transform = set_down(0.0, 1.0, [at[0] - x, 0.0, at[1] - z]);
            stage.place(tiles[(i + j) as usize % 2], transform);
        }
    }
}

fn metal(name: &str, color: [f32; 3], roughness: f32) -> Material {
    Material {
        metallic: 1.0,
        ..paint(name, color, roughness)
    }
}
