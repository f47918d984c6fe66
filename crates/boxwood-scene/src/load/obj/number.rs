//! Decimal numbers from bytes, fast and correctly rounded.
//!
//! *How it works.* The digits are gathered into one integer `m` and a power of ten `e`. While `m < 2⁵³` and `|e| ≤ 22`
//! both are exact in `f64`, so that `m · 10^e` is rounded once. Rounding that again to `f32` is right as long as the
//! `f64` does not lie exactly halfway between two `f32` and outside the subnormals; those, and everything longer,
//! go to the standard library. *Cost.* About one nanosecond per digit. *Source.* Clinger 1990, *How to Read Floating
//! Point Numbers Accurately*.

/// Powers of ten that are exact in `f64`.
const TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// So many decimal digits always fit in a `u64`.
const MAX_DIGITS: usize = 19;

/// Reads a number at the start of `bytes`: its value and its length in bytes.
///
/// `None` where the quick way does not suffice or there is no number; then [`exact`] decides on the whole word.
#[inline]
pub(super) fn quick(bytes: &[u8]) -> Option<(f32, usize)> {
    let (negative, start) = match bytes.first()? {
        b'-' => (true, 1),
        b'+' => (false, 1),
        _ => (false, 0),
    };
    let (whole, mut at) = digits(bytes, start, 0);
    let mut count = at - start;
    let mut mantissa = whole;
    let mut exponent = 0_i32;
    if bytes.get(at) == Some(&b'.') {
        let (all, end) = digits(bytes, at + 1, mantissa);
        let places = end - at - 1;
        mantissa = all;
        count += places;
        if count > MAX_DIGITS {
            return None;
        }
        exponent = -(places as i32);
        at = end;
    }
    if count == 0 || count > MAX_DIGITS {
        return None;
    }
    if let Some(b'e' | b'E') = bytes.get(at) {
        let (negative, start) = match bytes.get(at + 1)? {
            b'-' => (true, at + 2),
            b'+' => (false, at + 2),
            _ => (false, at + 1),
        };
        let (power, end) = digits(bytes, start, 0);
        if end == start || end - start > 4 {
            return None;
        }
        exponent += if negative {
            -(power as i32)
        } else {
            power as i32
        };
        at = end;
    }
    Some((round(negative, mantissa, exponent)?, at))
}

/// What the whole word says, by the standard library: also `inf` and `nan`. `None` when it is no number.
#[cold]
pub(super) fn exact(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Appends the digits at `at` to `value`; wraps when there are too many, which the caller counts.
#[inline]
fn digits(bytes: &[u8], mut at: usize, mut value: u64) -> (u64, usize) {
    while let Some(&byte) = bytes.get(at) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    (value, at)
}

/// `± mantissa · 10^exponent`, or `None` where two roundings might differ from one.
#[inline]
fn round(negative: bool, mantissa: u64, exponent: i32) -> Option<f32> {
    if mantissa == 0 {
        return Some(if negative { -0.0 } else { 0.0 });
    }
    if mantissa >= 1 << 53 {
        return None;
    }
    let power = *TEN.get(exponent.unsigned_abs() as usize)?;
    let value = if exponent < 0 {
        mantissa as f64 / power
    } else {
        mantissa as f64 * power
    };
    // The 29 bits that `f32` drops: exactly a half says nothing about the side on which the true value lies.
    let halfway = value.to_bits() & 0x1FFF_FFFF == 0x1000_0000;
    let normal = (f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&value);
    if halfway || !normal {
        return None;
    }
    Some(if negative {
        -value as f32
    } else {
        value as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn both(text: &str) -> Option<f32> {
        let quick = quick(text.as_bytes()).filter(|&(_, end)| end == text.len());
        quick.map(|(value, _)| value).or(exact(text.as_bytes()))
    }

    #[test]
    fn odd_forms_are_read_as_the_standard_library_reads_them() {
        for text in [
            "0",
            "-0",
            "+1",
            "2.",
            ".5",
            "-.5",
            "1e2",
            "2.e01",
            "1E-2",
            "3.1e+2",
            "16777217",
            "1.00000005960464477539",
            "1.0000000596046448",
            "3.4028236e38",
            "1e-40",
            "1e400",
            "00000000000000000000000000001",
            "123456789012345678901234567890",
            "4.7019774e-38",
            "0.000000000000000000000000000000000001",
            "9007199254740993",
            "1e22",
            "1e23",
            "1e99999",
        ] {
            let right: f32 = text.parse().unwrap();
            assert_eq!(both(text).unwrap().to_bits(), right.to_bits(), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in [
            "", "-", "+", ".", "e5", "1e", "1e+", "3.1+e2", "1,5", "0x10", "--1", "1.2.3",
        ] {
            assert_eq!(both(text), None, "{text:?}");
        }
    }

    #[test]
    fn a_number_ends_where_its_digits_end() {
        assert_eq!(quick(b"1.5 2"), Some((1.5, 3)));
        assert_eq!(quick(b"7/3"), Some((7.0, 1)));
    }

    proptest! {
        #[test]
        fn every_decimal_is_rounded_once(
            negative: bool, m in prop_oneof![0_u64..1 << 24, 0_u64..1 << 54, any::<u64>()],
            places in 0_usize..24, e in -50_i32..45, with_exponent: bool,
        ) {
            let digits = format!("{m:024}");
            let (whole, fraction) = digits.split_at(24 - places);
            let mut text = format!(
                "{}{}.{fraction}",
                if negative { "-" } else { "" },
                whole.trim_start_matches('0'),
            );
            if text.ends_with('.') && text.len() < 3 {
                text.push('0');
            }
            if with_exponent {
                text += &format!("e{e}");
            }
            let right: f32 = text.parse().unwrap();
            prop_assert_eq!(both(&text).unwrap().to_bits(), right.to_bits(), "{}", text);
        }

        /// Points halfway between neighbours and just beside them, where rounding twice goes wrong.
        #[test]
        fn halfway_points_are_rounded_right(bits in 0x0080_0000_u32..0x7F00_0000, beside in -1_i64..=1) {
            let low = f64::from(f32::from_bits(bits));
            let high = f64::from(f32::from_bits(bits + 1));
            let middle = f64::from_bits(((low + (high - low) * 0.5).to_bits() as i64 + beside) as u64);
            let text = format!("{middle:e}");
            let right: f32 = text.parse().unwrap();
            prop_assert_eq!(both(&text).unwrap().to_bits(), right.to_bits(), "{}", text);
        }
    }
}
