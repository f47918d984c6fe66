//! Swaps children with grandchildren where that makes a box smaller.
//!
//! *How it works.* A node has two children and up to four grandchildren. A child may change places with a child of its
//! sibling, or two grandchildren of different parents with each other: the node's own box stays, those of its children
//! change. From the leaves up, the best of these six swaps is made wherever it saves area.
//!
//! *Cost.* O(n) a round. Cheaper than [`reinsertion`](super::reinsertion), and sooner at its end.
//!
//! *Source.* Kensler 2008, *Tree Rotations for Improving Bounding Volume Hierarchies*.

use super::lay_out::lay_out;
use super::{inner_area, parents_first};
use crate::accel::Limits;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::Site;
use crate::simd::exactly;

/// Nodes between two looks at the clock.
const CHUNK: usize = 4096;

/// Rotates everywhere up to `rounds` times, as long as it saves something.
pub fn rotation(tree: &mut BinaryTree, rounds: usize) {
    let site = Site::new(&Limits::NONE, 1);
    for _ in 0..rounds {
        if !exactly(|| round(tree, &site)) {
            break;
        }
    }
}

/// One round; whether it saved anything.
pub(super) fn round(tree: &mut BinaryTree, site: &Site<'_>) -> bool {
    let before = inner_area(tree);
    let mut rotated = tree.clone();
    let mut nodes = parents_first(tree);
    nodes.reverse();
    for nodes in nodes.chunks(CHUNK) {
        // There are nearly two nodes for each primitive.
        if !site.advance(nodes.len() / 2) {
            return false;
        }
        for &i in nodes {
            rotate(&mut rotated, i as usize);
        }
    }
    lay_out(&mut rotated, |_| false);
    let better = inner_area(&rotated) < before;
    if better {
        *tree = rotated;
    }
    better
}

/// Makes the best swap below a node, if there is one that saves area.
fn rotate(tree: &mut BinaryTree, node: usize) {
    let nodes = &tree.nodes;
    if nodes[node].is_leaf() {
        return;
    }
    let [a, b] = nodes[node].children();
    let below = |i: usize| (!nodes[i].is_leaf()).then(|| nodes[i].children());
    // The area that the box of `parent` loses when of its children `stays` stays and `comes` joins it.
    let saved = |parent: usize, stays: usize, comes: usize| {
        let after = nodes[stays].bounds.union(nodes[comes].bounds);
        nodes[parent].bounds.half_area() - after.half_area()
    };
    let mut best = (0.0, None);
    let mut weigh = |saved: f32, swap: (usize, usize)| {
        if saved > best.0 {
            best = (saved, Some(swap));
        }
    };
    for (child, sibling) in [(a, b), (b, a)] {
        if let Some([x, y]) = below(sibling) {
            weigh(saved(sibling, y, child), (child, x));
            weigh(saved(sibling, x, child), (child, y));
        }
    }
    if let (Some([a0, a1]), Some([b0, b1])) = (below(a), below(b)) {
        // The other two pairings are the same boxes with the children's names swapped.
        weigh(saved(a, a1, b0) + saved(b, b1, a0), (a0, b0));
        weigh(saved(a, a1, b1) + saved(b, b0, a0), (a0, b1));
    }
    let Some((x, y)) = best.1 else {
        return;
    };
    tree.nodes.swap(x, y);
    for child in [a, b] {
        if !tree.nodes[child].is_leaf() {
            let [p, q] = tree.nodes[child].children();
            let bounds = tree.nodes[p].bounds.union(tree.nodes[q].bounds);
            tree.nodes[child].bounds = bounds;
        }
    }
}
