//! Where in a large cell the cheapest plane is, about: counted in bins.
//!
//! *How it works.* Each axis of the cell falls into equal bins; in one pass each part is counted where it begins and where it
//! ends. Sums from either side give the cost of every border between two bins, and the cheapest plane of all is looked for
//! within a bin's width of the cheapest border.
//!
//! *Source.* Shevtsov, Soupikov & Kapustin 2007 (min-max binning).

use super::Item;
use super::sweep::Surface;
use crate::accel::Axes;
use crate::geometry::Aabb;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

const BINS: usize = 128;

/// Beginnings and ends of parts, by axis and bin.
type Counts = [[[u32; 2]; BINS]; 3];

/// A cell's items in bins.
pub(super) struct Bins {
    grid: Grid,
    counts: Counts,
}

struct Grid {
    lower: [f32; 3],
    upper: [f32; 3],
    /// Bins per unit of length; 0 where the cell is flat.
    scale: [f32; 3],
    width: [f32; 3],
}

impl Grid {
    fn of(cell: &Aabb) -> Self {
        // Halves first, so that the size of the largest box is still a number.
        let half = [0, 1, 2].map(|k| 0.5 * cell.upper[k] - 0.5 * cell.lower[k]);
        let scale = half.map(|half| {
            let scale = 0.5 * BINS as f32 / half;
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self {
            lower: cell.lower.to_array(),
            upper: cell.upper.to_array(),
            scale,
            width: half.map(|half| half / (0.5 * BINS as f32)),
        }
    }

    #[inline(always)]
    fn bin(&self, axis: usize, place: f32) -> usize {
        let bin = (place - self.lower[axis]) * self.scale[axis];
        (bin as usize).min(BINS - 1)
    }

    /// The border before bin `i`.
    fn border(&self, axis: usize, i: usize) -> f32 {
        if i == BINS {
            return self.upper[axis];
        }
        self.lower[axis] + i as f32 * self.width[axis]
    }

    fn count(&self, items: &[Item]) -> Counts {
        let mut counts = [[[0; 2]; BINS]; 3];
        for item in items {
            for (axis, counts) in counts.iter_mut().enumerate() {
                counts[self.bin(axis, item.bounds.lower[axis])][0] += 1;
                counts[self.bin(axis, item.bounds.upper[axis])][1] += 1;
            }
        }
        counts
    }
}

impl Bins {
    pub fn of(items: &[Item], cell: &Aabb) -> Self {
        let grid = Grid::of(cell);
        #[cfg(feature = "parallel")]
        let counts = items
            .par_chunks(super::CHUNK)
            .exactly()
            .map(|items| grid.count(items))
            .reduce(|| [[[0; 2]; BINS]; 3], add);
        #[cfg(not(feature = "parallel"))]
        let counts = grid.count(items);
        Self { grid, counts }
    }

    /// The axis of the cheapest border between two bins, and the range around it, from border to border.
    pub fn least(&self, n: usize, axes: Axes, surface: &Surface) -> Option<(usize, (f32, f32))> {
        let mut best = None;
        let mut least = f64::INFINITY;
        for axis in axes.iter() {
            if self.grid.scale[axis] == 0.0 {
                continue;
            }
            let (mut begun, mut ended) = (0, 0);
            for i in 1..BINS {
                let [begins, ends] = self.counts[axis][i - 1];
                begun += begins as usize;
                ended += ends as usize;
                let cost = surface.cost(axis, self.grid.border(axis, i), [begun, n - ended]);
                if cost < least {
                    least = cost;
                    best = Some((axis, i));
                }
            }
        }
        let (axis, i) = best?;
        let range = (self.grid.border(axis, i - 1), self.grid.border(axis, i + 1));
        Some((axis, range))
    }
}

#[cfg(feature = "parallel")]
fn add(mut a: Counts, b: Counts) -> Counts {
    for (a, b) in a
        .iter_mut()
        .flatten()
        .flatten()
        .zip(b.iter().flatten().flatten())
    {
        *a += b;
    }
    a
}
