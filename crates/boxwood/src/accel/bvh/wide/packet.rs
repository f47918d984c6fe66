//! Sixty-four rays that run together: one box test for all of them, and each triangle against sixteen at once.
//!
//! *How it works.* Origins and reciprocal directions of the packet are intervals. A node's box is entered where *some* ray of
//! the intervals may enter it, so one test in lanes over the children serves the whole packet. At a leaf every ray is held
//! against its box, and those that enter it against each triangle, sixteen rays an operation: the canonical test in its
//! canonical order, behind the filter of rounded products, which most groups of rays do not pass.
//!
//! *Cost.* On the rays of a camera half to nine tenths of the time of one ray after the other, least where they meet much.
//!
//! *Source.* Wald et al. 2001, *Interactive Rendering with Coherent Ray Tracing*; Boulos, Wald & Shirley 2006, *Geometric and
//! Arithmetic Culling Methods for Entire Ray Packets*.

mod bounds;
mod found;
mod gather;
mod leaf;

use super::WideBvh;
use super::layout::Layout;
use super::node::{Child, Heading};
use super::precision::Precision;
use crate::geometry::Ray;
use crate::geometry::triangle::block::RayGroup;
use crate::primitive::Primitives;
use crate::query::Query;
use crate::simd::{Floats, Kernel, Lanes, Mask, Simd, Stack, U, Words};
use alloc::vec;
use alloc::vec::Vec;
use bounds::Bounds;
use found::Found;

/// Rays in a packet.
pub const RAYS: usize = 64;
/// Rays that are held against a triangle at once.
const LANES: usize = RayGroup::LANES;
const GROUPS: usize = RAYS / LANES;

/// A number for each ray.
type Row = [[f32; LANES]; GROUPS];
const ROW: Row = [[0.0; LANES]; GROUPS];

/// A packet through the door: at most [`RAYS`] rays, one query for each.
pub struct Together<'a, P, Q, const N: usize, L: Layout> {
    pub bvh: &'a WideBvh<P, N, L>,
    pub packet: &'a mut Packet,
    pub rays: &'a [Ray],
    pub queries: &'a mut [Q],
}

/// What became of rays that were to run together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// They are too different: none was asked.
    Apart,
    /// They came to so many nodes that they have little in common: those that are still [open](Found::is_open) are to be
    /// asked one by one, and the next ones had better run apart.
    Loose,
    /// They are answered.
    Together,
}

/// Rays made ready to run together. Aligned, for a row that crosses a line of the cache is read at half the pace.
#[repr(align(64))]
pub struct Packet {
    /// In the order of `axes`, in the world: triangles stay there.
    origin: [Row; 3],
    shear: [Row; 3],
    inverse: [Row; 3],
    enter: [Row; 3],
    leave: [Row; 3],
    t_min: Row,
    pub found: Found,
    heading: Heading,
    precision: Precision,
    axes: [usize; 3],
    /// The ranges of `1 / direction`.
    least_inverse: [f32; 3],
    most_inverse: [f32; 3],
    /// The ranges of the origins as the tree's frame sees them, widened by the slack.
    least_origin: [f32; 3],
    most_origin: [f32; 3],
    children: Vec<u32>,
    entries: Vec<f32>,
    /// The node that holds each child.
    parents: Vec<u32>,
}

/// A packet that opens more nodes and leaves than this is given up: rays of a camera need a tenth of it.
const MOST_STEPS: usize = 4 * RAYS;

impl Packet {
    /// For a tree of such a depth.
    pub fn for_depth<const N: usize>(depth: usize, precision: Precision) -> Self {
        let height = Stack::<0>::room(depth, N);
        Self {
            origin: [ROW; 3],
            shear: [ROW; 3],
            inverse: [ROW; 3],
            enter: [ROW; 3],
            leave: [ROW; 3],
            t_min: ROW,
            found: Found::NOTHING,
            heading: Heading::NONE,
            precision,
            axes: [0; 3],
            least_inverse: [0.0; 3],
            most_inverse: [0.0; 3],
            least_origin: [0.0; 3],
            most_origin: [0.0; 3],
            children: vec![Child::NOTHING.0; height],
            entries: vec![f32::NEG_INFINITY; height],
            parents: vec![Child::NOTHING.0; height],
        }
    }
}

impl<P: Primitives, Q: Query, const N: usize, L: Layout> Kernel<N> for Together<'_, P, Q, N, L> {
    type Output = Outcome;

    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, s: S) -> Outcome {
        let Together {
            bvh,
            packet,
            rays,
            queries,
        } = self;
        if !packet.gather(s, rays, queries, &bvh.frame) {
            return Outcome::Apart;
        }
        let bounds = Bounds::<S, N>::new(s, packet);
        let mut latest = packet.found.latest(s);
        let mut steps = 0;
        let mut pending = 1;
        let mut current = bvh.root;
        let mut parent = Child::NOTHING;
        loop {
            steps += 1;
            if steps > MOST_STEPS {
                packet.found.answer(queries);
                return Outcome::Loose;
            }
            if current.is_leaf() {
                if packet.leaf(s, bvh, current, parent, Q::ORDERED) {
                    latest = packet.found.latest(s);
                }
            } else {
                let node = &bvh.nodes[current.index()];
                let (entry, exit) = bounds.slabs(s, node, latest);
                let order = U::<S, N>::from_nibbles(s, node.order(packet.heading.octant()));
                let (entry, exit) = (entry.permute(order), exit.permute(order));
                let entered = entry.le(exit);
                let below = U::<S, N>::load(s, node.children()).permute(order);
                let room = "a stack as deep as the tree";
                below.close_up(
                    entered,
                    packet.children[pending..].first_chunk_mut().expect(room),
                );
                entry.close_up(
                    entered,
                    packet.entries[pending..].first_chunk_mut().expect(room),
                );
                packet.parents[pending..pending + N].fill(current.0);
                pending += entered.bits().count_ones() as usize;
            }
            loop {
                pending -= 1;
                if pending == 0 {
                    packet.found.answer(queries);
                    return Outcome::Together;
                }
                if packet.entries[pending] <= latest {
                    break;
                }
            }
            current = Child(packet.children[pending]);
            parent = Child(packet.parents[pending]);
        }
    }
}
