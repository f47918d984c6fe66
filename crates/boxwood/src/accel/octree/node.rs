//! Nodes of 8 bytes, and where their cells lie.

use crate::accel::cells::Space;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST, half_area};
use crate::geometry::{Aabb, Vec3};
use crate::inspect::{Cell, Statistics};
use alloc::vec::Vec;

/// An inner node or a leaf:
///
/// ```text
///          inner                         leaf
/// first    number of the first child     place of the first reference
/// rest     0 … 0 | mask of 8 bits        1 | number of references, 31 bits
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Node {
    pub first: u32,
    rest: u32,
}

const LEAF: u32 = 1 << 31;

impl Node {
    /// An inner node: its existing children lie side by side, in the order of the bits of `mask`.
    pub fn inner(first: u32, mask: u8) -> Self {
        Self {
            first,
            rest: u32::from(mask),
        }
    }
    /// A leaf.
    pub fn leaf(first: u32, count: u32) -> Self {
        Self {
            first,
            rest: count | LEAF,
        }
    }
    /// The same in a list that begins at `nodes` and `references` of a longer one.
    #[cfg(feature = "parallel")]
    pub fn moved(self, nodes: usize, references: usize) -> Self {
        let by = if self.is_leaf() { references } else { nodes };
        Self {
            first: self.first + by as u32,
            ..self
        }
    }
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.rest & LEAF != 0
    }
    /// Which children exist; the octant's bit 0 is set in the upper half along x, bit 1 along y, bit 2 along z.
    #[inline(always)]
    pub fn mask(self) -> u32 {
        self.rest
    }
    /// How many references a leaf has.
    #[inline(always)]
    pub fn count(self) -> u32 {
        self.rest & !LEAF
    }
    /// The places of a leaf's references.
    #[inline(always)]
    pub fn places(self) -> core::ops::Range<usize> {
        self.first as usize..self.first as usize + self.count() as usize
    }
}

/// How many bits are set in a byte: processors of the common denominator have no instruction for it.
static ONES: [u8; 256] = {
    let mut ones = [0; 256];
    let mut byte = 1;
    while byte < 256 {
        ones[byte] = ones[byte / 2] + (byte % 2) as u8;
        byte += 1;
    }
    ones
};

/// The place of an existing child among those that exist.
#[inline(always)]
pub(super) fn rank(mask: u32, octant: u32) -> u32 {
    let before = mask & ((1 << octant) - 1);
    u32::from(ONES[(before & 0xff) as usize])
}

/// Where a cell lies: around its middle, which is where it is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub middle: Vec3,
    /// Half the size. Zero along an axis that may not be divided: then the middle is the cell's upper end.
    pub half: Vec3,
}

impl Place {
    /// The root: along the divided axes a cube from the world's lower corner, so that no cell is longer than wide.
    pub fn root(world: &Aabb, axes: crate::accel::Axes) -> Self {
        let (mut middle, mut half) = (world.upper, Vec3::ZERO);
        if world.is_empty() {
            return Self { middle, half };
        }
        let size = world.upper * 0.5 - world.lower * 0.5;
        let longest = size[axes.longest(size)];
        for axis in axes.iter() {
            // A cube that reaches beyond the floats is cut to the world.
            let beyond = !(world.lower[axis] + 2.0 * longest).is_finite();
            half[axis] = if beyond { size[axis] } else { longest };
            middle[axis] = world.lower[axis] + half[axis];
        }
        Self { middle, half }
    }

    /// A child, by the bits of [`Node::mask`].
    #[inline(always)]
    pub fn child(&self, octant: u32) -> Self {
        let half = self.half * 0.5;
        let mut middle = self.middle;
        for axis in 0..3 {
            let up = octant >> axis & 1 == 1;
            middle[axis] += if up { half[axis] } else { -half[axis] };
        }
        Self { middle, half }
    }

    /// The cell as drawings want it: right to the rounding of its middle. `world` bounds the axes that are not divided.
    pub fn bounds(&self, world: &Aabb) -> Aabb {
        let mut b = *world;
        for axis in 0..3 {
            if self.half[axis] > 0.0 {
                b.lower[axis] = self.middle[axis] - self.half[axis];
                b.upper[axis] = self.middle[axis] + self.half[axis];
            }
        }
        b
    }
}

/// A finished octree, without its primitives: what [`OctreeBuilder`](super::OctreeBuilder) makes and
/// [`Octree`](super::Octree) walks.
#[derive(Clone, Debug, PartialEq)]
pub struct OctreeData {
    pub(super) space: Space,
    pub(super) root: Place,
    /// The root first; none when nothing is divided into cells.
    pub(super) nodes: Vec<Node>,
    /// The primitives of the leaves.
    pub(super) references: Vec<u32>,
    /// How many primitives it was built for.
    pub(super) primitives: usize,
}

impl OctreeData {
    /// What it is made of.
    pub(super) fn statistics(&self) -> Statistics {
        let mut found = Statistics {
            primitives: self.primitives,
            references: self.references.len() + self.space.everywhere.len(),
            bytes: size_of_val(&*self.nodes)
                + size_of_val(&*self.references)
                + size_of_val(&*self.space.everywhere),
            ..Statistics::default()
        };
        let whole = half_area(&self.space.world);
        let mut cost = 0.0;
        self.cells(&mut |cell| {
            let depth = cell.depth as usize;
            // What lies beyond the world costs nothing.
            let area = half_area(&cell.bounds.intersection(self.space.world));
            match cell.primitives {
                None => {
                    found.nodes += 1;
                    cost += f64::from(NODE_COST) * area;
                }
                Some(0) => return,
                Some(count) => {
                    found.leaves += 1;
                    found.largest_leaf = found.largest_leaf.max(count as usize);
                    cost += f64::from(PRIMITIVE_COST) * f64::from(count) * area;
                }
            }
            found.depth = found.depth.max(depth);
        });
        if whole > 0.0 && whole < f64::INFINITY {
            found.sah_cost = (cost / whole) as f32 + self.space.everywhere.len() as f32;
        }
        found
    }

    /// Every cell. Empty ones, which no node stands for, have the number `u32::MAX`.
    pub(super) fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        if self.nodes.is_empty() {
            return;
        }
        let divided = (0..8).filter(|&octant| {
            // No upper half along an axis that is not divided.
            (0..3).all(|axis| self.root.half[axis] > 0.0 || octant >> axis & 1 == 0)
        });
        let divided: Vec<u32> = divided.collect();
        let mut open = alloc::vec![(0, self.root, 0)];
        while let Some((number, place, depth)) = open.pop() {
            let node = self.nodes.get(number as usize);
            let primitives = match node {
                None => Some(0),
                Some(node) => node.is_leaf().then(|| node.count()),
            };
            show(&Cell {
                node: number,
                depth,
                bounds: place.bounds(&self.space.world),
                primitives,
                sides: &[],
            });
            let Some(node) = node.filter(|node| !node.is_leaf()) else {
                continue;
            };
            for &octant in divided.iter().rev() {
                let exists = node.mask() >> octant & 1 == 1;
                let number = if exists {
                    node.first + rank(node.mask(), octant)
                } else {
                    u32::MAX
                };
                open.push((number, place.child(octant), depth + 1));
            }
        }
    }
}
