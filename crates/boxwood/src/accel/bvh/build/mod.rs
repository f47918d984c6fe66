//! Builders. A builder is its settings; it sees boxes only.
//!
//! Large parts are built side by side in the caller's rayon pool; the tree does not depend on the threads.

/// The [`Settings`](crate::accel::settings::Settings) of a builder whose trees go into a [`Bvh`](super::Bvh).
macro_rules! bvh_settings {
    ($builder:ty, $name:literal, |$it:ident| $settings:expr) => {
        impl crate::accel::settings::Settings for $builder {
            const NAME: &'static str = $name;
            fn settings(&mut self) -> alloc::vec::Vec<Setting<'_>> {
                let $it = self;
                $settings.into()
            }
            fn structure<'a, P: Primitives + Send + Sync + 'a>(
                &self,
                primitives: P,
                limits: &Limits<'_>,
            ) -> Result<alloc::boxed::Box<dyn crate::query::Intersect + 'a>, BuildError> {
                let tree = self.build_within(&primitives, limits)?;
                Ok(alloc::boxed::Box::new(crate::accel::bvh::Bvh::new(
                    primitives, tree,
                )))
            }
        }
    };
}

mod binned_sah;
mod median;

pub use {binned_sah::BinnedSah, median::Median};

use super::tree::{BinaryNode, BinaryTree, MAX_DEPTH};
use crate::accel::limits::Site;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::{Aabb, Vec3};
use crate::primitive::Primitives;
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// A primitive on its way through a builder.
#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Aabb,
    id: u32,
}

impl Item {
    #[inline(always)]
    fn centroid(&self) -> Vec3 {
        self.bounds.centroid()
    }
}

/// What a builder says of some primitives.
enum Split {
    /// They stay together.
    Leaf,
    /// They were reordered, and the second half begins here.
    At(usize),
    /// They lie all in one place, or no cut is worth more than another: cut them in the middle.
    Halve,
}

/// Below this many primitives a subtree is built by one thread.
#[cfg(feature = "parallel")]
const SEQUENTIAL: usize = 4096;

/// The bytes that a builder needs for each primitive: its item, two nodes at most, a place in the order.
const BYTES_EACH: usize = size_of::<Item>() + 2 * size_of::<BinaryNode>() + size_of::<u32>();

/// Every primitive with its box, in order.
fn items(primitives: &impl Primitives) -> Vec<Item> {
    let item = |i| Item {
        bounds: primitives.bounds(i),
        id: i as u32,
    };
    (0..primitives.len()).map(item).collect()
}

/// Splits top-down: `split` reorders its slice and says where to cut.
///
/// Where the tree would grow deeper than [`MAX_DEPTH`], every further cut is in the middle.
fn top_down<P: Primitives>(
    primitives: &P,
    axes: Axes,
    limits: &Limits<'_>,
    split: &(impl Fn(&mut [Item], &Extent) -> Split + Sync),
) -> Result<BinaryTree, BuildError> {
    let site = Site::new(limits, primitives.len());
    if primitives.is_empty() || !site.take(BYTES_EACH.saturating_mul(primitives.len())) {
        return site.finish(BinaryTree::default());
    }
    let mut items = items(primitives);
    let mut nodes = Vec::new();
    subtree(
        &mut items,
        0,
        0,
        &Work {
            axes,
            site: &site,
            split,
        },
        &mut nodes,
    );
    site.finish(BinaryTree {
        nodes,
        order: items.iter().map(|item| item.id).collect(),
    })
}

/// What all parts of one top-down build share.
struct Work<'a, S> {
    axes: Axes,
    site: &'a Site<'a>,
    split: &'a S,
}

/// Builds the tree of `items`, which begin at place `start` of the order, behind what `nodes` already holds.
/// Its root comes first; numbers of children count from the root.
fn subtree(
    items: &mut [Item],
    start: usize,
    depth: usize,
    work: &Work<'_, impl Fn(&mut [Item], &Extent) -> Split + Sync>,
    nodes: &mut Vec<BinaryNode>,
) {
    let root = nodes.len();
    nodes.push(leaf(items, start));
    // Work left to do: a node, its places in `items`, its depth.
    let mut open = alloc::vec![(root, 0..items.len(), depth)];
    while let Some((node, range, depth)) = open.pop() {
        let slice = &mut items[range.clone()];
        // So many levels are enough to halve the rest down to single primitives.
        let levels = usize::BITS - (slice.len() - 1).leading_zeros();
        let may_choose = depth + (levels as usize) < MAX_DEPTH;
        if work.site.is_over() {
            return;
        }
        let cut = match (work.split)(slice, &Extent::of(slice, work.axes)) {
            Split::Leaf => {
                work.site.advance(slice.len());
                continue;
            }
            Split::At(cut) if may_choose && 0 < cut && cut < slice.len() => range.start + cut,
            Split::At(_) | Split::Halve => range.start + slice.len() / 2,
        };
        let pair = nodes.len();
        nodes[node].first = (pair - root) as u32;
        nodes[node].count = 0;
        #[cfg(feature = "parallel")]
        if range.len() > SEQUENTIAL {
            let (left, right) = items[range.clone()].split_at_mut(cut - range.start);
            let build = |items: &mut [Item], from: usize| {
                let mut nodes = Vec::new();
                subtree(items, start + from, depth + 1, work, &mut nodes);
                nodes
            };
            let (left, right) = rayon::join(|| build(left, range.start), || build(right, cut));
            append_pair(nodes, root, [left, right]);
            continue;
        }
        nodes.push(leaf(&items[range.start..cut], start + range.start));
        nodes.push(leaf(&items[cut..range.end], start + cut));
        open.push((pair + 1, cut..range.end, depth + 1));
        open.push((pair, range.start..cut, depth + 1));
    }
}

/// Two finished subtrees behind the nodes that are there: both roots, then what is below the one and the other.
#[cfg(feature = "parallel")]
fn append_pair(nodes: &mut Vec<BinaryNode>, root: usize, halves: [Vec<BinaryNode>; 2]) {
    let at = nodes.len() - root;
    // Children in the left half move by `at + 1`, those in the right half by the left half's length more.
    let moves = [at + 1, at + halves[0].len()];
    let moved = |node: &BinaryNode, by: usize| BinaryNode {
        first: node.first + if node.is_leaf() { 0 } else { by as u32 },
        ..*node
    };
    for (half, by) in halves.iter().zip(moves) {
        nodes.push(moved(&half[0], by));
    }
    for (half, by) in halves.iter().zip(moves) {
        nodes.extend(half[1..].iter().map(|node| moved(node, by)));
    }
}

fn leaf(items: &[Item], start: usize) -> BinaryNode {
    BinaryNode {
        bounds: items
            .iter()
            .fold(Aabb::EMPTY, |b, item| b.union(item.bounds)),
        first: start as u32,
        count: items.len() as u32,
    }
}

/// Where the middles of some primitives lie.
struct Extent {
    around: Aabb,
    axes: Axes,
}

impl Extent {
    fn of(items: &[Item], axes: Axes) -> Self {
        #[cfg(feature = "parallel")]
        if items.len() > 16 * SEQUENTIAL {
            let around = items
                .par_chunks(SEQUENTIAL)
                .map(|items| Aabb::of(items.iter().map(Item::centroid)))
                .reduce(|| Aabb::EMPTY, Aabb::union);
            return Self { around, axes };
        }
        Self {
            around: Aabb::of(items.iter().map(Item::centroid)),
            axes,
        }
    }
    /// The longest axis that may be divided, and its length.
    fn longest(&self) -> (usize, f32) {
        let size = self.around.size();
        let axis = self.axes.longest(size);
        (axis, size[axis])
    }
}
