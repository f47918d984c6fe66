//! A few boxes around an object, from which its boxes in the world are made.
//!
//! *How it works.* The object's box is cut into 4 × 4 × 4 cells; every primitive counts to the cell of its box's middle, and each
//! cell has the box of its own primitives. Turned into the world, so many small boxes overestimate the object much less than
//! its one large box does: a ball that is turned by 45° fills a box of 1.1 times its true width instead of 1.7 times. Only the
//! primitives' own boxes are asked, so that the outline is the same whatever structure stands over them.
//!
//! *Cost.* Two looks at every primitive; at most 64 boxes.

use crate::geometry::Aabb;
use crate::primitive::{Primitives, bounds_of};
use alloc::vec::Vec;

/// Cells along each axis.
const CELLS: usize = 4;

/// Boxes that hold all primitives; none for none.
pub(super) fn of(primitives: &impl Primitives) -> Vec<Aabb> {
    let around = bounds_of(primitives);
    if around.is_empty() {
        return Vec::new();
    }
    let mut cells = [Aabb::EMPTY; CELLS * CELLS * CELLS];
    for i in 0..primitives.len() {
        let own = primitives.bounds(i);
        if !own.is_empty() {
            let cell = &mut cells[cell_of(&own, &around)];
            *cell = cell.union(own);
        }
    }
    cells.into_iter().filter(|cell| !cell.is_empty()).collect()
}

fn cell_of(own: &Aabb, around: &Aabb) -> usize {
    let middle = own.centroid();
    (0..3).fold(0, |cell, axis| {
        let (lower, upper) = (around.lower[axis], around.upper[axis]);
        let share =
            (f64::from(middle[axis]) - f64::from(lower)) / (f64::from(upper) - f64::from(lower));
        // A flat box has no shares; casting makes 0 of NaN.
        cell * CELLS + ((share * CELLS as f64) as usize).min(CELLS - 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Shapes, Sphere, TriangleMesh};

    #[test]
    fn everything_is_in_some_box() {
        let ball = |i: i32| {
            let [x, y, z] = [i % 7, i / 7 % 7, i / 49].map(|k| (k - 3) as f32);
            Sphere::new([x, y, z], 0.5)
        };
        let balls = Shapes::new((0..343).map(ball)).expect("good spheres");
        let outline = of(&balls);
        assert_eq!(outline.len(), 64);
        assert!((0..343).all(|i| outline.iter().any(|b| b.contains(&balls.bounds(i)))));
    }

    #[test]
    fn flat_and_empty_sets_have_outlines() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let flat = TriangleMesh::new(corners, [[0_u32, 1, 2]]).expect("a good mesh");
        assert_eq!(of(&flat), [Aabb::of(corners)]);
        assert!(of(&TriangleMesh::default()).is_empty());
    }
}
