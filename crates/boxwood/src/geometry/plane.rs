//! Planes, as far as a box goes.
//!
//! *How it works.* Structures need boxes, and a plane without end has none that helps. So a plane is the part of it that
//! lies in a box of the user's: a polygon of up to six corners, whose own box is computed by solving the plane's equation
//! for each coordinate in turn, which is exact. *Cost:* 48 bytes, one division.

use super::double::{Line, along, cross, dot, frame, normalized, outward, sub};
use super::shape::{Place, Root, Shape, ShapeFlaw, all_finite, direction_is_good};
use super::{Aabb, Vec3};
use core::ops::ControlFlow::{self, Continue};

/// The part of a plane that lies in a closed box. A ray that runs in the plane does not hit it.
///
/// `u` and `v` are lengths in world units from `point`, along two unit vectors that depend on the normal only and make a
/// right-handed frame with it; for the normal +z they run along +x and +y. The front is where the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of the plane, world units; need not lie in the box.
    pub point: Vec3,
    /// Towards the front; any length but zero.
    pub normal: Vec3,
    /// How far it goes. Nothing is hit where this is empty.
    pub within: Aabb,
}

impl Plane {
    /// A plane through a point, as far as a box goes.
    pub fn new(point: impl Into<[f32; 3]>, normal: impl Into<[f32; 3]>, within: Aabb) -> Self {
        Self {
            point: point.into().into(),
            normal: normal.into().into(),
            within,
        }
    }
    fn point(&self) -> [f64; 3] {
        self.point.to_array().map(f64::from)
    }
    fn normal(&self) -> [f64; 3] {
        self.normal.to_array().map(f64::from)
    }
    /// What rounding may do to a point of the plane.
    fn margin(&self) -> f64 {
        let scale = f64::from(self.within.scale()) + f64::from(self.point.abs().max_element());
        scale * (1.0 / (1_u64 << 48) as f64)
    }

    /// The box of the polygon that a box cuts from the plane.
    fn polygon_bounds(&self, within: &Aabb) -> Aabb {
        if within.is_empty() {
            return Aabb::EMPTY;
        }
        let (n, p) = (self.normal(), self.point());
        let mut lower = within.lower.to_array().map(f64::from);
        let mut upper = within.upper.to_array().map(f64::from);
        let [from, to] = [lower, upper];
        let margin = self.margin();
        for axis in 0..3 {
            if n[axis] == 0.0 {
                continue;
            }
            // x = p + Σ slope (p' − x'), where the x' run over the other two sides of the box.
            let (mut least, mut most) = (p[axis], p[axis]);
            for other in [(axis + 1) % 3, (axis + 2) % 3] {
                let slope = n[other] / n[axis];
                let a = slope * (p[other] - from[other]);
                let b = slope * (p[other] - to[other]);
                least += a.min(b) - margin * slope.abs();
                most += a.max(b) + margin * slope.abs();
            }
            lower[axis] = lower[axis].max(least - margin);
            upper[axis] = upper[axis].min(most + margin);
            let meets = lower[axis] <= upper[axis];
            if !meets {
                return Aabb::EMPTY;
            }
        }
        outward(lower, upper).intersection(*within)
    }
}

impl Shape for Plane {
    const NAME: &'static str = "plane";

    fn check(&self) -> Result<(), ShapeFlaw> {
        all_finite([("point", self.point.to_array())])?;
        if !self.within.is_empty() {
            let Aabb { lower, upper } = self.within;
            all_finite([("box", lower.to_array()), ("box", upper.to_array())])?;
        }
        direction_is_good("normal", self.normal.to_array())
    }

    fn bounds(&self) -> Aabb {
        self.polygon_bounds(&self.within)
    }

    fn clipped_bounds(&self, within: &Aabb) -> Aabb {
        self.polygon_bounds(&self.within.intersection(*within))
    }

    #[inline]
    fn meet(
        &self,
        line: &Line,
        _: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let n = self.normal();
        let t = dot(sub(self.point(), line.origin), n) / dot(line.direction, n);
        let at = line.at(t);
        // The point is off the plane by its rounding, and a box may be as flat as the plane.
        let reach = line
            .origin
            .into_iter()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let margin = self.margin() + reach * (1.0 / (1_u64 << 48) as f64);
        let inside = (0..3).all(|k| {
            f64::from(self.within.lower[k]) - margin <= at[k]
                && at[k] <= f64::from(self.within.upper[k]) + margin
        });
        if inside {
            visit(Root { t, part: 0 })?;
        }
        Continue(())
    }

    fn place(&self, near: [f64; 3], _: u8) -> Place {
        let normal = normalized(self.normal());
        let from_point = sub(near, self.point());
        let [x, y] = frame(normal);
        debug_assert!(dot(cross(x, y), normal) > 0.0);
        Place {
            position: along(near, normal, -dot(from_point, normal)),
            normal,
            uv: [dot(from_point, x) as f32, dot(from_point, y) as f32],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_fit_the_polygon() {
        let within = Aabb::new([-1.0; 3], [1.0; 3]);
        let near = |a: Aabb, b: Aabb| {
            (a.lower - b.lower).abs().max_element() < 1.0e-6
                && (a.upper - b.upper).abs().max_element() < 1.0e-6
                && a.contains(&b)
        };
        let flat = Plane::new([0.0, 0.0, 0.5], [0.0, 0.0, 3.0], within).bounds();
        assert!(near(flat, Aabb::new([-1.0, -1.0, 0.5], [1.0, 1.0, 0.5])));
        let corner = Plane::new([0.5, 1.0, 1.0], [1.0, 1.0, 1.0], within).bounds();
        assert!(near(corner, Aabb::new([0.5; 3], [1.0; 3])), "{corner:?}");
        assert!(
            Plane::new([4.0, 0.0, 0.0], [1.0, 0.0, 0.0], within)
                .bounds()
                .is_empty()
        );
        let half = Plane::new([0.0; 3], [1.0, 0.0, -1.0], within)
            .clipped_bounds(&Aabb::new([0.0, -1.0, -1.0], [1.0; 3]));
        assert!(
            near(half, Aabb::new([0.0, -1.0, 0.0], [1.0; 3])),
            "{half:?}"
        );
    }
}
