//! The first 128 bytes of a saved tree.

use super::SavedError;

/// What every saved tree begins with. As in PNG, a transfer as text changes it.
pub const MAGIC: [u8; 8] = *b"\x89BXW\r\n\x1a\n";
/// The version of the format that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// Words in it.
pub const WORDS: usize = 32;
/// The words before the checksum of everything.
pub const CHECKED: usize = 28;

/// Everything of a tree but its nodes and leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Children of a node.
    pub width: u32,
    /// 1 where blocks hold triangles, 0 where they hold numbers.
    pub triangles: u32,
    /// 1 where some primitives lie in several leaves.
    pub cut: u32,
    pub primitives: u64,
    pub nodes: u64,
    pub blocks: u64,
    /// A child, as nodes hold them.
    pub root: u32,
    pub depth: u32,
    /// Lower x, y, z, upper x, y, z.
    pub bounds: [f32; 6],
    /// The [`fingerprint`](crate::primitive::fingerprint) of the primitives.
    pub fingerprint: u128,
}

impl Header {
    /// As words of which only the checksum is missing.
    pub fn words(&self) -> [u32; WORDS] {
        let mut words = [0; WORDS];
        let [a, b] = [0, 4].map(|at| core::array::from_fn(|i| MAGIC[at + i]));
        let head = [
            u32::from_le_bytes(a),
            u32::from_le_bytes(b),
            VERSION,
            self.width,
            self.triangles,
            self.cut,
        ];
        words[..6].copy_from_slice(&head);
        put(&mut words[6..8], self.primitives.into());
        put(&mut words[8..10], self.nodes.into());
        put(&mut words[10..12], self.blocks.into());
        words[12] = self.root;
        words[13] = self.depth;
        words[14..20].copy_from_slice(&self.bounds.map(f32::to_bits));
        put(&mut words[20..24], self.fingerprint);
        words
    }

    /// From words, which may be any.
    pub fn read(words: &[u32; WORDS]) -> Result<Self, SavedError> {
        let magic = words[..2].iter().flat_map(|word| word.to_le_bytes());
        if !magic.eq(MAGIC) {
            return Err(SavedError::NotSaved);
        }
        if words[2] != VERSION {
            return Err(SavedError::Version { found: words[2] });
        }
        let header = Self {
            width: words[3],
            triangles: words[4],
            cut: words[5],
            primitives: get(&words[6..8]) as u64,
            nodes: get(&words[8..10]) as u64,
            blocks: get(&words[10..12]) as u64,
            root: words[12],
            depth: words[13],
            bounds: core::array::from_fn(|i| f32::from_bits(words[14 + i])),
            fingerprint: get(&words[20..24]),
        };
        // What this version does not write means nothing to it.
        if header.words()[..CHECKED] != words[..CHECKED] || header.triangles.max(header.cut) > 1 {
            return Err(SavedError::Damaged);
        }
        Ok(header)
    }
}

/// Writes a number into words, the lowest first.
pub fn put(words: &mut [u32], number: u128) {
    for (i, word) in words.iter_mut().enumerate() {
        *word = (number >> (32 * i)) as u32;
    }
}

/// Reads it.
pub fn get(words: &[u32]) -> u128 {
    let number = |sum, (i, &word): (usize, &u32)| sum | u128::from(word) << (32 * i);
    words.iter().enumerate().fold(0, number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_go_both_ways() {
        let header = Header {
            width: 8,
            triangles: 1,
            cut: 0,
            primitives: 0x1_0000_0002,
            nodes: 3,
            blocks: u64::MAX,
            root: 0x8000_0001,
            depth: 5,
            bounds: [-1.0, -0.0, f32::INFINITY, 1.0, 2.0e-45, 3.0],
            fingerprint: 0x0123_4567_89ab_cdef_1122_3344_5566_7788,
        };
        let words = header.words();
        assert_eq!(Header::read(&words), Ok(header));
        for at in 0..CHECKED {
            let mut words = words;
            words[at] ^= 0x40;
            assert_ne!(Header::read(&words), Ok(header), "{at}");
        }
    }
}
