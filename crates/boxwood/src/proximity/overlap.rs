//! Which triangles reach into a region: a box, a ball, a frustum, or a region of your own.
//!
//! *How it works.* A region is asked whether a box lies outside of it, and whether a triangle reaches into it. Both are closed:
//! touching counts.
//!
//! *Cost.* O(log n + k) for small regions that hold `k` triangles.

use super::hierarchy::Extent;
use super::nearest::square;
use super::search::Search;
use crate::geometry::triangle::closest::closest;
use crate::geometry::triangle::overlap;
use crate::geometry::{Aabb, Vec3};
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Break, Continue};

/// A part of space that triangles may reach into.
///
/// What [`Region::excludes`] says must hold for every triangle in the box: where it is true of a box around a triangle,
/// [`Region::meets`] must be false of the triangle.
pub trait Region {
    /// Whether a box lies outside, for certain. A larger box may only be outside where a smaller one in it is.
    fn excludes(&self, around: &Extent) -> bool;
    /// Whether a triangle reaches into it; touching counts.
    fn meets(&self, corners: [Vec3; 3]) -> bool;
}

/// A closed box; nothing reaches into an empty one. It may be infinite.
///
/// Right up to rounding errors of 2⁻⁴⁸ of the largest coordinates (Akenine-Möller 2001).
impl Region for Aabb {
    fn excludes(&self, around: &Extent) -> bool {
        self.is_empty() || !Extent::new(self, 0.0).overlaps(around)
    }
    fn meets(&self, corners: [Vec3; 3]) -> bool {
        // Only the common part counts, and it is finite.
        overlap::overlaps(corners, &self.intersection(Aabb::of(corners)))
    }
}

/// A solid ball, closed. Nothing reaches into one whose radius is negative or NaN, or whose centre is infinite or NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// The centre, world space.
    pub centre: Vec3,
    /// The radius, world units; may be infinite.
    pub radius: f32,
}

impl Ball {
    /// A ball from its centre and radius.
    pub fn new(centre: impl Into<[f32; 3]>, radius: f32) -> Self {
        Self {
            centre: centre.into().into(),
            radius,
        }
    }
    fn holds(&self, distance_squared: f64) -> bool {
        self.centre.is_finite() && distance_squared <= square(self.radius)
    }
    fn centre(&self) -> [f64; 3] {
        self.centre.to_array().map(f64::from)
    }
}

/// The triangles are those that [`within`](super::Proximity::within) the same radius of the centre.
impl Region for Ball {
    fn excludes(&self, around: &Extent) -> bool {
        !self.holds(around.distance_squared(self.centre()))
    }
    fn meets(&self, corners: [Vec3; 3]) -> bool {
        self.holds(closest(corners, self.centre()).square)
    }
}

/// In search of all triangles that reach into a region.
#[derive(Clone, Debug)]
pub struct Overlapping<'r, R> {
    region: &'r R,
    /// After how many the search ends.
    most: usize,
    found: Vec<u32>,
}

impl<'r, R: Region> Overlapping<'r, R> {
    /// All of them.
    pub fn new(region: &'r R) -> Self {
        Self {
            region,
            most: usize::MAX,
            found: Vec::new(),
        }
    }
    /// Until one is found. Which one depends on the tree.
    pub fn any(region: &'r R) -> Self {
        Self {
            most: 1,
            ..Self::new(region)
        }
    }
    /// Their numbers, in ascending order.
    pub fn found(mut self) -> Vec<u32> {
        self.found.sort_unstable();
        self.found.dedup();
        self.found
    }
}

impl<R: Region> Search for Overlapping<'_, R> {
    const ORDERED: bool = false;
    fn limit(&self) -> f64 {
        f64::MAX
    }
    fn score(&mut self, around: &Extent, _: usize) -> f64 {
        if self.region.excludes(around) {
            f64::INFINITY
        } else {
            0.0
        }
    }
    fn offer(&mut self, primitive: u32, corners: [Vec3; 3], _: usize) -> ControlFlow<()> {
        if !self.region.excludes(&Extent::of(corners)) && self.region.meets(corners) {
            self.found.push(primitive);
            if self.found.len() == self.most {
                return Break(());
            }
        }
        Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_that_never_end() {
        let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Vec3::from);
        let (inf, nan) = (f32::INFINITY, f32::NAN);
        for (from, expected) in [(1.0, true), (2.0, true), (2.1, false)] {
            assert!(!Aabb::new([from; 3], [inf; 3]).meets(t), "{from}");
            assert_eq!(
                Aabb::new([from, from, -inf], [inf; 3]).meets(t),
                expected,
                "{from}"
            );
        }
        assert!(Aabb::new([-inf; 3], [inf; 3]).meets(t));
        assert!(Aabb::new([nan; 3], [inf; 3]).excludes(&Extent::of(t)));
        assert!(Aabb::EMPTY.excludes(&Extent::of(t)));
    }

    #[test]
    fn balls_of_any_radius() {
        let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Vec3::from);
        for (z, radius, expected) in [
            (2.0, 2.0, true),
            (2.0, 1.9, false),
            (0.0, 0.0, true),
            (f32::MAX, f32::INFINITY, true),
            (0.0, -1.0, false),
            (0.0, f32::NAN, false),
            (f32::NAN, 1.0, false),
            (f32::INFINITY, f32::INFINITY, false),
        ] {
            let ball = Ball::new([1.0, 1.0, z], radius);
            let met = !ball.excludes(&Extent::of(t)) && ball.meets(t);
            assert_eq!(met, expected, "{ball:?}");
        }
    }
}
