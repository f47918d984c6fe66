//! Sixteen lanes out of two registers of eight, for levels whose registers are that short.

use super::{Floats, Mask, Words};
use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// The lower and the upper eight lanes.
#[derive(Clone, Copy, Debug)]
pub struct Pair<T>(pub T, pub T);

/// What a pair needs beyond the operations of its halves: a table look-up across both.
pub trait Select16: Copy {
    /// Lane `i` is lane `order[i] % 8` of `low` or, where `order[i]` has bit 3 set, of `high`.
    fn select16(low: Self, high: Self, order: Self::Order) -> Self;
    /// Eight lane numbers in 0 to 15.
    type Order: Copy;
}

macro_rules! operator {
    ($($trait:ident $name:ident),*) => {$(
        impl<T: $trait<Output = T>> $trait for Pair<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0), self.1.$name(other.1))
            }
        }
    )*};
}
operator!(Add add, Sub sub, Mul mul, Div div, BitAnd bitand, BitOr bitor);

/// The two halves of sixteen words.
#[inline(always)]
pub fn halves<T>(all: &[T; 16]) -> (&[T; 8], &[T; 8]) {
    let (low, high) = all.split_first_chunk::<8>().expect("sixteen");
    (low, high.first_chunk::<8>().expect("eight more"))
}

impl<T, U, M> Floats<16> for Pair<T>
where
    T: Floats<8, Mask = M, Words = U> + Select16<Order = U>,
    U: Words<8, Token = T::Token, Mask = M> + Select16<Order = U>,
    M: Mask,
{
    type Token = T::Token;
    type Mask = Pair<M>;
    type Words = Pair<U>;

    #[inline(always)]
    fn splat(token: Self::Token, x: f32) -> Self {
        Self(T::splat(token, x), T::splat(token, x))
    }
    #[inline(always)]
    fn load(token: Self::Token, from: &[f32; 16]) -> Self {
        let (low, high) = halves(from);
        Self(T::load(token, low), T::load(token, high))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; 16] {
        let (low, high) = (self.0.to_array(), self.1.to_array());
        core::array::from_fn(|i| if i < 8 { low[i] } else { high[i - 8] })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Pair<M> {
        Pair(self.0.le(other.0), self.1.le(other.1))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Pair<M> {
        Pair(self.0.lt(other.0), self.1.lt(other.1))
    }
    #[inline(always)]
    fn times_less(self, factor: Self, less: Self) -> Self {
        Self(
            self.0.times_less(factor.0, less.0),
            self.1.times_less(factor.1, less.1),
        )
    }
    #[inline(always)]
    fn product_error(self, factor: Self, product: Self) -> Self {
        Self(
            self.0.product_error(factor.0, product.0),
            self.1.product_error(factor.1, product.1),
        )
    }
    #[inline(always)]
    fn permute(self, order: Pair<U>) -> Self {
        Self(
            T::select16(self.0, self.1, order.0),
            T::select16(self.0, self.1, order.1),
        )
    }
    #[inline(always)]
    fn compress(self, chosen: Pair<M>, out: &mut [MaybeUninit<f32>; 16]) {
        let count = chosen.0.bits().count_ones() as usize & 15;
        self.1
            .compress(chosen.1, out.last_chunk_mut().expect("sixteen"));
        self.0
            .compress(chosen.0, out.first_chunk_mut().expect("sixteen"));
        self.1.compress(
            chosen.1,
            out[count.min(8)..].first_chunk_mut().expect("eight left"),
        );
    }
}

impl<U, M> Words<16> for Pair<U>
where
    U: Words<8, Mask = M> + Select16<Order = U>,
    M: Mask,
{
    type Token = U::Token;
    type Mask = Pair<M>;

    #[inline(always)]
    fn load(token: Self::Token, from: &[u32; 16]) -> Self {
        let (low, high) = halves(from);
        Self(U::load(token, low), U::load(token, high))
    }
    #[inline(always)]
    fn from_nibbles(token: Self::Token, packed: u64) -> Self {
        Self(
            U::from_nibbles(token, packed),
            U::from_nibbles(token, packed >> 32),
        )
    }
    #[inline(always)]
    fn permute(self, order: Self) -> Self {
        Self(
            U::select16(self.0, self.1, order.0),
            U::select16(self.0, self.1, order.1),
        )
    }
    #[inline(always)]
    fn compress(self, chosen: Pair<M>, out: &mut [MaybeUninit<u32>; 16]) {
        let count = chosen.0.bits().count_ones() as usize & 15;
        self.1
            .compress(chosen.1, out.last_chunk_mut().expect("sixteen"));
        self.0
            .compress(chosen.0, out.first_chunk_mut().expect("sixteen"));
        self.1.compress(
            chosen.1,
            out[count.min(8)..].first_chunk_mut().expect("eight left"),
        );
    }
}

impl<M: Mask> Mask for Pair<M> {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits() | self.1.bits() << 8
    }
}
