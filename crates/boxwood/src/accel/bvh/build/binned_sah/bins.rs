//! Bins of one node: filling them, and cutting between them.

use super::row::Row;
use crate::accel::bvh::build::{Item, Sides};
use crate::simd::Lanes;

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
    #[inline(always)]
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

    /// Fills the bins of all axes.
    #[inline(always)]
    pub fn fill<S: Lanes<8>, const N: usize>(&self, s: S, items: &[Item], rows: &mut [Row<N>; 3]) {
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
                let sides = item.sides().lanes(s);
                for axis in 0..3 {
                    rows[axis].add::<S>(s, bins[axis] as usize & (N - 1), sides, 1);
                }
            }
        }
    }

    /// Brings the items of the bins before `at` to the front: how many they are.
    #[inline(always)]
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
