//! What a ray asks of any structure.
//!
//! *How it works.* A structure writes one loop, [`Traverse::traverse`]. It shows each primitive it reaches to a
//! [`Query`], which may shrink the interval or stop the loop, and reports its steps to [`Counters`]. [`Intersect`] is
//! the object-safe face that every structure gets for free.

mod batch;
mod counters;
mod intersect;
mod kinds;
mod part;
mod timed;

pub(crate) use batch::{each_chunk, each_pair};
pub use counters::{Counters, Step, TraversalStats, Verdict};
pub use intersect::{Intersect, Relay};
pub use kinds::{AllHits, Closest, Filter, FirstHits, Occluded, Seen};
pub use part::Part;
pub use timed::{At, Timed};

use crate::geometry::{Aabb, Hit, Ray};
use crate::inspect::{Cell, Statistics};
use core::ops::ControlFlow;

/// What a ray wants to know. A filter is a query that wraps a query.
pub trait Query {
    /// Whether near children should be visited first. Only a hint: the answer is the same without.
    const ORDERED: bool = true;
    /// Whether one hit is all it wants: the nearest one (of equally near ones the first by [`Hit::is_before`]), or, if it is
    /// not `ORDERED`, any one. Only for queries without a mask or a time. Then a structure may keep the others to itself.
    const ONE_HIT: bool = false;
    /// Nothing beyond this counts any more; never grows, and begins at the ray's own `t_max`, read as in [`Ray::end`].
    fn t_max(&self) -> f32;
    /// Only primitives whose [`mask`](crate::Primitives::mask) shares a bit with this are met. All by default.
    #[inline(always)]
    fn mask(&self) -> u32 {
        u32::MAX
    }
    /// The moment the ray is cast at, for primitives that move; 0 by default.
    #[inline(always)]
    fn time(&self) -> f32 {
        0.0
    }
    /// Receives a hit within `[t_min, t_max]`; `Break` ends the traversal.
    ///
    /// A hit may be shown more than once: a primitive may lie in several cells, and some rays are walked anew.
    fn offer(&mut self, hit: Hit) -> ControlFlow<()>;
}

impl<Q: Query> Query for &mut Q {
    const ORDERED: bool = Q::ORDERED;
    const ONE_HIT: bool = Q::ONE_HIT;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        (**self).t_max()
    }
    #[inline(always)]
    fn mask(&self) -> u32 {
        (**self).mask()
    }
    #[inline(always)]
    fn time(&self) -> f32 {
        (**self).time()
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        (**self).offer(hit)
    }
}

/// The one thing a structure writes.
///
/// Only the loop: it relies on the float mode that Rust takes for granted, and does not look at the thread's. Who calls it
/// himself on threads that flush subnormal numbers to zero does so within [`exactly`](crate::exactly); [`Intersect`] always
/// does.
pub trait Traverse {
    /// Around all primitives; [`Aabb::EMPTY`] when there are none.
    fn bounds(&self) -> Aabb;

    /// What the structure is made of and what it should cost.
    fn statistics(&self) -> Statistics;

    /// Shows every node and cell, parents before their children: for drawings and histograms. By default nothing.
    fn cells(&self, _show: &mut dyn FnMut(&Cell<'_>)) {}

    /// Shows what a part consists of, one step down: boxes around parts that have no primitive in common and together all of its primitives.
    /// By default nothing, which is right for structures in which a primitive may lie in several places.
    fn parts(&self, _of: Part, _show: &mut dyn FnMut(Aabb, Part)) {}

    /// Shows the primitives that the ray may meet to the query.
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C);

    /// The same of a part that [`Traverse::parts`] has shown; of more than that at most. By default of everything.
    fn traverse_part<Q: Query, C: Counters>(
        &self,
        _part: Part,
        ray: &Ray,
        query: &mut Q,
        counters: &mut C,
    ) {
        self.traverse(ray, query, counters);
    }

    /// One query per ray; the results are those of [`Traverse::traverse`] one by one.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn traverse_each<Q: Query, C: Counters>(
        &self,
        rays: &[Ray],
        queries: &mut [Q],
        counters: &mut C,
    ) {
        assert_eq!(rays.len(), queries.len(), "one query per ray");
        for (ray, query) in rays.iter().zip(queries) {
            self.traverse(ray, query, counters);
        }
    }
}
