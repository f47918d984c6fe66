//! Spheres.
//!
//! *How it works.* The stable quadratic of [`roots`](super::roots), in double precision. *Cost:* 16 bytes; some twenty
//! operations, a division and a square root; angles are computed only for a hit that counts.
//! *Source:* Haines, Günther & Akenine-Möller 2019.

use super::Aabb;
use super::double::{Line, along, around, normalized, sub};
use super::shape::{Place, Root, Shape, ShapeFlaw, all_finite, length_is_good};
use super::{Vec3, roots};
use crate::math::{sqrt_f64, turn};
use core::ops::ControlFlow::{self, Continue};

/// The surface of a ball, met from outside and from inside. A sphere of radius 0 is kept and never hit.
///
/// `u` is the longitude in turns, 0 to 1 from +x towards +y; `v` the latitude, 0 at the pole −z to 1 at the pole +z. The
/// normal points away from the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre, world units.
    pub centre: Vec3,
    /// The radius, world units; zero or more.
    pub radius: f32,
}

impl Sphere {
    /// A sphere from its centre and radius.
    pub fn new(centre: impl Into<[f32; 3]>, radius: f32) -> Self {
        Self {
            centre: centre.into().into(),
            radius,
        }
    }
    fn centre(&self) -> [f64; 3] {
        self.centre.to_array().map(f64::from)
    }
}

impl Shape for Sphere {
    const NAME: &'static str = "sphere";

    fn check(&self) -> Result<(), ShapeFlaw> {
        all_finite([("centre", self.centre.to_array())])?;
        length_is_good("radius", self.radius)
    }

    fn bounds(&self) -> Aabb {
        if self.radius == 0.0 {
            return Aabb::EMPTY;
        }
        around(self.centre(), [f64::from(self.radius); 3])
    }

    #[inline]
    fn meet(
        &self,
        line: &Line,
        _: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let l = sub(line.origin, self.centre());
        if self.radius == 0.0 {
            return Continue(());
        }
        let Some([near, far]) = roots::sphere(l, line.direction, f64::from(self.radius)) else {
            return Continue(());
        };
        visit(Root { t: near, part: 0 })?;
        if near < far {
            visit(Root { t: far, part: 0 })?;
        }
        Continue(())
    }

    fn place(&self, near: [f64; 3], _: u8) -> Place {
        let normal = normalized(sub(near, self.centre()));
        let [x, y, z] = normal;
        // From the pole −z: half a turn is the whole way.
        let v = 2.0 * turn(sqrt_f64(x * x + y * y), -z);
        Place {
            position: along(self.centre(), normal, f64::from(self.radius)),
            normal,
            uv: [turn(y, x), v],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longitude_and_latitude() {
        let sphere = Sphere::new([1.0, 0.0, 0.0], 2.0);
        let uv = |p: [f64; 3]| sphere.place(p, 0).uv;
        assert_eq!(uv([3.0, 0.0, 0.0]), [0.0, 0.5]);
        assert_eq!(uv([1.0, 2.0, 0.0]), [0.25, 0.5]);
        assert_eq!(uv([1.0, -2.0, 0.0]), [0.75, 0.5]);
        assert_eq!(uv([1.0, 0.0, 2.0])[1], 1.0);
        assert_eq!(uv([1.0, 0.0, -2.0])[1], 0.0);
    }

    #[test]
    fn the_box_holds_it_all() {
        let sphere = Sphere::new([0.1, 0.0, 0.0], 0.7);
        let b = sphere.bounds();
        assert!(f64::from(b.upper.x) >= f64::from(0.1_f32) + f64::from(0.7_f32));
        assert!(b.upper.x - 0.8 < 1.0e-6);
        assert!(Sphere::new([0.0; 3], 0.0).bounds().is_empty());
    }
}
