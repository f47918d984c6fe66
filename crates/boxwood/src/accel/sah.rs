//! The surface-area heuristic: what a ray is expected to pay (Goldsmith & Salmon 1987, MacDonald & Booth 1990).
//!
//! A random line that meets a box meets a smaller box inside it with the probability of the ratio of their areas. So the
//! expected cost of a tree is a sum over its nodes, each weighted with its area over the root's.

use crate::geometry::Aabb;

/// What opening a node costs, in units of one primitive test.
pub const NODE_COST: f32 = 1.0;
/// What testing a primitive costs.
pub const PRIMITIVE_COST: f32 = 1.0;

/// Half the surface of a box, in double precision, where squares of 1e30 and 1e-30 are numbers; zero when empty.
pub(crate) fn half_area(b: &Aabb) -> f64 {
    let d = |axis: usize| (f64::from(b.upper[axis]) - f64::from(b.lower[axis])).max(0.0);
    d(0) * d(1) + d(1) * d(2) + d(2) * d(0)
}
