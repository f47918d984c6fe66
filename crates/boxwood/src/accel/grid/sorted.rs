//! References in ranges of cells: what is done to a range is done by one thread, in a fast cache.
//!
//! *How it works.* A stable sort by counting puts references into ranges of equally many cells. Those of a range lie in
//! the order of their primitives, and are then sorted once more by counting, now by their cells. Where all
//! references lie in few ranges, few threads have work, though no more than one thread alone would have.
//!
//! *Source.* Sorting by a radix, the most significant digit first: Zagha & Blelloch 1991, *Radix Sort for Vector
//! Multiprocessors*.

use super::counted::{Reference, place};
use crate::accel::limits::Site;
use alloc::vec::Vec;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// References by ranges of cells, and in each by primitives.
pub(super) struct Sorted {
    pub references: Vec<[AtomicU32; 2]>,
    /// How many each range has.
    counts: Vec<u32>,
    /// A range has so many words of 64 cells.
    words: usize,
}

/// A range of cells.
pub(super) struct Range<'a> {
    pub masks: &'a mut [u64],
    /// The filled cells of the range before each word of these.
    pub before: &'a mut [u32],
    /// The cells, counted from the first of the range, and the primitives.
    pub references: &'a mut [[AtomicU32; 2]],
}

/// The lists of a range of cells.
pub(super) struct Lists<'a> {
    pub range: Range<'a>,
    pub starts: &'a mut [u32],
    pub primitives: &'a mut [u32],
    /// How many filled cells there are before these, and how many references.
    pub place: u32,
    pub first: u32,
}

/// So many references make a range of cells, if they lie evenly: what is done to them is done in a fast cache.
const IN_A_RANGE: usize = 2048;
/// There are no more ranges: so many places to write to at once are held by a fast cache as well.
const MOST_RANGES: usize = 512;
/// References are put into their ranges by so many tasks.
const TASKS: usize = 64;

impl Sorted {
    /// A stable sort: each task counts what it has for each range, so that it knows where to put it.
    pub fn of(cells: usize, parts: Vec<Vec<Reference>>, site: &Site<'_>) -> Self {
        let total: usize = parts.iter().map(Vec::len).sum();
        let most = (total / IN_A_RANGE).clamp(1, MOST_RANGES);
        let words = cells.div_ceil(64).div_ceil(most).next_power_of_two();
        let width = 64 * words;
        let shift = width.trailing_zeros();
        let tasks = || parts.chunks(parts.len().div_ceil(TASKS).max(1));
        let mut tables = every(tasks().collect(), |parts| {
            let mut counts = alloc::vec![0_u32; cells.div_ceil(width)];
            for reference in parts.iter().flatten() {
                counts[(reference.cell >> shift) as usize] += 1;
            }
            counts
        });
        let (mut counts, mut end) = (Vec::with_capacity(cells.div_ceil(width)), 0);
        for range in 0..cells.div_ceil(width) {
            let start = end;
            for table in &mut tables {
                end += core::mem::replace(&mut table[range], end);
            }
            counts.push(end - start);
        }
        let references = filled_with(total, <[AtomicU32; 2]>::default);
        every(tasks().zip(tables).collect(), |(parts, mut next)| {
            for part in parts {
                if !site.advance(part.len()) {
                    return;
                }
                for reference in part {
                    let next = &mut next[(reference.cell >> shift) as usize];
                    let [cell, primitive] = &references[*next as usize];
                    cell.store(reference.cell % width as u32, Relaxed);
                    primitive.store(reference.primitive, Relaxed);
                    *next += 1;
                }
            }
        });
        Self {
            references,
            counts,
            words,
        }
    }

    /// The ranges, each with its cells' bits.
    pub fn ranges<'a>(&'a mut self, masks: &'a mut [u64], before: &'a mut [u32]) -> Vec<Range<'a>> {
        let mut left = &mut *self.references;
        let words = masks
            .chunks_mut(self.words)
            .zip(before.chunks_mut(self.words));
        words
            .zip(&self.counts)
            .map(|((masks, before), &count)| Range {
                masks,
                before,
                references: left.split_off_mut(..count as usize).unwrap_or_default(),
            })
            .collect()
    }
}

impl Range<'_> {
    /// Marks the filled cells, and counts them.
    pub fn mark(&mut self) -> usize {
        for [cell, _] in &mut *self.references {
            let cell = *cell.get_mut();
            self.masks[cell as usize / 64] |= 1 << (cell % 64);
        }
        let mut filled = 0;
        for (mask, before) in self.masks.iter().zip(&mut *self.before) {
            *before = filled;
            filled += mask.count_ones();
        }
        filled as usize
    }
}

impl Lists<'_> {
    /// Writes the lists.
    pub fn write(self) {
        let Range {
            masks,
            before,
            references,
        } = self.range;
        for [cell, _] in &mut *references {
            let at = *cell.get_mut();
            let place = place(masks, before, at as usize) as u32;
            *cell.get_mut() = place;
            self.starts[place as usize] += 1;
        }
        // Each count becomes where the list ends; writing from the end, it becomes where the list begins.
        let mut end = 0;
        for start in &mut *self.starts {
            end += *start;
            *start = end;
        }
        for [place, primitive] in references.iter_mut().rev() {
            let start = &mut self.starts[*place.get_mut() as usize];
            *start -= 1;
            self.primitives[*start as usize] = *primitive.get_mut();
        }
        for start in self.starts {
            *start += self.first;
        }
        for before in before {
            *before += self.place;
        }
    }
}

/// What `what` makes of every item, by as many threads as there are.
pub(super) fn every<T: Send, R: Send>(
    items: Vec<T>,
    what: impl Fn(T) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    return items.into_par_iter().exactly().map(what).collect();
    #[cfg(not(feature = "parallel"))]
    return items.into_iter().map(what).collect();
}

/// A list of so many, written by as many threads as there are.
pub(super) fn filled_with<T: Send>(count: usize, with: impl Fn() -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "parallel")]
    return (0..count)
        .into_par_iter()
        .exactly()
        .map(|_| with())
        .collect();
    #[cfg(not(feature = "parallel"))]
    return (0..count).map(|_| with()).collect();
}
