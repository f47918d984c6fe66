//! Tori.
//!
//! *How it works.* The line is moved so that it begins where it passes the torus' centre, and scaled so that the torus fits
//! the unit ball: the quartic's coefficients are then near 1, wherever the ray comes from. Its roots within the ball are
//! found by cutting it at the roots of its derivatives, which never skips one and knows no special cases.
//! *Cost:* 32 bytes; up to ten monotone searches of about ten evaluations each: some ten triangle tests. *Source:* Yuksel 2022.
//!
//! A ring thinner than 10⁻⁵ of its radius loses digits: squares of both radii meet in one sum.

use super::double::{Line, along, around, disc_reach, dot, frame, length, normalized, scale, sub};
use super::shape::{Place, Root, Shape, ShapeFlaw, all_finite, direction_is_good, length_is_good};
use super::{Aabb, Vec3, roots};
use crate::math::{sqrt_f64, turn};
use core::ops::ControlFlow::{self, Continue};

/// A ring: all points at the distance `minor` from a circle of the radius `major`; met from outside and from inside. With
/// `minor` 0 it is kept and never hit.
///
/// `u` is the angle in turns around the axis, 0 to 1, in the frame that [`Plane`](super::Plane) uses; `v` the angle in turns
/// around the tube, 0 at its outermost circle, a quarter where the axis points. The normal points out of the tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    /// The middle of the hole, world units.
    pub centre: Vec3,
    /// The radius of the circle, world units.
    pub major: f32,
    /// What the ring runs around; any length but zero.
    pub axis: Vec3,
    /// The radius of the tube, world units; less than `major`.
    pub minor: f32,
}

impl Torus {
    /// A torus around an axis.
    pub fn new(
        centre: impl Into<[f32; 3]>,
        axis: impl Into<[f32; 3]>,
        major: f32,
        minor: f32,
    ) -> Self {
        Self {
            centre: centre.into().into(),
            major,
            axis: axis.into().into(),
            minor,
        }
    }
    fn centre(&self) -> [f64; 3] {
        self.centre.to_array().map(f64::from)
    }
    fn axis(&self) -> [f64; 3] {
        normalized(self.axis.to_array().map(f64::from))
    }
}

impl Shape for Torus {
    const NAME: &'static str = "torus";

    fn check(&self) -> Result<(), ShapeFlaw> {
        all_finite([("centre", self.centre.to_array())])?;
        direction_is_good("axis", self.axis.to_array())?;
        length_is_good("major radius", self.major)?;
        length_is_good("minor radius", self.minor)?;
        if self.minor >= self.major {
            return Err(ShapeFlaw::Order {
                smaller: "minor radius",
                than: "less than",
                larger: "major radius",
            });
        }
        Ok(())
    }

    fn bounds(&self) -> Aabb {
        if self.minor == 0.0 {
            return Aabb::EMPTY;
        }
        let circle = scale(disc_reach(self.axis()), f64::from(self.major));
        around(self.centre(), circle.map(|x| x + f64::from(self.minor)))
    }

    fn meet(
        &self,
        line: &Line,
        _: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let (major, minor) = (f64::from(self.major), f64::from(self.minor));
        let speed = length(line.direction);
        let direction = normalized(line.direction);
        if !(minor > 0.0 && speed > 0.0) {
            return Continue(());
        }
        let size = major + minor;
        let (major, minor) = (major / size, minor / size);
        // Where the line passes the centre. The second step repairs the rounding of the first, which is large far away.
        let l = sub(line.origin, self.centre());
        let first = -dot(l, direction);
        let passing = along(l, direction, first);
        let second = -dot(passing, direction);
        let passing = scale(along(passing, direction, second), 1.0 / size);
        let nearest = dot(passing, passing);
        // A little room, so that a line that touches the ball is met.
        let reach = 1.0 + 1.0e-9 - nearest;
        let near_enough = reach >= 0.0;
        if !near_enough {
            return Continue(());
        }
        let half = sqrt_f64(reach);

        // (|p|² + R² − r²)² = 4 R² (|p|² − z²) along p = passing + s direction.
        let axis = self.axis();
        let (z, climb) = (dot(passing, axis), dot(direction, axis));
        let lean = 2.0 * dot(passing, direction);
        let a = nearest + (major - minor) * (major + minor);
        let r = 4.0 * major * major;
        let quartic = [
            a * a - r * (nearest - z * z),
            2.0 * lean * a - r * (lean - 2.0 * z * climb),
            lean * lean + 2.0 * a - r * (1.0 - climb * climb),
            2.0 * lean,
            1.0,
        ];
        for &s in roots::polynomial(&quartic, -half, half).as_slice() {
            let t = (first + (second + s * size)) / speed;
            visit(Root { t, part: 0 })?;
        }
        Continue(())
    }

    fn place(&self, near: [f64; 3], _: u8) -> Place {
        let axis = self.axis();
        let l = sub(near, self.centre());
        let [x, y] = frame(axis).map(|a| dot(l, a));
        let z = dot(l, axis);
        let flat = along(l, axis, -z);
        let on_circle = along(self.centre(), normalized(flat), f64::from(self.major));
        let normal = normalized(sub(near, on_circle));
        let outwards = sqrt_f64(x * x + y * y) - f64::from(self.major);
        Place {
            position: along(on_circle, normal, f64::from(self.minor)),
            normal,
            uv: [turn(y, x), turn(z, outwards)],
        }
    }
}
