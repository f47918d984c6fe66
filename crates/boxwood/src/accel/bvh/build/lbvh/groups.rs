//! Neighbours along the curve that are met together.
//!
//! *How it works.* The row of primitives is cut into groups of at most as many as one block holds, such that the surfaces of
//! the groups' boxes come to the least: the cheapest way to cut the first `i` is the cheapest way to cut fewer, and one
//! group. The boxes of all runs of one length are made at once.
//!
//! *Cost.* O(n · block), in lanes.

use super::Item;
use crate::pieces;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// Most primitives in a group.
pub(super) const MAX_BLOCK: usize = 8;

/// Pieces of so many are cut apart from each other, whoever cuts them.
const PIECE: usize = 512;

/// Where each group begins, and where the last one ends.
pub(super) fn groups(items: &[Item], block: usize) -> Vec<u32> {
    let all = 0..=items.len() as u32;
    if block < 2 {
        return all.collect();
    }
    // A task is worth its price.
    let tasks: Vec<_> = items.chunks(16 * PIECE).collect();
    let found = pieces::each_of(tasks, |items: &[Item]| {
        let mut rows = Box::new(Rows::BLANK);
        let mut sizes = Vec::with_capacity(items.len() / 2);
        for piece in items.chunks(PIECE) {
            rows.cut(piece, block, &mut sizes);
        }
        sizes
    });
    let mut starts = Vec::with_capacity(1 + found.iter().map(Vec::len).sum::<usize>());
    let mut start = 0;
    starts.push(start);
    for size in found.into_iter().flatten() {
        start += u32::from(size);
        starts.push(start);
    }
    starts
}

/// What is known of the items of a piece.
struct Rows {
    /// Lower planes and negated upper ones.
    planes: [[f32; PIECE]; 6],
    /// The same around the runs that end with each item.
    around: [[f32; PIECE]; 6],
    /// The price of a run by its length less one, and by its last item.
    prices: [[f32; PIECE]; MAX_BLOCK],
    /// How many make the last group of the cheapest way to cut all up to an item.
    last: [u8; PIECE],
}

impl Rows {
    const BLANK: Self = Self {
        planes: [[0.0; PIECE]; 6],
        around: [[0.0; PIECE]; 6],
        prices: [[0.0; PIECE]; MAX_BLOCK],
        last: [0; PIECE],
    };

    /// Appends the sizes of the groups of a piece.
    fn cut(&mut self, items: &[Item], block: usize, sizes: &mut Vec<u8>) {
        let count = items.len().min(PIECE);
        self.weigh(items, block);
        // The least that all up to an item cost, of the last few items.
        let mut costs = [f32::INFINITY; MAX_BLOCK];
        costs[0] = 0.0;
        for i in 0..count {
            let (mut least, mut best) = (f32::INFINITY, 1);
            for size in 1..=block.min(i + 1) {
                let cost = costs[size - 1] + self.prices[size - 1][i];
                if cost < least {
                    (least, best) = (cost, size);
                }
            }
            self.last[i] = best as u8;
            costs.rotate_right(1);
            costs[0] = least;
        }
        let from = sizes.len();
        let mut end = count;
        while end > 0 {
            let size = self.last[end - 1];
            sizes.push(size);
            end -= usize::from(size);
        }
        sizes[from..].reverse();
    }

    /// Finds the price of every run.
    fn weigh(&mut self, items: &[Item], block: usize) {
        for (i, item) in items.iter().enumerate().take(PIECE) {
            let sides = item.sides();
            for plane in 0..6 {
                self.planes[plane][i] = sides.plane(plane);
            }
        }
        self.around = self.planes;
        for size in 0..block {
            if size > 0 {
                for (around, planes) in self.around.iter_mut().zip(&self.planes) {
                    for (around, &plane) in around[size..].iter_mut().zip(planes) {
                        *around = if plane < *around { plane } else { *around };
                    }
                }
            }
            let [lx, ly, lz, ux, uy, uz] = &self.around;
            for i in 0..PIECE {
                let (x, y, z) = (-ux[i] - lx[i], -uy[i] - ly[i], -uz[i] - lz[i]);
                self.prices[size][i] = x * y + y * z + z * x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;

    /// Boxes along a line that come closer and part again.
    fn row(count: usize) -> Vec<Item> {
        let boxes = (0..count).map(|i| {
            let at = (i * i * 7 % 31) as f32 + 3.0 * i as f32;
            let size = 1.0 + (i * 5 % 7) as f32;
            Aabb::new([at, 0.0, 0.0], [at + size, size, 1.0])
        });
        let items = boxes.enumerate();
        items.map(|(i, b)| Item::new(&b, i as u32)).collect()
    }

    fn surface(items: &[Item]) -> f32 {
        Item::around(items).half_area()
    }

    /// What the cheapest groups cost, by trying all.
    fn least(items: &[Item], block: usize) -> f32 {
        let first = 1..=block.min(items.len());
        let costs = first.map(|size| surface(&items[..size]) + least(&items[size..], block));
        costs.reduce(f32::min).unwrap_or(0.0)
    }

    #[test]
    fn no_groups_are_cheaper() {
        for block in 2..=4 {
            for count in 0..14 {
                let items = row(count);
                let starts = groups(&items, block);
                let sizes = starts
                    .windows(2)
                    .map(|ends| &items[ends[0] as usize..ends[1] as usize]);
                let cost: f32 = sizes.map(surface).sum();
                let least = least(&items, block);
                assert!(
                    (cost - least).abs() <= 1e-4 * least,
                    "{count} in {block}: {cost} not {least}"
                );
            }
        }
    }

    #[test]
    fn groups_are_small_and_hold_everything() {
        let mut items = row(3 * 16 * PIECE + 7);
        // Nothing can be said of a box that is no number, or infinite.
        items[5] = Item::new(&Aabb::new([f32::NAN; 3], [f32::NAN; 3]), 5);
        items[9] = Item::new(&Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]), 9);
        for block in [1, 2, 4, MAX_BLOCK] {
            let starts = groups(&items, block);
            let (first, last) = (starts.first(), starts.last());
            assert_eq!((first, last), (Some(&0), Some(&(items.len() as u32))));
            let fits = |ends: &[u32]| (1..=block as u32).contains(&(ends[1] - ends[0]));
            assert!(starts.windows(2).all(fits), "groups of {block}");
        }
    }
}
