//! The one loop over wide nodes, in lanes.

use super::node::{Child, Heading, WideRay};
use super::tree::Tree;
use crate::geometry::ray::Facing;
use crate::geometry::triangle::block::{BlockRay, Stop};
use crate::geometry::{PreparedRay, Ray};
use crate::query::{Counters, Query};
use crate::simd::{F, Floats, Kernel, Lanes, Mask, Simd, Stack, U, Words};
use core::hint::black_box;
use core::ops::ControlFlow::{self, Break, Continue};

/// Enough for 64 levels that each leave 15 of 16 children behind.
const ROOM: usize = Stack::<0>::room(64, 16);

/// One ray through the door.
pub struct One<'a, T, Q, C> {
    pub tree: &'a T,
    /// Where it begins.
    pub from: Child,
    pub ray: &'a Ray,
    pub query: &'a mut Q,
    pub counters: &'a mut C,
}

impl<T: Tree<N>, Q: Query, C: Counters, const N: usize> Kernel<N> for One<'_, T, Q, C> {
    type Output = ControlFlow<Stop>;
    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, s: S) -> ControlFlow<Stop> {
        let slack = self.tree.precision().slack();
        match PreparedRay::tame(s, self.ray, self.tree.frame(), slack) {
            Some((ray, facing)) => {
                let facing = match self.tree.slackened() {
                    Some(times) => facing.slackened(s, times),
                    None => facing,
                };
                walk(s, self, &ray, &facing)
            }
            None => Break(Stop::Uncovered),
        }
    }
}

/// Every query, counted or not, every width, every kind of leaf, every level, at rest or in motion.
///
/// *How it works.* All boxes of a node are met at once. Most rays enter none or one of them, which a branch predicts well:
/// the next load need not wait for any sorting. Where there are more, the list for the ray's octant says which comes
/// first; they go onto the stack in that order, closed up, with the distances of their boxes.
#[inline(always)]
fn walk<S, T, Q, C, const N: usize>(
    s: S,
    One {
        tree,
        from,
        query,
        counters,
        ..
    }: One<'_, T, Q, C>,
    ray: &PreparedRay,
    facing: &Facing<S>,
) -> ControlFlow<Stop>
where
    S: Simd + Lanes<N>,
    T: Tree<N>,
    Q: Query,
    C: Counters,
{
    let heading = Heading::of(s, facing);
    let wide = WideRay::<S, N>::new(s, facing.slab_terms(), ray.t_min, heading.rows());
    // In memory, for the compiler would otherwise spread it over registers before the first node, needed or not.
    let leaning = ray.leaning;
    let leaning = black_box(&leaning);
    let exact = tree.precision().is_exact();
    let mut t_max = F::<S, N>::splat(s, query.t_max());
    let mut stack = Stack::<ROOM>::new();
    let mut current = from;
    loop {
        while !current.is_leaf() {
            counters.node();
            let node = current.index();
            let (entry, exit) = tree.slabs(s, node, &wide, t_max);
            let entered = entry.le(exit);
            let bits = entered.bits();
            if bits & bits.wrapping_sub(1) == 0 {
                if bits != 0 {
                    current = tree.child(node, bits.trailing_zeros() as usize);
                    continue;
                }
            } else if Q::ORDERED {
                let order = U::<S, N>::from_nibbles(s, tree.order(node, heading.octant()));
                let (entry, exit) = (entry.permute(order), exit.permute(order));
                let children = U::<S, N>::load(s, tree.children(node)).permute(order);
                stack.top::<N>().push::<S>(children, entry, entry.le(exit));
            } else {
                let children = U::<S, N>::load(s, tree.children(node));
                stack.top::<N>().push::<S>(children, entry, entered);
            }
            match next(&mut stack, query) {
                Some(child) => current = child,
                None => return Continue(()),
            }
        }
        counters.leaf();
        let at = BlockRay {
            s,
            ray,
            leaning,
            exact,
        };
        tree.offer(current, &at, query, counters)?;
        t_max = F::<S, N>::splat(s, query.t_max());
        match next(&mut stack, query) {
            Some(child) => current = child,
            None => return Continue(()),
        }
    }
}

/// The next pending child that may still matter: one that is entered exactly at `t_max` may hold an equal hit of a lower
/// primitive.
#[inline(always)]
fn next<Q: Query>(stack: &mut Stack<ROOM>, query: &Q) -> Option<Child> {
    loop {
        let (child, entry) = stack.pop()?;
        if entry <= query.t_max() {
            return Some(Child(child));
        }
    }
}
