//! What a structure is made of and what it should cost.

use crate::accel::bvh::BinaryTree;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::geometry::Aabb;

/// Numbers that describe a structure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Statistics {
    /// Primitives that it answers for.
    pub primitives: usize,
    /// Inner nodes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Edges on the longest way from the root to a leaf.
    pub depth: usize,
    /// Primitives named by leaves; more than `primitives` where some lie in several.
    pub references: usize,
    /// The most primitives in a leaf.
    pub largest_leaf: usize,
    /// Bytes that the structure itself takes, without the primitives.
    pub bytes: usize,
    /// What a random ray that meets the root's box should cost, in primitive tests: the surface-area heuristic with a cost
    /// of 1 for a node and 1 for a primitive. Zero where the root's box has no area, or an infinite one.
    pub sah_cost: f32,
}

impl Statistics {
    /// Of testing everything.
    pub fn exhaustive(primitives: usize) -> Self {
        Self {
            primitives,
            leaves: usize::from(primitives > 0),
            references: primitives,
            largest_leaf: primitives,
            sah_cost: PRIMITIVE_COST * primitives as f32,
            ..Self::default()
        }
    }

    /// Of a binary hierarchy.
    pub fn of_tree(tree: &BinaryTree) -> Self {
        let mut found = Self {
            // Every primitive is in some leaf, so the highest number tells.
            primitives: tree.order.iter().max().map_or(0, |&id| id as usize + 1),
            references: tree.order.len(),
            bytes: size_of_val(&*tree.nodes) + size_of_val(&*tree.order),
            ..Self::default()
        };
        // In double precision: millions of small areas are added up, and squares of 1e30 and 1e-30 are numbers.
        let mut cost = 0.0;
        let mut open = alloc::vec![(0, 0)];
        // A tree has each node once; one from elsewhere may run in circles.
        for _ in 0..tree.nodes.len() {
            let Some((index, depth)) = open.pop() else {
                break;
            };
            let Some(node) = tree.nodes.get(index) else {
                continue;
            };
            let area = half_area(&node.bounds);
            found.depth = found.depth.max(depth);
            if node.is_leaf() {
                found.leaves += 1;
                found.largest_leaf = found.largest_leaf.max(node.count as usize);
                cost += f64::from(PRIMITIVE_COST) * f64::from(node.count) * area;
            } else {
                found.nodes += 1;
                cost += f64::from(NODE_COST) * area;
                open.extend(node.children().map(|child| (child, depth + 1)));
            }
        }
        let root_area = tree
            .nodes
            .first()
            .map_or(0.0, |root| half_area(&root.bounds));
        if root_area > 0.0 && root_area < f64::INFINITY {
            found.sah_cost = (cost / root_area) as f32;
        }
        found
    }
}

fn half_area(b: &Aabb) -> f64 {
    let d = |axis: usize| (f64::from(b.upper[axis]) - f64::from(b.lower[axis])).max(0.0);
    d(0) * d(1) + d(1) * d(2) + d(2) * d(0)
}
