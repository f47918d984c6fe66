//! Building: blocks, how finely each is cut, and what lies in the cells.

use super::blocks::{CutBlocks, MOST_PARTS, bytes_of_blocks};
use super::{GridOfGrids, TwoLevelGrid};
use crate::accel::cells::Space;
use crate::accel::grid::counted::{
    BYTES_EACH, Counted, Reference, bytes_of_cells, bytes_of_filled, filled, ones,
};
use crate::accel::grid::lattice::{Lattice, cubic};
use crate::accel::grid::nested::{Blocks, Nested};
use crate::accel::grid::register::{Register, most_references, register};
use crate::accel::grid::walk::{LEAST_PADS, PAD};
use crate::accel::limits::{Site, unlimited};
use crate::accel::settings::{Setting, Settings};
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::math;
use crate::primitive::Primitives;
use crate::query::Intersect;
use crate::simd::exactly;
use alloc::boxed::Box;
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// The builder of [`TwoLevelGrid`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoLevelGridBuilder {
    /// How many blocks there are for each primitive, 0 to 1000.
    pub blocks: f32,
    /// How many cells a block has for each primitive in it, 0 to 1000.
    pub density: f32,
    /// The axes that may be divided.
    pub axes: Axes,
}

/// The most blocks for a primitive, and the most cells.
const MOST: f32 = 1000.0;

impl Default for TwoLevelGridBuilder {
    fn default() -> Self {
        Self {
            blocks: 0.12,
            density: 2.4,
            axes: Axes::XYZ,
        }
    }
}

/// A block with more references than this for each place where there are any is crowded,
const CROWDED: f64 = 8.0;
/// and is cut so finely that there would be so many, if they lie on surfaces.
const AT_EASE: f64 = 4.0;

/// What a build works with.
struct Work<'a, P> {
    primitives: &'a P,
    space: Space,
    thinnest: f64,
    site: Site<'a>,
}

impl TwoLevelGridBuilder {
    /// Builds a grid; it cannot fail.
    pub fn build(&self, primitives: &(impl Primitives + Sync)) -> GridOfGrids {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Builds a grid within limits. Where memory does not suffice, or where primitives would lie in more than 32 cells each
    /// and 262,144 besides, there are an eighth of the blocks and half of the cells, and so on, down to one block
    /// with one cell.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<GridOfGrids, BuildError> {
        exactly(|| self.grid(primitives, limits))
    }

    fn grid(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<GridOfGrids, BuildError> {
        // Looking at each primitive, putting it into blocks and into cells, and about six references of each, which are
        // passed three times.
        let n = primitives.len();
        let site = Site::new(limits, n.saturating_mul(21));
        let space = Space::within(primitives, &site, n).with_pad(PAD);
        let work = Work {
            thinnest: LEAST_PADS * f64::from(space.pad()),
            space,
            primitives,
            site,
        };
        let around = Lattice::around(&work.space);
        // NaN is none.
        let number = |x: f32| f64::from(if x > 0.0 { x.min(MOST) } else { 0.0 });
        let mut blocks = number(self.blocks) * primitives.len() as f64;
        let mut density = number(self.density);
        loop {
            let lattice = around.cut(blocks, self.axes, work.thinnest);
            let last = lattice.cells() == 1 && density < 1.0 / primitives.len().max(1) as f64;
            let found = work.cut(self.axes, &lattice, density, last);
            if found.is_some() || last || work.site.is_over() {
                let (blocks, cells) =
                    found.unwrap_or_else(|| (CutBlocks::of([].into_iter()).0, Counted::default()));
                return work.site.finish(GridOfGrids(Nested {
                    primitives: primitives.len(),
                    lattice,
                    blocks,
                    cells,
                    space: work.space,
                }));
            }
            blocks = lattice.cells() as f64 / 8.0;
            density = if lattice.cells() == 1 {
                density / 8.0
            } else {
                density / 2.0
            };
        }
    }
}

impl<P: Primitives + Sync> Work<'_, P> {
    /// Both levels; `None` where that is too much, and nothing of it is kept.
    fn cut(
        &self,
        axes: Axes,
        lattice: &Lattice,
        density: f64,
        last: bool,
    ) -> Option<(CutBlocks, Counted)> {
        let number = lattice.cells() as usize;
        let most = if last {
            usize::MAX
        } else {
            most_references(self.primitives.len())
        };
        let blocks_bytes = bytes_of_blocks(number);
        if !self.take(blocks_bytes, last) {
            return None;
        }
        let in_blocks = |i: usize, around: &Aabb, register: &mut Register<'_>| {
            lattice.overlapped(&self.space, self.primitives, i, around, &mut |block| {
                register.put(lattice.number(block) as u32)
            })
        };
        let Some(parts) = register(self.primitives, &self.site, most, &in_blocks) else {
            self.site.give(blocks_bytes);
            return None;
        };
        let references: usize = parts.iter().map(Vec::len).sum();
        let divided = self.divide(axes, lattice, density, parts, last);
        self.site.give(references * BYTES_EACH);
        let Some((blocks, cells)) = divided else {
            self.site.give(blocks_bytes);
            return None;
        };
        let cells_bytes = bytes_of_cells(cells);
        if !self.take(cells_bytes, last) {
            self.site.give(blocks_bytes);
            return None;
        }
        let in_cells = |i: usize, around: &Aabb, register: &mut Register<'_>| {
            lattice.overlapped(&self.space, self.primitives, i, around, &mut |place| {
                let block = blocks.block(lattice.number(place));
                let inner = lattice.inside(place, block.parts);
                // Only what lies in the block, where triangles are cut; boxes take part with all they have.
                let part = match self.space.is_exact::<P>() {
                    true => around.intersection(self.space.padded(&lattice.cell(place))),
                    false => *around,
                };
                inner.overlapped(&self.space, self.primitives, i, &part, &mut |cell| {
                    register.put(block.cell(cell) as u32)
                })
            })
        };
        match register(self.primitives, &self.site, most, &in_cells) {
            Some(parts) => {
                let counted = Counted::of(cells, parts, &self.site);
                Some((blocks, counted))
            }
            None => {
                self.site.give(blocks_bytes + cells_bytes);
                None
            }
        }
    }

    /// How each block is cut: by the number of its references and, where they crowd in few of the cells, more finely.
    /// `None` where there is no memory to find out, in which case nothing is taken from the site.
    fn divide(
        &self,
        axes: Axes,
        lattice: &Lattice,
        density: f64,
        mut references: Vec<Vec<Reference>>,
        last: bool,
    ) -> Option<(CutBlocks, usize)> {
        let number = lattice.cells() as usize;
        // How much lies in each block, and how it is cut at first.
        let counts_bytes = number * size_of::<u32>() + bytes_of_blocks(number);
        if !self.take(counts_bytes, last) {
            return None;
        }
        let mut counts = alloc::vec![0_u32; number];
        for reference in references.iter().flatten() {
            counts[reference.cell as usize] += 1;
        }
        let wanted = |count: u32| density * f64::from(count);
        let even = counts
            .iter()
            .map(|&count| self.parts(axes, lattice, wanted(count), count));
        let (blocks, cells) = CutBlocks::of(even);
        let masks_bytes = bytes_of_filled(cells);
        if !self.take(masks_bytes, last) {
            self.site.give(counts_bytes);
            return None;
        }
        // Each reference goes to the cell where the middle of its primitive is.
        let move_inside = |part: &mut Vec<Reference>| {
            if !self.site.advance(0) {
                return;
            }
            for reference in part {
                let (number, i) = (reference.cell as usize, reference.primitive as usize);
                let block = blocks.block(number);
                let inner = lattice.inside(lattice.place(number), block.parts);
                let middle = self.primitives.bounds(i).centroid();
                let at = inner.range(&Aabb::new(middle, middle), 0.0);
                reference.cell = block.cell(at.map(|[first, _]| first)) as u32;
            }
        };
        #[cfg(feature = "parallel")]
        references.par_iter_mut().exactly().for_each(move_inside);
        #[cfg(not(feature = "parallel"))]
        references.iter_mut().for_each(move_inside);
        if self.site.is_over() {
            // Some still name blocks.
            self.site.give(counts_bytes + masks_bytes);
            return None;
        }
        let masks = filled(cells, &references);
        drop(references);
        let parts = counts.iter().enumerate().map(|(number, &count)| {
            let block = blocks.block(number);
            let (from, cells) = (block.first as usize, block.parts.iter().product::<u32>());
            let places = ones(&masks, from, from + cells as usize).max(1);
            let crowd = f64::from(count) / places as f64;
            // Surfaces fill cells by the square of the resolution; cells in all are its cube.
            let finer = if crowd > CROWDED && !last {
                crowd / AT_EASE
            } else {
                1.0
            };
            self.parts(
                axes,
                lattice,
                wanted(count) * finer * math::sqrt_f64(finer),
                count,
            )
        });
        let cut = CutBlocks::of(parts);
        self.site.give(counts_bytes + masks_bytes);
        Some(cut)
    }

    /// How a block with so many references is cut into about so many cells.
    fn parts(&self, axes: Axes, lattice: &Lattice, cells: f64, count: u32) -> [u32; 3] {
        if count == 0 {
            return [0; 3];
        }
        let parts = cubic(lattice.size, cells, axes);
        core::array::from_fn(|k| {
            let most = (lattice.size[k] / self.thinnest) as u32;
            parts[k].min(most).clamp(1, MOST_PARTS)
        })
    }

    /// Takes memory; where nothing smaller is left to try, a refusal ends the build.
    fn take(&self, bytes: usize, last: bool) -> bool {
        match last {
            true => self.site.take(bytes),
            false => self.site.try_take(bytes),
        }
    }
}

impl Settings for TwoLevelGridBuilder {
    const NAME: &'static str = "grid2";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        alloc::vec![
            Setting::real("blocks", &mut self.blocks, 0.0..=MOST),
            Setting::real("c", &mut self.density, 0.0..=MOST),
            Setting::axes(&mut self.axes),
        ]
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        let grid = self.build_within(&primitives, limits)?;
        Ok(Box::new(TwoLevelGrid::new(primitives, grid)))
    }
}
