//! Whether a point is inside a closed mesh: exactly.
//!
//! *How it works.* A line from the point straight up crosses the surface. Where it leaves through a front it counts one, where
//! it enters one less; what remains is how often the surface winds around the point, a whole number. Which triangles are
//! crossed is decided by exact signs, and a point exactly below an edge or corner counts as moved by an infinitely small
//! amount, so that of all triangles there the right ones are crossed. Hence the number is not merely near the truth: for
//! every mesh without borders it *is* the winding number, whatever its triangles are like, and however it intersects itself.
//!
//! *Cost.* The boxes above the point: O(√n) for most surfaces.
//!
//! *Source.* Edelsbrunner & Mücke 1990, *Simulation of Simplicity*; Shewchuk 1997 for the signs.

use super::hierarchy::Extent;
use super::search::Search;
use crate::geometry::triangle::contact;
use crate::geometry::{Aabb, Vec3};
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Continue};

/// How a surface lies around a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Winding {
    /// How often the surface winds around the point: 1 inside a closed mesh whose fronts (from where corners run
    /// counter-clockwise) point outward, 0 outside, 2 where two such meshes overlap, −1 inside one that is turned inside out.
    ///
    /// For a point on the surface: that of a point infinitely near, in the direction `(ε, ε², ε³)`. For a mesh with borders: the crossings
    /// straight above the point; ask for the [generalised](super::Proximity::winding_number) winding number instead.
    pub number: i64,
    /// Whether the point lies on a triangle, exactly.
    pub on_surface: bool,
}

impl Winding {
    /// Whether the point belongs to the solid that the mesh bounds: on the surface, or with a number that is not zero.
    pub fn is_inside(&self) -> bool {
        self.on_surface || self.number != 0
    }
}

/// In search of what lies above a point.
#[derive(Clone, Debug)]
pub struct Crossings {
    point: Vec3,
    /// The same, and NaN for points that are nowhere.
    from: [f64; 3],
    crossed: Vec<(u32, i32)>,
    on_surface: bool,
}

impl Crossings {
    /// Above a point. Nothing is above one that is infinite or NaN.
    pub fn new(point: Vec3) -> Self {
        let from = if point.is_finite() {
            point.to_array().map(f64::from)
        } else {
            [f64::NAN; 3]
        };
        Self {
            point,
            from,
            crossed: Vec::new(),
            on_surface: false,
        }
    }
    /// What they add up to.
    pub fn winding(mut self) -> Winding {
        // Trees that cut triangles show some of them twice.
        self.crossed.sort_unstable();
        self.crossed.dedup();
        Winding {
            number: self
                .crossed
                .iter()
                .map(|&(_, turns)| i64::from(turns))
                .sum(),
            on_surface: self.on_surface,
        }
    }
}

impl Search for Crossings {
    const ORDERED: bool = false;
    fn limit(&self) -> f64 {
        f64::MAX
    }
    #[inline(always)]
    fn score(&mut self, around: &Extent, _: usize) -> f64 {
        let [x, y, z] = self.from;
        let (l, u) = (&around.lower, &around.upper);
        let below = l[0] <= x && x <= u[0] && l[1] <= y && y <= u[1] && z <= u[2];
        if below { 0.0 } else { f64::INFINITY }
    }
    #[inline(always)]
    fn offer(&mut self, primitive: u32, corners: [Vec3; 3], _: usize) -> ControlFlow<()> {
        if self.score(&Extent::of(corners), 0) == 0.0 {
            let turns = contact::crossing_above(corners, self.point);
            if turns != 0 {
                self.crossed.push((primitive, turns));
            }
            let around = Aabb::of(corners);
            self.on_surface = self.on_surface
                || (around.lower.z <= self.point.z && contact::holds(corners, self.point));
        }
        Continue(())
    }
}
