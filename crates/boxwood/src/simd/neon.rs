//! NEON of 64-bit ARM: registers of four lanes, eight and sixteen as two and four.
//!
//! *How it works.* Every machine of a target that is compiled with NEON has it, so there is nothing to detect and the door is
//! an ordinary call. Lanes are moved by looking bytes up in up to four registers at once.

use super::registers::{Answers, CLOSE_UP, Registers, Select};
use super::{Floats, Kernel, Lanes, Mask, Words};
use core::arch::aarch64::*;
use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// Proof that the machine has NEON: exists only where the target is compiled with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neon(());

impl Neon {
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

/// Calls an intrinsic, whose instruction is there.
macro_rules! op {
    ($e:expr) => {{
        // SAFETY: this module is compiled only where the whole target has NEON, and the memory operands are references to
        // arrays of exactly the register's size.
        unsafe { $e }
    }};
}

/// Four floats.
#[derive(Clone, Copy)]
pub struct F4(float32x4_t);
/// Four words.
#[derive(Clone, Copy)]
pub struct U4(uint32x4_t);
/// Four answers, all bits of a lane alike.
#[derive(Clone, Copy)]
pub struct M4(uint32x4_t);

impl Lanes<4> for Neon {
    type F = F4;
    type U = U4;
    type M = M4;
}
impl Lanes<8> for Neon {
    type F = Registers<F4, 2>;
    type U = Registers<U4, 2>;
    type M = Registers<M4, 2>;
}
impl Lanes<16> for Neon {
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
                op!(Self($intrinsic(self.0, other.0)))
            }
        }
    )*};
}
operators!(F4: Add add vaddq_f32, F4: Sub sub vsubq_f32, F4: Mul mul vmulq_f32, F4: Div div vdivq_f32,
    M4: BitAnd bitand vandq_u32, M4: BitOr bitor vorrq_u32);

impl M4 {
    /// The bits of the chosen lanes, `by` further up, each in its own lane.
    #[inline(always)]
    fn weights(self, by: u32) -> uint32x4_t {
        const WEIGHTS: [[u32; 4]; 4] = [
            [1 << 0, 1 << 1, 1 << 2, 1 << 3],
            [1 << 4, 1 << 5, 1 << 6, 1 << 7],
            [1 << 8, 1 << 9, 1 << 10, 1 << 11],
            [1 << 12, 1 << 13, 1 << 14, 1 << 15],
        ];
        let row = &WEIGHTS[by as usize / 4 % 4];
        op!(vandq_u32(self.0, vld1q_u32(row.as_ptr())))
    }
}

// There is no instruction that gathers one bit of each lane: weights are added up, once for all registers.
impl Mask for M4 {
    #[inline(always)]
    fn bits(self) -> u32 {
        op!(vaddvq_u32(self.weights(0)))
    }
}
impl Answers<2> for M4 {
    #[inline(always)]
    fn gather([a, b]: [Self; 2]) -> u32 {
        op!(vaddvq_u32(vorrq_u32(a.weights(0), b.weights(4))))
    }
}
impl Answers<4> for M4 {
    #[inline(always)]
    fn gather([a, b, c, d]: [Self; 4]) -> u32 {
        let low = op!(vorrq_u32(a.weights(0), b.weights(4)));
        let high = op!(vorrq_u32(c.weights(8), d.weights(12)));
        op!(vaddvq_u32(vorrq_u32(low, high)))
    }
}

/// The numbers of the bytes of the lanes that `order` names among `lanes`.
#[inline(always)]
fn bytes(order: U4, lanes: u32) -> uint8x16_t {
    let lane = op!(vandq_u32(order.0, vdupq_n_u32(lanes - 1)));
    let first = op!(vmulq_u32(lane, vdupq_n_u32(0x0404_0404)));
    op!(vreinterpretq_u8_u32(vaddq_u32(
        first,
        vdupq_n_u32(0x0302_0100)
    )))
}

impl Select<1> for U4 {
    type Order = U4;
    #[inline(always)]
    fn select([a]: [Self; 1], order: U4) -> Self {
        let table = op!(vreinterpretq_u8_u32(a.0));
        op!(Self(vreinterpretq_u32_u8(vqtbl1q_u8(
            table,
            bytes(order, 4)
        ))))
    }
}
impl Select<2> for U4 {
    type Order = U4;
    #[inline(always)]
    fn select([a, b]: [Self; 2], order: U4) -> Self {
        let table = op!(uint8x16x2_t(
            vreinterpretq_u8_u32(a.0),
            vreinterpretq_u8_u32(b.0)
        ));
        op!(Self(vreinterpretq_u32_u8(vqtbl2q_u8(
            table,
            bytes(order, 8)
        ))))
    }
}
impl Select<4> for U4 {
    type Order = U4;
    #[inline(always)]
    fn select([a, b, c, d]: [Self; 4], order: U4) -> Self {
        let table = op!(uint8x16x4_t(
            vreinterpretq_u8_u32(a.0),
            vreinterpretq_u8_u32(b.0),
            vreinterpretq_u8_u32(c.0),
            vreinterpretq_u8_u32(d.0)
        ));
        op!(Self(vreinterpretq_u32_u8(vqtbl4q_u8(
            table,
            bytes(order, 16)
        ))))
    }
}

macro_rules! select {
    ($($r:literal: $($k:literal)*),*) => {$(
        impl Select<$r> for F4 {
            type Order = U4;
            #[inline(always)]
            fn select(all: [Self; $r], order: U4) -> Self {
                U4::select([$(all[$k].words()),*], order).floats()
            }
        }
    )*};
}
select!(1: 0, 2: 0 1, 4: 0 1 2 3);

impl F4 {
    #[inline(always)]
    fn words(self) -> U4 {
        op!(U4(vreinterpretq_u32_f32(self.0)))
    }
}

impl U4 {
    #[inline(always)]
    fn floats(self) -> F4 {
        op!(F4(vreinterpretq_f32_u32(self.0)))
    }
    #[inline(always)]
    fn of(words: &[u32; 4]) -> Self {
        op!(Self(vld1q_u32(words.as_ptr())))
    }
}

impl Floats<4> for F4 {
    type Token = Neon;
    type Mask = M4;
    type Words = U4;
    #[inline(always)]
    fn splat(_: Neon, x: f32) -> Self {
        op!(Self(vdupq_n_f32(x)))
    }
    #[inline(always)]
    fn load(_: Neon, from: &[f32; 4]) -> Self {
        op!(Self(vld1q_f32(from.as_ptr())))
    }
    #[inline(always)]
    fn from_bytes(_: Neon, from: &[u8; 4]) -> Self {
        let bytes = op!(vcreate_u8(u64::from(u32::from_le_bytes(*from))));
        let words = op!(vmovl_u16(vget_low_u16(vmovl_u8(bytes))));
        op!(Self(vcvtq_f32_u32(words)))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; 4] {
        let mut out = [0.0; 4];
        op!(vst1q_f32(out.as_mut_ptr(), self.0));
        out
    }
    // The instructions for the least and the greatest return NaN, or avoid it, whichever operand it is.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        op!(Self(vbslq_f32(self.lt(other).0, self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        op!(Self(vbslq_f32(other.lt(self).0, self.0, other.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        op!(Self(vabsq_f32(self.0)))
    }
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        op!(Self(vbslq_f32(vdupq_n_u32(1 << 31), other.0, self.0)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M4 {
        op!(M4(vcleq_f32(self.0, other.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M4 {
        op!(M4(vcltq_f32(self.0, other.0)))
    }
    #[inline(always)]
    fn choose(self, chosen: M4, other: Self) -> Self {
        op!(Self(vbslq_f32(chosen.0, self.0, other.0)))
    }
    #[inline(always)]
    fn times_more(self, factor: Self, more: Self) -> Self {
        op!(Self(vfmaq_f32(more.0, self.0, factor.0)))
    }
    #[inline(always)]
    fn product_error(self, factor: Self, product: Self) -> Self {
        op!(Self(vfmaq_f32(vnegq_f32(product.0), self.0, factor.0)))
    }
    #[inline(always)]
    fn permute(self, order: U4) -> Self {
        Self::select([self], order)
    }
    #[inline(always)]
    fn compress(self, chosen: M4, out: &mut [MaybeUninit<f32>; 4]) {
        let order = U4::of(&CLOSE_UP[chosen.bits() as usize & 15]);
        op!(vst1q_f32(out.as_mut_ptr().cast(), self.permute(order).0));
    }
}

impl Words<4> for U4 {
    type Token = Neon;
    type Mask = M4;
    #[inline(always)]
    fn load(_: Neon, from: &[u32; 4]) -> Self {
        Self::of(from)
    }
    #[inline(always)]
    fn from_nibbles(_: Neon, packed: u64) -> Self {
        // A shift to the left by less than nothing is one to the right.
        let by = [0_i32, -4, -8, -12];
        op!(Self(vshlq_u32(
            vdupq_n_u32(packed as u32),
            vld1q_s32(by.as_ptr())
        )))
    }
    #[inline(always)]
    fn permute(self, order: Self) -> Self {
        Self::select([self], order)
    }
    #[inline(always)]
    fn compress(self, chosen: M4, out: &mut [MaybeUninit<u32>; 4]) {
        let order = Self::of(&CLOSE_UP[chosen.bits() as usize & 15]);
        op!(vst1q_u32(out.as_mut_ptr().cast(), self.permute(order).0));
    }
}
