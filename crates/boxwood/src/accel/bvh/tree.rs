//! What every builder makes and every layout reads.

use crate::geometry::Aabb;
use alloc::vec::Vec;

/// No leaf lies deeper, so a stack of this size always suffices. The root has depth 0.
pub const MAX_DEPTH: usize = 64;
/// No leaf holds more primitives, whatever a builder is set to.
pub const MAX_LEAF: usize = 64;

/// A node: an inner one names its two children, which lie side by side; a leaf names a run of [`BinaryTree::order`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct BinaryNode {
    /// Around all below.
    pub bounds: Aabb,
    /// The first child, or the leaf's place in the order.
    pub first: u32,
    /// How many primitives the leaf holds; 0 marks an inner node.
    pub count: u32,
}

impl BinaryNode {
    /// Whether it has primitives instead of children.
    #[inline(always)]
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
    /// The leaf's places in [`BinaryTree::order`].
    #[inline(always)]
    pub fn places(&self) -> core::ops::Range<usize> {
        self.first as usize..self.first as usize + self.count as usize
    }
    /// The numbers of the two children of an inner node.
    #[inline(always)]
    pub fn children(&self) -> [usize; 2] {
        [self.first as usize, self.first as usize + 1]
    }
}

/// A binary hierarchy of boxes, the root first and each pair of children side by side. Without primitives it has no nodes.
///
/// The fields are public so that builders can be written elsewhere; [`inspect::validate`](crate::inspect::validate) says
/// whether a tree is whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BinaryTree {
    /// Nodes.
    pub nodes: Vec<BinaryNode>,
    /// Primitives in leaf order.
    pub order: Vec<u32>,
}

impl BinaryTree {
    /// The bytes that it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<BinaryNode>() + self.order.capacity() * size_of::<u32>()
    }

    /// Whether the nodes lie as a ray meets them: every pair of children, then what is below the first, then what is below the
    /// second. Builders and refinements leave them so.
    pub(crate) fn is_depth_first(&self) -> bool {
        let mut open = Vec::with_capacity(MAX_DEPTH);
        let (mut next, mut node) = (1, self.nodes.first());
        while let Some(this) = node {
            if this.is_leaf() {
                node = open.pop();
                continue;
            }
            let first = this.first as usize;
            let Some([left, right]) = self.nodes.get(first..first + 2) else {
                return false;
            };
            if first != next {
                return false;
            }
            open.push(right);
            (next, node) = (next + 2, Some(left));
        }
        next >= self.nodes.len()
    }
}
