//! From a binary tree to a wide one, as the [`Plan`] says.

use super::gathering::Gathering;
use super::leaf::Leaves;
use super::node::{Child, Node};
use super::plan::Plan;
use crate::accel::BuildError;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::Site;
use crate::geometry::Aabb;
use crate::geometry::frame::Frame;
use crate::primitive::Primitives;
use crate::simd::Pages;
use alloc::vec::Vec;

/// Root, nodes, leaves and depth of a wide tree whose leaves made of subtrees hold at most so many primitives, its boxes as seen from the
/// frame; nothing useful where the site says that the build is over.
pub fn collapse<P: Primitives, const N: usize>(
    primitives: &P,
    tree: &BinaryTree,
    frame: &Frame,
    max_leaf: usize,
    gathering: Gathering,
    site: &Site<'_>,
) -> Result<(Child, Pages<Node<N>>, Leaves, usize), BuildError> {
    let plan = Plan::new(primitives, tree, max_leaf, gathering, site);
    let mut wide = Wide {
        primitives,
        tree,
        frame,
        plan,
        site,
        nodes: Pages::default(),
        leaves: Leaves::default(),
        ids: Vec::new(),
        depth: 0,
    };
    let root = wide.grow()?;
    site.give(wide.plan.bytes());
    Ok((root, wide.nodes, wide.leaves, wide.depth))
}

struct Wide<'a, P, const N: usize> {
    primitives: &'a P,
    tree: &'a BinaryTree,
    frame: &'a Frame,
    plan: Plan<'a, N>,
    site: &'a Site<'a>,
    nodes: Pages<Node<N>>,
    leaves: Leaves,
    ids: Vec<u32>,
    depth: usize,
}

impl<P: Primitives, const N: usize> Wide<'_, P, N> {
    fn grow(&mut self) -> Result<Child, BuildError> {
        if self.tree.nodes.is_empty() || self.site.is_over() {
            return Ok(Child::NOTHING);
        }
        let (nodes, blocks) = self.size(0);
        if blocks > Child::MOST_BLOCKS {
            return Err(BuildError::TooMany {
                primitives: self.tree.order.len(),
                most: Child::MOST_BLOCKS * Leaves::LANES / 2,
            });
        }
        let bytes = nodes * size_of::<Node<N>>() + blocks * Leaves::block_bytes::<P>();
        if !self.site.take(bytes) {
            return Ok(Child::NOTHING);
        }
        self.nodes = Pages::with_room(nodes);
        self.leaves = Leaves::with_capacity::<P>(blocks);
        let root = self.child(0);
        if !root.is_leaf() {
            self.open(0, root.index(), 1);
        }
        Ok(root)
    }

    /// How many nodes and blocks a subtree becomes at most (parts of one primitive may meet in a leaf).
    fn size(&self, index: usize) -> (usize, usize) {
        if self.plan.is_leaf(index) {
            return (0, self.plan.count(index).div_ceil(Leaves::LANES));
        }
        let mut children = Vec::with_capacity(N);
        self.plan.children(index, &mut children);
        children.iter().fold((1, 0), |(nodes, blocks), &child| {
            let below = self.size(child);
            (nodes + below.0, blocks + below.1)
        })
    }

    /// Makes a place for a child: its leaf, or a node that is still empty.
    fn child(&mut self, index: usize) -> Child {
        if !self.plan.is_leaf(index) {
            self.nodes.push(Node::new(&[]));
            return Child::node(self.nodes.len() - 1);
        }
        self.plan.primitives(index, &mut self.ids);
        let blocks = self.leaves.push(self.primitives, &self.ids);
        Child::leaf(blocks.start, blocks.len())
    }

    /// Fills the node made for a subtree, and all below. The children of a node lie side by side.
    fn open(&mut self, index: usize, at: usize, depth: usize) {
        self.depth = self.depth.max(depth);
        let mut children = Vec::with_capacity(N);
        self.plan.children(index, &mut children);
        let mut slots = [(Aabb::EMPTY, Child::NOTHING); N];
        for (slot, &index) in slots.iter_mut().zip(&children) {
            let bounds = self.frame.seen(&self.tree.nodes[index].bounds);
            *slot = (bounds, self.child(index));
        }
        if !self.site.advance(children.len()) {
            return;
        }
        let slots = &slots[..children.len()];
        self.nodes[at] = Node::new(slots);
        for (&index, &(_, child)) in children.iter().zip(slots) {
            if !child.is_leaf() {
                self.open(index, child.index(), depth + 1);
            }
        }
    }
}
