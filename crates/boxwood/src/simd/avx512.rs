//! AVX-512: registers of four, eight and sixteen lanes, masks of their own, compress in one instruction.

use super::{Floats, Kernel, Lanes, Mask, Words};
use core::arch::x86_64::*;
use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// Proof that the machine has AVX-512 F, VL, BW, DQ and BMI: only [`Avx512::detect`] makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx512(());

impl Avx512 {
    /// The token, if this machine has the instructions.
    pub fn detect() -> Option<Self> {
        let all = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        all.then_some(Self(()))
    }

    #[inline(always)]
    pub(super) fn vectorize<const N: usize, K: Kernel<N>>(self, kernel: K) -> K::Output
    where
        Self: Lanes<N>,
    {
        #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn door<const N: usize, K: Kernel<N>>(kernel: K, s: Avx512) -> K::Output
        where
            Avx512: Lanes<N>,
        {
            kernel.run(s)
        }
        // SAFETY: `self` exists only where `detect` has found every feature named above.
        unsafe { door(kernel, self) }
    }
}

/// Calls an intrinsic on values that exist only where `detect` succeeded.
macro_rules! op {
    ($e:expr) => {{
        // SAFETY: lane values and tokens of this level exist only where `Avx512::detect` has succeeded, and the memory
        // operands are references to arrays of exactly the register's size.
        unsafe { $e }
    }};
}

macro_rules! level {
    ($n:literal: $f:ident $u:ident $m:ident, $ps:ident $si:ident $bits:ident;
     $add:ident $sub:ident $mul:ident $div:ident $min:ident $max:ident $cmp:ident
     $and:ident $andnot:ident $or:ident;
     $fmadd:ident $fmsub:ident $blend:ident $set1:ident $load:ident $store:ident $permute:ident $compress:ident;
     $load_u:ident $store_u:ident $permute_u:ident $compress_u:ident; |$packed:ident| $nibbles:expr; |$bytes:ident| $widened:expr) => {
        /// Floats of this width.
        #[derive(Clone, Copy)]
        pub struct $f($ps);
        /// Words of this width.
        #[derive(Clone, Copy)]
        pub struct $u($si);
        /// Answers of this width.
        #[derive(Clone, Copy)]
        pub struct $m($bits);

        impl Lanes<$n> for Avx512 {
            type F = $f;
            type U = $u;
            type M = $m;
        }
        impl Add for $f {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                op!(Self($add(self.0, other.0)))
            }
        }
        impl Sub for $f {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                op!(Self($sub(self.0, other.0)))
            }
        }
        impl Mul for $f {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                op!(Self($mul(self.0, other.0)))
            }
        }
        impl Div for $f {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                op!(Self($div(self.0, other.0)))
            }
        }
        impl BitAnd for $m {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                Self(self.0 & other.0)
            }
        }
        impl BitOr for $m {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }
        impl Mask for $m {
            #[inline(always)]
            fn bits(self) -> u32 {
                u32::from(self.0)
            }
        }
        impl Floats<$n> for $f {
            type Token = Avx512;
            type Mask = $m;
            type Words = $u;
            #[inline(always)]
            fn splat(_: Avx512, x: f32) -> Self {
                op!(Self($set1(x)))
            }
            #[inline(always)]
            fn load(_: Avx512, from: &[f32; $n]) -> Self {
                op!(Self($load(from.as_ptr())))
            }
            #[inline(always)]
            fn from_bytes(_: Avx512, $bytes: &[u8; $n]) -> Self {
                op!(Self($widened))
            }
            #[inline(always)]
            fn to_array(self) -> [f32; $n] {
                let mut out = [0.0; $n];
                op!($store(out.as_mut_ptr(), self.0));
                out
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                op!(Self($min(self.0, other.0)))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                op!(Self($max(self.0, other.0)))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                op!(Self($andnot($set1(-0.0), self.0)))
            }
            #[inline(always)]
            fn signed_as(self, other: Self) -> Self {
                op!(Self($or(self.abs().0, $and($set1(-0.0), other.0))))
            }
            #[inline(always)]
            fn le(self, other: Self) -> $m {
                op!($m($cmp::<_CMP_LE_OQ>(self.0, other.0)))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $m {
                op!($m($cmp::<_CMP_LT_OQ>(self.0, other.0)))
            }
            #[inline(always)]
            fn choose(self, chosen: $m, other: Self) -> Self {
                op!(Self($blend(chosen.0, other.0, self.0)))
            }
            #[inline(always)]
            fn times_more(self, factor: Self, more: Self) -> Self {
                op!(Self($fmadd(self.0, factor.0, more.0)))
            }
            #[inline(always)]
            fn product_error(self, factor: Self, product: Self) -> Self {
                op!(Self($fmsub(self.0, factor.0, product.0)))
            }
            #[inline(always)]
            fn permute(self, order: $u) -> Self {
                op!(Self($permute(order.0, self.0)))
            }
            #[inline(always)]
            fn compress(self, chosen: $m, out: &mut [MaybeUninit<f32>; $n]) {
                // To a register, then a plain store: compressing straight to memory is slower.
                op!($store(out.as_mut_ptr().cast(), $compress(chosen.0, self.0)));
            }
        }
        impl Words<$n> for $u {
            type Token = Avx512;
            type Mask = $m;
            #[inline(always)]
            fn load(_: Avx512, from: &[u32; $n]) -> Self {
                op!(Self($load_u(from.as_ptr().cast())))
            }
            #[inline(always)]
            fn from_nibbles(_: Avx512, $packed: u64) -> Self {
                op!(Self($nibbles))
            }
            #[inline(always)]
            fn permute(self, order: Self) -> Self {
                op!(Self($permute_u(order.0, self.0)))
            }
            #[inline(always)]
            fn compress(self, chosen: $m, out: &mut [MaybeUninit<u32>; $n]) {
                op!($store_u(
                    out.as_mut_ptr().cast(),
                    $compress_u(chosen.0, self.0)
                ));
            }
        }
    };
}

level!(16: F16 U16 M16, __m512 __m512i __mmask16;
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_min_ps _mm512_max_ps _mm512_cmp_ps_mask
    _mm512_and_ps _mm512_andnot_ps _mm512_or_ps;
    _mm512_fmadd_ps _mm512_fmsub_ps _mm512_mask_blend_ps _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_permutexvar_ps _mm512_maskz_compress_ps;
    _mm512_loadu_epi32 _mm512_storeu_epi32 _mm512_permutexvar_epi32 _mm512_maskz_compress_epi32;
    |packed| _mm512_srlv_epi32(
        _mm512_permutexvar_epi32(
            _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1),
            _mm512_castsi128_si512(_mm_cvtsi64_si128(packed as i64))),
        _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20, 24, 28));
    |bytes| _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(_mm_loadu_epi8(bytes.as_ptr().cast()))));

level!(8: F8 U8 M8, __m256 __m256i __mmask8;
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_min_ps _mm256_max_ps _mm256_cmp_ps_mask
    _mm256_and_ps _mm256_andnot_ps _mm256_or_ps;
    _mm256_fmadd_ps _mm256_fmsub_ps _mm256_mask_blend_ps _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_permutexvar_ps _mm256_maskz_compress_ps;
    _mm256_loadu_epi32 _mm256_storeu_epi32 _mm256_permutexvar_epi32 _mm256_maskz_compress_epi32;
    |packed| _mm256_srlv_epi32(
        _mm256_set1_epi32(packed as i32), _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
    |bytes| _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(i64::from_le_bytes(*bytes)))));

/// Four lanes have no `permutexvar`: the same by another name.
///
/// # Safety
/// AVX must be there.
#[inline(always)]
unsafe fn permute4(order: __m128i, x: __m128) -> __m128 {
    op!(_mm_permutevar_ps(x, order))
}

/// As [`permute4`], on words.
///
/// # Safety
/// AVX must be there.
#[inline(always)]
unsafe fn permute4_words(order: __m128i, x: __m128i) -> __m128i {
    op!(_mm_castps_si128(_mm_permutevar_ps(
        _mm_castsi128_ps(x),
        order
    )))
}

level!(4: F4 U4 M4, __m128 __m128i __mmask8;
    _mm_add_ps _mm_sub_ps _mm_mul_ps _mm_div_ps _mm_min_ps _mm_max_ps _mm_cmp_ps_mask
    _mm_and_ps _mm_andnot_ps _mm_or_ps;
    _mm_fmadd_ps _mm_fmsub_ps _mm_mask_blend_ps _mm_set1_ps _mm_loadu_ps _mm_storeu_ps permute4 _mm_maskz_compress_ps;
    _mm_loadu_epi32 _mm_storeu_epi32 permute4_words _mm_maskz_compress_epi32;
    |packed| _mm_srlv_epi32(_mm_set1_epi32(packed as i32), _mm_setr_epi32(0, 4, 8, 12));
    |bytes| _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(i32::from_le_bytes(*bytes)))));
