//! Who would join whom: for each cluster the one within the radius with which the common box is smallest.
//!
//! *How it works.* The area of a common box is the same from both sides, so each pair is measured once: every cluster with
//! those after it, eight at a time, from six rows of planes. A chunk of clusters begins as far ahead as the radius, so that
//! chunks need nothing of each other.
//!
//! Pairs are compared by area, then by the bits in which their numbers differ, which no two pairs of one cluster share: so
//! the best pair of all has chosen each other, and every round joins some. Both numbers together are one float of 64 bits:
//! the exponent of an area's 32 bits is never all ones there, and positive floats ascend like whole numbers.

use crate::accel::bvh::tree::BinaryNode;
use alloc::vec::Vec;

/// The widest search.
pub(super) const MAX_RADIUS: usize = 256;
/// Clusters that one thread looks at before it asks for more.
pub(super) const CHUNK: usize = 1024;

/// So many pairs are measured at once.
const LANES: usize = 8;

/// Scratch of one thread: the planes of a chunk and of what lies around it, and the best pairs so far.
pub(super) struct Scratch {
    /// Lower planes by axis, then negated upper ones.
    planes: [Vec<f32>; 6],
    best: Vec<f64>,
}

impl Scratch {
    pub const fn new() -> Self {
        Self {
            planes: [const { Vec::new() }; 6],
            best: Vec::new(),
        }
    }

    /// Writes the partners of the clusters from `first` on, for as many as there is room. There must be at least two
    /// clusters.
    pub fn find(
        &mut self,
        clusters: &[BinaryNode],
        radius: usize,
        first: usize,
        partners: &mut [u32],
    ) {
        let end = first + partners.len();
        let begin = first.saturating_sub(radius);
        let seen = &clusters[begin..(end + radius).min(clusters.len())];
        self.load(seen);
        for i in 0..end - begin {
            self.measure(i, begin, radius.min(seen.len() - 1 - i));
        }
        for (at, partner) in (first..).zip(partners) {
            // The lower half of the float says in which bits the numbers differ.
            *partner = at as u32 ^ self.best[at - begin].to_bits() as u32;
        }
    }

    fn load(&mut self, clusters: &[BinaryNode]) {
        let boxes = clusters.iter().map(|cluster| cluster.bounds);
        for (axis, plane) in self.planes.iter_mut().enumerate() {
            plane.clear();
            if axis < 3 {
                plane.extend(boxes.clone().map(|b| b.lower[axis]));
            } else {
                plane.extend(boxes.clone().map(|b| -b.upper[axis - 3]));
            }
            // Whoever is last still reads as many lanes.
            plane.resize(clusters.len() + LANES, 0.0);
        }
        self.best.clear();
        self.best.resize(clusters.len(), f64::INFINITY);
    }

    /// Measures pairs of the cluster in place `i` and the `others` after it.
    #[inline(always)]
    fn measure(&mut self, i: usize, begin: usize, others: usize) {
        let mine: [f32; 6] = core::array::from_fn(|k| self.planes[k][i]);
        let mut best = self.best[i];
        let mut j = i + 1;
        let end = j + others;
        while j < end {
            let areas = areas(&mine, &self.planes, j);
            let theirs = &mut self.best[j..end.min(j + LANES)];
            for (lane, other) in theirs.iter_mut().enumerate() {
                let differ = (begin + i) ^ (begin + j + lane);
                let pair = u64::from(areas[lane].to_bits()) << 32 | differ as u64;
                let pair = f64::from_bits(pair);
                *other = if pair < *other { pair } else { *other };
                best = if pair < best { pair } else { best };
            }
            j += LANES;
        }
        self.best[i] = best;
    }
}

/// Half the areas of the boxes around one cluster and each of some others.
#[inline(always)]
fn areas(mine: &[f32; 6], planes: &[Vec<f32>; 6], j: usize) -> [f32; LANES] {
    let mut sizes = [[0.0_f32; LANES]; 3];
    for axis in 0..3 {
        let lower = &planes[axis][j..j + LANES];
        let upper = &planes[axis + 3][j..j + LANES];
        for lane in 0..LANES {
            let (l, u) = (lower[lane], upper[lane]);
            let l = if l < mine[axis] { l } else { mine[axis] };
            let u = if u < mine[axis + 3] {
                u
            } else {
                mine[axis + 3]
            };
            let size = -u - l;
            sizes[axis][lane] = if size > 0.0 { size } else { 0.0 };
        }
    }
    let [x, y, z] = sizes;
    let mut areas = [0.0; LANES];
    for lane in 0..LANES {
        let area = x[lane] * y[lane] + y[lane] * z[lane] + z[lane] * x[lane];
        // An infinite box that is flat has the area NaN.
        areas[lane] = if area < f32::INFINITY {
            area
        } else {
            f32::INFINITY
        };
    }
    areas
}
