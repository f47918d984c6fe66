//! The lecture's builder: cut the longest axis so that half of the primitives lie on each side.
//!
//! *How it works.* Of the box around the primitives' middles take the longest axis, put the lower half of them to the
//! left and the others to the right, until at most five are left. The tree is balanced whatever the scene.
//!
//! *Cost.* O(n log n): a selection, not a sort, at every level.

use super::{BinaryTree, Split, top_down};
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;

/// The object-median builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Median {
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// The axes that may be divided.
    pub axes: Axes,
}

impl Default for Median {
    fn default() -> Self {
        Self {
            max_leaf: 5,
            axes: Axes::XYZ,
        }
    }
}

impl Median {
    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let max_leaf = self.max_leaf.clamp(1, MAX_LEAF);
        top_down(primitives, self.axes, limits, &|items, extent| {
            if items.len() <= max_leaf {
                return Split::Leaf;
            }
            let (axis, _) = extent.longest();
            let middle = items.len() / 2;
            items.select_nth_unstable_by(middle, |a, b| {
                a.centroid()[axis]
                    .total_cmp(&b.centroid()[axis])
                    .then(a.id().cmp(&b.id()))
            });
            Split::At(middle)
        })
    }
}

bvh_builder!(Median, "bvh:median", |builder| [
    Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
    Setting::axes(&mut builder.axes),
]);
