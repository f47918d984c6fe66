//! Nodes with 8 or 16 children, all met at once.
//!
//! *How it works.* `collapse` makes `N` children of two, at the least expected cost; `node` holds eight rows of `N` words and
//! meets its boxes in lanes; `leaf` holds triangles lane by lane, or numbers of anything else; `traverse` is the one loop,
//! compiled for every instruction set, and `scalar` the same box by box; `braid` opens placed objects that overlap; `job` says before a build which quality
//! it is worth; `hierarchy` shows the nodes to questions about space;
//! `saved` puts trees into files, and `validate` looks at those that come from there.
//!
//! Nodes and leaves lie in one of two ways (`layout`): as `boxes` of floats and corners, or `quantised` and as numbers; all that walks knows of it
//! is a type.
//!
//! Boxes of triangles are stored as seen from the middle of a scene that stands far from the world's origin (`geometry/frame.rs`); triangles
//! stay in the world, where all structures meet them.
//!
//! *Cost.* About 15 bytes of nodes and 45 of leaves for each triangle of a mesh; 16 and 6 for each of other primitives. Compact, 6 and 5 for each of
//! either.
//!
//! *Source.* Dammertz, Hanika & Keller 2008; Wald, Benthin & Boulos 2008; Ernst & Greiner 2008; Ylitie, Karras & Laine 2017
//! (octant order, collapse).

mod batch;
mod boxes;
mod braid;
mod build;
mod collapse;
mod compact;
mod gathering;
mod graft;
mod hierarchy;
mod job;
mod layout;
mod leaf;
mod motion;
mod node;
mod packet;
mod plan;
mod precision;
mod quality;
mod quantised;
mod refit;
mod saved;
mod scalar;
mod traverse;
mod tree;
mod upkeep;
mod validate;

pub use build::WideSah;
pub use compact::CompactSah;
pub use gathering::{Gathering, UnknownGathering};
pub use job::{Forecast, Job, Survey};
pub use layout::{Compact, CompactBvh, Full, Layout};
pub use motion::MotionBvh;
pub use precision::{Precision, UnknownPrecision};
pub use quality::{Quality, UnknownQuality};
#[doc(hidden)]
pub use saved::seal;
pub use saved::{OpenError, SavedError};
pub use upkeep::{Decision, Updated, Upkeep};

use crate::accel::BuildError;
use crate::accel::bvh::refine;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::{Limits, Site, unlimited};
use crate::geometry::frame::Frame;
use crate::geometry::triangle::block::{BlockRay, Stop};
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{self, Cell, Statistics, TreeFlaw};
use crate::primitive::{self, PARTS_SLACK, Primitives};
use crate::query::{Counters, Part, Query, Traverse};
use crate::simd::{Isa, Lanes, Level, Pages, Portable, Vectorize, exactly};
use alloc::vec::Vec;
use boxes::Boxes;
use collapse::{Wide, collapse};
use core::mem;
use core::ops::ControlFlow::{self, Break};
use leaf::Leaves;
use node::{Child, Node};
use packet::Outcome;

/// A hierarchy of nodes with `N` children (8 or 16) over owned, borrowed or shared primitives.
///
/// How it lies in memory is its [`Layout`]: [`Full`], the fast way, unless the type says [`Compact`]; see [`CompactBvh`].
///
/// It runs on the best instruction set of the machine, or the one named by the environment variable `BOXWOOD_ISA`; nodes
/// and answers do not depend on it, but for those of [`Precision::Fast`].
///
/// ```
/// use boxwood::{Proximity, TriangleMesh, WideBvh, WideSah};
/// use std::sync::Arc;
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
/// let builder = WideSah::<8>::default();
///
/// let borrowed: WideBvh<&TriangleMesh, 8> = builder.build(&mesh);
/// assert_eq!(borrowed.within([0.0; 3], 1.0).len(), 1);
///
/// // No vertex is copied: two trees and whoever else holds it have one mesh.
/// let mesh = Arc::new(mesh);
/// let shared: WideBvh<Arc<TriangleMesh>, 8> = builder.build(mesh.clone());
/// let wider: WideBvh<Arc<TriangleMesh>, 16> = WideSah::default().build(mesh.clone());
/// assert!(Arc::ptr_eq(shared.primitives(), wider.primitives()));
///
/// drop((shared, wider));
/// let owned: WideBvh<TriangleMesh, 8> = builder.build(Arc::unwrap_or_clone(mesh));
/// assert_eq!(owned.primitives().triangles().len(), 1);
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub struct WideBvh<P, const N: usize, L: Layout = Full> {
    primitives: P,
    bounds: Aabb,
    /// What the boxes of nodes are seen from.
    frame: Frame,
    root: Child,
    nodes: Pages<Node<N, L::Boxes<N>>>,
    leaves: Leaves,
    /// Whether some primitives lie in several leaves, each of which holds a part of them.
    cut: bool,
    /// Which part of its primitive each block of the leaves holds, where primitives were opened; else nothing.
    parts: Vec<Part>,
    isa: Isa,
    precision: Precision,
    /// How many nodes lie above the deepest leaf.
    depth: usize,
}

impl<P: Primitives + Sync, const N: usize> WideBvh<P, N>
where
    Level: Vectorize<N>,
{
    /// Lays a tree out that a builder of this crate made for these primitives.
    ///
    /// # Panics
    /// When the tree is for fewer or more primitives, has larger leaves than [`MAX_LEAF`](crate::accel::bvh::MAX_LEAF), or
    /// more than a quarter of a billion primitives. See [`WideBvh::checked`] for trees from elsewhere.
    pub fn new(primitives: P, tree: &BinaryTree) -> Self {
        unlimited(Self::within(
            primitives,
            tree,
            Gathering::Optimal,
            &Limits::NONE,
        ))
    }

    /// Takes a tree from anywhere, and looks at all of it first.
    ///
    /// # Errors
    /// The first flaw that [`inspect::validate`] finds.
    pub fn checked(primitives: P, tree: &BinaryTree) -> Result<Self, TreeFlaw> {
        inspect::validate(tree, &primitives)?;
        Ok(Self::new(primitives, tree))
    }
}

impl<P: Primitives + Sync, const N: usize, L: Layout> WideBvh<P, N, L>
where
    Level: Vectorize<N>,
{
    fn within(
        primitives: P,
        tree: &BinaryTree,
        gathering: Gathering,
        limits: &Limits<'_>,
    ) -> Result<Self, BuildError> {
        exactly(|| Self::laid_out(primitives, tree, gathering, limits))
    }

    fn laid_out(
        primitives: P,
        tree: &BinaryTree,
        gathering: Gathering,
        limits: &Limits<'_>,
    ) -> Result<Self, BuildError> {
        let most = tree.order.iter().max().map_or(0, |&id| id as usize + 1);
        let fits = most == primitives.len() && tree.nodes.is_empty() == tree.order.is_empty();
        assert!(fits, "a tree for other primitives");
        let laid_out;
        let tree = if tree.is_depth_first() {
            tree
        } else {
            laid_out = refine::depth_first(tree.clone());
            &laid_out
        };
        // Every node is looked at twice: when it is weighed, and when it finds its place.
        let site = Site::new(limits, tree.nodes.len());
        // Where there is no room for it, the build is over, and `finish` says so.
        site.take(tree.bytes());
        let bounds = tree.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds);
        let frame = Self::frame_of(&bounds);
        let most = Self::MOST_IN_LEAF;
        let wide: Wide<N, L> = collapse(&primitives, tree, &frame, most, gathering, &site)?;
        site.finish(Self {
            cut: tree.order.len() > primitives.len(),
            parts: Vec::new(),
            bounds,
            frame,
            primitives,
            root: wide.root,
            nodes: wide.nodes,
            leaves: wide.leaves,
            isa: Isa::best(),
            precision: Precision::Exact,
            depth: wide.depth,
        })
    }
}

impl<P: Primitives, const N: usize, L: Layout> WideBvh<P, N, L> {
    /// Most primitives that are brought together into one leaf, unless the binary tree has larger ones.
    const MOST_IN_LEAF: usize = if P::COMPOSITE { 1 } else { 2 * Leaves::LANES };

    /// From where the boxes of such a scene are seen.
    fn frame_of(bounds: &Aabb) -> Frame {
        if P::TRIANGLES {
            Frame::of(bounds)
        } else {
            Frame::world(bounds.scale())
        }
    }

    /// The same tree, walked with a chosen instruction set.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }

    /// A box that the frame sees, in the world, or one around it.
    #[inline(always)]
    fn in_world(&self, bounds: &Aabb) -> Aabb {
        if <L::Boxes<N> as Boxes<N>>::ROUNDED {
            self.frame.around_in_world(bounds)
        } else {
            self.frame.in_world(bounds)
        }
    }
}

impl<P: Primitives, const N: usize> WideBvh<P, N> {
    /// The same tree, looked at so exactly. Primitives that are not triangles are always met exactly.
    #[must_use]
    pub fn with_precision(self, precision: Precision) -> Self {
        let precision = if P::TRIANGLES {
            precision
        } else {
            Precision::Exact
        };
        Self { precision, ..self }
    }

    /// Whether the tree holds some placed objects part by part ([`WideSah::rebraid`]). Such a tree can be [saved](Self::save), but not opened:
    /// what is missing of its objects' boxes, their own structures alone can tell.
    pub fn has_parts(&self) -> bool {
        !self.parts.is_empty()
    }
}

impl<P: Primitives, const N: usize, L: Layout> WideBvh<P, N, L> {
    /// By how many times the slack a ray meets boxes, where it is more than once.
    #[inline(always)]
    fn slackened(&self) -> Option<f32> {
        (P::COMPOSITE && !self.parts.is_empty()).then_some(PARTS_SLACK)
    }

    /// Which part of its primitive a block of the leaves holds.
    fn part(&self, block: usize) -> Part {
        self.parts.get(block).copied().unwrap_or(Part::ALL)
    }

    /// Shows the primitives in a leaf to the query.
    #[inline(always)]
    fn offer<S: Lanes<{ Leaves::LANES }>, Q: Query, C: Counters>(
        &self,
        leaf: Child,
        at: &BlockRay<'_, S>,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<Stop> {
        let (blocks, primitives) = (leaf.blocks(), &self.primitives);
        (self.leaves).offer::<L, _, _, _, _>(blocks, primitives, &self.parts, at, query, counters)
    }

    /// One box after the other, for any ray.
    fn plainly<Q: Query, C: Counters>(
        &self,
        from: Child,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) {
        // Where primitives are cut, a leaf's box holds a part of each, but a ray outside the doors may hit it anywhere in
        // its own box.
        if self.cut && !ray.is_tame() {
            primitive::offer_all(&self.primitives, ray, query, counters);
        } else {
            scalar::walk(self, from, ray, query, counters);
        }
    }
}

impl<P: Primitives, const N: usize, L: Layout> WideBvh<P, N, L>
where
    Level: Vectorize<N>,
{
    /// Runs of rays that run together as packets, all others as one batch each.
    fn many<Q: Query>(&self, mut rays: &[Ray], mut queries: &mut [Q]) {
        let level = self.isa.level();
        let mut packet = packet::Packet::for_depth::<N>(self.depth, self.precision);
        let mut apart = 0;
        let mut wait = 0;
        while P::TRIANGLES && Q::ONE_HIT && rays.len() - apart >= FEW {
            let end = rays.len().min(apart + packet::RAYS);
            if wait > 0 {
                (wait, apart) = (wait - 1, end);
                continue;
            }
            let outcome = level.vectorize(packet::Together {
                bvh: self,
                packet: &mut packet,
                rays: &rays[apart..end],
                queries: &mut queries[apart..end],
            });
            if outcome == Outcome::Apart {
                apart = end;
                continue;
            }
            let (before, rest) = mem::take(&mut queries).split_at_mut(apart);
            self.apart(&rays[..apart], before);
            let (together, rest) = rest.split_at_mut(end - apart);
            for i in packet.found.take_uncovered() {
                if let Some(ray) = PreparedRay::new(&rays[apart + i], self.frame.scale) {
                    self.plainly(self.root, &ray, &mut together[i], &mut ());
                }
            }
            if outcome == Outcome::Loose {
                wait = WAIT;
                for (i, query) in together.iter_mut().enumerate() {
                    if packet.found.is_open(i) {
                        self.traverse(&rays[apart + i], query, &mut ());
                    }
                }
            }
            (rays, queries, apart) = (&rays[end..], rest, 0);
        }
        self.apart(rays, queries);
    }

    /// Where a part is.
    #[inline(always)]
    fn place(&self, part: Part) -> Child {
        if part == Part::ALL {
            self.root
        } else {
            Child(part.number())
        }
    }

    fn apart<Q: Query>(&self, rays: &[Ray], queries: &mut [Q]) {
        if self.depth > batch::LEVELS {
            for (ray, query) in rays.iter().zip(queries) {
                self.traverse(ray, query, &mut ());
            }
        } else if !rays.is_empty() {
            self.isa.level().vectorize(batch::Batch {
                bvh: self,
                rays,
                queries,
            });
        }
    }
}

/// How many packets run apart after a loose one.
const WAIT: usize = 7;
/// Fewer rays than this are not worth a batch.
const FEW: usize = 16;

impl<P: Primitives, const N: usize, L: Layout> Traverse for WideBvh<P, N, L>
where
    Level: Vectorize<N>,
{
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn statistics(&self) -> Statistics {
        let blocks = self.leaves.len() * Leaves::block_bytes(L::has_corners::<P>());
        Statistics {
            bytes: size_of_val(&*self.nodes) + blocks + size_of_val(&*self.parts),
            ..Statistics::of_cells(self.primitives.len(), self.bounds, |show| self.cells(show))
        }
    }

    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        tree::cells(self, show);
    }

    fn parts(&self, of: Part, show: &mut dyn FnMut(Aabb, Part)) {
        let child = self.place(of);
        // Of cut primitives a part is in several leaves, and to enter boxes of parts within parts takes more slack than there is.
        if self.cut || child.is_leaf() {
            return;
        }
        for (_, bounds, below) in self.nodes[child.index()].slots() {
            show(self.in_world(&bounds), Part::new(below.0));
        }
    }

    #[inline]
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        self.traverse_part(Part::ALL, ray, query, counters);
    }

    #[inline]
    fn traverse_part<Q: Query, C: Counters>(
        &self,
        part: Part,
        ray: &Ray,
        query: &mut Q,
        counters: &mut C,
    ) {
        let from = self.place(part);
        if from == Child::NOTHING {
            return;
        }
        // Of the two loops only one is compiled for a kind of counters.
        if !C::EXPLAINS {
            let one = traverse::One {
                tree: self,
                from,
                ray,
                query,
                counters,
            };
            // Boxes are rounded a little differently where operations are fused: counts are the same on every machine.
            let walked = if C::COUNTS {
                Portable.vectorize(one)
            } else {
                self.isa.level().vectorize(one)
            };
            if !matches!(walked, Break(Stop::Uncovered)) {
                return;
            }
        }
        if let Some(ray) = PreparedRay::new(ray, self.frame.scale) {
            self.plainly(from, &ray, query, counters);
        }
    }

    fn traverse_each<Q: Query, C: Counters>(
        &self,
        rays: &[Ray],
        queries: &mut [Q],
        counters: &mut C,
    ) {
        assert_eq!(rays.len(), queries.len(), "one query per ray");
        if C::COUNTS || rays.len() < FEW {
            for (ray, query) in rays.iter().zip(queries) {
                self.traverse(ray, query, counters);
            }
        } else if self.root != Child::NOTHING {
            self.many(rays, queries);
        }
    }
}
