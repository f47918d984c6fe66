//! From a binary tree to a wide one, as the [`Plan`] says.
//!
//! *How it works.* First the subtrees are measured: how many nodes and blocks each large one becomes. So everything has its place,
//! whoever writes it when, and large subtrees are written side by side.

use super::gathering::Gathering;
use super::leaf::{Blocks, Leaves};
use super::node::{Child, Node};
use super::plan::Plan;
use crate::accel::BuildError;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::Site;
use crate::geometry::Aabb;
use crate::pieces;
use crate::primitive::Primitives;
use crate::simd::Pages;
use alloc::vec::Vec;

/// A tree of wide nodes.
pub struct Wide<const N: usize> {
    pub root: Child,
    pub nodes: Pages<Node<N>>,
    pub leaves: Leaves,
    /// How many nodes lie above the deepest leaf.
    pub depth: usize,
}

impl<const N: usize> Wide<N> {
    fn nothing() -> Self {
        Self {
            root: Child::NOTHING,
            nodes: Pages::default(),
            leaves: Leaves::default(),
            depth: 0,
        }
    }
}

/// Makes a wide tree of one that lies [depth-first](BinaryTree::is_depth_first), whose leaves made of subtrees hold at most so many
/// primitives; nothing useful where the site says that the build is over.
pub fn collapse<P: Primitives + Sync, const N: usize>(
    primitives: &P,
    tree: &BinaryTree,
    max_leaf: usize,
    gathering: Gathering,
    site: &Site<'_>,
) -> Result<Wide<N>, BuildError> {
    let plan = Plan::new(primitives, tree, max_leaf, gathering, site);
    if tree.nodes.is_empty() || site.is_over() {
        return Ok(Wide::nothing());
    }
    let collapse = Collapse {
        primitives,
        tree,
        plan,
        site,
    };
    let wide = collapse.grow();
    site.give(collapse.plan.bytes());
    wide
}

struct Collapse<'a, P, const N: usize> {
    primitives: &'a P,
    tree: &'a BinaryTree,
    plan: Plan<'a, N>,
    site: &'a Site<'a>,
}

/// What a subtree becomes.
#[derive(Default)]
struct Size {
    nodes: usize,
    blocks: usize,
    /// The same of the children, where there is much below.
    children: Vec<Size>,
}

/// Subtrees of fewer primitives are written by one thread.
const MUCH: usize = 8192;

/// Where the nodes and blocks below some node go.
struct Places<'a, const N: usize> {
    nodes: &'a mut [Node<N>],
    /// The number of the first one.
    first_node: usize,
    blocks: Blocks<'a>,
    first_block: usize,
}

impl<'a, const N: usize> Places<'a, N> {
    /// Takes the first ones off.
    fn take(&mut self, nodes: usize, blocks: usize) -> Places<'a, N> {
        let (taken, rest) = core::mem::take(&mut self.nodes).split_at_mut(nodes);
        self.nodes = rest;
        let places = Places {
            nodes: taken,
            first_node: self.first_node,
            blocks: self.blocks.take(blocks),
            first_block: self.first_block,
        };
        (self.first_node, self.first_block) = (self.first_node + nodes, self.first_block + blocks);
        places
    }
}

impl<P: Primitives + Sync, const N: usize> Collapse<'_, P, N> {
    fn grow(&self) -> Result<Wide<N>, BuildError> {
        let size = self.size(0);
        if size.blocks > Child::MOST_BLOCKS {
            return Err(BuildError::TooMany {
                primitives: self.tree.order.len(),
                most: Child::MOST_BLOCKS * Leaves::LANES / 2,
            });
        }
        let bytes = size.nodes * size_of::<Node<N>>() + size.blocks * Leaves::block_bytes::<P>();
        if !self.site.take(bytes) {
            return Ok(Wide::nothing());
        }
        let room = "as much memory as the tree needs";
        let mut nodes = Pages::zeroed(size.nodes).expect(room);
        let mut leaves = Leaves::zeroed::<P>(size.blocks).expect(room);
        let mut places = Places {
            nodes: &mut nodes,
            first_node: 0,
            blocks: leaves.blocks(),
            first_block: 0,
        };
        let mut ids = Vec::new();
        let (root, depth) = if self.plan.is_leaf(0) {
            (self.leaf(0, &mut places, &mut ids), 0)
        } else {
            let top = places.take(1, 0);
            let (node, depth) = self.node(0, &size.children, &mut places, &mut ids);
            top.nodes[0] = node;
            (Child::node(0), depth)
        };
        Ok(Wide {
            root,
            nodes,
            leaves,
            depth,
        })
    }

    /// How many nodes and blocks a subtree becomes.
    fn size(&self, index: usize) -> Size {
        if self.plan.is_leaf(index) {
            return Size {
                blocks: self.blocks(index),
                ..Size::default()
            };
        }
        let mut children = Vec::with_capacity(N);
        self.plan.children(index, &mut children);
        let mut size = Size {
            nodes: 1,
            ..Size::default()
        };
        if self.plan.count(index) < MUCH {
            for &child in &children {
                let below = self.size(child);
                (size.nodes, size.blocks) = (size.nodes + below.nodes, size.blocks + below.blocks);
            }
        } else {
            size.children = pieces::each(children.len(), |i| self.size(children[i]));
            for below in &size.children {
                (size.nodes, size.blocks) = (size.nodes + below.nodes, size.blocks + below.blocks);
            }
        }
        size
    }

    /// How many blocks a leaf takes.
    fn blocks(&self, index: usize) -> usize {
        let mut count = self.plan.count(index);
        // Parts of a primitive may meet in a leaf.
        if self.tree.order.len() > self.primitives.len() {
            let mut ids = Vec::new();
            self.plan.primitives(index, &mut ids);
            count = ids.len();
        }
        count.div_ceil(Leaves::LANES)
    }

    fn leaf(&self, index: usize, places: &mut Places<'_, N>, ids: &mut Vec<u32>) -> Child {
        self.plan.primitives(index, ids);
        let blocks = ids.len().div_ceil(Leaves::LANES);
        let taken = places.take(0, blocks);
        taken.blocks.write(self.primitives, ids);
        Child::leaf(taken.first_block, blocks)
    }

    /// The node made of a subtree, and how deep it is; all that lies below goes to its places. The children of a node lie side by
    /// side.
    fn node(
        &self,
        index: usize,
        sizes: &[Size],
        places: &mut Places<'_, N>,
        ids: &mut Vec<u32>,
    ) -> (Node<N>, usize) {
        let mut children = Vec::with_capacity(N);
        self.plan.children(index, &mut children);
        let is_node = |&&index: &&usize| !self.plan.is_leaf(index);
        let below = places.take(children.iter().filter(is_node).count(), 0);
        let mut slots = [(Aabb::EMPTY, Child::NOTHING); N];
        let mut next = below.first_node;
        for (slot, &index) in slots.iter_mut().zip(&children) {
            let child = if self.plan.is_leaf(index) {
                self.leaf(index, places, ids)
            } else {
                next += 1;
                Child::node(next - 1)
            };
            *slot = (self.tree.nodes[index].bounds, child);
        }
        let node = Node::new(&slots[..children.len()]);
        let mut depth = 1;
        if self.site.advance(children.len()) {
            let nodes = children.iter().filter(is_node);
            if sizes.is_empty() {
                for (&index, to) in nodes.zip(below.nodes) {
                    let (node, levels) = self.node(index, &[], places, ids);
                    *to = node;
                    depth = depth.max(1 + levels);
                }
            } else {
                depth += self.side_by_side(&children, sizes, below.nodes, places);
            }
        }
        (node, depth)
    }

    /// Writes the nodes below a node: how deep they are.
    fn side_by_side(
        &self,
        children: &[usize],
        sizes: &[Size],
        nodes: &mut [Node<N>],
        places: &mut Places<'_, N>,
    ) -> usize {
        let inner = children
            .iter()
            .zip(sizes)
            .filter(|(_, size)| size.nodes > 0);
        let parts = inner.zip(nodes).map(|((&index, size), to)| {
            let places = places.take(size.nodes - 1, size.blocks);
            (index, size, to, places)
        });
        let parts: Vec<_> = parts.collect();
        let depths = pieces::each_of(parts, |(index, size, to, mut places)| {
            let (node, depth) = self.node(index, &size.children, &mut places, &mut Vec::new());
            *to = node;
            depth
        });
        depths.into_iter().max().unwrap_or(0)
    }
}
