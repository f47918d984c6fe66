//! The nodes of a kd-tree: eight bytes each.

use crate::accel::cells::Space;
use alloc::vec::Vec;

/// No leaf lies deeper, so a stack of this size always suffices. The root has depth 0.
pub const MAX_DEPTH: usize = 64;

/// So many that nodes and the primitives of a leaf have numbers of 30 bits, and references of 32.
pub(super) const MAX_WEIGHT: usize = (1 << 29) - 1;

/// A node: an inner one is cut by a plane across an axis, a leaf names a run of references.
///
/// ```text
///          word                                   link
/// inner    f32: where the plane is                bits 31…2: the lower child    bits 1…0: the axis, 0 to 2
/// leaf     u32: its first reference               bits 31…2: how many           bits 1…0: 3
/// ```
///
/// The children lie side by side, the lower one first; so near and far differ by one and share a cache line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(super) struct Node {
    word: u32,
    link: u32,
}

/// What stands in place of an axis in a leaf.
const LEAF: u32 = 3;

impl Node {
    /// A cell that is cut at `plane`; its lower child has the number `child`.
    pub fn inner(axis: usize, plane: f32, child: usize) -> Self {
        debug_assert!(axis < 3 && child < 1 << 30);
        Self {
            word: plane.to_bits(),
            link: (child as u32) << 2 | axis as u32,
        }
    }
    /// A cell with `count` references from `first` on.
    pub fn leaf(first: usize, count: usize) -> Self {
        debug_assert!(first <= u32::MAX as usize && count < 1 << 30);
        Self {
            word: first as u32,
            link: (count as u32) << 2 | LEAF,
        }
    }
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.link & 3 == LEAF
    }
    /// The axis across which an inner node is cut.
    #[inline(always)]
    pub fn axis(self) -> usize {
        (self.link & 3) as usize
    }
    /// Where an inner node is cut.
    #[inline(always)]
    pub fn plane(self) -> f32 {
        f32::from_bits(self.word)
    }
    /// The lower child of an inner node; the upper one is the next.
    #[inline(always)]
    pub fn child(self) -> usize {
        (self.link >> 2) as usize
    }
    /// How many references a leaf has.
    #[inline(always)]
    pub fn count(self) -> usize {
        (self.link >> 2) as usize
    }
    /// The places of a leaf's references.
    #[inline(always)]
    pub fn places(self) -> core::ops::Range<usize> {
        let first = self.word as usize;
        first..first + self.count()
    }
    /// The same node of a tree that lies behind `nodes` other nodes and `references` other references.
    #[cfg(any(test, feature = "parallel"))]
    pub fn moved(self, nodes: usize, references: usize) -> Self {
        if self.is_leaf() {
            Self::leaf(self.word as usize + references, self.count())
        } else {
            Self::inner(self.axis(), self.plane(), self.child() + nodes)
        }
    }
}

/// What a builder makes: space divided into cells, and for each cell the primitives that reach into it.
#[derive(Clone, Debug, PartialEq)]
pub struct Partition {
    /// What is divided, and what cannot be.
    pub(super) space: Space,
    /// The root first and each pair of children side by side, the lower one's descendants before the upper one's. Empty when
    /// there is nothing to divide.
    pub(super) nodes: Vec<Node>,
    /// The primitives of all leaves, one leaf after the other.
    pub(super) references: Vec<u32>,
    /// How many primitives it was made for.
    pub(super) primitives: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bytes_hold_it_all() {
        assert_eq!(size_of::<Node>(), 8);
        for axis in 0..3 {
            for plane in [0.0, -0.0, -1.5, f32::MAX, f32::from_bits(1)] {
                for child in [1, 2, (1 << 30) - 1] {
                    let node = Node::inner(axis, plane, child);
                    assert!(!node.is_leaf());
                    assert_eq!((node.axis(), node.child()), (axis, child));
                    assert_eq!(node.plane().to_bits(), plane.to_bits());
                }
            }
        }
        for first in [0, 7, u32::MAX as usize] {
            for count in [0, 1, (1 << 30) - 1] {
                let node = Node::leaf(first, count);
                assert!(node.is_leaf());
                assert_eq!((node.places().start, node.count()), (first, count));
            }
        }
    }

    #[test]
    fn moving_changes_links_only() {
        let inner = Node::inner(2, 0.5, 7).moved(10, 100);
        assert_eq!(inner, Node::inner(2, 0.5, 17));
        assert_eq!(Node::leaf(7, 3).moved(10, 100), Node::leaf(107, 3));
    }
}
