//! A node or a cell, as drawings want it.

use crate::geometry::{Aabb, Vec3};

/// A node or a cell of a structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<'a> {
    /// The number by which the structure's [`Step`](crate::Step)s name it.
    pub node: u32,
    /// How many nodes lie above; 0 for the root, and for the cells of a grid.
    pub depth: u32,
    /// The box that it is or, for a cell of slanted planes, that is around it.
    pub bounds: Aabb,
    /// How many primitives it names; `None` for an inner node.
    pub primitives: Option<u32>,
    /// The sides of a cell of slanted planes, each a loop of corners; empty where the cell is its box.
    pub sides: &'a [alloc::vec::Vec<Vec3>],
}
