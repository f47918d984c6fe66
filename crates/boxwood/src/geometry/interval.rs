//! Intervals of doubles: what a formula can be anywhere in a box.
//!
//! *How it works.* Every operation returns an interval that holds the true result for all numbers of its operands. Ends are
//! moved outward by one double after each rounding, and by a few for functions of `libm`, whose errors are below one unit
//! in the last place. What is undefined somewhere (a division by zero, NaN) is [`Interval::ALL`]: nothing is known, so
//! nothing is ever proven wrongly. *Source:* Moore 1966, *Interval Analysis*; Mitchell 1990 for rays.

use crate::math::sqrt_f64;
use core::f64::consts::PI;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// A closed interval of doubles; never empty and never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    lower: f64,
    upper: f64,
}

impl Interval {
    /// All numbers: nothing is known.
    pub const ALL: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
    };

    /// The interval between two numbers, in any order; [`Interval::ALL`] when one is NaN.
    #[inline]
    pub fn new(a: f64, b: f64) -> Self {
        if a <= b {
            Self { lower: a, upper: b }
        } else if b <= a {
            Self { lower: b, upper: a }
        } else {
            Self::ALL
        }
    }
    /// The smallest number in it.
    #[inline]
    pub fn lower(&self) -> f64 {
        self.lower
    }
    /// The largest number in it.
    #[inline]
    pub fn upper(&self) -> f64 {
        self.upper
    }
    /// Whether a number lies in it.
    #[inline]
    pub fn contains(&self, x: f64) -> bool {
        self.lower <= x && x <= self.upper
    }
    /// The largest |number| in it.
    #[inline]
    pub fn magnitude(&self) -> f64 {
        self.upper.max(-self.lower)
    }
    /// The smallest interval around both.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
        }
    }
    /// The numbers in both, where both hold what is looked for; this one where they have none in common.
    #[inline]
    pub fn and(self, other: Self) -> Self {
        let (lower, upper) = (self.lower.max(other.lower), self.upper.min(other.upper));
        if lower <= upper {
            Self { lower, upper }
        } else {
            self
        }
    }
    /// Moved outward by one double at each end, for the rounding of whatever made it.
    #[inline]
    fn rounded(lower: f64, upper: f64) -> Self {
        if lower <= upper {
            Self {
                lower: lower.next_down(),
                upper: upper.next_up(),
            }
        } else {
            Self::ALL
        }
    }
    /// Ends from a function of `libm`: four doubles further out.
    fn loose(lower: f64, upper: f64) -> Self {
        let mut loose = Self::rounded(lower, upper);
        for _ in 0..3 {
            loose = Self::rounded(loose.lower, loose.upper);
        }
        loose
    }

    /// Around `x²`.
    #[inline]
    pub fn square(self) -> Self {
        self.powi(2)
    }
    /// Around `xⁿ`.
    pub fn powi(self, n: u32) -> Self {
        if n == 0 {
            return Self::from(1.0);
        }
        // Each end by repeated products of intervals, so that roundings are in; then the shape of the function.
        let ends = [self.lower, self.upper].map(|x| {
            let x = Self::from(x);
            (1..n).fold(x, |power, _| power * x)
        });
        let both = ends[0].union(ends[1]);
        if n.is_multiple_of(2) {
            let lower = if self.contains(0.0) {
                0.0
            } else {
                both.lower.max(0.0)
            };
            Self {
                lower,
                upper: both.upper,
            }
        } else {
            both
        }
    }
    /// Around `√x` for the numbers that are not negative; [`Interval::ALL`] where there are none.
    pub fn sqrt(self) -> Self {
        if self.upper < 0.0 {
            return Self::ALL;
        }
        let root = Self::rounded(sqrt_f64(self.lower.max(0.0)), sqrt_f64(self.upper));
        Self {
            lower: root.lower.max(0.0),
            ..root
        }
    }
    /// Around `|x|`.
    pub fn abs(self) -> Self {
        let lower = self.lower.max(-self.upper).max(0.0);
        Self {
            lower,
            upper: self.magnitude(),
        }
    }
    /// Around the smaller of two numbers.
    pub fn min(self, other: Self) -> Self {
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.min(other.upper),
        }
    }
    /// Around the larger of two numbers.
    pub fn max(self, other: Self) -> Self {
        Self {
            lower: self.lower.max(other.lower),
            upper: self.upper.max(other.upper),
        }
    }
    /// Around `eˣ`.
    pub fn exp(self) -> Self {
        let e = Self::loose(libm::exp(self.lower), libm::exp(self.upper));
        Self {
            lower: e.lower.max(0.0),
            ..e
        }
    }
    /// Around the sine, radians. Of arguments beyond a billion it only says −1 to 1.
    pub fn sin(self) -> Self {
        self.wave(libm::sin, 0.25)
    }
    /// Around the cosine, radians. Of arguments beyond a billion it only says −1 to 1.
    pub fn cos(self) -> Self {
        self.wave(libm::cos, 0.0)
    }

    /// A function with the period 2π that is 1 at `peak` turns, −1 half a turn later, and monotone between.
    fn wave(self, f: fn(f64) -> f64, peak: f64) -> Self {
        let all = Self {
            lower: -1.0,
            upper: 1.0,
        };
        if !(self.magnitude() < 1.0e9 && self.upper - self.lower < 2.0 * PI) {
            return all;
        }
        let (a, b) = (f(self.lower), f(self.upper));
        // Whether a whole number lies between the ends, measured in turns from an extremum; the margin is the rounding
        // of up to 1.6e8 turns.
        let passes = |at: f64| {
            let from = self.lower / (2.0 * PI) - at;
            let to = self.upper / (2.0 * PI) - at;
            libm::floor(to + 1.0e-7) >= libm::ceil(from - 1.0e-7)
        };
        let ends = Self::loose(a.min(b), a.max(b));
        Self {
            lower: if passes(peak + 0.5) {
                -1.0
            } else {
                ends.lower.max(-1.0)
            },
            upper: if passes(peak) {
                1.0
            } else {
                ends.upper.min(1.0)
            },
        }
    }
}

impl From<f64> for Interval {
    #[inline]
    fn from(x: f64) -> Self {
        Self::new(x, x)
    }
}
impl Add for Interval {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::rounded(self.lower + other.lower, self.upper + other.upper)
    }
}
impl Sub for Interval {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}
impl Neg for Interval {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            lower: -self.upper,
            upper: -self.lower,
        }
    }
}
impl Mul for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let p = [
            self.lower * other.lower,
            self.lower * other.upper,
            self.upper * other.lower,
            self.upper * other.upper,
        ];
        // `min` and `max` would pass over the NaN of 0 · ∞.
        if p.iter().any(|x| x.is_nan()) {
            return Self::ALL;
        }
        Self::rounded(
            p[0].min(p[1]).min(p[2].min(p[3])),
            p[0].max(p[1]).max(p[2].max(p[3])),
        )
    }
}
impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if other.contains(0.0) {
            return Self::ALL;
        }
        self * Self::rounded(1.0 / other.upper, 1.0 / other.lower)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever lies in the operands, its image lies in the result.
    #[test]
    fn results_hold_every_point() {
        let ends = [
            -1.0e9, -7.0, -1.5, -0.3, 0.0, 1.0e-9, 0.2, 1.0, 3.3, 40.0, 1.0e9,
        ];
        let mut intervals = alloc::vec::Vec::new();
        for (k, &a) in ends.iter().enumerate() {
            intervals.extend(ends[k..].iter().map(|&b| Interval::new(a, b)));
        }
        let points = |i: Interval| {
            (0..=8).map(move |k| {
                let s = f64::from(k) / 8.0;
                (i.lower * (1.0 - s) + i.upper * s).clamp(i.lower, i.upper)
            })
        };
        let inside = |name: &str, i: Interval, x: f64| {
            assert!(x.is_nan() || i.contains(x), "{name}: {x} not in {i:?}");
        };
        for &a in &intervals {
            for x in points(a) {
                inside("sin", a.sin(), libm::sin(x));
                inside("cos", a.cos(), libm::cos(x));
                inside("exp", a.exp(), libm::exp(x));
                inside("sqrt", a.sqrt(), libm::sqrt(x));
                inside("abs", a.abs(), x.abs());
                inside("square", a.square(), x * x);
                inside("cube", a.powi(3), x * x * x);
            }
            for &b in &intervals {
                for (x, y) in points(a).zip(points(b)) {
                    inside("sum", a + b, x + y);
                    inside("difference", a - b, x - y);
                    inside("product", a * b, x * y);
                    inside("quotient", a / b, x / y);
                    inside("min", a.min(b), x.min(y));
                    inside("max", a.max(b), x.max(y));
                }
            }
        }
    }

    #[test]
    fn nothing_known_is_everything() {
        assert_eq!(Interval::new(f64::NAN, 1.0), Interval::ALL);
        assert_eq!(
            Interval::from(1.0) / Interval::new(-1.0, 1.0),
            Interval::ALL
        );
        assert_eq!(Interval::from(0.0) * Interval::ALL, Interval::ALL);
        assert_eq!(Interval::new(-2.0, -1.0).sqrt(), Interval::ALL);
        let narrow = Interval::new(0.1, 0.2).sin();
        assert!(narrow.upper() < 0.2 && narrow.lower() > 0.09);
        assert_eq!(Interval::new(1.0, 2.0).sin().upper(), 1.0);
    }
}
