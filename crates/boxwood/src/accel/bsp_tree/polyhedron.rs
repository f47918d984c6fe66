//! Convex cells of slanted planes: their surface, and cutting them in two.
//!
//! *How it works.* A polyhedron is its sides, each a loop of corners. A plane cuts every side as it cuts any polygon
//! (Sutherland & Hodgman 1974); what it leaves open is closed by one more side, the corners on the plane in the order of
//! their angles. Everything is double precision. Nothing but the heuristic and drawings depends on a cell's shape, so
//! rounding can make a tree slower, but never wrong.

use crate::geometry::{Aabb, Vec3};
use crate::math;
use alloc::vec::Vec;

pub(super) type Point = [f64; 3];

pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
pub(super) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
pub(super) fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Where the way from `p` to `q` meets the plane at whose sides they lie, at signed distances `at_p` and `at_q`.
#[inline]
pub(super) fn between(p: Point, at_p: f64, q: Point, at_q: f64) -> Point {
    let share = at_p / (at_p - at_q);
    core::array::from_fn(|k| p[k] + (q[k] - p[k]) * share)
}

/// The part of a polygon on one side of a plane, appended to `part`: where `distance` is not positive.
pub(super) fn clip(polygon: &[Point], distance: impl Fn(Point) -> f64, part: &mut Vec<Point>) {
    let Some(&last) = polygon.last() else { return };
    let (mut p, mut at_p) = (last, distance(last));
    for &q in polygon {
        let at_q = distance(q);
        if at_p < 0.0 && at_q > 0.0 || at_p > 0.0 && at_q < 0.0 {
            part.push(between(p, at_p, q, at_q));
        }
        if at_q <= 0.0 {
            part.push(q);
        }
        (p, at_p) = (q, at_q);
    }
}

/// Twice the area of a polygon as a vector along its normal.
fn double_area(polygon: &[Point]) -> Point {
    let mut sum = [0.0; 3];
    let [first, others @ ..] = polygon else {
        return sum;
    };
    for pair in others.windows(2) {
        add(&mut sum, cross(sub(pair[0], *first), sub(pair[1], *first)));
    }
    sum
}

fn add(sum: &mut Point, p: Point) {
    for axis in 0..3 {
        sum[axis] += p[axis];
    }
}

fn length(p: Point) -> f64 {
    math::sqrt_f64(dot(p, p))
}

/// A convex polyhedron by its sides.
#[derive(Clone, Debug)]
pub(super) struct Polyhedron {
    sides: Vec<Vec<Point>>,
}

impl Polyhedron {
    /// A box.
    pub fn of(b: &Aabb) -> Self {
        let corner = |bits: usize| {
            core::array::from_fn(|axis| {
                let upper = bits >> axis & 1 == 1;
                f64::from(if upper { b.upper[axis] } else { b.lower[axis] })
            })
        };
        // The corners of each side in a loop, seen from outside against the clock.
        let side = |loops: [usize; 4]| loops.map(corner).to_vec();
        let sides = [
            side([0, 4, 6, 2]),
            side([1, 3, 7, 5]),
            side([0, 1, 5, 4]),
            side([2, 6, 7, 3]),
            side([0, 2, 3, 1]),
            side([4, 5, 7, 6]),
        ];
        Self {
            sides: sides.into(),
        }
    }

    /// The whole surface.
    pub fn area(&self) -> f64 {
        let areas = self.sides.iter().map(|side| length(double_area(side)));
        0.5 * areas.sum::<f64>()
    }

    /// The surfaces of the part below a plane and of that above.
    pub fn areas_cut(&self, distance: impl Fn(Point) -> f64, buffer: &mut Vec<Point>) -> [f64; 2] {
        let (mut below, mut above) = (0.0, 0.0);
        // The ways across the sides close to a loop: its area is a sum, whatever the order.
        let mut hole = [0.0; 3];
        let mut anchor = None;
        for side in &self.sides {
            buffer.clear();
            let (mut first, mut last) = (None, None);
            let whole = length(double_area(side));
            let (mut p, mut at_p) = match side.last() {
                Some(&p) => (p, distance(p)),
                None => continue,
            };
            for &q in side {
                let at_q = distance(q);
                if (at_p <= 0.0) != (at_q <= 0.0) {
                    let on = between(p, at_p, q, at_q);
                    if at_p <= 0.0 {
                        first = Some(on);
                    } else {
                        last = Some(on);
                    }
                    buffer.push(on);
                }
                if at_q <= 0.0 {
                    buffer.push(q);
                }
                (p, at_p) = (q, at_q);
            }
            let part = if buffer.len() < 3 {
                0.0
            } else {
                length(double_area(buffer))
            };
            below += part;
            above += (whole - part).max(0.0);
            if let (Some(from), Some(to)) = (first, last) {
                let anchor = *anchor.get_or_insert(from);
                add(&mut hole, cross(sub(from, anchor), sub(to, anchor)));
            }
        }
        let hole = length(hole);
        [0.5 * (below + hole), 0.5 * (above + hole)]
    }

    /// The part below a plane (where `distance` is not positive); `normal` is the plane's.
    pub fn below(&self, normal: Point, distance: impl Fn(Point) -> f64) -> Self {
        let mut sides = Vec::with_capacity(self.sides.len() + 1);
        let mut lid: Vec<Point> = Vec::new();
        for side in &self.sides {
            let mut part = Vec::with_capacity(side.len() + 1);
            clip(side, &distance, &mut part);
            let mut p = *side.last().unwrap_or(&[0.0; 3]);
            for &q in side {
                let (at_p, at_q) = (distance(p), distance(q));
                if at_p < 0.0 && at_q > 0.0 || at_p > 0.0 && at_q < 0.0 {
                    lid.push(between(p, at_p, q, at_q));
                } else if at_q == 0.0 {
                    lid.push(q);
                }
                p = q;
            }
            if part.len() >= 3 {
                sides.push(part);
            }
        }
        order_round(&mut lid, normal);
        // A side that lies in the plane is its own lid.
        let is_cut = self.sides.iter().flatten().any(|&p| distance(p) > 0.0);
        if lid.len() >= 3 && is_cut {
            sides.push(lid);
        }
        Self { sides }
    }

    /// Around all corners.
    pub fn bounds(&self) -> Aabb {
        let corners = self.sides.iter().flatten();
        Aabb::of(corners.map(|p| p.map(|x| x as f32)))
    }

    /// The sides as drawings want them.
    pub fn drawn(&self) -> Vec<Vec<Vec3>> {
        let side = |side: &Vec<Point>| side.iter().map(|p| p.map(|x| x as f32).into()).collect();
        self.sides.iter().map(side).collect()
    }
}

/// Puts points of a plane in the order of their angles around their middle, each once.
fn order_round(points: &mut Vec<Point>, normal: Point) {
    let mut middle = [0.0; 3];
    for &p in points.iter() {
        add(&mut middle, p);
    }
    let middle = middle.map(|x| x / points.len().max(1) as f64);
    // Two directions in the plane: away from the axis that the normal is farthest from.
    let axis = (0..3).fold(0, |least, k| {
        if normal[k].abs() < normal[least].abs() {
            k
        } else {
            least
        }
    });
    let mut along = [0.0; 3];
    along[axis] = 1.0;
    let x = cross(normal, along);
    let y = cross(normal, x);
    // Grows with the angle, from −2 to 2.
    let turn = |p: &Point| {
        let from = sub(*p, middle);
        let (x, y) = (dot(from, x), dot(from, y));
        let size = x.abs() + y.abs();
        let slope = if size > 0.0 { x / size } else { 0.0 };
        if y < 0.0 { slope - 1.0 } else { 1.0 - slope }
    };
    points.sort_by(|p, q| turn(p).total_cmp(&turn(q)));
    points.dedup();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_of_a_cube_in_two() {
        let cube = Polyhedron::of(&Aabb::new([0.0; 3], [1.0; 3]));
        assert!((cube.area() - 6.0).abs() < 1.0e-12);
        let mut buffer = Vec::new();
        // Straight, along a diagonal, a corner off, and past it.
        let root = 2.0_f64.sqrt();
        let corner = 1.5 + 0.5 * 3.0_f64.sqrt();
        for (normal, offset, below, above) in [
            ([1.0, 0.0, 0.0], 0.25, 3.0, 5.0),
            ([1.0, -1.0, 0.0], 0.0, 3.0 + root, 3.0 + root),
            (
                [1.0, 1.0, 1.0],
                1.0,
                corner,
                6.0 - 1.5 + 0.5 * 3.0_f64.sqrt(),
            ),
            ([1.0, 0.0, 0.0], 2.0, 6.0, 0.0),
        ] {
            let distance = |p: Point| dot(normal, p) - offset;
            let found = cube.areas_cut(distance, &mut buffer);
            assert!((found[0] - below).abs() < 1.0e-9, "{normal:?}: {found:?}");
            assert!((found[1] - above).abs() < 1.0e-9, "{normal:?}: {found:?}");
            let part = cube.below(normal, distance);
            assert!((part.area() - below).abs() < 1.0e-9, "{normal:?}: {part:?}");
            let rest = cube.below(normal.map(|x| -x), |p| -distance(p));
            assert!((rest.area() - above).abs() < 1.0e-9, "{normal:?}: {rest:?}");
        }
    }
}
