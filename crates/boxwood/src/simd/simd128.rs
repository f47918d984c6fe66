//! The 128-bit registers of WebAssembly: four lanes, eight and sixteen as two and four.
//!
//! *How it works.* A WebAssembly module either has these instructions or does not, as a whole, and is refused by a machine
//! without them: what is compiled with `-C target-feature=+simd128` has nothing to detect, and the door is an ordinary call.
//! Relaxed instructions, whose results depend on the machine, are not used.

use super::registers::{Answers, CLOSE_UP, Registers, Select};
use super::{Floats, Kernel, Lanes, Mask, Words};
use core::arch::wasm32::*;
use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// Proof that the machine has 128-bit registers: exists only in modules that are compiled for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simd128(());

impl Simd128 {
    /// The token.
    pub fn detect() -> Option<Self> {
        Some(Self(()))
    }

    #[inline(always)]
    pub(super) fn vectorize<const N: usize, K: Kernel<N>>(self, kernel: K) -> K::Output
    where
        Self: Lanes<N>,
    {
        kernel.run(self)
    }
}

/// Four floats.
#[derive(Clone, Copy)]
pub struct F4(v128);
/// Four words.
#[derive(Clone, Copy)]
pub struct U4(v128);
/// Four answers, all bits of a lane alike.
#[derive(Clone, Copy)]
pub struct M4(v128);

impl Lanes<4> for Simd128 {
    type F = F4;
    type U = U4;
    type M = M4;
}
impl Lanes<8> for Simd128 {
    type F = Registers<F4, 2>;
    type U = Registers<U4, 2>;
    type M = Registers<M4, 2>;
}
impl Lanes<16> for Simd128 {
    type F = Registers<F4, 4>;
    type U = Registers<U4, 4>;
    type M = Registers<M4, 4>;
}

macro_rules! operators {
    ($($t:ident: $trait:ident $name:ident $intrinsic:ident),*) => {$(
        impl $trait for $t {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self($intrinsic(self.0, other.0))
            }
        }
    )*};
}
operators!(F4: Add add f32x4_add, F4: Sub sub f32x4_sub, F4: Mul mul f32x4_mul, F4: Div div f32x4_div,
    M4: BitAnd bitand v128_and, M4: BitOr bitor v128_or);

impl Mask for M4 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(u32x4_bitmask(self.0))
    }
}
impl Answers<2> for M4 {
    #[inline(always)]
    fn gather([a, b]: [Self; 2]) -> u32 {
        a.bits() | b.bits() << 4
    }
}
impl Answers<4> for M4 {
    #[inline(always)]
    fn gather([a, b, c, d]: [Self; 4]) -> u32 {
        // Sixteen answers narrowed to bytes, whose bits come in one piece. They are 0 and -1: narrowing keeps them.
        let low = i16x8_narrow_i32x4(a.0, b.0);
        let high = i16x8_narrow_i32x4(c.0, d.0);
        u32::from(u8x16_bitmask(i8x16_narrow_i16x8(low, high)))
    }
}

/// The numbers of the bytes of the lanes that `order` names among `lanes`.
#[inline(always)]
fn bytes(order: v128, lanes: u32) -> v128 {
    let lane = v128_and(order, u32x4_splat(lanes - 1));
    u32x4_add(
        u32x4_mul(lane, u32x4_splat(0x0404_0404)),
        u32x4_splat(0x0302_0100),
    )
}

/// The bytes that lie in register `k`, and zero for those of others: a look-up beyond 15 finds zero, and so does one before 0,
/// which wraps round.
#[inline(always)]
fn look_up(register: v128, bytes: v128, k: u8) -> v128 {
    u8x16_swizzle(register, u8x16_sub(bytes, u8x16_splat(16 * k)))
}

macro_rules! select {
    ($($t:ident: $r:literal: $($k:literal)*),*) => {$(
        impl Select<$r> for $t {
            type Order = U4;
            #[inline(always)]
            fn select(all: [Self; $r], order: U4) -> Self {
                let bytes = bytes(order.0, 4 * $r);
                let found = u32x4_splat(0);
                $(let found = v128_or(found, look_up(all[$k].0, bytes, $k));)*
                Self(found)
            }
        }
    )*};
}
select!(F4: 1: 0, F4: 2: 0 1, F4: 4: 0 1 2 3, U4: 1: 0, U4: 2: 0 1, U4: 4: 0 1 2 3);

#[inline(always)]
fn load<T>(from: &[T; 4]) -> v128 {
    const { assert!(size_of::<T>() == 4) };
    // SAFETY: the array is initialised and has the size of a register, which need not be aligned.
    unsafe { v128_load(from.as_ptr().cast()) }
}

/// Writes the chosen lanes, closed up, to the front of `out`, and something after them.
#[inline(always)]
fn close_up<T>(lanes: v128, chosen: M4, out: &mut [MaybeUninit<T>; 4]) {
    const { assert!(size_of::<T>() == 4) };
    let order = U4(load(&CLOSE_UP[chosen.bits() as usize & 15]));
    let closed = U4::select([U4(lanes)], order);
    // SAFETY: the array has the size of a register, which need not be aligned.
    unsafe { v128_store(out.as_mut_ptr().cast(), closed.0) }
}

impl Floats<4> for F4 {
    type Token = Simd128;
    type Mask = M4;
    type Words = U4;
    #[inline(always)]
    fn splat(_: Simd128, x: f32) -> Self {
        Self(f32x4_splat(x))
    }
    #[inline(always)]
    fn load(_: Simd128, from: &[f32; 4]) -> Self {
        Self(load(from))
    }
    #[inline(always)]
    fn from_bytes(_: Simd128, from: &[u8; 4]) -> Self {
        let bytes = u32x4_splat(u32::from_le_bytes(*from));
        let words = u32x4_extend_low_u16x8(u16x8_extend_low_u8x16(bytes));
        Self(f32x4_convert_u32x4(words))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; 4] {
        [
            f32x4_extract_lane::<0>(self.0),
            f32x4_extract_lane::<1>(self.0),
            f32x4_extract_lane::<2>(self.0),
            f32x4_extract_lane::<3>(self.0),
        ]
    }
    // `pmin(a, b)` is `b < a ? b : a`: the operands change places.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(f32x4_pmin(other.0, self.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(f32x4_pmax(other.0, self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(f32x4_abs(self.0))
    }
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        Self(v128_bitselect(other.0, self.0, u32x4_splat(1 << 31)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M4 {
        M4(f32x4_le(self.0, other.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M4 {
        M4(f32x4_lt(self.0, other.0))
    }
    #[inline(always)]
    fn choose(self, chosen: M4, other: Self) -> Self {
        Self(v128_bitselect(self.0, other.0, chosen.0))
    }
    #[inline(always)]
    fn times_more(self, factor: Self, more: Self) -> Self {
        self * factor + more
    }
    #[inline(always)]
    fn product_error(self, factor: Self, product: Self) -> Self {
        // As the portable level: exact in double precision.
        let low = half_error(self.0, factor.0, product.0);
        let high = half_error(upper(self.0), upper(factor.0), upper(product.0));
        Self(u32x4_shuffle::<0, 1, 4, 5>(low, high))
    }
    #[inline(always)]
    fn permute(self, order: U4) -> Self {
        Self::select([self], order)
    }
    #[inline(always)]
    fn compress(self, chosen: M4, out: &mut [MaybeUninit<f32>; 4]) {
        close_up(self.0, chosen, out);
    }
}

/// The upper two lanes, moved down.
#[inline(always)]
fn upper(x: v128) -> v128 {
    u32x4_shuffle::<2, 3, 2, 3>(x, x)
}

/// The errors of the lower two products.
#[inline(always)]
fn half_error(a: v128, b: v128, product: v128) -> v128 {
    let exact = f64x2_mul(f64x2_promote_low_f32x4(a), f64x2_promote_low_f32x4(b));
    f32x4_demote_f64x2_zero(f64x2_sub(exact, f64x2_promote_low_f32x4(product)))
}

impl Words<4> for U4 {
    type Token = Simd128;
    type Mask = M4;
    #[inline(always)]
    fn load(_: Simd128, from: &[u32; 4]) -> Self {
        Self(load(from))
    }
    #[inline(always)]
    fn from_nibbles(_: Simd128, packed: u64) -> Self {
        // Lanes cannot be shifted by different amounts, but multiplied: each nibble to the place of the highest.
        let to_bit_12 = u32x4(1 << 12, 1 << 8, 1 << 4, 1);
        Self(u32x4_shr(
            u32x4_mul(u32x4_splat(packed as u32), to_bit_12),
            12,
        ))
    }
    #[inline(always)]
    fn permute(self, order: Self) -> Self {
        Self::select([self], order)
    }
    #[inline(always)]
    fn compress(self, chosen: M4, out: &mut [MaybeUninit<u32>; 4]) {
        close_up(self.0, chosen, out);
    }
}
