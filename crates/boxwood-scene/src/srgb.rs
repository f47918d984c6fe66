//! The transfer curve of sRGB (IEC 61966-2-1): colours in files are stored with it, light adds up without it.

/// A stored component in 0 to 1 as linear light. The same bits on every machine.
pub fn srgb_to_linear(stored: f64) -> f64 {
    if stored <= 0.04045 {
        stored / 12.92
    } else {
        libm::pow((stored + 0.055) / 1.055, 2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middle() {
        assert_eq!(srgb_to_linear(0.0), 0.0);
        assert!((srgb_to_linear(1.0) - 1.0).abs() < 1.0e-12);
        assert!((srgb_to_linear(0.5) - 0.214_041_14).abs() < 1.0e-8);
    }
}
