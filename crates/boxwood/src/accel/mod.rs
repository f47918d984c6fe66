//! Structures, and which to choose.
//!
//! | structure | build | take it for |
//! |---|---|---|
//! | [`BruteForce`](brute_force::BruteForce) | none | judging the others; a handful of primitives |
//! | [`Bvh`](bvh::Bvh) over [`BinnedSah`](bvh::BinnedSah) | O(n log n) | everything: the default |
//! | [`Bvh`](bvh::Bvh) over [`Median`](bvh::Median) | O(n log n) | learning: the simplest tree that works |

pub mod brute_force;
pub mod bvh;
mod kind;
pub mod sah;

pub use kind::{StructureKind, UnknownStructure};
