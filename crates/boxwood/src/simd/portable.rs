//! Lanes as plain arrays: the definition of every operation, and the level for machines without their own.

use super::{Floats, Kernel, Lanes, Level, Mask, Vectorize, Words};
use core::array::from_fn;
use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// The bit of a float that says below zero.
const SIGN: u32 = 1 << 31;

/// The level that every machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Portable;

/// Lanes in an array.
#[derive(Clone, Copy, Debug)]
pub struct Array<T, const N: usize>([T; N]);

impl<const N: usize> Lanes<N> for Portable {
    type F = Array<f32, N>;
    type U = Array<u32, N>;
    type M = Array<bool, N>;
}

impl<const N: usize> Vectorize<N> for Portable
where
    Level: Vectorize<N>,
{
    /// A call, as at the other levels: inlined, its frame would be that of those who go through another door.
    #[inline(never)]
    fn vectorize<K: Kernel<N>>(self, kernel: K) -> K::Output {
        kernel.run(self)
    }
}

macro_rules! operator {
    ($($trait:ident $name:ident $op:tt),*) => {$(
        impl<const N: usize> $trait for Array<f32, N> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(from_fn(|i| self.0[i] $op other.0[i]))
            }
        }
    )*};
}
operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const N: usize> Floats<N> for Array<f32, N> {
    type Token = Portable;
    type Mask = Array<bool, N>;
    type Words = Array<u32, N>;

    #[inline(always)]
    fn splat(_: Portable, x: f32) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn load(_: Portable, from: &[f32; N]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn from_bytes(_: Portable, from: &[u8; N]) -> Self {
        Self(from_fn(|i| f32::from(from[i])))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; N] {
        self.0
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|i| {
            if self.0[i] < other.0[i] {
                self.0[i]
            } else {
                other.0[i]
            }
        }))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|i| {
            if self.0[i] > other.0[i] {
                self.0[i]
            } else {
                other.0[i]
            }
        }))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(from_fn(|i| f32::from_bits(self.0[i].to_bits() & !SIGN)))
    }
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        Self(from_fn(|i| {
            f32::from_bits(self.0[i].to_bits() & !SIGN | other.0[i].to_bits() & SIGN)
        }))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        Array(from_fn(|i| self.0[i] <= other.0[i]))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        Array(from_fn(|i| self.0[i] < other.0[i]))
    }
    #[inline(always)]
    fn choose(self, chosen: Self::Mask, other: Self) -> Self {
        Self(from_fn(
            |i| {
                if chosen.0[i] { self.0[i] } else { other.0[i] }
            },
        ))
    }
    #[inline(always)]
    fn times_more(self, factor: Self, more: Self) -> Self {
        self * factor + more
    }
    #[inline(always)]
    fn product_error(self, factor: Self, product: Self) -> Self {
        // Each of the three steps in double precision is exact: the bits are those of a fused multiply-add.
        Self(from_fn(|i| {
            (f64::from(self.0[i]) * f64::from(factor.0[i]) - f64::from(product.0[i])) as f32
        }))
    }
    #[inline(always)]
    fn permute(self, order: Self::Words) -> Self {
        Self(from_fn(|i| self.0[order.0[i] as usize % N]))
    }
    #[inline(always)]
    fn compress(self, chosen: Self::Mask, out: &mut [MaybeUninit<f32>; N]) {
        compress(self.0, chosen.0, out);
    }
}

impl<const N: usize> Words<N> for Array<u32, N> {
    type Token = Portable;
    type Mask = Array<bool, N>;

    #[inline(always)]
    fn load(_: Portable, from: &[u32; N]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn from_nibbles(_: Portable, packed: u64) -> Self {
        Self(from_fn(|i| (packed >> (4 * i)) as u32 & 15))
    }
    #[inline(always)]
    fn permute(self, order: Self) -> Self {
        Self(from_fn(|i| self.0[order.0[i] as usize % N]))
    }
    #[inline(always)]
    fn compress(self, chosen: Self::Mask, out: &mut [MaybeUninit<u32>; N]) {
        compress(self.0, chosen.0, out);
    }
}

impl<const N: usize> Mask for Array<bool, N> {
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..N).fold(0, |bits, i| bits | u32::from(self.0[i]) << i)
    }
}

impl<const N: usize> BitAnd for Array<bool, N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] & other.0[i]))
    }
}

impl<const N: usize> BitOr for Array<bool, N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] | other.0[i]))
    }
}

#[inline(always)]
pub(super) fn compress<T: Copy, const N: usize>(
    from: [T; N],
    chosen: [bool; N],
    out: &mut [MaybeUninit<T>; N],
) {
    *out = from.map(MaybeUninit::new);
    let mut end = 0;
    for i in 0..N {
        // Without a branch: write always, advance when chosen. `end <= i`, so nothing unread is lost.
        out[end] = MaybeUninit::new(from[i]);
        end += usize::from(chosen[i]);
    }
}
