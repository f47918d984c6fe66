//! The triangles of glowing materials, as one lamp.
//!
//! *How it works.* A triangle is chosen by its power (area times mean emission), a point on it by area; what comes from
//! there is divided by the chance of the choice. Few large emitters give soft shadows at little cost, many small ones
//! grain. *Cost.* 16 bytes a triangle; a binary search an aim.

use super::light::{Aim, solid_angle, towards};
use crate::colour::luminance;
use crate::world::{Triangle, World};
use boxwood::{Hit, Vec3};

/// With more glowing triangles than this, a scene's glow is seen but does not light: the choice by power alone would be
/// too noisy to be worth its rays.
const MOST_EMITTERS: usize = 50_000;

/// The triangles of glowing materials.
#[derive(Default)]
pub(crate) struct Emitters {
    triangles: Vec<Triangle>,
    /// Sums of power up to and with each triangle, the last one 1.
    shares: Vec<f32>,
    /// Areas.
    areas: Vec<f32>,
}

impl Emitters {
    /// Looks for them.
    pub fn find(world: &World) -> Self {
        let brightness: Vec<f32> = world
            .materials
            .iter()
            .map(|m| {
                if !m.shines() {
                    return 0.0;
                }
                let mean = m
                    .emissive_map
                    .as_ref()
                    .map_or([1.0; 4], |map| world.textures.mean(map));
                luminance(Vec3::from(m.plain.emissive) * Vec3::new(mean[0], mean[1], mean[2]))
            })
            .collect();
        let mut found = Self::default();
        if brightness.iter().all(|&b| !(b > 0.0)) {
            return found;
        }
        let mut sum = 0.0_f64;
        let mut sums = Vec::new();
        let layout = &world.layout;
        let shines = |mesh: u32| brightness[world.meshes[mesh as usize].material] > 0.0;
        let laid_out = (0..layout.laid_out_triangles()).map(|i| (0, i));
        let some_shine = (0..world.meshes.len() as u32).any(shines);
        let instanced = layout
            .instanced()
            .take_while(|_| some_shine)
            .filter(|&(_, mesh)| shines(mesh))
            .flat_map(|(instance, mesh)| {
                let count = world.meshes[mesh as usize].triangles.len() as u32;
                (0..count).map(move |i| (instance, i))
            });
        for triangle in laid_out.chain(instanced) {
            let mesh = &world.meshes[layout.mesh_of(triangle) as usize];
            let [a, b, c] = corners(world, triangle);
            let area = 0.5 * (b - a).cross(c - a).length();
            let power = f64::from(area) * f64::from(brightness[mesh.material]);
            if !(power > 0.0 && power.is_finite()) {
                continue;
            }
            if found.triangles.len() == MOST_EMITTERS {
                return Self::default();
            }
            sum += power;
            sums.push(sum);
            found.triangles.push(triangle);
            found.areas.push(area);
        }
        found.shares = sums.into_iter().map(|s| (s / sum) as f32).collect();
        found
    }

    /// Whether nothing glows (or too many triangles do).
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Aims at a triangle chosen by power.
    pub fn aim(&self, world: &World, from: Vec3, [u, v]: [f32; 2]) -> Option<Aim> {
        let i = self
            .shares
            .partition_point(|&share| share <= u)
            .min(self.shares.len() - 1);
        let before = if i == 0 { 0.0 } else { self.shares[i - 1] };
        let share = self.shares[i] - before;
        if !(share > 0.0) {
            return None;
        }
        // The rest of the first number serves again, inside the triangle.
        let root = ((u - before) / share).clamp(0.0, 1.0).sqrt();
        let weights = [root * (1.0 - v), root * v];
        let triangle = self.triangles[i];
        let [a, b, c] = corners(world, triangle);
        let place = a * (1.0 - weights[0] - weights[1]) + b * weights[0] + c * weights[1];
        let (direction, distance) = towards(from, place)?;
        let surface = world.surface_of(triangle, weights, direction);
        let cos = surface.normal.dot(direction).abs();
        let light =
            world.glow(triangle, weights) * (solid_angle(self.areas[i], cos, distance) / share);
        Some(Aim {
            direction,
            end: Some(surface.offset_origin(-direction)),
            light,
            triangle: Some(triangle),
        })
    }
}

/// In the world.
fn corners(world: &World, (instance, primitive): Triangle) -> [Vec3; 3] {
    world.layout.corners(&Hit {
        t: 0.0,
        u: 0.0,
        v: 0.0,
        primitive,
        instance,
    })
}
