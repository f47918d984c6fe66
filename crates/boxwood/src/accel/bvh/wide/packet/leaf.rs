//! A packet at a leaf: which of its rays enter the box, and what they meet.

use super::{GROUPS, LANES, Packet};
use crate::accel::bvh::wide::WideBvh;
use crate::accel::bvh::wide::layout::Layout;
use crate::accel::bvh::wide::node::Child;
use crate::geometry::Aabb;
use crate::geometry::triangle::block::{RayGroup, TriangleBlock};
use crate::primitive::Primitives;
use crate::simd::{F, Floats, Lanes, Mask, Simd};
use core::mem::MaybeUninit;

impl Packet {
    /// Shows a leaf's triangles to the rays that enter its box; whether some ray's interval became shorter. Rays want the
    /// nearest hit if they are `ORDERED`, else any one.
    #[inline(always)]
    pub fn leaf<S: Simd, P: Primitives, const N: usize, L: Layout>(
        &mut self,
        s: S,
        bvh: &WideBvh<P, N, L>,
        leaf: Child,
        parent: Child,
        ordered: bool,
    ) -> bool {
        let mut shorter = false;
        // A tree of one leaf has no node that holds its box.
        let bounds = bvh
            .nodes
            .get(parent.index())
            .map(|node| node.bounds(node.lane(leaf)));
        for group in 0..GROUPS {
            if let Some(bounds) = &bounds
                && (self.found.closed[group] || self.enter(s, bounds, group) == 0)
            {
                continue;
            }
            for block in leaf.blocks() {
                let mut room = MaybeUninit::uninit();
                let primitives = &bvh.primitives;
                let block = (bvh.leaves).triangles::<S, L, P>(s, block, primitives, &mut room);
                shorter |= self.block(s, primitives, block, group, ordered);
            }
        }
        shorter
    }

    /// The rays of a group that enter a child's box, a bit each.
    #[inline(always)]
    fn enter<S: Lanes<LANES>>(&self, s: S, bounds: &Aabb, group: usize) -> u32 {
        let mut entry = F::<S, LANES>::load(s, &self.t_min[group]);
        let mut exit = F::<S, LANES>::load(s, &self.found.t_max[group]);
        for k in 0..3 {
            let (lower, upper) = (bounds.lower[k], bounds.upper[k]);
            let (near, far) = if self.heading.is_down(k) {
                (upper, lower)
            } else {
                (lower, upper)
            };
            let inverse = F::<S, LANES>::load(s, &self.inverse[k][group]);
            let enter = F::<S, LANES>::load(s, &self.enter[k][group]);
            let leave = F::<S, LANES>::load(s, &self.leave[k][group]);
            entry = entry.max(F::<S, LANES>::splat(s, near).times_more(inverse, enter));
            exit = exit.min(F::<S, LANES>::splat(s, far).times_more(inverse, leave));
        }
        entry.le(exit).bits()
    }

    /// Each triangle of a block against a group of rays.
    #[inline(always)]
    fn block<S: Lanes<LANES>, P: Primitives>(
        &mut self,
        s: S,
        primitives: &P,
        block: &TriangleBlock,
        group: usize,
        ordered: bool,
    ) -> bool {
        let rays = RayGroup {
            exact: self.precision.is_exact(),
            axes: self.axes,
            origin: [0, 1, 2].map(|k| &self.origin[k][group]),
            shear: [0, 1, 2].map(|k| &self.shear[k][group]),
            t_min: &self.t_min[group],
        };
        let may_meet = block.may_meet::<S>(s, &rays);
        let mut t_max = F::<S, LANES>::load(s, &self.found.t_max[group]);
        let mut met_any = false;
        for (triangle, &id) in block.ids().iter().enumerate() {
            if may_meet[triangle] == 0 || primitives.mask(id as usize) == 0 {
                continue;
            }
            let Some(met) = block.meet::<S>(s, triangle, &rays, t_max) else {
                continue;
            };
            met_any = true;
            t_max = self.found.keep(s, &met, id, group, ordered);
            if met.uncovered != 0 {
                t_max = self.found.leave_alone(s, met.uncovered, group);
            }
        }
        met_any
    }
}
