//! Menger's sponge: a cube of 27, of which the middle of each face and of the whole is left out, and so on in each of the 20 left.
//!
//! *How it works.* The first two levels are a mesh of 400 cubes. Each further level is a group that places 20 copies of the
//! one before, a third as large: a dozen bytes of memory stand for 20 times as many triangles, and six levels are 768 million
//! of them.
//!
//! *Source.* Menger 1926, *Allgemeine Räume und Cartesische Räume*; recursive instances after Rubin & Whitted 1980.

use super::random::Random;
use super::solids::cuboid;
use super::stage::{Stage, paint};
use super::{camera, sun};
use crate::scene::{Group, Instance, Mesh, PlacedGroup, Scene};
use boxwood::Affine;

/// Levels that the mesh has.
const MESHED: u32 = 2;

/// A sponge of some levels, 2 m wide, on a floor.
pub(super) fn sponge(levels: u32, seed: u64) -> Scene {
    let mut random = Random::new(seed, 9);
    let mut stage = Stage::default();
    let colour = [(0.5, 0.75), (0.3, 0.5), (0.08, 0.3)].map(|(from, to)| random.between(from, to));
    let stuff = stage.material(paint("sponge", colour, 0.8));
    let floor = stage.material(paint("floor", [0.34, 0.35, 0.37], 0.9));
    stage.build(
        "floor",
        cuboid([-40.0, -1.2, -40.0], [40.0, -1.0, 40.0]),
        floor,
    );
    let mesh = stage.mesh("cubes", cubes(levels.min(MESHED)), stuff);
    if levels <= MESHED {
        stage.place(mesh, Affine::IDENTITY);
    }
    let mut scene = stage.scene;
    for level in MESHED + 1..=levels {
        // The first group places the mesh, each further one the group before it.
        let transforms = kept().map(|[x, y, z]| {
            let third = 1.0 / 3.0;
            let to = [x, y, z].map(|k| 2.0 * third * k as f32);
            Affine::scale([third; 3]).then(&Affine::translation(to))
        });
        scene.groups.push(if level == MESHED + 1 {
            Group {
                instances: transforms
                    .map(|transform| Instance { mesh, transform })
                    .collect(),
                groups: Vec::new(),
            }
        } else {
            let group = scene.groups.len() as u32 - 1;
            Group {
                instances: Vec::new(),
                groups: transforms
                    .map(|transform| PlacedGroup { group, transform })
                    .collect(),
            }
        });
    }
    if levels > MESHED {
        scene.placed_groups = vec![PlacedGroup {
            group: scene.groups.len() as u32 - 1,
            transform: Affine::IDENTITY,
        }];
    }
    scene.lights = vec![sun([-0.45, -0.75, -0.5])];
    scene.cameras = vec![
        camera("main", [2.5, 1.35, 3.1], [0.0, -0.12, 0.0], 40.0),
        camera("inside", [0.0, 0.05, 0.32], [0.3, 0.0, -1.0], 75.0),
    ];
    scene
}

/// Of the 27 places from −1 to 1 along each axis, those that are kept: where at most one coordinate is 0.
fn kept() -> impl Iterator<Item = [i32; 3]> {
    (0..27)
        .map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1])
        .filter(|place| place.iter().filter(|&&k| k == 0).count() < 2)
}

/// The cubes of a sponge between −1 and 1.
fn cubes(levels: u32) -> Mesh {
    let mut places = vec![[0.0_f32; 3]];
    let mut half = 1.0_f32;
    for _ in 0..levels {
        half /= 3.0;
        let place = |at: [f32; 3], [x, y, z]: [i32; 3]| {
            let to = |at: f32, k: i32| at + 2.0 * half * k as f32;
            [to(at[0], x), to(at[1], y), to(at[2], z)]
        };
        places = (places.iter())
            .flat_map(|&at| kept().map(move |k| place(at, k)))
            .collect();
    }
    let mut mesh = Mesh::default();
    for at in places {
        let cube = cuboid(at.map(|x| x - half), at.map(|x| x + half));
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(cube.positions);
        let triangles = cube.triangles.into_iter().map(|t| t.map(|v| v + first));
        mesh.triangles.extend(triangles);
    }
    mesh
}
