//! Functions that are the same bits with and without `std`, and on every machine.
//!
//! Square roots are correctly rounded everywhere; angles and logarithms come from `libm`, never from the system. All other operations
//! are in `core`.

/// `√x` as a float.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrtf(x)
}

/// `√x` in double precision.
#[inline(always)]
pub fn sqrt_f64(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrt(x)
}

/// The binary logarithm in double precision.
pub fn log2(x: f64) -> f64 {
    libm::log2(x)
}

/// `2ˣ` in double precision.
pub fn exp2(x: f64) -> f64 {
    libm::exp2(x)
}

/// The lesser of two, as one instruction; the second where either is NaN.
#[inline(always)]
pub fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two, as one instruction; the second where either is NaN.
#[inline(always)]
pub fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The angle of `(x, y)` in turns, from 0 to 1; both mean the positive x axis. 0 for the zero vector.
#[inline]
pub fn turn(y: f64, x: f64) -> f32 {
    let turns = libm::atan2f(y as f32, x as f32) * (0.5 * core::f32::consts::FRAC_1_PI);
    if turns < 0.0 { turns + 1.0 } else { turns }
}

/// The power of two, among those that floats hold, that brings `x` nearest to the interval from 1 to 2.
pub fn power_to_one(x: f32) -> f32 {
    libm::scalbnf(1.0, -libm::ilogbf(x).clamp(-127, 127))
}
