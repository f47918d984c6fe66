//! Places along a curve that fills space, so that what is close on the curve is close in space.
//!
//! *How it works.* Space is a grid of 2²¹ cells an axis; a place's code interleaves the bits of its three cell numbers. The
//! codes are sorted by their bytes, the lowest first; large lists are sorted in halves that are then merged.
//!
//! *Cost.* O(n): eight passes at most, and only over bytes that differ.
//!
//! *Source.* Morton 1966, *A Computer Oriented Geodetic Data Base*.

use super::{Aabb, Vec3};

/// Cells along an axis: 21 bits.
const CELLS: u32 = 1 << 21;

/// A grid of cubes over a box.
pub(crate) struct Grid {
    lower: Vec3,
    /// Cells per unit of length; 0 along an axis that does not count.
    scale: Vec3,
}

impl Grid {
    /// The grid over a box whose longest edge has [`CELLS`] cells. Only axes that are marked count.
    pub fn over(bounds: &Aabb, axes: [bool; 3]) -> Self {
        let size = bounds.size();
        let longest = (0..3).filter(|&axis| axes[axis]);
        let longest = longest.fold(0.0_f32, |most, axis| most.max(size[axis]));
        let scale = CELLS as f32 / longest;
        // Nothing to tell apart, or nothing that can be told apart.
        let scale = if scale.is_finite() { scale } else { 0.0 };
        let along = |axis: usize| if axes[axis] { scale } else { 0.0 };
        Self {
            lower: bounds.lower,
            scale: Vec3::new(along(0), along(1), along(2)),
        }
    }

    /// The code of a place: 63 bits. Places outside count as the nearest cell, NaN as the first.
    #[inline]
    pub fn code(&self, place: Vec3) -> u64 {
        (0..3).fold(0, |code, axis| {
            let cell = (place[axis] - self.lower[axis]) * self.scale[axis];
            // The conversion brings everything into the range of the integer, NaN to 0.
            code | spread((cell as u32).min(CELLS - 1)) << axis
        })
    }
}

/// 21 bits with two zeros between neighbours.
#[inline(always)]
fn spread(bits: u32) -> u64 {
    let mut x = u64::from(bits);
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// A code and whose it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Coded {
    pub code: u64,
    pub id: u32,
}

/// So many are sorted at once by one thread.
#[cfg(feature = "parallel")]
const SEQUENTIAL: usize = 1 << 16;

/// Sorts by code; equal codes keep their order. `spare` is scratch of the same length. After every pass over some codes
/// `goes_on` is told how many they were; where it says no, nothing is sorted and the answer is `false`.
pub(crate) fn sort(
    list: &mut [Coded],
    spare: &mut [Coded],
    goes_on: &(impl Fn(usize) -> bool + Sync),
) -> bool {
    #[cfg(feature = "parallel")]
    if list.len() > SEQUENTIAL {
        let middle = list.len() / 2;
        let (left, right) = list.split_at_mut(middle);
        let (left_spare, right_spare) = spare.split_at_mut(middle);
        let sorted = rayon::join(
            || sort(left, left_spare, goes_on),
            || sort(right, right_spare, goes_on),
        );
        if sorted != (true, true) {
            return false;
        }
        merge((left, right), spare);
        list.copy_from_slice(spare);
        return goes_on(list.len());
    }
    sort_by_bytes(list, spare, goes_on)
}

/// Merges two sorted lists, large ones in halves; of equal codes those of the first come first.
#[cfg(feature = "parallel")]
fn merge((mut a, mut b): (&[Coded], &[Coded]), into: &mut [Coded]) {
    if into.len() > SEQUENTIAL / 2 {
        // What lies before the middle of the longer list in both of them comes before the rest.
        let (before_a, before_b) = if a.len() >= b.len() {
            let middle = a.len() / 2;
            let code = a[middle].code;
            (middle, b.partition_point(|coded| coded.code < code))
        } else {
            let middle = b.len() / 2;
            let code = b[middle].code;
            (a.partition_point(|coded| coded.code <= code), middle)
        };
        let ((a, more_a), (b, more_b)) = (a.split_at(before_a), b.split_at(before_b));
        let (into, rest) = into.split_at_mut(before_a + before_b);
        rayon::join(|| merge((a, b), into), || merge((more_a, more_b), rest));
        return;
    }
    for slot in into {
        let from = match (a.first(), b.first()) {
            (Some(x), Some(y)) if y.code < x.code => &mut b,
            (Some(_), _) => &mut a,
            (None, _) => &mut b,
        };
        if let Some((first, rest)) = from.split_first() {
            (*slot, *from) = (*first, rest);
        }
    }
}

fn sort_by_bytes(
    list: &mut [Coded],
    spare: &mut [Coded],
    goes_on: &impl Fn(usize) -> bool,
) -> bool {
    let mut counts = [[0_u32; 256]; 8];
    for coded in &*list {
        for (byte, counts) in coded.code.to_le_bytes().into_iter().zip(&mut counts) {
            counts[usize::from(byte)] += 1;
        }
    }
    let (mut from, mut to) = (list, spare);
    let mut swapped = false;
    for (place, counts) in counts.iter_mut().enumerate() {
        // A byte that is the same everywhere says nothing.
        if counts.iter().any(|&count| count as usize == from.len()) {
            continue;
        }
        let mut start = 0;
        for count in counts.iter_mut() {
            start += core::mem::replace(count, start);
        }
        for coded in &*from {
            let next = &mut counts[usize::from(coded.code.to_le_bytes()[place])];
            to[*next as usize] = *coded;
            *next += 1;
        }
        (from, to) = (to, from);
        swapped = !swapped;
        if !goes_on(from.len()) {
            return false;
        }
    }
    if swapped {
        // What is sorted lies in the scratch.
        to.copy_from_slice(from);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    #[test]
    fn codes_interleave() {
        let grid = Grid::over(&Aabb::new([0.0; 3], [CELLS as f32; 3]), [true; 3]);
        assert_eq!(grid.code(Vec3::new(1.5, 0.0, 0.0)), 0b001);
        assert_eq!(grid.code(Vec3::new(0.0, 1.0, 0.0)), 0b010);
        assert_eq!(grid.code(Vec3::new(3.0, 0.0, 2.0)), 0b101_001);
        assert_eq!(grid.code(Vec3::splat(1.0e30)), (1 << 63) - 1);
        assert_eq!(grid.code(Vec3::splat(f32::NAN)), 0);
        let flat = Grid::over(
            &Aabb::new([0.0; 3], [CELLS as f32; 3]),
            [true, false, false],
        );
        assert_eq!(flat.code(Vec3::splat(3.0)), 0b001_001);
        for all in [
            Aabb::EMPTY,
            Aabb::new([1.0; 3], [1.0; 3]),
            Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]),
        ] {
            assert_eq!(Grid::over(&all, [true; 3]).code(Vec3::splat(7.0)), 0);
        }
    }

    #[test]
    fn lists_of_any_length_are_sorted_and_stable() {
        let mut state = 1_u64;
        for length in [0, 1, 2, 255, 1_000, 200_001] {
            for mask in [0, 0xff, 0x7fff_ffff_ffff_ffff, 0x00ff_0000_0000_0000] {
                let mut list: Vec<Coded> = (0..length)
                    .map(|id| {
                        state = state
                            .wrapping_mul(6_364_136_223_846_793_005)
                            .wrapping_add(1);
                        let code = (state ^ state >> 29) & mask;
                        Coded { code, id }
                    })
                    .collect();
                let mut expected = list.clone();
                expected.sort();
                let mut spare = alloc::vec![Coded::default(); length as usize];
                assert!(sort(&mut list, &mut spare, &|_| true));
                assert!(list == expected, "{length} codes of {mask:x}");
                if length > 255 && mask > 0 {
                    assert!(!sort(&mut list, &mut spare, &|_| false));
                }
            }
        }
    }
}
