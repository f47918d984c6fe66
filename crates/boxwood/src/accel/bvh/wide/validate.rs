//! Whether a wide tree is whole: that every ray gets the judge's answer, whoever made the tree.
//!
//! *How it works.* Children come after their parents and have one each, so there is no cycle; every box holds the boxes below it, every
//! leaf's box its primitives, every block the corners that its triangles have in the mesh, and every primitive is in one leaf.
//! From that follow the answers: all other numbers only say what comes first. Nodes are looked at by all threads.
//!
//! *Cost.* O(n): each node is read twice, each triangle once; a bit for each node, block and primitive.

use super::WideBvh;
use super::leaf::{Leaves, NONE};
use super::node::Child;
use crate::accel::bvh::MAX_DEPTH;
use crate::geometry::{Aabb, cover};
use crate::inspect::TreeFlaw;
use crate::pieces;
use crate::primitive::Primitives;
use crate::proximity::slack_of_cut;
use crate::simd::exactly;
use alloc::vec;
use alloc::vec::Vec;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Nodes in a piece of work.
const PIECE: usize = 512;

impl<P: Primitives + Sync, const N: usize> WideBvh<P, N> {
    /// Looks at all of the tree, in the caller's rayon pool: answers are those of the exhaustive test where nothing is found. That is
    /// so for trees of this crate's builders; [`WideBvh::open`] asks it of files.
    ///
    /// Of triangles that are cut and lie in several leaves, no part may be missing, and none of the box of anything else. Only of primitives
    /// that are no triangles and yet promise to be [within the slack](Primitives::WITHIN_SLACK), the parts remain the builder's promise, as
    /// they do for [`inspect::validate`](crate::inspect::validate), and so do those of [opened objects](WideBvh::has_parts).
    ///
    /// # Errors
    /// The first flaw found.
    pub fn validate(&self) -> Result<(), TreeFlaw> {
        let (nodes, blocks) = (self.nodes.len(), self.leaves.len());
        let marks = Marks {
            nodes: Bits::new(nodes),
            blocks: Bits::new(blocks),
            primitives: Bits::new(self.primitives.len()),
        };
        let mut seen = exactly(|| self.root(&marks))?;
        for piece in pieces::each(nodes.div_ceil(PIECE), |piece| {
            let mut seen = Seen::NOTHING;
            for node in piece * PIECE..nodes.min((piece + 1) * PIECE) {
                self.node(node, &marks, &mut seen)?;
            }
            Ok(seen)
        }) {
            seen = seen.and(&piece?);
        }
        marks
            .nodes
            .all_set(|node| TreeFlaw::Parents { node, parents: 0 })?;
        marks
            .blocks
            .all_set(|place| TreeFlaw::Place { place, leaves: 0 })?;
        (marks.primitives).all_set(|primitive| TreeFlaw::Times {
            primitive,
            times: 0,
        })?;
        let whole = |is: bool, what| is.then_some(()).ok_or(TreeFlaw::Whole { what });
        // Parts of all that were cut may have come together in their leaves.
        whole(self.cut || seen.places == self.primitives.len(), "cut")?;
        // Rays and their slack go by these: those of the judge, no others.
        whole(self.bounds == seen.around, "bounds")?;

        whole(self.depth == self.depth_of_nodes(), "depth")?;
        if self.depth > MAX_DEPTH {
            return Err(TreeFlaw::TooDeep { node: 0 });
        }
        // What parts of objects there are, their own structures have said; files cannot name any.
        if self.cut && !self.has_parts() {
            exactly(|| self.validate_parts())?;
        }
        Ok(())
    }

    /// Node 0, a leaf of all blocks, or nothing.
    fn root(&self, marks: &Marks) -> Result<Seen, TreeFlaw> {
        let mut seen = Seen::NOTHING;
        let is_root = match (self.nodes.len(), self.leaves.len()) {
            (0, 0) => self.root == Child::NOTHING,
            (0, _) => self.root.is_leaf() && self.root != Child::NOTHING,
            _ => self.root == Child::node(0),
        };
        if !is_root {
            return Err(TreeFlaw::Whole { what: "root" });
        }
        if !self.nodes.is_empty() {
            marks.nodes.set(0);
            self.boxes_below(0, &self.frame.seen(&self.bounds), 0)?;
        } else if self.root != Child::NOTHING {
            let bounds = self.frame.seen(&self.bounds);
            self.leaf(0, &bounds, self.root, marks, &mut seen)?;
        }
        Ok(seen)
    }

    /// A node, the boxes of the nodes below, and its leaves.
    fn node(&self, index: usize, marks: &Marks, seen: &mut Seen) -> Result<(), TreeFlaw> {
        let node = &self.nodes[index];
        if !node.is_ordered() || !node.is_closed() {
            return Err(TreeFlaw::Node { node: index });
        }
        for (_, bounds, child) in node.slots() {
            if child.is_leaf() {
                self.leaf(index, &bounds, child, marks, seen)?;
                continue;
            }
            let below = child.index();
            if below >= self.nodes.len() {
                return Err(TreeFlaw::Dangling { node: index });
            }
            if below == 0 {
                return Err(TreeFlaw::Root { node: index });
            }
            // Parents come first, so that nothing is its own grandparent.
            if below <= index || marks.nodes.set(below) {
                return Err(TreeFlaw::Parents {
                    node: below,
                    parents: 2,
                });
            }
            self.boxes_below(below, &bounds, index)?;
        }
        Ok(())
    }

    /// Whether the box in which a node lies holds all of the node's own.
    fn boxes_below(&self, index: usize, around: &Aabb, parent: usize) -> Result<(), TreeFlaw> {
        if (self.nodes[index].slots()).all(|(_, bounds, _)| around.contains(&bounds)) {
            Ok(())
        } else {
            Err(TreeFlaw::SticksOut { node: parent })
        }
    }

    fn leaf(
        &self,
        node: usize,
        around: &Aabb,
        leaf: Child,
        marks: &Marks,
        seen: &mut Seen,
    ) -> Result<(), TreeFlaw> {
        let blocks = leaf.blocks();
        if blocks.end > self.leaves.len() {
            return Err(TreeFlaw::Dangling { node });
        }
        let mut before = None;
        for block in blocks.clone() {
            if marks.blocks.set(block) {
                return Err(TreeFlaw::Place {
                    place: block,
                    leaves: 2,
                });
            }
            let places = self.leaves.places(block);
            let count = places.iter().take_while(|&&id| id != NONE).count();
            let (ids, rest) = places.split_at(count);
            let is_full = count == Leaves::LANES || (count > 0 && block + 1 == blocks.end);
            if !is_full || rest.iter().any(|&id| id != NONE) {
                return Err(TreeFlaw::Block { block });
            }
            for &id in ids {
                let primitive = id as usize;
                if primitive >= self.primitives.len() {
                    return Err(TreeFlaw::Dangling { node });
                }
                // Of equal hits the first one counts.
                if before.replace(id) >= Some(id) {
                    return Err(TreeFlaw::Block { block });
                }
                if marks.primitives.set(primitive) && !self.cut {
                    return Err(TreeFlaw::Times {
                        primitive,
                        times: 2,
                    });
                }
                let bounds = self.primitives.bounds(primitive);
                let own = self.frame.seen(&bounds);
                let holds = if self.cut {
                    bounds.is_empty() || !around.intersection(own).is_empty()
                } else {
                    around.contains(&own)
                };
                if !holds {
                    return Err(TreeFlaw::SticksOut { node });
                }
                seen.around = seen.around.union(bounds);
            }
            seen.places += count;
            if !self.leaves.is_of(&self.primitives, block, ids) {
                return Err(TreeFlaw::Block { block });
            }
        }
        Ok(())
    }

    /// How many nodes lie above the deepest leaf, where children come after their parents.
    fn depth_of_nodes(&self) -> usize {
        let mut depths = vec![0_u32; self.nodes.len()];
        let mut deepest = 0;
        for (index, node) in self.nodes.iter().enumerate() {
            let depth = depths[index] + 1;
            deepest = deepest.max(depth);
            for &child in node.children() {
                if !Child(child).is_leaf() {
                    depths[child as usize] = depth;
                }
            }
        }
        deepest as usize
    }

    /// Whether the leaves of each primitive together hold all of it.
    fn validate_parts(&self) -> Result<(), TreeFlaw> {
        let mut leaves = Vec::with_capacity(self.leaves.len() * Leaves::LANES);
        for (_, bounds, child) in self.nodes.iter().flat_map(|node| node.slots()) {
            if child.is_leaf() {
                let bounds = self.frame.in_world(&bounds);
                leaves.extend(self.leaves.ids(child.blocks()).map(|id| (id, bounds)));
            }
        }
        leaves.sort_by_key(|&(id, _)| id);
        let runs: Vec<_> = leaves.chunk_by(|a, b| a.0 == b.0).collect();
        let flaws = pieces::each(runs.len().div_ceil(PIECE), |piece| {
            let runs = &runs[piece * PIECE..runs.len().min((piece + 1) * PIECE)];
            let mut parts = Vec::new();
            runs.iter().find_map(|run| {
                parts.clear();
                parts.extend(run.iter().map(|&(_, bounds)| bounds));
                let primitive = run[0].0 as usize;
                let held = self.is_held(primitive, &parts);
                (!held).then_some(TreeFlaw::Uncovered { primitive })
            })
        });
        flaws.into_iter().flatten().next().map_or(Ok(()), Err)
    }

    fn is_held(&self, primitive: usize, parts: &[Aabb]) -> bool {
        let bounds = self.primitives.bounds(primitive);
        let around = parts.iter().fold(Aabb::EMPTY, |a, &b| a.union(b));
        if !around.contains(&bounds) {
            return false;
        }
        if parts.len() == 1 {
            return true;
        }
        match self.primitives.corners(primitive) {
            Some(corners) if P::WITHIN_SLACK => {
                cover::holds_triangle(parts, corners, slack_of_cut(self.frame.scale))
            }
            // Its own way of being cut: what it says of its parts was asked when the tree was built.
            _ if P::WITHIN_SLACK => true,
            _ => cover::holds_box(parts, &bounds),
        }
    }
}

/// What lies in some leaves.
struct Seen {
    /// Places with a primitive.
    places: usize,
    /// Around all of them.
    around: Aabb,
}

impl Seen {
    const NOTHING: Self = Self {
        places: 0,
        around: Aabb::EMPTY,
    };

    fn and(&self, other: &Self) -> Self {
        Self {
            places: self.places + other.places,
            around: self.around.union(other.around),
        }
    }
}

/// What has been named.
struct Marks {
    nodes: Bits,
    blocks: Bits,
    primitives: Bits,
}

/// A row of bits that threads set together.
struct Bits {
    words: Vec<AtomicU32>,
    len: usize,
}

impl Bits {
    fn new(len: usize) -> Self {
        let words = (0..len.div_ceil(32)).map(|_| AtomicU32::new(0)).collect();
        Self { words, len }
    }
    /// Sets a bit; whether it was set before.
    fn set(&self, i: usize) -> bool {
        let bit = 1 << (i % 32);
        self.words[i / 32].fetch_or(bit, Relaxed) & bit != 0
    }
    /// What `flaw` says of the first bit that is not set.
    fn all_set(&self, flaw: impl Fn(usize) -> TreeFlaw) -> Result<(), TreeFlaw> {
        let words = self.words.iter().map(|word| word.load(Relaxed));
        let unset = (0..)
            .zip(words)
            .find(|&(_, bits)| bits != u32::MAX)
            .map(|(word, bits): (usize, _)| 32 * word + bits.trailing_ones() as usize);
        match unset {
            Some(i) if i < self.len => Err(flaw(i)),
            _ => Ok(()),
        }
    }
}
