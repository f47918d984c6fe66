//! Whitted's tree of rays.
//!
//! *How it works.* At each surface: what it emits, what lamps bring it (a shadow ray each, several where shadows are
//! soft), even light from around (darker where near things stand in the way), then a mirrored and a refracted ray, each
//! weighted by Fresnel, both followed. Nothing branches by chance. A branch ends at the depth that was asked for, or
//! when it can no longer change a pixel; the surroundings stand in for what it would have seen. Rough surfaces mirror
//! blurred surroundings instead of tracing a ray; between, the two fade into each other. Cost: with `b` mirrors in view of
//! each other at most `2^depth` rays a sample, in practice few, as glass reflects but 4 %.
//!
//! *Source.* Whitted 1980, *An Improved Illumination Model for Shaded Display*; Chiang, Li & Burley 2019, *Taming the
//! Shadow Terminator*.

use super::direction::around_normal;
use super::fresnel;
use super::gloss;
use super::light::{Aim, Lamp};
use super::material::attenuate;
use super::point::Point;
use crate::colour::{WHITE, smoothstep};
use crate::sample::{Samples, hash};
use crate::world::World;
use boxwood::{Ray, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A branch that contributes less than this is not followed.
const LEAST_WEIGHT: f32 = 1.0 / 256.0;
/// More blended layers than this on one straight ray count as solid.
const MOST_LAYERS: u32 = 48;
/// Perceptual roughness up to which reflections are traced, and from which they are blurred surroundings.
const MIRROR: [f32; 2] = [0.18, 0.42];
/// The part of even light that reaches the most sheltered place: light between surfaces, which is not traced.
const SHELTERED: f32 = 0.3;
/// The brightest highlight of a lamp, so that single samples cannot make specks.
const BRIGHTEST: f32 = 24.0;

/// Follows rays through a world.
pub(crate) struct Tracer<'a> {
    pub world: &'a World,
    /// The light over the viewer's shoulder, where the scene has none.
    pub key: Option<Lamp>,
    /// What radiance is multiplied by in the end; unlit surfaces are held against it.
    pub exposure: f32,
    /// How many mirrored or refracted rays may follow each other.
    pub depth: u32,
    /// Rays per soft lamp, and for ambient occlusion, at what the camera sees directly; 0 makes shadows hard and leaves
    /// occlusion out.
    pub soft: u32,
    /// Whether any lamp has a surface that rays may meet.
    pub visible_lamps: bool,
}

/// What a ray brought home.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    pub radiance: Vec3,
    /// The part of it that comes straight from the surroundings.
    pub background: Vec3,
    /// The share that is not surroundings.
    pub coverage: f32,
    /// The share that is shown as it is, without light.
    pub unlit: f32,
    pub albedo: Vec3,
    /// Shading normal; zero where there is no surface.
    pub normal: Vec3,
}

/// Where in the tree a ray is.
#[derive(Clone, Copy)]
pub(crate) struct Branch {
    depth: u32,
    /// What the pixel gets of it at most.
    weight: f32,
    /// Tells branches apart when they take samples.
    purpose: u32,
    /// Width of the ray's footprint at its origin, and its growth per distance.
    width: f32,
    spread: f32,
}

impl Branch {
    /// A ray from the camera.
    pub fn root((width, spread): (f32, f32)) -> Self {
        Self {
            depth: 0,
            weight: 1.0,
            purpose: 1,
            width,
            spread,
        }
    }

    fn child(&self, which: u32, weight: f32, width: f32) -> Self {
        Self {
            depth: self.depth + 1,
            weight: self.weight * weight,
            purpose: hash(self.purpose.wrapping_mul(4).wrapping_add(which)),
            width,
            spread: self.spread,
        }
    }
}

impl Tracer<'_> {
    /// Follows a ray whose direction has unit length.
    pub fn trace(&self, mut ray: Ray, mut branch: Branch, samples: &Samples) -> Seen {
        let mut seen = Seen::default();
        // The share of what lies behind the layers so far.
        let mut left = 1.0;
        for layer in 0..MOST_LAYERS {
            let hit = self.world.closest(&ray);
            if self.visible_lamps
                && let Some(radiance) =
                    self.lamp_before(&ray, hit.map_or(f32::INFINITY, |hit| hit.t))
            {
                seen.radiance += radiance * left;
                seen.coverage += left;
                seen.albedo += WHITE * left;
                return seen;
            }
            let Some(hit) = hit else {
                seen.background = self.world.environment.radiance(ray.direction) * left;
                seen.radiance += seen.background;
                return seen;
            };
            let width = branch.width + branch.spread * hit.t;
            let point = self.world.point(&ray, &hit, width);
            let share = if layer + 1 == MOST_LAYERS {
                left
            } else {
                left * point.alpha
            };
            let mut radiance = if point.material.plain.unlit {
                seen.unlit += share;
                point.base * (1.0 / self.exposure)
            } else {
                let here = Branch {
                    weight: branch.weight * share,
                    width,
                    ..branch
                };
                self.shade(&point, here, samples)
            };
            if point.inside() {
                radiance = radiance * attenuate(point.material.absorption, hit.t);
            }
            seen.radiance += radiance * share;
            seen.coverage += share;
            seen.albedo += point.base * share;
            seen.normal += point.normal * share;
            left -= share;
            if left < LEAST_WEIGHT {
                return seen;
            }
            branch.width = width;
            branch.purpose = hash(branch.purpose ^ 0x5bd1_e995);
            ray = Ray::new(point.surface.offset_origin(ray.direction), ray.direction);
        }
        seen
    }

    /// Only what the ray meets first, without any light.
    pub fn look(&self, ray: Ray, branch: Branch) -> Seen {
        let Some(hit) = self.world.closest(&ray) else {
            return Seen::default();
        };
        let point = self
            .world
            .point(&ray, &hit, branch.width + branch.spread * hit.t);
        Seen {
            coverage: 1.0,
            albedo: point.base,
            normal: point.normal,
            ..Seen::default()
        }
    }

    fn lamp_before(&self, ray: &Ray, t: f32) -> Option<Vec3> {
        let mut nearest = None;
        let mut t_max = t;
        for lamp in &self.world.lamps {
            if let Some((t, radiance)) = lamp.meet(ray, t_max) {
                t_max = t;
                nearest = Some(radiance);
            }
        }
        nearest
    }

    fn shade(&self, point: &Point<'_>, branch: Branch, samples: &Samples) -> Vec3 {
        let n_v = point.normal.dot(point.to_eye).clamp(0.0, 1.0);
        let mirror = 1.0 - smoothstep(MIRROR[0], MIRROR[1], point.roughness);
        let smooth = point.fresnel(n_v);
        let rough = gloss::towards_even_light(point.at_normal(), point.roughness, n_v);
        let glossy = smooth * mirror + rough * (1.0 - mirror);
        let kept = WHITE - glossy;
        // Metals have no diffuse part to keep anything for.
        let diffuse = point.diffuse() * kept.max(Vec3::ZERO);

        let mut light = point.emission;
        light += self.direct(point, diffuse, mirror, branch, samples);

        let (matt, dull) = (diffuse.max_element() > 0.0, rough * (1.0 - mirror));
        if matt || dull.max_element() > 0.0 {
            let around = &self.world.environment;
            let even = around.irradiance(point.normal) * diffuse * FRAC_1_PI
                + around.blurred(point.mirrored(), point.roughness) * dull;
            light += even * self.openness(point, branch, samples);
        }
        let reflected = smooth * mirror;
        if reflected.max_element() > 0.0 {
            light += self.follow(
                point,
                point.mirrored(),
                reflected,
                branch.child(1, reflected.max_element(), branch.width),
                samples,
            );
        }
        if point.transmission > 0.0 {
            light += self.transmitted(point, smooth, branch, samples);
        }
        light
    }

    fn transmitted(
        &self,
        point: &Point<'_>,
        fresnel: Vec3,
        branch: Branch,
        samples: &Samples,
    ) -> Vec3 {
        let clear = point.transmission * (1.0 - point.metallic);
        // A body's own colour counts once, where the ray enters.
        let colour = if point.inside() { WHITE } else { point.base };
        let factor = (WHITE - fresnel).max(Vec3::ZERO) * colour * clear;
        if !(factor.max_element() > 0.0) {
            return Vec3::ZERO;
        }
        let along = -point.to_eye;
        let direction = if point.material.plain.thin {
            Some(along)
        } else {
            let eta = if point.inside() {
                point.ior()
            } else {
                1.0 / point.ior()
            };
            fresnel::refract(along, point.normal, eta)
                .filter(|bent| bent.dot(point.facing) < 0.0)
                .or_else(|| fresnel::refract(along, point.facing, eta))
        };
        let Some(direction) = direction else {
            return Vec3::ZERO;
        };
        self.follow(
            point,
            direction,
            factor,
            branch.child(2, factor.max_element(), branch.width),
            samples,
        )
    }

    /// What comes from a direction, or what the surroundings say when that branch is not worth a ray.
    fn follow(
        &self,
        point: &Point<'_>,
        direction: Vec3,
        factor: Vec3,
        branch: Branch,
        samples: &Samples,
    ) -> Vec3 {
        if branch.depth > self.depth || branch.weight < LEAST_WEIGHT {
            return self.world.environment.blurred(direction, 0.3) * factor;
        }
        let ray = Ray::new(point.surface.offset_origin(direction), direction);
        self.trace(ray, branch, samples).radiance * factor
    }

    /// How many rays something soft gets here.
    fn soft_rays(&self, branch: &Branch) -> u32 {
        if branch.depth == 0 && branch.weight > 0.25 {
            self.soft
        } else {
            self.soft.min(1)
        }
    }

    fn direct(
        &self,
        point: &Point<'_>,
        diffuse: Vec3,
        mirror: f32,
        branch: Branch,
        samples: &Samples,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let soft = self.soft_rays(&branch);
        for (number, lamp) in self.world.lamps.iter().chain(&self.key).enumerate() {
            let rays = if lamp.is_soft() { soft.max(1) } else { 1 };
            // Mirrors see lamps with a surface of their own as they are.
            let highlight = match lamp {
                Lamp::Sphere { .. } | Lamp::Rectangle { .. } => 1.0 - mirror,
                _ => 1.0,
            };
            let purpose = branch.purpose.wrapping_add(number as u32 * 0x9e37_79b9);
            let mut part = Vec3::ZERO;
            for j in 0..rays {
                let sample = if soft == 0 {
                    [0.5; 2]
                } else {
                    samples.pair(purpose, rays, j)
                };
                if let Some(aim) = lamp.aim(point.surface.position, sample) {
                    part += self.arriving(point, &aim, diffuse, highlight);
                }
            }
            sum += part * (1.0 / rays as f32);
        }
        if !self.world.emitters.is_empty() {
            let rays = soft.max(1) * 2;
            let mut part = Vec3::ZERO;
            for j in 0..rays {
                let sample = samples.pair(branch.purpose ^ 0x3c6e_f372, rays, j);
                if let Some(aim) =
                    self.world
                        .emitters
                        .aim(self.world, point.surface.position, sample)
                {
                    part += self.arriving(point, &aim, diffuse, 1.0 - mirror);
                }
            }
            sum += part * (1.0 / rays as f32);
        }
        sum
    }

    /// What one aim at a lamp brings to the eye.
    fn arriving(&self, point: &Point<'_>, aim: &Aim, diffuse: Vec3, highlight: f32) -> Vec3 {
        let cos = point.normal.dot(aim.direction);
        let true_cos = point.facing.dot(aim.direction);
        if !(cos > 0.0 && true_cos > 0.0) {
            return Vec3::ZERO;
        }
        let mut scattered = diffuse * (FRAC_1_PI * cos * terminator(point, cos, true_cos));
        if highlight > 0.0 {
            let half = (aim.direction + point.to_eye).normalized();
            let lobe = gloss::lobe(
                point.normal,
                point.to_eye,
                aim.direction,
                half,
                point.roughness,
            );
            let share = point.fresnel(half.dot(point.to_eye).clamp(0.0, 1.0));
            scattered += share * (lobe * highlight);
        }
        let light = scattered * aim.light;
        if !(light.max_element() > 0.0) {
            return Vec3::ZERO;
        }
        let origin = point.surface.offset_origin(aim.direction);
        let ray = match aim.end {
            Some(end) => Ray::between(origin, end),
            None => Ray::new(origin, aim.direction),
        };
        let light = light * self.world.light_through(&ray, aim.triangle);
        let brightest = light.max_element();
        if brightest > BRIGHTEST {
            light * (BRIGHTEST / brightest)
        } else {
            light
        }
    }

    /// How much of the even light from around reaches a place: 1 in the open.
    fn openness(&self, point: &Point<'_>, branch: Branch, samples: &Samples) -> f32 {
        let rays = self.soft_rays(&branch);
        let reach = self.world.ambient_reach;
        if rays == 0 || !(reach > 0.0) {
            return 1.0;
        }
        let mut open = 0.0;
        for j in 0..rays {
            let sample = samples.pair(branch.purpose ^ 0x1656_67b1, rays, j);
            let direction = around_normal(point.normal, sample);
            if direction.dot(point.facing) <= 0.0 {
                // Below the triangle, which the smooth surface that it stands for does not cover.
                open += 1.0;
                continue;
            }
            let ray = Ray::new(point.surface.offset_origin(direction), direction).until(reach);
            open += self.world.light_through(&ray, None).max_element();
        }
        SHELTERED + (1.0 - SHELTERED) * open / rays as f32
    }
}

/// Softens the edge that flat triangles cut into the shading of the smooth surface they stand for.
fn terminator(point: &Point<'_>, cos: f32, true_cos: f32) -> f32 {
    let across = point.normal.dot(point.facing);
    let share = (true_cos / (cos * across)).clamp(0.0, 1.0);
    if share < 1.0 {
        ((1.0 - share) * share + 1.0) * share
    } else {
        1.0
    }
}
