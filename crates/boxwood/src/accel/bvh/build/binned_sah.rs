//! Cuts where the surface-area heuristic, sampled at a few planes, is lowest.
//!
//! *How it works.* On each axis the primitives fall into equal bins by their middles; one sweep from either side gives the
//! cost of cutting between any two bins. The cheapest cut of the three axes is taken, unless keeping the primitives
//! together is cheaper and they are few enough for a leaf.
//!
//! *Cost.* O(n log n), three bin look-ups per primitive and level.
//!
//! *Source.* Wald 2007, *On Fast Construction of SAH-based Bounding Volume Hierarchies*.

use super::{BinaryTree, Extent, Item, Split, top_down};
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::limits::unlimited;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::{Aabb, Vec3};
use crate::primitive::Primitives;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// The binned builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BinnedSah {
    /// Bins per axis, 2 to 64.
    pub bins: usize,
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// The axes that may be divided.
    pub axes: Axes,
}

/// The most bins there may be.
const MAX_BINS: usize = 64;

impl Default for BinnedSah {
    fn default() -> Self {
        Self {
            bins: 16,
            max_leaf: 8,
            axes: Axes::XYZ,
        }
    }
}

impl BinnedSah {
    /// Builds a tree; it cannot fail.
    pub fn build(&self, primitives: &impl Primitives) -> BinaryTree {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Builds a tree within limits.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within(
        &self,
        primitives: &impl Primitives,
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let settings = Self {
            bins: self.bins.clamp(2, MAX_BINS),
            max_leaf: self.max_leaf.clamp(1, MAX_LEAF),
            axes: self.axes,
        };
        top_down(primitives, self.axes, limits, &|items, extent| {
            settings.split(items, extent)
        })
    }

    fn split(&self, items: &mut [Item], extent: &Extent) -> Split {
        if items.len() < 2 {
            return Split::Leaf;
        }
        let grid = Bins::new(self.bins, extent);
        let filled = grid.fill(items);
        let mut best: Option<Cut> = None;
        for axis in self.axes.iter() {
            if let Some(cut) = filled.cheapest_cut(axis, self.bins)
                && best.as_ref().is_none_or(|best| cut.is_better(best))
            {
                best = Some(cut);
            }
        }
        let Some(cut) = best else {
            return if items.len() <= self.max_leaf {
                Split::Leaf
            } else {
                Split::Halve
            };
        };
        if items.len() <= self.max_leaf {
            let together = PRIMITIVE_COST * items.len() as f32 * cut.whole_area;
            let apart = NODE_COST * cut.whole_area + PRIMITIVE_COST * cut.cost;
            // Written so that a box without area, or with an infinite one, stays together.
            if !(apart < together) {
                return Split::Leaf;
            }
        }
        let mut left = 0;
        for i in 0..items.len() {
            if grid.bin(&items[i], cut.axis) < cut.plane {
                items.swap(i, left);
                left += 1;
            }
        }
        Split::At(left)
    }
}

/// Where to cut, and what it costs in areas times primitives.
struct Cut {
    axis: usize,
    plane: usize,
    cost: f32,
    whole_area: f32,
    /// How many primitives lie on the side that has fewer.
    smaller_half: u32,
}

impl Cut {
    /// Cheaper, or as cheap and more even: boxes along a line have no area, and all cuts through them cost nothing.
    fn is_better(&self, other: &Self) -> bool {
        self.cost < other.cost
            || (self.cost == other.cost && self.smaller_half > other.smaller_half)
    }
}

/// The bins of one node.
struct Bins {
    bins: usize,
    lower: Vec3,
    /// Bins per world unit; 0 where all middles are one.
    scale: Vec3,
}

/// What fell into the bins: bounds and number, by axis.
#[derive(Clone)]
struct Filled([[(Aabb, u32); MAX_BINS]; 3]);

impl Bins {
    fn new(bins: usize, extent: &Extent) -> Self {
        let size = extent.around.size();
        // A little less than `bins`, so that the last middle falls into the last bin; infinite or NaN reads as 0.
        let scale = |size: f32| {
            let scale = bins as f32 * 0.999_999 / size;
            if scale.is_finite() { scale } else { 0.0 }
        };
        Self {
            bins,
            lower: extent.around.lower,
            scale: Vec3::new(scale(size.x), scale(size.y), scale(size.z)),
        }
    }

    #[inline(always)]
    fn bin(&self, item: &Item, axis: usize) -> usize {
        // A NaN (from an infinite box) becomes 0.
        let place = (item.centroid()[axis] - self.lower[axis]) * self.scale[axis];
        (place as usize).min(self.bins - 1)
    }

    fn fill(&self, items: &[Item]) -> Filled {
        #[cfg(feature = "parallel")]
        if items.len() > 16 * super::SEQUENTIAL {
            // Unions and sums of whole numbers: the order does not count.
            return items
                .par_chunks(2 * super::SEQUENTIAL)
                .map(|items| self.fill_some(items))
                .reduce(Filled::empty, Filled::merge);
        }
        self.fill_some(items)
    }

    fn fill_some(&self, items: &[Item]) -> Filled {
        let mut filled = Filled::empty();
        for item in items {
            for axis in 0..3 {
                let (bounds, count) = &mut filled.0[axis][self.bin(item, axis)];
                (*bounds, *count) = (bounds.union(item.bounds), *count + 1);
            }
        }
        filled
    }
}

impl Filled {
    fn empty() -> Self {
        Self([[(Aabb::EMPTY, 0); MAX_BINS]; 3])
    }

    #[cfg(feature = "parallel")]
    fn merge(mut self, other: Self) -> Self {
        for (mine, theirs) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *mine = (mine.0.union(theirs.0), mine.1 + theirs.1);
        }
        self
    }

    /// The cheapest cut on one axis that leaves something on both sides; `None` when all lie in one bin.
    fn cheapest_cut(&self, axis: usize, bins: usize) -> Option<Cut> {
        let filled = &self.0[axis];
        let mut right_cost = [0.0; MAX_BINS];
        let mut right = (Aabb::EMPTY, 0);
        for i in (1..bins).rev() {
            right = (right.0.union(filled[i].0), right.1 + filled[i].1);
            right_cost[i] = right.0.half_area() * right.1 as f32;
        }
        let total = right.1 + filled[0].1;
        let whole_area = right.0.union(filled[0].0).half_area();
        let mut best: Option<Cut> = None;
        let mut left = (Aabb::EMPTY, 0);
        for plane in 1..bins {
            let (bounds, count) = filled[plane - 1];
            left = (left.0.union(bounds), left.1 + count);
            if left.1 == 0 || left.1 == total {
                continue;
            }
            let cost = left.0.half_area() * left.1 as f32 + right_cost[plane];
            let cut = Cut {
                axis,
                plane,
                cost,
                whole_area,
                smaller_half: left.1.min(total - left.1),
            };
            if best.as_ref().is_none_or(|best| cut.is_better(best)) {
                best = Some(cut);
            }
        }
        best
    }
}

bvh_settings!(BinnedSah, "bvh:binned", |builder| [
    Setting::count("bins", &mut builder.bins, 2..=MAX_BINS),
    Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
    Setting::axes(&mut builder.axes),
]);
