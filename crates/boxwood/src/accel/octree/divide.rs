//! Dividing cells until they hold little, within a budget of memory.
//!
//! *How it works.* Depth first: of a cell's primitives each gets a mask of the [octants](super::octants) that it overlaps;
//! the masks decide whether the cell is divided, and its primitives are handed on to its children in one go. Large
//! cells hand their children to several threads. The budget is divided among children by their references, so that
//! the tree does not depend on who builds what when.

use super::node::{Node, Place};
use super::octants::{Octants, octant_bounds};
use crate::accel::Axes;
use crate::accel::cells::Space;
use crate::accel::limits::Site;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST, half_area};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// A cell with fewer primitives is built by one thread.
#[cfg(feature = "parallel")]
const SEQUENTIAL: usize = 4096;
/// Work is reported after so many primitives.
const CHUNK: usize = 8192;

/// What a leaf with so many references takes.
pub(super) fn leaf_bytes(references: usize) -> usize {
    size_of::<Node>() + size_of::<u32>() * references
}

/// A primitive on its way down.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub bounds: Aabb,
    pub id: u32,
}

impl Item {
    /// What lists are filled with before they are written.
    const NONE: Self = Self {
        bounds: Aabb::EMPTY,
        id: 0,
    };
}

/// A cell on its way down.
pub(super) struct Cell {
    pub place: Place,
    pub bounds: Aabb,
    pub depth: usize,
    /// Bytes that nodes and references below may take, this node included.
    pub budget: usize,
    pub units: usize,
}

/// A finished part of the tree: its root first, numbers and places counting from its own beginning.
#[derive(Default)]
pub(super) struct Part {
    pub nodes: Vec<Node>,
    pub references: Vec<u32>,
    /// Masks of the cells above, while they are being worked on.
    masks: Vec<u8>,
}

/// What all parts of one build share.
pub(super) struct Work<'a, P> {
    pub primitives: &'a P,
    pub space: &'a Space,
    pub site: &'a Site<'a>,
    pub axes: Axes,
    pub leaf: usize,
    pub depth: usize,
    #[cfg(feature = "parallel")]
    pub parallel: bool,
}

impl<P: Primitives + Sync> Work<'_, P> {
    /// Makes the tree of `items[start..]`, all of which overlap the cell, and names it node `root`. Leaves `items` as it was.
    pub fn divide(
        &self,
        items: &mut Vec<Item>,
        start: usize,
        cell: &Cell,
        root: usize,
        part: &mut Part,
    ) {
        let count = items.len() - start;
        let masks = part.masks.len();
        if count <= self.leaf
            || !self.may_divide(cell)
            || !self.site.reserve(&mut part.masks, count)
        {
            return self.make_leaf(&items[start..], cell, root, part);
        }
        self.mark(&items[start..], cell, &mut part.masks);
        let counts = count_each(&part.masks[masks..]);
        let Some(budgets) = self.worth_dividing(count, &counts, cell) else {
            part.masks.truncate(masks);
            return self.make_leaf(&items[start..], cell, root, part);
        };
        let existing = (0..8).fold(0, |mask, i| mask | u8::from(counts[i] > 0) << i);
        let first = part.nodes.len();
        if !self
            .site
            .reserve(&mut part.nodes, existing.count_ones() as usize)
        {
            return;
        }
        part.nodes
            .resize(first + existing.count_ones() as usize, Node::leaf(0, 0));
        part.nodes[root] = Node::inner(first as u32, existing);
        let total: usize = counts.iter().sum();
        let child = |octant: usize| Cell {
            place: cell.place.child(octant as u32),
            bounds: octant_bounds(&cell.bounds, cell.place.middle, octant),
            depth: cell.depth + 1,
            budget: budgets[octant],
            // A quarter is this cell's own work.
            units: (cell.units as f64 * 0.75 * counts[octant] as f64 / total as f64) as usize,
        };
        let octants = (0..8).filter(|&octant| counts[octant] > 0);
        #[cfg(feature = "parallel")]
        if self.parallel && count > SEQUENTIAL {
            let parts: Vec<Part> = octants
                .collect::<Vec<_>>()
                .into_par_iter()
                .exactly()
                .map(|octant| {
                    let mut below = Part::default();
                    let mut mine = Vec::new();
                    if self.site.reserve(&mut mine, counts[octant])
                        && self.site.reserve(&mut below.nodes, 1)
                    {
                        choose(&items[start..], &part.masks[masks..], octant, &mut mine);
                        below.nodes.push(Node::leaf(0, 0));
                        self.divide(&mut mine, 0, &child(octant), 0, &mut below);
                    }
                    self.site.release(mine);
                    self.site.release(core::mem::take(&mut below.masks));
                    below
                })
                .collect();
            part.masks.truncate(masks);
            for (i, below) in parts.into_iter().enumerate() {
                self.append(part, first + i, below);
            }
            return;
        }
        let end = items.len();
        if !self.site.reserve(items, total) {
            return;
        }
        // The first octant comes last: each is divided while nothing lies behind it.
        let mut starts = [end; 8];
        for octant in (0..7).rev() {
            starts[octant] = starts[octant + 1] + counts[octant + 1];
        }
        items.resize(end + total, Item::NONE);
        let (parents, children) = items.split_at_mut(end);
        let mut next = starts.map(|start| start - end);
        for (item, &mask) in parents[start..].iter().zip(&part.masks[masks..]) {
            let mut mask = mask;
            while mask != 0 {
                let next = &mut next[mask.trailing_zeros() as usize];
                children[*next] = *item;
                *next += 1;
                mask &= mask - 1;
            }
        }
        part.masks.truncate(masks);
        for (i, octant) in octants.enumerate() {
            self.divide(items, starts[octant], &child(octant), first + i, part);
            items.truncate(starts[octant]);
            if self.site.is_over() {
                return;
            }
        }
    }

    /// Whether there is anything between a cell's middle and its sides.
    fn may_divide(&self, cell: &Cell) -> bool {
        cell.depth < self.depth
            && !self.site.is_over()
            && self.axes.iter().all(|axis| {
                let (middle, half) = (cell.place.middle[axis], cell.place.half[axis]);
                // Halves of the smallest floats are not exact.
                half >= 4.0 * f32::MIN_POSITIVE
                    && cell.bounds.lower[axis] < middle
                    && middle < cell.bounds.upper[axis]
            })
    }

    /// Appends the octants that each primitive overlaps.
    fn mark(&self, items: &[Item], cell: &Cell, masks: &mut Vec<u8>) {
        let (place, bounds) = (&cell.place, &cell.bounds);
        let octants = Octants::of(self.primitives, self.space, bounds, place.middle, self.axes);
        let mask = |item: &Item| octants.overlapped(item.id as usize, &item.bounds);
        let chunks = items.len().div_ceil(CHUNK);
        let units = cell.units / 4 / chunks;
        #[cfg(feature = "parallel")]
        if self.parallel && items.len() > 4 * CHUNK {
            masks.par_extend(items.par_chunks(CHUNK).exactly().flat_map_iter(|items| {
                self.site.advance(units);
                items.iter().map(mask)
            }));
            return;
        }
        for items in items.chunks(CHUNK) {
            // After the last call a build that is over is only unwound.
            if items.len() == CHUNK {
                self.site.advance(units);
            }
            masks.extend(items.iter().map(mask));
        }
    }

    /// The children's budgets; `None` when the cell should stay whole.
    fn worth_dividing(&self, count: usize, counts: &[usize; 8], cell: &Cell) -> Option<[usize; 8]> {
        let needed = counts.iter().filter(|&&n| n > 0).map(|&n| leaf_bytes(n));
        let spare = cell
            .budget
            .checked_sub(size_of::<Node>() + needed.sum::<usize>())?;
        // A child's surface over the cell's: a quarter for eight cubes.
        let total: usize = counts.iter().sum();
        let share = |octant: usize| {
            let bounds = octant_bounds(&cell.bounds, cell.place.middle, octant);
            half_area(&bounds) / half_area(&cell.bounds)
        };
        let apart: f64 = (0..8)
            .filter(|&octant| counts[octant] > 0)
            .map(|octant| counts[octant] as f64 * share(octant))
            .sum();
        let together = f64::from(PRIMITIVE_COST) * count as f64;
        // Written so that areas of zero or infinity leave it to the other limits.
        if f64::from(NODE_COST) + f64::from(PRIMITIVE_COST) * apart > together {
            return None;
        }
        Some(core::array::from_fn(|octant| {
            let n = counts[octant];
            let extra = (spare as f64 * n as f64 / total as f64) as usize;
            if n > 0 { leaf_bytes(n) + extra } else { 0 }
        }))
    }

    fn make_leaf(&self, items: &[Item], cell: &Cell, root: usize, part: &mut Part) {
        if !self.site.reserve(&mut part.references, items.len()) {
            return;
        }
        part.nodes[root] = Node::leaf(part.references.len() as u32, items.len() as u32);
        part.references.extend(items.iter().map(|item| item.id));
        self.site.advance(cell.units);
    }

    /// Puts a finished subtree in the place of node `root`.
    #[cfg(feature = "parallel")]
    fn append(&self, part: &mut Part, root: usize, below: Part) {
        let Some((top, others)) = below.nodes.split_first() else {
            return;
        };
        let (nodes, references) = (part.nodes.len(), part.references.len());
        if !self.site.reserve(&mut part.nodes, others.len())
            || !self
                .site
                .reserve(&mut part.references, below.references.len())
        {
            return;
        }
        // The subtree's node 1 becomes node `nodes`.
        part.nodes[root] = top.moved(nodes - 1, references);
        let moved = others.iter().map(|node| node.moved(nodes - 1, references));
        part.nodes.extend(moved);
        part.references.extend_from_slice(&below.references);
        self.site.release(below.nodes);
        self.site.release(below.references);
    }
}

#[cfg(feature = "parallel")]
fn choose(items: &[Item], masks: &[u8], octant: usize, chosen: &mut Vec<Item>) {
    let both = items.iter().zip(masks);
    chosen.extend(
        both.filter(|(_, mask)| *mask >> octant & 1 == 1)
            .map(|(item, _)| *item),
    );
}

/// The bits of a mask, each in a byte of its own.
static BYTES: [u64; 256] = {
    let mut bytes = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut octant = 0;
        while octant < 8 {
            bytes[mask] |= (mask as u64 >> octant & 1) << (8 * octant);
            octant += 1;
        }
        mask += 1;
    }
    bytes
};

/// How many primitives each octant has.
fn count_each(masks: &[u8]) -> [usize; 8] {
    let mut counts = [0; 8];
    // As many as the bytes can count.
    for masks in masks.chunks(255) {
        let sum: u64 = masks.iter().map(|&mask| BYTES[mask as usize]).sum();
        for (count, byte) in counts.iter_mut().zip(sum.to_le_bytes()) {
            *count += usize::from(byte);
        }
    }
    counts
}
