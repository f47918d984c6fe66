//! Dividing cells until they hold little, within a budget of memory.
//!
//! *How it works.* Depth first: of a cell's primitives each gets a mask of the octants that it overlaps; the masks decide
//! whether the cell is divided, and its primitives are handed on child by child. Boxes alone settle most of it, because a
//! primitive whose box lies in one octant lies in that octant; only what straddles a plane is tested exactly. Large cells
//! hand their children to several threads. The budget is divided among children by their references, so that the tree
//! does not depend on who builds what when.

use super::node::{Node, OctreeData, Place};
use super::{MAX_DEPTH, Octree};
use crate::accel::cells::Space;
use crate::accel::limits::{Site, unlimited};
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST, half_area};
use crate::accel::settings::{Setting, Settings};
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::{Aabb, Vec3};
use crate::primitive::Primitives;
use crate::query::Intersect;
use alloc::boxed::Box;
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// The builder of [`Octree`].
///
/// *Budget.* Nodes and references take at most 96 bytes per primitive (and 4 KiB), or a quarter of what
/// [`Limits::memory`] allows, if that is less: cells that would exceed their share stay whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OctreeBuilder {
    /// A cell with so many primitives or fewer is not divided, 1 to 64.
    pub leaf: usize,
    /// No cell lies deeper, 0 to [`MAX_DEPTH`].
    pub depth: usize,
    /// The axes that are divided.
    pub axes: Axes,
}

impl Default for OctreeBuilder {
    fn default() -> Self {
        Self {
            leaf: 12,
            depth: 20,
            axes: Axes::XYZ,
        }
    }
}

/// Bytes of nodes and references for each primitive, at most.
const BUDGET_EACH: usize = 96;
/// And for the whole.
const BUDGET_BASE: usize = 4096;
/// A cell with fewer primitives is built by one thread.
#[cfg(feature = "parallel")]
const SEQUENTIAL: usize = 4096;
/// Work is reported after so many primitives.
const CHUNK: usize = 8192;

impl OctreeBuilder {
    /// Builds an octree; it cannot fail.
    pub fn build(&self, primitives: &(impl Primitives + Sync)) -> OctreeData {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Builds an octree within limits. Little memory makes it shallower.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within<P: Primitives + Sync>(
        &self,
        primitives: &P,
        limits: &Limits<'_>,
    ) -> Result<OctreeData, BuildError> {
        let site = Site::new(limits, WORK);
        let space = Space::of(primitives);
        let mut data = OctreeData {
            root: Place::root(&space.world, self.axes),
            space,
            nodes: Vec::new(),
            references: Vec::new(),
            primitives: primitives.len(),
        };
        let n = primitives.len();
        if data.space.world.is_empty() || !site.take(size_of::<Item>().saturating_mul(n)) {
            return site.finish(data);
        }
        let mut items = Vec::with_capacity(n);
        for i in 0..n {
            let bounds = primitives.bounds(i);
            if !bounds.is_empty() && bounds.lower.is_finite() && bounds.upper.is_finite() {
                let id = i as u32;
                items.push(Item { bounds, id });
            }
        }
        let most = (BUDGET_EACH.saturating_mul(n) + BUDGET_BASE).min(MOST_BYTES);
        let budget = most.min(site.room() / 4).max(leaf_bytes(items.len()));
        let work = Work {
            primitives,
            space: &data.space,
            site: &site,
            axes: self.axes,
            leaf: self.leaf.clamp(1, 64),
            depth: self.depth.min(MAX_DEPTH),
            pad: data.space.pad(),
            exact: data.space.is_exact::<P>(),
            // Where memory is short, one thread after another, so that what is refused does not depend on them.
            #[cfg(feature = "parallel")]
            parallel: limits.memory.is_none() || site.room() / 8 > most,
        };
        let cell = Cell {
            place: data.root,
            // The root may reach beyond the world; nothing else does.
            bounds: data.root.bounds(&data.space.world).union(data.space.world),
            depth: 0,
            budget,
            units: WORK,
        };
        let mut part = Part::default();
        if site.reserve(&mut part.nodes, 1) {
            part.nodes.push(Node::leaf(0, 0));
            work.divide(&mut items, 0, &cell, 0, &mut part);
        }
        if !site.is_over() {
            part.nodes.shrink_to_fit();
            part.references.shrink_to_fit();
        }
        (data.nodes, data.references) = (part.nodes, part.references);
        site.finish(data)
    }
}

/// The units of work of a whole build, for those who watch: divided among the cells by their primitives.
const WORK: usize = 1 << 30;
/// So that places have 32 bits.
const MOST_BYTES: usize = if usize::BITS > 32 {
    4 * (u32::MAX as usize)
} else {
    usize::MAX / 8
};

/// What a leaf with so many references takes.
fn leaf_bytes(references: usize) -> usize {
    size_of::<Node>() + size_of::<u32>() * references
}

/// A primitive on its way down.
#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    id: u32,
}

/// A cell on its way down.
struct Cell {
    place: Place,
    bounds: Aabb,
    depth: usize,
    /// Bytes that nodes and references below may take, this node included.
    budget: usize,
    units: usize,
}

/// A finished part of the tree: its root first, numbers and places counting from its own beginning.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    references: Vec<u32>,
    /// Masks of the cells above, while they are being worked on.
    masks: Vec<u8>,
}

/// What all parts of one build share.
struct Work<'a, P> {
    primitives: &'a P,
    space: &'a Space,
    site: &'a Site<'a>,
    axes: Axes,
    leaf: usize,
    depth: usize,
    pad: f32,
    exact: bool,
    #[cfg(feature = "parallel")]
    parallel: bool,
}

impl<P: Primitives + Sync> Work<'_, P> {
    /// Makes the tree of `items[start..]`, all of which overlap the cell, and names it node `root`. Leaves `items` as it was.
    fn divide(
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
        for (i, octant) in octants.enumerate() {
            let end = items.len();
            if !self.site.reserve(items, counts[octant]) {
                return;
            }
            for k in start..end {
                if part.masks[masks + k - start] >> octant & 1 == 1 {
                    items.push(items[k]);
                }
            }
            self.divide(items, end, &child(octant), first + i, part);
            items.truncate(end);
            if self.site.is_over() {
                return;
            }
        }
        part.masks.truncate(masks);
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
        let chunks = items.len().div_ceil(CHUNK);
        let units = cell.units / 4 / chunks;
        #[cfg(feature = "parallel")]
        if self.parallel && items.len() > 4 * CHUNK {
            masks.par_extend(items.par_chunks(CHUNK).flat_map_iter(|items| {
                self.site.advance(units);
                items.iter().map(|item| self.octants(item, cell))
            }));
            return;
        }
        for items in items.chunks(CHUNK) {
            // After the last call a build that is over is only unwound.
            if items.len() == CHUNK {
                self.site.advance(units);
            }
            masks.extend(items.iter().map(|item| self.octants(item, cell)));
        }
    }

    /// The octants that a primitive of this cell overlaps: never none.
    fn octants(&self, item: &Item, cell: &Cell) -> u8 {
        let mut octants = 0xff_u8;
        let mut astride = 0;
        for (axis, &below) in LOW.iter().enumerate() {
            let plane = cell.place.middle[axis];
            let divided = self.axes.has(axis);
            let low = !divided || item.bounds.lower[axis] <= plane + self.pad;
            let high = divided && item.bounds.upper[axis] >= plane - self.pad;
            octants &= match (low, high) {
                (true, true) => 0xff,
                (true, false) => below,
                (false, _) => !below,
            };
            astride += u32::from(low && high);
        }
        // Boxes are asked no more than that; a triangle that crosses one plane inside the cell lies on both sides.
        if astride == 0 || !self.exact || astride == 1 && cell.bounds.contains(&item.bounds) {
            return octants;
        }
        let mut held = 0;
        for octant in 0..8 {
            if octants >> octant & 1 == 1 {
                let bounds = octant_bounds(&cell.bounds, cell.place.middle, octant);
                let holds = self.space.holds(self.primitives, item.id as usize, &bounds);
                held |= u8::from(holds) << octant;
            }
        }
        // Rounding may leave none of them; then all may hold it.
        if held == 0 { octants } else { held }
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

/// The octants in the lower half of each axis.
const LOW: [u8; 3] = [0b0101_0101, 0b0011_0011, 0b0000_1111];

#[cfg(feature = "parallel")]
fn choose(items: &[Item], masks: &[u8], octant: usize, chosen: &mut Vec<Item>) {
    let both = items.iter().zip(masks);
    chosen.extend(
        both.filter(|(_, mask)| *mask >> octant & 1 == 1)
            .map(|(item, _)| *item),
    );
}

fn count_each(masks: &[u8]) -> [usize; 8] {
    let mut counts = [0; 8];
    for mask in masks {
        for (octant, count) in counts.iter_mut().enumerate() {
            *count += usize::from(mask >> octant & 1);
        }
    }
    counts
}

/// The cell's part on one side of each plane. Along an axis that is not divided the middle is the upper end.
fn octant_bounds(cell: &Aabb, middle: Vec3, octant: usize) -> Aabb {
    let mut bounds = *cell;
    for axis in 0..3 {
        if octant >> axis & 1 == 1 {
            bounds.lower[axis] = middle[axis];
        } else {
            bounds.upper[axis] = middle[axis];
        }
    }
    bounds
}

impl Settings for OctreeBuilder {
    const NAME: &'static str = "octree";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        alloc::vec![
            Setting::count("leaf", &mut self.leaf, 1..=64),
            Setting::count("depth", &mut self.depth, 0..=MAX_DEPTH),
            Setting::axes(&mut self.axes),
        ]
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        let data = self.build_within(&primitives, limits)?;
        Ok(Box::new(Octree::new(primitives, data)))
    }
}
