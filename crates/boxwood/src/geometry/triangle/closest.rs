//! The point of a triangle that is closest to a point in space.
//!
//! *How it works.* It lies on an edge, or where the point falls straight down onto the triangle. All four candidates are
//! computed in double precision and the nearest is taken, so that slivers and triangles without area have one as well. An
//! edge is run along from its lesser corner to its greater one, so that both triangles at an edge find the same bits there.
//!
//! *These operations in this order are the definition of a distance*: every structure returns them. Each candidate is at
//! last brought into the box of its edge or triangle, which it may have left by a rounding. Hence the square that is
//! computed for a triangle is never less than the one that [`Extent::distance_squared`](crate::proximity::Extent::distance_squared) computes for a box around it: along
//! each axis the difference to a point in a box is at least that to the box, and subtraction, squaring and addition round
//! monotonically. So no structure ever passes over a triangle that counts, and no slack is needed.
//!
//! *Cost.* About 150 operations and four divisions.
//!
//! *Source.* Ericson 2005, *Real-Time Collision Detection*, 5.1.5, for the regions; Schneider & Eberly 2002.

use crate::geometry::Vec3;
use crate::geometry::double::{Double3, cross, dot, sub};

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The square of the distance to it, as computed.
    pub square: f64,
    pub point: Double3,
    /// Weight of vertex 1.
    pub u: f64,
    /// Weight of vertex 2.
    pub v: f64,
}

/// The point of a triangle closest to `p`; its square is NaN or infinite only where a coordinate is.
#[inline]
pub fn closest(triangle: [Vec3; 3], p: Double3) -> Nearest {
    let [a, b, c] = triangle.map(|v| v.to_array().map(f64::from));
    // Opposite to vertices 2, 0 and 1.
    let mut best = on_edge(a, b, p, |t| [t, 0.0]);
    best = nearer(best, on_edge(b, c, p, |t| [1.0 - t, t]));
    best = nearer(best, on_edge(c, a, p, |t| [0.0, 1.0 - t]));
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let n = cross(ab, ac);
    let square = dot(n, n);
    let v = dot(cross(ap, ac), n) / square;
    let w = dot(cross(ab, ap), n) / square;
    // Fails for NaN: a triangle without area has its edges only.
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        let point = core::array::from_fn(|k| {
            let (least, most) = (min(min(a[k], b[k]), c[k]), max(max(a[k], b[k]), c[k]));
            within(a[k] + ab[k] * v + ac[k] * w, least, most)
        });
        best = nearer(best, at(p, point, [v, w]));
    }
    best
}

/// The closest point of an edge; `weights` says what those of vertices 1 and 2 are where a share of the way to `b` is run.
#[inline(always)]
fn on_edge(a: Double3, b: Double3, p: Double3, weights: impl Fn(f64) -> [f64; 2]) -> Nearest {
    let turned = b < a;
    let (from, to) = if turned { (b, a) } else { (a, b) };
    let along = sub(to, from);
    let t = dot(sub(p, from), along) / dot(along, along);
    // An edge without length gives NaN, and is where it begins.
    let t = if t > 0.0 { min(t, 1.0) } else { 0.0 };
    let point = core::array::from_fn(|k| {
        let x = from[k] + along[k] * t;
        let x = if t == 1.0 { to[k] } else { x };
        within(x, min(from[k], to[k]), max(from[k], to[k]))
    });
    at(p, point, weights(if turned { 1.0 - t } else { t }))
}

#[inline(always)]
fn at(p: Double3, point: Double3, [u, v]: [f64; 2]) -> Nearest {
    let d = sub(p, point);
    Nearest {
        square: dot(d, d),
        point,
        u,
        v,
    }
}

#[inline(always)]
fn nearer(a: Nearest, b: Nearest) -> Nearest {
    if b.square < a.square { b } else { a }
}

#[inline(always)]
fn within(x: f64, least: f64, most: f64) -> f64 {
    min(max(x, least), most)
}
#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
#[inline(always)]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
