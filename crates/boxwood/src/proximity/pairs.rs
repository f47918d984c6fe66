//! Tree against tree: which triangles of one mesh meet which of another.
//!
//! *How it works.* Both trees are walked down together; pairs of nodes whose boxes do not meet are left out with all below
//! them. What is left are pairs of leaves, whose triangles are held against each other by a test that is never wrong. So two
//! shells that touch in one point are found to touch, and shells a rounding apart are not.
//!
//! *Cost.* O(log n + k) for surfaces that meet in `k` pairs, as long as they are not nearly parallel throughout.
//!
//! *Source.* Gottschalk, Lin & Manocha 1996, *OBBTree: A Hierarchical Structure for Rapid Interference Detection*.

use super::hierarchy::{Extent, Hierarchy, Opened};
use crate::geometry::Vec3;
use crate::geometry::triangle::contact;
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Break, Continue};

/// A node and its box; none for the root, which is always opened.
type Place<N> = (N, Option<Extent>);

/// Shows every pair of triangles of two trees that share a point, in no particular order and perhaps some of them twice.
pub(super) fn meetings<A: Hierarchy, B: Hierarchy>(
    a: &A,
    b: &B,
    mut show: impl FnMut(u32, u32) -> ControlFlow<()>,
) {
    let (Some(root_a), Some(root_b)) = (a.root(), b.root()) else {
        return;
    };
    let apart = |a: &Option<Extent>, b: &Option<Extent>| {
        let both = a.as_ref().zip(b.as_ref());
        both.is_some_and(|(a, b)| !a.overlaps(b))
    };
    let mut open = Vec::from([((root_a, None), (root_b, None))]);
    let (mut below_a, mut below_b) = (Vec::new(), Vec::new());
    let (mut triangles_a, mut triangles_b) = (Vec::new(), Vec::new());
    while let Some((of_a, of_b)) = open.pop() {
        // A leaf stays where it is while the other tree is walked down.
        below_a.clear();
        below_b.clear();
        let leaf_a = opened(a, of_a, &mut below_a, &mut triangles_a);
        let leaf_b = opened(b, of_b, &mut below_b, &mut triangles_b);
        if leaf_a && leaf_b {
            if meet_all(&triangles_a, &triangles_b, &mut show).is_break() {
                return;
            }
            continue;
        }
        for child_a in &below_a {
            for child_b in &below_b {
                if !apart(&child_a.1, &child_b.1) {
                    open.push((*child_a, *child_b));
                }
            }
        }
    }
}

/// A triangle with its box and its number.
type Boxed = (Extent, [Vec3; 3], u32);

/// Collects what is below a node: its children, or itself and its triangles where it is a leaf.
fn opened<H: Hierarchy>(
    tree: &H,
    of: Place<H::Node>,
    below: &mut Vec<Place<H::Node>>,
    triangles: &mut Vec<Boxed>,
) -> bool {
    match tree.open(of.0) {
        Opened::Inner(children) => {
            let slack = tree.slack();
            below
                .extend(children.map(|(bounds, child)| (child, Some(Extent::new(&bounds, slack)))));
            false
        }
        Opened::Leaf(ids) => {
            triangles.clear();
            triangles.extend(ids.map(|(id, corners)| (Extent::of(corners), corners, id)));
            below.push(of);
            true
        }
    }
}

fn meet_all(
    a: &[Boxed],
    b: &[Boxed],
    show: &mut impl FnMut(u32, u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    for (around, s, i) in a {
        for (near, t, k) in b {
            if around.overlaps(near) && contact::meet(*s, *t) {
                show(*i, *k)?;
            }
        }
    }
    Continue(())
}

/// All pairs, in ascending order, each once.
pub(super) fn all(a: &impl Hierarchy, b: &impl Hierarchy) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    meetings(a, b, |i, k| {
        pairs.push([i, k]);
        Continue(())
    });
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Whether there is any.
pub(super) fn any(a: &impl Hierarchy, b: &impl Hierarchy) -> bool {
    let mut found = false;
    meetings(a, b, |_, _| {
        found = true;
        Break(())
    });
    found
}
