//! Implicit surfaces: where a function of space is zero.
//!
//! *How it works.* A function gives its values, and a bound of them on any part of a ray; [`ImplicitSurface`] searches the ray
//! with both and skips no root. The bound comes from a Lipschitz constant (Kalra & Barr 1989, *Guaranteed Ray Intersections
//! with Implicit Surfaces*) or from interval arithmetic (Mitchell 1990, *Robust Ray Intersection with Interval Arithmetic*);
//! for a [`Formula`] it follows from the formula itself.

pub use super::search::{ImplicitSurface, MAX_PIECES};

use super::Aabb;
use super::double::{Line, dot, length};
use super::interval::Interval;
use super::real::{Dual, Real};

/// A function of space whose zeros are a surface, and a bound that can prove where it is not zero.
///
/// Where a formula is all there is, implement [`Formula`] instead: it knows its bounds by itself. A wrong bound loses roots, as
/// does a wrong box; neither panics nor hangs.
///
/// ```
/// use boxwood::{Aabb, BruteForce, Enclosure, Implicit, ImplicitSurface, Intersect, Ray, Segment, Shapes};
///
/// /// A ball by its distance, which changes by at most one unit per unit: the Lipschitz constant is 1.
/// struct Ball;
/// impl Implicit for Ball {
///     fn bounds(&self) -> Aabb {
///         Aabb::new([-1.0; 3], [1.0; 3])
///     }
///     fn value(&self, [x, y, z]: [f64; 3]) -> f64 {
///         (x * x + y * y + z * z).sqrt() - 1.0
///     }
///     fn enclose(&self, part: &Segment) -> Enclosure {
///         part.lipschitz(self.value(part.middle()), 1.0)
///     }
/// }
/// let ball = BruteForce::new(Shapes::new([ImplicitSurface(Ball)])?);
/// let hits = ball.all_hits(&Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]));
/// assert_eq!(hits.iter().map(|h| h.t).collect::<Vec<_>>(), [2.0, 4.0]);
/// # Ok::<(), boxwood::ShapeError>(())
/// ```
pub trait Implicit {
    /// A box around all of the surface that is to be seen; what lies outside does not exist.
    fn bounds(&self) -> Aabb;
    /// The function; negative inside by convention, as normals point to where it grows.
    fn value(&self, p: [f64; 3]) -> f64;
    /// Its derivatives by x, y and z. By default central differences, right to about six digits.
    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        let step = (f64::from(self.bounds().scale())) * (1.0 / (1 << 18) as f64);
        let mut gradient = [0.0; 3];
        for (axis, slope) in gradient.iter_mut().enumerate() {
            let (mut a, mut b) = (p, p);
            a[axis] -= step;
            b[axis] += step;
            *slope = (self.value(b) - self.value(a)) / (b[axis] - a[axis]);
        }
        gradient
    }
    /// What the function and its slope can be on a part of a ray: from a Lipschitz constant
    /// ([`Segment::lipschitz`], [`Segment::smooth`]) or in interval arithmetic over [`Segment::points`].
    fn enclose(&self, part: &Segment) -> Enclosure;
    /// The `u` and `v` of hits at a point of the surface; 0 by default.
    fn uv(&self, _p: [f64; 3]) -> [f32; 2] {
        [0.0; 2]
    }
}

/// A function written once for all kinds of numbers: its values, bounds and derivatives follow, and so does [`Implicit`].
///
/// ```
/// use boxwood::{Aabb, BruteForce, Formula, ImplicitSurface, Intersect, Ray, Real, Shapes};
///
/// struct Gyroid;
/// impl Formula for Gyroid {
///     fn bounds(&self) -> Aabb {
///         Aabb::new([-4.0; 3], [4.0; 3])
///     }
///     fn at<T: Real>(&self, [x, y, z]: [T; 3]) -> T {
///         x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
///     }
/// }
/// let gyroid = BruteForce::new(Shapes::new([ImplicitSurface(Gyroid)])?);
/// let ray = Ray::new([-4.0, 0.1, 0.2], [1.0, 0.05, 0.1]);
/// assert!(gyroid.closest_hit(&ray).is_some());
/// # Ok::<(), boxwood::ShapeError>(())
/// ```
pub trait Formula {
    /// A box around all of the surface that is to be seen.
    fn bounds(&self) -> Aabb;
    /// The function; negative inside by convention.
    fn at<T: Real>(&self, p: [T; 3]) -> T;
    /// The `u` and `v` of hits at a point of the surface; 0 by default.
    fn uv(&self, _p: [f64; 3]) -> [f32; 2] {
        [0.0; 2]
    }
}

impl<F: Formula> Implicit for F {
    fn bounds(&self) -> Aabb {
        Formula::bounds(self)
    }
    fn value(&self, p: [f64; 3]) -> f64 {
        self.at(p)
    }
    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let mut p = p.map(Dual::<f64>::from);
            p[axis].slope = 1.0;
            self.at(p).slope
        })
    }
    fn enclose(&self, part: &Segment) -> Enclosure {
        let mut p = part.points().map(|value| Dual {
            value,
            slope: Interval::from(0.0),
        });
        for (p, d) in p.iter_mut().zip(part.line.direction) {
            p.slope = Interval::from(d);
        }
        let all = self.at(p);
        Enclosure {
            values: all.value,
            slopes: all.slope,
        }
    }
    fn uv(&self, p: [f64; 3]) -> [f32; 2] {
        Formula::uv(self, p)
    }
}

/// What a function can be on a part of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosure {
    /// Holds every value of the function there.
    pub values: Interval,
    /// Holds every derivative of the function by the ray's `t` there; [`Interval::ALL`] when nothing is known.
    pub slopes: Interval,
}

/// A part of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    pub(super) line: Line,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Segment {
    pub(super) fn middle_t(&self) -> f64 {
        0.5 * self.from + 0.5 * self.to
    }
    /// The point half way.
    pub fn middle(&self) -> [f64; 3] {
        self.line.at(self.middle_t())
    }
    /// Half its length in world units.
    pub fn reach(&self) -> f64 {
        // A few roundings more, so that no point lies beyond.
        0.5 * (self.to - self.from) * length(self.line.direction) * (1.0 + f64::EPSILON * 8.0)
    }
    /// The coordinates of its points.
    pub fn points(&self) -> [Interval; 3] {
        let t = Interval::new(self.from, self.to);
        let Line { origin, direction } = self.line;
        [0, 1, 2].map(|k| Interval::from(origin[k]) + t * Interval::from(direction[k]))
    }
    /// The enclosure of a function that changes by at most `constant` per unit of length, from its value in the
    /// [`Segment::middle`].
    pub fn lipschitz(&self, value: f64, constant: f64) -> Enclosure {
        let change = constant.abs() * self.reach();
        let slope = constant.abs() * length(self.line.direction);
        Enclosure {
            values: Interval::new(value - change, value + change),
            slopes: Interval::new(-slope, slope),
        }
    }
    /// The same of a function whose *gradient* changes by at most `constant` per unit of length, from its value and gradient
    /// in the middle. Far narrower than [`Segment::lipschitz`] where the ray nearly touches the surface.
    pub fn smooth(&self, value: f64, gradient: [f64; 3], constant: f64) -> Enclosure {
        let (reach, speed) = (self.reach(), length(self.line.direction));
        let slope = dot(gradient, self.line.direction);
        let bend = constant.abs() * reach;
        // The slope where it is largest, over half the way, would be too much by a half.
        let change = slope.abs() * 0.5 * (self.to - self.from) * (1.0 + f64::EPSILON * 8.0)
            + 0.5 * bend * reach;
        Enclosure {
            values: Interval::new(value - change, value + change),
            slopes: Interval::new(slope - bend * speed, slope + bend * speed),
        }
    }
}
