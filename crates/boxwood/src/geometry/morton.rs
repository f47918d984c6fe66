//! Places along a curve that fills space, so that what is close on the curve is close in space.
//!
//! *How it works.* Space is a grid of 2²¹ cells an axis; a place's code interleaves the bits of its three cell numbers. The
//! codes are brought to buckets by the highest bits in which they differ, then within each bucket by the next ones. Chunks of a
//! large list go to the same buckets side by side.
//!
//! *Cost.* O(n): two or three passes where codes lie evenly, seven at most.
//!
//! *Source.* Morton 1966, *A Computer Oriented Geodetic Data Base*.

use super::{Aabb, Vec3};
use crate::pieces;
use alloc::vec::Vec;

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

/// So many are brought to their buckets by one thread at a time.
const CHUNK: usize = 1 << 16;
/// Lists of more are brought to many buckets.
const MANY: usize = 4096;
/// So many are sorted by comparing them.
const FEW: usize = 20;

/// Sorts by code; equal codes keep their order. `spare` is scratch of the same length. Now and then `goes_on` is told how
/// many codes were looked at; where it says no, nothing is sorted and the answer is `false`.
pub(crate) fn sort(
    list: &mut [Coded],
    spare: &mut [Coded],
    goes_on: &(impl Fn(usize) -> bool + Sync),
) -> bool {
    // Short lists are sorted without a question in between.
    settle(list, spare, false, goes_on) && (list.len() > MANY || goes_on(list.len()))
}

/// Sorts what the first list holds; it lies in the second one then if that is asked for, else in the first.
fn settle(
    from: &mut [Coded],
    to: &mut [Coded],
    into_second: bool,
    goes_on: &(impl Fn(usize) -> bool + Sync),
) -> bool {
    if from.len() > MANY {
        return by_digit::<1024>(from, to, into_second, goes_on);
    }
    if from.len() > FEW {
        return by_digit::<64>(from, to, into_second, goes_on);
    }
    let list = if into_second {
        to.copy_from_slice(from);
        to
    } else {
        from
    };
    list.sort_by_key(|coded| coded.code);
    true
}

/// The same by buckets, `B` at most.
fn by_digit<const B: usize>(
    from: &mut [Coded],
    to: &mut [Coded],
    into_second: bool,
    goes_on: &(impl Fn(usize) -> bool + Sync),
) -> bool {
    let Some(digit) = Digit::<B>::of(from) else {
        // All are equal.
        if into_second {
            to.copy_from_slice(from);
        }
        return true;
    };
    let large = from.len() > CHUNK;
    let counts = if large {
        digit.distribute_chunks(from, to)
    } else {
        let counts = digit.counts(from);
        digit.distribute(from, to, &counts);
        counts
    };
    if from.len() > MANY && !goes_on(from.len()) {
        return false;
    }
    let (mut of_first, mut of_second) = (from, to);
    let counts = counts.into_iter().take(digit.buckets);
    let mut buckets = counts.filter_map(|count| {
        let first = of_first.split_off_mut(..count as usize)?;
        Some((of_second.split_off_mut(..count as usize)?, first))
    });
    // What was brought from the first list to the second goes back.
    let sorted = |(from, to): (&mut [Coded], &mut [Coded])| settle(from, to, !into_second, goes_on);
    if large {
        let sorted = pieces::each_of(buckets.collect(), sorted);
        sorted.into_iter().all(|sorted| sorted)
    } else {
        buckets.all(sorted)
    }
}

/// The highest bits in which codes differ: they choose one of `B` buckets or fewer.
struct Digit<const B: usize> {
    shift: u32,
    buckets: usize,
}

impl<const B: usize> Digit<B> {
    /// A few codes for each bucket; `None` where all are the same.
    fn of(list: &[Coded]) -> Option<Self> {
        let first = list.first()?.code;
        let differing = list
            .iter()
            .fold(0, |bits, coded| bits | (coded.code ^ first));
        let bits = (list.len().ilog2() - 2).min(B.ilog2());
        Some(Self {
            shift: (differing.checked_ilog2()? + 1).saturating_sub(bits),
            buckets: 1 << bits,
        })
    }

    /// Where a code goes.
    #[inline(always)]
    fn bucket(&self, coded: &Coded) -> usize {
        // What lies above is the same in all codes.
        (coded.code >> self.shift) as usize & (self.buckets - 1) & (B - 1)
    }

    /// How many codes go where.
    fn counts(&self, list: &[Coded]) -> [u32; B] {
        let mut counts = [0; B];
        for coded in list {
            counts[self.bucket(coded)] += 1;
        }
        counts
    }

    /// Brings codes to their buckets.
    fn distribute(&self, from: &[Coded], to: &mut [Coded], counts: &[u32; B]) {
        let mut places = [0; B];
        let mut start = 0;
        for (place, &count) in places.iter_mut().zip(counts) {
            (*place, start) = (start, start + count);
        }
        for coded in from {
            let place = &mut places[self.bucket(coded)];
            to[*place as usize] = *coded;
            *place += 1;
        }
    }

    /// The same for many: chunks are brought to their places in the buckets side by side. Says how many went where.
    fn distribute_chunks(&self, from: &[Coded], to: &mut [Coded]) -> [u32; B] {
        let chunks: Vec<&[Coded]> = from.chunks(CHUNK).collect();
        let counts = pieces::each_of(chunks.clone(), |chunk| self.counts(chunk));
        // A bucket has room for what the first chunk brings, then for what the second one does.
        let mut rooms: Vec<Vec<&mut [Coded]>> = Vec::new();
        rooms.resize_with(chunks.len(), Vec::new);
        let mut rest = to;
        for bucket in 0..B {
            for (rooms, counts) in rooms.iter_mut().zip(&counts) {
                let room = rest.split_off_mut(..counts[bucket] as usize);
                rooms.push(room.unwrap_or_default());
            }
        }
        let work = chunks.into_iter().zip(rooms).collect();
        pieces::each_of(work, |(chunk, mut rooms): (&[Coded], Vec<&mut [Coded]>)| {
            let mut brought = [0; B];
            for coded in chunk {
                let bucket = self.bucket(coded);
                rooms[bucket][brought[bucket]] = *coded;
                brought[bucket] += 1;
            }
        });
        let mut sum = [0; B];
        for counts in counts {
            for (sum, count) in sum.iter_mut().zip(counts) {
                *sum += count;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
