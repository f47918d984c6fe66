//! Makes leaves of subtrees that are not worth opening.
//!
//! *How it works.* From the leaves up, every subtree of few primitives is weighed against testing all of them at once. Trees
//! that were clustered or cut along a curve have one primitive in a leaf until then. The tree is copied depth-first while it
//! is weighed: where the primitives of a subtree stay together, the copies of its nodes are taken back. Subtrees of a large
//! tree are copied side by side.
//!
//! *Cost.* O(n).

use super::area;
use super::lay_out::lay_out;
#[cfg(feature = "parallel")]
use crate::accel::bvh::assemble::Parts;
use crate::accel::bvh::tree::{BinaryNode, BinaryTree, MAX_DEPTH, MAX_LEAF};
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::simd::exactly;
#[cfg(feature = "parallel")]
use crate::threads;
use alloc::vec::Vec;

/// Makes leaves of up to `max_leaf` primitives (1 to [`MAX_LEAF`]) wherever the surface-area heuristic finds them no dearer
/// than what they replace.
pub fn collapse_leaves(tree: &mut BinaryTree, max_leaf: usize) {
    if tree.nodes.is_empty() {
        return;
    }
    let max_leaf = max_leaf.clamp(1, MAX_LEAF) as u32;
    exactly(|| {
        let (collapsed, depth) = collapsed(tree, max_leaf);
        *tree = collapsed;
        if depth > MAX_DEPTH {
            lay_out(tree, |_| false);
        }
    });
}

/// What a subtree costs.
#[derive(Clone, Copy)]
struct Weight {
    cost: f64,
    primitives: u32,
    /// Of the deepest leaf, under the subtree's root.
    depth: usize,
}

impl Weight {
    fn of_leaf(node: &BinaryNode) -> Self {
        Self {
            cost: f64::from(PRIMITIVE_COST) * f64::from(node.count) * area(node),
            primitives: node.count,
            depth: 0,
        }
    }
    /// The weight of a node above two others, and whether it becomes a leaf.
    fn above(node: &BinaryNode, [a, b]: [Self; 2], max_leaf: u32) -> (Self, bool) {
        let primitives = a.primitives + b.primitives;
        let apart = f64::from(NODE_COST) * area(node) + a.cost + b.cost;
        let together = f64::from(PRIMITIVE_COST) * f64::from(primitives) * area(node);
        // Written so that boxes without area, or with an infinite one, stay together.
        let leaf = primitives <= max_leaf && !(apart < together);
        let weight = Self {
            cost: if leaf { together } else { apart },
            primitives,
            depth: if leaf { 0 } else { 1 + a.depth.max(b.depth) },
        };
        (weight, leaf)
    }
}

/// The tree with its leaves collapsed, and its depth.
#[cfg(not(feature = "parallel"))]
fn collapsed(tree: &BinaryTree, max_leaf: u32) -> (BinaryTree, usize) {
    let (copied, weight) = copy(tree, 0, max_leaf);
    (copied, weight.depth)
}

/// So many levels below the root subtrees are copied side by side.
#[cfg(feature = "parallel")]
const LEVELS: usize = 10;
/// Trees of fewer nodes are copied by one thread.
#[cfg(feature = "parallel")]
const FEW_NODES: usize = 8192;

#[cfg(feature = "parallel")]
fn collapsed(tree: &BinaryTree, max_leaf: u32) -> (BinaryTree, usize) {
    let levels = if tree.nodes.len() < FEW_NODES {
        0
    } else {
        LEVELS
    };
    let (parts, weight) = copy_parts(tree, 0, levels, max_leaf);
    (parts.join(), weight.depth)
}

#[cfg(feature = "parallel")]
fn copy_parts(tree: &BinaryTree, root: usize, levels: usize, max_leaf: u32) -> (Parts, Weight) {
    let node = &tree.nodes[root];
    if levels == 0 || node.is_leaf() {
        let (copied, weight) = copy(tree, root, max_leaf);
        return (Parts::Whole(copied), weight);
    }
    let [a, b] = node.children();
    let ((a, weight_a), (b, weight_b)) = threads::join(
        || copy_parts(tree, a, levels - 1, max_leaf),
        || copy_parts(tree, b, levels - 1, max_leaf),
    );
    let (weight, leaf) = Weight::above(node, [weight_a, weight_b], max_leaf);
    let mut parts = Parts::pair([a, b], node.bounds);
    if leaf {
        let mut order = parts.join().order;
        gather(&mut order, 0);
        let nodes = alloc::vec![BinaryNode {
            bounds: node.bounds,
            first: 0,
            count: order.len() as u32,
        }];
        parts = Parts::Whole(BinaryTree { nodes, order });
    }
    (parts, weight)
}

/// Makes one leaf of the places from `first` on. Of several leaves that become one each primitive is named once, though
/// parts of it may lie in several.
fn gather(order: &mut Vec<u32>, first: usize) {
    order[first..].sort_unstable();
    let mut kept = first;
    for i in first..order.len() {
        if kept == first || order[kept - 1] != order[i] {
            order[kept] = order[i];
            kept += 1;
        }
    }
    order.truncate(kept);
}

/// What is to be done with a node of the old tree.
enum Step {
    /// Copy it to this place, and all below it.
    Copy { node: usize, to: usize },
    /// All below has been copied, to the pairs from `pair` and the places from `first` on: weigh it.
    Weigh {
        node: usize,
        to: usize,
        pair: usize,
        first: usize,
    },
}

/// A subtree with its leaves collapsed.
fn copy(tree: &BinaryTree, root: usize, max_leaf: u32) -> (BinaryTree, Weight) {
    let (mut nodes, mut order) = (Vec::new(), Vec::new());
    nodes.push(tree.nodes[root]);
    let mut weights: Vec<Weight> = Vec::new();
    let mut steps = alloc::vec![Step::Copy { node: root, to: 0 }];
    while let Some(step) = steps.pop() {
        match step {
            Step::Copy { node, to } => {
                let old = &tree.nodes[node];
                nodes[to] = *old;
                if old.is_leaf() {
                    nodes[to].first = order.len() as u32;
                    order.extend(&tree.order[old.places()]);
                    weights.push(Weight::of_leaf(old));
                    continue;
                }
                let [a, b] = old.children();
                let (pair, first) = (nodes.len(), order.len());
                nodes[to].first = pair as u32;
                nodes.extend([*old; 2]);
                steps.push(Step::Weigh {
                    node,
                    to,
                    pair,
                    first,
                });
                steps.push(Step::Copy {
                    node: b,
                    to: pair + 1,
                });
                steps.push(Step::Copy { node: a, to: pair });
            }
            Step::Weigh {
                node,
                to,
                pair,
                first,
            } => {
                let (Some(b), Some(a)) = (weights.pop(), weights.pop()) else {
                    break;
                };
                let (weight, leaf) = Weight::above(&tree.nodes[node], [a, b], max_leaf);
                if leaf {
                    nodes.truncate(pair);
                    gather(&mut order, first);
                    nodes[to].first = first as u32;
                    nodes[to].count = (order.len() - first) as u32;
                }
                weights.push(weight);
            }
        }
    }
    let weight = weights.pop().unwrap_or(Weight::of_leaf(&nodes[0]));
    (BinaryTree { nodes, order }, weight)
}
