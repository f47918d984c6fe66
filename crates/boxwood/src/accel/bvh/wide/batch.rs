//! Many rays in flight: while one waits for memory, the others are worked on.
//!
//! *How it works.* A few dozen rays have a slot each, with a stack of their own. Rounds alternate: every ray that stands at a
//! node takes one step there (all boxes met, those entered put onto the stack in order, the top taken off), then every ray that
//! stands at a leaf is shown its triangles. A step has no branch that depends on the ray, so nothing is mispredicted, and
//! the processor overlaps the steps of several rays. What a ray needs next is fetched when it gets into line.
//!
//! *Cost.* For rays in any order about three quarters of the time of one after the other; less where the tree is much larger than the
//! second-level cache.

use super::WideBvh;
use super::boxes::Boxes;
use super::layout::Layout;
use super::node::{Child, Heading, Node, WideRay};
use crate::geometry::triangle::block::{BlockRay, Stop};
use crate::geometry::{PreparedRay, Ray};
use crate::primitive::{Foresight, Primitives};
use crate::query::Query;
use crate::simd::{F, Floats, Kernel, Lanes, Row, Simd, Stack, U, Words, address, prefetch};
use core::array;
use core::hint::select_unpredictable;
use core::mem;
use core::ops::ControlFlow::{Break, Continue};

/// Rays in flight: 16 to 64 are equally fast.
const SLOTS: usize = 32;

/// The cache lines of a node or a leaf that are asked for ahead. A leaf has three; the rest of a node follows by itself.
const LINES: usize = 3;

/// A batch through the door: one query for each ray.
pub struct Batch<'a, P, Q, const N: usize, L: Layout> {
    pub bvh: &'a WideBvh<P, N, L>,
    pub rays: &'a [Ray],
    pub queries: &'a mut [Q],
}

/// A ray in flight.
struct Slot<const N: usize> {
    ray: PreparedRay,
    heading: Heading,
    /// Of the planes that the ray meets first.
    rows: [Row<N, 6>; 3],
    /// Where it stands; [`Child::NOTHING`] when it is through, which lies at the bottom of its stack.
    current: Child,
    /// Its place in the batch.
    index: usize,
    /// What its query said last.
    t_max: f32,
}

/// The slots that stand somewhere.
struct Queue {
    slots: [u8; SLOTS],
    len: usize,
}

impl Queue {
    const EMPTY: Self = Self {
        slots: [0; SLOTS],
        len: 0,
    };

    /// Writes a slot behind the last one, where it stays if it is `there`: without a branch.
    #[inline(always)]
    fn push_if(&mut self, there: bool, slot: usize) {
        self.slots[self.len % SLOTS] = slot as u8;
        self.len += usize::from(there);
    }

    #[inline(always)]
    fn slot(&self, i: usize) -> usize {
        usize::from(self.slots[i % SLOTS]) % SLOTS
    }
}

impl<P: Primitives, Q: Query, const N: usize, L: Layout> Kernel<N> for Batch<'_, P, Q, N, L> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, s: S) {
        let Batch { bvh, rays, queries } = self;
        let nodes = &*bvh.nodes;
        let mut slots = [const { Slot::IDLE }; SLOTS];
        let mut stacks: [Stack<ROOM>; SLOTS] = array::from_fn(|_| Stack::new());
        let mut waiting = rays.iter().enumerate();
        let (mut at_node, mut at_leaf) = (Queue::EMPTY, Queue::EMPTY);
        for (place, (slot, stack)) in slots.iter_mut().zip(&mut stacks).enumerate() {
            if !slot.begin(s, bvh, &mut waiting, queries, stack) {
                break;
            }
            at_node.push_if(!slot.current.is_leaf(), place);
            at_leaf.push_if(slot.current.is_leaf(), place);
        }
        while at_node.len + at_leaf.len > 0 {
            while at_node.len > 0 && at_leaf.len < SLOTS / 2 {
                let standing = mem::take(&mut at_node.len);
                for i in 0..standing {
                    let place = at_node.slot(i);
                    let slot = &mut slots[place];
                    slot.step::<S, Q, _>(s, nodes, bvh.slackened(), &mut stacks[place]);
                    bvh.fetch(slot.current);
                    at_node.push_if(!slot.current.is_leaf(), place);
                    at_leaf.push_if(slot.current.is_leaf(), place);
                }
            }
            let standing = mem::take(&mut at_leaf.len);
            if P::TRIANGLES && !L::CORNERS {
                // What leaves name is asked for on behalf of all rays before the first one looks at it.
                for i in 0..standing {
                    bvh.foresee(slots[at_leaf.slot(i)].current, Foresight::Far);
                }
                for i in 0..standing {
                    bvh.foresee(slots[at_leaf.slot(i)].current, Foresight::Near);
                }
            }
            for i in 0..standing {
                let place = at_leaf.slot(i);
                let (slot, stack) = (&mut slots[place], &mut stacks[place]);
                if slot.current != Child::NOTHING {
                    slot.look(s, bvh, &mut queries[slot.index], stack);
                }
                if slot.current == Child::NOTHING
                    && !slot.begin(s, bvh, &mut waiting, queries, stack)
                {
                    continue;
                }
                bvh.fetch(slot.current);
                at_node.push_if(!slot.current.is_leaf(), place);
                at_leaf.push_if(slot.current.is_leaf(), place);
            }
        }
    }
}

impl<const N: usize> Slot<N> {
    const IDLE: Self = Self {
        ray: PreparedRay::IDLE,
        heading: Heading::NONE,
        rows: [Row::FIRST; 3],
        current: Child::NOTHING,
        index: 0,
        t_max: f32::NEG_INFINITY,
    };

    /// Takes the next ray that is worth a slot, if there is one; those outside the doors are answered at once.
    #[inline(always)]
    fn begin<'r, S: Lanes<4>, P: Primitives, Q: Query, L: Layout>(
        &mut self,
        s: S,
        bvh: &WideBvh<P, N, L>,
        waiting: &mut impl Iterator<Item = (usize, &'r Ray)>,
        queries: &mut [Q],
        stack: &mut Stack<ROOM>,
    ) -> bool {
        let slack = bvh.precision.slack();
        for (index, ray) in waiting {
            if let Some((ray, facing)) = PreparedRay::tame(s, ray, &bvh.frame, slack) {
                self.heading = Heading::of(s, &facing);
                self.rows = self.heading.rows();
                self.ray = ray;
                self.current = bvh.root;
                self.index = index;
                self.t_max = queries[index].t_max();
                stack.begin(Child::NOTHING.0);
                return true;
            }
            if let Some(ray) = PreparedRay::new(ray, bvh.frame.scale) {
                bvh.plainly(bvh.root, &ray, &mut queries[index], &mut ());
            }
        }
        false
    }

    /// Opens the node at which the ray stands and takes the next one.
    #[inline(always)]
    fn step<S: Simd + Lanes<N>, Q: Query, B: Boxes<N>>(
        &mut self,
        s: S,
        nodes: &[Node<N, B>],
        slackened: Option<f32>,
        stack: &mut Stack<ROOM>,
    ) {
        let node = &nodes[self.current.index()];
        let top = stack.top::<N>();
        let terms = match slackened {
            Some(times) => self.ray.slackened_terms(s, times),
            None => self.ray.slab_terms(),
        };
        let ray = WideRay::<S, N>::new(s, terms, self.ray.t_min, self.rows);
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
        top.push::<S>(below, entry, entry.le(exit));
        self.pop(stack);
    }

    /// Shows the query the leaf at which the ray stands and takes the next child.
    #[inline(always)]
    fn look<S: Simd + Lanes<N>, P: Primitives, Q: Query, L: Layout>(
        &mut self,
        s: S,
        bvh: &WideBvh<P, N, L>,
        query: &mut Q,
        stack: &mut Stack<ROOM>,
    ) {
        let at = BlockRay {
            s,
            ray: &self.ray,
            leaning: &self.ray.leaning,
            exact: bvh.precision.is_exact(),
        };
        match bvh.offer(self.current, &at, query, &mut ()) {
            Continue(()) => {
                if query.t_max() < self.t_max {
                    self.t_max = query.t_max();
                    // What is entered exactly there may hold an equal hit of a lower primitive.
                    stack.forget_beyond::<S, N>(s, self.t_max);
                }
                self.pop(stack);
            }
            Break(Stop::Enough) => self.current = Child::NOTHING,
            Break(Stop::Uncovered) => {
                // In the world, where primitives want to see it.
                if let Some(ray) = PreparedRay::new(&self.ray, bvh.frame.scale) {
                    bvh.plainly(bvh.root, &ray, query, &mut ());
                }
                self.current = Child::NOTHING;
            }
        }
    }

    #[inline(always)]
    fn pop(&mut self, stack: &mut Stack<ROOM>) {
        let (child, _) = stack.pop().expect("nothing lies at the bottom");
        self.current = Child(child);
    }
}

/// How many levels a tree may have for this.
pub const LEVELS: usize = 24;
const ROOM: usize = Stack::<0>::room(LEVELS, 16);

impl<P: Primitives, const N: usize, L: Layout> WideBvh<P, N, L> {
    /// Begins to load what a leaf names.
    #[inline(always)]
    fn foresee(&self, leaf: Child, step: Foresight) {
        let block = leaf.blocks().start;
        self.leaves.foresee(block, &self.primitives, step);
    }

    /// Begins to load what a ray that stands there will need. Without a branch: where a ray stands cannot be predicted.
    #[inline(always)]
    fn fetch(&self, child: Child) {
        let node = address(&self.nodes, child.index());
        let leaf = self.leaves.address::<L>(child.blocks().start);
        let lines = if L::CORNERS { LINES } else { 2 };
        prefetch(select_unpredictable(child.is_leaf(), leaf, node), lines);
    }
}
