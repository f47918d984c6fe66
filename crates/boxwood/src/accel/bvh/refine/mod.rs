//! Refinements: functions that make a finished tree better, or bring it up to date.
//!
//! | refinement | does | source |
//! |---|---|---|
//! | [`reinsertion`] | moves subtrees to where they cost least | Meister & Bittner 2018 |
//! | [`rotation`] | swaps children with grandchildren | Kensler 2008 |
//! | [`collapse_leaves`] | makes leaves of subtrees that are not worth opening | |
//! | [`refit`] | follows primitives that have moved | |
//!
//! Each keeps the tree whole: pairs of children side by side, the root first, no leaf deeper than
//! [`MAX_DEPTH`](super::MAX_DEPTH); afterwards the nodes lie depth-first, as a ray meets them. The first three never raise
//! the cost by the surface-area heuristic. They take trees that are whole, as builders make them; see
//! [`inspect::validate`](crate::inspect::validate) for others.

mod collapse;
mod lay_out;
mod refit;
mod reinsertion;
mod rotation;

pub use {collapse::collapse_leaves, refit::refit, reinsertion::reinsertion, rotation::rotation};

use super::tree::{BinaryNode, BinaryTree};
use crate::accel::limits::Site;
use crate::accel::settings::Setting;
use alloc::vec::Vec;

/// What a builder does to its tree at the end: by default nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refine {
    /// Rounds of [`reinsertion`], 0 to [`Refine::MOST`].
    pub reinsert: usize,
    /// Rounds of [`rotation`], 0 to [`Refine::MOST`]; they come first.
    pub rotate: usize,
}

impl Refine {
    /// Nothing is done.
    pub const NONE: Self = Self {
        reinsert: 0,
        rotate: 0,
    };
    /// The most rounds of anything; trees stop getting better long before.
    pub const MOST: usize = 64;

    /// The settings of every builder that refines.
    pub(crate) fn settings(&mut self) -> [Setting<'_>; 2] {
        [
            Setting::count("reinsert", &mut self.reinsert, 0..=Self::MOST),
            Setting::count("rotate", &mut self.rotate, 0..=Self::MOST),
        ]
    }

    /// How much work there is, in units of one level of a build.
    pub(crate) fn work(self) -> usize {
        REINSERTION_WORK * self.reinsert.min(Self::MOST) + self.rotate.min(Self::MOST)
    }

    /// Refines a tree that is being built; stops early when the build is over.
    pub(crate) fn apply(self, tree: &mut BinaryTree, site: &Site<'_>) {
        // The tree of a build that is over is not whole.
        if site.is_over() {
            return;
        }
        // What it was made of is gone.
        site.settle(tree.bytes());
        let scratch = scratch(tree);
        if self == Self::NONE || !site.take(scratch) {
            return;
        }
        let count = tree.order.len();
        for _ in 0..self.rotate.min(Self::MOST) {
            if !rotation::round(tree, site) {
                break;
            }
        }
        for _ in 0..self.reinsert.min(Self::MOST) {
            if site.is_over() || !reinsertion::round(tree, site) {
                break;
            }
            site.advance(count * (REINSERTION_WORK - 2));
        }
        site.give(scratch);
    }
}

/// The bytes that any refinement takes beside the tree at most: the better tree and the one in which that is laid out; and of
/// each node its parent, its leaves, its place in the order, whether it was touched, and where it should go.
fn scratch(tree: &BinaryTree) -> usize {
    let each = 3 * size_of::<u32>() + size_of::<bool>() + reinsertion::MOVE_BYTES;
    2 * tree.bytes() + each * tree.nodes.len()
}

/// The same tree with its nodes depth-first: every pair of children, then what lies below the first, then what lies below the second.
pub(crate) fn depth_first(mut tree: BinaryTree) -> BinaryTree {
    lay_out::lay_out(&mut tree, |_| false);
    tree
}

/// A round of reinsertion takes as long as so many levels of a build.
/// Searches tell of two of them, one for each node.
const REINSERTION_WORK: usize = 8;

/// The area of all inner nodes. Leaves keep theirs while subtrees move, so this is the part of the cost that changes.
fn inner_area(tree: &BinaryTree) -> f64 {
    let inner = tree.nodes.iter().filter(|node| !node.is_leaf());
    inner.map(area).sum()
}

fn area(node: &BinaryNode) -> f64 {
    f64::from(node.bounds.half_area())
}

/// The nodes depth-first: every parent comes before its children.
fn parents_first(tree: &BinaryTree) -> Vec<u32> {
    let mut found = Vec::with_capacity(tree.nodes.len());
    let mut open = Vec::new();
    if !tree.nodes.is_empty() {
        open.push(0);
    }
    while let Some(i) = open.pop() {
        found.push(i);
        let node = &tree.nodes[i as usize];
        if !node.is_leaf() {
            open.extend([node.first + 1, node.first]);
        }
    }
    found
}
