//! Looking at a partition: its cells and its figures.

use super::node::Partition;
use crate::accel::sah::half_area;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::geometry::Aabb;
use crate::inspect::{Cell, Statistics};

/// The two parts of a cell.
pub(super) fn halves(cell: &Aabb, axis: usize, plane: f32) -> [Aabb; 2] {
    let (mut below, mut above) = (*cell, *cell);
    below.upper[axis] = plane;
    above.lower[axis] = plane;
    [below, above]
}

/// Shows every node, parents before their children.
pub(super) fn cells(partition: &Partition, show: &mut dyn FnMut(&Cell<'_>)) {
    if partition.nodes.is_empty() {
        return;
    }
    let mut open = alloc::vec![(0, 0, partition.space.world)];
    while let Some((index, depth, bounds)) = open.pop() {
        let node = partition.nodes[index];
        show(&Cell {
            node: index as u32,
            depth,
            bounds,
            primitives: node.is_leaf().then(|| node.count() as u32),
            sides: &[],
        });
        if !node.is_leaf() {
            let [below, above] = halves(&bounds, node.axis(), node.plane());
            open.push((node.child() + 1, depth + 1, above));
            open.push((node.child(), depth + 1, below));
        }
    }
}

/// Primitives that are everywhere count as references, and cost every ray a test.
pub(super) fn statistics(partition: &Partition) -> Statistics {
    let space = &partition.space;
    let mut found = Statistics {
        primitives: partition.primitives,
        references: partition.references.len() + space.everywhere.len(),
        bytes: size_of_val(&*partition.nodes)
            + size_of_val(&*partition.references)
            + size_of_val(&*space.everywhere),
        ..Statistics::default()
    };
    let mut cost = 0.0;
    cells(partition, &mut |cell| {
        let area = half_area(&cell.bounds);
        found.depth = found.depth.max(cell.depth as usize);
        if let Some(count) = cell.primitives {
            found.leaves += 1;
            found.largest_leaf = found.largest_leaf.max(count as usize);
            cost += f64::from(PRIMITIVE_COST) * f64::from(count) * area;
        } else {
            found.nodes += 1;
            cost += f64::from(NODE_COST) * area;
        }
    });
    let whole = half_area(&space.world);
    if whole > 0.0 && whole < f64::INFINITY {
        found.sah_cost = (cost / whole) as f32 + PRIMITIVE_COST * space.everywhere.len() as f32;
    }
    found
}
