//! The judge: a loop over everything. Never optimise it.
//!
//! *Cost.* One test per primitive and ray; no memory. Whatever a structure answers, this is what it must equal.

use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::Statistics;
use crate::primitive::{self, Primitives};
use crate::query::{Counters, Query, Traverse};

/// Tests every primitive against every ray.
#[derive(Clone, Copy, Debug)]
pub struct BruteForce<P> {
    primitives: P,
    bounds: Aabb,
}

impl<P: Primitives> BruteForce<P> {
    /// Looks at every primitive once, for the bounds.
    pub fn new(primitives: P) -> Self {
        let bounds = primitive::bounds_of(&primitives);
        Self { primitives, bounds }
    }
}

impl<P: Primitives> Traverse for BruteForce<P> {
    fn bounds(&self) -> Aabb {
        self.bounds
    }
    fn statistics(&self) -> Statistics {
        Statistics::exhaustive(self.primitives.len())
    }
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let Some(ray) = PreparedRay::new(ray, self.bounds.scale()) else {
            return;
        };
        for i in 0..self.primitives.len() {
            if primitive::offer(&self.primitives, i, &ray, query, counters).is_break() {
                return;
            }
        }
    }
}
