//! The surface-area heuristic: what a ray is expected to pay (Goldsmith & Salmon 1987, MacDonald & Booth 1990).
//!
//! A random line that meets a box meets a smaller box inside it with the probability of the ratio of their areas. So the
//! expected cost of a tree is a sum over its nodes, each weighted with its area over the root's.

/// What opening a node costs, in units of one primitive test.
pub const NODE_COST: f32 = 1.0;
/// What testing a primitive costs.
pub const PRIMITIVE_COST: f32 = 1.0;
