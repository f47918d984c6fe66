//! Builders. A builder is its settings; it sees boxes only.
//!
//! Large parts are built side by side in the caller's rayon pool; the tree does not depend on the threads.

mod binned_sah;
mod median;

pub use {binned_sah::BinnedSah, median::Median};

use super::tree::{BinaryNode, BinaryTree, MAX_DEPTH};
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

/// Splits top-down: `split` reorders its slice and says where to cut.
///
/// Where the tree would grow deeper than [`MAX_DEPTH`], every further cut is in the middle.
fn top_down<P: Primitives>(
    primitives: &P,
    split: &(impl Fn(&mut [Item], &Extent) -> Split + Sync),
) -> BinaryTree {
    let mut items: Vec<Item> = (0..primitives.len())
        .map(|i| Item {
            bounds: primitives.bounds(i),
            id: i as u32,
        })
        .collect();
    if items.is_empty() {
        return BinaryTree::default();
    }
    let mut nodes = Vec::new();
    subtree(&mut items, 0, 0, split, &mut nodes);
    BinaryTree {
        nodes,
        order: items.iter().map(|item| item.id).collect(),
    }
}

/// Builds the tree of `items`, which begin at place `start` of the order, behind what `nodes` already holds.
/// Its root comes first; numbers of children count from the root.
fn subtree(
    items: &mut [Item],
    start: usize,
    depth: usize,
    split: &(impl Fn(&mut [Item], &Extent) -> Split + Sync),
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
        let cut = match split(slice, &Extent::of(slice)) {
            Split::Leaf => continue,
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
                subtree(items, start + from, depth + 1, split, &mut nodes);
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
}

impl Extent {
    fn of(items: &[Item]) -> Self {
        #[cfg(feature = "parallel")]
        if items.len() > 16 * SEQUENTIAL {
            let around = items
                .par_chunks(SEQUENTIAL)
                .map(|items| Aabb::of(items.iter().map(Item::centroid)))
                .reduce(|| Aabb::EMPTY, Aabb::union);
            return Self { around };
        }
        Self {
            around: Aabb::of(items.iter().map(Item::centroid)),
        }
    }
    /// The longest axis and its length.
    fn longest(&self) -> (usize, f32) {
        let size = self.around.size();
        let axis = size.max_axis();
        (axis, size[axis])
    }
}
