//! Which primitives lie in which cells: one list after the other, and nothing at all for an empty cell.
//!
//! *How it works.* Cells are numbered, and a bit tells of each whether anything lies in it. The filled ones are counted
//! through: 64 bits and the number of filled cells before them give a cell its place, and the place the beginning of its
//! list. Building first sorts the references into ranges of cells. Then the references of every cell of a range are
//! counted, the counts are added up and each reference is written where it belongs. Many threads may do so at once: each
//! has tasks or ranges for itself, and what it makes does not depend on the others.
//!
//! *Cost.* 12 bytes per 64 cells, 4 per filled cell, 4 per reference; while building 12 bytes more per reference.
//!
//! *Source.* Lagae & Dutré 2008, *Compact, Fast and Robust Grids for Ray Tracing*: counting, prefix sums and one array.
//! Theirs has 4 bytes for every cell; bits with counts are Jacobson 1989.

use super::sorted::{Lists, Sorted, every, filled_with};
use crate::accel::limits::Site;
use alloc::vec::Vec;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// Primitive `primitive` lies in cell `cell`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    pub cell: u32,
    pub primitive: u32,
}

/// The lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Counted {
    /// A bit for every cell: whether its list has anything in it.
    masks: Vec<u64>,
    /// The filled cells before each of them.
    before: Vec<u32>,
    /// Where the list of each filled cell begins, and where the last one ends.
    starts: Vec<u32>,
    primitives: Vec<u32>,
}

/// Bytes for each reference while lists are built: itself, and once more while it is sorted; afterwards its place in a
/// list, and a list of its own at the worst.
pub(crate) const BYTES_EACH: usize = 2 * size_of::<Reference>();

/// Bytes for so many cells with nothing in them.
pub(crate) fn bytes_of_cells(cells: usize) -> usize {
    cells.div_ceil(64) * (size_of::<u64>() + size_of::<u32>())
}

impl Counted {
    /// How many cells have a number.
    pub fn len(&self) -> usize {
        64 * self.masks.len()
    }
    /// The 64 bits that tell which of the cells `64 · word`, … are filled.
    #[inline(always)]
    pub fn word(&self, word: usize) -> u64 {
        self.masks[word]
    }
    /// Whether anything lies in a cell.
    #[inline(always)]
    pub fn is_filled(&self, cell: usize) -> bool {
        self.masks[cell / 64] >> (cell % 64) & 1 == 1
    }
    /// The primitives of a cell that is filled.
    #[inline(always)]
    pub fn list(&self, cell: usize) -> &[u32] {
        let place = place(&self.masks, &self.before, cell);
        &self.primitives[self.starts[place] as usize..self.starts[place + 1] as usize]
    }
    /// How many primitives lie in any cell.
    pub fn count(&self, cell: usize) -> u32 {
        if self.is_filled(cell) {
            self.list(cell).len() as u32
        } else {
            0
        }
    }
    /// How many references there are.
    pub fn references(&self) -> usize {
        self.primitives.len()
    }
    /// How many primitives the fullest cell has.
    pub fn longest(&self) -> usize {
        let lists = self.starts.windows(2).map(|w| w[1] - w[0]);
        lists.max().unwrap_or(0) as usize
    }
    /// Bytes of all arrays.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.masks)
            + size_of_val(&*self.before)
            + size_of_val(&*self.starts)
            + size_of_val(&*self.primitives)
    }

    /// Makes the lists of `cells` cells. Fewer than 2³² references, in the order of their primitives and none twice. Where
    /// the build is over, what is returned is worth nothing.
    pub fn of(cells: usize, parts: Vec<Vec<Reference>>, site: &Site<'_>) -> Self {
        let mut sorted = Sorted::of(cells, parts, site);
        let words = cells.div_ceil(64);
        let mut counted = Self {
            masks: alloc::vec![0; words],
            before: alloc::vec![0; words],
            ..Self::default()
        };
        let marked = every(
            sorted.ranges(&mut counted.masks, &mut counted.before),
            |mut range| site.advance(range.references.len()).then(|| range.mark()),
        );
        if site.is_over() {
            return Self::default();
        }
        let filled: usize = marked.iter().flatten().sum();
        counted.starts = filled_with(filled + 1, || 0);
        counted.primitives = filled_with(sorted.references.len(), || 0);
        let mut lists = Vec::with_capacity(marked.len());
        let (mut starts, mut primitives) = (&mut *counted.starts, &mut *counted.primitives);
        let (mut places, mut references) = (0, 0);
        let ranges = sorted.ranges(&mut counted.masks, &mut counted.before);
        for (range, filled) in ranges.into_iter().zip(marked) {
            let (filled, count) = (filled.unwrap_or(0), range.references.len());
            let lists_of_range = Lists {
                starts: starts.split_off_mut(..filled).unwrap_or_default(),
                primitives: primitives.split_off_mut(..count).unwrap_or_default(),
                place: places,
                first: references,
                range,
            };
            lists.push(lists_of_range);
            places += filled as u32;
            references += count as u32;
        }
        starts[0] = references;
        every(lists, |lists| {
            if site.advance(lists.range.references.len()) {
                lists.write();
            }
        });
        counted
    }
}

/// The place of a filled cell: how many there are before it.
#[inline(always)]
pub(super) fn place(masks: &[u64], before: &[u32], cell: usize) -> usize {
    let below = masks[cell / 64] & ((1 << (cell % 64)) - 1);
    (before[cell / 64] + below.count_ones()) as usize
}

/// Bytes that [`filled`] takes: the bits, twice while they are gathered.
pub(crate) fn bytes_of_filled(cells: usize) -> usize {
    cells.div_ceil(64) * 2 * size_of::<u64>()
}

/// A bit for every cell that is named.
pub(crate) fn filled(cells: usize, parts: &[Vec<Reference>]) -> Vec<u64> {
    let mut halves = Vec::new();
    halves.resize_with(2 * cells.div_ceil(64), || AtomicU32::new(0));
    let mark = |part: &Vec<Reference>| {
        for reference in part {
            let (half, bit) = (reference.cell as usize / 32, 1 << (reference.cell % 32));
            // Most are marked already, and looking is cheaper than writing.
            if halves[half].load(Relaxed) & bit == 0 {
                halves[half].fetch_or(bit, Relaxed);
            }
        }
    };
    #[cfg(feature = "parallel")]
    parts.par_iter().for_each(mark);
    #[cfg(not(feature = "parallel"))]
    parts.iter().for_each(mark);
    let half = |half: &AtomicU32| u64::from(half.load(Relaxed));
    let (pairs, _) = halves.as_chunks::<2>();
    pairs
        .iter()
        .map(|[low, high]| half(low) | half(high) << 32)
        .collect()
}

/// How many bits are set from one number up to before another.
pub(crate) fn ones(masks: &[u64], from: usize, to: usize) -> usize {
    let ones = |word: usize| {
        let skipped = from.saturating_sub(64 * word);
        let beyond = (64 * (word + 1)).saturating_sub(to);
        // Neither is 64: every word that is asked for has a bit in the range.
        (masks[word] >> skipped << skipped << beyond >> beyond).count_ones() as usize
    };
    match from < to {
        true => (from / 64..=(to - 1) / 64).map(ones).sum(),
        false => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Limits;

    #[test]
    fn bits_are_counted() {
        let masks: Vec<u64> = alloc::vec![0x8000_0000_0000_0001, u64::MAX, 0b1010];
        let set = |i: usize| masks[i / 64] >> (i % 64) & 1 == 1;
        for from in [0, 1, 63, 64, 70, 129, 191] {
            for to in [0, 1, 64, 65, 128, 130, 192] {
                let expected = (from..to).filter(|&i| set(i)).count();
                assert_eq!(ones(&masks, from, to), expected, "{from}..{to}");
            }
        }
    }

    #[test]
    fn lists_hold_what_they_were_given() {
        let cells = 20_000;
        let mut expected = alloc::vec![Vec::new(); cells];
        let mut parts = Vec::new();
        for part in 0..50_u32 {
            let one = |i: u32| Reference {
                // Every third cell and some of the others; the last as well.
                cell: (part * 1_999 + i * 3) % 20_000,
                primitive: part * 1000 + i,
            };
            let part: Vec<_> = (0..500).map(one).collect();
            for r in &part {
                expected[r.cell as usize].push(r.primitive);
            }
            parts.push(part);
        }
        let site = Site::new(&Limits::NONE, 1);
        let counted = Counted::of(cells, parts, &site);
        assert_eq!(counted.references(), 25_000);
        for (cell, list) in expected.iter_mut().enumerate() {
            list.sort_unstable();
            assert_eq!(counted.is_filled(cell), !list.is_empty());
            assert_eq!(counted.count(cell) as usize, list.len());
            if !list.is_empty() {
                assert_eq!(counted.list(cell), list);
            }
        }
        assert_eq!(
            counted.longest(),
            expected.iter().map(Vec::len).max().unwrap_or(0)
        );
        let none = Counted::of(64, Vec::new(), &site);
        assert!(!none.is_filled(63) && none.longest() == 0);
    }
}
