//! A point or a direction: three floats, twelve bytes.

use core::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Neg, Sub};

/// A point or a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Vec3 {
    /// First coordinate.
    pub x: f32,
    /// Second coordinate.
    pub y: f32,
    /// Third coordinate.
    pub z: f32,
}

impl Vec3 {
    /// All zero.
    pub const ZERO: Self = Self::splat(0.0);

    /// A vector from its coordinates.
    #[inline(always)]
    pub const fn new(x: f32, y: f32, z: f32) -> Self {
        Self { x, y, z }
    }
    /// The same value three times.
    #[inline(always)]
    pub const fn splat(x: f32) -> Self {
        Self::new(x, x, x)
    }
    /// The inner product, summed from left to right.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f32 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
    /// The outer product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }
    /// The square of the length.
    #[inline(always)]
    pub fn length_squared(self) -> f32 {
        self.dot(self)
    }
    /// The length; infinite where its square is too large for a float.
    #[inline(always)]
    pub fn length(self) -> f32 {
        crate::math::sqrt(self.length_squared())
    }
    /// The vector of length 1 in the same direction, whatever its length; zero when that has no direction (zero, NaN,
    /// infinite).
    #[inline]
    pub fn normalized(self) -> Self {
        let largest = self.abs().max_element();
        if !(largest > 0.0 && self.is_finite()) {
            return Self::ZERO;
        }
        // A vector near the ends of the floats is first brought to where its square is a normal number.
        let v = if (1.0e-12..1.0e12).contains(&largest) {
            self
        } else if largest < f32::MIN_POSITIVE {
            let v = self * (1.0 / f32::MIN_POSITIVE);
            v / v.abs().max_element()
        } else {
            self / largest
        };
        v / v.length()
    }
    /// The smaller coordinates of both; NaN in `self` is ignored.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        let f = |a, b| if a < b { a } else { b };
        Self::new(f(self.x, other.x), f(self.y, other.y), f(self.z, other.z))
    }
    /// The larger coordinates of both; NaN in `self` is ignored.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        let f = |a, b| if a > b { a } else { b };
        Self::new(f(self.x, other.x), f(self.y, other.y), f(self.z, other.z))
    }
    /// The coordinates without their signs.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }
    /// The largest coordinate; NaN counts as smallest.
    #[inline(always)]
    pub fn max_element(self) -> f32 {
        self.x.max(self.y).max(self.z)
    }
    /// The axis (0, 1, 2) of the largest coordinate; the lowest axis wins a tie.
    #[inline(always)]
    pub fn max_axis(self) -> usize {
        if self.x >= self.y && self.x >= self.z {
            0
        } else {
            1 + usize::from(self.z > self.y)
        }
    }
    /// Whether no coordinate is infinite or NaN.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
    /// The coordinates in an array.
    #[inline(always)]
    pub const fn to_array(self) -> [f32; 3] {
        [self.x, self.y, self.z]
    }
}

impl From<[f32; 3]> for Vec3 {
    #[inline(always)]
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}
impl From<Vec3> for [f32; 3] {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        v.to_array()
    }
}
impl Add for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}
impl AddAssign for Vec3 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl Sub for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}
impl Mul<f32> for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f32) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}
impl Mul for Vec3 {
    type Output = Self;
    /// Coordinate by coordinate.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }
}
impl Div<f32> for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn div(self, s: f32) -> Self {
        Self::new(self.x / s, self.y / s, self.z / s)
    }
}
impl Neg for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}
impl Index<usize> for Vec3 {
    type Output = f32;
    /// # Panics
    /// When `axis` is not 0, 1 or 2.
    #[inline(always)]
    fn index(&self, axis: usize) -> &f32 {
        match axis {
            0 => &self.x,
            1 => &self.y,
            2 => &self.z,
            _ => panic!("a vector has the axes 0, 1 and 2, not {axis}"),
        }
    }
}
impl IndexMut<usize> for Vec3 {
    #[inline(always)]
    fn index_mut(&mut self, axis: usize) -> &mut f32 {
        match axis {
            0 => &mut self.x,
            1 => &mut self.y,
            2 => &mut self.z,
            _ => panic!("a vector has the axes 0, 1 and 2, not {axis}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twelve_bytes() {
        assert_eq!(size_of::<Vec3>(), 12);
    }

    #[test]
    fn normalizes_every_length() {
        for scale in [1.0e-44, 1.0e-38, 1.0e-20, 1.0, 1.0e20, 1.0e38] {
            let n = Vec3::new(3.0 * scale, 0.0, 3.0 * scale).normalized();
            assert!((n.length() - 1.0).abs() < 1.0e-6, "{scale}: {n:?}");
        }
        for none in [0.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Vec3::new(none, 0.0, 0.0).normalized(), Vec3::ZERO);
        }
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(Vec3::new(bad, 1.0, 0.0).normalized(), Vec3::ZERO);
        }
    }

    #[test]
    fn the_lowest_axis_wins_a_tie() {
        assert_eq!(Vec3::new(1.0, 1.0, 1.0).max_axis(), 0);
        assert_eq!(Vec3::new(0.0, 1.0, 1.0).max_axis(), 1);
        assert_eq!(Vec3::new(0.0, 1.0, 2.0).max_axis(), 2);
        assert_eq!(Vec3::new(2.0, 1.0, 2.0).max_axis(), 0);
    }
}
