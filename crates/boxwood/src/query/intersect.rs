//! The object-safe face of a structure.

use super::batch::each_chunk;
use super::{AllHits, Closest, FirstHits, Occluded, Part, Query, Seen, TraversalStats, Traverse};
use crate::geometry::{Aabb, Hit, Ray};
use crate::inspect::{Cell, Event, Explained, Statistics};
use crate::simd::exactly;
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Break, Continue};

/// What every structure answers, whatever its type: `Box<dyn Intersect>` holds any of them.
///
/// The queries in it are a closed set: that bounds how many loops are compiled. A question outside the set goes through
/// [`Intersect::visit`] or, when the type is known, through [`Traverse`].
///
/// Everything here is answered in the float mode that exact answers need, whatever mode the caller's thread is in (see
/// [`exactly`](crate::exactly)); so closures that are passed in run in it too.
///
/// The batch calls take slices of rays and run in the caller's rayon pool (`pool.install(|| …)` chooses another one, a
/// pool of one thread included) when the feature `parallel` is on; the answers do not depend on the threads. Up to 2048 rays stay
/// on the caller's thread.
pub trait Intersect: Send + Sync {
    /// Around all primitives; [`Aabb::EMPTY`] when there are none.
    fn bounds(&self) -> Aabb;
    /// What the structure is made of and what it should cost.
    fn statistics(&self) -> Statistics;
    /// Shows every node and cell, parents before their children: for drawings and histograms.
    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>));
    /// Everything that happens to a ray in search of its nearest hit, in order.
    fn explain(&self, ray: &Ray) -> Vec<Event>;
    /// The nearest hit; `None` when there is none.
    fn closest_hit(&self, ray: &Ray) -> Option<Hit>;
    /// Is anything in the ray's interval?
    fn occluded(&self, ray: &Ray) -> bool;
    /// All hits, nearest first, each once.
    fn all_hits(&self, ray: &Ray) -> Vec<Hit>;
    /// The first `k` hits, nearest first, each once.
    fn first_hits(&self, ray: &Ray, k: usize) -> Vec<Hit>;
    /// [`Intersect::closest_hit`], adding its steps to `stats`.
    fn closest_hit_counted(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<Hit>;
    /// [`Intersect::occluded`], adding its steps to `stats`.
    fn occluded_counted(&self, ray: &Ray, stats: &mut TraversalStats) -> bool;
    /// [`Intersect::all_hits`], adding its steps to `stats`.
    fn all_hits_counted(&self, ray: &Ray, stats: &mut TraversalStats) -> Vec<Hit>;
    /// [`Intersect::closest_hit`] among the primitives whose mask shares a bit with `mask`, at a moment (which primitives
    /// that move make sense of).
    fn closest_hit_seen(&self, ray: &Ray, mask: u32, time: f32) -> Option<Hit>;
    /// [`Intersect::occluded`] by those primitives, at a moment.
    fn occluded_seen(&self, ray: &Ray, mask: u32, time: f32) -> bool;
    /// Shows hits to `visit` in no particular order, perhaps some of them twice, until it breaks; its value, when it is `Continue`, is the new end of
    /// the interval.
    fn visit(&self, ray: &Ray, visit: &mut dyn FnMut(Hit) -> ControlFlow<(), f32>);
    /// Shows what a part of the structure consists of, as [`Traverse::parts`] does.
    fn parts(&self, of: Part, show: &mut dyn FnMut(Aabb, Part));
    /// [`Intersect::visit`] with all that a query and its counters say: how a structure within another one is asked. As with
    /// [`Traverse::traverse`], the float mode is the caller's business, who has seen to it for the outer one.
    fn relay(&self, ray: &Ray, asked: Relay<'_>);
    /// [`Intersect::closest_hit`] for many rays.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]);
    /// [`Intersect::occluded`] for many rays.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]);
    /// [`Intersect::occluded_each`], with the (instance, primitive) of one that is in each ray's interval. Which one depends on the
    /// structure: for callers that ask again where it is one that light passes.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn occluders(&self, rays: &[Ray], occluders: &mut [Option<(u32, u32)>]);

    /// The nearest hit that `keep` accepts: cut-outs, back-face culling. `keep` may be asked about any hit in the
    /// interval, in any order, so it must not depend on what it was asked before.
    fn closest_hit_where(&self, ray: &Ray, keep: &mut dyn FnMut(&Hit) -> bool) -> Option<Hit> {
        exactly(|| {
            let mut query = Closest::new(ray);
            self.visit(ray, &mut |hit| {
                if keep(&hit) {
                    query.offer(hit).map_continue(|()| query.t_max())
                } else {
                    Continue(query.t_max())
                }
            });
            query.hit()
        })
    }

    /// Is anything that `keep` accepts in the ray's interval?
    fn occluded_where(&self, ray: &Ray, keep: &mut dyn FnMut(&Hit) -> bool) -> bool {
        let mut found = false;
        self.visit(ray, &mut |hit| {
            found = keep(&hit);
            if found {
                Break(())
            } else {
                Continue(ray.t_max)
            }
        });
        found
    }
}

/// A query and its counters in a form that passes through [`Intersect`].
pub struct Relay<'a> {
    /// Which part of the structure is asked.
    pub part: Part,
    /// As [`Query::ORDERED`].
    pub ordered: bool,
    /// As [`Query::mask`].
    pub mask: u32,
    /// As [`Query::time`].
    pub time: f32,
    /// Where steps are added up, when anybody counts them.
    pub stats: Option<&'a mut TraversalStats>,
    /// As in [`Intersect::visit`].
    pub visit: &'a mut dyn FnMut(Hit) -> ControlFlow<(), f32>,
}

/// Rays per chunk of a batch: enough to keep many in flight nearly all of the time, few enough for the second-level cache.
pub(super) const CHUNK: usize = 2048;

impl<T: Traverse + Send + Sync> Intersect for T {
    fn bounds(&self) -> Aabb {
        Traverse::bounds(self)
    }
    fn statistics(&self) -> Statistics {
        exactly(|| Traverse::statistics(self))
    }
    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        exactly(|| Traverse::cells(self, show));
    }
    fn explain(&self, ray: &Ray) -> Vec<Event> {
        let explained = Explained::default();
        let query = explained.query(Closest::new(ray));
        exactly(|| ask(self, ray, query, &mut explained.counters(), |_| ()));
        explained.events()
    }
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        exactly(|| ask(self, ray, Closest::new(ray), &mut (), Closest::hit))
    }
    fn occluded(&self, ray: &Ray) -> bool {
        exactly(|| ask(self, ray, Occluded::new(ray), &mut (), Occluded::found))
    }
    fn all_hits(&self, ray: &Ray) -> Vec<Hit> {
        exactly(|| show::<true, _>(self, ray, AllHits::new(ray), &mut ()).sorted())
    }
    fn first_hits(&self, ray: &Ray, k: usize) -> Vec<Hit> {
        exactly(|| show::<true, _>(self, ray, FirstHits::new(ray, k), &mut ()).sorted())
    }
    fn closest_hit_counted(&self, ray: &Ray, stats: &mut TraversalStats) -> Option<Hit> {
        exactly(|| show::<true, _>(self, ray, Closest::new(ray), stats).hit())
    }
    fn occluded_counted(&self, ray: &Ray, stats: &mut TraversalStats) -> bool {
        exactly(|| show::<false, _>(self, ray, Occluded::new(ray), stats).found())
    }
    fn all_hits_counted(&self, ray: &Ray, stats: &mut TraversalStats) -> Vec<Hit> {
        exactly(|| show::<true, _>(self, ray, AllHits::new(ray), stats).sorted())
    }
    fn closest_hit_seen(&self, ray: &Ray, mask: u32, time: f32) -> Option<Hit> {
        exactly(|| {
            let inner = Closest::new(ray);
            let seen = show::<true, _>(self, ray, Seen { inner, mask, time }, &mut ());
            seen.inner.hit()
        })
    }
    fn occluded_seen(&self, ray: &Ray, mask: u32, time: f32) -> bool {
        exactly(|| {
            let inner = Occluded::new(ray);
            let seen = show::<true, _>(self, ray, Seen { inner, mask, time }, &mut ());
            seen.inner.found()
        })
    }
    fn visit(&self, ray: &Ray, visit: &mut dyn FnMut(Hit) -> ControlFlow<(), f32>) {
        exactly(|| {
            let mut query = Visit::<true> {
                t_max: ray.end(),
                mask: u32::MAX,
                time: 0.0,
                visit,
            };
            self.traverse(ray, &mut query, &mut ());
        });
    }
    fn parts(&self, of: Part, show: &mut dyn FnMut(Aabb, Part)) {
        exactly(|| Traverse::parts(self, of, show));
    }
    fn relay(&self, ray: &Ray, asked: Relay<'_>) {
        if asked.ordered {
            relay::<true>(self, ray, asked);
        } else {
            relay::<false>(self, ray, asked);
        }
    }
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one hit per ray");
        each_chunk(CHUNK, rays, hits, |rays, hits| {
            ask_each(self, rays, hits, Closest::new, Closest::hit);
        });
    }
    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer per ray");
        each_chunk(CHUNK, rays, occluded, |rays, occluded| {
            ask_each(self, rays, occluded, Occluded::new, Occluded::found);
        });
    }
    fn occluders(&self, rays: &[Ray], occluders: &mut [Option<(u32, u32)>]) {
        assert_eq!(rays.len(), occluders.len(), "one answer per ray");
        each_chunk(CHUNK, rays, occluders, |rays, occluders| {
            ask_each(self, rays, occluders, Occluded::new, Occluded::occluder);
        });
    }
}

#[inline(always)]
fn ask<Q: Query, A>(
    structure: &impl Traverse,
    ray: &Ray,
    mut query: Q,
    counters: &mut impl super::Counters,
    answer: impl Fn(&Q) -> A,
) -> A {
    structure.traverse(ray, &mut query, counters);
    // From where it lies: a query that moves is copied in larger pieces than it was written in, which waits.
    answer(&query)
}

/// The same through [`Visit`], with `ORDERED` as its hint: one loop is compiled for all the questions that are asked less
/// often than those for which a call at each hit would be dear.
fn show<const ORDERED: bool, Q: Query>(
    structure: &impl Traverse,
    ray: &Ray,
    mut query: Q,
    counters: &mut impl super::Counters,
) -> Q {
    let mut visit = Visit::<ORDERED> {
        t_max: query.t_max(),
        mask: query.mask(),
        time: query.time(),
        visit: &mut |hit| query.offer(hit).map_continue(|()| query.t_max()),
    };
    structure.traverse(ray, &mut visit, counters);
    query
}

fn relay<const ORDERED: bool>(structure: &impl Traverse, ray: &Ray, asked: Relay<'_>) {
    let mut visit = Visit::<ORDERED> {
        t_max: ray.end(),
        mask: asked.mask,
        time: asked.time,
        visit: asked.visit,
    };
    match asked.stats {
        None => structure.traverse_part(asked.part, ray, &mut visit, &mut ()),
        Some(stats) => structure.traverse_part(asked.part, ray, &mut visit, stats),
    }
}

/// At most [`CHUNK`] rays through [`Traverse::traverse_each`].
fn ask_each<Q: Query, A>(
    structure: &impl Traverse,
    rays: &[Ray],
    answers: &mut [A],
    question: impl Fn(&Ray) -> Q,
    answer: impl Fn(&Q) -> A,
) {
    let mut queries: Vec<Q> = rays.iter().map(question).collect();
    structure.traverse_each(rays, &mut queries, &mut ());
    for (place, query) in answers.iter_mut().zip(&queries) {
        *place = answer(query);
    }
}

/// A query whose mind is a closure.
struct Visit<'a, const ORDERED: bool> {
    t_max: f32,
    mask: u32,
    time: f32,
    visit: &'a mut dyn FnMut(Hit) -> ControlFlow<(), f32>,
}

impl<const ORDERED: bool> Query for Visit<'_, ORDERED> {
    const ORDERED: bool = ORDERED;
    fn t_max(&self) -> f32 {
        self.t_max
    }
    fn mask(&self) -> u32 {
        self.mask
    }
    fn time(&self) -> f32 {
        self.time
    }
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        // `min`: the interval never grows, whatever the closure says.
        (self.visit)(hit).map_continue(|t_max| self.t_max = self.t_max.min(t_max))
    }
}
