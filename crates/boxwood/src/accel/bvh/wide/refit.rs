//! Follows primitives that have moved: who lies where stays as it is, all boxes are made anew.
//!
//! *How it works.* First each block of a leaf takes its triangles' corners from the mesh and finds the box around them, one
//! after the other as they lie in memory. Then the nodes, of which the children come after their parents: from the last to the first each
//! learns what is around it, and afterwards all take their children's boxes, in any order, so that threads may share both
//! greater parts of the work. What a ray is expected to pay falls out of the last step.
//!
//! Where a builder has cut primitives, each of their leaves grows around the whole primitive: every answer stays
//! right, but what the cuts had gained is lost.
//!
//! *Cost.* O(n), and 24 bytes for each block of a leaf and 32 for each node while it runs.
//!
//! *Source.* Wald, Boulos & Shirley 2007, *Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies*.

use super::WideBvh;
use super::node::{Child, Node};
use super::plan::NODE_COST;
use crate::geometry::Aabb;
use crate::geometry::frame::Frame;
use crate::primitive::Primitives;
use crate::query::each_pair;
use crate::simd::{Isa, Kernel, Lanes, Level, Simd, Vectorize, exactly};
use alloc::vec::Vec;

/// So many nodes are brought up to date by one thread at a time.
const CHUNK: usize = 256;

/// What is found out about a tree while it is fitted. Kept from frame to frame, it needs no new memory.
#[derive(Clone, Debug, Default)]
pub struct Fitting {
    /// Around each block of the leaves.
    blocks: Vec<Aabb>,
    /// Around each node.
    pub bounds: Vec<Aabb>,
    /// What a ray pays for opening each node's children, each as often as a ray comes there: times its half area.
    own: Vec<f64>,
}

impl<P: Primitives + Sync, const N: usize> WideBvh<P, N>
where
    Level: Vectorize<N>,
{
    /// Changes the primitives and follows them: moves the vertices of a mesh that the tree owns, or takes another mesh or set instead
    /// of one that is borrowed or shared. Returns what `change` returns.
    ///
    /// Primitive `i` must remain primitive `i` for the tree to stay good; answers are right in any case. After small
    /// movements the tree is as good as a new one; after large ones boxes overlap: [`Upkeep`](super::Upkeep) watches that, and does what pays.
    ///
    /// ```
    /// use boxwood::{Intersect, Ray, TriangleMesh, WideSah};
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
    /// let mut bvh = WideSah::<8>::default().build(mesh);
    /// bvh.update(|mesh| mesh.move_vertices(corners.map(|[x, y, _]| [x, y, 4.0])))?;
    /// let hit = bvh.closest_hit(&Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]));
    /// assert_eq!(hit.map(|hit| hit.t), Some(5.0));
    /// # Ok::<(), boxwood::MeshError>(())
    /// ```
    ///
    /// # Panics
    /// When there are fewer or more primitives afterwards.
    pub fn update<A>(&mut self, change: impl FnOnce(&mut P) -> A) -> A {
        let answer = self.change(change);
        self.fit(&mut Fitting::default());
        answer
    }

    /// Changes the primitives; the tree does not fit afterwards.
    pub(super) fn change<A>(&mut self, change: impl FnOnce(&mut P) -> A) -> A {
        let count = self.primitives.len();
        // They name parts of what there was.
        self.parts = Vec::new();
        let answer = change(&mut self.primitives);
        assert_eq!(self.primitives.len(), count, "a tree for other primitives");
        answer
    }

    /// Brings leaves, boxes and all that depends on them up to date.
    pub(super) fn fit(&mut self, found: &mut Fitting) {
        exactly(|| self.follow(found, Self::frame_of));
    }

    /// The same, with boxes seen from what a frame is chosen for the new bounds.
    pub(super) fn follow(&mut self, found: &mut Fitting, frame: impl FnOnce(&Aabb) -> Frame) {
        found.blocks.resize(self.leaves.len(), Aabb::EMPTY);
        found.bounds.resize(self.nodes.len(), Aabb::EMPTY);
        found.own.resize(self.nodes.len(), 0.0);
        (self.leaves).refit(&self.primitives, &mut found.blocks, self.isa);
        self.bounds = found
            .blocks
            .iter()
            .fold(Aabb::EMPTY, |b, &block| b.union(block));
        self.frame = frame(&self.bounds);
        found.place_leaves(&mut self.nodes, &self.frame);
        found.place_nodes(&mut self.nodes, &self.frame);
        found.finish(&mut self.nodes, self.isa);
    }
}

impl Fitting {
    /// What it takes for so many nodes and blocks.
    pub fn bytes(nodes: usize, blocks: usize) -> usize {
        blocks * size_of::<Aabb>() + nodes * (size_of::<Aabb>() + size_of::<f64>())
    }

    /// Of a tree that fits.
    pub fn weigh<const N: usize>(&mut self, nodes: &[Node<N>]) {
        self.own.clear();
        self.own.extend(nodes.iter().map(own));
        let around = |node: &Node<N>| node.slots().fold(Aabb::EMPTY, |b, (_, c, _)| b.union(c));
        self.bounds.clear();
        self.bounds.extend(nodes.iter().map(around));
    }

    /// What a ray pays below each node, each step as often as a ray comes there: times its half area. They are shown from the last to the
    /// first, with the boxes.
    pub fn costs<const N: usize>(
        &self,
        nodes: &[Node<N>],
        costs: &mut Vec<f64>,
        mut show: impl FnMut(usize, f64, &Aabb),
    ) {
        costs.clear();
        costs.extend_from_slice(&self.own);
        for (i, node) in nodes.iter().enumerate().rev() {
            let below: f64 = inner(node).map(|child| costs[child]).sum();
            costs[i] += below;
            show(i, costs[i], &self.bounds[i]);
        }
    }

    /// Gives all nodes the boxes of their leaves; what is around a node begins with these.
    fn place_leaves<const N: usize>(&mut self, nodes: &mut [Node<N>], frame: &Frame) {
        let blocks = &self.blocks;
        each_pair(CHUNK, nodes, &mut self.bounds, |_, nodes, bounds| {
            for (node, bounds) in nodes.iter_mut().zip(bounds) {
                *bounds = Aabb::EMPTY;
                for lane in 0..N {
                    let child = node.child(lane);
                    if child.is_leaf() && child != Child::NOTHING {
                        let leaf = around(blocks, child);
                        node.set_bounds(lane, &frame.seen(&leaf));
                        *bounds = bounds.union(leaf);
                    }
                }
            }
        });
    }

    /// Gives all nodes the boxes of the nodes below, from the last to the first.
    fn place_nodes<const N: usize>(&mut self, nodes: &mut [Node<N>], frame: &Frame) {
        for (i, node) in nodes.iter_mut().enumerate().rev() {
            let mut bounds = self.bounds[i];
            for lane in 0..N {
                let child = node.child(lane);
                if !child.is_leaf() {
                    debug_assert!(child.index() > i, "parents come first");
                    let below = self.bounds[child.index()];
                    node.set_bounds(lane, &frame.seen(&below));
                    bounds = bounds.union(below);
                }
            }
            self.bounds[i] = bounds;
        }
    }

    /// What follows from a node's boxes.
    fn finish<const N: usize>(&mut self, nodes: &mut [Node<N>], isa: Isa)
    where
        Level: Vectorize<N>,
    {
        each_pair(CHUNK, nodes, &mut self.own, |_, nodes, own| {
            isa.level().vectorize(Finish { nodes, own });
        });
    }
}

/// Around the blocks of a leaf.
#[inline(always)]
fn around(blocks: &[Aabb], leaf: Child) -> Aabb {
    let blocks = blocks.get(leaf.blocks()).unwrap_or(&[]);
    blocks.iter().fold(Aabb::EMPTY, |b, &block| b.union(block))
}

struct Finish<'a, const N: usize> {
    nodes: &'a mut [Node<N>],
    own: &'a mut [f64],
}

impl<const N: usize> Kernel<N> for Finish<'_, N> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, _: S) {
        for (node, own) in self.nodes.iter_mut().zip(self.own) {
            node.set_order();
            *own = self::own(node);
        }
    }
}

/// What opening a node's children costs, each as often as a ray comes there.
#[inline(always)]
fn own<const N: usize>(node: &Node<N>) -> f64 {
    let areas = node.half_areas();
    let mut own = 0.0;
    for (lane, area) in areas.iter().enumerate() {
        let child = node.child(lane);
        let cost = if child.is_leaf() {
            child.blocks().len() as f64
        } else {
            f64::from(NODE_COST)
        };
        own += area * cost;
    }
    own
}

/// The nodes below a node.
pub fn inner<const N: usize>(node: &Node<N>) -> impl Iterator<Item = usize> {
    let children = node.children().iter().map(|&child| Child(child));
    children.filter(|child| !child.is_leaf()).map(Child::index)
}
