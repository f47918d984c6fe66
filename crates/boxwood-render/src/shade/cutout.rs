//! Rays through holes: cut-outs, blended layers and clear bodies.
//!
//! *How it works.* Rays ask for their nearest hits together; one that may be no surface there asks again, alone and with a filter,
//! which looks at such hits and no others. Shadow rays ask together for anything in their way; only where light passes
//! that do they ask again and gather what they cross: a solid surface ends the ray, layers tint it. Clear bodies tint by Fresnel, by
//! colour and by the way inside, but do not bend the ray: shadows of glass are coloured, without caustics.

use super::fresnel;
use super::material::attenuate;
use super::shadow::Shadow;
use crate::colour::WHITE;
use crate::world::{Triangle, World};
use boxwood::{Hit, Ray, Vec3};

/// More layers than this are dark.
const MOST_LAYERS: usize = 16;
/// Thinner layers are no surface.
const LEAST_COVERAGE: f32 = 1.0 / 512.0;

impl World {
    /// The nearest surface that is there, for many rays.
    pub fn closest_each(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        let mut hits = vec![None; rays.len()];
        self.layout.structure().closest_hits(rays, &mut hits);
        for (ray, hit) in rays.iter().zip(&mut hits) {
            *hit = self.closest(ray, *hit);
        }
        hits
    }

    /// The nearest surface that is there, of a ray whose nearest hit is known.
    pub fn closest(&self, ray: &Ray, nearest: Option<Hit>) -> Option<Hit> {
        let is_there =
            |hit: &Hit| !self.has_holes(triangle(hit)) || self.coverage(hit) > LEAST_COVERAGE;
        if nearest.as_ref().is_none_or(is_there) {
            return nearest;
        }
        self.layout
            .structure()
            .closest_hit_where(ray, &mut |hit| is_there(hit))
    }

    /// Takes from each light what stands in its way.
    pub fn darken(&self, shadows: &mut [Shadow]) {
        let rays: Vec<Ray> = shadows.iter().filter_map(|shadow| shadow.ray).collect();
        let mut found = vec![None; rays.len()];
        self.layout.structure().occluders(&rays, &mut found);
        let shadows = shadows.iter_mut().filter(|shadow| shadow.ray.is_some());
        for ((shadow, ray), found) in shadows.zip(&rays).zip(found) {
            let left = match found {
                None => WHITE,
                Some(triangle) if self.stops(triangle, shadow.lamp) => Vec3::ZERO,
                Some(_) => self.light_through(ray, shadow.lamp),
            };
            shadow.light = shadow.light * left;
        }
    }

    /// Whether no light passes a triangle.
    fn stops(&self, triangle: Triangle, lamp: Option<Triangle>) -> bool {
        Some(triangle) != lamp && !self.lets_through(triangle)
    }

    /// The share of light that arrives along a shadow ray. A triangle may be left out: the lamp itself.
    fn light_through(&self, ray: &Ray, lamp: Option<Triangle>) -> Vec3 {
        let mut layers = Layers::none();
        let dark = self.layout.structure().occluded_where(ray, &mut |hit| {
            self.stops(triangle(hit), lamp) || (Some(triangle(hit)) != lamp && !layers.add(hit))
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
            let coverage = if self.has_holes(triangle(hit)) {
                self.coverage(hit)
            } else {
                1.0
            };
            if coverage <= LEAST_COVERAGE {
                continue;
            }
            let material = self.material_of(triangle(hit));
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
        (instance, primitive): Triangle,
        [u, v]: [f32; 2],
        seen_along: Vec3,
    ) -> boxwood::Surface {
        let ray = Ray::new([0.0; 3], seen_along);
        let hit = Hit {
            t: 0.0,
            u,
            v,
            primitive,
            instance,
        };
        self.layout.surface(&ray, &hit)
    }
}

fn triangle(hit: &Hit) -> Triangle {
    (hit.instance, hit.primitive)
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
            .any(|other| triangle(other) == triangle(hit))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Setup;
    use crate::sample::Samples;
    use crate::shade::whitted::tests::{everything, glowing, solid};

    /// Segments between random points around the scenes.
    fn segments() -> Vec<Ray> {
        let point = |i: u32, purpose: u32| {
            let samples = Samples::new([i, 0], 0);
            let ([x, y], [z, _]) = (samples.pair(purpose, 1, 0), samples.pair(purpose + 1, 1, 0));
            Vec3::new(6.0 * x - 3.0, 3.0 * y, 6.0 * z - 3.0)
        };
        (0..3000)
            .map(|i| Ray::between(point(i, 1), point(i, 3)))
            .collect()
    }

    #[test]
    fn rays_together_are_answered_as_alone() {
        let rays = segments();
        for (scene, passable) in [(everything(), true), (solid(), false), (glowing(), false)] {
            for structure in ["bvh:binned", "wide16"] {
                let setup = Setup {
                    structure: structure.parse().expect("a structure"),
                    ..Setup::default()
                };
                let world = World::new(&scene, &setup, &mut Vec::new()).expect("a good scene");
                let alone = |ray: &Ray| {
                    world.layout.structure().closest_hit_where(ray, &mut |hit| {
                        !world.has_holes(triangle(hit)) || world.coverage(hit) > LEAST_COVERAGE
                    })
                };
                let hits: Vec<_> = rays.iter().map(alone).collect();
                assert!(world.closest_each(&rays) == hits, "{structure}");

                // The last triangles are those that glow, where any do.
                let lamp = (0, world.layout.laid_out_triangles() - 1);
                for lamp in [None, Some(lamp)] {
                    let shadow = |(i, &ray): (usize, &Ray)| Shadow {
                        ray: (i % 7 != 0).then_some(ray),
                        lamp: lamp.filter(|_| i % 2 == 0),
                        light: Vec3::new(1.0, 2.0, 0.5),
                    };
                    let mut shadows: Vec<Shadow> = rays.iter().enumerate().map(shadow).collect();
                    world.darken(&mut shadows);
                    let mut counts = [0; 3];
                    for (found, open) in shadows.iter().zip(rays.iter().enumerate().map(shadow)) {
                        let through = open
                            .ray
                            .map_or(WHITE, |ray| world.light_through(&ray, open.lamp));
                        assert_eq!(found.light, open.light * through, "{structure}");
                        let kind = [WHITE, Vec3::ZERO].iter().position(|x| *x == through);
                        counts[kind.unwrap_or(2)] += 1;
                    }
                    let [lit, dark, tinted] = counts;
                    assert!(lit > 100 && dark > 100, "{counts:?}");
                    assert_eq!(tinted > 20, passable, "{counts:?}");
                }
            }
        }
    }
}
