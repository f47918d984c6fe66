//! Parts of a wide tree made anew, in their places.
//!
//! *How it works.* The primitives below a node are given to the builder as a set of their own, and what it makes is collapsed like a
//! whole tree. Then the tree is copied: node by node from the old one, and where a part was made anew, from that. So there are no
//! gaps to keep account of, parents come before their children, and what lies together in the tree lies together in memory.
//!
//! *Cost.* That of building the parts, and 120 bytes read and written for each triangle of the whole.

use super::collapse::{Wide, collapse};
use super::leaf::Leaves;
use super::node::{Child, Node};
use super::{WideBvh, WideSah};
use crate::accel::BuildError;
use crate::accel::bvh::MAX_DEPTH;
use crate::accel::limits::{Limits, Site};
use crate::geometry::{Aabb, PreparedRay, Vec3};
use crate::primitive::{Primitives, bounds_of};
use crate::query::{Counters, Query};
use crate::simd::{Level, Pages, Vectorize};
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// Some of a set's primitives.
struct Part<'a, P> {
    all: &'a P,
    ids: &'a [u32],
}

impl<P: Primitives> Primitives for Part<'_, P> {
    fn len(&self) -> usize {
        self.ids.len()
    }
    fn bounds(&self, i: usize) -> Aabb {
        self.all.bounds(self.ids[i] as usize)
    }
    fn corners(&self, i: usize) -> Option<[Vec3; 3]> {
        self.all.corners(self.ids[i] as usize)
    }
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        let id = self.ids[i] as usize;
        self.all.offer(id, ray, query, counters)
    }
}

/// The number of a node that was not there before.
pub const NEW: u32 = u32::MAX;

impl<P: Primitives + Sync, const N: usize> WideBvh<P, N>
where
    Level: Vectorize<N>,
{
    /// Takes other primitives, for which the tree must then be built anew.
    pub(super) fn replace(&mut self, primitives: P) {
        self.primitives = primitives;
    }

    /// Builds the tree anew.
    ///
    /// # Errors
    /// When there are too many primitives.
    pub(super) fn rebuild(&mut self, builder: &WideSah<N>) -> Result<(), BuildError> {
        self.bounds = bounds_of(&self.primitives);
        self.frame = Self::frame_of(&self.bounds);
        let ids: Vec<u32> = (0..self.primitives.len() as u32).collect();
        let whole = self.build_part(builder, &ids)?;
        self.become_of(whole);
        self.cut = false;
        Ok(())
    }

    /// Builds the subtrees of some nodes anew, none of which lies below another one, and says which number each node had before, and how
    /// many primitives are in them. `None`, and all is as it was, where the tree would become too deep.
    ///
    /// # Errors
    /// When there are too many primitives.
    pub(super) fn rebuild_parts(
        &mut self,
        builder: &WideSah<N>,
        at: &[u32],
    ) -> Result<Option<(Vec<u32>, usize)>, BuildError> {
        let mut parts = Vec::with_capacity(at.len());
        let (mut ids, mut primitives) = (Vec::new(), 0);
        for &node in at {
            self.primitives_below(node, &mut ids);
            primitives += ids.len();
            parts.push((node, self.build_part(builder, &ids)?));
        }
        parts.sort_unstable_by_key(|&(node, _)| node);
        let all = || parts.iter().map(|(_, part)| part);
        let nodes = self.nodes.len() + all().map(|part| part.nodes.len()).sum::<usize>();
        let blocks = self.leaves.len() + all().map(|part| part.leaves.len()).sum::<usize>();
        let mut graft = Graft {
            old: self,
            parts: &parts,
            nodes: Pages::with_room(nodes),
            leaves: Leaves::with_capacity(P::TRIANGLES, blocks),
            before: Vec::with_capacity(self.nodes.len()),
            depth: 0,
        };
        let root = graft.copy_root();
        let Graft {
            nodes,
            leaves,
            before,
            depth,
            ..
        } = graft;
        if depth > MAX_DEPTH {
            return Ok(None);
        }
        self.become_of(Wide {
            root,
            nodes,
            leaves,
            depth,
        });
        Ok(Some((before, primitives)))
    }

    fn become_of(&mut self, whole: Wide<N>) {
        self.root = whole.root;
        self.nodes = whole.nodes;
        self.leaves = whole.leaves;
        self.parts = Vec::new();
        self.depth = whole.depth;
    }

    /// The primitives below a node, ascending and each once.
    fn primitives_below(&self, node: u32, ids: &mut Vec<u32>) {
        ids.clear();
        let mut open = Vec::from([Child(node)]);
        while let Some(child) = open.pop() {
            if child.is_leaf() {
                ids.extend(self.leaves.ids(child.blocks()));
            } else {
                open.extend(self.nodes[child.index()].slots().map(|(_, _, below)| below));
            }
        }
        ids.sort_unstable();
        ids.dedup();
    }

    fn build_part(&self, builder: &WideSah<N>, ids: &[u32]) -> Result<Wide<N>, BuildError> {
        let all = &self.primitives;
        let mut tree = builder.binary::<P>().build(&Part { all, ids });
        for place in &mut tree.order {
            *place = ids[*place as usize];
        }
        let site = Site::new(&Limits::NONE, tree.nodes.len());
        let most = Self::MOST_IN_LEAF;
        collapse(all, &tree, &self.frame, most, builder.gathering, &site)
    }
}

/// The copy on its way.
struct Graft<'a, P, const N: usize> {
    old: &'a WideBvh<P, N>,
    /// By their nodes, ascending.
    parts: &'a [(u32, Wide<N>)],
    nodes: Pages<Node<N>>,
    leaves: Leaves,
    /// For each node, its number in the old tree.
    before: Vec<u32>,
    depth: usize,
}

/// Where a child comes from.
#[derive(Clone, Copy)]
struct Source<'a, const N: usize> {
    nodes: &'a [Node<N>],
    leaves: &'a Leaves,
    /// Not made anew.
    old: bool,
}

impl<'a, P, const N: usize> Graft<'a, P, N> {
    fn copy_root(&mut self) -> Child {
        let from = Source {
            nodes: &self.old.nodes,
            leaves: &self.old.leaves,
            old: true,
        };
        let (from, child) = self.instead(from, self.old.root);
        let root = self.place(from, child);
        if !root.is_leaf() {
            self.open(from, child, root.index(), 1);
        }
        root
    }

    /// The part that was made anew instead of a child, or that child.
    fn instead(&self, from: Source<'a, N>, child: Child) -> (Source<'a, N>, Child) {
        let part = self.parts.binary_search_by_key(&child.0, |&(node, _)| node);
        match part {
            Ok(place) if from.old => {
                let part = &self.parts[place].1;
                let from = Source {
                    nodes: &part.nodes,
                    leaves: &part.leaves,
                    old: false,
                };
                (from, part.root)
            }
            _ => (from, child),
        }
    }

    /// Copies a leaf, or makes a place for a node.
    fn place(&mut self, from: Source<'_, N>, child: Child) -> Child {
        if child == Child::NOTHING {
            return child;
        }
        if child.is_leaf() {
            let blocks = self.leaves.push_copy(from.leaves, child.blocks());
            return Child::leaf(blocks.start, blocks.len());
        }
        self.nodes.push(from.nodes[child.index()]);
        self.before.push(if from.old { child.0 } else { NEW });
        Child::node(self.nodes.len() - 1)
    }

    /// Copies what is below a node, whose own copy lies at a place. At most as many levels as two trees have.
    fn open(&mut self, from: Source<'a, N>, node: Child, at: usize, depth: usize) {
        self.depth = self.depth.max(depth);
        let children = *from.nodes[node.index()].children();
        let below: [_; N] = core::array::from_fn(|lane| self.instead(from, Child(children[lane])));
        for (lane, &(from, child)) in below.iter().enumerate() {
            let placed = self.place(from, child);
            self.nodes[at].set_child(lane, placed);
        }
        for (lane, &(from, child)) in below.iter().enumerate() {
            if !child.is_leaf() {
                let placed = self.nodes[at].child(lane);
                self.open(from, child, placed.index(), depth + 1);
            }
        }
    }
}
