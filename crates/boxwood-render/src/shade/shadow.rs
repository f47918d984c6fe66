//! What lamps and the surroundings bring to the places of a wave, held against what stands in the way.
//!
//! *How it works.* One lamp after the other: all places say which shadow rays they want, each with the light that it would
//! bring; these are asked together; then each place adds up what its own have brought. The rays of ambient occlusion go the
//! same way, for light from all around.
//!
//! *Cost.* A shadow ray for each place and lamp, several where shadows are soft; memory for those of one wave, or of one place where
//! it wants more.
//!
//! *Source.* Whitted 1980; Chiang, Li & Burley 2019, *Taming the Shadow Terminator*.

use super::direction::around_normal;
use super::gloss;
use super::light::{Aim, Lamp};
use super::point::Point;
use super::whitted::{Branch, Place, Tracer, WAVE};
use crate::colour::WHITE;
use crate::world::Triangle;
use boxwood::{Ray, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The part of even light that reaches the most sheltered place: light between surfaces, which is not traced.
const SHELTERED: f32 = 0.3;
/// The brightest highlight of a lamp, so that single samples cannot make specks.
const BRIGHTEST: f32 = 24.0;

/// Light on its way to a place.
pub(crate) struct Shadow {
    /// What must be free; `None` where nothing can stand in the way.
    pub ray: Option<Ray>,
    /// The triangle that shines. It casts no shadow.
    pub lamp: Option<Triangle>,
    /// What it brings: in the open at first, then what arrives.
    pub light: Vec3,
}

impl Tracer<'_> {
    /// What lamps bring to the eye by way of each place.
    pub(super) fn direct(&self, places: &[Place<'_>]) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; places.len()];
        let lamps = self.world.lamps.iter().chain(&self.key);
        for (number, lamp) in (0_u32..).zip(lamps) {
            let count = |place: &Place<'_>| {
                if lamp.is_soft() {
                    self.soft_rays(&place.branch).max(1)
                } else {
                    1
                }
            };
            let want = |place: &Place<'_>, shadows: &mut Vec<Shadow>| {
                // Mirrors see lamps with a surface of their own as they are.
                let highlight = match lamp {
                    Lamp::Sphere { .. } | Lamp::Rectangle { .. } => 1.0 - place.mirror,
                    _ => 1.0,
                };
                let purpose = (place.branch.purpose).wrapping_add(number.wrapping_mul(0x9e37_79b9));
                let rays = count(place);
                for j in 0..rays {
                    let sample = if self.soft == 0 || !lamp.is_soft() {
                        [0.5; 2]
                    } else {
                        place.samples.pair(purpose, rays, j)
                    };
                    let aim = lamp.aim(place.point.surface.position, sample);
                    shadows.extend(aim.and_then(|aim| arriving(place, &aim, highlight)));
                }
            };
            self.gather(places, want, |i, shadows| {
                sums[i] += mean(shadows, count(&places[i]));
            });
        }
        let emitters = &self.world.emitters;
        if !emitters.is_empty() {
            let count = |place: &Place<'_>| self.soft_rays(&place.branch).max(1) * 2;
            let want = |place: &Place<'_>, shadows: &mut Vec<Shadow>| {
                let purpose = place.branch.purpose ^ 0x3c6e_f372;
                let rays = count(place);
                for j in 0..rays {
                    let sample = place.samples.pair(purpose, rays, j);
                    let aim = emitters.aim(self.world, place.point.surface.position, sample);
                    shadows.extend(aim.and_then(|aim| arriving(place, &aim, 1.0 - place.mirror)));
                }
            };
            self.gather(places, want, |i, shadows| {
                sums[i] += mean(shadows, count(&places[i]));
            });
        }
        sums
    }

    /// How much of the even light from around reaches each place that shows any: 1 in the open.
    pub(super) fn openness(&self, places: &[Place<'_>]) -> Vec<f32> {
        let mut open = vec![1.0; places.len()];
        let reach = self.world.ambient_reach;
        if !(reach > 0.0) {
            return open;
        }
        let want = |place: &Place<'_>, shadows: &mut Vec<Shadow>| {
            if !place.shows_even_light() {
                return;
            }
            let point = &place.point;
            let rays = self.soft_rays(&place.branch);
            for j in 0..rays {
                let sample = (place.samples).pair(place.branch.purpose ^ 0x1656_67b1, rays, j);
                let direction = around_normal(point.normal, sample);
                // Below the triangle there is nothing in the way that the smooth surface it stands for does not cover.
                let ray = (direction.dot(point.facing) > 0.0)
                    .then(|| Ray::new(point.surface.offset_origin(direction), direction));
                shadows.push(Shadow {
                    ray: ray.map(|ray| ray.until(reach)),
                    lamp: None,
                    light: WHITE,
                });
            }
        };
        self.gather(places, want, |i, shadows| {
            if !shadows.is_empty() {
                let sum: f32 = shadows.iter().map(|s| s.light.max_element()).sum();
                open[i] = SHELTERED + (1.0 - SHELTERED) * sum / shadows.len() as f32;
            }
        });
        open
    }

    /// Asks for the shadow rays that places want, many together, and gives to each place, by its number, its own.
    fn gather<'p>(
        &self,
        places: &[Place<'p>],
        want: impl Fn(&Place<'p>, &mut Vec<Shadow>),
        mut give: impl FnMut(usize, &[Shadow]),
    ) {
        let mut shadows = Vec::new();
        // Of the shadow rays of each place that waits for its own.
        let mut ends = Vec::new();
        for (i, place) in places.iter().enumerate() {
            want(place, &mut shadows);
            ends.push(shadows.len());
            if shadows.len() < WAVE && i + 1 < places.len() {
                continue;
            }
            for wave in shadows.chunks_mut(WAVE) {
                self.world.darken(wave);
            }
            let first = i + 1 - ends.len();
            let mut start = 0;
            for (i, end) in (first..).zip(ends.drain(..)) {
                give(i, &shadows[start..end]);
                start = end;
            }
            shadows.clear();
        }
    }

    /// How many rays something soft gets here.
    fn soft_rays(&self, branch: &Branch) -> u32 {
        if branch.depth == 0 && branch.weight > 0.25 {
            self.soft
        } else {
            self.soft.min(1)
        }
    }
}

/// The mean over rays, of which those that bring nothing are left out.
fn mean(shadows: &[Shadow], rays: u32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for Shadow { light, .. } in shadows {
        let brightest = light.max_element();
        sum += if brightest > BRIGHTEST {
            *light * (BRIGHTEST / brightest)
        } else {
            *light
        };
    }
    sum * (1.0 / rays as f32)
}

/// What one aim at a lamp brings to the eye, if nothing is in the way; `None` where that is nothing.
fn arriving(place: &Place<'_>, aim: &Aim, highlight: f32) -> Option<Shadow> {
    let point = &place.point;
    let cos = point.normal.dot(aim.direction);
    let true_cos = point.facing.dot(aim.direction);
    if !(cos > 0.0 && true_cos > 0.0) {
        return None;
    }
    let mut scattered = place.diffuse * (FRAC_1_PI * cos * terminator(point, cos, true_cos));
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
        return None;
    }
    let origin = point.surface.offset_origin(aim.direction);
    let ray = match aim.end {
        Some(end) => Ray::between(origin, end),
        None => Ray::new(origin, aim.direction),
    };
    Some(Shadow {
        ray: Some(ray),
        lamp: aim.triangle,
        light,
    })
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
