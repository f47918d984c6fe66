//! What a structure is made of and what it should cost.

use crate::accel::bvh::BinaryTree;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};

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
    /// of 1 for a node and 1 for a primitive.
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
            primitives: tree.order.len(),
            references: tree.order.len(),
            bytes: size_of_val(&*tree.nodes) + size_of_val(&*tree.order),
            ..Self::default()
        };
        // In double precision: millions of small areas are added up.
        let mut cost = 0.0;
        let mut open = alloc::vec![(0, 0)];
        while let Some((index, depth)) = open.pop() {
            let Some(node) = tree.nodes.get(index) else {
                continue;
            };
            let area = f64::from(node.bounds.half_area());
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
            .map_or(0.0, |root| root.bounds.half_area());
        if root_area > 0.0 {
            found.sah_cost = (cost / f64::from(root_area)) as f32;
        }
        found
    }
}
