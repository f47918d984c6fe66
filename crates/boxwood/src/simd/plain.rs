//! Types that are words of 32 bits and nothing else, seen as what they are: so trees go into files and come back as they lie.

use super::{ByteRows, Rows};

/// What is made of 32-bit words and nothing else.
///
/// # Safety
/// Whatever the words, they are a value, and `BYTES` are used. Where that is less than the size, there are gaps, and the functions
/// below do not compile.
pub unsafe trait Plain: Copy + Send + Sync + 'static {
    /// The bytes of all words.
    const BYTES: usize;
    /// Proof that there are no gaps, and that items lie as words do.
    const SOLID: () = assert!(
        size_of::<Self>() == Self::BYTES && align_of::<Self>() >= align_of::<u32>(),
        "words and nothing else"
    );
}

// SAFETY: one word.
unsafe impl Plain for u32 {
    const BYTES: usize = WORD;
}
// SAFETY: one word; a NaN is a value too.
unsafe impl Plain for f32 {
    const BYTES: usize = WORD;
}
// SAFETY: items of an array lie side by side.
unsafe impl<T: Plain, const N: usize> Plain for [T; N] {
    const BYTES: usize = N * T::BYTES;
}
// SAFETY: transparent, an array.
unsafe impl<const N: usize, const R: usize> Plain for Rows<N, R> {
    const BYTES: usize = <[[f32; N]; R]>::BYTES;
}

// SAFETY: bytes side by side, aligned as words are; rows that do not fill whole words leave a gap, which `SOLID` refuses.
unsafe impl<const N: usize, const R: usize> Plain for ByteRows<N, R> {
    const BYTES: usize = N * R;
}

/// Makes a structure [`Plain`] whose fields are: `plain!(Pair<N> { first: u32, second: [f32; N] });`
///
/// Does not compile when a field is left out or of another type, or when one is not plain.
macro_rules! plain {
    ($name:ident $(<$n:ident $(, $b:ident: $bound:path)?>)? { $($field:ident: $of:ty),* $(,)? }) => {
        const _: () = {
            #[allow(dead_code, reason = "that it compiles is all it is for")]
            fn all_fields$(<const $n: usize $(, $b: $bound)?>)?(
                $name { $($field),* }: $name $(<$n $(, $b)?>)?
            ) {
                $(let _: $of = $field;)*
            }
        };
        #[allow(unsafe_code, reason = "the promise is made for fields that were just looked at")]
        // SAFETY: all fields are plain, and their bytes are counted.
        unsafe impl$(<const $n: usize $(, $b: $bound)?>)? $crate::simd::Plain for $name $(<$n $(, $b)?>)? {
            const BYTES: usize = 0 $(+ <$of as $crate::simd::Plain>::BYTES)*;
        }
    };
}
pub(crate) use plain;

const WORD: usize = size_of::<u32>();

/// Items as words.
pub fn words<T: Plain>(items: &[T]) -> &[u32] {
    let () = T::SOLID;
    // SAFETY: made of words, they lie as words do, and none is unused.
    unsafe { core::slice::from_raw_parts(items.as_ptr().cast(), size_of_val(items) / WORD) }
}

/// The same, to be written.
pub fn words_mut<T: Plain>(items: &mut [T]) -> &mut [u32] {
    let () = T::SOLID;
    let count = size_of_val(items) / WORD;
    // SAFETY: as above, and any words are values.
    unsafe { core::slice::from_raw_parts_mut(items.as_mut_ptr().cast(), count) }
}

/// Words as the bytes that they are in this machine.
pub fn bytes(words: &[u32]) -> &[u8] {
    // SAFETY: bytes may lie anywhere, and a word has no unused ones.
    unsafe { core::slice::from_raw_parts(words.as_ptr().cast(), size_of_val(words)) }
}

/// The same, to be written.
pub fn bytes_mut(words: &mut [u32]) -> &mut [u8] {
    // SAFETY: as above, and any bytes are words.
    unsafe { core::slice::from_raw_parts_mut(words.as_mut_ptr().cast(), size_of_val(words)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Debug, PartialEq)]
    #[repr(C, align(16))]
    struct Pair<const N: usize> {
        first: [f32; N],
        second: [u32; 2],
    }
    plain!(Pair<N> { first: [f32; N], second: [u32; 2] });

    #[test]
    fn items_are_their_words_and_bytes() {
        let mut pairs = [Pair {
            first: [1.0, -0.0],
            second: [7, 0x0102_0304],
        }; 2];
        let expected = [0x3f80_0000, 0x8000_0000, 7, 0x0102_0304];
        assert_eq!(words(&pairs), [expected, expected].as_flattened());
        assert_eq!(bytes(words(&pairs))[12..16], 0x0102_0304_u32.to_ne_bytes());
        words_mut(&mut pairs)[6] = 9;
        bytes_mut(words_mut(&mut pairs))[28..].fill(0);
        assert_eq!(pairs[1].second, [9, 0]);
        assert!(words::<Pair<2>>(&[]).is_empty());
    }
}
