//! Wide lanes out of several short registers, for levels whose registers are that short.

use super::{Floats, Mask, Words};
use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// `R` registers side by side, the one with lane 0 first.
#[derive(Clone, Copy, Debug)]
pub struct Registers<T, const R: usize>(pub [T; R]);

/// What registers side by side need beyond the operations of each: one look-up across all of them.
pub trait Select<const R: usize>: Copy {
    /// Lane `i` is the lane of all registers that `order[i]` names. Only the low bits that name a lane count.
    fn select(all: [Self; R], order: Self::Order) -> Self;
    /// As many lane numbers as a register has lanes.
    type Order: Copy;
}

/// Answers that lie side by side.
pub trait Answers<const R: usize>: Mask {
    /// Lane `i` of all registers in bit `i`.
    fn gather(all: [Self; R]) -> u32;
}

impl<M: Answers<R>, const R: usize> Mask for Registers<M, R>
where
    Self: BitAnd<Output = Self> + BitOr<Output = Self>,
{
    #[inline(always)]
    fn bits(self) -> u32 {
        M::gather(self.0)
    }
}

macro_rules! operator {
    ($trait:ident $name:ident for $r:literal: $($k:literal)*) => {
        impl<T: $trait<Output = T> + Copy> $trait for Registers<T, $r> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self([$(self.0[$k].$name(other.0[$k])),*])
            }
        }
    };
    ($($trait:ident $name:ident),*) => {$(
        operator!($trait $name for 2: 0 1);
        operator!($trait $name for 4: 0 1 2 3);
    )*};
}
operator!(Add add, Sub sub, Mul mul, Div div, BitAnd bitand, BitOr bitor);

/// The lanes of register `k`.
#[inline(always)]
fn part<T, const L: usize, const N: usize>(all: &[T; N], k: usize) -> &[T; L] {
    all[k * L..].first_chunk().expect("that many lanes")
}

/// Where the lanes of register `k` go: after those lanes before it that are `chosen`, and so no further than where it lies.
#[inline(always)]
fn place<T, const L: usize, const N: usize>(
    out: &mut [MaybeUninit<T>; N],
    chosen: u32,
    k: usize,
) -> &mut [MaybeUninit<T>; L] {
    let before = (chosen & ((1 << (k * L)) - 1)).count_ones() as usize;
    out[before.min(k * L)..]
        .first_chunk_mut()
        .expect("that many lanes left")
}

/// `$n` lanes as `$r` registers of `$l`, which are numbered.
macro_rules! registers {
    ($n:literal = $r:literal of $l:literal: $($k:literal)*) => {
        impl<T, U, M> Floats<$n> for Registers<T, $r>
        where
            T: Floats<$l, Mask = M, Words = U> + Select<$r, Order = U>,
            U: Words<$l, Token = T::Token, Mask = M> + Select<$r, Order = U>,
            M: Answers<$r>,
        {
            type Token = T::Token;
            type Mask = Registers<M, $r>;
            type Words = Registers<U, $r>;

            #[inline(always)]
            fn splat(token: Self::Token, x: f32) -> Self {
                Self([T::splat(token, x); $r])
            }
            #[inline(always)]
            fn load(token: Self::Token, from: &[f32; $n]) -> Self {
                Self([$(T::load(token, part(from, $k))),*])
            }
            #[inline(always)]
            fn from_bytes(token: Self::Token, from: &[u8; $n]) -> Self {
                Self([$(T::from_bytes(token, part(from, $k))),*])
            }
            #[inline(always)]
            fn to_array(self) -> [f32; $n] {
                let mut out = [0.0; $n];
                $(out[$k * $l..][..$l].copy_from_slice(&self.0[$k].to_array());)*
                out
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self([$(self.0[$k].min(other.0[$k])),*])
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self([$(self.0[$k].max(other.0[$k])),*])
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self([$(self.0[$k].abs()),*])
            }
            #[inline(always)]
            fn signed_as(self, other: Self) -> Self {
                Self([$(self.0[$k].signed_as(other.0[$k])),*])
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                Registers([$(self.0[$k].le(other.0[$k])),*])
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                Registers([$(self.0[$k].lt(other.0[$k])),*])
            }
            #[inline(always)]
            fn choose(self, chosen: Self::Mask, other: Self) -> Self {
                Self([$(self.0[$k].choose(chosen.0[$k], other.0[$k])),*])
            }
            #[inline(always)]
            fn times_more(self, factor: Self, more: Self) -> Self {
                Self([$(self.0[$k].times_more(factor.0[$k], more.0[$k])),*])
            }
            #[inline(always)]
            fn product_error(self, factor: Self, product: Self) -> Self {
                Self([$(self.0[$k].product_error(factor.0[$k], product.0[$k])),*])
            }
            #[inline(always)]
            fn permute(self, order: Self::Words) -> Self {
                Self([$(T::select(self.0, order.0[$k])),*])
            }
            #[inline(always)]
            fn compress(self, chosen: Self::Mask, out: &mut [MaybeUninit<f32>; $n]) {
                let bits = chosen.bits();
                // First to where each register lies, so that all is written; then each after the chosen lanes before it.
                $(self.0[$k].compress(chosen.0[$k], place(out, u32::MAX, $k));)*
                $(self.0[$k].compress(chosen.0[$k], place(out, bits, $k));)*
            }
        }

        impl<U, M> Words<$n> for Registers<U, $r>
        where
            U: Words<$l, Mask = M> + Select<$r, Order = U>,
            M: Answers<$r>,
        {
            type Token = U::Token;
            type Mask = Registers<M, $r>;

            #[inline(always)]
            fn load(token: Self::Token, from: &[u32; $n]) -> Self {
                Self([$(U::load(token, part(from, $k))),*])
            }
            #[inline(always)]
            fn from_nibbles(token: Self::Token, packed: u64) -> Self {
                Self([$(U::from_nibbles(token, packed >> (4 * $k * $l))),*])
            }
            #[inline(always)]
            fn permute(self, order: Self) -> Self {
                Self([$(U::select(self.0, order.0[$k])),*])
            }
            #[inline(always)]
            fn compress(self, chosen: Self::Mask, out: &mut [MaybeUninit<u32>; $n]) {
                let bits = chosen.bits();
                $(self.0[$k].compress(chosen.0[$k], place(out, u32::MAX, $k));)*
                $(self.0[$k].compress(chosen.0[$k], place(out, bits, $k));)*
            }
        }
    };
}
registers!(16 = 2 of 8: 0 1);
registers!(8 = 2 of 4: 0 1);
registers!(16 = 4 of 4: 0 1 2 3);

/// For each set of chosen lanes, their numbers, closed up: for levels with registers of four.
#[cfg(not(target_arch = "x86_64"))]
pub static CLOSE_UP: [[u32; 4]; 16] = {
    let mut table = [[0; 4]; 16];
    let mut chosen = 0;
    while chosen < 16 {
        let (mut lane, mut end) = (0, 0);
        while lane < 4 {
            if chosen >> lane & 1 == 1 {
                table[chosen][end] = lane;
                end += 1;
            }
            lane += 1;
        }
        chosen += 1;
    }
    table
};
