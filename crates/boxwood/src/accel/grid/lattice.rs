//! A box cut into equal cells: where its planes are, and in which cells a primitive lies.

use crate::accel::Axes;
use crate::accel::cells::Space;
use crate::geometry::{Aabb, Vec3};
use crate::math;
use crate::primitive::Primitives;
use core::ops::ControlFlow::{self, Continue};

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

    #[inline]
    fn plane(&self, axis: usize, number: u32) -> f64 {
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

    /// Shows every cell that primitive `i`, whose box is `around`, lies in.
    ///
    /// *How.* Where its box spans cells on one axis only, it lies in all of them. In a few cells it is held against each.
    /// Otherwise it is cut row by row: the part of it in a row is in one piece, and so are the cells of it.
    #[inline]
    pub fn overlapped<P: Primitives>(
        &self,
        space: &Space,
        primitives: &P,
        i: usize,
        around: &Aabb,
        show: &mut impl FnMut([u32; 3]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let range = self.range(around, space.pad());
        let span = range.map(|[first, last]| last - first + 1);
        let divided = span.iter().filter(|&&n| n > 1).count();
        if divided <= 1 || !space.is_exact::<P>() {
            each(&range, show)
        } else if count(span) <= FEW {
            each(&range, &mut |cell| {
                if space.holds(primitives, i, &self.cell(cell)) {
                    show(cell)?;
                }
                Continue(())
            })
        } else {
            self.rows(space, primitives, i, around, range, show)
        }
    }

    fn rows<P: Primitives>(
        &self,
        space: &Space,
        primitives: &P,
        i: usize,
        around: &Aabb,
        range: Range,
        show: &mut impl FnMut([u32; 3]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let span = range.map(|[first, last]| last - first);
        // Rows along the axis with the most cells, in slabs across the one with the fewest.
        let row = (0..3).max_by_key(|&k| span[k]).unwrap_or(0);
        let (a, b) = ((row + 1) % 3, (row + 2) % 3);
        let (slab, other) = if span[a] < span[b] { (a, b) } else { (b, a) };
        let cut = |axis: usize, number: u32, from: &Aabb| {
            let mut within = *from;
            within.lower[axis] = self.plane(axis, number) as f32;
            within.upper[axis] = self.plane(axis, number + 1) as f32;
            within
        };
        for s in range[slab][0]..=range[slab][1] {
            let in_slab = cut(slab, s, around);
            let part = if span[slab] == 0 {
                *around
            } else {
                space.part(primitives, i, &in_slab)
            };
            if part.is_empty() {
                continue;
            }
            let [first, last] =
                self.between(other, part.lower[other], part.upper[other], space.pad());
            for o in first..=last {
                let part = space.part(primitives, i, &cut(other, o, &in_slab));
                if part.is_empty() {
                    continue;
                }
                let mut cells = [[0; 2]; 3];
                cells[slab] = [s, s];
                cells[other] = [o, o];
                cells[row] = self.between(row, part.lower[row], part.upper[row], space.pad());
                each(&cells, show)?;
            }
        }
        Continue(())
    }
}

/// Up to so many cells, each is asked for itself.
const FEW: u64 = 4;

#[inline]
fn each(range: &Range, show: &mut impl FnMut([u32; 3]) -> ControlFlow<()>) -> ControlFlow<()> {
    let [xs, ys, zs] = range.map(|[first, last]| first..=last);
    for z in zs {
        for y in ys.clone() {
            for x in xs.clone() {
                show([x, y, z])?;
            }
        }
    }
    Continue(())
}

/// Rounded to a float where that is finite, because the walk of a tame ray reads it as one. What is lost is less than the
/// errors of the crossings that it allows for.
fn float(x: f64) -> f64 {
    let rounded = f64::from(x as f32);
    if rounded.is_finite() { rounded } else { x }
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
    use crate::TriangleMesh;
    use alloc::vec::Vec;

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

    /// Both ways of finding a triangle's cells against the plain one.
    #[test]
    fn cells_are_those_that_hold_the_triangle() {
        let mut state = 7_u64;
        let mut coordinate = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f32 / (1_u64 << 31) as f32
        };
        let positions: Vec<[f32; 3]> = (0..600)
            .map(|i| {
                let size = if i % 6 < 3 { 1.0 } else { 0.2 };
                [(); 3].map(|()| coordinate() * size)
            })
            .collect();
        let triangles = (0..200_u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let mesh = TriangleMesh::new(positions, triangles).expect("a good mesh");
        let space = Space::of(&mesh).with_pad(320.0);
        let lattice = Lattice::around(&space).divided([9, 7, 11], 1.0e-6);
        let mut most = 0;
        for i in 0..200 {
            let around = mesh.bounds(i);
            let mut found = Vec::new();
            let mut show = |cell| {
                found.push(cell);
                Continue(())
            };
            let ended = lattice.overlapped(&space, &mesh, i, &around, &mut show);
            assert!(ended.is_continue());
            let mut expected = Vec::new();
            for number in 0..9 * 7 * 11 {
                let cell = lattice.place(number);
                if space.holds(&mesh, i, &lattice.cell(cell)) {
                    expected.push(cell);
                }
            }
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected, "triangle {i}");
            most = most.max(found.len());
        }
        assert!(most > 50, "{most}");
    }
}
