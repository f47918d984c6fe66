//! Cuts where the bits of a curve through space change: the fastest builder.
//!
//! *How it works.* The primitives are sorted along a Morton curve, and neighbours are brought together into groups (`groups`).
//! A node is a run of groups; it is cut where the highest bit that differs within the run goes from 0 to 1, which is a
//! plane in the middle of a cell of the grid (`cuts`). Runs of equal codes are halved. At last small subtrees become leaves
//! where that is cheaper.
//!
//! *Cost.* O(n): to sort, to group, one union a node.
//!
//! *Source.* Lauterbach et al. 2009, *Fast BVH Construction on GPUs*; the halving of equal codes is that of Karras 2012,
//! *Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees*.

mod cuts;
mod groups;

use super::curve::{CURVE_BYTES_EACH, along_curve};
use super::top_down::{levels, work};
use super::{BYTES_EACH, BinaryTree, Item};
use crate::accel::bvh::refine::{Refine, collapse_leaves};
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::limits::Site;
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;
use groups::MAX_BLOCK;

/// The builder along a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lbvh {
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// Primitives that are met at once, 1 to 8: so many neighbours along the curve may be brought together before the tree is
    /// made.
    pub block: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

impl Default for Lbvh {
    fn default() -> Self {
        Self {
            max_leaf: 8,
            block: 1,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

impl Lbvh {
    /// The bytes that so many primitives take while their tree is built.
    pub(crate) fn bytes(count: usize) -> usize {
        (BYTES_EACH + CURVE_BYTES_EACH).saturating_mul(count)
    }

    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let count = primitives.len();
        let site = Site::new(limits, work(count, self.refine));
        if count == 0 || !site.take(Self::bytes(count)) {
            return site.finish(BinaryTree::default());
        }
        let Some((codes, items)) = along_curve(primitives, self.axes, &site) else {
            return site.finish(BinaryTree::default());
        };
        let block = self.block.clamp(1, MAX_BLOCK).min(self.max_leaf.max(1));
        let groups = groups::groups(&items, block);
        let mut tree = cuts::tree(&codes, &items, &groups, &site);
        drop((codes, items, groups));
        if !site.is_over() {
            self.refine.apply(&mut tree, &site);
            if self.max_leaf > block {
                collapse_leaves(&mut tree, self.max_leaf);
            }
        }
        site.finish(tree)
    }
}

bvh_builder!(
    Lbvh,
    "bvh:lbvh",
    |builder| [
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::count("block", &mut builder.block, 1..=MAX_BLOCK),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
