//! Sixty-four rays that run together: one box test for all of them, and each triangle against sixteen at once.
//!
//! *How it works.* Origins and reciprocal directions of the packet are intervals. A node's box is entered where *some* ray of
//! the intervals may enter it, so one test in lanes over the children serves the whole packet. At a leaf every ray is held
//! against its box, and those that enter it against each triangle, sixteen rays an operation: the canonical test in its
//! canonical order, behind the filter of rounded products, which most groups of rays do not pass.
//!
//! *Cost.* On the rays of a camera a third to a fifth of the time of one ray after the other.
//!
//! *Source.* Wald et al. 2001, *Interactive Rendering with Coherent Ray Tracing*; Boulos, Wald & Shirley 2006, *Geometric and
//! Arithmetic Culling Methods for Entire Ray Packets*.

use super::WideBvh;
use super::node::{Child, Heading, Node};
use crate::geometry::triangle::block::{RayGroup, TriangleBlock};
use crate::geometry::{PreparedRay, Ray};
use crate::primitive::Primitives;
use crate::query::Query;
use crate::simd::{F, Floats, Kernel, Lanes, Mask, Portable, Simd, U, Words};
use alloc::vec;
use alloc::vec::Vec;

/// Rays in a packet.
pub const RAYS: usize = 64;
/// Rays that are held against a triangle at once.
const LANES: usize = RayGroup::LANES;
const GROUPS: usize = RAYS / LANES;

/// A number for each ray.
type Row = [[f32; LANES]; GROUPS];
const ROW: Row = [[0.0; LANES]; GROUPS];

/// A packet through the door: at most [`RAYS`] rays, one query for each.
pub struct Together<'a, P, Q, const N: usize> {
    pub bvh: &'a WideBvh<P, N>,
    pub packet: &'a mut Packet,
    pub queries: &'a mut [Q],
}

/// Rays made ready to run together.
pub struct Packet {
    /// In the order of `axes`.
    origin: [Row; 3],
    shear: [Row; 3],
    inverse: [Row; 3],
    near: [Row; 3],
    far: [Row; 3],
    t_min: Row,
    /// Below every `t_min` for a ray that asks no more.
    t_max: Row,
    heading: Heading,
    axes: [usize; 3],
    /// The ranges of `1 / direction`.
    least_inverse: [f32; 3],
    most_inverse: [f32; 3],
    /// The ranges of the origins, widened by the slack.
    least_origin: [f32; 3],
    most_origin: [f32; 3],
    /// Rays for the loop that looks at boxes of triangles; see [`Stop::Uncovered`](crate::geometry::triangle::block::Stop).
    uncovered: Vec<usize>,
    children: Vec<u32>,
    entries: Vec<f32>,
    /// The node that holds each child.
    parents: Vec<u32>,
}

/// Directions that differ by more than this in their reciprocals are not worth a packet: its boxes would be entered by rays
/// that none of its rays is near to.
const SPREAD: f32 = 0.25;

impl Packet {
    /// For a tree of such a depth.
    pub fn for_depth<const N: usize>(depth: usize) -> Self {
        let height = depth * (N - 1) + 1 + N;
        Self {
            origin: [ROW; 3],
            shear: [ROW; 3],
            inverse: [ROW; 3],
            near: [ROW; 3],
            far: [ROW; 3],
            t_min: ROW,
            t_max: ROW,
            heading: Heading::NONE,
            axes: [0; 3],
            least_inverse: [0.0; 3],
            most_inverse: [0.0; 3],
            least_origin: [0.0; 3],
            most_origin: [0.0; 3],
            uncovered: Vec::new(),
            children: vec![Child::NOTHING.0; height],
            entries: vec![f32::NEG_INFINITY; height],
            parents: vec![Child::NOTHING.0; height],
        }
    }

    /// Takes up to [`RAYS`] rays in; `false` when they do not run together.
    pub fn gather(&mut self, rays: &[Ray], scale: f32) -> bool {
        let s = Portable;
        self.t_max = [[f32::NEG_INFINITY; LANES]; GROUPS];
        self.least_inverse = [f32::INFINITY; 3];
        self.most_inverse = [f32::NEG_INFINITY; 3];
        self.least_origin = [f32::INFINITY; 3];
        self.most_origin = [f32::NEG_INFINITY; 3];
        let mut slack = 0.0_f64;
        for (i, ray) in rays.iter().enumerate() {
            let Some(ray) = PreparedRay::tame(s, ray, scale) else {
                return false;
            };
            let heading = Heading::of(&ray);
            if i == 0 {
                (self.heading, self.axes) = (heading, ray.axes);
            }
            if heading.octant != self.heading.octant || ray.axes != self.axes {
                return false;
            }
            let (group, lane) = (i / LANES % GROUPS, i % LANES);
            let (inverse, near, far) = ray.slab_terms();
            for k in 0..3 {
                self.origin[k][group][lane] = ray.origin[self.axes[k]];
                self.shear[k][group][lane] = ray.shear[k];
                self.inverse[k][group][lane] = inverse[k];
                self.near[k][group][lane] = near[k];
                self.far[k][group][lane] = far[k];
                self.least_inverse[k] = self.least_inverse[k].min(inverse[k]);
                self.most_inverse[k] = self.most_inverse[k].max(inverse[k]);
                self.least_origin[k] = self.least_origin[k].min(ray.origin[k]);
                self.most_origin[k] = self.most_origin[k].max(ray.origin[k]);
            }
            self.t_min[group][lane] = ray.t_min;
            self.t_max[group][lane] = ray.t_max;
            slack = slack.max(ray.slack());
        }
        let slack = slack as f32;
        for k in 0..3 {
            self.least_origin[k] -= slack;
            self.most_origin[k] += slack;
        }
        self.is_narrow()
    }

    /// Whether the directions are alike. The longest axis says by how much the others may differ.
    fn is_narrow(&self) -> bool {
        let [_, _, kz] = self.axes;
        let unit = self.least_inverse[kz]
            .abs()
            .min(self.most_inverse[kz].abs());
        (0..3).all(|k| {
            // In slopes, not in reciprocals, which grow without bound as a direction turns away from an axis.
            let slope = |inverse: f32| unit / inverse;
            (slope(self.least_inverse[k]) - slope(self.most_inverse[k])).abs() < SPREAD
        })
    }

    fn latest(&self) -> f32 {
        self.t_max
            .as_flattened()
            .iter()
            .fold(f32::NEG_INFINITY, |a, &b| if b > a { b } else { a })
    }
}

impl<P: Primitives, Q: Query, const N: usize> Kernel<N> for Together<'_, P, Q, N> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, s: S) {
        let Together {
            bvh,
            packet,
            queries,
        } = self;
        let bounds = Bounds::<S, N>::new(s, packet);
        let mut latest = packet.latest();
        let mut pending = 1;
        let mut current = bvh.root;
        let mut parent = Child::NOTHING;
        loop {
            if current.is_leaf() {
                if packet.leaf(s, bvh, current, parent, queries) {
                    latest = packet.latest();
                }
            } else {
                let node = &bvh.nodes[current.index()];
                let (entry, exit) = bounds.slabs(s, node, latest);
                let order = U::<S, N>::from_nibbles(s, node.order(packet.heading.octant));
                let (entry, exit) = (entry.permute(order), exit.permute(order));
                let entered = entry.le(exit);
                let below = U::<S, N>::load(s, node.children()).permute(order);
                let room = "a stack as deep as the tree";
                below.close_up(
                    entered,
                    packet.children[pending..].first_chunk_mut().expect(room),
                );
                entry.close_up(
                    entered,
                    packet.entries[pending..].first_chunk_mut().expect(room),
                );
                packet.parents[pending..pending + N].fill(current.0);
                pending += entered.bits().count_ones() as usize;
            }
            loop {
                pending -= 1;
                if pending == 0 {
                    return;
                }
                if packet.entries[pending] <= latest {
                    break;
                }
            }
            current = Child(packet.children[pending]);
            parent = Child(packet.parents[pending]);
        }
    }
}

/// The intervals of a packet in every lane.
struct Bounds<S: Lanes<N>, const N: usize> {
    least_inverse: [F<S, N>; 3],
    most_inverse: [F<S, N>; 3],
    /// What the near planes are seen from, and the far ones.
    near: [F<S, N>; 3],
    far: [F<S, N>; 3],
    t_min: F<S, N>,
    heading: Heading,
}

impl<S: Lanes<N>, const N: usize> Bounds<S, N> {
    #[inline(always)]
    fn new(s: S, packet: &Packet) -> Self {
        let zero = F::<S, N>::splat(s, 0.0);
        let mut new = Self {
            least_inverse: [zero; 3],
            most_inverse: [zero; 3],
            near: [zero; 3],
            far: [zero; 3],
            t_min: zero,
            heading: packet.heading,
        };
        for k in 0..3 {
            let (least, most) = (packet.least_origin[k], packet.most_origin[k]);
            let down = packet.heading.octant >> k & 1 == 1;
            let (near, far) = if down { (least, most) } else { (most, least) };
            new.least_inverse[k] = F::<S, N>::splat(s, packet.least_inverse[k]);
            new.most_inverse[k] = F::<S, N>::splat(s, packet.most_inverse[k]);
            new.near[k] = F::<S, N>::splat(s, near);
            new.far[k] = F::<S, N>::splat(s, far);
        }
        new
    }

    /// Where the first ray may enter each child, and where the last one may leave it.
    #[inline(always)]
    fn slabs(&self, s: S, node: &Node<N>, latest: f32) -> (F<S, N>, F<S, N>) {
        let mut entry = self.t_min;
        let mut exit = F::<S, N>::splat(s, latest);
        for k in 0..3 {
            let [near, far] = self.heading.planes(s, node, k);
            let (near, far) = (near - self.near[k], far - self.far[k]);
            let (a, b) = (self.least_inverse[k], self.most_inverse[k]);
            entry = entry.max((near * a).min(near * b));
            exit = exit.min((far * a).max(far * b));
        }
        (entry, exit)
    }
}

impl Packet {
    /// Shows a leaf's triangles to the rays that enter its box; whether some ray's interval became shorter.
    #[inline(always)]
    fn leaf<S: Simd, P: Primitives, Q: Query, const N: usize>(
        &mut self,
        s: S,
        bvh: &WideBvh<P, N>,
        leaf: Child,
        parent: Child,
        queries: &mut [Q],
    ) -> bool {
        let mut shorter = false;
        for group in 0..GROUPS {
            // A tree of one leaf has no node that holds its box.
            if let Some(node) = bvh.nodes.get(parent.index())
                && let Some(lane) = node.children().iter().position(|&child| child == leaf.0)
                && !self.enter(s, node, lane, group)
            {
                continue;
            }
            for block in bvh.leaves.triangles(leaf.blocks()) {
                shorter |= self.triangles(s, &bvh.primitives, block, group, queries);
            }
        }
        shorter
    }

    /// Whether some ray of a group enters a child's box.
    #[inline(always)]
    fn enter<S: Lanes<LANES>, const N: usize>(
        &self,
        s: S,
        node: &Node<N>,
        lane: usize,
        group: usize,
    ) -> bool {
        let mut entry = F::<S, LANES>::load(s, &self.t_min[group]);
        let mut exit = F::<S, LANES>::load(s, &self.t_max[group]);
        for k in 0..3 {
            let [near, far] = self.heading.plane(node, k, lane);
            let inverse = F::<S, LANES>::load(s, &self.inverse[k][group]);
            let from = F::<S, LANES>::load(s, &self.near[k][group]);
            let to = F::<S, LANES>::load(s, &self.far[k][group]);
            entry = entry.max(F::<S, LANES>::splat(s, near).times_less(inverse, from));
            exit = exit.min(F::<S, LANES>::splat(s, far).times_less(inverse, to));
        }
        entry.le(exit).bits() != 0
    }

    /// Each triangle of a block against a group of rays.
    #[inline(always)]
    fn triangles<S: Lanes<LANES>, P: Primitives, Q: Query>(
        &mut self,
        s: S,
        primitives: &P,
        block: &TriangleBlock,
        group: usize,
        queries: &mut [Q],
    ) -> bool {
        let rays = RayGroup {
            axes: self.axes,
            origin: [
                &self.origin[0][group],
                &self.origin[1][group],
                &self.origin[2][group],
            ],
            shear: [
                &self.shear[0][group],
                &self.shear[1][group],
                &self.shear[2][group],
            ],
            t_min: &self.t_min[group],
        };
        let mut shorter = false;
        for triangle in 0..block.count() {
            let Some(met) = block.meet::<S>(s, triangle, &rays, &self.t_max[group]) else {
                continue;
            };
            let mut found = met.rays;
            while found != 0 {
                let lane = found.trailing_zeros() as usize % LANES;
                found &= found - 1;
                let index = group * LANES + lane;
                let Some(query) = queries.get_mut(index) else {
                    continue;
                };
                let hit = met.hit(lane);
                if primitives.mask(hit.primitive as usize) & query.mask() == 0 {
                    continue;
                }
                let end = &mut self.t_max[group][lane];
                if !met.is_covered(lane) {
                    self.uncovered.push(index);
                    *end = f32::NEG_INFINITY;
                } else if query.offer(hit).is_break() {
                    *end = f32::NEG_INFINITY;
                } else {
                    *end = query.t_max();
                }
                shorter = true;
            }
        }
        shorter
    }

    /// Takes the rays that were left for the other loop.
    pub fn take_uncovered(&mut self) -> Vec<usize> {
        core::mem::take(&mut self.uncovered)
    }
}
