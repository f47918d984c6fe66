//! The two-level grid: a coarse grid whose cells are cut again, each as finely as what lies in it asks for.
//!
//! *How it works.* About one block for eight primitives lies around the world. Every block that holds anything is a grid of
//! its own, with so many cells for each of its references ([`TwoLevelGridBuilder`]). All cells of all blocks lie one
//! after the other, and a block says where its own begin. A ray walks from block to block, and through the cells of those
//! that are not empty: an empty block is one step, however large. So a detailed model in a large place (the teapot in a
//! stadium) has small cells, and the place large ones.
//!
//! *Crowded blocks.* The number of references says nothing of where they are: sixty thousand of a teapot may lie in a
//! hundredth of their block, together with the floor. So the places that the middles of the references take are counted,
//! and a block with many references to a place is cut more finely, up to 255 times on an axis. (This is not in the paper;
//! it is affordable because empty cells are bits.)
//!
//! *Cost.* Building is linear in primitives, cells and references: every primitive is registered in blocks, which tells how
//! finely they are cut, and then in cells. 8 bytes per block, 0.2 per cell, 4 per filled cell, 4 per reference. A ray pays
//! blocks and cells on its way.
//!
//! *Source.* Kalojanov, Billeter & Slusallek 2011, *Two-Level Grids for Ray Tracing on GPUs*. The loop is that of the
//! [uniform grid](super::grid), whose bricks are blocks of one size.

mod blocks;
mod build;

pub use build::TwoLevelGridBuilder;

use super::grid::nested::Nested;
use crate::geometry::{Aabb, Ray};
use crate::inspect::{Cell, Statistics};
use crate::primitive::Primitives;
use crate::query::{Counters, Query, Traverse};
use blocks::CutBlocks;

/// Blocks and cells; what [`TwoLevelGridBuilder`] makes and [`TwoLevelGrid`] reads.
#[derive(Clone, Debug, PartialEq)]
pub struct GridOfGrids(Nested<CutBlocks>);

impl GridOfGrids {
    /// How many blocks there are on each axis.
    pub fn resolution(&self) -> [u32; 3] {
        self.0.lattice.resolution
    }
}

/// A two-level grid over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct TwoLevelGrid<P> {
    primitives: P,
    grid: GridOfGrids,
}

impl<P: Primitives> TwoLevelGrid<P> {
    /// Takes a grid that the builder made for these primitives.
    ///
    /// # Panics
    /// When it was made for another number of primitives.
    pub fn new(primitives: P, grid: GridOfGrids) -> Self {
        assert_eq!(
            primitives.len(),
            grid.0.primitives,
            "a grid for other primitives"
        );
        Self { primitives, grid }
    }
    /// Blocks and cells.
    pub fn grid(&self) -> &GridOfGrids {
        &self.grid
    }
    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
}

impl<P: Primitives> Traverse for TwoLevelGrid<P> {
    fn bounds(&self) -> Aabb {
        self.grid.0.space.bounds
    }
    fn statistics(&self) -> Statistics {
        self.grid.0.statistics()
    }
    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        self.grid.0.show_cells(true, show);
    }
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        self.grid.0.traverse(&self.primitives, ray, query, counters);
    }
}
