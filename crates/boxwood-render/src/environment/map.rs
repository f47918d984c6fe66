//! Surroundings from a latitude-longitude image.

use super::harmonics::{Harmonics, cell};
use crate::colour::luminance;
use crate::shade::texture::{Lookup, Texture};
use boxwood::Vec3;
use boxwood_scene::Wrap;
use std::f32::consts::PI;

/// The share of an image's light that its brightest spot must have to become a [`Sun`].
const SUN_SHARE: f32 = 0.08;
/// How many times brighter than the mean of the rest a pixel of the sun is.
const SUN_PEAK: f32 = 10.0;
/// Columns and rows of the grid that the light is summed over.
const GRID: [u32; 2] = [256, 128];

/// A spot of an image that is small, and bright enough to cast shadows.
#[derive(Clone, Debug)]
pub struct Sun {
    /// To the sun.
    pub direction: Vec3,
    /// On a surface that faces it.
    pub irradiance: Vec3,
    /// Half its apparent angle, in radians.
    pub radius: f32,
}

/// An image around the scene, in a y-up frame.
pub struct Map {
    image: Texture,
    intensity: f32,
    /// Pixels count no brighter than this for ambient light and rough reflections: the sun is a light of its own.
    ceiling: f32,
}

impl Map {
    /// Looks for a sun, and takes it out.
    pub fn new(image: Texture, intensity: f32) -> (Self, Option<Sun>) {
        let mut map = Self {
            image,
            intensity,
            ceiling: f32::INFINITY,
        };
        let all = luminance(map.sum(|light| light));
        // Each round takes more of the sun out of the mean that it is compared with.
        for _ in 0..4 {
            let mean = luminance(map.sum(|light| map.below_ceiling(light))) / (4.0 * PI);
            map.ceiling = SUN_PEAK * mean;
        }
        let peak = map.ceiling;
        let (mut irradiance, mut direction, mut solid_angle) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        map.each_cell(|d, light, angle| {
            let brightness = luminance(light);
            if peak > 0.0 && brightness > peak {
                // What is left below the ceiling stays with the rest of the sky.
                let excess = light * (1.0 - peak / brightness) * angle;
                irradiance += excess;
                direction += d * luminance(excess);
                solid_angle += angle;
            }
        });
        let together = direction.length() / luminance(irradiance).max(f32::MIN_POSITIVE);
        // Several lamps far apart are no sun: their mean direction would be none of theirs.
        if !(luminance(irradiance) > SUN_SHARE * all && together > 0.97) {
            map.ceiling = f32::INFINITY;
            return (map, None);
        }
        let sun = Sun {
            direction: direction.normalized(),
            irradiance,
            radius: (solid_angle / PI).sqrt().clamp(0.005, 0.5),
        };
        (map, Some(sun))
    }

    /// Light per grid cell: the image's own mip level of about that size, `f` told of direction, light and solid angle.
    fn each_cell(&self, mut f: impl FnMut(Vec3, Vec3, f32)) {
        let level = self.image.level_of_width(GRID[0]);
        for row in 0..GRID[1] {
            for column in 0..GRID[0] {
                let (d, angle) = cell(GRID[0], GRID[1], column, row);
                f(d, self.look_up(d, level), angle);
            }
        }
    }

    fn sum(&self, f: impl Fn(Vec3) -> Vec3) -> Vec3 {
        let mut sum = Vec3::ZERO;
        self.each_cell(|_, light, angle| sum += f(light) * angle);
        sum
    }

    /// As light.
    pub fn ambient(&self) -> Harmonics {
        let level = self.image.level_of_width(GRID[0]);
        Harmonics::project(GRID[0], GRID[1], |d| {
            self.below_ceiling(self.look_up(d, level))
        })
    }

    /// As a picture.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.look_up(direction, 0.0)
    }

    /// In a rough mirror: a mip level whose texels are about as wide as the cone of reflection.
    pub fn blurred(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let cone = roughness * roughness * PI;
        let texels = cone / (2.0 * PI) * self.image.size()[0] as f32;
        self.below_ceiling(self.look_up(direction, libm::log2f(texels.max(1.0))))
    }

    fn below_ceiling(&self, light: Vec3) -> Vec3 {
        let brightness = luminance(light);
        if brightness > self.ceiling {
            light * (self.ceiling / brightness)
        } else {
            light
        }
    }

    fn look_up(&self, d: Vec3, level: f32) -> Vec3 {
        let u = 0.5 + libm::atan2f(d.x, -d.z) / (2.0 * PI);
        let v = libm::acosf(d.y.clamp(-1.0, 1.0)) / PI;
        let lookup = Lookup {
            wrap: [Wrap::Repeat, Wrap::Clamp],
            smooth: true,
        };
        let [r, g, b, _] = self.image.sample([u, v], level, lookup);
        Vec3::new(r, g, b) * self.intensity
    }
}
