//! Wide trees over meshes that move: one tree, whose boxes and triangles are kept at every key and met in between.
//!
//! *How it works.* A tree is built over the mesh as it is at the middle of the shutter, and [fitted](super::refit) to it once for each key: who
//! lies where is the same at all keys, boxes and corners are not. A ray has a time, and a time lies between two keys
//! (`geometry/motion.rs`): at each step all planes of a node, and at a leaf all corners, are taken from both and mixed, in lanes. Boxes
//! so are as tight at any time as those of a tree at rest are that was fitted, however far things go; a box around all of the way is not. A mesh that
//! turns or bends needs as many keys as its curves want, and each of them has boxes of its own.
//!
//! *Why nothing is lost.* What moves evenly and is inside a plane at both keys is inside at all times between. Rounding is paid for by a
//! larger slack (`Frame::in_motion`). Rays outside the doors meet boxes around those of both keys, which hold what is between them as it is
//! ([`geometry/motion.rs`](crate::MovingMesh)). Corners are mixed by the operations that define where they are, so answers are the judge's.
//!
//! *Cost.* For each key what a [`WideBvh`] takes: about 62 bytes for a triangle. Building: one tree, and a fitting for each key. A step
//! reads two nodes instead of one.
//!
//! *Source.* Grünschloß, Stich, Nawaz & Keller 2011, *MSBVH: An Efficient Acceleration Data Structure for Ray Traced Motion Blur*; Woop, Áfra &
//! Benthin 2017, *STBVH: A Spatial-Temporal BVH for Efficient Multi-Segment Motion Blur* (linear bounds; their splits in time are not done here).

mod between;
mod build;

use super::leaf::Leaves;
use super::node::{Child, Node};
use super::{scalar, traverse, tree};
use crate::geometry::frame::Frame;
use crate::geometry::motion::Moment;
use crate::geometry::triangle::block::Stop;
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{Cell, Statistics};
use crate::primitive::{MovingMesh, Primitives};
use crate::query::{Counters, Query, Traverse};
use crate::simd::{Isa, Level, Pages, Portable, Vectorize};
use alloc::vec::Vec;
use between::Between;
use core::borrow::Borrow;
use core::ops::ControlFlow::Break;

/// A hierarchy of nodes with `N` children (8 or 16) over a [`MovingMesh`], owned, borrowed or shared, whose boxes move with it.
///
/// [`WideSah::build_moving`](super::WideSah::build_moving) makes it, and [`Timed`](crate::Timed) asks it: each query has a time,
/// 0 unless it says another one. It shows itself as it is at the middle of the shutter.
#[derive(Clone, Debug)]
pub struct MotionBvh<M, const N: usize> {
    mesh: M,
    /// Around all of the way.
    bounds: Aabb,
    /// What the boxes of nodes are seen from at all keys.
    frame: Frame,
    root: Child,
    /// One at least.
    keys: Vec<Key<N>>,
    isa: Isa,
}

/// Nodes and leaves at one key. Children, and who lies where, are the same at all of them.
#[derive(Clone, Debug)]
struct Key<const N: usize> {
    nodes: Pages<Node<N>>,
    leaves: Leaves,
}

impl<M: Borrow<MovingMesh>, const N: usize> MotionBvh<M, N> {
    /// The same tree, walked with a chosen instruction set.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The mesh.
    pub fn mesh(&self) -> &MovingMesh {
        self.mesh.borrow()
    }

    /// The tree at a moment.
    #[inline(always)]
    fn now(&self, time: f32) -> Between<'_, N> {
        let moment = Moment::new(time, self.keys.len());
        Between {
            mesh: self.mesh.borrow(),
            bounds: self.bounds,
            frame: &self.frame,
            root: self.root,
            near: &self.keys[moment.near],
            far: &self.keys[moment.far],
            moment,
        }
    }
}

/// When it shows itself.
const MIDDLE: f32 = 0.5;

impl<M: Borrow<MovingMesh>, const N: usize> Traverse for MotionBvh<M, N>
where
    Level: Vectorize<N>,
{
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn statistics(&self) -> Statistics {
        let bytes = |key: &Key<N>| {
            let blocks = key.leaves.len() * Leaves::block_bytes(true);
            size_of_val(&*key.nodes) + blocks
        };
        let count = self.mesh().len();
        Statistics {
            bytes: self.keys.iter().map(bytes).sum(),
            ..Statistics::of_cells(count, self.bounds, |show| self.cells(show))
        }
    }

    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        tree::cells(&self.now(MIDDLE), show);
    }

    #[inline]
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        if self.root == Child::NOTHING {
            return;
        }
        let now = self.now(query.time());
        if !C::EXPLAINS {
            let one = traverse::One {
                tree: &now,
                from: self.root,
                ray,
                query,
                counters,
            };
            // As trees at rest: counts are the same on every machine.
            let walked = if C::COUNTS {
                Portable.vectorize(one)
            } else {
                self.isa.level().vectorize(one)
            };
            if !matches!(walked, Break(Stop::Uncovered)) {
                return;
            }
        }
        if let Some(ray) = PreparedRay::new(ray, self.frame.scale) {
            scalar::walk(&now, self.root, &ray, query, counters);
        }
    }
}
