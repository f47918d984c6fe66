//! Sets of analytic shapes and implicit surfaces.
//!
//! *How it works.* One set holds shapes of one kind, so that the compiler sees their test; [`Chain`](super::Chain) joins sets
//! of different kinds. Shapes cannot promise the error bound of the triangle test, so a hit counts only in its shape's
//! own padded box, which [`offer`](super::offer) sees to.

use super::{Primitives, Surfaces};
use crate::geometry::shape::{Shape, ShapeError, ShapeFlaw};
use crate::geometry::{
    Aabb, Cuboid, Cylinder, Disc, Hit, ImplicitSurface, Line, OrientedCuboid, Plane, PreparedRay,
    Ray, Sphere, Surface, Torus, Vec3,
};
use crate::query::{Counters, Query};
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Break, Continue};

/// A numbered set of shapes of one kind, checked once.
///
/// ```
/// use boxwood::{BruteForce, Intersect, Ray, Sphere, Surfaces, Shapes};
/// let spheres = Shapes::new([Sphere::new([0.0, 0.0, 5.0], 1.0)])?;
/// let ray = Ray::new([0.0; 3], [0.0, 0.0, 2.0]);
/// let hit = BruteForce::new(&spheres).closest_hit(&ray).expect("straight ahead");
/// assert_eq!(hit.t, 2.0);
/// assert_eq!(spheres.surface(&ray, &hit).normal, [0.0, 0.0, -1.0].into());
/// # Ok::<(), boxwood::ShapeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Shapes<S> {
    shapes: Vec<S>,
}

/// A set of spheres.
pub type Spheres = Shapes<Sphere>;
/// A set of planes, each as far as its box goes.
pub type Planes = Shapes<Plane>;
/// A set of discs and rings.
pub type Discs = Shapes<Disc>;
/// A set of boxes along the axes.
pub type Cuboids = Shapes<Cuboid>;
/// A set of boxes in any position.
pub type OrientedCuboids = Shapes<OrientedCuboid>;
/// A set of cylinders.
pub type Cylinders = Shapes<Cylinder>;
/// A set of tori.
pub type Tori = Shapes<Torus>;
/// A set of implicit surfaces of one type.
pub type ImplicitSurfaces<F> = Shapes<ImplicitSurface<F>>;

impl<S: Shape> Shapes<S> {
    /// Checks and keeps the shapes, in order.
    ///
    /// # Errors
    /// The first shape that makes no sense: a number that is infinite or NaN, a negative radius, a direction of zero, a box
    /// beyond the floats.
    pub fn new(shapes: impl IntoIterator<Item = S>) -> Result<Self, ShapeError> {
        let shapes: Vec<S> = shapes.into_iter().collect();
        if shapes.len() >= u32::MAX as usize {
            return Err(ShapeError::TooMany(shapes.len()));
        }
        for (index, shape) in shapes.iter().enumerate() {
            let bounded = || {
                let b = shape.bounds();
                let finite = b.lower.is_finite() && b.upper.is_finite();
                if finite || b.is_empty() {
                    Ok(())
                } else {
                    Err(ShapeFlaw::TooLarge)
                }
            };
            shape
                .check()
                .and_then(|()| bounded())
                .map_err(|flaw| ShapeError::Flaw {
                    name: S::NAME,
                    index,
                    flaw,
                })?;
        }
        Ok(Self { shapes })
    }

    /// The shapes.
    pub fn as_slice(&self) -> &[S] {
        &self.shapes
    }
}

impl<S> Default for Shapes<S> {
    fn default() -> Self {
        Self { shapes: Vec::new() }
    }
}

impl<S: Shape> Primitives for Shapes<S> {
    #[inline]
    fn len(&self) -> usize {
        self.shapes.len()
    }
    #[inline]
    fn bounds(&self, i: usize) -> Aabb {
        self.shapes[i].bounds()
    }
    fn clipped_bounds(&self, i: usize, within: &Aabb) -> Aabb {
        self.shapes[i].clipped_bounds(within)
    }
    #[inline]
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        _: &mut C,
    ) -> ControlFlow<()> {
        let shape = &self.shapes[i];
        let line = Line::from(&**ray);
        // A root just beyond the end may still be rounded to it.
        let end = |t_max: f32| f64::from(t_max.next_up());
        let mut last = f32::NAN;
        let mut stopped = Continue(());
        // Whether the shape was done or the query: only the latter stops the traversal.
        let _ = shape.meet(&line, end(query.t_max()), &mut |root| {
            // `+ 0.0` makes a zero of either sign the positive one.
            let t = root.t as f32 + 0.0;
            let counts = root.t >= 0.0 && ray.t_min <= t && t <= query.t_max();
            // Two roots that one float cannot tell apart are one hit.
            if counts && t != last {
                last = t;
                let [u, v] = shape.place(line.at(root.t), root.part).uv;
                stopped = query.offer(Hit {
                    t,
                    u,
                    v,
                    primitive: i as u32,
                    instance: 0,
                });
            }
            match stopped {
                Break(()) => Break(()),
                Continue(()) => Continue(end(query.t_max())),
            }
        });
        stopped
    }
}

impl<S: Shape> Surfaces for Shapes<S> {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let shape = &self.shapes[hit.primitive as usize];
        let line = Line::from(ray);
        let root = shape.root(&line, hit.t);
        let place = shape.place(line.at(root.t), root.part);
        let [x, y, z] = place.position;
        let [a, b, c] = place.normal;
        let [dx, dy, dz] = line.direction;
        // The position is rounded once and the moved origin three times (product, sum, normal), each by at most
        // u |p| along each axis; the rest is the shape's own.
        let rounding = (x.abs() + y.abs() + z.abs()) * (4.0 / (1 << 24) as f64);
        Surface {
            position: Vec3::new(x as f32, y as f32, z as f32),
            normal: Vec3::new(a as f32, b as f32, c as f32),
            front: a * dx + b * dy + c * dz < 0.0,
            uv: [hit.u, hit.v],
            error: ((rounding + shape.error()) as f32).max(f32::MIN_POSITIVE),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;

    #[test]
    fn bad_shapes_are_refused_in_a_sentence() {
        fn refused<S: Shape>(shapes: impl IntoIterator<Item = S>) -> alloc::string::String {
            Shapes::new(shapes).err().expect("refused").to_string()
        }
        let (nan, up) = (f32::NAN, [0.0, 0.0, 1.0]);
        let good = Sphere::new([0.0; 3], 1.0);
        assert_eq!(
            refused([good, Sphere::new([0.0, nan, 0.0], 1.0)]),
            "sphere 1: its centre is not finite"
        );
        assert_eq!(
            refused([Sphere::new([0.0; 3], -2.0)]),
            "sphere 0: its radius must not be negative, but is -2"
        );
        assert_eq!(
            refused([Sphere::new([3.0e38; 3], 1.0e38)]),
            "sphere 0: it reaches beyond the floats"
        );
        assert_eq!(
            refused([Disc::new([0.0; 3], [0.0; 3], 1.0)]),
            "disc 0: its normal is zero"
        );
        assert_eq!(
            refused([Disc::new([0.0; 3], up, 1.0).with_hole(2.0)]),
            "disc 0: its inner radius must be at most its radius"
        );
        assert_eq!(
            refused([Torus::new([0.0; 3], up, 1.0, 1.0)]),
            "torus 0: its minor radius must be less than its major radius"
        );
        assert_eq!(
            refused([Cylinder::new(up, up, 1.0)]),
            "cylinder 0: its length is zero"
        );
        assert_eq!(
            refused([Cuboid::new(up, [0.0; 3])]),
            "cuboid 0: its lower corner must be at most its upper corner"
        );
        assert_eq!(
            refused([OrientedCuboid::new([0.0; 3], [up, up, up])]),
            "oriented cuboid 0: its volume is zero"
        );
        let endless = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        assert_eq!(
            refused([Plane::new(up, up, endless)]),
            "plane 0: its box is not finite"
        );
    }
}
