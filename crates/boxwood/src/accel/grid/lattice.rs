//! A box cut into equal cells: where its planes are.

use crate::accel::Axes;
use crate::accel::cells::Space;
use crate::geometry::{Aabb, Vec3};
use crate::math;

/// A box cut into equal cells. The planes are `lower + number · size`, computed in double precision and hence, for the
/// sizes of floats, as good as exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lattice {
    pub lower: [f64; 3],
    pub size: [f64; 3],
    pub resolution: [u32; 3],
}

/// First and last numbers of cells, by axis.
pub(crate) type Range = [[u32; 2]; 3];

/// No axis is cut into more cells: so many have numbers that are floats, with room to spare.
pub(crate) const MAX_SIDE: u32 = 1 << 14;
/// There are no more cells than this (2³⁰), whatever is asked for: 190 MB without anything in them.
pub(crate) const MAX_CELLS: u64 = 1 << 30;

impl Lattice {
    /// One cell: the world and, on each side, as much more as cells are padded by, so that every hit lies in it.
    pub fn around(space: &Space) -> Self {
        if space.world.is_empty() {
            return Self {
                lower: [0.0; 3],
                size: [1.0; 3],
                resolution: [1; 3],
            };
        }
        let [lower, upper] = [space.world.lower, space.world.upper].map(Vec3::to_array);
        let pad = f64::from(space.pad());
        let lower = lower.map(|x| float(f64::from(x) - pad));
        let size = core::array::from_fn(|k| {
            float((f64::from(upper[k]) + pad - lower[k]) * (1.0 + 1.0e-7))
        });
        Self {
            lower,
            size,
            resolution: [1; 3],
        }
    }

    /// The same box, cut into nearly cubic cells: about so many, none thinner than `thinnest`.
    pub fn cut(&self, cells: f64, axes: Axes, thinnest: f64) -> Self {
        self.divided(cubic(self.size, cells, axes), thinnest)
    }

    /// The same box, each of its cells cut into so many, none thinner than `thinnest`, all together at most
    /// [`MAX_CELLS`].
    pub fn divided(&self, parts: [u32; 3], thinnest: f64) -> Self {
        let mut parts: [u32; 3] = core::array::from_fn(|k| {
            // Zero over zero is NaN, which reads as 0.
            let most = (self.size[k] / thinnest).min(f64::from(MAX_SIDE)) as u32;
            parts[k].clamp(1, most.max(1))
        });
        while count(parts) > MAX_CELLS {
            parts = parts.map(|n| n.div_ceil(2));
        }
        Self {
            lower: self.lower,
            size: core::array::from_fn(|k| float(self.size[k] / f64::from(parts[k]))),
            resolution: parts,
        }
    }

    /// The cells of one cell, cut into so many parts.
    pub fn inside(&self, cell: [u32; 3], parts: [u32; 3]) -> Self {
        Self {
            lower: core::array::from_fn(|k| self.plane(k, cell[k])),
            size: core::array::from_fn(|k| self.size[k] / f64::from(parts[k])),
            resolution: parts,
        }
    }

    /// How many cells there are.
    pub fn cells(&self) -> u64 {
        count(self.resolution)
    }

    /// The number of a cell: x first, then y, then z.
    #[inline]
    pub fn number(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.resolution;
        x as usize + nx as usize * (y as usize + ny as usize * z as usize)
    }

    /// The cell with a number.
    pub fn place(&self, number: usize) -> [u32; 3] {
        let [nx, ny, _] = self.resolution.map(|n| n as usize);
        [number % nx, number / nx % ny, number / nx / ny].map(|c| c as u32)
    }

    /// Where cells with a number begin on an axis.
    #[inline]
    pub fn plane(&self, axis: usize, number: u32) -> f64 {
        self.lower[axis] + f64::from(number) * self.size[axis]
    }

    /// Around some cells.
    pub fn bounds(&self, range: &Range) -> Aabb {
        let mut around = Aabb::EMPTY;
        for (k, [first, last]) in range.iter().enumerate() {
            let clamp = |x: f64| x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
            around.lower[k] = clamp(self.plane(k, *first)).next_down();
            around.upper[k] = clamp(self.plane(k, last + 1)).next_up();
        }
        around
    }

    /// A cell's box.
    pub fn cell(&self, cell: [u32; 3]) -> Aabb {
        self.bounds(&cell.map(|c| [c, c]))
    }

    /// The cells on an axis that, padded, meet an interval.
    #[inline]
    fn between(&self, axis: usize, lower: f32, upper: f32, pad: f32) -> [u32; 2] {
        let last = self.resolution[axis] - 1;
        // Saturating: what lies outside belongs to the outermost cell.
        let cell = |x: f64| (((x - self.lower[axis]) / self.size[axis]) as u32).min(last);
        let pad = f64::from(pad);
        [cell(f64::from(lower) - pad), cell(f64::from(upper) + pad)]
    }

    /// The cells that, padded, meet a box.
    #[inline]
    pub fn range(&self, b: &Aabb, pad: f32) -> Range {
        core::array::from_fn(|k| self.between(k, b.lower[k], b.upper[k], pad))
    }
}

/// Rounded to a float, because the walk of a tame ray reads it as one. What is lost is less than the errors of the crossings
/// that it allows for. Not where floats are infinite or subnormal: a size that is rounded on their coarse grid, times the
/// number of cells, would leave out the end of a scene that is itself so small.
fn float(x: f64) -> f64 {
    let rounded = x as f32;
    if rounded.is_normal() {
        f64::from(rounded)
    } else {
        x
    }
}

fn count(parts: [u32; 3]) -> u64 {
    parts.into_iter().map(u64::from).product()
}

/// How often to cut each axis so that there are about so many cells and they are nearly cubes. An axis that is thinner
/// than a cell is not cut, and the others share the cells.
pub(crate) fn cubic(size: [f64; 3], cells: f64, axes: Axes) -> [u32; 3] {
    let mut cut: [bool; 3] = core::array::from_fn(|k| axes.has(k) && size[k] > 0.0);
    loop {
        let axes = (0..3).filter(|&k| cut[k]);
        let number = axes.clone().count();
        // The longest edge is 1, so that no product leaves the floats.
        let longest = axes.clone().fold(0.0, |most: f64, k| most.max(size[k]));
        let volume: f64 = axes.map(|k| size[k] / longest).product();
        let edge = match number {
            0 => return [1; 3],
            1 => volume / cells,
            2 => math::sqrt_f64(volume / cells),
            _ => libm::cbrt(volume / cells),
        } * longest;
        let thin = |k: usize| cut[k] && !(size[k] > edge);
        // The thinnest first: the others have more cells then.
        let thinnest = (0..3)
            .filter(|&k| thin(k))
            .min_by(|&a, &b| size[a].total_cmp(&size[b]));
        match thinnest {
            Some(k) => cut[k] = false,
            None => {
                return core::array::from_fn(|k| match cut[k] {
                    true => (size[k] / edge + 0.5) as u32,
                    false => 1,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_nearly_cubes() {
        let cells = |size, n| cubic(size, n, Axes::XYZ);
        assert_eq!(cells([1.0, 1.0, 1.0], 27.0), [3, 3, 3]);
        assert_eq!(cells([2.0, 1.0, 1.0], 16.0), [4, 2, 2]);
        // Flat, a line, a point; thin but not flat.
        assert_eq!(cells([1.0e30, 1.0e30, 0.0], 100.0), [10, 10, 1]);
        assert_eq!(cells([0.0, 1.0e-30, 0.0], 100.0), [1, 100, 1]);
        assert_eq!(cells([0.0; 3], 100.0), [1; 3]);
        assert_eq!(cells([1.0, 1.0, 0.01], 100.0), [10, 10, 1]);
        assert_eq!(cells([1.0; 3], 0.0), [1; 3]);
        assert_eq!(cubic([1.0; 3], 100.0, Axes::XY), [10, 10, 1]);
    }
}
