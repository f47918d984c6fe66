//! Many rays in flight: while one waits for memory, the others are worked on.
//!
//! *How it works.* A few dozen rays have a slot each, with a stack of their own. Rounds alternate: every ray that stands at a
//! node takes one step there (all boxes met, those entered put onto the stack in order, the top taken off), then every ray that
//! stands at a leaf is shown its triangles. A step has no branch that depends on the ray, so nothing is mispredicted, and
//! the processor overlaps the steps of several rays. What a ray needs next is fetched when it gets into line.
//!
//! *Cost.* For rays in any order about half the time of one after the other, where the tree is larger than the second-level cache.

use super::WideBvh;
use super::node::{Child, Heading, Node, WideRay};
use super::scalar;
use crate::geometry::triangle::block::{BlockRay, Stop};
use crate::geometry::{PreparedRay, Ray};
use crate::primitive::Primitives;
use crate::query::Query;
use crate::simd::{F, Floats, Kernel, Lanes, Mask, Simd, U, Words, prefetch};
use alloc::vec;
use core::ops::ControlFlow::{Break, Continue};

/// Rays in flight: 16 to 64 are equally fast.
const SLOTS: usize = 32;

/// A batch through the door: one query for each ray.
pub struct Batch<'a, P, Q, const N: usize> {
    pub bvh: &'a WideBvh<P, N>,
    pub rays: &'a [Ray],
    pub queries: &'a mut [Q],
}

/// A ray in flight.
struct Slot {
    ray: PreparedRay,
    heading: Heading,
    /// Where it stands; [`Child::NOTHING`] when it is through.
    current: Child,
    /// How many entries its stack has. The lowest one is [`Child::NOTHING`].
    pending: usize,
    /// Its place in the batch.
    index: usize,
    /// What its query said last.
    t_max: f32,
}

impl Slot {
    const IDLE: Self = Self {
        ray: PreparedRay::IDLE,
        heading: Heading::NONE,
        current: Child::NOTHING,
        pending: 1,
        index: 0,
        t_max: f32::NEG_INFINITY,
    };
}

impl<P: Primitives, Q: Query, const N: usize> Kernel<N> for Batch<'_, P, Q, N> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, s: S) {
        let Batch { bvh, rays, queries } = self;
        // Every level below the root leaves at most `N - 1` children behind; `N` lanes are written at a time.
        let height = bvh.depth * (N - 1) + 1 + N;
        let mut children = vec![Child::NOTHING.0; SLOTS * height];
        let mut entries = vec![f32::NEG_INFINITY; SLOTS * height];
        let mut slots = [const { Slot::IDLE }; SLOTS];
        let mut waiting = rays.iter().enumerate();
        // Who stands at a node, and who at a leaf.
        let mut at_node = [0_u8; SLOTS];
        let mut at_leaf = [0_u8; SLOTS];
        let (mut nodes, mut leaves) = (0, 0);
        for (place, slot) in slots.iter_mut().enumerate() {
            let Some(next) = Slot::next(s, bvh, &mut waiting, queries) else {
                break;
            };
            *slot = next;
            let (list, count) = if slot.current.is_leaf() {
                (&mut at_leaf, &mut leaves)
            } else {
                (&mut at_node, &mut nodes)
            };
            list[*count % SLOTS] = place as u8;
            *count += 1;
        }
        while nodes + leaves > 0 {
            while nodes > 0 && leaves < SLOTS / 2 {
                let mut stay = 0;
                for i in 0..nodes {
                    let place = at_node[i % SLOTS] as usize % SLOTS;
                    let slot = &mut slots[place];
                    let bottom = place * height;
                    let children = &mut children[bottom..bottom + height];
                    let entries = &mut entries[bottom..bottom + height];
                    slot.step::<S, Q, N>(s, &bvh.nodes, children, entries);
                    bvh.fetch(slot.current);
                    // Both lists are written, and one of them grows.
                    at_node[stay % SLOTS] = place as u8;
                    at_leaf[leaves % SLOTS] = place as u8;
                    let leaf = usize::from(slot.current.is_leaf());
                    stay += 1 - leaf;
                    leaves += leaf;
                }
                nodes = stay;
            }
            let count = leaves;
            leaves = 0;
            for i in 0..count {
                let place = at_leaf[i % SLOTS] as usize % SLOTS;
                let slot = &mut slots[place];
                let query = &mut queries[slot.index];
                let bottom = place * height;
                if slot.current != Child::NOTHING {
                    let lanes = BlockRay::<S>::new(s, &slot.ray);
                    let blocks = slot.current.blocks();
                    let shown = bvh
                        .leaves
                        .offer(blocks, &bvh.primitives, &lanes, query, &mut ());
                    match shown {
                        Continue(()) => {
                            let children = &mut children[bottom..bottom + height];
                            let entries = &mut entries[bottom..bottom + height];
                            if query.t_max() < slot.t_max {
                                slot.t_max = query.t_max();
                                slot.forget_beyond(children, entries);
                            }
                            slot.pop(children);
                        }
                        Break(Stop::Enough) => slot.current = Child::NOTHING,
                        Break(Stop::Uncovered) => {
                            scalar::walk(bvh, &slot.ray, query, &mut ());
                            slot.current = Child::NOTHING;
                        }
                    }
                }
                if slot.current == Child::NOTHING {
                    match Slot::next(s, bvh, &mut waiting, queries) {
                        Some(next) => *slot = next,
                        None => continue,
                    }
                }
                bvh.fetch(slot.current);
                let (list, count) = if slot.current.is_leaf() {
                    (&mut at_leaf, &mut leaves)
                } else {
                    (&mut at_node, &mut nodes)
                };
                list[*count % SLOTS] = place as u8;
                *count += 1;
            }
        }
    }
}

impl Slot {
    /// The next ray that is worth a slot; those outside the doors are answered at once.
    #[inline(always)]
    fn next<'r, S: Lanes<4>, P: Primitives, Q: Query, const N: usize>(
        s: S,
        bvh: &WideBvh<P, N>,
        waiting: &mut impl Iterator<Item = (usize, &'r Ray)>,
        queries: &mut [Q],
    ) -> Option<Self> {
        for (index, ray) in waiting {
            if let Some(ray) = PreparedRay::tame(s, ray, bvh.scale) {
                return Some(Self {
                    heading: Heading::of(&ray),
                    ray,
                    current: bvh.root,
                    pending: 1,
                    index,
                    t_max: queries[index].t_max(),
                });
            }
            if let Some(ray) = PreparedRay::new(ray, bvh.scale) {
                bvh.plainly(&ray, &mut queries[index], &mut ());
            }
        }
        None
    }

    /// Opens the node at which the ray stands and takes the next one.
    #[inline(always)]
    fn step<S: Simd + Lanes<N>, Q: Query, const N: usize>(
        &mut self,
        s: S,
        nodes: &[Node<N>],
        children: &mut [u32],
        entries: &mut [f32],
    ) {
        let node = &nodes[self.current.index()];
        let ray = WideRay::<S, N>::new(s, &self.ray, self.heading);
        let (entry, exit) = node.slabs(s, &ray, F::<S, N>::splat(s, self.t_max));
        let below = U::<S, N>::load(s, node.children());
        let (entry, exit, below) = if Q::ORDERED {
            let order = U::<S, N>::from_nibbles(s, node.order(self.heading.octant()));
            (
                entry.permute(order),
                exit.permute(order),
                below.permute(order),
            )
        } else {
            (entry, exit, below)
        };
        let entered = entry.le(exit);
        let top = self.pending;
        below.close_up(entered, children[top..].first_chunk_mut().expect("room"));
        if Q::ORDERED {
            entry.close_up(entered, entries[top..].first_chunk_mut().expect("room"));
        }
        self.pending = top + entered.bits().count_ones() as usize;
        self.pop(children);
    }

    #[inline(always)]
    fn pop(&mut self, children: &[u32]) {
        self.pending -= 1;
        self.current = Child(children[self.pending]);
    }

    /// Drops what is entered beyond its `t_max`. What is entered exactly there may hold an equal hit of a lower primitive.
    #[inline(always)]
    fn forget_beyond(&mut self, children: &mut [u32], entries: &mut [f32]) {
        let mut kept = 1;
        for i in 1..self.pending {
            (children[kept], entries[kept]) = (children[i], entries[i]);
            kept += usize::from(entries[i] <= self.t_max);
        }
        self.pending = kept;
    }
}

impl<P: Primitives, const N: usize> WideBvh<P, N> {
    /// Begins to load what a ray that stands there will need.
    #[inline(always)]
    fn fetch(&self, child: Child) {
        if child.is_leaf() {
            self.leaves.fetch(child.blocks().start);
        } else if let Some(node) = self.nodes.get(child.index()) {
            prefetch(node, size_of::<Node<N>>() / 64);
        }
    }
}
