//! Decimal numbers in text to the nearest `f32`, fast for the short ones that mesh files are full of.
//!
//! *How it works.* Digits go into an integer `m`, the point and the exponent into a power `k`, and the value `m · 10ᵏ`
//! is one division or product of two exact doubles, so the double `d` is `RN₅₃(m · 10ᵏ)`. Rounding `d` again to 24 bits
//! is right unless `d` lies exactly halfway between two neighbouring floats: rounding is monotonic and every such
//! midpoint is itself a double, so the true value and `d` lie on the same side of it or `d` is the midpoint. That case,
//! long mantissas, large exponents, results below the normal floats, `nan` and `inf` go to the general algorithm.
//!
//! *Cost.* About 10 ns a number. *Source.* Clinger 1990 for the exact power; Lemire 2021 (`fast-float2`) for the rest.

/// Powers of ten that a double holds exactly.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The number at the start of `text`, correctly rounded, and how many bytes it takes; `None` where there is none.
///
/// The caller decides what may follow. Besides `1`, `-.5`, `+2.`, `3e-7` this also reads `nan` and `inf`.
#[inline]
pub fn float(text: &[u8]) -> Option<(f32, usize)> {
    let negative = text.first() == Some(&b'-');
    let start = usize::from(negative || text.first() == Some(&b'+'));
    let mut mantissa = 0_u64;
    let mut at = digits(text, start, &mut mantissa);
    let mut read = at - start;
    let mut power = 0;
    if text.get(at) == Some(&b'.') {
        let end = digits(text, at + 1, &mut mantissa);
        let decimals = end - at - 1;
        read += decimals;
        // Kept in range of what follows: from 20 digits on the general algorithm reads it anyway.
        power = -(decimals.min(20) as i32);
        at = end;
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let Some((exponent, end)) = exponent(text, at) else {
            return general(text);
        };
        power += exponent;
        at = end;
    }
    let power_size = power.unsigned_abs() as usize;
    // Nineteen digits always fit the mantissa's 64 bits.
    if read == 0 || read > 19 || mantissa > 1 << 53 || power_size >= EXACT_POWERS.len() {
        return general(text);
    }
    let scale = EXACT_POWERS[power_size];
    let value = if power < 0 {
        mantissa as f64 / scale
    } else {
        mantissa as f64 * scale
    };
    let midpoint = value.to_bits() & 0x1fff_ffff == 0x1000_0000;
    if midpoint || (value < f64::from(f32::MIN_POSITIVE) && mantissa != 0) {
        return general(text);
    }
    let value = value as f32;
    Some((if negative { -value } else { value }, at))
}

/// The whole number at the start of `text` and how many bytes it takes; `None` where there is none, or one of more
/// than 18 digits.
#[inline]
pub fn integer(text: &[u8]) -> Option<(i64, usize)> {
    let negative = text.first() == Some(&b'-');
    let start = usize::from(negative || text.first() == Some(&b'+'));
    let mut size = 0_u64;
    let end = digits(text, start, &mut size);
    if end == start || end - start > 18 {
        return None;
    }
    let size = size as i64;
    Some((if negative { -size } else { size }, end))
}

/// Appends the digits from `at` on to `value` (which wraps around after 19 of them) and says where they end.
#[inline]
fn digits(text: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(digit) = text.get(at).map(|b| b.wrapping_sub(b'0'))
        && digit < 10
    {
        *value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

/// The exponent whose `e` is at `at`, and where it ends. Far too large ones stay far too large.
#[inline(never)]
fn exponent(text: &[u8], at: usize) -> Option<(i32, usize)> {
    let (size, length) = integer(text.get(at + 1..)?)?;
    Some((size.clamp(-100_000, 100_000) as i32, at + 1 + length))
}

#[cold]
fn general(text: &[u8]) -> Option<(f32, usize)> {
    fast_float2::parse_partial::<f32, _>(text).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(text: &str) {
        let right: f32 = text.parse().unwrap();
        let (value, length) =
            float(text.as_bytes()).unwrap_or_else(|| panic!("{text} is a number"));
        assert_eq!(value.to_bits(), right.to_bits(), "{text}");
        assert_eq!(length, text.len(), "{text}");
    }

    #[test]
    fn forms_that_files_use() {
        for text in [
            "0",
            "-0",
            "+1",
            "2.",
            ".5",
            "-.5",
            "1e10",
            "1E-3",
            "0.0503364",
            "1.17549e-38",
            "1e-45",
            "3.4028235e38",
            "3.4028236e38",
            "1e400",
            "-1e-400",
            "9007199254740993",
            "00000000000000000000001",
            "123456789012345678901234567890",
            "0.000000000000000000000000000001",
            "1e+5",
            "inf",
            "-inf",
        ] {
            check(text);
        }
        assert!(float(b"nan").unwrap().0.is_nan());
        for text in ["", "-", ".", "e5", "x", "+-1", "1e", "1e+"] {
            let read = float(text.as_bytes());
            assert!(read.is_none_or(|(_, n)| n < text.len()), "{text}: {read:?}");
        }
        assert_eq!(float(b"1.5 7"), Some((1.5, 3)));
    }

    #[test]
    fn values_whose_double_is_a_midpoint_of_floats() {
        // Just above, on and just below midpoints; each double is the midpoint itself.
        for text in [
            "16777217",
            "16777219",
            "16777217.0000000001",
            "16777216.9999999999",
            "1.000000059604644775",
        ] {
            check(text);
        }
    }

    #[test]
    fn whole_numbers() {
        assert_eq!(integer(b"42 "), Some((42, 2)));
        assert_eq!(integer(b"-1"), Some((-1, 2)));
        assert_eq!(integer(b"+7x"), Some((7, 2)));
        assert_eq!(integer(b"x"), None);
        assert_eq!(integer(b"-"), None);
        assert_eq!(integer(b"9999999999999999999999"), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn every_float_comes_back(bits: u32) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            check(&format!("{value}"));
            check(&format!("{value:e}"));
            check(&format!("{:.6}", value));
        }

        #[test]
        fn decimals_round_as_the_standard_library_does(text in "-?[0-9]{1,12}(\\.[0-9]{0,12})?([eE][+-]?[0-9]{1,2})?") {
            check(&text);
        }

        #[test]
        fn bytes_never_panic(text in proptest::collection::vec(any::<u8>(), 0..40)) {
            if let Some((_, length)) = float(&text) {
                prop_assert!(length <= text.len());
            }
            integer(&text);
        }
    }
}
