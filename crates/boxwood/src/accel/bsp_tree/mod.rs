//! The binary space partition: a plane in any direction divides each cell in two.
//!
//! *How it works.* A kd-tree whose planes need not follow the axes. Candidates are the sides of what lies in the cell along
//! each axis and, where few triangles are left, the planes that the triangles lie in and those through their edges at a right
//! angle to them. The cheapest by the surface-area heuristic wins, with the surfaces of the two cells that it would really
//! make: cells are convex polyhedra, cut in double precision. A primitive on one side of a plane goes to that side only; one
//! that crosses it is cut, and each part goes its way.
//!
//! Planes across an axis stay what they are in a kd-tree: one number and one multiplication. A slanted plane costs two
//! scalar products, and the heuristic knows it.
//!
//! *Cost.* The search for slanted planes is quadratic in the primitives of a cell, so only cells of
//! a few hundred are asked, and none at all above [`BspSah::limit`] primitives: there it is a kd-tree, and
//! [`BspData::is_slanted`] says so. 12 bytes a node, 24 a slanted plane, 4 a reference.
//!
//! *Source.* Fuchs, Kedem & Naylor 1980, *On Visible Surface Generation by A Priori Tree Structures*; Ize, Wald & Parker
//! 2008, *Ray Tracing with the BSP Tree*.

mod build;
mod fragment;
mod node;
mod polyhedron;
mod search;
mod traverse;

pub use {build::BspSah, node::BspData, traverse::BspTree};

/// No cell lies deeper, so a stack of this size always suffices. The root has depth 0.
pub const MAX_DEPTH: usize = 64;
