//! Two sets as one, so that different shapes share a structure.

use super::{Primitives, Surfaces};
use crate::geometry::shape::ShapeError;
use crate::geometry::{Aabb, Hit, PreparedRay, Ray, Surface, Vec3};
use crate::query::{Counters, Query};
use core::ops::ControlFlow;

/// The primitives of `A`, then those of `B`, numbered through: the first of `B` has the number `a.len()`. Chains nest.
///
/// ```
/// use boxwood::{Bvh, BinnedSah, Chain, Intersect, Ray, Shapes, Sphere, Torus};
/// let spheres = Shapes::new([Sphere::new([0.0, 0.0, 9.0], 1.0)])?;
/// let tori = Shapes::new([Torus::new([0.0, 0.0, 5.0], [1.0, 0.0, 0.0], 2.0, 0.5)])?;
/// let both = Chain::new(spheres, tori)?;
/// let bvh = Bvh::new(&both, BinnedSah::default().build(&both));
/// let hits = bvh.all_hits(&Ray::new([0.0; 3], [0.0, 0.0, 1.0]));
/// let seen: Vec<_> = hits.iter().map(|hit| (hit.t, hit.primitive)).collect();
/// assert_eq!(seen, [(2.5, 1), (3.5, 1), (6.5, 1), (7.5, 1), (8.0, 0), (10.0, 0)]);
/// # Ok::<(), boxwood::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Chain<A, B> {
    a: A,
    b: B,
}

impl<A: Primitives, B: Primitives> Chain<A, B> {
    /// Joins two sets.
    ///
    /// # Errors
    /// When there are more than can be numbered.
    pub fn new(a: A, b: B) -> Result<Self, ShapeError> {
        let count = a.len().saturating_add(b.len());
        if count >= u32::MAX as usize {
            return Err(ShapeError::TooMany(count));
        }
        Ok(Self { a, b })
    }
    /// The first set.
    pub fn first(&self) -> &A {
        &self.a
    }
    /// The second set.
    pub fn second(&self) -> &B {
        &self.b
    }
}

impl<A: Primitives, B: Primitives> Primitives for Chain<A, B> {
    #[inline]
    fn len(&self) -> usize {
        self.a.len() + self.b.len()
    }
    #[inline]
    fn bounds(&self, i: usize) -> Aabb {
        match i.checked_sub(self.a.len()) {
            None => self.a.bounds(i),
            Some(i) => self.b.bounds(i),
        }
    }
    fn clipped_bounds(&self, i: usize, within: &Aabb) -> Aabb {
        match i.checked_sub(self.a.len()) {
            None => self.a.clipped_bounds(i, within),
            Some(i) => self.b.clipped_bounds(i, within),
        }
    }
    fn overlaps(&self, i: usize, within: &Aabb) -> bool {
        match i.checked_sub(self.a.len()) {
            None => self.a.overlaps(i, within),
            Some(i) => self.b.overlaps(i, within),
        }
    }
    fn object_end(&self, i: usize) -> usize {
        let before = self.a.len();
        match i.checked_sub(before) {
            None => self.a.object_end(i).min(before),
            Some(i) => before + self.b.object_end(i),
        }
    }
    fn corners(&self, i: usize) -> Option<[Vec3; 3]> {
        match i.checked_sub(self.a.len()) {
            None => self.a.corners(i),
            Some(i) => self.b.corners(i),
        }
    }
    #[inline]
    fn mask(&self, i: usize) -> u32 {
        match i.checked_sub(self.a.len()) {
            None => self.a.mask(i),
            Some(i) => self.b.mask(i),
        }
    }
    #[inline]
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        match i.checked_sub(self.a.len()) {
            None => self.a.offer(i, ray, query, counters),
            Some(i) => {
                let by = self.a.len() as u32;
                self.b
                    .offer(i, ray, &mut Renumbered { by, query }, counters)
            }
        }
    }
    // Where only one of the two is proven, both are asked: the proof says that nothing is lost by that.
    const WITHIN_SLACK: bool = A::WITHIN_SLACK && B::WITHIN_SLACK;
}

impl<A: Surfaces, B: Surfaces> Surfaces for Chain<A, B> {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let before = self.a.len() as u32;
        match hit.primitive.checked_sub(before) {
            None => self.a.surface(ray, hit),
            Some(primitive) => self.b.surface(ray, &Hit { primitive, ..*hit }),
        }
    }
}

/// A query that sees later numbers than the primitives know.
struct Renumbered<'a, Q> {
    by: u32,
    query: &'a mut Q,
}

impl<Q: Query> Query for Renumbered<'_, Q> {
    const ORDERED: bool = Q::ORDERED;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.query.t_max()
    }
    #[inline(always)]
    fn mask(&self) -> u32 {
        self.query.mask()
    }
    #[inline(always)]
    fn time(&self) -> f32 {
        self.query.time()
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        let primitive = hit.primitive + self.by;
        self.query.offer(Hit { primitive, ..hit })
    }
}
