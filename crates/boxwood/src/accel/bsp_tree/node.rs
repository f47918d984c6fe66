//! Nodes of 12 bytes, slanted planes, and what a finished tree is made of.

use super::polyhedron::{Point, Polyhedron};
use crate::accel::cells::Space;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST, half_area};
use crate::geometry::{Aabb, Vec3};
use crate::inspect::{Cell, Statistics};
use alloc::vec::Vec;

/// An inner node or a leaf:
///
/// ```text
///          across an axis             slanted               leaf
/// first    number of the lower child  the same              place of the first reference
/// kind     0, 1, 2: the axis          3                     4 + number of references
/// at       the plane                  bits of its number    0
/// ```
///
/// The upper child comes right behind the lower one. Below a slanted plane is where its normal does not point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub first: u32,
    kind: u32,
    at: f32,
}

const SLANTED: u32 = 3;
const LEAF: u32 = 4;

/// A leaf cannot name more.
pub(super) const MOST_IN_LEAF: usize = (u32::MAX - LEAF) as usize;

impl Node {
    pub fn axis(first: u32, axis: usize, at: f32) -> Self {
        let kind = axis as u32;
        Self { first, kind, at }
    }
    pub fn slanted(first: u32, plane: u32) -> Self {
        Self {
            first,
            kind: SLANTED,
            at: f32::from_bits(plane),
        }
    }
    pub fn leaf(first: u32, count: u32) -> Self {
        Self {
            first,
            kind: LEAF + count,
            at: 0.0,
        }
    }
    /// The same in lists that begin at these places of longer ones.
    pub fn moved(self, nodes: u32, planes: u32, references: u32) -> Self {
        match self.kind {
            0..SLANTED => Self::axis(self.first + nodes, self.kind as usize, self.at),
            SLANTED => Self::slanted(self.first + nodes, self.at.to_bits() + planes),
            _ => Self {
                first: self.first + references,
                ..self
            },
        }
    }
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.kind >= LEAF
    }
    /// The axis and the plane across it.
    #[inline(always)]
    pub fn across(self) -> Option<(usize, f32)> {
        (self.kind < SLANTED).then_some((self.kind as usize, self.at))
    }
    /// The number of an inner node's slanted plane.
    #[inline(always)]
    pub fn plane(self) -> usize {
        self.at.to_bits() as usize
    }
    #[inline(always)]
    pub fn count(self) -> u32 {
        self.kind - LEAF
    }
    #[inline(always)]
    pub fn places(self) -> core::ops::Range<usize> {
        self.first as usize..self.first as usize + self.count() as usize
    }
}

/// `normal · p = offset`, exactly so: the builder sorts by it, and the walk asks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slanted {
    pub normal: [f32; 3],
    /// `|x| + |y| + |z|` of the normal, rounded up: how far `normal · p` moves where each coordinate of `p` moves by 1.
    pub reach: f32,
    pub offset: f64,
}

impl Slanted {
    /// A plane with this normal of length 1 through the middle of the shadows that some points throw on it; `None`
    /// where there is no normal, or where it is an axis.
    pub fn new(normal: Point, points: &[Point]) -> Option<Self> {
        // Any plane will do, so nearly nothing can be nothing: in the plane, walls then stand upright.
        let normal = normal.map(|x| if x.abs() < 1.0e-6 { 0.0 } else { x as f32 });
        let slants = normal.iter().filter(|&&x| x != 0.0).count() > 1;
        if !slants || !normal.iter().all(|x| x.is_finite()) {
            return None;
        }
        let sum: f32 = normal.iter().map(|x| x.abs()).sum();
        let mut plane = Self {
            normal,
            reach: sum.next_up().next_up(),
            offset: 0.0,
        };
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for &p in points {
            let at = plane.distance(p);
            least = least.min(at);
            most = most.max(at);
        }
        plane.offset = 0.5 * (least + most);
        plane.offset.is_finite().then_some(plane)
    }
    #[inline(always)]
    pub fn distance(&self, p: Point) -> f64 {
        let [x, y, z] = self.normal.map(f64::from);
        x * p[0] + y * p[1] + z * p[2] - self.offset
    }
}

/// A plane that divides a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Plane {
    Across(usize, f32),
    Slanted(Slanted),
}

impl Plane {
    pub fn normal(&self) -> Point {
        match *self {
            Self::Across(axis, _) => {
                let mut normal = [0.0; 3];
                normal[axis] = 1.0;
                normal
            }
            Self::Slanted(plane) => plane.normal.map(f64::from),
        }
    }
    /// Where a point lies: not positive below.
    #[inline(always)]
    pub fn distance(&self, p: Point) -> f64 {
        match self {
            Self::Across(axis, at) => p[*axis] - f64::from(*at),
            Self::Slanted(plane) => plane.distance(p),
        }
    }
}

/// A finished tree without its primitives: what [`BspSah`](super::BspSah) makes and [`BspTree`](super::BspTree) walks.
#[derive(Clone, Debug, PartialEq)]
pub struct BspData {
    pub(super) space: Space,
    /// The root first; none when nothing is divided into cells.
    pub(super) nodes: Vec<Node>,
    pub(super) planes: Vec<Slanted>,
    /// The primitives of the leaves.
    pub(super) references: Vec<u32>,
    /// How many primitives it was built for.
    pub(super) primitives: usize,
    /// Whether slanted planes were tried.
    pub(super) slanted: bool,
}

impl BspData {
    /// Whether slanted planes were tried: not above [`BspSah::limit`](super::BspSah::limit) primitives, not for anything
    /// but triangles, and not in scenes smaller than 2⁻¹² or larger than 2²⁸.
    pub fn is_slanted(&self) -> bool {
        self.slanted
    }

    pub(super) fn plane(&self, node: Node) -> Plane {
        match node.across() {
            Some((axis, at)) => Plane::Across(axis, at),
            None => Plane::Slanted(self.planes[node.plane()]),
        }
    }

    pub(super) fn statistics(&self) -> Statistics {
        let mut found = Statistics {
            primitives: self.primitives,
            references: self.references.len() + self.space.everywhere.len(),
            bytes: size_of_val(&*self.nodes)
                + size_of_val(&*self.planes)
                + size_of_val(&*self.references)
                + size_of_val(&*self.space.everywhere),
            ..Statistics::default()
        };
        let (mut cost, mut whole) = (0.0, 0.0);
        self.walk(&mut |node, _, depth, shape| {
            let area = shape.area();
            if depth == 0 {
                whole = area;
            }
            found.depth = found.depth.max(depth as usize);
            if node.is_leaf() {
                found.leaves += 1;
                found.largest_leaf = found.largest_leaf.max(node.count() as usize);
                cost += f64::from(PRIMITIVE_COST) * f64::from(node.count()) * area;
            } else {
                found.nodes += 1;
                cost += f64::from(NODE_COST) * area;
            }
        });
        if whole > 0.0 && whole < f64::INFINITY {
            found.sah_cost = (cost / whole) as f32 + self.space.everywhere.len() as f32;
        }
        found
    }

    pub(super) fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        self.walk(&mut |node, number, depth, shape| {
            let sides = match shape {
                Shape::Box(_) => Vec::new(),
                Shape::Slanted(polyhedron) => polyhedron.drawn(),
            };
            show(&Cell {
                node: number,
                depth,
                bounds: shape.bounds(),
                primitives: node.is_leaf().then(|| node.count()),
                sides: &sides,
            });
        });
    }

    /// Every node with its number, depth and cell, parents before their children.
    fn walk(&self, visit: &mut dyn FnMut(Node, u32, u32, &Shape)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut open = alloc::vec![(0_u32, 0, Shape::Box(self.space.world))];
        while let Some((number, depth, shape)) = open.pop() {
            let node = self.nodes[number as usize];
            visit(node, number, depth, &shape);
            if !node.is_leaf() {
                let [below, above] = shape.cut(&self.plane(node));
                open.push((node.first + 1, depth + 1, above));
                open.push((node.first, depth + 1, below));
            }
        }
    }
}

/// A cell: a box until a slanted plane cuts it.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Box(Aabb),
    Slanted(Polyhedron),
}

impl Shape {
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Box(b) => *b,
            Self::Slanted(polyhedron) => polyhedron.bounds(),
        }
    }
    pub fn area(&self) -> f64 {
        match self {
            Self::Box(b) => 2.0 * half_area(b),
            Self::Slanted(polyhedron) => polyhedron.area(),
        }
    }
    /// The surfaces below and above a plane.
    pub fn areas_cut(&self, plane: &Plane, buffer: &mut Vec<Point>) -> [f64; 2] {
        match (self, plane) {
            (Self::Box(b), Plane::Across(axis, at)) => {
                halves(b, *axis, *at).map(|b| 2.0 * half_area(&b))
            }
            (Self::Slanted(polyhedron), _) => polyhedron.areas_cut(|p| plane.distance(p), buffer),
            (Self::Box(b), _) => Polyhedron::of(b).areas_cut(|p| plane.distance(p), buffer),
        }
    }
    /// The parts below and above a plane.
    pub fn cut(&self, plane: &Plane) -> [Self; 2] {
        let whole = match (self, plane) {
            (Self::Box(b), Plane::Across(axis, at)) => {
                return halves(b, *axis, *at).map(Self::Box);
            }
            (Self::Box(b), _) => &Polyhedron::of(b),
            (Self::Slanted(polyhedron), _) => polyhedron,
        };
        let normal = plane.normal();
        let below = whole.below(normal, |p| plane.distance(p));
        let above = whole.below(normal.map(|x| -x), |p| -plane.distance(p));
        [Self::Slanted(below), Self::Slanted(above)]
    }
    /// The same with corners and sides: what slanted planes are tried on.
    pub fn with_sides(self) -> Self {
        match self {
            Self::Box(b) => Self::Slanted(Polyhedron::of(&b)),
            Self::Slanted(_) => self,
        }
    }
}

/// A box below and above a plane, which is brought into it.
pub(super) fn halves(b: &Aabb, axis: usize, at: f32) -> [Aabb; 2] {
    let (mut below, mut above) = (*b, *b);
    let at = at.max(b.lower[axis]).min(b.upper[axis]);
    below.upper[axis] = at;
    above.lower[axis] = at;
    [below, above]
}

/// A corner in double precision.
pub(super) fn wide(p: Vec3) -> Point {
    p.to_array().map(f64::from)
}
