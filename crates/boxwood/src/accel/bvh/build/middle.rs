//! Cuts the longest axis in the middle.
//!
//! *How it works.* Primitives go left or right by their middles, until a handful is left; where all would go to one side
//! they are halved by number. The tree follows space and not the primitives: small details far from each other part
//! early, and crowded corners lie deep.
//!
//! *Cost.* O(n) a level, and as many levels as it takes to tell the closest primitives apart, at most
//! [`MAX_DEPTH`](crate::accel::bvh::MAX_DEPTH).

use super::top_down::{Split, top_down_refined};
use super::{BinaryTree, Item};
use crate::accel::bvh::refine::Refine;
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;

/// The builder by spatial middles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Middle {
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

impl Default for Middle {
    fn default() -> Self {
        Self {
            max_leaf: 4,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

impl Middle {
    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let max_leaf = self.max_leaf.clamp(1, MAX_LEAF);
        let split = |items: &mut [Item], extent: &super::Extent| {
            if items.len() <= max_leaf {
                return Split::Leaf;
            }
            let (axis, _) = extent.longest();
            let middle = extent.around.centroid()[axis];
            let mut left = 0;
            for i in 0..items.len() {
                if items[i].centroid()[axis] < middle {
                    items.swap(i, left);
                    left += 1;
                }
            }
            Split::At(left)
        };
        top_down_refined(primitives, self.axes, self.refine, limits, &split)
    }
}

bvh_builder!(
    Middle,
    "bvh:middle",
    |builder| [
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
