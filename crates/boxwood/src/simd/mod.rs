//! Lanes of floats, and the one door into fast code. Nothing here knows what a ray is.
//!
//! *How it works.* A level (`Portable`, `Avx2`, `Avx512`, `Neon`, `Simd128`) is a token that only its `detect` makes, so that
//! holding one proves that the machine has the instructions. Lane values are made from a token and therefore carry
//! the same proof: every operation on them is safe. A [`Kernel`] is one text, generic over the level;
//! [`Level::vectorize`] runs it inside a function compiled for that level, into which everything is inlined.
//!
//! *Rule.* All of a kernel is `#[inline(always)]`: what stays outside the door is compiled for the plain machine and
//! hands its lanes over in memory. Closures, `array::map` and `array::from_fn` cannot promise that: what runs at every step
//! has none, because three leftover calls to `array::map`, per ray and not even per node, cost 10 to 15 %. What runs once a
//! ray or a leaf may have them, and the assembly is looked at.
#![allow(unsafe_code, reason = "the one room where unsafe is allowed")]

use core::mem::MaybeUninit;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

#[cfg(all(target_arch = "x86_64", feature = "std"))]
mod avx2;
#[cfg(all(target_arch = "x86_64", feature = "std"))]
mod avx512;
mod environment;
mod isa;
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod neon;
mod pages;
mod plain;
mod portable;
#[cfg(any(
    all(target_arch = "x86_64", feature = "std"),
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
mod registers;
mod rows;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;
mod stack;
#[cfg(test)]
mod tests;

pub use environment::{carelessly, exactly};
pub use isa::{Isa, UnknownIsa};
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
pub use neon::Neon;
pub use pages::Pages;
pub(crate) use plain::plain;
pub use plain::{Plain, bytes, bytes_mut, words, words_mut};
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub use simd128::Simd128;
#[cfg(all(target_arch = "x86_64", feature = "std"))]
pub use {avx2::Avx2, avx512::Avx512};
pub use {
    portable::Portable,
    rows::{ByteRows, Row, Rows},
    stack::Stack,
};

/// The levels beside the portable one, from slow to fast: where each is there, its token, its name, what it has.
macro_rules! levels {
    ($use:ident $($n:literal)?) => {
        $use! { $($n;)?
            #[cfg(all(target_arch = "x86_64", feature = "std"))]
            Avx2 "avx2" "AVX2, FMA and BMI.",
            #[cfg(all(target_arch = "x86_64", feature = "std"))]
            Avx512 "avx512" "AVX-512 F, VL, BW, DQ.",
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Neon "neon" "NEON of 64-bit ARM.",
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Simd128 "simd128" "The 128-bit registers of WebAssembly.",
        }
    };
}

mod sealed {
    /// [`Stack`](super::Stack) trusts `compress` and `bits`: only this room may implement them.
    pub trait Sealed {}
    impl Sealed for super::Portable {}
    macro_rules! seal {
        ($(#[$there:meta] $level:ident $name:literal $has:literal,)*) => {$(
            #[$there]
            impl Sealed for super::$level {}
        )*};
    }
    levels!(seal);
}

/// A level seen through registers of `N` lanes.
pub trait Lanes<const N: usize>: Copy + sealed::Sealed {
    /// `N` floats.
    type F: Floats<N, Token = Self, Mask = Self::M, Words = Self::U>;
    /// `N` unsigned words.
    type U: Words<N, Token = Self, Mask = Self::M>;
    /// `N` yes-or-no answers.
    type M: Mask;
}

/// `N` floats of level `S`.
pub type F<S, const N: usize> = <S as Lanes<N>>::F;
/// `N` words of level `S`.
pub type U<S, const N: usize> = <S as Lanes<N>>::U;

/// A level: every width the library uses.
pub trait Simd: Lanes<4> + Lanes<8> + Lanes<16> + Send + Sync + 'static {}
impl<S: Lanes<4> + Lanes<8> + Lanes<16> + Send + Sync + 'static> Simd for S {}

/// A piece of work written once for every level, on lanes of width `N`.
///
/// A struct with a method rather than a closure: a closure can be neither generic over the level nor
/// `#[inline(always)]`.
pub trait Kernel<const N: usize> {
    /// What the work returns.
    type Output;
    /// The work. Implementations are `#[inline(always)]`, and so is all they call.
    fn run<S: Simd + Lanes<N>>(self, s: S) -> Self::Output;
}

/// Floats in lanes. `min` and `max` return the *second* argument when either is NaN; comparisons read NaN as false.
pub trait Floats<const N: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The level.
    type Token: Copy;
    /// The answer of a comparison.
    type Mask: Mask;
    /// Words of the same width.
    type Words: Words<N>;
    /// The same value in each lane.
    fn splat(token: Self::Token, x: f32) -> Self;
    /// Lanes from memory.
    fn load(token: Self::Token, from: &[f32; N]) -> Self;
    /// Lanes from bytes, as the numbers that they are.
    fn from_bytes(token: Self::Token, from: &[u8; N]) -> Self;
    /// Lanes to memory.
    fn to_array(self) -> [f32; N];
    /// The smaller; `other` when unordered.
    fn min(self, other: Self) -> Self;
    /// The larger; `other` when unordered.
    fn max(self, other: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    /// With the sign of `other`, a zero's included.
    fn signed_as(self, other: Self) -> Self;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self` in the chosen lanes, `other` in the rest.
    fn choose(self, chosen: Self::Mask, other: Self) -> Self;
    /// `self * factor + more`, rounded once where the level can and twice where not: for boxes only, whose slack covers
    /// either. Never for what an answer is made of.
    fn times_more(self, factor: Self, more: Self) -> Self;
    /// `self * factor - product` exactly, where `product` is `self * factor` rounded: the same bits on every level.
    fn product_error(self, factor: Self, product: Self) -> Self;
    /// Lane `i` of the result is lane `order[i]`.
    fn permute(self, order: Self::Words) -> Self;
    /// Writes the chosen lanes, closed up, to the front of `out`. All of `out` is written.
    fn compress(self, chosen: Self::Mask, out: &mut [MaybeUninit<f32>; N]);
    /// The same into memory that holds something.
    #[inline(always)]
    fn close_up(self, chosen: Self::Mask, out: &mut [f32; N]) {
        // SAFETY: initialised memory may be seen as memory that need not be, as long as nothing uninitialised is written
        // to it, and `compress` writes all of it with values.
        let out = unsafe { &mut *core::ptr::from_mut(out).cast() };
        self.compress(chosen, out);
    }
}

/// Words in lanes: child references and lane numbers.
pub trait Words<const N: usize>: Copy {
    /// The level.
    type Token: Copy;
    /// The mask of this width.
    type Mask: Mask;
    /// Lanes from memory.
    fn load(token: Self::Token, from: &[u32; N]) -> Self;
    /// Lane numbers from nibbles: lane `i` gets bits `4 i .. 4 i + 4`. Only the low bits that name a lane count.
    fn from_nibbles(token: Self::Token, packed: u64) -> Self;
    /// Lane `i` of the result is lane `order[i]`.
    fn permute(self, order: Self) -> Self;
    /// Writes the chosen lanes, closed up, to the front of `out`. All of `out` is written.
    fn compress(self, chosen: Self::Mask, out: &mut [MaybeUninit<u32>; N]);
    /// The same into memory that holds something.
    #[inline(always)]
    fn close_up(self, chosen: Self::Mask, out: &mut [u32; N]) {
        // SAFETY: initialised memory may be seen as memory that need not be, as long as nothing uninitialised is written
        // to it, and `compress` writes all of it with values.
        let out = unsafe { &mut *core::ptr::from_mut(out).cast() };
        self.compress(chosen, out);
    }
}

/// One answer per lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// Lane `i` in bit `i`.
    fn bits(self) -> u32;
}

/// Reads a number that has just been written, by a load of its own. Left to itself, the compiler reads neighbours together;
/// but a processor hands a store on to a later load only if it holds all that is loaded, and waits else until the store has
/// left for the cache, with all that was to be done meanwhile.
#[inline(always)]
pub fn alone<T: Copy>(number: &T) -> T {
    // SAFETY: a reference can be read.
    unsafe { core::ptr::from_ref(number).read_volatile() }
}

/// Where an element lies, or would lie: for [`prefetch`].
#[inline(always)]
pub fn address<T>(slice: &[T], index: usize) -> *const u8 {
    slice.as_ptr().wrapping_add(index).cast()
}

/// Begins to load some cache lines; does nothing where that cannot be asked for. Any address will do.
#[inline(always)]
pub fn prefetch(_at: *const u8, _lines: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0.._lines {
        let at = _at.wrapping_add(64 * line).cast();
        // SAFETY: prefetching reads nothing and is allowed for any address.
        unsafe { core::arch::x86_64::_mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(at) };
    }
}

macro_rules! level {
    ($(#[$there:meta] $level:ident $name:literal $has:literal,)*) => {
        /// What a machine can do. Small, `Copy`, stored in each wide structure.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Level {
            /// Plain Rust: defines what every operation means.
            Portable(Portable),
            $(
                #[$there]
                #[doc = $has]
                $level($level),
            )*
        }

        impl Level {
            /// `portable`, `avx2`, `avx512`, `neon` or `simd128`.
            pub fn name(self) -> &'static str {
                match self {
                    Self::Portable(_) => "portable",
                    $(
                        #[$there]
                        Self::$level(_) => $name,
                    )*
                }
            }

            /// All levels of this machine, the portable one first.
            pub fn available() -> alloc::vec::Vec<Self> {
                #[allow(unused_mut, reason = "some machines have no other level")]
                let mut levels = alloc::vec![Self::Portable(Portable)];
                $(
                    #[$there]
                    levels.extend($level::detect().map(Self::$level));
                )*
                levels
            }
        }
    };
}
levels!(level);

/// "The library has lanes of width `N` at every level": the only bound a generic layout needs.
pub trait Vectorize<const N: usize>: Copy {
    /// Runs `kernel` compiled for this level. This is the door: open it once per query or batch.
    fn vectorize<K: Kernel<N>>(self, kernel: K) -> K::Output;
}

macro_rules! door {
    ($n:literal; $(#[$there:meta] $level:ident $name:literal $has:literal,)*) => {
        impl Vectorize<$n> for Level {
            #[inline]
            fn vectorize<K: Kernel<$n>>(self, kernel: K) -> K::Output {
                match self {
                    Self::Portable(s) => s.vectorize(kernel),
                    $(
                        #[$there]
                        Self::$level(s) => s.vectorize(kernel),
                    )*
                }
            }
        }
    };
}
levels!(door 4);
levels!(door 8);
levels!(door 16);
