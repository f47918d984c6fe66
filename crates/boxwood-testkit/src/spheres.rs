//! Spheres, as a user of the library would write them: nothing but the public traits.

use crate::Random;
use boxwood::{Aabb, Counters, Hit, PreparedRay, Primitives, Query, Vec3};
use std::ops::ControlFlow;

/// Spheres by centre and radius; bit `i % 3` of a query's mask must be set to see sphere `i`.
///
/// The centre moves by `(time, 0, 0)` for times from 0 to 1.
#[derive(Clone, Debug, Default)]
pub struct Spheres(pub Vec<(Vec3, f32)>);

impl Spheres {
    /// Some spheres; on a grid of whole numbers when `grid`, which makes them touch each other.
    pub fn random(count: usize, grid: bool, random: &mut Random) -> Self {
        let mut sphere = |_| {
            if grid {
                let centre = [(); 3].map(|()| random.below(8) as f32);
                (centre.into(), (1 + random.below(2)) as f32)
            } else {
                (random.in_cube() * 5.0, random.between(0.1, 1.0))
            }
        };
        Self((0..count).map(&mut sphere).collect())
    }
}

impl Primitives for Spheres {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, i: usize) -> Aabb {
        let (centre, radius) = self.0[i];
        let r = Vec3::splat(radius);
        Aabb::new(centre - r, centre + r + Vec3::new(1.0, 0.0, 0.0))
    }
    fn mask(&self, i: usize) -> u32 {
        1 << (i % 3)
    }
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        _: &mut C,
    ) -> ControlFlow<()> {
        let (centre, radius) = self.0[i];
        let centre = centre + Vec3::new(query.time(), 0.0, 0.0);
        let (o, d) = (ray.origin - centre, ray.direction);
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - radius * radius);
        let root = (b * b - a * c).sqrt();
        for (t, side) in [((-b - root) / a, 0.0), ((-b + root) / a, 1.0)] {
            if ray.t_min <= t && t <= query.t_max() {
                query.offer(Hit {
                    t,
                    u: side,
                    v: 0.0,
                    primitive: i as u32,
                    instance: 0,
                })?;
            }
        }
        ControlFlow::Continue(())
    }
}
