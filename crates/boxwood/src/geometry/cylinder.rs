//! Cylinders between two points, open or closed.
//!
//! *How it works.* The line without its part along the axis meets a circle: the quadratic of spheres. The slab between the
//! ends cuts the rest. A closed cylinder is convex, so the line meets it where it enters and leaves both at once: a line
//! through the rim can not slip between wall and cap. *Cost:* 32 bytes; two divisions and two square roots.
//! *Source:* Shene 1994, *Computing the Intersection of a Line and a Cylinder* (Graphics Gems IV).

use super::double::{
    Chord, Double3, Line, along, disc_reach, dot, frame, length, normalized, outward, scale, sub,
};
use super::shape::{Place, Root, Shape, ShapeFlaw, all_finite, length_is_good};
use super::{Aabb, Vec3, roots};
use crate::math::{sqrt_f64, turn};
use core::ops::ControlFlow::{self, Continue};

/// A cylinder between two points, met from outside and from inside; its ends belong to it. With radius 0 it is kept and
/// never hit.
///
/// On the wall, `u` is the angle in turns around the axis, 0 to 1, and `v` runs from 0 at `from` to 1 at `to`. On a cap, `u`
/// is the same angle and `v` the distance from the axis, 1 at the rim. The normal points outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// One end of the axis, world units.
    pub from: Vec3,
    /// The radius, world units; zero or more.
    pub radius: f32,
    /// The other end.
    pub to: Vec3,
    /// Whether the ends are closed by discs; else it is a tube that one looks into.
    pub caps: bool,
}

const WALL: u8 = 0;
/// Plus the side of the slab that the axis gives.
const CAPS: u8 = 2;

impl Cylinder {
    /// A closed cylinder.
    pub fn new(from: impl Into<[f32; 3]>, to: impl Into<[f32; 3]>, radius: f32) -> Self {
        Self {
            from: from.into().into(),
            radius,
            to: to.into().into(),
            caps: true,
        }
    }
    /// The same without caps.
    #[must_use]
    pub fn open(self) -> Self {
        Self {
            caps: false,
            ..self
        }
    }
    /// One end, the unit axis and the length.
    fn axis(&self) -> (Double3, Double3, f64) {
        let from = self.from.to_array().map(f64::from);
        let axis = sub(self.to.to_array().map(f64::from), from);
        (from, normalized(axis), length(axis))
    }
}

impl Shape for Cylinder {
    const NAME: &'static str = "cylinder";

    fn check(&self) -> Result<(), ShapeFlaw> {
        all_finite([
            ("one end", self.from.to_array()),
            ("other end", self.to.to_array()),
        ])?;
        length_is_good("radius", self.radius)?;
        if self.from == self.to {
            return Err(ShapeFlaw::Zero("length"));
        }
        Ok(())
    }

    fn bounds(&self) -> Aabb {
        if self.radius == 0.0 {
            return Aabb::EMPTY;
        }
        let (_, axis, _) = self.axis();
        let reach = scale(disc_reach(axis), f64::from(self.radius));
        let ends = Aabb::of([self.from, self.to]);
        outward(
            sub(ends.lower.to_array().map(f64::from), reach),
            along(ends.upper.to_array().map(f64::from), reach, 1.0),
        )
    }

    #[inline]
    fn meet(
        &self,
        line: &Line,
        _: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let (from, axis, length) = self.axis();
        let radius = f64::from(self.radius);
        let l = sub(line.origin, from);
        let (height, climb) = (dot(l, axis), dot(line.direction, axis));
        let slab = Chord::ALL.within_slab(0.0, length, height, climb, CAPS / 2);
        let (Some(slab), true) = (slab, radius > 0.0) else {
            return Continue(());
        };
        let flat_l = along(l, axis, -height);
        let flat_d = along(line.direction, axis, -climb);
        // A line along the axis has a rest of rounding errors only, and is inside the wall or outside for good.
        let straight = dot(flat_d, flat_d)
            <= dot(line.direction, line.direction) * (1.0 / (1_u128 << 96) as f64);
        let wall = if straight {
            (dot(flat_l, flat_l) <= radius * radius).then_some([f64::NEG_INFINITY, f64::INFINITY])
        } else {
            roots::sphere(flat_l, flat_d, radius)
        };
        let Some(wall) = wall else {
            return Continue(());
        };
        if !self.caps {
            for (k, t) in wall.into_iter().enumerate() {
                let repeated = k == 1 && wall[0] == t;
                if slab.enter <= t && t <= slab.leave && t.is_finite() && !repeated {
                    visit(Root { t, part: WALL })?;
                }
            }
            return Continue(());
        }
        let enter = if slab.enter > wall[0] {
            (slab.enter, slab.sides[0])
        } else {
            (wall[0], WALL)
        };
        let leave = if slab.leave < wall[1] {
            (slab.leave, slab.sides[1])
        } else {
            (wall[1], WALL)
        };
        if enter.0 <= leave.0 {
            visit(Root {
                t: enter.0,
                part: enter.1,
            })?;
        }
        if enter.0 < leave.0 {
            visit(Root {
                t: leave.0,
                part: leave.1,
            })?;
        }
        Continue(())
    }

    fn place(&self, near: [f64; 3], part: u8) -> Place {
        let (from, axis, length) = self.axis();
        let radius = f64::from(self.radius);
        let l = sub(near, from);
        let height = dot(l, axis);
        let flat = along(l, axis, -height);
        let [x, y] = frame(axis).map(|a| dot(flat, a));
        let u = turn(y, x);
        if part == WALL {
            let normal = normalized(flat);
            let foot = along(from, axis, height);
            Place {
                position: along(foot, normal, radius),
                normal,
                uv: [u, (height / length).clamp(0.0, 1.0) as f32],
            }
        } else {
            let (height, outside) = if part == CAPS {
                (0.0, -1.0)
            } else {
                (length, 1.0)
            };
            let v = sqrt_f64(x * x + y * y) / radius;
            Place {
                position: along(along(from, flat, 1.0), axis, height),
                normal: axis.map(|a| a * outside),
                uv: [u, v.clamp(0.0, 1.0) as f32],
            }
        }
    }
}
