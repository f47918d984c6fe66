//! A wide tree as the loops see it: at rest, or between two keys of its motion.

use super::leaf::Leaves;
use super::node::{Child, WideRay};
use super::{Layout, Precision, WideBvh};
use crate::geometry::Aabb;
use crate::geometry::frame::Frame;
use crate::geometry::triangle::block::{BlockRay, Stop};
use crate::inspect::Cell;
use crate::primitive::Primitives;
use crate::query::{Counters, Part, Query};
use crate::simd::{F, Lanes};
use alloc::vec;
use core::ops::ControlFlow;

/// What the loops ask of a tree. All of it is `#[inline(always)]`, for kernels ask it.
pub trait Tree<const N: usize> {
    /// The primitives.
    type Primitives: Primitives;
    fn primitives(&self) -> &Self::Primitives;
    /// Around all of them.
    fn bounds(&self) -> Aabb;
    /// What boxes are seen from.
    fn frame(&self) -> &Frame;
    fn root(&self) -> Child;
    fn precision(&self) -> Precision;
    /// The children of a node.
    fn children(&self, index: usize) -> &[u32; N];
    /// As [`Node::child`](super::node::Node::child), of a node.
    fn child(&self, index: usize, lane: usize) -> Child;
    /// As [`Node::order`](super::node::Node::order), of a node.
    fn order(&self, index: usize, octant: usize) -> u64;
    /// The leaves, for the numbers in them.
    fn leaves(&self) -> &Leaves;
    /// The box of a child, as the frame sees it. For a ray that is not tame it holds what is below without any slack.
    fn child_bounds(&self, index: usize, lane: usize, tame: bool) -> Aabb;
    /// As [`Node::slabs`](super::node::Node::slabs), of a node.
    fn slabs<S: Lanes<N>>(
        &self,
        s: S,
        index: usize,
        ray: &WideRay<S, N>,
        t_max: F<S, N>,
    ) -> (F<S, N>, F<S, N>);
    /// A child's box, as the world sees it.
    fn in_world(&self, seen: &Aabb) -> Aabb;
    /// By how many times the slack a ray meets boxes, where it is more than once.
    #[inline(always)]
    fn slackened(&self) -> Option<f32> {
        None
    }
    /// Which part of its primitive a block of the leaves holds.
    fn part(&self, _block: usize) -> Part {
        Part::ALL
    }
    /// Shows the primitives in a leaf to the query.
    fn offer<S: Lanes<{ Leaves::LANES }>, Q: Query, C: Counters>(
        &self,
        leaf: Child,
        at: &BlockRay<'_, S>,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<Stop>;
}

impl<P: Primitives, const N: usize, L: Layout> Tree<N> for WideBvh<P, N, L> {
    type Primitives = P;
    #[inline(always)]
    fn primitives(&self) -> &P {
        &self.primitives
    }
    #[inline(always)]
    fn bounds(&self) -> Aabb {
        self.bounds
    }
    #[inline(always)]
    fn frame(&self) -> &Frame {
        &self.frame
    }
    #[inline(always)]
    fn root(&self) -> Child {
        self.root
    }
    #[inline(always)]
    fn precision(&self) -> Precision {
        self.precision
    }
    #[inline(always)]
    fn children(&self, index: usize) -> &[u32; N] {
        self.nodes[index].children()
    }
    #[inline(always)]
    fn child(&self, index: usize, lane: usize) -> Child {
        self.nodes[index].child(lane)
    }
    #[inline(always)]
    fn order(&self, index: usize, octant: usize) -> u64 {
        self.nodes[index].order(octant)
    }
    #[inline(always)]
    fn leaves(&self) -> &Leaves {
        &self.leaves
    }
    #[inline(always)]
    fn child_bounds(&self, index: usize, lane: usize, _tame: bool) -> Aabb {
        self.nodes[index].bounds(lane)
    }
    #[inline(always)]
    fn in_world(&self, seen: &Aabb) -> Aabb {
        Self::in_world(self, seen)
    }
    #[inline(always)]
    fn slackened(&self) -> Option<f32> {
        Self::slackened(self)
    }
    fn part(&self, block: usize) -> Part {
        Self::part(self, block)
    }
    #[inline(always)]
    fn slabs<S: Lanes<N>>(
        &self,
        s: S,
        index: usize,
        ray: &WideRay<S, N>,
        t_max: F<S, N>,
    ) -> (F<S, N>, F<S, N>) {
        self.nodes[index].slabs(s, ray, t_max)
    }
    #[inline(always)]
    fn offer<S: Lanes<{ Leaves::LANES }>, Q: Query, C: Counters>(
        &self,
        leaf: Child,
        at: &BlockRay<'_, S>,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<Stop> {
        Self::offer(self, leaf, at, query, counters)
    }
}

/// Shows every node and leaf, parents before their children.
pub fn cells<T: Tree<N>, const N: usize>(tree: &T, show: &mut dyn FnMut(&Cell<'_>)) {
    if tree.root() == Child::NOTHING {
        return;
    }
    let mut open = vec![(0, 0, tree.bounds(), tree.root())];
    while let Some((node, depth, bounds, child)) = open.pop() {
        let leaf = child.is_leaf();
        let primitives = leaf.then(|| tree.leaves().ids(child.blocks()).count() as u32);
        show(&Cell {
            node,
            depth,
            bounds,
            primitives,
            sides: &[],
        });
        if leaf {
            continue;
        }
        // The first one comes next.
        for lane in (0..N).rev() {
            let below = tree.child(child.index(), lane);
            if below != Child::NOTHING {
                let bounds = tree.child_bounds(child.index(), lane, true);
                let bounds = tree.in_world(&bounds);
                open.push((child.number::<N>(lane), depth + 1, bounds, below));
            }
        }
    }
}
