//! AVX2 with FMA and BMI: registers of four and eight lanes, sixteen as two.

use super::registers::{Answers, Registers, Select};
use super::{Floats, Kernel, Lanes, Mask, Words};
use core::arch::x86_64::*;
use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// Proof that the machine has AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT: only [`Avx2::detect`] makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2(());

impl Avx2 {
    /// The token, if this machine has the instructions.
    pub fn detect() -> Option<Self> {
        let all = is_x86_feature_detected!("avx2")
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
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn door<const N: usize, K: Kernel<N>>(kernel: K, s: Avx2) -> K::Output
        where
            Avx2: Lanes<N>,
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
        // SAFETY: lane values and tokens of this level exist only where `Avx2::detect` has succeeded, and the memory
        // operands are references to arrays of exactly the register's size.
        unsafe { $e }
    }};
}

/// Four floats.
#[derive(Clone, Copy)]
pub struct F4(__m128);
/// Eight floats.
#[derive(Clone, Copy)]
pub struct F8(__m256);
/// Four words.
#[derive(Clone, Copy)]
pub struct U4(__m128i);
/// Eight words.
#[derive(Clone, Copy)]
pub struct U8(__m256i);
/// Four answers.
#[derive(Clone, Copy)]
pub struct M4(__m128);
/// Eight answers.
#[derive(Clone, Copy)]
pub struct M8(__m256);

impl Lanes<4> for Avx2 {
    type F = F4;
    type U = U4;
    type M = M4;
}
impl Lanes<8> for Avx2 {
    type F = F8;
    type U = U8;
    type M = M8;
}
impl Lanes<16> for Avx2 {
    type F = Registers<F8, 2>;
    type U = Registers<U8, 2>;
    type M = Registers<M8, 2>;
}

macro_rules! arithmetic {
    ($f:ident, $m:ident: $($trait:ident $name:ident $intrinsic:ident),*; $and:ident $or:ident $movemask:ident) => {
        $(impl $trait for $f {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                op!(Self($intrinsic(self.0, other.0)))
            }
        })*
        impl BitAnd for $m {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                op!(Self($and(self.0, other.0)))
            }
        }
        impl BitOr for $m {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                op!(Self($or(self.0, other.0)))
            }
        }
        impl Mask for $m {
            #[inline(always)]
            fn bits(self) -> u32 {
                op!($movemask(self.0) as u32)
            }
        }
    };
}
arithmetic!(F4, M4: Add add _mm_add_ps, Sub sub _mm_sub_ps, Mul mul _mm_mul_ps, Div div _mm_div_ps;
    _mm_and_ps _mm_or_ps _mm_movemask_ps);
arithmetic!(F8, M8: Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps;
    _mm256_and_ps _mm256_or_ps _mm256_movemask_ps);

/// For each set of chosen lanes, the numbers of the chosen lanes, one byte each, closed up.
static CLOSE_UP: [u64; 256] = {
    let mut table = [0; 256];
    let mut chosen = 0;
    while chosen < 256 {
        let (mut lane, mut end) = (0, 0);
        while lane < 8 {
            if chosen >> lane & 1 == 1 {
                table[chosen] |= lane << (8 * end);
                end += 1;
            }
            lane += 1;
        }
        chosen += 1;
    }
    table
};

/// Lane numbers that close up the chosen lanes.
#[inline(always)]
fn close_up(chosen: M8) -> U8 {
    let row = CLOSE_UP[chosen.bits() as usize & 255];
    op!(U8(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(row as i64))))
}

impl Floats<4> for F4 {
    type Token = Avx2;
    type Mask = M4;
    type Words = U4;
    #[inline(always)]
    fn splat(_: Avx2, x: f32) -> Self {
        op!(Self(_mm_set1_ps(x)))
    }
    #[inline(always)]
    fn load(_: Avx2, from: &[f32; 4]) -> Self {
        op!(Self(_mm_loadu_ps(from.as_ptr())))
    }
    #[inline(always)]
    fn from_bytes(_: Avx2, from: &[u8; 4]) -> Self {
        let bytes = i32::from_le_bytes(*from);
        op!(Self(_mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(
            bytes
        )))))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; 4] {
        let mut out = [0.0; 4];
        op!(_mm_storeu_ps(out.as_mut_ptr(), self.0));
        out
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        op!(Self(_mm_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        op!(Self(_mm_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        op!(Self(_mm_andnot_ps(_mm_set1_ps(-0.0), self.0)))
    }
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        let sign = op!(_mm_and_ps(_mm_set1_ps(-0.0), other.0));
        op!(Self(_mm_or_ps(self.abs().0, sign)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M4 {
        op!(M4(_mm_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M4 {
        op!(M4(_mm_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn choose(self, chosen: M4, other: Self) -> Self {
        op!(Self(_mm_blendv_ps(other.0, self.0, chosen.0)))
    }
    #[inline(always)]
    fn times_more(self, factor: Self, more: Self) -> Self {
        op!(Self(_mm_fmadd_ps(self.0, factor.0, more.0)))
    }
    #[inline(always)]
    fn product_error(self, factor: Self, product: Self) -> Self {
        op!(Self(_mm_fmsub_ps(self.0, factor.0, product.0)))
    }
    #[inline(always)]
    fn permute(self, order: U4) -> Self {
        op!(Self(_mm_permutevar_ps(self.0, order.0)))
    }
    #[inline(always)]
    fn compress(self, chosen: M4, out: &mut [MaybeUninit<f32>; 4]) {
        let row = CLOSE_UP[chosen.bits() as usize & 15];
        let order = op!(U4(_mm_cvtepu8_epi32(_mm_cvtsi64_si128(row as i64))));
        op!(_mm_storeu_ps(
            out.as_mut_ptr().cast(),
            self.permute(order).0
        ));
    }
}

impl Words<4> for U4 {
    type Token = Avx2;
    type Mask = M4;
    #[inline(always)]
    fn load(_: Avx2, from: &[u32; 4]) -> Self {
        op!(Self(_mm_loadu_si128(from.as_ptr().cast())))
    }
    #[inline(always)]
    fn from_nibbles(_: Avx2, packed: u64) -> Self {
        op!(Self(_mm_srlv_epi32(
            _mm_set1_epi32(packed as i32),
            _mm_setr_epi32(0, 4, 8, 12)
        )))
    }
    #[inline(always)]
    fn permute(self, order: Self) -> Self {
        op!(Self(_mm_castps_si128(_mm_permutevar_ps(
            _mm_castsi128_ps(self.0),
            order.0
        ))))
    }
    #[inline(always)]
    fn compress(self, chosen: M4, out: &mut [MaybeUninit<u32>; 4]) {
        let row = CLOSE_UP[chosen.bits() as usize & 15];
        let order = op!(U4(_mm_cvtepu8_epi32(_mm_cvtsi64_si128(row as i64))));
        op!(_mm_storeu_si128(
            out.as_mut_ptr().cast(),
            self.permute(order).0
        ));
    }
}

impl Floats<8> for F8 {
    type Token = Avx2;
    type Mask = M8;
    type Words = U8;
    #[inline(always)]
    fn splat(_: Avx2, x: f32) -> Self {
        op!(Self(_mm256_set1_ps(x)))
    }
    #[inline(always)]
    fn load(_: Avx2, from: &[f32; 8]) -> Self {
        op!(Self(_mm256_loadu_ps(from.as_ptr())))
    }
    #[inline(always)]
    fn from_bytes(_: Avx2, from: &[u8; 8]) -> Self {
        let bytes = i64::from_le_bytes(*from);
        op!(Self(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(
            _mm_cvtsi64_si128(bytes)
        ))))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        let mut out = [0.0; 8];
        op!(_mm256_storeu_ps(out.as_mut_ptr(), self.0));
        out
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        op!(Self(_mm256_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        op!(Self(_mm256_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        op!(Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)))
    }
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        let sign = op!(_mm256_and_ps(_mm256_set1_ps(-0.0), other.0));
        op!(Self(_mm256_or_ps(self.abs().0, sign)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M8 {
        op!(M8(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M8 {
        op!(M8(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn choose(self, chosen: M8, other: Self) -> Self {
        op!(Self(_mm256_blendv_ps(other.0, self.0, chosen.0)))
    }
    #[inline(always)]
    fn times_more(self, factor: Self, more: Self) -> Self {
        op!(Self(_mm256_fmadd_ps(self.0, factor.0, more.0)))
    }
    #[inline(always)]
    fn product_error(self, factor: Self, product: Self) -> Self {
        op!(Self(_mm256_fmsub_ps(self.0, factor.0, product.0)))
    }
    #[inline(always)]
    fn permute(self, order: U8) -> Self {
        op!(Self(_mm256_permutevar8x32_ps(self.0, order.0)))
    }
    #[inline(always)]
    fn compress(self, chosen: M8, out: &mut [MaybeUninit<f32>; 8]) {
        op!(_mm256_storeu_ps(
            out.as_mut_ptr().cast(),
            self.permute(close_up(chosen)).0
        ));
    }
}

impl Words<8> for U8 {
    type Token = Avx2;
    type Mask = M8;
    #[inline(always)]
    fn load(_: Avx2, from: &[u32; 8]) -> Self {
        op!(Self(_mm256_loadu_si256(from.as_ptr().cast())))
    }
    #[inline(always)]
    fn from_nibbles(_: Avx2, packed: u64) -> Self {
        let shifts = op!(_mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
        op!(Self(_mm256_srlv_epi32(
            _mm256_set1_epi32(packed as i32),
            shifts
        )))
    }
    #[inline(always)]
    fn permute(self, order: Self) -> Self {
        op!(Self(_mm256_permutevar8x32_epi32(self.0, order.0)))
    }
    #[inline(always)]
    fn compress(self, chosen: M8, out: &mut [MaybeUninit<u32>; 8]) {
        op!(_mm256_storeu_si256(
            out.as_mut_ptr().cast(),
            self.permute(close_up(chosen)).0
        ));
    }
}

impl Select<2> for F8 {
    type Order = U8;
    #[inline(always)]
    fn select([low, high]: [Self; 2], order: U8) -> Self {
        let upper = op!(_mm256_castsi256_ps(_mm256_slli_epi32::<28>(order.0)));
        op!(Self(_mm256_blendv_ps(
            low.permute(order).0,
            high.permute(order).0,
            upper
        )))
    }
}

impl Select<2> for U8 {
    type Order = U8;
    #[inline(always)]
    fn select([low, high]: [Self; 2], order: U8) -> Self {
        let (low, high) = op!((_mm256_castsi256_ps(low.0), _mm256_castsi256_ps(high.0)));
        op!(Self(_mm256_castps_si256(
            F8::select([F8(low), F8(high)], order).0
        )))
    }
}

impl Answers<2> for M8 {
    #[inline(always)]
    fn gather([low, high]: [Self; 2]) -> u32 {
        low.bits() | high.bits() << 8
    }
}
