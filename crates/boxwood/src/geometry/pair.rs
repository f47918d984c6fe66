//! Two boxes side by side, met at once.
//!
//! *How it works.* Of each axis a ray wants the planes that it reaches first and those that it reaches last, which its sign
//! tells beforehand. First and last planes of both boxes fill four lanes; the last ones are negated, so that one product, one
//! difference and one maximum per axis narrow both intervals. The numbers are those of [`PreparedRay::slabs`].

use super::{Aabb, PreparedRay};

/// Two boxes and two words, in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct BoxPair {
    /// Bits, two of a kind: lower x, y, z and upper x, y, z of both boxes, then the words. Eight rows, so that no row
    /// number of three bits is out of bounds.
    rows: [[u32; 2]; 8],
}

impl BoxPair {
    /// Two boxes, each with a pair of words of the caller's.
    pub fn new(boxes: [Aabb; 2], words: [[u32; 2]; 2]) -> Self {
        let [a, b] = boxes;
        let lower = |k: usize| [a.lower[k].to_bits(), b.lower[k].to_bits()];
        let upper = |k: usize| [a.upper[k].to_bits(), b.upper[k].to_bits()];
        let rows = [
            lower(0),
            lower(1),
            lower(2),
            upper(0),
            upper(1),
            upper(2),
            words[0],
            words[1],
        ];
        Self { rows }
    }
    /// One of the boxes.
    pub fn bounds(&self, side: usize) -> Aabb {
        let row = |k: usize| f32::from_bits(self.rows[k][side]);
        Aabb::new([row(0), row(1), row(2)], [row(3), row(4), row(5)])
    }
    /// The words of one of the boxes.
    #[inline(always)]
    pub fn words(&self, side: usize) -> [u32; 2] {
        self.rows[6 + side]
    }
    #[inline(always)]
    fn planes(&self, row: usize) -> [f32; 2] {
        self.rows[row & 7].map(f32::from_bits)
    }
}

/// A ray made ready to meet pairs.
pub(crate) struct PairRay {
    /// Rows of the planes that the ray reaches first; those reached last are three rows on, or back.
    first: [usize; 3],
    last: [usize; 3],
    /// By axis, for the first planes of both boxes and the last ones: what they are multiplied with, and what is then
    /// added.
    factor: [[f32; 4]; 3],
    shift: [[f32; 4]; 3],
    t_min: f32,
}

impl PairRay {
    #[inline(always)]
    pub fn new(ray: &PreparedRay) -> Self {
        let [inverse, enter, leave] = ray.slab_terms();
        let row = |k: usize| if inverse[k] < 0.0 { k + 3 } else { k };
        let opposite = |k: usize| if inverse[k] < 0.0 { k } else { k + 3 };
        let factor = |k: usize| [inverse[k], inverse[k], -inverse[k], -inverse[k]];
        let shift = |k: usize| [enter[k], enter[k], -leave[k], -leave[k]];
        Self {
            first: [row(0), row(1), row(2)],
            last: [opposite(0), opposite(1), opposite(2)],
            factor: [factor(0), factor(1), factor(2)],
            shift: [shift(0), shift(1), shift(2)],
            t_min: ray.t_min,
        }
    }

    /// Where the ray enters and leaves both boxes within `[t_min, t_max]`, erring to the outside by the slack: a box is
    /// entered where `enter <= leave`.
    #[inline(always)]
    pub fn slabs(&self, ray: &PreparedRay, pair: &BoxPair, t_max: f32) -> ([f32; 2], [f32; 2]) {
        if !ray.is_tame() {
            return self.slabs_one_by_one(ray, pair, t_max);
        }
        // Enter, enter, minus leave, minus leave.
        let mut ends = [self.t_min, self.t_min, -t_max, -t_max];
        ends = self.narrowed(0, pair, ends);
        ends = self.narrowed(1, pair, ends);
        ends = self.narrowed(2, pair, ends);
        ([ends[0], ends[1]], [-ends[2], -ends[3]])
    }

    #[inline(always)]
    fn narrowed(&self, axis: usize, pair: &BoxPair, ends: [f32; 4]) -> [f32; 4] {
        let (p, q) = (pair.planes(self.first[axis]), pair.planes(self.last[axis]));
        let (m, s) = (self.factor[axis], self.shift[axis]);
        let at = [
            p[0] * m[0] + s[0],
            p[1] * m[1] + s[1],
            q[0] * m[2] + s[2],
            q[1] * m[3] + s[3],
        ];
        [
            if at[0] > ends[0] { at[0] } else { ends[0] },
            if at[1] > ends[1] { at[1] } else { ends[1] },
            if at[2] > ends[2] { at[2] } else { ends[2] },
            if at[3] > ends[3] { at[3] } else { ends[3] },
        ]
    }

    #[cold]
    fn slabs_one_by_one(
        &self,
        ray: &PreparedRay,
        pair: &BoxPair,
        t_max: f32,
    ) -> ([f32; 2], [f32; 2]) {
        let side = |side: usize| {
            let (enter, leave) = ray.slabs(&pair.bounds(side));
            (enter.max(self.t_min), leave.min(t_max))
        };
        let (a, b) = (side(0), side(1));
        ([a.0, b.0], [a.1, b.1])
    }
}
