//! Work in numbered pieces: by the threads of the caller's pool where there are threads, one after the other where not.

use alloc::vec::Vec;

/// What becomes of each piece, in order. Each is computed [exactly](crate::simd::exactly).
pub fn each<T: Send>(count: usize, piece: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "parallel")]
    {
        use crate::threads::Exactly;
        use rayon::prelude::*;
        (0..count).into_par_iter().exactly().map(piece).collect()
    }
    #[cfg(not(feature = "parallel"))]
    crate::simd::exactly(|| (0..count).map(piece).collect())
}

/// What becomes of each of some things, in order.
pub fn each_of<A: Send, T: Send>(things: Vec<A>, piece: impl Fn(A) -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "parallel")]
    {
        use crate::threads::Exactly;
        use rayon::prelude::*;
        things.into_par_iter().exactly().map(piece).collect()
    }
    #[cfg(not(feature = "parallel"))]
    crate::simd::exactly(|| things.into_iter().map(piece).collect())
}
