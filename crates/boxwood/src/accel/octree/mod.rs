//! The octree: a cell that holds too much is halved along every axis at once.
//!
//! *How it works.* The root is a cube around everything. A cell with more than a leaf's worth of primitives becomes eight
//! cells of half the size (four, or two, where some axes may not be divided), each with those primitives that really
//! overlap it; so a primitive may be in several. Children that hold nothing are not stored: a mask of eight bits in the node
//! says which exist, and those lie side by side. A cell is not divided where that separates nothing: the expected cost of
//! its children by the surface-area heuristic has to be lower than its own.
//!
//! The walk keeps, for each of the three planes through a cell's middle, where the ray crosses it at the earliest and at
//! the latest. Twelve comparisons of these and of the ray's interval in the cell leave the children that the ray may meet.
//! Children are numbered as seen from the ray, 0 the nearest octant; along a line these numbers only grow, so the lowest
//! bit of the mask is always the next child.
//!
//! *Cost.* O(n log n) to build for scenes of well-shaped primitives; 8 bytes a node and 4 a reference, and no more than
//! [`OctreeBuilder`] says of its budget.
//!
//! *Source.* Glassner 1984, *Space Subdivision for Fast Ray Tracing*; Agate, Grimsdale & Lister 1991 (the order of children
//! by masks); Revelles, Ureña & Lastra 2000, *An Efficient Parametric Algorithm for Octree Traversal*.

mod build;
mod divide;
mod node;
mod octants;
mod traverse;

pub use {build::OctreeBuilder, node::OctreeData, traverse::Octree};

/// No cell lies deeper, so a stack of this size always suffices. The root has depth 0.
pub const MAX_DEPTH: usize = 24;
