//! Whether some boxes together hold all of a triangle, or of a box.
//!
//! *How it works.* What a box holds whole is done with. Else it is cut in two by a side of one of the boxes, the one nearest to its middle, and
//! each part is looked at with the boxes that it meets. A part that no side cuts and no box holds is not covered.
//! Parts are computed in double precision; by as much as that errs, boxes are taken as larger.
//!
//! *Cost.* O(k log k) for k boxes side by side. Boxes may lie so that it is far more: then the answer is no.

use super::triangle::overlap::Polygon;
use super::{Aabb, Vec3};
use alloc::vec::Vec;

/// Whether boxes hold all of a triangle. What of it lies outside all of them reaches no farther than `slack`.
pub fn holds_triangle(boxes: &[Aabb], triangle: [Vec3; 3], slack: f64) -> bool {
    let polygon = Polygon::of(triangle.map(|v| v.to_array().map(f64::from)));
    holds(boxes, polygon, slack)
}

/// Whether boxes hold all of a box.
pub fn holds_box(boxes: &[Aabb], whole: &Aabb) -> bool {
    whole.is_empty() || holds(boxes, Sides::of(whole), 0.0)
}

fn holds(boxes: &[Aabb], whole: impl Part, slack: f64) -> bool {
    let mut boxes: Vec<Sides> = boxes.iter().map(Sides::of).collect();
    let each = 64 * (4 + boxes.len().max(1).ilog2() as usize);
    let looks = boxes.len().saturating_mul(each).saturating_add(1 << 12);
    let mut search = Search { slack, looks };
    search.covers(&mut boxes, &whole, MOST_CUTS)
}

/// No part is cut out of so many others.
const MOST_CUTS: usize = 128;

/// What can be cut by planes across the axes.
trait Part: Sized {
    /// From where to where it reaches along an axis.
    fn reach(&self, axis: usize) -> (f64, f64);
    /// What lies below a plane and what above.
    fn cut(&self, axis: usize, plane: f64) -> [Self; 2];
}

/// A box in double precision.
#[derive(Clone, Copy)]
struct Sides([(f64, f64); 3]);

impl Sides {
    fn of(b: &Aabb) -> Self {
        Self([0, 1, 2].map(|axis| (f64::from(b.lower[axis]), f64::from(b.upper[axis]))))
    }
}

impl Part for Sides {
    fn reach(&self, axis: usize) -> (f64, f64) {
        self.0[axis]
    }
    fn cut(&self, axis: usize, plane: f64) -> [Self; 2] {
        let (mut below, mut above) = (*self, *self);
        (below.0[axis].1, above.0[axis].0) = (plane, plane);
        [below, above]
    }
}

impl Part for Polygon {
    fn reach(&self, axis: usize) -> (f64, f64) {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let corners = self.corners().iter().map(|p| p[axis]);
        corners.fold(start, |(low, high), x| (low.min(x), high.max(x)))
    }
    fn cut(&self, axis: usize, plane: f64) -> [Self; 2] {
        [self.above(axis, plane, -1.0), self.above(axis, plane, 1.0)]
    }
}

struct Search {
    slack: f64,
    /// How many boxes may still be looked at.
    looks: usize,
}

impl Search {
    /// Whether the boxes, which it brings into another order, hold all of the part.
    fn covers(&mut self, boxes: &mut [Sides], part: &impl Part, cuts: usize) -> bool {
        let slack = self.slack;
        let Some(looks) = self.looks.checked_sub(boxes.len().max(1)) else {
            return false;
        };
        self.looks = looks;
        let reach = [0, 1, 2].map(|axis| part.reach(axis));
        let (mut met, mut best): (_, Option<(f64, usize, f64)>) = (0, None);
        for i in 0..boxes.len() {
            let b = boxes[i].0;
            let along = |axis: usize| (reach[axis], b[axis]);
            if (0..3)
                .map(along)
                .all(|((low, high), (from, to))| low >= from - slack && high <= to + slack)
            {
                return true;
            }
            if (0..3)
                .map(along)
                .any(|((low, high), (from, to))| low > to + slack || high < from - slack)
            {
                continue;
            }
            boxes.swap(met, i);
            met += 1;
            // The side that leaves most on both sides of it, as a share of the reach.
            for (axis, ((low, high), (from, to))) in (0..3).map(along).enumerate() {
                for plane in [from, to] {
                    let rest = (plane - low).min(high - plane);
                    let share = rest / (high - low);
                    if rest > slack && best.is_none_or(|(most, ..)| share > most) {
                        best = Some((share, axis, plane));
                    }
                }
            }
        }
        let (Some((_, axis, plane)), Some(cuts)) = (best, cuts.checked_sub(1)) else {
            return false;
        };
        let boxes = &mut boxes[..met];
        let halves = part.cut(axis, plane);
        halves.iter().all(|half| self.covers(boxes, half, cuts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f32; 3]; 3]) -> [Vec3; 3] {
        corners.map(Vec3::from)
    }

    #[test]
    fn a_hole_is_found_and_none_is_not() {
        let whole = Aabb::new([0.0; 3], [4.0, 4.0, 1.0]);
        let cell = |x: u8, y: u8| {
            let (x, y) = (f32::from(x), f32::from(y));
            Aabb::new([x, y, 0.0], [x + 1.0, y + 1.0, 1.0])
        };
        let all: Vec<Aabb> = (0..16).map(|i| cell(i % 4, i / 4)).collect();
        assert!(holds_box(&all, &whole));
        assert!(holds_box(&[], &Aabb::EMPTY) && !holds_box(&[], &whole));
        let slope = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [0.0, 4.0, 0.5]]);
        assert!(holds_triangle(&all, slope, 0.0));
        for missing in 0..16 {
            let mut some = all.clone();
            some.remove(missing);
            assert!(!holds_box(&some, &whole));
            // Cells beyond the hypotenuse hold at most a point of it.
            let needed = missing % 4 + missing / 4 < 4;
            assert_eq!(!holds_triangle(&some, slope, 1.0e-12), needed, "{missing}");
        }
        // One of the sides ends a little early.
        let mut short = all.clone();
        short[5].upper.x = short[5].upper.x.next_down();
        assert!(!holds_box(&short, &whole) && !holds_triangle(&short, slope, 1.0e-12));
        assert!(holds_triangle(&short, slope, 1.0e-6));
    }

    /// Parts that were cut one out of the other hold the whole.
    #[test]
    fn parts_hold_the_whole() {
        let needle = triangle([[0.1, 0.2, 0.3], [0.15, 0.2, 0.3], [9.7, 9.1, 9.9]]);
        let mut parts = alloc::vec![Aabb::of(needle)];
        for step in 0..6 {
            let halves = parts.iter().flat_map(|b| {
                let axis = step % 3;
                let middle = b.centroid()[axis];
                let (mut below, mut above) = (*b, *b);
                below.upper[axis] = middle;
                above.lower[axis] = middle;
                [below, above].map(|b| super::super::triangle::overlap::clipped_bounds(needle, &b))
            });
            parts = halves.filter(|b| !b.is_empty()).collect();
        }
        assert!(parts.len() > 20);
        assert!(holds_triangle(&parts, needle, 1.0e-11));
        parts.remove(parts.len() / 2);
        assert!(!holds_triangle(&parts, needle, 1.0e-11));
    }

    #[test]
    fn boxes_in_disorder_end_somewhere() {
        // Each leaves a corner out that the next one has.
        let boxes: Vec<Aabb> = (1..400_u16)
            .map(|i| {
                let x = f32::from(i) / 400.0;
                Aabb::new([0.0; 3], [x, 1.0 - x, 1.0])
            })
            .collect();
        assert!(!holds_box(&boxes, &Aabb::new([0.0; 3], [1.0; 3])));
    }
}
