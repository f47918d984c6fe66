//! A hash of words, the same on every machine and for any number of threads: what tells a damaged file from a whole one, and
//! one mesh from another.
//!
//! *How it works.* Pieces of fixed size are hashed each by itself, as little-endian bytes, and then the row of their hashes.
//!
//! *Source.* XXH3 of 128 bits (Collet 2019). It finds accidents, not forgeries: whoever trusts no hash looks at what was hashed.

use crate::pieces;
use alloc::borrow::Cow;
use alloc::vec::Vec;
use twox_hash::XxHash3_128;

/// Words in a piece: a megabyte.
const PIECE: usize = 1 << 18;

/// The hash of some lists of words; that of the same words in other lists is another.
pub fn of_words(lists: &[&[u32]]) -> u128 {
    together(lists.iter().flat_map(|list| {
        pieces::each(list.len().div_ceil(PIECE), |piece| {
            let from = piece * PIECE;
            of_piece(&list[from..list.len().min(from + PIECE)])
        })
    }))
}

/// The hash of one piece.
pub fn of_piece(words: &[u32]) -> u128 {
    XxHash3_128::oneshot(&little_endian(words))
}

/// One hash of many.
pub fn together(hashes: impl IntoIterator<Item = u128>) -> u128 {
    let bytes: Vec<u8> = hashes.into_iter().flat_map(u128::to_le_bytes).collect();
    XxHash3_128::oneshot(&bytes)
}

/// Words as bytes in the order that files have; they are not moved where the machine has the same.
pub fn little_endian(words: &[u32]) -> Cow<'_, [u8]> {
    if cfg!(target_endian = "little") {
        Cow::Borrowed(crate::simd::bytes(words))
    } else {
        Cow::Owned(words.iter().flat_map(|word| word.to_le_bytes()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_and_every_border_counts() {
        let mut words: Vec<u32> = (0..2 * PIECE as u32 + 5).collect();
        let whole = of_words(&[&words]);
        assert_eq!(whole, of_words(&[&words]));
        assert_ne!(whole, of_words(&[&words[..7], &words[7..]]));
        assert_ne!(whole, of_words(&[&words[..2 * PIECE + 4]]));
        for at in [0, PIECE - 1, PIECE, 2 * PIECE + 4] {
            words[at] ^= 1 << 31;
            assert_ne!(whole, of_words(&[&words]), "{at}");
            words[at] ^= 1 << 31;
        }
        // The same on every machine.
        assert_eq!(
            of_words(&[&[1, 2, 3], &[]]),
            233_875_861_218_791_302_249_724_198_197_302_996_651
        );
    }
}
