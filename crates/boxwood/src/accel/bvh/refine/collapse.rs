//! Makes leaves of subtrees that are not worth opening.
//!
//! *How it works.* From the leaves up, every subtree of few primitives is weighed against testing all of them at once. Trees
//! that were clustered or cut along a curve have one primitive in a leaf until then.
//!
//! *Cost.* O(n).

use super::lay_out::lay_out;
use super::{area, parents_first};
use crate::accel::bvh::tree::{BinaryTree, MAX_LEAF};
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};

/// Makes leaves of up to `max_leaf` primitives (1 to [`MAX_LEAF`]) wherever the surface-area heuristic finds them no dearer
/// than what they replace.
pub fn collapse_leaves(tree: &mut BinaryTree, max_leaf: usize) {
    let max_leaf = max_leaf.clamp(1, MAX_LEAF) as u32;
    let nodes = &tree.nodes;
    let mut costs = alloc::vec![0.0_f64; nodes.len()];
    let mut primitives = alloc::vec![0_u32; nodes.len()];
    let mut leaf = alloc::vec![false; nodes.len()];
    for i in parents_first(tree).into_iter().rev() {
        let i = i as usize;
        let node = &nodes[i];
        let area = area(node);
        if node.is_leaf() {
            primitives[i] = node.count;
            costs[i] = f64::from(PRIMITIVE_COST) * f64::from(node.count) * area;
            continue;
        }
        let [a, b] = node.children();
        primitives[i] = primitives[a] + primitives[b];
        costs[i] = f64::from(NODE_COST) * area + costs[a] + costs[b];
        let together = f64::from(PRIMITIVE_COST) * f64::from(primitives[i]) * area;
        // Written so that boxes without area, or with an infinite one, stay together.
        if primitives[i] <= max_leaf && !(costs[i] < together) {
            (leaf[i], costs[i]) = (true, together);
        }
    }
    lay_out(tree, |i| leaf[i]);
}
