//! Mountains around a lake: one height field of any fineness.
//!
//! *How it works.* The land is a function of the place, so that a finer field shows the same mountains with more on them:
//! hills upon hills, with sharp ridges where they are high. Colours follow height and slope. *Cost.* 26 bytes for each
//! triangle; 10 million take a second or two.

use super::random::Noise;
use super::solids::facets;
use super::stage::{Stage, paint};
use super::{camera, sun};
use crate::material::Material;
use crate::scene::{Mesh, Scene};
use boxwood::Vec3;
use rayon::prelude::*;

/// Half the length of the land, in metres.
const HALF: f64 = 2000.0;
/// The lake's level, in metres.
const LAKE: f64 = 112.0;

/// A height field 4 km wide of about `n` triangles: as near to it as a square grid comes.
pub(super) fn terrain(n: u32, seed: u64) -> Scene {
    let land = Land(Noise::new(seed));
    let side = libm::sqrt(f64::from(n) / 2.0).round().max(2.0) as u32;
    let mut stage = Stage::default();
    let soil = stage.material(paint("land", [1.0; 3], 1.0));
    stage.build("land", land.mesh(side), soil);
    let water = stage.material(Material {
        ior: 1.33,
        ..paint("water", [0.012, 0.045, 0.06], 0.03)
    });
    stage.build("lake", lake(), water);
    let mut scene = stage.scene;
    scene.lights = vec![sun([0.75, -0.42, -0.25])];
    // On a hill above the shore, or high enough over what stands between it and the lake.
    let [x, z] = [-200.0, 1150.0];
    let way = (0..=25).map(|k| land.height(x + 10.0 * f64::from(k), z - 40.0 * f64::from(k)));
    let top = way.fold(LAKE, f64::max) + 50.0;
    scene.cameras = vec![
        camera(
            "main",
            [x as f32, top as f32, z as f32],
            [80.0, LAKE as f32 + 150.0, -700.0],
            46.0,
        ),
        camera(
            "overview",
            [-2900.0, 1900.0, 3300.0],
            [0.0, 0.0, 100.0],
            42.0,
        ),
    ];
    scene
}

#[derive(Clone, Copy)]
struct Land(Noise);

impl Land {
    /// In metres above the lowest places.
    fn height(&self, x: f64, z: f64) -> f64 {
        let (u, v) = (x / 1300.0, z / 1300.0);
        let hills = 0.5 + 0.5 * self.0.octaves(u, v, 3);
        // Ridges stand where the noise changes sign; each octave counts where those before it are high.
        let (mut ridges, mut weight, mut tall, mut wide) = (0.0, 1.0, 0.55, 1.0);
        for octave in 0..9 {
            let offset = 17.3 * f64::from(octave);
            let noise = self
                .0
                .at(u * 1.25 * wide + offset, v * 1.25 * wide - offset);
            let ridge = (1.0 - noise.abs()).max(0.0);
            let ridge = ridge * ridge * weight;
            weight = (ridge * 1.4).clamp(0.0, 1.0);
            ridges += tall * ridge;
            (tall, wide) = (tall * 0.46, wide * 2.07);
        }
        // A valley in the middle holds the lake.
        let far = (x * x + z * z) / (HALF * HALF);
        let bowl = 0.13 + 0.87 * smooth((far * 1.5).min(1.0));
        1150.0 * bowl * hills * (0.25 + ridges)
    }

    fn mesh(&self, side: u32) -> Mesh {
        let row = side as usize + 1;
        let at = |k: usize| HALF * (2.0 * k as f64 / f64::from(side) - 1.0);
        let heights: Vec<f32> = (0..row * row)
            .into_par_iter()
            .map(|i| self.height(at(i % row), at(i / row)) as f32)
            .collect();
        let step = (2.0 * HALF / f64::from(side)) as f32;
        let normals: Vec<[f32; 3]> = (0..row * row)
            .into_par_iter()
            .map(|i| {
                let (x, z) = (i % row, i / row);
                // Central differences; one-sided ones on the border.
                let slope = |low: usize, high: usize, cells: usize| {
                    (heights[high] - heights[low]) / (cells as f32 * step)
                };
                let (west, east) = (x.saturating_sub(1), (x + 1).min(row - 1));
                let (north, south) = (z.saturating_sub(1), (z + 1).min(row - 1));
                let dx = slope(z * row + west, z * row + east, east - west);
                let dz = slope(north * row + x, south * row + x, south - north);
                Vec3::new(-dx, 1.0, -dz).normalized().to_array()
            })
            .collect();
        let colors = (0..row * row)
            .into_par_iter()
            .map(|i| {
                self.color(
                    at(i % row),
                    heights[i].into(),
                    at(i / row),
                    normals[i][1].into(),
                )
            })
            .collect();
        let positions = (0..row * row)
            .into_par_iter()
            .map(|i| [at(i % row) as f32, heights[i], at(i / row) as f32])
            .collect();
        let vertex = |x: u32, z: u32| z * row as u32 + x;
        let triangles = (0..side * side)
            .into_par_iter()
            .flat_map_iter(|cell| {
                let (x, z) = (cell % side, cell / side);
                let [a, b] = [vertex(x, z), vertex(x + 1, z)];
                let [c, d] = [vertex(x + 1, z + 1), vertex(x, z + 1)];
                // Diagonals alternate, so that no direction is favoured.
                if (x + z) % 2 == 0 {
                    [[a, d, c], [a, c, b]]
                } else {
                    [[a, d, b], [b, d, c]]
                }
            })
            .collect();
        Mesh {
            normals,
            colors,
            smooth: true,
            ..facets(positions, triangles)
        }
    }

    /// Sand, meadow, forest, rock and snow.
    fn color(&self, x: f64, height: f64, z: f64, upright: f64) -> [f32; 4] {
        let rough = 0.5 * self.0.octaves(x / 90.0 + 31.7, z / 90.0, 3);
        let mut color = [0.13, 0.17, 0.045];
        let mut cover = |with: [f64; 3], share: f64| {
            let share = smooth(share.clamp(0.0, 1.0));
            for k in 0..3 {
                color[k] += (with[k] - color[k]) * share;
            }
        };
        cover([0.035, 0.075, 0.022], rough * 3.0 + 0.55);
        cover([0.36, 0.3, 0.2], (LAKE + 7.0 - height) / 6.0 + rough);
        cover(
            [0.21, 0.19, 0.17],
            (0.84 - upright) * 7.0 + rough + (height - 420.0) / 130.0,
        );
        cover(
            [0.82, 0.85, 0.9],
            (height - 520.0) / 90.0 + 3.0 * (upright - 0.8) + rough,
        );
        let [r, g, b] = color.map(|c| c as f32);
        [r, g, b, 1.0]
    }
}

fn lake() -> Mesh {
    let (r, y) = (HALF as f32, LAKE as f32);
    let corners = vec![[-r, y, -r], [-r, y, r], [r, y, r], [r, y, -r]];
    facets(corners, vec![[0, 1, 2], [0, 2, 3]])
}

/// From 0 to 1 without a kink at either end.
fn smooth(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}
