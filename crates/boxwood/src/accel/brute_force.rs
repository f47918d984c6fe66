//! The judge: a loop over everything. Never optimise it.
//!
//! *Cost.* One test per primitive and ray; no memory. Whatever a structure answers, this is what it must equal.

use super::limits::Site;
use super::settings::{Setting, Settings};
use super::{BuildError, Limits};
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::Statistics;
use crate::primitive::{self, Primitives, Triangles};
use crate::proximity::{Hierarchy, Numbered, Opened};
use crate::query::{Counters, Intersect, Query, Traverse};
use crate::simd::exactly;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// Tests every primitive against every ray.
#[derive(Clone, Copy, Debug)]
pub struct BruteForce<P> {
    primitives: P,
    bounds: Aabb,
}

impl<P: Primitives> BruteForce<P> {
    /// Looks at every primitive once, for the bounds.
    pub fn new(primitives: P) -> Self {
        let bounds = exactly(|| primitive::bounds_of(&primitives));
        Self { primitives, bounds }
    }
}

/// The builder of [`BruteForce`]: there is nothing to set and nothing to build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exhaustive;

impl Settings for Exhaustive {
    const NAME: &'static str = "brute";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        Vec::new()
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        Site::new(limits, 1).finish(Box::new(BruteForce::new(primitives)))
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

/// One leaf: questions about space are judged as rays are.
impl<P: Triangles> Hierarchy for BruteForce<P> {
    type Primitives = P;
    type Node = ();
    fn primitives(&self) -> &P {
        &self.primitives
    }
    fn root(&self) -> Option<()> {
        Some(())
    }
    fn open(
        &self,
        (): (),
    ) -> Opened<impl Iterator<Item = (Aabb, ())>, impl Iterator<Item = Numbered>> {
        let triangle = |i| (i as u32, self.primitives.triangle(i));
        Opened::<core::iter::Empty<_>, _>::Leaf((0..self.primitives.len()).map(triangle))
    }
    fn number(&self, (): ()) -> usize {
        0
    }
}
