//! The uniform grid: space cut into equal cells, each with the list of what lies in it.
//!
//! *How it works.* `C` times as many cells as primitives, nearly cubes, lie around the world ([`GridBuilder`]). A triangle is
//! registered in every cell that it really overlaps, not in those of its box. A ray goes from cell to cell by adding and
//! comparing, and stops in the first cell that has a hit before its exit. Cells lie in bricks of four by four by four: 64
//! bits tell which hold anything, so that a ray passes 64 empty cells with one look.
//!
//! *Where it fails.* All cells have one size, for all of the scene: a detailed model in a large place falls into a few cells,
//! and every ray at it tests all of it (the teapot in a stadium). [`two_level_grid`](super::two_level_grid) cuts such
//! cells again.
//!
//! *Cost.* Building is linear in primitives, cells and references. 0.2 bytes per cell, 4 per filled cell, 4 per reference.
//! A ray pays the cells on its way, some `(C n)^⅓`, of which most are passed in bricks.
//!
//! *Source.* Fujimoto, Tanaka & Iwata 1986, *ARTS: Accelerated Ray-Tracing System*; Amanatides & Woo 1987 for the walk;
//! Cleary & Wyvill 1988, *Analysis of an Algorithm for Fast Ray Tracing Using Uniform Space Subdivision*, for the number
//! of cells; Lagae & Dutré 2008, *Compact, Fast and Robust Grids for Ray Tracing*, for the lists. Bricks of bits are
//! Museth 2013, *VDB*.

mod bisect;
mod bricks;
mod build;
pub(super) mod counted;
mod cover;
pub(super) mod lattice;
pub(super) mod nested;
pub(super) mod register;
mod rows;
mod settings;
mod sorted;
pub(super) mod walk;

pub use build::GridBuilder;
pub use settings::Density;

use crate::geometry::{Aabb, Ray};
use crate::inspect::{Cell, Statistics};
use crate::primitive::Primitives;
use crate::query::{Counters, Query, Traverse};
use bricks::Bricks;
use nested::Nested;

/// The cells; what [`GridBuilder`] makes and [`UniformGrid`] reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid(Nested<Bricks>);

impl Grid {
    /// How many cells there are on each axis.
    pub fn resolution(&self) -> [u32; 3] {
        self.0.lattice.resolution
    }
}

/// A uniform grid over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct UniformGrid<P> {
    primitives: P,
    grid: Grid,
}

impl<P: Primitives> UniformGrid<P> {
    /// Takes a grid that the builder made for these primitives.
    ///
    /// # Panics
    /// When it was made for another number of primitives.
    pub fn new(primitives: P, grid: Grid) -> Self {
        assert_eq!(
            primitives.len(),
            grid.0.primitives,
            "a grid for other primitives"
        );
        Self { primitives, grid }
    }
    /// The cells.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
}

impl<P: Primitives> Traverse for UniformGrid<P> {
    fn bounds(&self) -> Aabb {
        self.grid.0.space.bounds
    }
    fn statistics(&self) -> Statistics {
        self.grid.0.statistics()
    }
    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        self.grid.0.show_cells(false, show);
    }
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        self.grid.0.traverse(&self.primitives, ray, query, counters);
    }
}
