//! From cell to cell along a ray: the three-dimensional digital differential analyser.
//!
//! *How it works.* On each axis the ray crosses the planes of equal cells at equal steps. It leaves a cell where the next
//! of three crossings is, and that axis's number goes up or down by one. Numbers of cells count along the ray's way here,
//! whichever way that is.
//!
//! *Why no hit is lost.* Each crossing is computed from the plane's number, `first + number · per`, never from the crossing
//! before it: errors do not add up, and crossings ascend with their numbers because rounding is monotone. A walk from
//! `enter` to `leave` visits, for each `t` in between, a cell whose six crossings have `t` between them. How far off may a
//! crossing be? With `u = 2⁻²⁴`, `S` the scene's largest |coordinate|, `R` the origin's, and all planes within `2.5 S`
//! (see [`Way::through`]), in distance along the axis:
//!
//! - `plane · inverse − origin · inverse`: 2 u of either product and 1 u of their difference, `3 u (2.5 S + R)`;
//! - `number · per`, with 3 u on a distance of at most `3.5 S`, and the sum: `10.5 u S + u (2.5 S + R)`;
//! - the same once more for cells within a cell, where 5 u apply to a distance of at most `2 S`: `10 u S + u (2.5 S + R)`;
//! - directions near zero are raised by `u` times the largest, over a way of at most `S + R`: `u (S + R)`.
//!
//! Together less than `35 u S + 6 u R`. A hit lies within `36 u (S + R)` of the primitive it belongs to (see
//! [`PreparedRay`]), so while `R ≤ 4 S` the point of the primitive that a hit stands for lies within `240 u S` of the cell
//! whose turn it is. Cells are padded by [`PAD`], `320 u S`. A border, an edge or a corner is no matter, nor is a ray
//! that runs in a plane. The walk may stop in a cell when the query's `t_max` lies before where the ray leaves it.
//!
//! *Source.* Amanatides & Woo 1987, *A Fast Voxel Traversal Algorithm for Ray Tracing*.

use super::lattice::Lattice;
use crate::geometry::PreparedRay;

/// By how many units in the last place of the scene's largest coordinate cells are larger than their planes say.
pub(crate) const PAD: f32 = 320.0;
/// Cells are at least so many pads thin, so that the place where a walk begins is found by rounding, give or take one.
pub(crate) const LEAST_PADS: f64 = 4.0;
/// A ray from farther away than this, in units of the scene's largest coordinate, does not walk.
pub(crate) const MOST_SCALES: f32 = 4.0;

/// How a ray crosses the planes of equal cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Where it crosses the first plane along its way.
    first: [f32; 3],
    /// From one plane to the next; positive.
    per: [f32; 3],
    /// `1 / per`.
    rate: [f32; 3],
    /// Whether the way goes towards lower numbers.
    pub backward: [bool; 3],
}

/// A walk through cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walk {
    /// The plane ahead, by its number along the way.
    ahead: [f32; 3],
    /// Where it is crossed; infinite for the last.
    crossing: [f32; 3],
    /// How many cells there are.
    count: [f32; 3],
    /// What is added to the number of the cell.
    step: [i32; 3],
    /// The number of the cell.
    cell: i32,
}

impl Way {
    /// How a tame ray crosses the planes of a lattice whose cells are taken together by `edge`, and from where to where
    /// it is in the lattice.
    ///
    /// Where `edge` does not divide the resolution, the last cell sticks out: by at most three quarters of the box, if
    /// there are 4 cells or more, which is why planes may lie as far as `2.5 S`.
    #[inline(always)]
    pub fn through(lattice: &Lattice, edge: [u32; 3], ray: &PreparedRay) -> (Self, f32, f32) {
        let mut way = Self {
            first: [0.0; 3],
            per: [0.0; 3],
            rate: [0.0; 3],
            backward: [false; 3],
        };
        let (mut enter, mut leave) = (ray.t_min, f32::INFINITY);
        for (k, edge) in edge.into_iter().enumerate() {
            let inverse = ray.inverse()[k];
            let size = lattice.size[k] as f32 * edge as f32;
            let count = lattice.resolution[k].div_ceil(edge) as f32;
            let lower = lattice.lower[k] as f32;
            let backward = inverse < 0.0;
            let plane = if backward {
                lower + size * count
            } else {
                lower
            };
            let first = plane * inverse - ray.origin[k] * inverse;
            let per = size * inverse.abs();
            let last = first + count * per;
            enter = if first > enter { first } else { enter };
            leave = if last < leave { last } else { leave };
            way.backward[k] = backward;
            way.first[k] = first;
            way.per[k] = per;
            way.rate[k] = 1.0 / per;
        }
        (way, enter, leave)
    }

    /// The way through a cell that is itself cut into cells.
    #[inline(always)]
    pub fn within(&self, walk: &Walk, parts: [u32; 3]) -> Self {
        let mut way = *self;
        for k in 0..3 {
            let parts = parts[k] as f32;
            way.first[k] = self.first[k] + (walk.ahead[k] - 1.0) * self.per[k];
            way.per[k] = self.per[k] * (1.0 / parts);
            way.rate[k] = self.rate[k] * parts;
        }
        way
    }

    /// Where a walk through so many cells begins that is there at `enter`. `strides` is from one cell to the next.
    #[inline(always)]
    pub fn walk(&self, parts: [u32; 3], strides: [i32; 3], enter: f32) -> Walk {
        let mut walk = Walk {
            ahead: [0.0; 3],
            crossing: [0.0; 3],
            count: [0.0; 3],
            step: [0; 3],
            cell: 0,
        };
        for k in 0..3 {
            let (first, per) = (self.first[k], self.per[k]);
            let last = parts[k] as i32 - 1;
            // Saturating, and NaN reads as 0.
            let mut at = ((enter - first) * self.rate[k]) as i32;
            at = if at < 0 { 0 } else { at };
            at = if at > last { last } else { at };
            let behind = first + at as f32 * per;
            let ahead = first + (at + 1) as f32 * per;
            at -= i32::from(behind > enter && at > 0);
            at += i32::from(ahead < enter && at < last);
            walk.count[k] = parts[k] as f32;
            walk.ahead[k] = (at + 1) as f32;
            walk.crossing[k] = self.crossing(&walk, k);
            let backward = self.backward[k];
            walk.cell += strides[k] * if backward { last - at } else { at };
            walk.step[k] = if backward { -strides[k] } else { strides[k] };
        }
        walk
    }

    /// The last plane is never crossed: where the walk ends, who walks knows better.
    #[inline(always)]
    fn crossing(&self, walk: &Walk, k: usize) -> f32 {
        let crossing = self.first[k] + walk.ahead[k] * self.per[k];
        if walk.ahead[k] < walk.count[k] {
            crossing
        } else {
            f32::INFINITY
        }
    }
}

impl Walk {
    /// The number of the cell whose turn it is.
    #[inline(always)]
    pub fn cell(&self) -> usize {
        self.cell as usize
    }

    /// Where the ray leaves the cell; infinite in the last one.
    #[inline(always)]
    pub fn exit(&self) -> f32 {
        let [x, y, z] = self.crossing;
        let xy = if x < y { x } else { y };
        if xy < z { xy } else { z }
    }

    /// Into the next cell; through an edge or a corner, two or three axes at once.
    #[inline(always)]
    pub fn advance(&mut self, way: &Way, exit: f32) {
        for k in 0..3 {
            let crossed = self.crossing[k] <= exit;
            self.ahead[k] += if crossed { 1.0 } else { 0.0 };
            self.cell += if crossed { self.step[k] } else { 0 };
            self.crossing[k] = way.crossing(self, k);
        }
    }
}
