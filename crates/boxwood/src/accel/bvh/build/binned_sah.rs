//! Cuts where the surface-area heuristic, sampled at a few planes, is lowest.
//!
//! *How it works.* On each axis the primitives fall into equal bins by their middles; one sweep from either side gives the
//! cost of cutting between any two bins. The cheapest cut of the three axes is taken, unless keeping the primitives
//! together is cheaper and they are few enough for a leaf. A handful of primitives is sorted instead, and every cut
//! between two of them is tried.
//!
//! *Cost.* O(n log n), three bin look-ups per primitive and level.
//!
//! *Source.* Wald 2007, *On Fast Construction of SAH-based Bounding Volume Hierarchies*.

#[cfg(feature = "parallel")]
use super::top_down::SEQUENTIAL;
use super::top_down::{Extent, Split, top_down_refined};
use super::{BinaryTree, Item};
use crate::accel::bvh::refine::Refine;
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
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

/// The most bins there may be.
const MAX_BINS: usize = 64;

impl Default for BinnedSah {
    fn default() -> Self {
        Self {
            bins: 16,
            max_leaf: 8,
            axes: Axes::XYZ,
            refine: Refine::NONE,
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
            ..*self
        };
        top_down_refined(
            primitives,
            self.axes,
            self.refine,
            limits,
            &|items, extent| settings.split(items, extent),
        )
    }

    fn split(&self, items: &mut [Item], extent: &Extent) -> Split {
        let (cut, bins) = match items.len() {
            0 | 1 => return Split::Leaf,
            2..=FEW => (cheapest_of_few(items, self.axes), None),
            // Most nodes are small, and clearing bins that nobody asked for would take longer than filling the others.
            _ if self.bins <= 16 => self.cheapest_of_bins::<16>(items, extent),
            _ => self.cheapest_of_bins::<MAX_BINS>(items, extent),
        };
        let Some(cut) = cut else {
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
        let Some(bins) = bins else {
            items.sort_unstable_by(|a, b| by_middle(a, b, cut.axis));
            return Split::At(cut.place);
        };
        let mut left = 0;
        for i in 0..items.len() {
            if bins.bin(&items[i], cut.axis) < cut.place {
                items.swap(i, left);
                left += 1;
            }
        }
        Split::At(left)
    }

    fn cheapest_of_bins<const N: usize>(
        &self,
        items: &[Item],
        extent: &Extent,
    ) -> (Option<Cut>, Option<Bins>) {
        let bins = Bins::new(self.bins, extent);
        let filled = bins.fill::<N>(items);
        let mut best = None;
        for axis in self.axes.iter() {
            filled.cheapest_cut(axis, self.bins, &mut best);
        }
        (best, Some(bins))
    }
}

/// Up to so many primitives are sorted, and every cut between two of them is tried.
const FEW: usize = 8;

/// The order along an axis.
fn by_middle(a: &Item, b: &Item, axis: usize) -> core::cmp::Ordering {
    let (at_a, at_b) = (a.centroid()[axis], b.centroid()[axis]);
    at_a.total_cmp(&at_b).then(a.id.cmp(&b.id))
}

/// The cheapest cut between at most [`FEW`] primitives, put in order along an axis: `place` is how many lie before it.
fn cheapest_of_few(items: &[Item], axes: Axes) -> Option<Cut> {
    let n = items.len();
    let mut best = None;
    for axis in axes.iter() {
        // Numbers are sorted, not items, which are seven times as large.
        let mut sorted: [u8; FEW] = core::array::from_fn(|i| i as u8);
        let sorted = &mut sorted[..n];
        let item = |place: u8| &items[usize::from(place)];
        for i in 1..n {
            let mut k = i;
            while k > 0 && by_middle(item(sorted[k]), item(sorted[k - 1]), axis).is_lt() {
                sorted.swap(k, k - 1);
                k -= 1;
            }
        }
        let mut right_cost = [0.0; FEW];
        let mut right = Sides::EMPTY;
        for i in (1..n).rev() {
            right = right.around(&Sides::of(&item(sorted[i]).bounds));
            right_cost[i] = right.half_area() * (n - i) as f32;
        }
        let whole_area = right
            .around(&Sides::of(&item(sorted[0]).bounds))
            .half_area();
        let mut left = Sides::EMPTY;
        for place in 1..n {
            left = left.around(&Sides::of(&item(sorted[place - 1]).bounds));
            let cut = Cut {
                axis,
                place,
                cost: left.half_area() * place as f32 + right_cost[place],
                whole_area,
                smaller_half: place.min(n - place) as u32,
            };
            cut.replace_if_better(&mut best);
        }
    }
    best
}

/// Where to cut, and what it costs in areas times primitives.
struct Cut {
    axis: usize,
    /// How many bins, or primitives, lie before it.
    place: usize,
    cost: f32,
    whole_area: f32,
    /// How many primitives lie on the side that has fewer.
    smaller_half: u32,
}

impl Cut {
    /// Takes the place of one that is dearer, or as dear and less even: boxes along a line have no area, and all cuts
    /// through them cost nothing.
    fn replace_if_better(self, best: &mut Option<Self>) {
        let better = best.as_ref().is_none_or(|best| {
            self.cost < best.cost
                || (self.cost == best.cost && self.smaller_half > best.smaller_half)
        });
        if better {
            *best = Some(self);
        }
    }
}

/// A box as four lanes of lower planes and four of negated upper ones: all of it grows by one minimum.
#[derive(Clone, Copy)]
struct Sides([f32; 8]);

impl Sides {
    const EMPTY: Self = Self([f32::INFINITY; 8]);

    #[inline(always)]
    fn of(b: &Aabb) -> Self {
        let (l, u) = (b.lower, b.upper);
        Self([l.x, l.y, l.z, 0.0, -u.x, -u.y, -u.z, 0.0])
    }
    #[inline(always)]
    fn around(&self, other: &Self) -> Self {
        let mut sides = self.0;
        for (mine, &theirs) in sides.iter_mut().zip(&other.0) {
            *mine = if theirs < *mine { theirs } else { *mine };
        }
        Self(sides)
    }
    #[inline(always)]
    fn half_area(&self) -> f32 {
        let size = |k: usize| {
            let size = -self.0[k + 4] - self.0[k];
            if size > 0.0 { size } else { 0.0 }
        };
        let (x, y, z) = (size(0), size(1), size(2));
        x * y + y * z + z * x
    }
}

/// The bins of one node.
struct Bins {
    bins: usize,
    lower: Vec3,
    /// Bins per world unit; 0 where all middles are one.
    scale: Vec3,
}

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
        (place as i32 as usize).min(self.bins - 1)
    }

    fn fill<const N: usize>(&self, items: &[Item]) -> Filled<N> {
        #[cfg(feature = "parallel")]
        if items.len() > 16 * SEQUENTIAL {
            // Unions and sums of whole numbers: the order does not count.
            return items
                .par_chunks(2 * SEQUENTIAL)
                .map(|items| self.fill_some(items))
                .reduce(Filled::empty, Filled::merge);
        }
        self.fill_some(items)
    }

    fn fill_some<const N: usize>(&self, items: &[Item]) -> Filled<N> {
        let mut filled = Filled::empty();
        for item in items {
            let sides = Sides::of(&item.bounds);
            for axis in 0..3 {
                let bin = self.bin(item, axis);
                filled.sides[axis][bin] = filled.sides[axis][bin].around(&sides);
                filled.counts[axis][bin] += 1;
            }
        }
        filled
    }
}

/// What fell into at most `N` bins: bounds and number, by axis.
struct Filled<const N: usize> {
    sides: [[Sides; N]; 3],
    counts: [[u32; N]; 3],
}

impl<const N: usize> Filled<N> {
    fn empty() -> Self {
        Self {
            sides: [[Sides::EMPTY; N]; 3],
            counts: [[0; N]; 3],
        }
    }

    #[cfg(feature = "parallel")]
    fn merge(mut self, other: Self) -> Self {
        let sides = self.sides.as_flattened_mut().iter_mut();
        for (mine, theirs) in sides.zip(other.sides.as_flattened()) {
            *mine = mine.around(theirs);
        }
        let counts = self.counts.as_flattened_mut().iter_mut();
        for (mine, theirs) in counts.zip(other.counts.as_flattened()) {
            *mine += theirs;
        }
        self
    }

    /// The cheapest cut on one axis that leaves something on both sides, if it is better than the best so far.
    fn cheapest_cut(&self, axis: usize, bins: usize, best: &mut Option<Cut>) {
        let (sides, counts) = (&self.sides[axis], &self.counts[axis]);
        let mut right_cost = [0.0; N];
        let (mut right, mut behind) = (Sides::EMPTY, 0);
        for i in (1..bins).rev() {
            right = right.around(&sides[i]);
            behind += counts[i];
            right_cost[i] = right.half_area() * behind as f32;
        }
        let total = behind + counts[0];
        let whole_area = right.around(&sides[0]).half_area();
        let (mut left, mut before) = (Sides::EMPTY, 0);
        for place in 1..bins {
            left = left.around(&sides[place - 1]);
            before += counts[place - 1];
            if before == 0 || before == total {
                continue;
            }
            let cut = Cut {
                axis,
                place,
                cost: left.half_area() * before as f32 + right_cost[place],
                whole_area,
                smaller_half: before.min(total - before),
            };
            cut.replace_if_better(best);
        }
    }
}

bvh_settings!(
    BinnedSah,
    "bvh:binned",
    |builder| [
        Setting::count("bins", &mut builder.bins, 2..=MAX_BINS),
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
