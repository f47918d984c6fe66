//! Rays through holes: cut-outs, blended layers and clear bodies.
//!
//! *How it works.* A ray on its way asks about the hits that may be no surface there, and only about those; a scene without
//! any never asks. A shadow ray gathers what it crosses: a solid surface ends it, layers tint it. Clear bodies tint by
//! Fresnel, by colour and by the way inside, but do not bend the ray: shadows of glass are coloured, without caustics.

use super::fresnel;
use super::material::attenuate;
use crate::colour::WHITE;
use crate::world::World;
use boxwood::{Hit, Ray, Surfaces, Vec3};

/// More layers than this are dark.
const MOST_LAYERS: usize = 16;
/// Thinner layers are no surface.
const LEAST_COVERAGE: f32 = 1.0 / 512.0;

impl World {
    /// The nearest surface that is there.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        if !self.open.any_holes() {
            return self.structure.closest_hit(ray);
        }
        self.structure.closest_hit_where(ray, &mut |hit| {
            !self.open.has_holes(hit.primitive) || self.coverage(hit) > LEAST_COVERAGE
        })
    }

    /// The share of light that arrives along a shadow ray. A triangle may be left out: the lamp itself.
    pub fn light_through(&self, ray: &Ray, lamp: Option<u32>) -> Vec3 {
        if !self.open.any() {
            let dark = match lamp {
                None => self.structure.occluded(ray),
                Some(_) => self
                    .structure
                    .occluded_where(ray, &mut |hit| Some(hit.primitive) != lamp),
            };
            return if dark { Vec3::ZERO } else { WHITE };
        }
        let mut layers = Layers::none();
        let dark = self.structure.occluded_where(ray, &mut |hit| {
            Some(hit.primitive) != lamp
                && (!self.open.lets_through(hit.primitive) || !layers.add(hit))
        });
        if dark {
            Vec3::ZERO
        } else {
            self.tint(ray, layers.sorted())
        }
    }

    fn tint(&self, ray: &Ray, layers: &[Hit]) -> Vec3 {
        let mut light = WHITE;
        // Way inside, per body: entering counts back from zero, leaving forward.
        let mut optical_depth = Vec3::ZERO;
        for hit in layers {
            let coverage = if self.open.has_holes(hit.primitive) {
                self.coverage(hit)
            } else {
                1.0
            };
            if coverage <= LEAST_COVERAGE {
                continue;
            }
            let material = self.material_of(hit.primitive);
            let mut solid = Vec3::ZERO;
            if material.transmits() {
                let point = self.point(ray, hit, 0.0);
                let cos_in = point.to_eye.dot(point.facing).abs();
                // From inside, a shadow ray that is not bent meets angles that real light never does: the angle outside counts.
                let share = fresnel::dielectric(cos_in, 1.0 / point.ior());
                let colour = if point.inside() { WHITE } else { point.base };
                solid = colour * ((1.0 - share) * point.transmission * (1.0 - point.metallic));
                if !material.plain.thin && material.absorption != Vec3::ZERO {
                    let distance = (ray.direction * hit.t).length();
                    let sign = if point.front { -distance } else { distance };
                    optical_depth += material.absorption * sign;
                }
            }
            light = light * (Vec3::splat(1.0 - coverage) + solid * coverage);
        }
        light * attenuate(optical_depth.max(Vec3::ZERO), 1.0)
    }

    /// The geometric surface at a point of a triangle.
    pub fn surface_of(
        &self,
        primitive: u32,
        [u, v]: [f32; 2],
        seen_along: Vec3,
    ) -> boxwood::Surface {
        let ray = Ray::new([0.0; 3], seen_along);
        let hit = Hit {
            t: 0.0,
            u,
            v,
            primitive,
            instance: 0,
        };
        self.mesh.surface(&ray, &hit)
    }
}

/// The layers that a shadow ray crosses. Which they are does not depend on the order in which a structure finds them.
struct Layers {
    hits: [Hit; MOST_LAYERS],
    count: usize,
}

impl Layers {
    fn none() -> Self {
        let blank = Hit {
            t: 0.0,
            u: 0.0,
            v: 0.0,
            primitive: 0,
            instance: 0,
        };
        Self {
            hits: [blank; MOST_LAYERS],
            count: 0,
        }
    }

    /// Whether there was room.
    fn add(&mut self, hit: &Hit) -> bool {
        if self.hits[..self.count]
            .iter()
            .any(|other| other.primitive == hit.primitive)
        {
            return true;
        }
        if self.count == MOST_LAYERS {
            return false;
        }
        self.hits[self.count] = *hit;
        self.count += 1;
        true
    }

    /// In the order along the ray, so that rounding does not depend on the structure either.
    fn sorted(&mut self) -> &[Hit] {
        let found = &mut self.hits[..self.count];
        found.sort_unstable_by(Hit::order);
        found
    }
}
