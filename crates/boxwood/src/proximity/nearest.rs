//! The closest point, the `k` closest triangles, and all within a radius.
//!
//! *How it works.* The score of a box is the square of its distance, and the limit that of what is farthest among what
//! counts: the best so far, the `k`-th best, or the radius. Triangles at equal distance are told apart by their numbers.
//!
//! *Cost.* O(log n) boxes for a point near the surface; up to O(n) for one that is equally far from everything, such as
//! the centre of a sphere.
//!
//! *Source.* Roussopoulos, Kelley & Vincent 1995, *Nearest Neighbor Queries*.

use super::hierarchy::Extent;
use super::search::Search;
use crate::geometry::Vec3;
use crate::geometry::triangle::closest::{Nearest as Found, closest};
use crate::math::sqrt_f64;
use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Continue};

/// The point of a triangle that is closest to where it was asked from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The distance, world units, rounded to the nearest float; infinite where it is beyond the floats.
    pub distance: f32,
    /// The point, world space, rounded to the nearest floats.
    pub point: Vec3,
    /// Weight of vertex 1 of the triangle.
    pub u: f32,
    /// Weight of vertex 2.
    pub v: f32,
    /// The triangle.
    pub primitive: u32,
}

impl ClosestPoint {
    fn new(found: &Found, primitive: u32) -> Self {
        Self {
            distance: sqrt_f64(found.square) as f32,
            point: Vec3::from(found.point.map(|x| x as f32)),
            u: found.u as f32,
            v: found.v as f32,
            primitive,
        }
    }
}

/// Where a question about distances is asked from; `None` for a point that is at no distance from anything.
fn origin(point: Vec3) -> Option<[f64; 3]> {
    point.is_finite().then(|| point.to_array().map(f64::from))
}

/// The square of a radius, exactly; −1 for none.
pub(super) fn square(radius: f32) -> f64 {
    if radius >= 0.0 {
        // An infinite radius reaches everything.
        (f64::from(radius) * f64::from(radius)).min(f64::MAX)
    } else {
        -1.0
    }
}

/// In search of the closest point; of several triangles at one distance the one with the lowest number.
#[derive(Clone, Debug)]
pub struct Closest {
    from: [f64; 3],
    limit: f64,
    best: Option<(Found, u32)>,
}

impl Closest {
    /// As seen from `point`, no farther than `radius` (world units, closed interval). Nothing is found where the point is
    /// infinite or NaN, or the radius negative or NaN.
    pub fn new(point: Vec3, radius: f32) -> Self {
        let origin = origin(point);
        Self {
            from: origin.unwrap_or_default(),
            limit: origin.map_or(-1.0, |_| square(radius)),
            best: None,
        }
    }
    /// What was found.
    pub fn found(&self) -> Option<ClosestPoint> {
        let (found, primitive) = self.best?;
        Some(ClosestPoint::new(&found, primitive))
    }
}

/// The closest point of a triangle, if the square of its distance is within the limit.
#[inline(always)]
fn no_farther(corners: [Vec3; 3], from: [f64; 3], limit: f64) -> Option<Found> {
    // Less work than the triangle, and most end here.
    if !(Extent::of(corners).distance_squared(from) <= limit) {
        return None;
    }
    let found = closest(corners, from);
    (found.square <= limit).then_some(found)
}

impl Search for Closest {
    #[inline(always)]
    fn limit(&self) -> f64 {
        self.limit
    }
    #[inline(always)]
    fn score(&mut self, around: &Extent, _: usize) -> f64 {
        around.distance_squared(self.from)
    }
    #[inline(always)]
    fn offer(&mut self, primitive: u32, corners: [Vec3; 3], _: usize) -> ControlFlow<()> {
        let lower = |&(_, best): &(Found, u32)| primitive < best;
        if let Some(found) = no_farther(corners, self.from, self.limit)
            && (found.square < self.limit || self.best.as_ref().is_none_or(lower))
        {
            (self.limit, self.best) = (found.square, Some((found, primitive)));
        }
        Continue(())
    }
}

/// In search of the `k` closest triangles.
#[derive(Clone, Debug)]
pub struct Nearest {
    from: [f64; 3],
    k: usize,
    limit: f64,
    /// By the bits of the square, which ascend with it, and the number; so a triangle that is shown again changes nothing.
    best: BTreeMap<(u64, u32), Found>,
}

impl Nearest {
    /// As seen from `point`, no farther than `radius`; see [`Closest::new`].
    pub fn new(point: Vec3, k: usize, radius: f32) -> Self {
        let origin = origin(point).filter(|_| k > 0);
        Self {
            from: origin.unwrap_or_default(),
            k,
            limit: origin.map_or(-1.0, |_| square(radius)),
            best: BTreeMap::new(),
        }
    }
    /// What was found, nearest first; of triangles at one distance the one with the lower number first.
    pub fn found(&self) -> Vec<ClosestPoint> {
        let best = self.best.iter();
        best.map(|(&(_, primitive), found)| ClosestPoint::new(found, primitive))
            .collect()
    }
}

impl Search for Nearest {
    #[inline(always)]
    fn limit(&self) -> f64 {
        self.limit
    }
    #[inline(always)]
    fn score(&mut self, around: &Extent, _: usize) -> f64 {
        around.distance_squared(self.from)
    }
    fn offer(&mut self, primitive: u32, corners: [Vec3; 3], _: usize) -> ControlFlow<()> {
        if let Some(found) = no_farther(corners, self.from, self.limit) {
            self.best.insert((found.square.to_bits(), primitive), found);
            if self.best.len() > self.k {
                self.best.pop_last();
            }
            // Only once there are `k` of them, what is as far as the last one may still have a lower number.
            if let Some((&(farthest, _), _)) = self.best.last_key_value()
                && self.best.len() == self.k
            {
                self.limit = f64::from_bits(farthest);
            }
        }
        Continue(())
    }
}

/// In search of all triangles within a radius.
#[derive(Clone, Debug)]
pub struct Within {
    from: [f64; 3],
    limit: f64,
    all: Vec<(Found, u32)>,
}

impl Within {
    /// As seen from `point`, no farther than `radius`; see [`Closest::new`].
    pub fn new(point: Vec3, radius: f32) -> Self {
        let Closest { from, limit, .. } = Closest::new(point, radius);
        Self {
            from,
            limit,
            all: Vec::new(),
        }
    }
    /// What was found, nearest first; of triangles at one distance the one with the lower number first.
    pub fn found(mut self) -> Vec<ClosestPoint> {
        let order = |a: &(Found, u32), b: &(Found, u32)| {
            (a.0.square.total_cmp(&b.0.square)).then(a.1.cmp(&b.1))
        };
        self.all.sort_unstable_by(order);
        self.all.dedup_by_key(|(_, primitive)| *primitive);
        let points = self.all.iter();
        points
            .map(|(found, primitive)| ClosestPoint::new(found, *primitive))
            .collect()
    }
}

impl Search for Within {
    const ORDERED: bool = false;
    #[inline(always)]
    fn limit(&self) -> f64 {
        self.limit
    }
    #[inline(always)]
    fn score(&mut self, around: &Extent, _: usize) -> f64 {
        around.distance_squared(self.from)
    }
    #[inline(always)]
    fn offer(&mut self, primitive: u32, corners: [Vec3; 3], _: usize) -> ControlFlow<()> {
        if let Some(found) = no_farther(corners, self.from, self.limit) {
            self.all.push((found, primitive));
        }
        Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f32; 3]; 3]) -> [Vec3; 3] {
        corners.map(Vec3::from)
    }

    fn ask(t: [Vec3; 3], p: [f32; 3]) -> ClosestPoint {
        let mut search = Closest::new(Vec3::from(p), f32::INFINITY);
        let _ = search.offer(7, t, 0);
        search
            .found()
            .expect("everything is within an infinite radius")
    }

    #[test]
    fn all_regions_of_a_triangle() {
        let t = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        for (from, to, distance) in [
            ([1.0, 1.0, 3.0], [1.0, 1.0, 0.0], 3.0),
            ([1.0, 1.0, 0.0], [1.0, 1.0, 0.0], 0.0),
            ([-3.0, -4.0, 0.0], [0.0, 0.0, 0.0], 5.0),
            ([7.0, -4.0, 0.0], [4.0, 0.0, 0.0], 5.0),
            ([-3.0, 8.0, 0.0], [0.0, 4.0, 0.0], 5.0),
            ([2.0, -3.0, 4.0], [2.0, 0.0, 0.0], 5.0),
            ([-3.0, 1.0, 4.0], [0.0, 1.0, 0.0], 5.0),
            ([4.0, 4.0, 1.0], [2.0, 2.0, 0.0], 3.0),
        ] {
            let found = ask(t, from);
            assert_eq!(
                (found.point, found.distance, found.primitive),
                (Vec3::from(to), distance, 7)
            );
            let weighed = t[0] * (1.0 - found.u - found.v) + t[1] * found.u + t[2] * found.v;
            assert!((weighed - found.point).length() < 1.0e-6, "{found:?}");
        }
    }

    #[test]
    fn triangles_without_area_are_segments_and_points() {
        let segment = triangle([[0.0; 3], [3.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(
            ask(segment, [2.0, 1.0, 0.0]).point,
            Vec3::new(2.0, 0.0, 0.0)
        );
        assert_eq!(
            ask(segment, [9.0, 0.0, 0.0]).point,
            Vec3::new(3.0, 0.0, 0.0)
        );
        let point = triangle([[1.0; 3]; 3]);
        assert_eq!(ask(point, [1.0, 1.0, 3.0]).distance, 2.0);
        let huge = triangle([[-f32::MAX; 3], [f32::MAX; 3], [f32::MAX, 0.0, 0.0]]);
        assert_eq!(ask(huge, [0.0; 3]).distance, 0.0);
    }

    #[test]
    fn nothing_is_near_nowhere() {
        let t = triangle([[0.0; 3]; 3]);
        let offered = |mut search: Closest| {
            let _ = search.offer(0, t, 0);
            search.found().map(|found| found.distance)
        };
        let at = |x: f32| Vec3::new(x, 0.0, 0.0);
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(offered(Closest::new(at(x), f32::INFINITY)), None);
        }
        for (radius, found) in [
            (1.0, Some(1.0)),
            (0.99, None),
            (-1.0, None),
            (f32::NAN, None),
        ] {
            assert_eq!(offered(Closest::new(at(1.0), radius)), found);
        }
        assert_eq!(offered(Closest::new(at(0.0), 0.0)), Some(0.0));
        assert_eq!(offered(Closest::new(at(0.0), -0.0)), Some(0.0));
        assert!(offered(Closest::new(at(f32::MAX), f32::INFINITY)).is_some());
    }
}
