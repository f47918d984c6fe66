//! Structures, and which to choose.
//!
//! | structure | build | take it for |
//! |---|---|---|
//! | [`BruteForce`](brute_force::BruteForce) | none | judging the others; a handful of primitives |
//! | [`BoundingBoxes`](boxes::BoundingBoxes) | O(n) | a few objects far apart; learning: one box each, no more |
//! | [`UniformGrid`](grid::UniformGrid) | O(n) | primitives of one size, evenly spread; building often |
//! | [`TwoLevelGrid`](two_level_grid::TwoLevelGrid) | O(n) | the same, with details of several sizes |
//! | [`WideBvh`](bvh::WideBvh) over [`WideSah`](bvh::WideSah) | O(n log n) | speed: 8 or 16 boxes at once, many rays at a time |
//! | [`CompactBvh`](bvh::CompactBvh) over [`CompactSah`](bvh::CompactSah) | O(n log n) | memory: a sixth of the bytes, somewhat slower |
//! | [`Bvh`](bvh::Bvh) over [`BinnedSah`](bvh::BinnedSah) | O(n log n) | everything: the default, and the one to read |
//! | [`Bvh`](bvh::Bvh) over [`SpatialSplit`](bvh::SpatialSplit) | O(n log² n) | buildings: large triangles beside small ones |
//! | [`Bvh`](bvh::Bvh) over [`SweepSah`](bvh::SweepSah) | O(n log n) | the best tree that cuts no primitive |
//! | [`Bvh`](bvh::Bvh) over [`Ploc`](bvh::Ploc) | O(n) | scenes that change: a good tree, soon |
//! | [`Bvh`](bvh::Bvh) over [`Lbvh`](bvh::Lbvh) | O(n) | a tree, at once |
//! | [`Bvh`](bvh::Bvh) over [`Middle`](bvh::Middle), [`EqualCounts`](bvh::EqualCounts) | O(n log n) | comparing |
//! | [`Bvh`](bvh::Bvh) over [`Median`](bvh::Median) | O(n log n) | learning: the simplest tree that works |
//! | [`KdTree`](kd_tree::KdTree) over [`KdSah`](kd_tree::KdSah) | O(n log n) | scenes of walls and rooms; seeing space divided at its best |
//! | [`KdTree`](kd_tree::KdTree) over [`KdLecture`](kd_tree::KdLecture) | O(n log n) | learning: axis in turn, plane in the middle |
//! | [`Octree`](octree::Octree) over [`OctreeBuilder`](octree::OctreeBuilder) | O(n log n) | the classic division of space; scenes of evenly sized things |
//! | [`BspTree`](bsp_tree::BspTree) over [`BspSah`](bsp_tree::BspSah) | O(n log n), large factor | the fewest tests per ray; meshes that are built once |
//!
//! Every builder is its settings as a value; `build` cannot fail, `build_within` obeys [`Limits`].

mod axes;
pub mod boxes;
pub mod brute_force;
pub mod bsp_tree;
pub mod bvh;
mod cells;
pub mod grid;
pub mod kd_tree;
mod kind;
mod limits;
pub mod octree;
pub mod sah;
mod settings;
pub mod top_level;
pub mod two_level_grid;

pub use axes::{Axes, UnknownAxes};
pub use kind::{StructureKind, UnknownStructure};
pub use limits::{BuildError, Limits};
