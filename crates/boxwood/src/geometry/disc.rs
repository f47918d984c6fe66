//! Discs and rings.
//!
//! *How it works.* The plane is met first, then the distance from the centre is compared with both radii, all in double
//! precision. *Cost:* 32 bytes, one division.

use super::double::{Line, around, disc_reach, dot, frame, normalized, scale, sub};
use super::shape::{Place, Root, Shape, ShapeFlaw, all_finite, direction_is_good, length_is_good};
use super::{Aabb, Vec3, double};
use crate::math::{sqrt_f64, turn};
use core::ops::ControlFlow::{self, Continue};

/// A flat disc, or a ring when it has an inner radius; both radii belong to it. A ray that runs in it does not hit it, and
/// a disc of radius 0 is kept and never hit.
///
/// `u` is the angle in turns, 0 to 1, in the frame that [`Plane`](super::Plane) uses; `v` runs from 0 at the inner radius
/// to 1 at the outer (0 where both are equal). The front is where the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// The centre, world units.
    pub centre: Vec3,
    /// The outer radius, world units.
    pub radius: f32,
    /// Towards the front; any length but zero.
    pub normal: Vec3,
    /// The inner radius, world units; 0 for a disc without a hole.
    pub inner_radius: f32,
}

impl Disc {
    /// A disc without a hole.
    pub fn new(centre: impl Into<[f32; 3]>, normal: impl Into<[f32; 3]>, radius: f32) -> Self {
        Self {
            centre: centre.into().into(),
            radius,
            normal: normal.into().into(),
            inner_radius: 0.0,
        }
    }
    /// The same with a hole.
    #[must_use]
    pub fn with_hole(self, inner_radius: f32) -> Self {
        Self {
            inner_radius,
            ..self
        }
    }
    fn centre(&self) -> [f64; 3] {
        self.centre.to_array().map(f64::from)
    }
    fn normal(&self) -> [f64; 3] {
        self.normal.to_array().map(f64::from)
    }
}

impl Shape for Disc {
    const NAME: &'static str = "disc";

    fn check(&self) -> Result<(), ShapeFlaw> {
        all_finite([("centre", self.centre.to_array())])?;
        direction_is_good("normal", self.normal.to_array())?;
        length_is_good("radius", self.radius)?;
        length_is_good("inner radius", self.inner_radius)?;
        if self.inner_radius > self.radius {
            return Err(ShapeFlaw::Order {
                smaller: "inner radius",
                than: "at most",
                larger: "radius",
            });
        }
        Ok(())
    }

    fn bounds(&self) -> Aabb {
        if self.radius == 0.0 {
            return Aabb::EMPTY;
        }
        let reach = disc_reach(normalized(self.normal()));
        around(self.centre(), scale(reach, f64::from(self.radius)))
    }

    #[inline]
    fn meet(
        &self,
        line: &Line,
        _: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let n = self.normal();
        let l = sub(line.origin, self.centre());
        let t = -dot(l, n) / dot(line.direction, n);
        let from_centre = double::along(l, line.direction, t);
        let square = dot(from_centre, from_centre);
        let (inner, outer) = (f64::from(self.inner_radius), f64::from(self.radius));
        if outer > 0.0 && inner * inner <= square && square <= outer * outer {
            visit(Root { t, part: 0 })?;
        }
        Continue(())
    }

    fn place(&self, near: [f64; 3], _: u8) -> Place {
        let normal = normalized(self.normal());
        let from_centre = sub(near, self.centre());
        let [x, y] = frame(normal).map(|axis| dot(from_centre, axis));
        let (inner, outer) = (f64::from(self.inner_radius), f64::from(self.radius));
        let v = if inner < outer {
            ((sqrt_f64(x * x + y * y) - inner) / (outer - inner)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Place {
            position: double::along(near, normal, -dot(from_centre, normal)),
            normal,
            uv: [turn(y, x), v as f32],
        }
    }
}
