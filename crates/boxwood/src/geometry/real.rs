//! One formula, read as a number, as an interval, and with its derivative.
//!
//! *How it works.* A formula that is generic over [`Real`] can be asked for its value (`f64`), for all values in a box
//! ([`Interval`]), and for its slope along a line ([`Dual`], forward differentiation; Wengert 1964). So one text yields
//! everything that a proof about its roots needs. *Cost:* an interval costs about four numbers, a dual two or three.

use super::interval::Interval;
use crate::math::sqrt_f64;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// What formulas compute with. Numbers enter as `T::from(0.5)`, or to the right of an operator: `x * x * 4.0 - 1.0`.
pub trait Real:
    Copy
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// `xⁿ`. For intervals narrower than a product of equal factors.
    #[must_use]
    fn powi(self, n: u32) -> Self;
    /// `x²`.
    #[must_use]
    fn square(self) -> Self {
        self.powi(2)
    }
    /// `√x`.
    #[must_use]
    fn sqrt(self) -> Self;
    /// `|x|`.
    #[must_use]
    fn abs(self) -> Self;
    /// The smaller.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// The larger.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// The sine, radians.
    #[must_use]
    fn sin(self) -> Self;
    /// The cosine, radians.
    #[must_use]
    fn cos(self) -> Self;
    /// `eˣ`.
    #[must_use]
    fn exp(self) -> Self;
}

impl Real for f64 {
    fn powi(self, n: u32) -> Self {
        (0..n).fold(1.0, |power, _| power * self)
    }
    fn sqrt(self) -> Self {
        sqrt_f64(self)
    }
    fn abs(self) -> Self {
        Self::abs(self)
    }
    fn min(self, other: Self) -> Self {
        Self::min(self, other)
    }
    fn max(self, other: Self) -> Self {
        Self::max(self, other)
    }
    fn sin(self) -> Self {
        libm::sin(self)
    }
    fn cos(self) -> Self {
        libm::cos(self)
    }
    fn exp(self) -> Self {
        libm::exp(self)
    }
}

impl Real for Interval {
    fn powi(self, n: u32) -> Self {
        Self::powi(self, n)
    }
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    fn abs(self) -> Self {
        Self::abs(self)
    }
    fn min(self, other: Self) -> Self {
        Self::min(self, other)
    }
    fn max(self, other: Self) -> Self {
        Self::max(self, other)
    }
    fn sin(self) -> Self {
        Self::sin(self)
    }
    fn cos(self) -> Self {
        Self::cos(self)
    }
    fn exp(self) -> Self {
        Self::exp(self)
    }
}

/// A value and its slope: the derivative along one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T> {
    /// The value.
    pub value: T,
    /// Its derivative.
    pub slope: T,
}

/// A number that can decide, or fail to decide, which of two is smaller.
pub trait Branch: Real {
    /// What is known of the slope of a piecewise formula: `a` where `at` is negative, `b` where it is positive, and
    /// whatever holds both where that is not known.
    #[must_use]
    fn choose(at: Self, a: Self, b: Self) -> Self;
}

impl Branch for f64 {
    fn choose(at: Self, a: Self, b: Self) -> Self {
        if at < 0.0 { a } else { b }
    }
}

impl Branch for Interval {
    fn choose(at: Self, a: Self, b: Self) -> Self {
        if at.upper() < 0.0 {
            a
        } else if at.lower() > 0.0 {
            b
        } else {
            a.union(b)
        }
    }
}

impl<T: Real> Dual<T> {
    #[inline]
    fn new(value: T, slope: T) -> Self {
        Self { value, slope }
    }
}

impl<T: Branch> Real for Dual<T> {
    fn powi(self, n: u32) -> Self {
        let slope = match n {
            0 => T::from(0.0),
            _ => self.value.powi(n - 1) * f64::from(n) * self.slope,
        };
        Self::new(self.value.powi(n), slope)
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Self::new(root, self.slope / (root * 2.0))
    }
    fn abs(self) -> Self {
        Self::new(
            self.value.abs(),
            T::choose(self.value, -self.slope, self.slope),
        )
    }
    fn min(self, other: Self) -> Self {
        Self::new(
            self.value.min(other.value),
            T::choose(self.value - other.value, self.slope, other.slope),
        )
    }
    fn max(self, other: Self) -> Self {
        Self::new(
            self.value.max(other.value),
            T::choose(self.value - other.value, other.slope, self.slope),
        )
    }
    fn sin(self) -> Self {
        Self::new(self.value.sin(), self.value.cos() * self.slope)
    }
    fn cos(self) -> Self {
        Self::new(self.value.cos(), -self.value.sin() * self.slope)
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        Self::new(e, e * self.slope)
    }
}

impl<T: Real> From<f64> for Dual<T> {
    #[inline]
    fn from(x: f64) -> Self {
        Self::new(T::from(x), T::from(0.0))
    }
}
impl<T: Real> Neg for Dual<T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.value, -self.slope)
    }
}
impl<T: Real> Add for Dual<T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.slope + other.slope)
    }
}
impl<T: Real> Sub for Dual<T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.value - other.value, self.slope - other.slope)
    }
}
impl<T: Real> Mul for Dual<T> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self::new(
            self.value * other.value,
            self.slope * other.value + self.value * other.slope,
        )
    }
}
impl<T: Real> Div for Dual<T> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self::new(value, (self.slope - value * other.slope) / other.value)
    }
}

macro_rules! with_numbers {
    ($([$($generics:tt)*] $type:ty),*) => {$(
        impl<$($generics)*> Add<f64> for $type {
            type Output = Self;
            #[inline]
            fn add(self, other: f64) -> Self {
                self + Self::from(other)
            }
        }
        impl<$($generics)*> Sub<f64> for $type {
            type Output = Self;
            #[inline]
            fn sub(self, other: f64) -> Self {
                self - Self::from(other)
            }
        }
        impl<$($generics)*> Mul<f64> for $type {
            type Output = Self;
            #[inline]
            fn mul(self, other: f64) -> Self {
                self * Self::from(other)
            }
        }
        impl<$($generics)*> Div<f64> for $type {
            type Output = Self;
            #[inline]
            fn div(self, other: f64) -> Self {
                self / Self::from(other)
            }
        }
    )*};
}
with_numbers!([] Interval, [T: Real] Dual<T>);

#[cfg(test)]
mod tests {
    use super::*;

    fn formula<T: Real>(x: T) -> T {
        let a = (x.square() + 1.0).sqrt() * (x * 2.0).sin() - (x / 3.0).exp();
        (a.max(x.cos()) + (x - 0.4).abs().min(a) + x.powi(3)) / (x.square() + 2.0)
    }

    /// The slope is the difference quotient, and intervals hold values and slopes.
    #[test]
    fn one_formula_three_readings() {
        let mut k = -40;
        while k < 40 {
            let x = f64::from(k) * 0.0713;
            let slope = formula(Dual::new(x, 1.0)).slope;
            let quotient = (formula(x + 1.0e-6) - formula(x - 1.0e-6)) / 2.0e-6;
            assert!(
                (slope - quotient).abs() < 1.0e-5,
                "{slope} {quotient} at {x}"
            );
            for width in [1.0e-6, 0.01, 0.3] {
                let around = Interval::new(x - width, x + 0.5 * width);
                let dual = formula(Dual::new(around, Interval::from(1.0)));
                assert!(dual.value.contains(formula(x)), "{dual:?}");
                assert!(dual.slope.contains(slope), "{dual:?}");
            }
            k += 1;
        }
    }
}
