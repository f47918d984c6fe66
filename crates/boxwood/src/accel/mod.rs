//! Structures, and which to choose.
//!
//! | structure | build | take it for |
//! |---|---|---|
//! | [`BruteForce`](brute_force::BruteForce) | none | judging the others; a handful of primitives |
//! | [`Bvh`](bvh::Bvh) over [`BinnedSah`](bvh::BinnedSah) | O(n log n) | everything: the default |
//! | [`Bvh`](bvh::Bvh) over [`SpatialSplit`](bvh::SpatialSplit) | O(n log² n) | buildings: large triangles beside small ones |
//! | [`Bvh`](bvh::Bvh) over [`SweepSah`](bvh::SweepSah) | O(n log n) | the best tree that cuts no primitive |
//! | [`Bvh`](bvh::Bvh) over [`Ploc`](bvh::Ploc) | O(n) | scenes that change: a good tree, soon |
//! | [`Bvh`](bvh::Bvh) over [`Lbvh`](bvh::Lbvh) | O(n) | a tree, at once |
//! | [`Bvh`](bvh::Bvh) over [`Middle`](bvh::Middle), [`EqualCounts`](bvh::EqualCounts) | O(n log n) | comparing |
//! | [`Bvh`](bvh::Bvh) over [`Median`](bvh::Median) | O(n log n) | learning: the simplest tree that works |
//!
//! Every builder is its settings as a value; `build` cannot fail, `build_within` obeys [`Limits`].

mod axes;
pub mod brute_force;
pub mod bvh;
mod cells;
mod kind;
mod limits;
pub mod sah;
mod settings;

pub use axes::{Axes, UnknownAxes};
pub use kind::{StructureKind, UnknownStructure};
pub use limits::{BuildError, Limits};
