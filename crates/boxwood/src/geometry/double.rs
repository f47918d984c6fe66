//! Double-precision lines and vectors: where analytic shapes compute before one rounding to floats.

use super::ray::round_down;
use super::shape::Root;
use super::{Aabb, Ray};
use crate::math::sqrt_f64;
use core::ops::ControlFlow::{self, Continue};

/// A point or direction in double precision.
pub(crate) type Double3 = [f64; 3];

/// The line that a ray runs along, exactly: doubles hold every float.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Where `t = 0`.
    pub origin: [f64; 3],
    /// From `t = 0` to `t = 1`; any length.
    pub direction: [f64; 3],
}

impl Line {
    /// The point at `t`.
    #[inline(always)]
    pub fn at(&self, t: f64) -> [f64; 3] {
        along(self.origin, self.direction, t)
    }

    /// Where the line enters and leaves a closed box given by its corners; `None` when it passes it. A line that runs in
    /// a side is inside that slab. Kay & Kajiya 1986.
    pub(crate) fn slabs(&self, lower: Double3, upper: Double3) -> Option<Chord> {
        let mut chord = Chord::ALL;
        for axis in 0..3 {
            chord = chord.within_slab(
                lower[axis],
                upper[axis],
                self.origin[axis],
                self.direction[axis],
                axis as u8,
            )?;
        }
        Some(chord)
    }
}

impl From<&Ray> for Line {
    #[inline(always)]
    fn from(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array().map(f64::from),
            direction: ray.direction.to_array().map(f64::from),
        }
    }
}

/// The part of a line in a convex body, and which sides it enters and leaves by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chord {
    pub enter: f64,
    pub leave: f64,
    /// The axis of the slab, doubled; one more at its upper side.
    pub sides: [u8; 2],
}

impl Chord {
    pub const ALL: Self = Self {
        enter: f64::NEG_INFINITY,
        leave: f64::INFINITY,
        sides: [0, 0],
    };

    /// What is left of it in `lower <= o + t d <= upper`.
    #[inline(always)]
    pub fn within_slab(mut self, lower: f64, upper: f64, o: f64, d: f64, axis: u8) -> Option<Self> {
        if d == 0.0 {
            return (lower <= o && o <= upper).then_some(self);
        }
        let (first, last, side) = if d < 0.0 {
            (upper, lower, 1)
        } else {
            (lower, upper, 0)
        };
        let (enter, leave) = ((first - o) / d, (last - o) / d);
        if enter > self.enter {
            (self.enter, self.sides[0]) = (enter, 2 * axis + side);
        }
        if leave < self.leave {
            (self.leave, self.sides[1]) = (leave, 2 * axis + 1 - side);
        }
        (self.enter <= self.leave).then_some(self)
    }

    /// Shows both ends, or the one that they are.
    pub fn visit_ends(
        self,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let [first, last] = self.sides;
        visit(Root {
            t: self.enter,
            part: first,
        })?;
        if self.enter < self.leave {
            visit(Root {
                t: self.leave,
                part: last,
            })?;
        }
        Continue(())
    }
}

#[inline(always)]
pub(crate) fn dot(a: Double3, b: Double3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
#[inline(always)]
pub(crate) fn sub(a: Double3, b: Double3) -> Double3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
#[inline(always)]
pub(crate) fn scale(a: Double3, s: f64) -> Double3 {
    [a[0] * s, a[1] * s, a[2] * s]
}
/// `a + s b`.
#[inline(always)]
pub(crate) fn along(a: Double3, b: Double3, s: f64) -> Double3 {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}
#[inline(always)]
pub(crate) fn cross(a: Double3, b: Double3) -> Double3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
#[inline(always)]
pub(crate) fn length(a: Double3) -> f64 {
    sqrt_f64(dot(a, a))
}
/// The vector of length 1; zero where there is none (zero, NaN, infinite).
#[inline]
pub(crate) fn normalized(a: Double3) -> Double3 {
    let largest = a.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if !(largest > 0.0 && largest < f64::INFINITY) {
        return [0.0; 3];
    }
    // First to where no square leaves the normal numbers.
    let a = a.map(|x| x / largest);
    let l = length(a);
    a.map(|x| x / l)
}
/// Two unit vectors that make a right-handed frame with the unit vector `n`; they depend on `n` only.
///
/// Duff et al. 2017, *Building an Orthonormal Basis, Revisited*.
#[inline]
pub(crate) fn frame(n: Double3) -> [Double3; 2] {
    let sign = 1.0_f64.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [
        [1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]],
        [b, sign + n[1] * n[1] * a, -n[1]],
    ]
}

/// The smallest float box around a box in double precision, and around its rounding errors of `2⁻⁵⁰`.
pub(crate) fn outward(lower: Double3, upper: Double3) -> Aabb {
    const U: f64 = 1.0 / (1_u64 << 50) as f64;
    Aabb::new(
        lower.map(|x| round_down(x - x.abs() * U)),
        upper.map(|x| -round_down(-x - x.abs() * U)),
    )
}

/// `centre ± half`, rounded outward.
pub(crate) fn around(centre: Double3, half: Double3) -> Aabb {
    outward(sub(centre, half), along(centre, half, 1.0))
}

/// How far a flat disc of radius 1 with the unit normal `n` reaches along each axis.
pub(crate) fn disc_reach(n: Double3) -> Double3 {
    // 1 − x² as a product: exact where it is nearly zero. A normal may be longer than 1 by a rounding.
    n.map(|x| sqrt_f64(((1.0 - x) * (1.0 + x)).max(0.0)))
}
