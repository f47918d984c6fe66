//! Building: how many cells, and what lies in them.

use super::bricks::Bricks;
use super::counted::{Counted, bytes_of_cells};
use super::lattice::{Lattice, MAX_SIDE};
use super::nested::Nested;
use super::register::{Register, most_references, register};
use super::settings::{CutIn, Density};
use super::walk::{LEAST_PADS, PAD};
use super::{Grid, UniformGrid};
use crate::accel::cells::Space;
use crate::accel::limits::{Site, unlimited};
use crate::accel::settings::{Setting, Settings};
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;
use crate::query::Intersect;
use crate::simd::exactly;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// The builder of [`UniformGrid`].
///
/// ```
/// use boxwood::{Density, GridBuilder, TriangleMesh, UniformGrid};
/// let mesh = TriangleMesh::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0_u32, 1, 2]])?;
/// let builder = GridBuilder { density: Density::PerPrimitive(100.0), ..Default::default() };
/// let grid = UniformGrid::new(&mesh, builder.build(&mesh));
/// assert_eq!(grid.grid().resolution(), [10, 10, 1]);
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridBuilder {
    /// How many cells there are for each primitive.
    pub density: Density,
    /// How many cells there are on each axis, whatever the density; at most 16384 on an axis and 2³⁰ in all.
    pub resolution: Option<[u32; 3]>,
    /// The axes that may be divided; the others have one cell.
    pub axes: Axes,
}

impl Default for GridBuilder {
    fn default() -> Self {
        Self {
            density: Density::PerPrimitive(27.0),
            resolution: None,
            axes: Axes::XYZ,
        }
    }
}

impl GridBuilder {
    /// Builds a grid; it cannot fail.
    pub fn build(&self, primitives: &(impl Primitives + Sync)) -> Grid {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Builds a grid within limits. Where memory does not suffice for the cells that were asked for, or where primitives
    /// would lie in more than 32 cells each and 262,144 besides, there are half as many on each axis, and half again,
    /// down to one cell.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<Grid, BuildError> {
        exactly(|| self.grid(primitives, limits))
    }

    fn grid(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<Grid, BuildError> {
        // Looking at each primitive, and about seven references of each, which are made and then passed three times.
        let n = primitives.len();
        let site = Site::new(limits, n.saturating_mul(23));
        let space = Space::within(primitives, &site, n).with_pad(PAD);
        let thinnest = LEAST_PADS * f64::from(space.pad());
        let around = Lattice::around(&space);
        let mut lattice = match self.resolution {
            Some(parts) => {
                let parts = core::array::from_fn(|k| match self.axes.has(k) {
                    true => parts[k],
                    false => 1,
                });
                around.divided(parts, thinnest)
            }
            None => around.cut(self.density.cells(primitives.len()), self.axes, thinnest),
        };
        let most = most_references(primitives.len());
        let (bricks, cells) = loop {
            let bricks = Bricks::of(lattice.resolution);
            let cells = bricks.cells();
            let last = lattice.cells() == 1;
            // The last resort takes what it needs, or the build is over.
            let room = match last {
                true => site.take(bytes_of_cells(cells)),
                false => site.try_take(bytes_of_cells(cells)),
            };
            if room {
                let put = |i: usize, bounds: &_, register: &mut Register<'_>| {
                    lattice.overlapped(&space, primitives, i, bounds, &mut |cell| {
                        register.put(bricks.cell(cell))
                    })
                };
                let found = register(
                    primitives,
                    &site,
                    if last { usize::MAX } else { most },
                    &put,
                );
                if let Some(parts) = found {
                    break (bricks, Counted::of(cells, parts, &site));
                }
                site.give(bytes_of_cells(cells));
            }
            if last || site.is_over() {
                break (bricks, Counted::default());
            }
            let half = lattice.resolution.map(|n| n.div_ceil(2));
            lattice = around.divided(half, thinnest);
        };
        site.finish(Grid(Nested {
            space,
            primitives: primitives.len(),
            lattice,
            blocks: bricks,
            cells,
        }))
    }
}

impl Settings for GridBuilder {
    const NAME: &'static str = "grid";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        alloc::vec![
            Setting::new("c", &mut self.density),
            Setting::new("resolution", CutIn(&mut self.resolution, MAX_SIDE)),
            Setting::axes(&mut self.axes),
        ]
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        let grid = self.build_within(&primitives, limits)?;
        Ok(Box::new(UniformGrid::new(primitives, grid)))
    }
}
