//! How a wide tree lies in memory: [`Full`], the fast way, or [`Compact`], the small one.

use super::WideBvh;
use super::boxes::Boxes;
use super::quantised::Quantised;
use crate::primitive::Primitives;
use crate::simd::Rows;
use core::fmt::Debug;

mod sealed {
    /// The loops know the layouts of this room.
    pub trait Sealed {}
    impl Sealed for super::Full {}
    impl Sealed for super::Compact {}
}

/// How the nodes and leaves of a [`WideBvh`] lie in memory.
///
/// There are two of them, and no more can be made.
pub trait Layout: sealed::Sealed + Copy + Debug + Send + Sync + 'static {
    /// How the boxes lie in nodes.
    #[doc(hidden)]
    type Boxes<const N: usize>: Boxes<N>;
    /// Whether the leaves hold the corners of triangles, where primitives are such.
    #[doc(hidden)]
    const CORNERS: bool;
    /// Whether they do so for these primitives.
    #[doc(hidden)]
    fn has_corners<P: Primitives>() -> bool {
        P::TRIANGLES && Self::CORNERS
    }
}

/// Boxes of floats, and leaves that hold the corners of their triangles, lane by lane: about 60 bytes for each triangle of a mesh.
/// The default.
#[derive(Clone, Copy, Debug)]
pub struct Full;

impl Layout for Full {
    type Boxes<const N: usize> = Rows<N, 6>;
    const CORNERS: bool = true;
}

/// Boxes of bytes on a grid that each node has for itself, and leaves that hold nothing but the numbers of their primitives: about 11
/// bytes for each triangle of a mesh. Corners are fetched from the mesh when a ray comes to a leaf.
#[derive(Clone, Copy, Debug)]
pub struct Compact;

impl Layout for Compact {
    type Boxes<const N: usize> = Quantised<N>;
    const CORNERS: bool = false;
}

/// A [wide tree](WideBvh) of 8 children that lies in memory as small as can be: see [`Compact`].
pub type CompactBvh<P> = WideBvh<P, 8, Compact>;
