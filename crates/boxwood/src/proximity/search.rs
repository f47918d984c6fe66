//! The one walk down a tree.

use super::hierarchy::{Extent, Hierarchy, Opened};
use crate::geometry::Vec3;
use crate::query::Counters;
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// A question about space: which boxes count, and what to make of a triangle.
///
/// Boxes and triangles are given a score, a distance for example. Everything that scores more than [`Search::limit`] does
/// not count, and the limit may fall as better ones are found.
pub trait Search {
    /// Whether children of lower score should be visited first. Only a hint: the answer is the same without.
    const ORDERED: bool = true;
    /// What scores more does not count any more; never grows.
    fn limit(&self) -> f64;
    /// A score that nothing in the box falls short of; infinite or NaN where nothing in it counts. `node` is the number of
    /// the node whose box it is.
    fn score(&mut self, around: &Extent, node: usize) -> f64;
    /// Looks at a triangle in the leaf with number `node`; `Break` ends the search. Trees that cut triangles may show the same again.
    fn offer(&mut self, primitive: u32, corners: [Vec3; 3], node: usize) -> ControlFlow<()>;
}

/// Walks down a tree, depth first, the child with the lowest score next.
///
/// It relies on the float mode that Rust takes for granted: call it within [`exactly`](crate::exactly) where threads may be in
/// another one. [`Proximity`](super::Proximity) always does.
pub fn search<H: Hierarchy, S: Search, C: Counters>(tree: &H, question: &mut S, counters: &mut C) {
    search_with(tree, question, counters, &mut Vec::new());
}

/// The same with an empty stack from elsewhere.
pub(super) fn search_with<H: Hierarchy, S: Search, C: Counters>(
    tree: &H,
    question: &mut S,
    counters: &mut C,
    stack: &mut Vec<(f64, H::Node)>,
) {
    stack.clear();
    let slack = tree.slack();
    // Whatever counts is in the root; its box is not looked at.
    let mut next = tree.root();
    while let Some(node) = next {
        match tree.open(node) {
            Opened::Leaf(primitives) => {
                counters.leaf();
                let number = tree.number(node);
                for (id, corners) in primitives {
                    counters.primitives(1);
                    if question.offer(id, corners, number).is_break() {
                        return;
                    }
                }
            }
            Opened::Inner(children) => {
                counters.node();
                let from = stack.len();
                for (bounds, child) in children {
                    let score = question.score(&Extent::new(&bounds, slack), tree.number(child));
                    // NaN fails, and infinity may be the limit.
                    if score <= question.limit() && score < f64::INFINITY {
                        stack.push((score, child));
                    }
                }
                if S::ORDERED {
                    far_to_near(&mut stack[from..]);
                }
            }
        }
        next = loop {
            match stack.pop() {
                None => break None,
                Some((score, node)) if score <= question.limit() => break Some(node),
                Some(_) => {}
            }
        };
    }
}

/// Few and nearly sorted: insertion is fastest.
#[inline(always)]
fn far_to_near<N: Copy>(entries: &mut [(f64, N)]) {
    for i in 1..entries.len() {
        let entry = entries[i];
        let mut k = i;
        while k > 0 && entries[k - 1].0 < entry.0 {
            entries[k] = entries[k - 1];
            k -= 1;
        }
        entries[k] = entry;
    }
}
