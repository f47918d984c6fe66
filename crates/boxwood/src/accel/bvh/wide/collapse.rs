//! From a binary tree to a wide one, as the [`Plan`] says.
//!
//! *How it works.* First the subtrees are measured: how many nodes and blocks each large one becomes. So everything has its place,
//! whoever writes it when, and large subtrees are written side by side.

use super::gathering::Gathering;
use super::layout::{Full, Layout};
use super::leaf::{Blocks, Leaves};
use super::node::{Child, Node};
use super::plan::Plan;
use crate::accel::BuildError;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::Site;
use crate::geometry::Aabb;
use crate::geometry::frame::Frame;
use crate::pieces;
use crate::primitive::Primitives;
use crate::simd::Pages;
use alloc::vec::Vec;
use core::marker::PhantomData;

/// A tree of wide nodes.
pub struct Wide<const N: usize, L: Layout = Full> {
    pub root: Child,
    pub nodes: Pages<Node<N, L::Boxes<N>>>,
    pub leaves: Leaves,
    /// How many nodes lie above the deepest leaf.
    pub depth: usize,
}

impl<const N: usize, L: Layout> Wide<N, L> {
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
/// primitives, its boxes as seen from the frame; nothing useful where the site says that the build is over.
pub fn collapse<P: Primitives + Sync, const N: usize, L: Layout>(
    primitives: &P,
    tree: &BinaryTree,
    frame: &Frame,
    max_leaf: usize,
    gathering: Gathering,
    site: &Site<'_>,
) -> Result<Wide<N, L>, BuildError> {
    let plan = Plan::new(primitives, tree, max_leaf, gathering, site);
    let scripts = SCRIPT_BYTES_EACH * tree.nodes.len();
    site.take(scripts);
    if tree.nodes.is_empty() || site.is_over() {
        return Ok(Wide::nothing());
    }
    let collapse = Collapse::<_, N, L> {
        primitives,
        tree,
        frame,
        plan,
        site,
        layout: PhantomData,
    };
    let wide = collapse.grow();
    site.give(collapse.plan.bytes() + scripts);
    wide
}

struct Collapse<'a, P, const N: usize, L> {
    primitives: &'a P,
    tree: &'a BinaryTree,
    frame: &'a Frame,
    plan: Plan<'a, N>,
    site: &'a Site<'a>,
    layout: PhantomData<L>,
}

/// What a subtree becomes.
#[derive(Default)]
struct Size {
    nodes: usize,
    blocks: usize,
    /// The same of the children, where there is much below.
    children: Vec<Size>,
    /// Where there is less: how many children each node has that the subtree becomes, and which, from the root down.
    script: Vec<u32>,
}

/// What scripts take at most for each node of the binary tree: wide nodes and leaves come to no more than there are nodes, wide nodes
/// to half as many, and lists grow by doubling.
const SCRIPT_BYTES_EACH: usize = 3 * size_of::<u32>();

/// Subtrees of fewer primitives are written by one thread.
const MUCH: usize = 8192;

/// A node, and where the nodes below it go.
type NodeAndBelow<'p, const N: usize, L> = (
    Node<N, <L as Layout>::Boxes<N>>,
    &'p mut [Node<N, <L as Layout>::Boxes<N>>],
);

/// Where the nodes and blocks below some node go.
struct Places<'a, const N: usize, L: Layout> {
    nodes: &'a mut [Node<N, L::Boxes<N>>],
    /// The number of the first one.
    first_node: usize,
    blocks: Blocks<'a>,
    first_block: usize,
}

impl<'a, const N: usize, L: Layout> Places<'a, N, L> {
    /// Takes the first ones off.
    fn take(&mut self, nodes: usize, blocks: usize) -> Self {
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

impl<P: Primitives + Sync, const N: usize, L: Layout> Collapse<'_, P, N, L> {
    fn grow(&self) -> Result<Wide<N, L>, BuildError> {
        let size = self.size(0);
        if size.blocks > Child::MOST_BLOCKS {
            return Err(BuildError::TooMany {
                primitives: self.tree.order.len(),
                most: Child::MOST_BLOCKS * Leaves::LANES / 2,
            });
        }
        let node = size_of::<Node<N, L::Boxes<N>>>();
        let corners = L::has_corners::<P>();
        let bytes = size.nodes * node + size.blocks * Leaves::block_bytes(corners);
        if !self.site.take(bytes) {
            return Ok(Wide::nothing());
        }
        let room = "as much memory as the tree needs";
        let mut nodes = Pages::zeroed(size.nodes).expect(room);
        let mut leaves = Leaves::zeroed(corners, size.blocks).expect(room);
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
            let (node, depth) = self.node(0, &size, &mut places, &mut ids);
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
        let mut size = Size::default();
        if self.plan.count(index) < MUCH {
            self.read(index, &mut size, &mut Vec::with_capacity(N));
            return size;
        }
        let mut children = Vec::with_capacity(N);
        self.plan.children(index, &mut children);
        size.nodes = 1;
        size.children = pieces::each(children.len(), |i| self.size(children[i]));
        for below in &size.children {
            (size.nodes, size.blocks) = (size.nodes + below.nodes, size.blocks + below.blocks);
        }
        size
    }

    /// Writes down what becomes of a subtree that is no leaf.
    fn read(&self, index: usize, size: &mut Size, children: &mut Vec<usize>) {
        self.plan.children(index, children);
        size.nodes += 1;
        size.script.push(children.len() as u32);
        let at = size.script.len();
        size.script
            .extend(children.iter().map(|&child| child as u32));
        for place in at..size.script.len() {
            let child = size.script[place] as usize;
            if self.plan.is_leaf(child) {
                size.blocks += self.blocks(child);
            } else {
                self.read(child, size, children);
            }
        }
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

    fn leaf(&self, index: usize, places: &mut Places<'_, N, L>, ids: &mut Vec<u32>) -> Child {
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
        size: &Size,
        places: &mut Places<'_, N, L>,
        ids: &mut Vec<u32>,
    ) -> (Node<N, L::Boxes<N>>, usize) {
        if !size.script.is_empty() {
            return self.by_script(&mut &size.script[..], places, ids);
        }
        let mut children = Vec::with_capacity(N);
        self.plan.children(index, &mut children);
        let children = children.iter().map(|&child| child as u32);
        let children: Vec<u32> = children.collect();
        let (node, to) = self.top(&children, places, ids);
        let inner = children.iter().zip(&size.children);
        let inner = inner.filter(|(_, size)| size.nodes > 0).zip(to);
        let parts = inner.map(|((&index, size), to)| {
            let places = places.take(size.nodes - 1, size.blocks);
            (index as usize, size, to, places)
        });
        let depths = pieces::each_of(parts.collect(), |(index, size, to, mut places)| {
            let (node, depth) = self.node(index, size, &mut places, &mut Vec::new());
            *to = node;
            depth
        });
        (node, 1 + depths.into_iter().max().unwrap_or(0))
    }

    /// The same, by one thread.
    fn by_script(
        &self,
        script: &mut &[u32],
        places: &mut Places<'_, N, L>,
        ids: &mut Vec<u32>,
    ) -> (Node<N, L::Boxes<N>>, usize) {
        let [count, rest @ ..] = *script else {
            return (Node::new(&[]), 0);
        };
        let (children, rest) = rest.split_at(*count as usize);
        *script = rest;
        let (node, to) = self.top(children, places, ids);
        let mut depth = 1;
        if self.site.advance(children.len()) {
            for to in to {
                let (node, levels) = self.by_script(script, places, ids);
                *to = node;
                depth = depth.max(1 + levels);
            }
        }
        (node, depth)
    }

    /// A node with its leaves, and where the nodes below it go.
    fn top<'p>(
        &self,
        children: &[u32],
        places: &mut Places<'p, N, L>,
        ids: &mut Vec<u32>,
    ) -> NodeAndBelow<'p, N, L> {
        let is_node = |index: u32| !self.plan.is_leaf(index as usize);
        let count = children.iter().filter(|&&index| is_node(index)).count();
        let below = places.take(count, 0);
        let mut slots = [(Aabb::EMPTY, Child::NOTHING); N];
        let mut next = below.first_node;
        for (slot, &index) in slots.iter_mut().zip(children) {
            let child = if is_node(index) {
                next += 1;
                Child::node(next - 1)
            } else {
                self.leaf(index as usize, places, ids)
            };
            let bounds = self.frame.seen(&self.tree.nodes[index as usize].bounds);
            *slot = (bounds, child);
        }
        (Node::new(&slots[..children.len()]), below.nodes)
    }
}
