//! Whitted's tree of rays, a wave at a time.
//!
//! *How it works.* At each surface: what it emits, what lamps bring it (a shadow ray each, several where shadows are
//! soft), even light from around (darker where near things stand in the way), then a mirrored and a refracted ray, each
//! weighted by Fresnel, both followed. Nothing branches by chance. A branch ends at the depth that was asked for, or
//! when it can no longer change a pixel; the surroundings stand in for what it would have seen. Rough surfaces mirror
//! blurred surroundings instead of tracing a ray; between, the two fade into each other.
//!
//! It is Whitted's recursion with a slice of rays where he has one, because structures answer many rays faster than one after
//! the other: a wave asks for its hits together, then for the shadows of all of them, and what mirrors and glass send on is the
//! next wave. Each ray adds up what it sees in the order that it would have alone, so no bit of a picture depends on the
//! company.
//!
//! *Cost.* With `b` mirrors in view of each other at most `2^depth` rays a sample, in practice few, as glass reflects but 4 %.
//! Memory for one wave, of at most [`WAVE`] rays, at each depth.
//!
//! *Source.* Whitted 1980, *An Improved Illumination Model for Shaded Display*.

use super::fresnel;
use super::gloss;
use super::light::Lamp;
use super::material::attenuate;
use super::point::Point;
use crate::colour::{WHITE, smoothstep};
use crate::sample::{Samples, hash};
use crate::world::World;
use boxwood::{Hit, Ray, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The most rays that travel together: no more than a batch call keeps on its thread. A thread that waited for others in the
/// middle of a tile would begin another one meanwhile.
pub(crate) const WAVE: usize = 1024;
/// A branch that contributes less than this is not followed.
const LEAST_WEIGHT: f32 = 1.0 / 256.0;
/// More blended layers than this on one straight ray count as solid.
const MOST_LAYERS: u32 = 48;
/// Perceptual roughness up to which reflections are traced, and from which they are blurred surroundings.
const MIRROR: [f32; 2] = [0.18, 0.42];

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

/// A ray on its way.
#[derive(Clone, Copy)]
pub(crate) struct Sent {
    /// Its direction has unit length.
    pub ray: Ray,
    pub branch: Branch,
    pub samples: Samples,
}

/// What a ray brought home.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
    pub depth: u32,
    /// What the pixel gets of it at most.
    pub weight: f32,
    /// Tells branches apart when they take samples.
    pub purpose: u32,
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

    fn child(&self, which: u32, weight: f32) -> Self {
        Self {
            depth: self.depth + 1,
            weight: self.weight * weight,
            purpose: hash(self.purpose.wrapping_mul(4).wrapping_add(which)),
            ..*self
        }
    }

    /// How wide the ray is after a distance.
    fn width_at(&self, t: f32) -> f32 {
        self.width + self.spread * t
    }
}

/// A ray of a wave, which blended layers may let pass.
struct Way {
    /// In the wave.
    number: usize,
    sent: Sent,
    /// The share of what lies behind the layers so far.
    left: f32,
}

/// Where a way meets a surface.
struct Crossing {
    way: Way,
    t: f32,
    /// What the pixel sees of the surface rather than of what lies before and behind.
    share: f32,
}

/// A surface to be shaded, and what it does with light.
pub(super) struct Place<'a> {
    pub point: Point<'a>,
    pub branch: Branch,
    pub samples: Samples,
    /// How much of its gloss mirrors rays rather than blurred surroundings.
    pub mirror: f32,
    /// The matt share of light, per colour.
    pub diffuse: Vec3,
    /// What a smooth surface would mirror.
    smooth: Vec3,
    /// The share of blurred surroundings that it mirrors.
    dull: Vec3,
}

/// A way on from a surface.
struct Onward {
    direction: Vec3,
    /// What the surface sends on of the light from there.
    factor: Vec3,
    branch: Branch,
}

impl Tracer<'_> {
    /// Follows at most [`WAVE`] rays.
    pub fn trace(&self, sent: &[Sent]) -> Vec<Seen> {
        debug_assert!(sent.len() <= WAVE, "{} rays", sent.len());
        let mut seen = vec![Seen::default(); sent.len()];
        let mut ways: Vec<Way> = (0..).zip(sent).map(Way::new).collect();
        for layer in 1..=MOST_LAYERS {
            let rays: Vec<Ray> = ways.iter().map(|way| way.sent.ray).collect();
            let hits = self.world.closest_each(&rays);
            let mut behind = Vec::new();
            let (mut crossings, mut places) = (Vec::new(), Vec::new());
            for (way, hit) in ways.into_iter().zip(hits) {
                let Sent {
                    ray,
                    branch,
                    samples,
                } = way.sent;
                let seen = &mut seen[way.number];
                if self.visible_lamps
                    && let Some(radiance) =
                        self.lamp_before(&ray, hit.map_or(f32::INFINITY, |hit| hit.t))
                {
                    seen.radiance += radiance * way.left;
                    seen.coverage += way.left;
                    seen.albedo += WHITE * way.left;
                    continue;
                }
                let Some(hit) = hit else {
                    seen.background = self.world.environment.radiance(ray.direction) * way.left;
                    seen.radiance += seen.background;
                    continue;
                };
                let width = branch.width_at(hit.t);
                let point = self.world.point(&ray, &hit, width);
                let share = if layer == MOST_LAYERS {
                    way.left
                } else {
                    way.left * point.alpha
                };
                let crossing = Crossing {
                    way,
                    t: hit.t,
                    share,
                };
                if point.material.plain.unlit {
                    seen.unlit += share;
                    let light = point.base * (1.0 / self.exposure);
                    behind.extend(crossing.pass(&point, light, seen));
                } else {
                    let here = Branch {
                        weight: branch.weight * share,
                        width,
                        ..branch
                    };
                    crossings.push(crossing);
                    places.push(Place::new(point, here, samples));
                }
            }
            let lights = self.shade(&places);
            for ((crossing, place), light) in crossings.into_iter().zip(&places).zip(lights) {
                let seen = &mut seen[crossing.way.number];
                behind.extend(crossing.pass(&place.point, light, seen));
            }
            if behind.is_empty() {
                break;
            }
            ways = behind;
        }
        seen
    }

    /// Only what rays meet first, without any light.
    pub fn look(&self, sent: &[Sent]) -> Vec<Seen> {
        let rays: Vec<Ray> = sent.iter().map(|sent| sent.ray).collect();
        let hits = self.world.closest_each(&rays);
        let look = |(sent, hit): (&Sent, Option<Hit>)| {
            let Some(hit) = hit else {
                return Seen::default();
            };
            let width = sent.branch.width_at(hit.t);
            let point = self.world.point(&sent.ray, &hit, width);
            Seen {
                coverage: 1.0,
                albedo: point.base,
                normal: point.normal,
                ..Seen::default()
            }
        };
        sent.iter().zip(hits).map(look).collect()
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

    /// The light that places send to the eye.
    fn shade(&self, places: &[Place<'_>]) -> Vec<Vec3> {
        let direct = self.direct(places);
        let open = self.openness(places);
        let mirrored = places.iter().map(Place::mirrored);
        let refracted = places.iter().map(Place::refracted);
        let onward: Vec<_> = mirrored.chain(refracted).collect();
        let brought = self.follow(places, &onward);
        let (mirrored, refracted) = brought.split_at(places.len());
        let light = |(i, place): (usize, &Place<'_>)| {
            let mut light = place.point.emission + direct[i];
            if place.shows_even_light() {
                light += self.even(place) * open[i];
            }
            light + mirrored[i] + refracted[i]
        };
        places.iter().enumerate().map(light).collect()
    }

    /// What a place would send of the surroundings if it lay in the open.
    fn even(&self, place: &Place<'_>) -> Vec3 {
        let around = &self.world.environment;
        let point = &place.point;
        around.irradiance(point.normal) * place.diffuse * FRAC_1_PI
            + around.blurred(point.mirrored(), point.roughness) * place.dull
    }

    /// What comes along each way, of which every place has the same number, or what the surroundings say where it is not
    /// worth a ray.
    fn follow(&self, places: &[Place<'_>], ways: &[Option<Onward>]) -> Vec<Vec3> {
        let mut brought = vec![Vec3::ZERO; ways.len()];
        let (mut sent, mut factors) = (Vec::new(), Vec::new());
        for (i, (way, place)) in ways.iter().zip(places.iter().cycle()).enumerate() {
            let Some(way) = way else { continue };
            if way.branch.depth > self.depth || way.branch.weight < LEAST_WEIGHT {
                brought[i] = self.world.environment.blurred(way.direction, 0.3) * way.factor;
                continue;
            }
            let origin = place.point.surface.offset_origin(way.direction);
            sent.push(Sent {
                ray: Ray::new(origin, way.direction),
                branch: way.branch,
                samples: place.samples,
            });
            factors.push((i, way.factor));
        }
        for (sent, factors) in sent.chunks(WAVE).zip(factors.chunks(WAVE)) {
            for (seen, &(i, factor)) in self.trace(sent).iter().zip(factors) {
                brought[i] = seen.radiance * factor;
            }
        }
        brought
    }
}

impl Way {
    fn new((number, sent): (usize, &Sent)) -> Self {
        Self {
            number,
            sent: *sent,
            left: 1.0,
        }
    }
}

impl Crossing {
    /// Takes in the light of the surface and goes on behind it, unless nothing more can be seen there.
    fn pass(self, point: &Point<'_>, mut light: Vec3, seen: &mut Seen) -> Option<Way> {
        let Self { mut way, t, share } = self;
        if point.inside() {
            light = light * attenuate(point.material.absorption, t);
        }
        seen.radiance += light * share;
        seen.coverage += share;
        seen.albedo += point.base * share;
        seen.normal += point.normal * share;
        way.left -= share;
        if way.left < LEAST_WEIGHT {
            return None;
        }
        let Sent { ray, branch, .. } = &mut way.sent;
        branch.width = branch.width_at(t);
        branch.purpose = hash(branch.purpose ^ 0x5bd1_e995);
        *ray = Ray::new(point.surface.offset_origin(ray.direction), ray.direction);
        Some(way)
    }
}

impl<'a> Place<'a> {
    fn new(point: Point<'a>, branch: Branch, samples: Samples) -> Self {
        let n_v = point.normal.dot(point.to_eye).clamp(0.0, 1.0);
        let mirror = 1.0 - smoothstep(MIRROR[0], MIRROR[1], point.roughness);
        let smooth = point.fresnel(n_v);
        let rough = gloss::towards_even_light(point.at_normal(), point.roughness, n_v);
        let glossy = smooth * mirror + rough * (1.0 - mirror);
        let kept = WHITE - glossy;
        Self {
            // Metals have no diffuse part to keep anything for.
            diffuse: point.diffuse() * kept.max(Vec3::ZERO),
            dull: rough * (1.0 - mirror),
            point,
            branch,
            samples,
            mirror,
            smooth,
        }
    }

    /// Whether light from all around changes how the place looks.
    pub fn shows_even_light(&self) -> bool {
        self.diffuse.max_element() > 0.0 || self.dull.max_element() > 0.0
    }

    fn mirrored(&self) -> Option<Onward> {
        let factor = self.smooth * self.mirror;
        (factor.max_element() > 0.0).then(|| Onward {
            direction: self.point.mirrored(),
            factor,
            branch: self.branch.child(1, factor.max_element()),
        })
    }

    fn refracted(&self) -> Option<Onward> {
        let point = &self.point;
        if !(point.transmission > 0.0) {
            return None;
        }
        let clear = point.transmission * (1.0 - point.metallic);
        // A body's own colour counts once, where the ray enters.
        let colour = if point.inside() { WHITE } else { point.base };
        let factor = (WHITE - self.smooth).max(Vec3::ZERO) * colour * clear;
        if !(factor.max_element() > 0.0) {
            return None;
        }
        let along = -point.to_eye;
        let direction = if point.material.plain.thin {
            along
        } else {
            let eta = if point.inside() {
                point.ior()
            } else {
                1.0 / point.ior()
            };
            fresnel::refract(along, point.normal, eta)
                .filter(|bent| bent.dot(point.facing) < 0.0)
                .or_else(|| fresnel::refract(along, point.facing, eta))?
        };
        Some(Onward {
            direction,
            factor,
            branch: self.branch.child(2, factor.max_element()),
        })
    }
}

#[cfg(test)]
pub(crate) mod tests;
