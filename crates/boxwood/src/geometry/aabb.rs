//! Axis-aligned boxes: three pairs of slabs.

use super::{Ray, Vec3};

/// A box with closed sides. Empty when `lower > upper` on any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Aabb {
    /// Smallest coordinates.
    pub lower: Vec3,
    /// Largest coordinates.
    pub upper: Vec3,
}

impl Aabb {
    /// The box of nothing: neutral for [`Aabb::union`].
    pub const EMPTY: Self = Self {
        lower: Vec3::splat(f32::INFINITY),
        upper: Vec3::splat(f32::NEG_INFINITY),
    };

    /// A box from its smallest and largest coordinates.
    #[inline]
    pub fn new(lower: impl Into<[f32; 3]>, upper: impl Into<[f32; 3]>) -> Self {
        Self {
            lower: lower.into().into(),
            upper: upper.into().into(),
        }
    }
    /// The smallest box of some points; [`Aabb::EMPTY`] when there are none. NaN coordinates are passed over.
    #[inline(always)]
    pub fn of<V: Into<[f32; 3]>>(points: impl IntoIterator<Item = V>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| {
            let p = Vec3::from(p.into());
            Self {
                lower: p.min(b.lower),
                upper: p.max(b.upper),
            }
        })
    }
    /// The smallest box around both.
    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self {
            lower: other.lower.min(self.lower),
            upper: other.upper.max(self.upper),
        }
    }
    /// The common part; empty when there is none.
    #[inline]
    pub fn intersection(self, other: Self) -> Self {
        Self {
            lower: self.lower.max(other.lower),
            upper: self.upper.min(other.upper),
        }
    }
    /// Whether there is no point in it. A box with NaN is empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !(self.lower.x <= self.upper.x
            && self.lower.y <= self.upper.y
            && self.lower.z <= self.upper.z)
    }
    /// Whether all of `other` lies inside; an empty box lies in every box.
    #[inline]
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || self.union(*other) == *self
    }
    /// The lengths of the edges; zero when empty.
    #[inline(always)]
    pub fn size(&self) -> Vec3 {
        if self.is_empty() {
            return Vec3::ZERO;
        }
        self.upper - self.lower
    }
    /// Half the surface; zero when empty.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let d = (self.upper - self.lower).max(Vec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
    /// The middle. Each half is taken before the sum, so that it is finite for every finite box.
    #[inline(always)]
    pub fn centroid(&self) -> Vec3 {
        self.lower * 0.5 + self.upper * 0.5
    }
    /// The largest |coordinate|: the scale that rounding errors of everything inside go by. Zero when empty.
    #[inline]
    pub fn scale(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        self.lower.abs().max(self.upper.abs()).max_element()
    }

    /// The slab test (Kay & Kajiya 1986): the part of the ray's interval `[t_min, t_max]` that lies in the box, as
    /// `(enter, leave)`; `None` when there is none.
    ///
    /// A ray that runs in a side of the box is inside that slab. An empty box, a NaN in ray or box, and a ray that misses
    /// everything (see [`Ray`]) are a miss.
    /// The two numbers are rounded like any float; structures use a conservative form of their own.
    pub fn intersect(&self, ray: &Ray) -> Option<(f32, f32)> {
        let hopeless = !ray.origin.is_finite()
            || !ray.direction.is_finite()
            || ray.direction.abs().max_element() == 0.0
            || !(ray.t_min <= ray.t_max);
        if hopeless || self.is_empty() {
            return None;
        }
        let (mut enter, mut leave) = (ray.t_min.max(0.0), ray.t_max.min(f32::MAX));
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            let (lower, upper) = (self.lower[axis], self.upper[axis]);
            if d == 0.0 {
                if !(lower <= o && o <= upper) {
                    return None;
                }
                continue;
            }
            let (near, far) = if d < 0.0 {
                (upper, lower)
            } else {
                (lower, upper)
            };
            enter = enter.max((near - o) / d);
            leave = leave.min((far - o) / d);
        }
        (enter <= leave).then_some((enter, leave))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb {
        lower: Vec3::ZERO,
        upper: Vec3::splat(1.0),
    };

    fn meet(b: &Aabb, origin: [f32; 3], direction: [f32; 3]) -> Option<(f32, f32)> {
        b.intersect(&Ray::new(origin, direction))
    }

    #[test]
    fn before_inside_behind() {
        assert_eq!(
            meet(&UNIT, [-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]),
            Some((1.0, 2.0))
        );
        assert_eq!(
            meet(&UNIT, [0.5, 0.5, 0.5], [1.0, 0.0, 0.0]),
            Some((0.0, 0.5))
        );
        assert_eq!(
            meet(&UNIT, [0.5, 0.5, 0.5], [-2.0, 0.0, 0.0]),
            Some((0.0, 0.25))
        );
        assert_eq!(meet(&UNIT, [2.0, 0.5, 0.5], [1.0, 0.0, 0.0]), None);
        assert_eq!(meet(&UNIT, [-1.0, 2.1, 0.5], [1.0, -0.5, 0.0]), None);
    }

    #[test]
    fn the_interval_is_closed() {
        let ray = Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
        assert_eq!(UNIT.intersect(&ray.until(1.0)), Some((1.0, 1.0)));
        assert_eq!(UNIT.intersect(&ray.until(0.9)), None);
        assert_eq!(UNIT.intersect(&ray.from(2.0)), Some((2.0, 2.0)));
        assert_eq!(UNIT.intersect(&ray.from(2.1)), None);
        assert_eq!(UNIT.intersect(&ray.from(-5.0)), Some((1.0, 2.0)));
    }

    #[test]
    fn a_ray_in_a_side_is_inside() {
        for zero in [0.0, -0.0] {
            for side in [0.0, 1.0] {
                assert_eq!(
                    meet(&UNIT, [-1.0, side, 0.5], [1.0, zero, zero]),
                    Some((1.0, 2.0))
                );
            }
            assert_eq!(meet(&UNIT, [-1.0, 1.1, 0.5], [1.0, zero, zero]), None);
        }
        let flat = Aabb::new([0.0, 0.0, 0.5], [1.0, 1.0, 0.5]);
        assert_eq!(
            meet(&flat, [0.5, 0.5, -1.0], [0.0, 0.0, 1.0]),
            Some((1.5, 1.5))
        );
        assert_eq!(
            meet(&flat, [-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]),
            Some((1.0, 2.0))
        );
    }

    #[test]
    fn empty_and_nan_are_missed() {
        assert_eq!(meet(&Aabb::EMPTY, [0.0; 3], [1.0, 1.0, 1.0]), None);
        let nan = f32::NAN;
        for axis in 0..3 {
            let mut v = [0.5; 3];
            v[axis] = nan;
            assert_eq!(meet(&UNIT, v, [1.0, 1.0, 1.0]), None);
            assert_eq!(meet(&UNIT, [0.5; 3], v), None);
            assert_eq!(
                meet(&Aabb::new(v, [1.0; 3]), [0.5; 3], [1.0, 1.0, 1.0]),
                None
            );
            assert_eq!(
                meet(&Aabb::new([0.0; 3], v), [0.2; 3], [1.0, 0.0, 1.0]),
                None
            );
        }
        assert_eq!(meet(&UNIT, [0.5; 3], [0.0, -0.0, 0.0]), None);
        assert_eq!(meet(&UNIT, [0.5; 3], [f32::INFINITY, 1.0, 0.0]), None);
        let ray = Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
        assert_eq!(UNIT.intersect(&ray.until(nan)), None);
        assert_eq!(UNIT.intersect(&ray.from(nan)), None);
    }

    #[test]
    fn sizes() {
        assert_eq!(Aabb::new([0.0; 3], [1.0, 2.0, 3.0]).half_area(), 11.0);
        assert_eq!(Aabb::EMPTY.half_area(), 0.0);
        assert_eq!(Aabb::EMPTY.size(), Vec3::ZERO);
        assert!(UNIT.contains(&Aabb::EMPTY) && !Aabb::EMPTY.contains(&UNIT));
        assert_eq!(Aabb::new([-3.0, 0.0, 0.0], [1.0; 3]).scale(), 3.0);
        let huge = Aabb::new([f32::MAX; 3], [f32::MAX; 3]);
        assert_eq!(huge.centroid(), Vec3::splat(f32::MAX));
    }
}
