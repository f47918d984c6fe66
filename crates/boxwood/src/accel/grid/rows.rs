//! A triangle as rows of cells see it.
//!
//! *How it works.* The cells of a row that a convex shape meets are in one piece, from the least to the greatest
//! coordinate of its part in that row. By the theorem of the separating axis, these are bounded by four things: the
//! triangle's shadow along each of the other two axes, its plane, and the triangle itself. The shadows are found from the
//! edges that cross a slab, the plane from its slopes; nothing is cut. All is computed in double precision, whose errors
//! the pad of the cells covers by far.
//!
//! *Cost.* A few dozen operations for a slab and for a row, two for a cell.
//!
//! *Source.* The bounds are those of Akenine-Möller 2001, *Fast 3D Triangle-Box Overlap Testing*, solved for the coordinate
//! along the row; slabs and rows as in Kaufman 1987, *Efficient Algorithms for 3D Scan-Conversion of Parametric Curves,
//! Surfaces, and Volumes*.

use super::lattice::{Lattice, Range};
use crate::geometry::{
    Vec3,
    double::{cross, sub},
};
use crate::math::{least, most};
use core::ops::ControlFlow::{self, Continue};

/// The least and the greatest value.
type Span = [f64; 2];

/// A triangle's shadow on a plane of two axes: over each place on the first, how far it reaches on the second.
struct Shadow {
    /// The corners' places on the first axis, ascending.
    x: [f64; 3],
    /// On the second.
    y: [f64; 3],
    /// One over the difference of places, from the lowest to the highest, to the middle one, and from there: 0 where
    /// there is none.
    per: [f64; 3],
    /// How far it reaches in all.
    whole: Span,
}

impl Shadow {
    fn of(corners: &[[f64; 3]; 3], along: usize, across: usize) -> Self {
        let [mut a, mut b, mut c] = corners.map(|p| (p[along], p[across]));
        if b.0 < a.0 {
            (a, b) = (b, a);
        }
        if c.0 < b.0 {
            (b, c) = (c, b);
        }
        if b.0 < a.0 {
            (a, b) = (b, a);
        }
        let per = |from: f64, to: f64| if to > from { 1.0 / (to - from) } else { 0.0 };
        Self {
            x: [a.0, b.0, c.0],
            y: [a.1, b.1, c.1],
            per: [per(a.0, c.0), per(a.0, b.0), per(b.0, c.0)],
            whole: [least(least(a.1, b.1), c.1), most(most(a.1, b.1), c.1)],
        }
    }

    /// How far it reaches over an interval, which has places of the triangle in it.
    #[inline]
    fn over(&self, [from, to]: Span) -> Span {
        let ([x0, x1, x2], [y0, y1, y2]) = (self.x, self.y);
        if from <= x0 && x2 <= to {
            return self.whole;
        }
        let mut reach = [f64::INFINITY, f64::NEG_INFINITY];
        for (x, y) in [(x0, y0), (x1, y1), (x2, y2)] {
            if from <= x && x <= to {
                reach = [least(reach[0], y), most(reach[1], y)];
            }
        }
        for x in [most(from, x0), least(to, x2)] {
            let long = y0 + (y2 - y0) * ((x - x0) * self.per[0]);
            let short = if x < x1 {
                y0 + (y1 - y0) * ((x - x0) * self.per[1])
            } else {
                y1 + (y2 - y1) * ((x - x1) * self.per[2])
            };
            reach = [
                least(reach[0], least(long, short)),
                most(reach[1], most(long, short)),
            ];
        }
        reach
    }
}

/// A triangle above a plane of two axes: between which bounds its third coordinate lies over a rectangle.
struct Slope {
    /// How steep it is along the two axes.
    by: [f64; 2],
    /// The third coordinate less what the slopes make of the other two: the same for all corners but for rounding.
    at: Span,
}

/// A plane that is steeper than this says nothing of the third coordinate that its shadows do not, and what it says is
/// more rounding than the pad allows for.
const STEEPEST: f64 = (1 << 20) as f64;

impl Slope {
    /// Any slopes give true bounds, so rounding of the normal does no harm. Flat ones where the plane is too steep.
    fn of(corners: &[[f64; 3]; 3], [a, b, row]: [usize; 3]) -> Self {
        let [p, q, r] = *corners;
        let normal = cross(sub(q, p), sub(r, p));
        let (na, nb, nc) = (normal[a], normal[b], normal[row]);
        let by = if most(na.abs(), nb.abs()) < STEEPEST * nc.abs() {
            [-na / nc, -nb / nc]
        } else {
            [0.0; 2]
        };
        let [u, v, w] = corners.map(|p| p[row] - by[0] * p[a] - by[1] * p[b]);
        Self {
            by,
            at: [least(least(u, v), w), most(most(u, v), w)],
        }
    }

    #[inline]
    fn over(&self, [a0, a1]: Span, [b0, b1]: Span) -> Span {
        let (a, b) = (
            [self.by[0] * a0, self.by[0] * a1],
            [self.by[1] * b0, self.by[1] * b1],
        );
        [
            self.at[0] + least(a[0], a[1]) + least(b[0], b[1]),
            self.at[1] + most(a[0], a[1]) + most(b[0], b[1]),
        ]
    }
}

/// The rows of cells that a triangle may lie in.
pub(super) struct Rows<'a> {
    lattice: &'a Lattice,
    pad: f64,
    range: Range,
    corners: [[f64; 3]; 3],
    /// Across slabs, across rows, and along them.
    axes: [usize; 3],
}

impl<'a> Rows<'a> {
    #[inline]
    pub fn of(corners: [Vec3; 3], lattice: &'a Lattice, pad: f64, range: Range) -> Self {
        // Rows along the axis with the most cells, in slabs across the one with the fewest.
        let [x, y, z] = range.map(|[first, last]| last - first);
        let mut axes = [0, 1, 2];
        let mut sort = |i: usize, j: usize| {
            let span = |axis: usize| [x, y, z][axis];
            if span(axes[j]) < span(axes[i]) {
                axes.swap(i, j);
            }
        };
        sort(0, 1);
        sort(1, 2);
        sort(0, 1);
        Self {
            lattice,
            pad,
            range,
            corners: corners.map(|p| p.to_array().map(f64::from)),
            axes,
        }
    }

    /// A padded cell's interval on an axis.
    #[inline]
    fn cell(&self, axis: usize, number: u32) -> Span {
        let lattice = self.lattice;
        [
            lattice.plane(axis, number) - self.pad,
            lattice.plane(axis, number + 1) + self.pad,
        ]
    }

    /// The cells of the range that, padded, meet an interval: none where the second is less than the first.
    #[inline]
    fn meet(&self, axis: usize, [from, to]: Span) -> [u32; 2] {
        let (lattice, [first, last]) = (self.lattice, self.range[axis]);
        let at = |x: f64| (x - lattice.lower[axis]) / lattice.size[axis];
        let (from, to) = (at(from - self.pad), at(to + self.pad));
        if !(to >= f64::from(first)) {
            return [1, 0];
        }
        [(from as u32).max(first), (to as u32).min(last)]
    }

    /// Shows every cell of the range that the triangle lies in.
    #[inline]
    pub fn each(&self, show: &mut impl FnMut([u32; 3]) -> ControlFlow<()>) -> ControlFlow<()> {
        let [slab, other, row] = self.axes;
        let others = Shadow::of(&self.corners, slab, other);
        let rows = Shadow::of(&self.corners, slab, row);
        let across = Shadow::of(&self.corners, other, row);
        let slope = Slope::of(&self.corners, [slab, other, row]);
        let mut cell = [0; 3];
        for s in self.range[slab][0]..=self.range[slab][1] {
            let in_slab = self.cell(slab, s);
            let by_slab = rows.over(in_slab);
            let [first, last] = self.meet(other, others.over(in_slab));
            cell[slab] = s;
            for o in first..=last {
                let in_row = self.cell(other, o);
                let (by_row, by_plane) = (across.over(in_row), slope.over(in_slab, in_row));
                let from = most(most(by_slab[0], by_row[0]), by_plane[0]);
                let to = least(least(by_slab[1], by_row[1]), by_plane[1]);
                let [first, last] = self.meet(row, [from, to]);
                cell[other] = o;
                for r in first..=last {
                    cell[row] = r;
                    show(cell)?;
                }
            }
        }
        Continue(())
    }
}
