//! Bins of one node: filling them, weighing the cuts between them, and cutting there.

use crate::accel::bvh::build::sweep::{Block, Cut, Slot, cheapest_cut};
use crate::accel::bvh::build::{Item, Sides};
#[cfg(feature = "parallel")]
use {crate::accel::bvh::build::top_down::SEQUENTIAL, crate::threads::Exactly, rayon::prelude::*};

/// The most bins there may be.
pub(super) const MAX_BINS: usize = 64;

/// Where the bins of a node lie, by axis; the fourth lane says nothing.
pub(super) struct Bins {
    lower: [f32; 4],
    /// Bins per world unit; 0 where all middles are one.
    scale: [f32; 4],
    last: f32,
}

/// A float that counts in ones: what is added to it is rounded to a whole number, which its lowest bits then say. The
/// conversion of the language would first ask whether the number fits.
const ROUNDING: f32 = 12_582_912.0;
/// A little less than half a bin, so that rounding to the nearest becomes rounding down.
const HALF: f32 = 0.499_99;

impl Bins {
    pub fn new(bins: usize, middles: &Sides) -> Self {
        let around = middles.bounds();
        let size = around.size();
        // A little less than `bins`, so that the last middle falls into the last bin; infinite or NaN reads as 0.
        let scale = |size: f32| {
            let scale = bins as f32 * 0.999_999 / size;
            if scale.is_finite() { scale } else { 0.0 }
        };
        let lower = around.lower;
        Self {
            lower: [lower.x, lower.y, lower.z, 0.0],
            scale: [scale(size.x), scale(size.y), scale(size.z), 0.0],
            last: (bins - 1) as f32,
        }
    }

    /// The bin along one axis.
    #[inline(always)]
    fn bin(&self, middle: f32, axis: usize) -> u32 {
        let place = (middle - self.lower[axis]) * self.scale[axis] - HALF;
        // A NaN (from an infinite box) falls into the last bin.
        let place = if place < self.last { place } else { self.last };
        (place + ROUNDING).to_bits()
    }

    pub fn fill<const N: usize>(&self, items: &[Item]) -> Filled<N> {
        #[cfg(feature = "parallel")]
        if items.len() > 8 * SEQUENTIAL {
            // Unions and sums of whole numbers: the order does not count.
            return items
                .par_chunks(2 * SEQUENTIAL)
                .exactly()
                .map(|items| self.fill_some(items))
                .reduce(Filled::empty, Filled::merge);
        }
        self.fill_some(items)
    }

    fn fill_some<const N: usize>(&self, items: &[Item]) -> Filled<N> {
        let mut filled = Filled::empty();
        const { assert!(N.is_power_of_two()) };
        // First all numbers of some items, four lanes at a time, then the items.
        let mut bins = [[0; 4]; 64];
        for items in items.chunks(bins.len()) {
            for (bins, item) in bins.iter_mut().zip(items) {
                let middle = item.middle();
                for axis in 0..4 {
                    bins[axis] = self.bin(middle[axis], axis);
                }
            }
            for (bins, item) in bins.iter().zip(items) {
                let sides = item.sides();
                for axis in 0..3 {
                    let bin = bins[axis] as usize & (N - 1);
                    filled.sides[axis][bin] = filled.sides[axis][bin].around(&sides);
                    filled.counts[axis][bin] += 1;
                }
            }
        }
        filled
    }

    /// Brings the items of the bins before `at` to the front: how many they are.
    pub fn part(&self, items: &mut [Item], axis: usize, at: usize) -> usize {
        let mut left = 0;
        for i in 0..items.len() {
            let bin = self.bin(items[i].middle_along(axis), axis) as usize & (MAX_BINS - 1);
            // Swapped whether it goes left or not: which, nobody could foresee.
            items.swap(i, left);
            left += usize::from(bin < at);
        }
        left
    }
}

/// What fell into at most `N` bins: bounds and number, by axis.
pub(super) struct Filled<const N: usize> {
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

    /// The cheapest cut on one axis that leaves something on both sides.
    pub fn cheapest_cut(&self, axis: usize, bins: usize, block: Block) -> Option<Cut> {
        let (sides, counts) = (&self.sides[axis], &self.counts[axis]);
        cheapest_cut(bins.min(N), u32::MAX, block, &mut [0.0; N], |i| Slot {
            sides: sides[i],
            begin: counts[i],
            end: counts[i],
        })
    }

    /// What is around the bins before `at`, and around the others.
    pub fn around(&self, axis: usize, at: usize) -> [Sides; 2] {
        let (left, right) = self.sides[axis].split_at(at);
        [left, right].map(|row| row.iter().fold(Sides::EMPTY, |a, b| a.around(b)))
    }
}
