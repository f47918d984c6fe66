//! In which cells of a lattice a primitive lies.
//!
//! *How it works.* Where a primitive's box spans cells on one axis only, it lies in all of them. A triangle in more is gone
//! through [row by row](super::rows). Anything else that is exact is asked itself, by halves of the range of cells.

use super::lattice::{Lattice, Range};
use super::rows::Rows;
use crate::accel::cells::Space;
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use core::ops::ControlFlow::{self, Continue};

impl Lattice {
    /// Shows every cell that primitive `i` lies in and that, padded, meets `around`: its box, or less where the rest is
    /// none of this lattice's business. Some part of it lies there.
    #[inline]
    pub fn overlapped<P: Primitives>(
        &self,
        space: &Space,
        primitives: &P,
        i: usize,
        around: &Aabb,
        show: &mut impl FnMut([u32; 3]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let range = self.range(around, space.pad());
        let [x, y, z] = range.map(|[first, last]| first < last);
        if !(x || y || z) {
            return show(range.map(|[first, _]| first));
        }
        if !space.is_exact::<P>() {
            return each(&range, show);
        }
        let Some(corners) = primitives.corners(i) else {
            return self.bisected(space, primitives, i, range, show);
        };
        // A line of cells, and nothing of the triangle beyond it.
        if u8::from(x) + u8::from(y) + u8::from(z) == 1 && around.contains(&Aabb::of(corners)) {
            return each(&range, show);
        }
        Rows::of(corners, self, f64::from(space.pad()), range).each(show)
    }

    /// The cells of a range that hold the primitive, by halves.
    #[cold]
    fn bisected<P: Primitives>(
        &self,
        space: &Space,
        primitives: &P,
        i: usize,
        range: Range,
        show: &mut impl FnMut([u32; 3]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if !space.holds(primitives, i, &self.bounds(&range)) {
            return Continue(());
        }
        let cells = range.map(|[first, last]| last - first);
        let axis = (0..3).max_by_key(|&k| cells[k]).unwrap_or(0);
        if cells[axis] == 0 {
            return show(range.map(|[first, _]| first));
        }
        let middle = range[axis][0] + cells[axis] / 2;
        let (mut low, mut high) = (range, range);
        low[axis][1] = middle;
        high[axis][0] = middle + 1;
        self.bisected(space, primitives, i, low, show)?;
        self.bisected(space, primitives, i, high, show)
    }
}

#[inline]
fn each(range: &Range, show: &mut impl FnMut([u32; 3]) -> ControlFlow<()>) -> ControlFlow<()> {
    let &[[x0, x1], [y0, y1], [z0, z1]] = range;
    for z in z0..=z1 {
        for y in y0..=y1 {
            for x in x0..=x1 {
                show([x, y, z])?;
            }
        }
    }
    Continue(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriangleMesh;
    use crate::geometry::PreparedRay;
    use crate::query::{Counters, Query};
    use alloc::vec::Vec;

    fn triangles(count: u32) -> TriangleMesh {
        let mut state = 7_u64;
        let mut coordinate = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f32 / (1_u64 << 31) as f32
        };
        let positions: Vec<[f32; 3]> = (0..3 * count)
            .map(|i| {
                let size = if i % 6 < 3 { 1.0 } else { 0.2 };
                [(); 3].map(|()| coordinate() * size)
            })
            .collect();
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        TriangleMesh::new(positions, triangles).expect("a good mesh")
    }

    /// What is found in a lattice, and what holds the primitive by the plain test.
    fn found_and_held<P: Primitives>(
        lattice: &Lattice,
        space: &Space,
        primitives: &P,
        i: usize,
        around: &Aabb,
    ) -> [Vec<[u32; 3]>; 2] {
        let mut found = Vec::new();
        let ended = lattice.overlapped(space, primitives, i, around, &mut |cell| {
            found.push(cell);
            Continue(())
        });
        assert!(ended.is_continue());
        found.sort_unstable();
        let cells = (0..lattice.cells() as usize).map(|number| lattice.place(number));
        let mut held: Vec<_> = cells
            .filter(|&cell| space.holds(primitives, i, &lattice.cell(cell)))
            .collect();
        held.sort_unstable();
        [found, held]
    }

    #[test]
    fn cells_are_those_that_hold_the_triangle() {
        let mesh = triangles(200);
        let space = Space::of(&mesh).with_pad(320.0);
        let lattice = Lattice::around(&space).divided([9, 7, 11], 1.0e-6);
        let (mut most, mut inside) = (0, 0);
        for i in 0..200 {
            let around = mesh.bounds(i);
            let [found, held] = found_and_held(&lattice, &space, &mesh, i, &around);
            assert_eq!(found, held, "triangle {i}");
            most = most.max(found.len());
            // The cells of a cell: most of the triangle lies elsewhere.
            for &cell in found.iter().take(8) {
                let inner = lattice.inside(cell, [3, 4, 2]);
                let part = around.intersection(space.padded(&lattice.cell(cell)));
                let [found, held] = found_and_held(&inner, &space, &mesh, i, &part);
                assert_eq!(found, held, "triangle {i} in {cell:?}");
                inside += found.len();
            }
        }
        assert!(most > 50 && inside > 2000, "{most} {inside}");
    }

    /// Exact, but not known to be triangles.
    struct Unknown(TriangleMesh);

    impl Primitives for Unknown {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn bounds(&self, i: usize) -> Aabb {
            self.0.bounds(i)
        }
        fn overlaps(&self, i: usize, within: &Aabb) -> bool {
            self.0.overlaps(i, within)
        }
        fn offer<Q: Query, C: Counters>(
            &self,
            i: usize,
            ray: &PreparedRay,
            query: &mut Q,
            counters: &mut C,
        ) -> ControlFlow<()> {
            self.0.offer(i, ray, query, counters)
        }
        const WITHIN_SLACK: bool = true;
    }

    #[test]
    fn other_shapes_are_asked_themselves() {
        let unknown = Unknown(triangles(60));
        let space = Space::of(&unknown).with_pad(320.0);
        let lattice = Lattice::around(&space).divided([6, 5, 7], 1.0e-6);
        for i in 0..60 {
            let around = unknown.bounds(i);
            let [found, held] = found_and_held(&lattice, &space, &unknown, i, &around);
            assert_eq!(found, held, "shape {i}");
        }
    }

    /// Corners in a line or in a point, along axes and askew: their normals are rounding, if anything.
    #[test]
    fn triangles_without_area_lie_where_their_corners_do() {
        let positions = [
            [0.1, 0.2, 0.3],
            [0.7, 0.9, 0.4],
            [1.3, 1.6, 0.5],
            [0.7, 0.2, 0.3],
        ];
        let lines: [[u32; 3]; 5] = [[0, 2, 1], [0, 0, 2], [0, 3, 3], [1, 1, 1], [2, 3, 2]];
        let mesh = TriangleMesh::new(positions, lines).expect("a good mesh");
        let space = Space::of(&mesh).with_pad(320.0);
        let lattice = Lattice::around(&space).divided([8; 3], 1.0e-6);
        for i in 0..lines.len() {
            let around = mesh.bounds(i);
            let [found, held] = found_and_held(&lattice, &space, &mesh, i, &around);
            assert_eq!(found, held, "line {i}");
            for corner in mesh.corners(i).expect("triangles") {
                let at = lattice.range(&Aabb::new(corner, corner), 0.0);
                assert!(found.contains(&at.map(|[first, _]| first)));
            }
        }
    }
}
