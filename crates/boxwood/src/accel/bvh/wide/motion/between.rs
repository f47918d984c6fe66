//! A moving tree at a moment: every plane and every corner on its way from the nearer key to the farther one.

use super::super::Precision;
use super::super::leaf::Leaves;
use super::super::node::{Child, WideRay};
use super::super::tree::Tree;
use super::Key;
use crate::geometry::Aabb;
use crate::geometry::frame::Frame;
use crate::geometry::motion::Moment;
use crate::geometry::triangle::block::{BlockRay, Stop};
use crate::primitive::MovingMesh;
use crate::query::{Counters, Query};
use crate::simd::{F, Floats, Lanes};
use core::ops::ControlFlow::{self, Continue};

pub struct Between<'a, const N: usize> {
    pub mesh: &'a MovingMesh,
    pub bounds: Aabb,
    pub frame: &'a Frame,
    pub root: Child,
    pub near: &'a Key<N>,
    pub far: &'a Key<N>,
    pub moment: Moment,
}

impl<const N: usize> Tree<N> for Between<'_, N> {
    type Primitives = MovingMesh;
    #[inline(always)]
    fn primitives(&self) -> &MovingMesh {
        self.mesh
    }
    #[inline(always)]
    fn bounds(&self) -> Aabb {
        self.bounds
    }
    #[inline(always)]
    fn frame(&self) -> &Frame {
        self.frame
    }
    #[inline(always)]
    fn root(&self) -> Child {
        self.root
    }
    #[inline(always)]
    fn precision(&self) -> Precision {
        Precision::Exact
    }
    #[inline(always)]
    fn children(&self, index: usize) -> &[u32; N] {
        self.near.nodes[index].children()
    }
    #[inline(always)]
    fn child(&self, index: usize, lane: usize) -> Child {
        self.near.nodes[index].child(lane)
    }
    #[inline(always)]
    fn order(&self, index: usize, octant: usize) -> u64 {
        self.near.nodes[index].order(octant)
    }
    #[inline(always)]
    fn leaves(&self) -> &Leaves {
        &self.near.leaves
    }
    #[inline(always)]
    fn child_bounds(&self, index: usize, lane: usize, tame: bool) -> Aabb {
        let near = self.near.nodes[index].bounds(lane);
        let far = self.far.nodes[index].bounds(lane);
        if tame {
            Aabb {
                lower: self.moment.place(near.lower, far.lower),
                upper: self.moment.place(near.upper, far.upper),
            }
        } else {
            near.union(far)
        }
    }
    #[inline(always)]
    fn in_world(&self, seen: &Aabb) -> Aabb {
        self.frame.in_world(seen)
    }
    #[inline(always)]
    fn slabs<S: Lanes<N>>(
        &self,
        s: S,
        index: usize,
        ray: &WideRay<S, N>,
        t_max: F<S, N>,
    ) -> (F<S, N>, F<S, N>) {
        let weight = F::<S, N>::splat(s, self.moment.weight);
        let (near, far) = (&self.near.nodes[index], &self.far.nodes[index]);
        near.slabs_towards(s, far, weight, ray, t_max)
    }
    #[inline(always)]
    fn offer<S: Lanes<{ Leaves::LANES }>, Q: Query, C: Counters>(
        &self,
        leaf: Child,
        at: &BlockRay<'_, S>,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<Stop> {
        // A mesh that moves has no masks of its own.
        if query.mask() == 0 {
            return Continue(());
        }
        for block in leaf.blocks() {
            let near = self.near.leaves.corners(block);
            let far = self.far.leaves.corners(block);
            let (Some(near), Some(far)) = (near, far) else {
                continue;
            };
            counters.primitives(near.count());
            let block = near.towards(at.s, far, self.moment.weight);
            block.offer(at, query, |_| true)?;
        }
        Continue(())
    }
}
