//! Lays the nodes of a tree out depth-first, and halves what lies too deep.
//!
//! *How it works.* The tree is copied from the root, the left side first, so that what a ray meets next lies next. A subtree
//! that could not end within [`MAX_DEPTH`] if its children were kept is built anew over the same leaves: halved by their
//! number, in the order in which they lie.

use super::parents_first;
use crate::accel::bvh::tree::{BinaryNode, BinaryTree, MAX_DEPTH};
use crate::geometry::Aabb;
use alloc::vec::Vec;

/// What a node is copied from.
enum Source {
    /// A node of the old tree.
    Node(usize),
    /// A run of the leaves that are arranged anew.
    Run(usize, usize),
}

/// Copies a tree depth-first. Nodes for which `becomes_leaf` holds take everything below them.
pub(super) fn lay_out(tree: &mut BinaryTree, becomes_leaf: impl Fn(usize) -> bool) {
    if tree.nodes.is_empty() {
        return;
    }
    let old = &*tree;
    let is_leaf = |i: usize| old.nodes[i].is_leaf() || becomes_leaf(i);
    let mut leaves = alloc::vec![1_u32; old.nodes.len()];
    for i in parents_first(old).into_iter().rev() {
        let i = i as usize;
        if !is_leaf(i) {
            let [a, b] = old.nodes[i].children();
            leaves[i] = leaves[a] + leaves[b];
        }
    }
    // As many levels as halving takes from a node on.
    let levels = |leaves: u32| (u32::BITS - (leaves - 1).leading_zeros()) as usize;
    let mut nodes: Vec<BinaryNode> = Vec::with_capacity(2 * leaves[0] as usize);
    let mut order = Vec::with_capacity(old.order.len());
    let mut arranged: Vec<u32> = Vec::new();
    nodes.push(old.nodes[0]);
    let mut open = alloc::vec![(Source::Node(0), 0, 0)];
    while let Some((source, to, depth)) = open.pop() {
        let halves = match source {
            Source::Node(i) if is_leaf(i) => {
                nodes[to].first = order.len() as u32;
                append_places(old, i, &mut order);
                nodes[to].count = order.len() as u32 - nodes[to].first;
                continue;
            }
            Source::Node(i) => {
                let children = old.nodes[i].children();
                let fits = |child: &usize| depth + 1 + levels(leaves[*child]) <= MAX_DEPTH;
                if children.iter().all(fits) {
                    children.map(Source::Node)
                } else {
                    let start = arranged.len();
                    append_leaves(old, i, &is_leaf, &mut arranged);
                    halve(start, arranged.len())
                }
            }
            Source::Run(start, end) => halve(start, end),
        };
        // A run of one is that leaf.
        let halves = halves.map(|half| match half {
            Source::Run(start, end) if end - start == 1 => Source::Node(arranged[start] as usize),
            other => other,
        });
        let pair = nodes.len();
        nodes[to].first = pair as u32;
        nodes[to].count = 0;
        nodes.extend(halves.iter().map(|half| {
            match *half {
                Source::Node(i) => old.nodes[i],
                Source::Run(start, end) => BinaryNode {
                    bounds: arranged[start..end]
                        .iter()
                        .fold(Aabb::EMPTY, |b, &i| b.union(old.nodes[i as usize].bounds)),
                    first: 0,
                    count: 0,
                },
            }
        }));
        let [left, right] = halves;
        open.push((right, pair + 1, depth + 1));
        open.push((left, pair, depth + 1));
    }
    *tree = BinaryTree { nodes, order };
}

fn halve(start: usize, end: usize) -> [Source; 2] {
    let middle = start + (end - start) / 2;
    [Source::Run(start, middle), Source::Run(middle, end)]
}

/// Appends the leaves below a node from left to right.
fn append_leaves(
    tree: &BinaryTree,
    root: usize,
    is_leaf: &impl Fn(usize) -> bool,
    found: &mut Vec<u32>,
) {
    let mut open = alloc::vec![root];
    while let Some(i) = open.pop() {
        if is_leaf(i) {
            found.push(i as u32);
        } else {
            let [a, b] = tree.nodes[i].children();
            open.extend([b, a]);
        }
    }
}

/// Appends the primitives below a node. Of a leaf they stay as they are; of several leaves that become one, each
/// primitive is named once, though parts of it may lie in several.
fn append_places(tree: &BinaryTree, root: usize, order: &mut Vec<u32>) {
    let nodes = &tree.nodes;
    if nodes[root].is_leaf() {
        order.extend(&tree.order[nodes[root].places()]);
        return;
    }
    let mut ids: Vec<u32> = Vec::new();
    let mut leaves = Vec::new();
    append_leaves(tree, root, &|i| nodes[i].is_leaf(), &mut leaves);
    for leaf in leaves {
        ids.extend(&tree.order[nodes[leaf as usize].places()]);
    }
    ids.sort_unstable();
    ids.dedup();
    order.extend(ids);
}
