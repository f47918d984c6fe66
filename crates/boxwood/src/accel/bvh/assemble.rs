//! Joining trees that were made side by side.
//!
//! *How it works.* Threads make small trees, each in memory of its own. When all are known their nodes and places are
//! counted, and every tree is copied to where it belongs, once and again side by side: a pair of roots, then what is below
//! the left one, then what is below the right one.
//!
//! *Cost.* One copy of the tree.

use super::tree::{BinaryNode, BinaryTree};
use crate::geometry::Aabb;
use alloc::boxed::Box;
use rayon::prelude::*;

/// A tree in parts.
pub(super) enum Parts {
    /// A tree that one thread has made.
    Whole(BinaryTree),
    /// A node above two others.
    Pair(Box<Pair>),
}

pub(super) struct Pair {
    bounds: Aabb,
    nodes: usize,
    places: usize,
    halves: [Parts; 2],
}

impl Parts {
    /// A node above both.
    pub fn pair(halves: [Self; 2], bounds: Aabb) -> Self {
        let [a, b] = &halves;
        Self::Pair(Box::new(Pair {
            bounds,
            nodes: 1 + a.nodes() + b.nodes(),
            places: a.places() + b.places(),
            halves,
        }))
    }

    /// Around everything in it.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Whole(tree) => tree.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds),
            Self::Pair(pair) => pair.bounds,
        }
    }
    fn nodes(&self) -> usize {
        match self {
            Self::Whole(tree) => tree.nodes.len(),
            Self::Pair(pair) => pair.nodes,
        }
    }
    fn places(&self) -> usize {
        match self {
            Self::Whole(tree) => tree.order.len(),
            Self::Pair(pair) => pair.places,
        }
    }

    /// The tree in one part.
    pub fn join(self) -> BinaryTree {
        if let Self::Whole(tree) = self {
            return tree;
        }
        const BLANK: BinaryNode = BinaryNode {
            bounds: Aabb::EMPTY,
            first: 0,
            count: 0,
        };
        // Side by side, because the first write to fresh memory takes as long as all that follow.
        let mut nodes = rayon::iter::repeat_n(BLANK, self.nodes()).collect::<alloc::vec::Vec<_>>();
        let mut order = alloc::vec![0; self.places()];
        if let [root, below @ ..] = &mut nodes[..] {
            self.write(root, (below, 1), (&mut order, 0));
        }
        BinaryTree { nodes, order }
    }

    /// Writes the root to its place, what is below it and the places of the order to slices that begin at known numbers.
    fn write(
        self,
        root: &mut BinaryNode,
        (below, at): (&mut [BinaryNode], usize),
        (order, place): (&mut [u32], usize),
    ) {
        let pair = match self {
            Self::Pair(pair) => *pair,
            Self::Whole(tree) => {
                let moved = |node: &BinaryNode| BinaryNode {
                    // The second node of the small tree lies at `at`.
                    first: node.first + if node.is_leaf() { place } else { at - 1 } as u32,
                    ..*node
                };
                let [first, rest @ ..] = &tree.nodes[..] else {
                    return;
                };
                *root = moved(first);
                for (to, node) in below.iter_mut().zip(rest) {
                    *to = moved(node);
                }
                order.copy_from_slice(&tree.order);
                return;
            }
        };
        *root = BinaryNode {
            bounds: pair.bounds,
            first: at as u32,
            count: 0,
        };
        let [a, b] = pair.halves;
        let (roots, below) = below.split_at_mut(2);
        let [root_a, root_b] = roots else {
            return;
        };
        let (nodes, places) = (a.nodes() - 1, a.places());
        let (below_a, below_b) = below.split_at_mut(nodes);
        let (order_a, order_b) = order.split_at_mut(places);
        rayon::join(
            || a.write(root_a, (below_a, at + 2), (order_a, place)),
            || {
                let (at, place) = (at + 2 + nodes, place + places);
                b.write(root_b, (below_b, at), (order_b, place));
            },
        );
    }
}
