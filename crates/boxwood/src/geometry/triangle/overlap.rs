//! Whether a triangle and a box share a point, and around which part of it.
//!
//! *How it works.* Both are convex, so they are apart only if their shadows on some line are: on one of the axes, on the
//! triangle's normal, or on one of the nine cross products of an axis and an edge. The part of a triangle inside a box
//! is what is left of it after six half-spaces have each cut a corner off. Both are computed in double precision from
//! floats: errors of 2⁻⁵⁰ of the coordinates, which callers cover by asking with a slightly larger box.
//!
//! *Source.* Akenine-Möller 2001, *Fast 3D Triangle-Box Overlap Testing*; Sutherland & Hodgman 1974, *Reentrant Polygon
//! Clipping*.

use crate::geometry::double::{Double3 as Point, cross, dot, sub};
use crate::geometry::ray::round_down;
use crate::geometry::{Aabb, Vec3};

/// Whether they share a point; touching counts. An empty box overlaps nothing.
pub fn overlaps(triangle: [Vec3; 3], b: &Aabb) -> bool {
    let around = Aabb::of(triangle);
    if b.is_empty() || around.intersection(*b).is_empty() {
        return false;
    }
    if b.contains(&around) {
        return true;
    }
    let wide = |v: Vec3| v.to_array().map(f64::from);
    let (lower, upper) = (wide(b.lower), wide(b.upper));
    let half: Point = core::array::from_fn(|k| 0.5 * (upper[k] - lower[k]));
    let middle: Point = core::array::from_fn(|k| lower[k] + half[k]);
    let corners = triangle.map(|v| sub(wide(v), middle));
    let edges = [
        sub(corners[1], corners[0]),
        sub(corners[2], corners[1]),
        sub(corners[0], corners[2]),
    ];
    // The shadow of the box around its middle reaches as far as that of its half diagonal.
    let reach = |n: Point| (0..3).map(|k| half[k] * n[k].abs()).sum::<f64>();
    let normal = cross(edges[0], edges[1]);
    // The same for all three but for rounding, which may turn a sliver's normal any way.
    let shadow = corners.map(|p| dot(normal, p));
    if apart(shadow, reach(normal)) {
        return false;
    }
    for edge in edges {
        for axis in 0..3 {
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut line = [0.0; 3];
            (line[j], line[k]) = (-edge[k], edge[j]);
            let shadow = corners.map(|p| dot(line, p));
            if apart(shadow, reach(line)) {
                return false;
            }
        }
    }
    true
}

/// Whether the shadows of a triangle's corners lie on one side of that of a box, which reaches so far to both.
fn apart(shadow: [f64; 3], reach: f64) -> bool {
    let [a, b, c] = shadow;
    a.min(b).min(c) > reach || a.max(b).max(c) < -reach
}

/// Around the part of a triangle that lies in a box, rounded outwards; empty when there is none.
pub fn clipped_bounds(triangle: [Vec3; 3], b: &Aabb) -> Aabb {
    let around = Aabb::of(triangle);
    if b.contains(&around) {
        return around;
    }
    if around.intersection(*b).is_empty() {
        return Aabb::EMPTY;
    }
    // A convex polygon gains at most one corner from each half-space.
    let mut polygon = Polygon::of(triangle.map(|v| v.to_array().map(f64::from)));
    for axis in 0..3 {
        if around.lower[axis] < b.lower[axis] {
            polygon = polygon.above(axis, f64::from(b.lower[axis]), 1.0);
        }
        if around.upper[axis] > b.upper[axis] {
            polygon = polygon.above(axis, f64::from(b.upper[axis]), -1.0);
        }
    }
    let mut part = Aabb::EMPTY;
    for p in polygon.corners() {
        for (axis, &x) in p.iter().enumerate() {
            let (down, up) = (round_down(x), -round_down(-x));
            part.lower[axis] = part.lower[axis].min(down);
            part.upper[axis] = part.upper[axis].max(up);
        }
    }
    // Rounding outwards may have left either.
    part.intersection(around).intersection(*b)
}

const MOST_CORNERS: usize = 9;

/// What is left of a triangle after planes across the axes have cut corners off.
pub(crate) struct Polygon {
    corners: [Point; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    /// All of a triangle.
    pub fn of(triangle: [Point; 3]) -> Self {
        let mut corners = [[0.0; 3]; MOST_CORNERS];
        corners[..3].copy_from_slice(&triangle);
        Self { corners, count: 3 }
    }

    /// Its corners in their order.
    pub fn corners(&self) -> &[Point] {
        &self.corners[..self.count]
    }

    /// The part whose coordinate is at least `plane` (`sign` 1) or at most (`sign` −1).
    pub fn above(&self, axis: usize, plane: f64, sign: f64) -> Self {
        let mut cut = Self {
            corners: [[0.0; 3]; MOST_CORNERS],
            count: 0,
        };
        let over = |p: &Point| (p[axis] - plane) * sign;
        for (i, p) in self.corners().iter().enumerate() {
            let q = &self.corners()[(i + 1) % self.count];
            let (at_p, at_q) = (over(p), over(q));
            if at_p >= 0.0 {
                cut.push(*p);
            }
            if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
                let share = at_p / (at_p - at_q);
                let mut between: Point = core::array::from_fn(|k| p[k] + (q[k] - p[k]) * share);
                between[axis] = plane;
                cut.push(between);
            }
        }
        cut
    }

    fn push(&mut self, p: Point) {
        // Rounding may make a polygon that is not quite convex; its corners are still few.
        if self.count < MOST_CORNERS {
            self.corners[self.count] = p;
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f32; 3]; 3]) -> [Vec3; 3] {
        corners.map(Vec3::from)
    }

    #[test]
    fn a_box_that_only_the_bounds_overlap_is_missed() {
        let slope = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let at = |x: f32, y: f32, z: f32| Aabb::new([x, y, z], [x + 1.0, y + 1.0, z + 1.0]);
        for (b, meets) in [
            (at(0.5, 0.5, -0.5), true),
            (at(2.9, 2.9, -0.5), false),
            (at(1.5, 1.5, -0.5), true),
            // Touches the edge with a corner, and the plane with a side.
            (at(2.0, 2.0, -0.5), true),
            (at(0.5, 0.5, 0.0), true),
            (at(0.5, 0.5, 0.1), false),
            (at(-2.0, 0.0, 0.0), false),
        ] {
            assert_eq!(overlaps(slope, &b), meets, "{b:?}");
            assert_eq!(!clipped_bounds(slope, &b).is_empty(), meets, "{b:?}");
        }
        assert!(!overlaps(slope, &Aabb::EMPTY));
    }

    #[test]
    fn the_part_inside_is_tight() {
        let slope = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 4.0], [0.0, 4.0, 4.0]]);
        let b = Aabb::new([1.0, -1.0, -1.0], [2.0, 9.0, 9.0]);
        let part = clipped_bounds(slope, &b);
        assert_eq!(part, Aabb::new([1.0, 0.0, 1.0], [2.0, 3.0, 4.0]));
        let whole = Aabb::new([-9.0; 3], [9.0; 3]);
        assert_eq!(clipped_bounds(slope, &whole), Aabb::of(slope));
    }

    /// Both tests against each other and against points of the triangle.
    #[test]
    fn no_point_is_lost() {
        let mut state = 1_u64;
        let mut coordinate = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f32 / (1_u64 << 31) as f32 * 8.0 - 4.0
        };
        let mut met = 0;
        for _ in 0..3000 {
            let mut point = || [coordinate(), coordinate(), coordinate()];
            let corners = triangle([point(), point(), point()]);
            let b = Aabb::of([point(), point()]);
            let part = clipped_bounds(corners, &b);
            assert_eq!(overlaps(corners, &b), !part.is_empty());
            met += usize::from(!part.is_empty());
            for i in 0..=20 {
                for k in 0..=20 - i {
                    let (u, v) = (i as f32 / 20.0, k as f32 / 20.0);
                    let p = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                    let inner = Vec3::splat(1.0e-5);
                    let shrunk = Aabb::new(b.lower + inner, b.upper - inner);
                    if shrunk.contains(&Aabb::new(p, p)) {
                        let near = Aabb::new(part.lower - inner, part.upper + inner);
                        assert!(near.contains(&Aabb::new(p, p)));
                    }
                }
            }
        }
        assert!((500..2500).contains(&met), "{met}");
    }
}
