//! Bounding volume hierarchies: builders make a [`BinaryTree`], layouts read it.
//!
//! *How it works.* A box around everything, two boxes in it around the halves, and so on until a handful of primitives
//! is left. A ray that misses a box misses all inside. Builders ([`BinnedSah`] and others) only decide which primitives
//! go where; functions in [`refine`] make a finished tree better; [`Bvh`] is the readable layout with its loop, [`WideBvh`] the
//! fast one, [`CompactBvh`] the small one.
//!
//! *Cost.* About 36 bytes per primitive: 64 for each pair of nodes, 4 for each place. Spatial splits take up to their budget times that.
//!
//! *Source.* Rubin & Whitted 1980; Kay & Kajiya 1986.

#[cfg(feature = "parallel")]
mod assemble;
mod binary;
mod build;
pub mod refine;
mod tree;
mod wide;

#[doc(hidden)]
pub use wide::seal;
pub use {
    binary::Bvh,
    build::{BinnedSah, EqualCounts, Lbvh, Median, Middle, Ploc, SpatialSplit, SweepSah},
    refine::Refine,
    tree::{BinaryNode, BinaryTree, MAX_DEPTH, MAX_LEAF},
    wide::{
        Compact, CompactBvh, CompactSah, Decision, Forecast, Full, Gathering, Job, Layout,
        MotionBvh, OpenError, Precision, Quality, SavedError, Survey, UnknownGathering,
        UnknownPrecision, UnknownQuality, Updated, Upkeep, WideBvh, WideSah,
    },
};
