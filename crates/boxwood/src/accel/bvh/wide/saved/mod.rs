//! Wide trees in files: saved as they lie in memory, read into their places, looked at before use.
//!
//! *How it works.* A file (`.bxw`) is a header of 128 bytes, the nodes, and the blocks of the leaves, all of them words of 32 bits in
//! little-endian order; `docs/bxw.md` has the details. Nodes and blocks are what the traversal reads, so there is nothing to parse: the file
//! is read into the memory of the tree, once. Then its checksum is computed, and [`WideBvh::validate`] looks at everything against
//! the primitives, which the caller brings: a file that is cut off, damaged, forged or of another mesh is an error.
//!
//! *Why it is read and not mapped.* What a mapping shows may change while it is looked at, whenever anybody writes to the file, and vanishes
//! when somebody cuts it off. No check could be relied on, and safe callers would meet undefined behaviour. Since every
//! byte must be looked at anyway, there is little to win; and the tree would lie on small pages.
//!
//! *Cost.* Reading is the system's copy; checking, a few nanoseconds a triangle and thread. No memory beside the tree's own but a
//! bit for each node, block and primitive.

mod header;

use super::leaf::Leaves;
use super::node::{Child, Node};
use super::{Precision, WideBvh};
use crate::digest;
use crate::geometry::Aabb;
use crate::inspect::TreeFlaw;
use crate::primitive::{Primitives, fingerprint};
use crate::simd::{Isa, Level, Pages, Vectorize, bytes_mut, words, words_mut};
use alloc::vec::Vec;
use core::convert::Infallible;
use header::{CHECKED, Header, VERSION, WORDS};

/// Bytes of the header.
const HEADER: u64 = 4 * WORDS as u64;
/// Words that are written at a time.
const PIECE: usize = 1 << 18;

/// Why a file is not the saved tree of some primitives.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SavedError {
    /// It does not begin as a saved tree does.
    #[error("this is no saved tree")]
    NotSaved,
    /// The format has another version.
    #[error(
        "the tree is saved in version {found} of the format; this Boxwood reads version {VERSION}"
    )]
    Version {
        /// Its version.
        found: u32,
    },
    /// Its nodes have another number of children.
    #[error("the saved tree has {found} children a node, expected {expected}")]
    Width {
        /// How many they have.
        found: u32,
        /// How many were asked for.
        expected: u32,
    },
    /// It is shorter or longer than its header says.
    #[error("the saved tree should have {expected} bytes, but there are {found}")]
    Length {
        /// What the header says.
        expected: u64,
        /// What there is.
        found: u64,
    },
    /// There is not enough memory for it.
    #[error("there is not enough memory for a tree of {bytes} bytes")]
    NoMemory {
        /// Its size.
        bytes: u64,
    },
    /// It has changed since it was saved.
    #[error("the saved tree is damaged: its checksum is wrong")]
    Damaged,
    /// It is the tree of other primitives.
    #[error("the tree was saved for other primitives")]
    OtherPrimitives,
    /// It is not whole, although its checksum is right.
    #[error("the saved tree is not whole: {0}")]
    Flaw(#[from] TreeFlaw),
}

/// Why a tree was not [opened](WideBvh::open).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenError<E> {
    /// Reading failed.
    #[error("{0}")]
    Read(E),
    /// What was read is no good.
    #[error("{0}")]
    Saved(#[from] SavedError),
}

impl<P, const N: usize> WideBvh<P, N> {
    /// The version of the format that [`save`](Self::save) writes, and the only one that [`open`](Self::open) reads.
    pub const SAVED_VERSION: u32 = VERSION;
}

impl<P: Primitives + Sync, const N: usize> WideBvh<P, N> {
    /// Writes the tree, without its primitives, piece after piece.
    ///
    /// The same tree gives the same bytes on every machine. One [from elsewhere](WideBvh::checked) whose bounds are larger than its
    /// primitives can be saved, but not opened. To whom a half-written file would do harm, it should be written beside
    /// its place and then renamed.
    ///
    /// ```no_run
    /// # use boxwood::{TriangleMesh, WideBvh, WideSah};
    /// # use std::{fs::File, io::{BufReader, Read, Write}};
    /// # let mesh = TriangleMesh::default();
    /// let tree = WideSah::<8>::default().build(&mesh);
    /// let mut file = File::create("scene.bxw")?;
    /// tree.save(|bytes| file.write_all(bytes))?;
    ///
    /// let mut file = File::open("scene.bxw")?;
    /// let length = file.metadata()?.len();
    /// let tree = WideBvh::<_, 8>::open(&mesh, length, |bytes| file.read_exact(bytes))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of `write`.
    pub fn save<E>(&self, mut write: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let mut header = self.header().words();
        let (nodes, leaves) = (words(&self.nodes), self.leaves.words());
        let digest = digest::of_words(&[&header[..CHECKED], nodes, leaves]);
        header::put(&mut header[CHECKED..], digest);
        let pieces = nodes.chunks(PIECE).chain(leaves.chunks(PIECE));
        core::iter::once(&header[..])
            .chain(pieces)
            .try_for_each(|piece| write(&digest::little_endian(piece)))
    }

    /// What [`save`](Self::save) writes, as one list.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut all = Vec::new();
        let Ok(()) = self.save(|bytes| {
            all.extend_from_slice(bytes);
            Ok::<_, Infallible>(())
        });
        all
    }

    fn header(&self) -> Header {
        let [lower, upper] = [self.bounds.lower, self.bounds.upper].map(|p| p.to_array());
        Header {
            width: N as u32,
            triangles: P::TRIANGLES.into(),
            cut: self.cut.into(),
            primitives: self.primitives.len() as u64,
            nodes: self.nodes.len() as u64,
            blocks: self.leaves.len() as u64,
            root: self.root.0,
            depth: self.depth as u32,
            bounds: core::array::from_fn(|i| if i < 3 { lower[i] } else { upper[i - 3] }),
            fingerprint: fingerprint(&self.primitives),
        }
    }
}

impl<P: Primitives + Sync, const N: usize> WideBvh<P, N>
where
    Level: Vectorize<N>,
{
    /// Opens the saved tree of these primitives. `read` fills what it is given with the bytes that come next; there are `length`
    /// of them in all.
    ///
    /// Whatever the bytes are, the answers are those of the exhaustive test or this fails: see [`WideBvh::validate`]. The instruction set is the
    /// machine's best and the precision exact, whatever they were when the tree was saved.
    ///
    /// # Errors
    /// Those of `read`; and when the bytes are not the whole tree of these primitives, as [`WideBvh::save`] writes it.
    pub fn open<E>(
        primitives: P,
        length: u64,
        mut read: impl FnMut(&mut [u8]) -> Result<(), E>,
    ) -> Result<Self, OpenError<E>> {
        let mut fill = |words: &mut [u32]| {
            read(bytes_mut(words)).map_err(OpenError::Read)?;
            if cfg!(target_endian = "big") {
                words.iter_mut().for_each(|word| *word = word.swap_bytes());
            }
            Ok::<(), OpenError<E>>(())
        };
        if length < HEADER {
            return Err(SavedError::NotSaved.into());
        }
        let mut first = [0; WORDS];
        fill(&mut first)?;
        let header = Header::read(&first)?;
        let mut tree = Self::unread(primitives, &header, length)?;
        fill(words_mut(&mut tree.nodes))?;
        fill(tree.leaves.words_mut())?;

        let (nodes, leaves) = (words(&tree.nodes), tree.leaves.words());
        let digest = digest::of_words(&[&first[..CHECKED], nodes, leaves]);
        if digest != header::get(&first[CHECKED..]) {
            return Err(SavedError::Damaged.into());
        }
        if header.fingerprint != fingerprint(&tree.primitives) {
            return Err(SavedError::OtherPrimitives.into());
        }
        tree.validate().map_err(SavedError::Flaw)?;
        Ok(tree)
    }

    /// [`open`](Self::open) of bytes in memory.
    ///
    /// ```
    /// use boxwood::{TriangleMesh, WideBvh, WideSah};
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
    /// let bytes = WideSah::<8>::default().build(&mesh).to_bytes();
    /// assert!(WideBvh::<_, 8>::from_bytes(&mesh, &bytes).is_ok());
    /// assert!(WideBvh::<_, 8>::from_bytes(&mesh, &bytes[1..]).is_err());
    /// # Ok::<(), boxwood::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_bytes(primitives: P, mut bytes: &[u8]) -> Result<Self, SavedError> {
        let length = bytes.len() as u64;
        let read = |out: &mut [u8]| {
            // `open` asks for no more than there is.
            let next = bytes.split_off(..out.len()).ok_or(SavedError::Damaged)?;
            out.copy_from_slice(next);
            Ok(())
        };
        Self::open(primitives, length, read).map_err(|error| match error {
            OpenError::Read(error) | OpenError::Saved(error) => error,
        })
    }

    /// A tree with everything that a header says, and room for the rest of a file.
    fn unread(primitives: P, header: &Header, length: u64) -> Result<Self, SavedError> {
        if header.width != N as u32 {
            return Err(SavedError::Width {
                found: header.width,
                expected: N as u32,
            });
        }
        if header.triangles != u32::from(P::TRIANGLES)
            || header.primitives != primitives.len() as u64
        {
            return Err(SavedError::OtherPrimitives);
        }
        // Before any memory is asked for.
        let bytes = |count: u64, each: usize| count.checked_mul(each as u64);
        let expected = bytes(header.nodes, size_of::<Node<N>>())
            .zip(bytes(header.blocks, Leaves::block_bytes(P::TRIANGLES)))
            .and_then(|(nodes, blocks)| nodes.checked_add(blocks)?.checked_add(HEADER))
            .unwrap_or(u64::MAX);
        if expected != length {
            return Err(SavedError::Length {
                expected,
                found: length,
            });
        }
        let no_memory = SavedError::NoMemory { bytes: length };
        let room = |count: u64| usize::try_from(count).map_err(|_| no_memory.clone());
        let (nodes, blocks) = (room(header.nodes)?, room(header.blocks)?);
        let [a, b, c, d, e, f] = header.bounds;
        let bounds = Aabb::new([a, b, c], [d, e, f]);
        Ok(Self {
            bounds,
            frame: Self::frame_of(&bounds),
            primitives,
            root: Child(header.root),
            nodes: Pages::zeroed(nodes).ok_or_else(|| no_memory.clone())?,
            leaves: Leaves::zeroed(P::TRIANGLES, blocks).ok_or(no_memory.clone())?,
            cut: header.cut == 1,
            parts: Vec::new(),
            isa: Isa::best(),
            precision: Precision::Exact,
            depth: header.depth as usize,
        })
    }
}

/// Puts the right checksum into the bytes of a saved tree, so that tests and fuzzing get past it. Not for users: whoever wants another
/// tree saves one.
#[doc(hidden)]
pub fn seal(file: &mut [u8]) {
    let as_words = |bytes: &[u8]| -> Vec<u32> {
        let words = bytes.as_chunks().0.iter();
        words.map(|&word| u32::from_le_bytes(word)).collect()
    };
    let all = as_words(file);
    let (Some(header), width) = (all.first_chunk::<WORDS>(), all.get(3)) else {
        return;
    };
    let each = match width {
        Some(8) => size_of::<Node<8>>(),
        _ => size_of::<Node<16>>(),
    };
    let nodes = header::get(&header[8..10]).saturating_mul(each as u128 / 4);
    let rest = &all[WORDS..];
    let nodes = usize::try_from(nodes).unwrap_or(usize::MAX).min(rest.len());
    let (nodes, leaves) = rest.split_at(nodes);
    let digest = digest::of_words(&[&header[..CHECKED], nodes, leaves]);
    file[4 * CHECKED..4 * WORDS].copy_from_slice(&digest.to_le_bytes());
}
