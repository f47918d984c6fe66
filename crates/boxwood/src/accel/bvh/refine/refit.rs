//! Follows primitives that have moved.
//!
//! *How it works.* Boxes are made anew from the leaves up; who lies where stays as it is. After small movements that is as
//! good as building, after large ones boxes overlap and [`reinsertion`](super::reinsertion) or a new build is due.
//!
//! *Cost.* O(n): one look at every primitive.

use super::lay_out::lay_out;
use super::parents_first;
use crate::accel::bvh::tree::BinaryTree;
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use crate::simd::exactly;

/// Fits the boxes of a tree to primitives that have moved, of the same number as before.
///
/// Where a builder has cut primitives ([`SpatialSplit`](crate::SpatialSplit)), each of their leaves grows around the whole
/// primitive: every answer stays right, but what the cuts had gained is lost.
///
/// # Panics
/// When there are fewer primitives than the tree names.
pub fn refit(tree: &mut BinaryTree, primitives: &impl Primitives) {
    exactly(|| follow(tree, primitives));
}

fn follow(tree: &mut BinaryTree, primitives: &impl Primitives) {
    for i in parents_first(tree).into_iter().rev() {
        let node = tree.nodes[i as usize];
        tree.nodes[i as usize].bounds = if node.is_leaf() {
            let ids = tree.order[node.places()].iter();
            ids.fold(Aabb::EMPTY, |b, &id| {
                b.union(primitives.bounds(id as usize))
            })
        } else {
            let [a, b] = node.children();
            tree.nodes[a].bounds.union(tree.nodes[b].bounds)
        };
    }
    lay_out(tree, |_| false);
}
