//! Which plane is cheapest.
//!
//! *How it works.* A cell's cost is the primitives in it; that of a cell in two is the plane's own and the primitives of
//! either part, weighted with its share of the surface. In large cells planes across an axis are tried at even steps, by
//! counting where primitives begin and end (*binning*); in small ones at every place where a primitive begins or ends,
//! and beside them the slanted planes that the triangles propose.

use super::fragment::{Fragments, Side, proposals, side_across};
use super::node::{Plane, Shape};
use super::polyhedron::Point;
use crate::accel::Axes;
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;

/// What opening a node costs where its plane runs across an axis, in units of one primitive test.
const ACROSS_COST: f64 = 1.5;
/// What it costs where the plane is slanted.
const SLANTED_COST: f64 = 2.0;
/// Cutting off empty space makes a cut so much cheaper (Wald & Havran 2006), …
const EMPTY_BONUS: f64 = 0.85;
/// … where the rest has at most this share of the surface.
const LESS: f64 = 0.95;
/// Steps along an axis.
const BINS: usize = 32;

/// A plane that makes a cell cheaper, and where what lies in the plane goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    pub plane: Plane,
    pub flat_below: bool,
}

/// How many primitives lie below a plane, above it, and in it.
#[derive(Clone, Copy, Default)]
struct Count {
    below: usize,
    above: usize,
    flat: usize,
}

impl Count {
    fn add(&mut self, side: Side) {
        self.below += usize::from(side.below);
        self.above += usize::from(side.above);
        self.flat += usize::from(!side.below && !side.above);
    }
}

/// The best so far of the cuts of one cell.
struct Best {
    count: usize,
    area: f64,
    cut: Option<Cut>,
    /// What the next one has to be cheaper than.
    cost: f64,
}

impl Best {
    fn new(count: usize, area: f64) -> Self {
        Self {
            count,
            area,
            cut: None,
            cost: count as f64,
        }
    }

    /// Whether a plane may still be cheaper, whatever the areas: both together are no less than the whole.
    fn may_gain(&self, n: Count) -> bool {
        ACROSS_COST + (n.below.min(n.above) as f64) < self.cost && n.flat < self.count
    }

    fn consider(&mut self, plane: Plane, n: Count, areas: [f64; 2]) {
        let own = match plane {
            Plane::Across(..) => ACROSS_COST,
            Plane::Slanted(_) => SLANTED_COST,
        };
        for flat_below in [true, false] {
            let (mut below, mut above) = (n.below, n.above);
            if flat_below {
                below += n.flat;
            } else {
                above += n.flat;
            }
            let parts = below as f64 * areas[0] + above as f64 * areas[1];
            let kept = if below == 0 { areas[1] } else { areas[0] };
            // Not for slices, of which there is no end.
            let hollow = (below == 0 || above == 0) && kept < LESS * self.area;
            let bonus = if hollow { EMPTY_BONUS } else { 1.0 };
            let cost = bonus * (own + parts / self.area);
            if cost < self.cost {
                self.cost = cost;
                self.cut = Some(Cut { plane, flat_below });
            }
        }
    }
}

/// The cheapest of evenly spaced planes across the axes; `None` when none is worth it.
pub(super) fn binned(
    bounds: impl Iterator<Item = Aabb> + Clone,
    count: usize,
    cell: &Aabb,
    axes: Axes,
    pad: f32,
) -> Option<Cut> {
    let shape = Shape::Box(*cell);
    let mut best = Best::new(count, shape.area());
    let (mut begin, mut end) = ([[0_usize; BINS]; 3], [[0_usize; BINS]; 3]);
    let size = cell.upper * 0.5 - cell.lower * 0.5;
    let step = |axis: usize| size[axis] / (0.5 * BINS as f32);
    for b in bounds {
        for axis in axes.iter() {
            // NaN and what lies outside go to the ends.
            let bin = |x: f32| (((x - cell.lower[axis]) / step(axis)) as usize).min(BINS - 1);
            begin[axis][bin(b.lower[axis] + pad)] += 1;
            end[axis][bin(b.upper[axis] - pad)] += 1;
        }
    }
    let mut buffer = Vec::new();
    for axis in axes.iter() {
        let (mut below, mut ended) = (0, 0);
        for k in 1..BINS {
            below += begin[axis][k - 1];
            ended += end[axis][k - 1];
            let at = cell.lower[axis] + step(axis) * k as f32;
            if !(cell.lower[axis] < at && at < cell.upper[axis]) {
                continue;
            }
            let n = Count {
                below,
                above: count - ended.min(count),
                flat: 0,
            };
            let plane = Plane::Across(axis, at);
            if best.may_gain(n) {
                let areas = shape.areas_cut(&plane, &mut buffer);
                best.consider(plane, n, areas);
            }
        }
    }
    best.cut
}

/// The cheapest of all planes that the fragments of a cell propose; `None` when none is worth it.
pub(super) fn exact<P: Primitives>(
    primitives: &P,
    fragments: &Fragments,
    shape: &Shape,
    axes: Axes,
    pad: f32,
    slanted: bool,
) -> Option<Cut> {
    let mut best = Best::new(fragments.list.len(), shape.area());
    let mut buffer: Vec<Point> = Vec::new();
    let cell = shape.bounds();
    for axis in axes.iter() {
        let ends = fragments.list.iter();
        let ends = ends.flat_map(|f| [f.bounds.lower[axis], f.bounds.upper[axis]]);
        let inside = |&at: &f32| cell.lower[axis] < at && at < cell.upper[axis];
        let mut ends: Vec<f32> = ends.filter(inside).collect();
        ends.sort_unstable_by(f32::total_cmp);
        ends.dedup();
        for at in ends {
            let mut n = Count::default();
            for fragment in &fragments.list {
                n.add(side_across(&fragment.bounds, axis, at, pad));
            }
            if best.may_gain(n) {
                let plane = Plane::Across(axis, at);
                let areas = shape.areas_cut(&plane, &mut buffer);
                best.consider(plane, n, areas);
            }
        }
    }
    if !slanted {
        return best.cut;
    }
    for fragment in &fragments.list {
        let Some(triangle) = primitives.corners(fragment.id as usize) else {
            continue;
        };
        for plane in proposals(triangle).into_iter().flatten() {
            // Along an axis that may not be divided no plane may lean.
            if (0..3).any(|axis| !axes.has(axis) && plane.normal[axis] != 0.0) {
                continue;
            }
            let plane = Plane::Slanted(plane);
            let mut n = Count::default();
            for fragment in &fragments.list {
                n.add(fragments.side(fragment, &plane, pad));
            }
            if best.may_gain(n) {
                let areas = shape.areas_cut(&plane, &mut buffer);
                best.consider(plane, n, areas);
            }
        }
    }
    best.cut
}
