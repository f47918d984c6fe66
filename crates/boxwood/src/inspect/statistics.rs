//! What a structure is made of and what it should cost.

use super::Cell;
use crate::accel::bvh::BinaryTree;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST, half_area};
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

    /// Of the nodes and cells that a structure shows; `bytes` stays 0.
    pub fn of_cells(
        primitives: usize,
        world: Aabb,
        cells: impl FnOnce(&mut dyn FnMut(&Cell<'_>)),
    ) -> Self {
        let mut found = Self {
            primitives,
            ..Self::default()
        };
        // In double precision: millions of small areas are added up, and squares of 1e30 and 1e-30 are numbers.
        let mut cost = 0.0;
        cells(&mut |cell| {
            found.depth = found.depth.max(cell.depth as usize);
            let area = half_area(&cell.bounds);
            match cell.primitives {
                None => {
                    found.nodes += 1;
                    cost += f64::from(NODE_COST) * area;
                }
                Some(count) => {
                    found.leaves += 1;
                    found.references += count as usize;
                    found.largest_leaf = found.largest_leaf.max(count as usize);
                    cost += f64::from(PRIMITIVE_COST) * f64::from(count) * area;
                }
            }
        });
        let world_area = half_area(&world);
        if world_area > 0.0 && world_area < f64::INFINITY {
            found.sah_cost = (cost / world_area) as f32;
        }
        found
    }

    /// Of a binary hierarchy.
    pub fn of_tree(tree: &BinaryTree) -> Self {
        let world = tree.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds);
        // Every primitive is in some leaf, so the highest number tells.
        let primitives = tree.order.iter().max().map_or(0, |&id| id as usize + 1);
        Self {
            bytes: size_of_val(&*tree.nodes) + size_of_val(&*tree.order),
            ..Self::of_cells(primitives, world, |show| show_tree(tree, show))
        }
    }
}

fn show_tree(tree: &BinaryTree, show: &mut dyn FnMut(&Cell<'_>)) {
    let mut open = alloc::vec![(0, 0)];
    // A tree has each node once; one from elsewhere may run in circles.
    for _ in 0..tree.nodes.len() {
        let Some((index, depth)) = open.pop() else {
            break;
        };
        let Some(node) = tree.nodes.get(index) else {
            continue;
        };
        show(&Cell {
            node: index as u32,
            depth,
            bounds: node.bounds,
            primitives: node.is_leaf().then_some(node.count),
            sides: &[],
        });
        if !node.is_leaf() {
            open.extend(node.children().map(|child| (child, depth + 1)));
        }
    }
}
