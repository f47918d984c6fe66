//! The square root, correctly rounded with and without `std`. All other operations are in `core`.

/// `√x` as a float.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrtf(x)
}
