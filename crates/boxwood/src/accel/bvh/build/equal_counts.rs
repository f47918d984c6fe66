//! Puts half of the primitives on each side, on that axis where the halves are cheapest.
//!
//! *How it works.* [`Median`](super::Median) takes the longest axis unseen; this one cuts on trial along each axis and
//! compares the areas of the two boxes. The tree is balanced whatever the scene.
//!
//! *Cost.* O(n log n): three selections at every level.

use super::top_down::{Split, top_down_refined};
use super::{BinaryTree, Item};
use crate::accel::bvh::refine::Refine;
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;

/// The builder by equal counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EqualCounts {
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

impl Default for EqualCounts {
    fn default() -> Self {
        Self {
            max_leaf: 4,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

impl EqualCounts {
    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let max_leaf = self.max_leaf.clamp(1, MAX_LEAF);
        let split = |items: &mut [Item], _: &super::Extent| {
            if items.len() <= max_leaf {
                return Split::Leaf;
            }
            let middle = items.len() / 2;
            let mut best = None;
            let mut last = None;
            for axis in self.axes.iter() {
                halve(items, middle, axis);
                last = Some(axis);
                let (left, right) = items.split_at(middle);
                let [left, right] = [left, right].map(Item::around);
                // The halves have the same number of primitives, so their areas tell.
                let area = left.half_area() + right.half_area();
                if best.is_none_or(|(least, _)| area < least) {
                    best = Some((area, axis));
                }
            }
            if let Some((_, axis)) = best
                && best.map(|(_, axis)| axis) != last
            {
                halve(items, middle, axis);
            }
            Split::At(middle)
        };
        top_down_refined(primitives, self.axes, self.refine, limits, &split)
    }
}

fn halve(items: &mut [Item], middle: usize, axis: usize) {
    items.select_nth_unstable_by_key(middle, |item| item.key(axis, item.id()));
}

bvh_builder!(
    EqualCounts,
    "bvh:equal",
    |builder| [
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
