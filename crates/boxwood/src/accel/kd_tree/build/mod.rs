//! Builders. A builder is its settings; [`Rule`] is what sets one apart, the rest is shared.
//!
//! *How it works.* From the whole world down, a rule says where to cut a cell. Primitives on one side go there; one that
//! reaches across goes to both, held against the halves once more (a *perfect split*: its box in a child is that of the part
//! inside, and where nothing is inside it does not go there).
//!
//! *What bounds it.* Every cell has an allowance, the most references and leaves that it may end up with, shared out to
//! the halves in proportion to their primitives. A cut that would exceed it is not made. So the sum of all is bounded before
//! the work begins and does not depend on threads; under a memory limit the root's allowance is made as small as it takes.

mod bins;
mod lecture;
mod sah;
mod sweep;

pub use lecture::{AxisRule, KdLecture, PlaneRule};
pub use sah::KdSah;

use super::inspect::halves;
use super::node::{MAX_DEPTH, MAX_WEIGHT, Node, Partition};
use crate::accel::cells::Space;
use crate::accel::limits::Site;
use crate::accel::settings::Value;
use crate::accel::{BuildError, Limits};
use crate::geometry::{Aabb, Vec3};
use crate::primitive::Primitives;
#[cfg(feature = "parallel")]
use crate::threads;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// The [`Settings`](crate::accel::settings::Settings) and the two `build`s of a builder of kd-trees.
macro_rules! kd_builder {
    ($builder:ident, $name:literal, |$it:ident| $settings:expr) => {
        impl $builder {
            /// Divides the space of some primitives; it cannot fail.
            pub fn build(&self, primitives: &(impl Primitives + Sync)) -> Partition {
                crate::accel::limits::unlimited(self.build_within(primitives, &Limits::NONE))
            }

            /// Divides the space of some primitives within limits. A memory limit means fewer references, and so larger
            /// leaves.
            ///
            /// # Errors
            /// When the limits end the build.
            pub fn build_within(
                &self,
                primitives: &(impl Primitives + Sync),
                limits: &Limits<'_>,
            ) -> Result<Partition, BuildError> {
                crate::simd::exactly(|| super::top_down(primitives, &self.caps(), self, limits))
            }
        }

        impl crate::accel::settings::Settings for $builder {
            const NAME: &'static str = $name;
            fn settings(&mut self) -> Vec<Setting<'_>> {
                let $it = self;
                $settings.into()
            }
            fn structure<'a, P: Primitives + Send + Sync + 'a>(
                &self,
                primitives: P,
                limits: &Limits<'_>,
            ) -> Result<alloc::boxed::Box<dyn crate::query::Intersect + 'a>, BuildError> {
                let partition = self.build_within(&primitives, limits)?;
                Ok(alloc::boxed::Box::new(super::super::KdTree::new(
                    primitives, partition,
                )))
            }
        }
    };
}
use kd_builder;

/// A primitive in a cell: around its part in there, never empty and never beyond the cell.
#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Aabb,
    id: u32,
}

/// Where to cut a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    axis: usize,
    /// Strictly inside the cell.
    plane: f32,
    /// Where primitives go that lie in the plane.
    flat_below: bool,
}

/// A cell that a rule is asked about.
struct Cell<'a> {
    items: &'a [Item],
    bounds: Aabb,
    depth: usize,
    /// How many levels may follow.
    levels: usize,
}

/// What sets a builder apart.
trait Rule: Sync {
    /// Memory that is used again from cell to cell.
    type Scratch: Default;
    /// Where to cut; `None` makes the cell a leaf.
    fn cut(&self, cell: &Cell<'_>, scratch: &mut Self::Scratch) -> Option<Cut>;
}

/// What bounds a build.
struct Caps {
    /// Cells of so few primitives are leaves.
    leaf: usize,
    depth: Option<usize>,
    /// References and leaves per primitive.
    budget: f32,
}

impl Caps {
    /// The depth after which no cell is cut: by default 8 + 1.3 log₂ n (Havran).
    fn depth_of(&self, primitives: usize) -> usize {
        let levels = libm::log2f(primitives.max(1) as f32);
        let depth = self.depth.unwrap_or((8.5 + 1.3 * levels) as usize);
        depth.min(MAX_DEPTH)
    }
    /// The root's allowance. A few primitives are never short of it.
    fn allowance_of(&self, primitives: usize) -> usize {
        let budget = if self.budget >= 1.0 {
            self.budget.min(64.0)
        } else {
            1.0
        };
        ((budget * primitives as f32) as usize)
            .saturating_add(SMALL)
            .clamp(primitives, MAX_WEIGHT.max(primitives))
    }
}

/// References and leaves that are granted beyond the budget.
const SMALL: usize = 16;
/// Below this many primitives a subtree is built by one thread.
#[cfg(feature = "parallel")]
const SEQUENTIAL: usize = 4096;
/// So many primitives are looked at between two looks at the watcher.
const CHUNK: usize = 8192;

/// The most bytes in use per unit of the allowance while building. Of each vector half may be unused and the smaller one
/// not yet given back when it grows: items of open cells, then nodes (two per leaf) and references, which exist twice when the
/// trees of two threads become one.
const BYTES_EACH: usize = 3 * size_of::<Item>() + 3 * (2 * size_of::<Node>() + size_of::<u32>());

/// Divides top-down.
fn top_down<P: Primitives + Sync, R: Rule>(
    primitives: &P,
    caps: &Caps,
    rule: &R,
    limits: &Limits<'_>,
) -> Result<Partition, BuildError> {
    let n = primitives.len();
    let depth = caps.depth_of(n);
    // Each level looks at each reference about once.
    let site = Site::new(limits, n.saturating_mul(2 * depth + 1));
    let mut partition = Partition {
        space: Space::of(primitives),
        nodes: Vec::new(),
        references: Vec::new(),
        primitives: n,
    };
    if n > MAX_WEIGHT {
        partition.space.everywhere = (0..n as u32).collect();
        partition.space.world = Aabb::EMPTY;
    }
    site.take(size_of_val(&*partition.space.everywhere));
    let divided = n - partition.space.everywhere.len().min(n);
    if divided == 0 || partition.space.world.is_empty() {
        return site.finish(partition);
    }
    // What there is no room for is not granted.
    let allowance = caps
        .allowance_of(divided)
        .min((site.room() / BYTES_EACH).max(divided));
    if site.take(allowance.saturating_mul(BYTES_EACH)) {
        let items = items(primitives, &site);
        let work = Work {
            primitives,
            space: &partition.space,
            site: &site,
            rule,
            leaf: caps.leaf,
            depth,
        };
        let root = Open {
            node: 0,
            bounds: partition.space.world,
            depth: 0,
            items: items.len(),
            allowance,
        };
        let built = work.subtree(items, root);
        (partition.nodes, partition.references) = (built.nodes, built.references);
        partition.nodes.shrink_to_fit();
        partition.references.shrink_to_fit();
    }
    site.finish(partition)
}

/// Every primitive that is divided, with its whole box.
fn items(primitives: &impl Primitives, site: &Site<'_>) -> Vec<Item> {
    let mut items = Vec::with_capacity(primitives.len());
    for id in 0..primitives.len() {
        if id % CHUNK == 0 && !site.advance(CHUNK) {
            break;
        }
        let bounds = primitives.bounds(id);
        if !bounds.is_empty() && bounds.lower.is_finite() && bounds.upper.is_finite() {
            // Adding zero makes a negative zero positive, so that equal coordinates are equal bits.
            let [lower, upper] = [bounds.lower, bounds.upper].map(|p| p + Vec3::ZERO);
            let bounds = Aabb { lower, upper };
            let id = id as u32;
            items.push(Item { bounds, id });
        }
    }
    items
}

/// What all parts of one build share.
struct Work<'a, P, R> {
    primitives: &'a P,
    space: &'a Space,
    site: &'a Site<'a>,
    rule: &'a R,
    leaf: usize,
    depth: usize,
}

/// A cell that is not finished. Its items are the last ones of the list that are not those of a cell above it.
struct Open {
    node: usize,
    bounds: Aabb,
    depth: usize,
    items: usize,
    allowance: usize,
}

/// A part of the tree, numbered from its own root on.
#[derive(Default)]
struct Built {
    nodes: Vec<Node>,
    references: Vec<u32>,
}

impl<P: Primitives + Sync, R: Rule> Work<'_, P, R> {
    fn subtree(&self, mut items: Vec<Item>, root: Open) -> Built {
        let mut built = Built::default();
        built.nodes.push(Node::leaf(0, 0));
        let mut scratch = R::Scratch::default();
        let mut parts = [Vec::new(), Vec::new()];
        let mut open = alloc::vec![Open { node: 0, ..root }];
        while let Some(task) = open.pop() {
            let start = items.len() - task.items;
            if !self.site.advance(task.items) {
                return built;
            }
            let cell = Cell {
                items: &items[start..],
                bounds: task.bounds,
                depth: task.depth,
                levels: self.depth.saturating_sub(task.depth),
            };
            let may_cut = task.items > self.leaf && task.depth < self.depth;
            let cut = may_cut
                .then(|| self.rule.cut(&cell, &mut scratch))
                .flatten();
            let cells = cut.map(|cut| halves(&task.bounds, cut.axis, cut.plane));
            let shares = cut.zip(cells).and_then(|(cut, cells)| {
                self.divide(cell.items, &cut, &cells, &mut parts);
                shares(task.allowance, [parts[0].len(), parts[1].len()])
            });
            let (Some(cut), Some(cells), Some(shares)) = (cut, cells, shares) else {
                let first = built.references.len();
                built.nodes[task.node] = Node::leaf(first, task.items);
                built
                    .references
                    .extend(items[start..].iter().map(|item| item.id));
                items.truncate(start);
                continue;
            };
            items.truncate(start);
            let pair = built.nodes.len();
            built.nodes[task.node] = Node::inner(cut.axis, cut.plane, pair);
            let child = |side: usize| Open {
                node: pair + side,
                bounds: cells[side],
                depth: task.depth + 1,
                items: parts[side].len(),
                allowance: shares[side],
            };
            let children = [child(0), child(1)];
            #[cfg(feature = "parallel")]
            if task.items > SEQUENTIAL {
                let [below, above] = children;
                let [b, a] = core::mem::take(&mut parts);
                let (b, a) = threads::join(|| self.subtree(b, below), || self.subtree(a, above));
                built.append_pair([b, a]);
                continue;
            }
            built.nodes.extend([Node::leaf(0, 0); 2]);
            items.append(&mut parts[1]);
            items.append(&mut parts[0]);
            let [below, above] = children;
            open.extend([above, below]);
        }
        built
    }

    /// Fills the parts with the items of the two cells.
    fn divide(&self, items: &[Item], cut: &Cut, cells: &[Aabb; 2], parts: &mut [Vec<Item>; 2]) {
        let [below, above] = parts;
        below.clear();
        above.clear();
        #[cfg(feature = "parallel")]
        if items.len() > 4 * CHUNK {
            use crate::threads::Exactly;
            use rayon::prelude::*;
            let pieces: Vec<[Vec<Item>; 2]> = items
                .par_chunks(CHUNK)
                .exactly()
                .map(|items| {
                    let mut parts = [Vec::new(), Vec::new()];
                    if self.site.advance(items.len()) {
                        self.divide_some(items, cut, cells, &mut parts);
                    }
                    parts
                })
                .collect();
            for [mut b, mut a] in pieces {
                below.append(&mut b);
                above.append(&mut a);
            }
            return;
        }
        self.divide_some(items, cut, cells, parts);
    }

    fn divide_some(
        &self,
        items: &[Item],
        cut: &Cut,
        cells: &[Aabb; 2],
        parts: &mut [Vec<Item>; 2],
    ) {
        for item in items {
            let (lower, upper) = (item.bounds.lower[cut.axis], item.bounds.upper[cut.axis]);
            let (is_below, is_above) = if lower == upper && lower == cut.plane {
                (cut.flat_below, !cut.flat_below)
            } else {
                // A point in the plane counts for the half where the rest is.
                (lower < cut.plane, upper > cut.plane)
            };
            if is_below && is_above {
                for side in 0..2 {
                    parts[side].extend(self.part(item.id, &cells[side]));
                }
            } else {
                parts[usize::from(is_above)].push(*item);
            }
        }
    }

    /// The part of a primitive in a cell, when there is one.
    fn part(&self, id: u32, cell: &Aabb) -> Option<Item> {
        let part = self.space.part(self.primitives, id as usize, cell);
        if part.is_empty() {
            return None;
        }
        // The part may lie in the cell's padding only: then it counts as one in the cell's side.
        let clamp = |p: Vec3| p.max(cell.lower).min(cell.upper) + Vec3::ZERO;
        let bounds = Aabb {
            lower: clamp(part.lower),
            upper: clamp(part.upper),
        };
        Some(Item { bounds, id })
    }
}

/// What the two halves of a cell may grow to; `None` when even their primitives are too many.
fn shares(allowance: usize, items: [usize; 2]) -> Option<[usize; 2]> {
    // An empty leaf is a leaf.
    let least = items.map(|count| count.max(1));
    let rest = allowance.checked_sub(least[0] + least[1])?;
    let all = items[0] + items[1];
    // In 128 bits nothing overflows; `all` is zero only when both halves are empty.
    let below = (rest as u128 * items[0] as u128 / all.max(1) as u128) as usize;
    Some([least[0] + below, least[1] + (rest - below)])
}

impl Built {
    /// Two finished trees behind the nodes that are there: both roots, then what is below the one and the other.
    #[cfg(feature = "parallel")]
    fn append_pair(&mut self, halves: [Self; 2]) {
        let at = self.nodes.len();
        // Children of the lower half move by `at + 1`, those of the upper half by the lower one's length more.
        let moves = [at + 1, at + halves[0].nodes.len()];
        let behind = self.references.len();
        let references = [behind, behind + halves[0].references.len()];
        for side in 0..2 {
            self.nodes
                .push(halves[side].nodes[0].moved(moves[side], references[side]));
        }
        for side in 0..2 {
            let rest = halves[side].nodes[1..].iter();
            self.nodes
                .extend(rest.map(|node| node.moved(moves[side], references[side])));
            self.references.extend(&halves[side].references);
        }
    }
}

/// A depth as text: a number, or `auto`.
struct Depth<'a>(&'a mut Option<usize>);

impl Value for Depth<'_> {
    fn read(&mut self, text: &str) -> bool {
        if text == "auto" {
            *self.0 = None;
            return true;
        }
        let number = text.parse().ok().filter(|n| *n <= MAX_DEPTH);
        if number.is_some() {
            *self.0 = number;
        }
        number.is_some()
    }
    fn write(&self) -> String {
        self.0.map_or("auto".into(), |n| n.to_string())
    }
    fn expected(&self) -> String {
        alloc::format!("auto|0…{MAX_DEPTH}")
    }
}
