//! Colours: linear RGB in a [`Vec3`], and the way from and to eight bits of sRGB.

use crate::sample::hash;
use boxwood::Vec3;
use boxwood_scene::srgb_to_linear;
use std::sync::LazyLock;

/// White.
pub const WHITE: Vec3 = Vec3::splat(1.0);

/// Brightness as the eye sees it (Rec. 709).
pub fn luminance(c: Vec3) -> f32 {
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}

/// From `a` (at 0) to `b` (at 1).
pub fn mix(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a * (1.0 - t) + b * t
}

/// 0 below `from`, 1 above `to`, smooth between.
pub fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Linear value of each sRGB byte.
pub static SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| srgb_to_linear(byte as f64 / 255.0) as f32));

/// Each byte as a share of 255.
pub static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| byte as f32 / 255.0));

/// The linear values where rounding goes up to the next sRGB byte.
static STEPS: LazyLock<[f32; 255]> = LazyLock::new(|| {
    std::array::from_fn(|byte| srgb_to_linear((byte as f64 + 0.5) / 255.0) as f32)
});

/// The nearest sRGB byte of a linear value; what is not a number is 0.
pub fn to_srgb(linear: f32) -> u8 {
    STEPS.partition_point(|&step| step <= linear) as u8
}

/// A linear colour in sRGB bytes.
pub fn to_srgb_bytes(c: Vec3) -> [u8; 3] {
    [to_srgb(c.x), to_srgb(c.y), to_srgb(c.z)]
}

/// Bends what is too bright for a screen back below 1, without a change of hue.
///
/// Up to 0.8 of the brightest channel nothing changes. Above, that channel follows `0.8 + 0.2 · x / (1 + x)` with
/// `x = (peak − 0.8) / 0.2`, which leaves 0.8 without a kink and reaches 1 only at infinity; the other channels keep
/// their share of it, and the more was taken away, the paler the colour becomes (up to white), as film does.
pub fn roll_off(c: Vec3) -> Vec3 {
    const KNEE: f32 = 0.8;
    let peak = c.max_element();
    if !(peak > KNEE) {
        return c;
    }
    let over = (peak - KNEE) / (1.0 - KNEE);
    let bent = KNEE + (1.0 - KNEE) * (1.0 - 1.0 / (1.0 + over));
    let kept = c * (bent / peak);
    let paleness = 1.0 - 1.0 / (1.0 + 0.05 * (peak - bent));
    mix(kept, Vec3::splat(bent), paleness)
}

/// A stable colour for a number: neighbours differ in hue; none is too dark to see.
pub fn of_number(n: u32) -> Vec3 {
    let bits = hash(n.wrapping_add(0x51ed_270b));
    let hue = (bits & 0xffff) as f32 / 65536.0 * 6.0;
    let low = 0.08 + (bits >> 16 & 0xff) as f32 / 255.0 * 0.25;
    let high = 0.5 + (bits >> 24) as f32 / 255.0 * 0.4;
    let ramp = |shift: f32| {
        let at = (hue + shift) % 6.0;
        let share = ((at - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        low + (high - low) * share
    };
    Vec3::new(ramp(0.0), ramp(4.0), ramp(2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255_u8 {
            assert_eq!(to_srgb(SRGB[usize::from(byte)]), byte);
        }
        assert_eq!(
            [to_srgb(-1.0), to_srgb(7.0), to_srgb(f32::NAN)],
            [0, 255, 0]
        );
    }

    #[test]
    fn the_table_is_the_standard_curve() {
        assert_eq!(SRGB[0], 0.0);
        assert_eq!(SRGB[255], 1.0);
        assert!((SRGB[10] - 10.0 / 255.0 / 12.92).abs() < 1.0e-9);
        assert!((SRGB[128] - 0.215_860_5).abs() < 1.0e-6);
    }

    #[test]
    fn roll_off_keeps_what_fits_and_the_order_of_the_rest() {
        let quiet = Vec3::new(0.8, 0.3, 0.0);
        assert_eq!(roll_off(quiet), quiet);
        let mut last = 0.8;
        for i in 1..200 {
            let now = roll_off(Vec3::splat(0.8 + i as f32 * 0.1)).x;
            assert!(now > last && now < 1.0, "{i}: {last} {now}");
            last = now;
        }
    }

    #[test]
    fn numbers_have_their_own_colours() {
        let mut seen: Vec<_> = (0..200).map(|n| to_srgb_bytes(of_number(n))).collect();
        seen.sort_unstable();
        seen.dedup();
        assert!(seen.len() >= 198, "{}", seen.len());
    }
}
