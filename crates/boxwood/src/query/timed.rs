//! Any structure asked at a moment, or each ray at one of its own.
//!
//! *How it works.* The moment belongs to the question ([`Query::time`]), so a ray stays what it is, and structures over things that rest
//! know nothing of it.

use super::intersect::CHUNK;
use super::{Closest, Counters, Occluded, Query, Seen, Traverse, each_pair};
use crate::geometry::{Aabb, Hit, Ray};
use crate::inspect::{Cell, Statistics};
use alloc::vec::Vec;

/// Questions at a moment, for structures over primitives that move, such as a [`MovingMesh`](crate::MovingMesh).
///
/// ```
/// use boxwood::{Intersect, MovingMesh, Ray, Timed, TriangleMesh, WideSah};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let first = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
/// let mesh = MovingMesh::new(first, [corners.map(|[x, y, _]| [x, y, 4.0])])?;
/// let bvh = WideSah::<8>::default().build_moving(&mesh);
///
/// let ray = Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]);
/// assert!(bvh.at(1.0).closest_hit(&ray).is_some_and(|hit| hit.t == 5.0));
///
/// let mut hits = [None; 2];
/// bvh.closest_hits_at(&[ray; 2], &[0.0, 0.5], &mut hits);
/// assert_eq!(hits.map(|hit| hit.map(|hit| hit.t)), [Some(1.0), Some(3.0)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Timed: Traverse {
    /// The structure as it is at a moment: all of [`Intersect`](super::Intersect) and [`Traverse`] can be asked of it.
    fn at(&self, time: f32) -> At<'_, Self> {
        At {
            structure: self,
            time,
        }
    }

    /// The nearest hit of each ray at its own time; with threads as the batches of [`Intersect`](super::Intersect).
    ///
    /// # Panics
    /// When the slices differ in length.
    fn closest_hits_at(&self, rays: &[Ray], times: &[f32], hits: &mut [Option<Hit>])
    where
        Self: Sync,
    {
        ask_each_at(self, rays, times, hits, Closest::new, Closest::hit);
    }

    /// Whether anything is in each ray's interval at its own time.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn occluded_each_at(&self, rays: &[Ray], times: &[f32], occluded: &mut [bool])
    where
        Self: Sync,
    {
        ask_each_at(self, rays, times, occluded, Occluded::new, Occluded::found);
    }
}

impl<T: Traverse + ?Sized> Timed for T {}

/// A structure as it is at a moment, made by [`Timed::at`]. Whatever time a query has of its own does not count.
#[derive(Debug)]
pub struct At<'a, T: ?Sized> {
    structure: &'a T,
    time: f32,
}

impl<T: ?Sized> Clone for At<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T: ?Sized> Copy for At<'_, T> {}

impl<T: Traverse + ?Sized> Traverse for At<'_, T> {
    /// Around all that primitives go through.
    fn bounds(&self) -> Aabb {
        self.structure.bounds()
    }
    fn statistics(&self) -> Statistics {
        self.structure.statistics()
    }
    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        self.structure.cells(show);
    }
    #[inline]
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let mut query = seen(query, self.time);
        self.structure.traverse(ray, &mut query, counters);
    }
    fn traverse_each<Q: Query, C: Counters>(
        &self,
        rays: &[Ray],
        queries: &mut [Q],
        counters: &mut C,
    ) {
        let queries = queries.iter_mut().map(|query| seen(query, self.time));
        let mut queries: Vec<_> = queries.collect();
        self.structure.traverse_each(rays, &mut queries, counters);
    }
}

fn seen<Q: Query>(query: Q, time: f32) -> Seen<Q> {
    Seen {
        mask: query.mask(),
        inner: query,
        time,
    }
}

fn ask_each_at<Q: Query + Send, A: Send>(
    structure: &(impl Traverse + Sync + ?Sized),
    rays: &[Ray],
    times: &[f32],
    answers: &mut [A],
    question: impl Fn(&Ray) -> Q,
    answer: impl Fn(&Q) -> A + Sync + Send,
) {
    assert_eq!(rays.len(), times.len(), "one time per ray");
    assert_eq!(rays.len(), answers.len(), "one answer per ray");
    let asked = rays.iter().zip(times);
    let asked = asked.map(|(ray, &time)| seen(question(ray), time));
    let mut queries: Vec<Seen<Q>> = asked.collect();
    each_pair(CHUNK, &mut queries, answers, |from, queries, answers| {
        let rays = &rays[from..from + queries.len()];
        structure.traverse_each(rays, queries, &mut ());
        for (place, query) in answers.iter_mut().zip(queries) {
            *place = answer(&query.inner);
        }
    });
}
