//! Builders. A builder is its settings; it sees boxes only, unless it cuts primitives.
//!
//! | builder | how | source |
//! |---|---|---|
//! | [`Median`] | half of the primitives on each side of the longest axis | Kay & Kajiya 1986 |
//! | [`EqualCounts`] | the same on the axis where it is cheapest | |
//! | [`Middle`] | the middle of the longest axis | |
//! | [`BinnedSah`] | the cheapest of a few planes | Wald 2007 |
//! | [`SweepSah`] | the cheapest of all planes | Goldsmith & Salmon 1987, MacDonald & Booth 1990 |
//! | [`SpatialSplit`] | that, or a plane that cuts primitives in two | Stich, Friedrich & Dietrich 2009 |
//! | [`Lbvh`] | the bits of the primitives' places along a curve | Lauterbach et al. 2009 |
//! | [`Ploc`] | from the leaves: neighbours along that curve join | Meister & Bittner 2018 |
//!
//! Large parts are built side by side in the caller's rayon pool; the tree does not depend on the threads.

/// What every builder whose trees go into a [`Bvh`](super::Bvh) has: `build` and `build_within` around its own `tree`, and
/// its [`Settings`](crate::accel::settings::Settings). With `+ refine` the settings of its field `refine` follow its own.
macro_rules! bvh_builder {
    ($builder:ty, $name:literal, |$it:ident| $settings:expr $(, + $refine:ident)?) => {
        impl $builder {
            /// Builds a tree; it cannot fail.
            pub fn build(&self, primitives: &(impl Primitives + Sync)) -> BinaryTree {
                crate::accel::limits::unlimited(self.build_within(primitives, &Limits::NONE))
            }

            /// Builds a tree within limits.
            ///
            /// # Errors
            /// When the limits end the build.
            pub fn build_within(
                &self,
                primitives: &(impl Primitives + Sync),
                limits: &Limits<'_>,
            ) -> Result<BinaryTree, BuildError> {
                crate::simd::exactly(|| self.tree(primitives, limits))
            }
        }

        impl crate::accel::settings::Settings for $builder {
            const NAME: &'static str = $name;
            fn settings(&mut self) -> alloc::vec::Vec<Setting<'_>> {
                let $it = self;
                #[allow(unused_mut, reason = "only some builders refine")]
                let mut all = alloc::vec::Vec::from($settings);
                $(all.extend($it.$refine.settings());)?
                all
            }
            fn structure<'a, P: Primitives + Send + Sync + 'a>(
                &self,
                primitives: P,
                limits: &Limits<'_>,
            ) -> Result<alloc::boxed::Box<dyn crate::query::Intersect + 'a>, BuildError> {
                let tree = self.build_within(&primitives, limits)?;
                Ok(alloc::boxed::Box::new(crate::accel::bvh::Bvh::new(
                    primitives, tree,
                )))
            }
        }
    };
}

mod binned_sah;
mod curve;
mod equal_counts;
mod item;
mod lbvh;
mod median;
mod middle;
mod ploc;
mod spatial_split;
mod sweep;
mod sweep_sah;
mod top_down;

pub use {
    binned_sah::BinnedSah, equal_counts::EqualCounts, lbvh::Lbvh, median::Median, middle::Middle,
    ploc::Ploc, spatial_split::SpatialSplit, sweep_sah::SweepSah,
};

use super::tree::{BinaryNode, BinaryTree};
use item::{Item, Sides, items};
use top_down::{Extent, Split, top_down};

/// The bytes that a builder needs for each primitive: its item, and twice (parts and what they are joined to, or a tree and
/// its layout) two nodes at most and a place in the order.
const BYTES_EACH: usize = size_of::<Item>() + 2 * (2 * size_of::<BinaryNode>() + size_of::<u32>());
