//! Moves subtrees to where they cost least.
//!
//! *How it works.* For every node the best other place is sought: on the way up to the root the subtrees beside it are
//! searched, and a branch is left as soon as even a box that did not grow at all could not save more than the best place
//! found so far. Searches only read, so all are made side by side. Then the moves are made one after the other, those that
//! save most first, leaving out any that touches a node which has changed since. A round that would raise the cost is
//! taken back.
//!
//! *Cost.* A few hundred nodes looked at per node and round, at most [`MOST_VISITS`]. The first round saves the most.
//!
//! *Source.* Bittner, Hapala & Havran 2013, *Fast Insertion-Based Optimization of Bounding Volume Hierarchies*; Meister &
//! Bittner 2018, *Parallel Reinsertion for Bounding Volume Hierarchy Optimization*.

use super::inner_area;
use super::lay_out::lay_out;
use crate::accel::Limits;
use crate::accel::bvh::tree::{BinaryNode, BinaryTree};
use crate::accel::limits::Site;
use crate::simd::exactly;
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// After so many nodes a search is content with what it has found: boxes that all overlap each other save little.
const MOST_VISITS: usize = 1024;
/// Searches between two looks at the clock.
const CHUNK: usize = 512;

/// Moves subtrees in up to `rounds` rounds, as long as that lowers the cost. For trees with and without primitives that
/// are cut.
pub fn reinsertion(tree: &mut BinaryTree, rounds: usize) {
    let site = Site::new(&Limits::NONE, 1);
    for _ in 0..rounds {
        if !exactly(|| round(tree, &site)) {
            break;
        }
    }
}

/// One round; whether it saved anything.
pub(super) fn round(tree: &mut BinaryTree, site: &Site<'_>) -> bool {
    // Brings pairs to odd places, so that a node's number names its sibling.
    lay_out(tree, |_| false);
    let before = inner_area(tree);
    let mut parents = alloc::vec![0_u32; tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate() {
        if !node.is_leaf() {
            for child in node.children() {
                parents[child] = i as u32;
            }
        }
    }
    let mut moves = find_all(&tree.nodes, &parents, site);
    if moves.is_empty() || site.is_over() {
        return false;
    }
    // The most saving first; no two leave from one place.
    moves.sort_unstable_by(|a, b| b.saved.total_cmp(&a.saved).then(a.from.cmp(&b.from)));
    let mut better = tree.clone();
    Surgery {
        nodes: &mut better.nodes,
        parents,
        touched: alloc::vec![false; tree.nodes.len()],
    }
    .make(&moves);
    lay_out(&mut better, |_| false);
    let saves = inner_area(&better) < before;
    if saves {
        *tree = better;
    }
    saves
}

/// A subtree that would be better off as the sibling of another one.
#[derive(Clone, Copy, Debug)]
struct Move {
    from: u32,
    to: u32,
    /// By how much the area of all inner nodes shrinks.
    saved: f32,
}

/// Bytes of a move.
pub(super) const MOVE_BYTES: usize = size_of::<Move>();

/// The other node of a pair.
#[inline(always)]
fn sibling(i: usize) -> usize {
    ((i - 1) ^ 1) + 1
}

fn find_all(nodes: &[BinaryNode], parents: &[u32], site: &Site<'_>) -> Vec<Move> {
    let find_some = |start: usize| {
        let mut found = Vec::new();
        let mut stack = Vec::new();
        let end = (start + CHUNK).min(nodes.len());
        if site.advance(end - start) {
            found.extend((start..end).filter_map(|from| find(nodes, parents, from, &mut stack)));
        }
        found
    };
    let chunks = nodes.len().saturating_sub(1).div_ceil(CHUNK);
    let start = |chunk: usize| 1 + chunk * CHUNK;
    #[cfg(feature = "parallel")]
    if chunks > 1 {
        let found: Vec<Vec<Move>> = (0..chunks)
            .into_par_iter()
            .exactly()
            .map(|chunk| find_some(start(chunk)))
            .collect();
        return found.concat();
    }
    (0..chunks)
        .flat_map(|chunk| find_some(start(chunk)))
        .collect()
}

/// The best other place for one node.
fn find(
    nodes: &[BinaryNode],
    parents: &[u32],
    from: usize,
    stack: &mut Vec<(f32, u32)>,
) -> Option<Move> {
    let area = |i: usize| nodes[i].bounds.half_area();
    let bounds = nodes[from].bounds;
    let own = bounds.half_area();
    let parent = parents[from] as usize;
    let mut best = Move {
        from: from as u32,
        to: 0,
        saved: 0.0,
    };
    // The parent goes away with the node; those above it, up to `above`, shrink.
    let mut saved = area(parent);
    let mut above = parent;
    let mut beside = sibling(from);
    // What `above` holds without the node.
    let mut rest = nodes[beside].bounds;
    let mut visits = 0;
    loop {
        stack.push((saved, beside as u32));
        while let Some((saved, i)) = stack.pop() {
            visits += 1;
            // Even if the new parent's box were no larger than the node's own.
            if !(saved - own > best.saved) || visits > MOST_VISITS {
                continue;
            }
            let node = &nodes[i as usize];
            let saved = saved - node.bounds.union(bounds).half_area();
            if saved > best.saved && i as usize != sibling(from) {
                (best.saved, best.to) = (saved, i);
            }
            if !node.is_leaf() {
                // Below it, it has to grow around both.
                let saved = saved + node.bounds.half_area();
                stack.extend(node.children().map(|child| (saved, child as u32)));
            }
        }
        if above == 0 {
            break;
        }
        if above != parent {
            saved += area(above) - rest.half_area();
        }
        beside = sibling(above);
        rest = rest.union(nodes[beside].bounds);
        above = parents[above] as usize;
    }
    (best.to != 0).then_some(best)
}

/// A tree whose subtrees are being moved.
struct Surgery<'a> {
    nodes: &'a mut [BinaryNode],
    parents: Vec<u32>,
    touched: Vec<bool>,
}

impl Surgery<'_> {
    fn make(&mut self, moves: &[Move]) {
        for step in moves {
            let (from, to) = (step.from as usize, step.to as usize);
            let involved = [
                from,
                to,
                sibling(from),
                self.parents[from] as usize,
                self.parents[to] as usize,
            ];
            // An earlier move may have brought the place below the node itself.
            if involved.iter().any(|&i| self.touched[i]) || self.is_below(to, from) {
                continue;
            }
            for i in involved {
                self.touched[i] = true;
            }
            self.reinsert(from, to);
        }
    }

    fn is_below(&self, mut i: usize, top: usize) -> bool {
        while i != 0 {
            if i == top {
                return true;
            }
            i = self.parents[i] as usize;
        }
        false
    }

    /// Makes `from` the sibling of `to`: its own sibling takes their parent's place, and the pair moves below `to`.
    fn reinsert(&mut self, from: usize, to: usize) {
        let (beside, parent) = (sibling(from), self.parents[from] as usize);
        let (target, stays) = (self.nodes[to], self.nodes[beside]);
        self.nodes[to].first = from.min(beside) as u32;
        self.nodes[to].count = 0;
        self.put(beside, target);
        self.put(parent, stays);
        self.parents[from] = to as u32;
        self.parents[beside] = to as u32;
        self.fit(to);
        self.fit(parent);
    }

    /// Puts a node into another place.
    fn put(&mut self, place: usize, node: BinaryNode) {
        self.nodes[place] = node;
        if !node.is_leaf() {
            for child in node.children() {
                self.parents[child] = place as u32;
            }
        }
    }

    /// Fits the boxes from a node up to the root.
    fn fit(&mut self, mut i: usize) {
        loop {
            if !self.nodes[i].is_leaf() {
                let [a, b] = self.nodes[i].children();
                self.nodes[i].bounds = self.nodes[a].bounds.union(self.nodes[b].bounds);
            }
            if i == 0 {
                return;
            }
            i = self.parents[i] as usize;
        }
    }
}
