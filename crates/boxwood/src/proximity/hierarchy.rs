//! What a tree must show to be asked about space: its nodes' boxes and its leaves' primitives.

use crate::geometry::{Aabb, Vec3};
use crate::primitive::Triangles;

/// A tree of boxes over triangles, seen node by node. The one thing a structure writes to be asked everything in this module.
///
/// What holds for every node: each triangle that some leaf below names has all of its points in the boxes of such leaves, or
/// within [`Hierarchy::slack`] of them; and a node's box contains the boxes below it.
pub trait Hierarchy: Sized {
    /// What lies in the leaves.
    type Primitives: Triangles;
    /// Names a node.
    type Node: Copy;

    /// The primitives, by the numbers that leaves name.
    fn primitives(&self) -> &Self::Primitives;
    /// The root; `None` when there are no primitives.
    fn root(&self) -> Option<Self::Node>;
    /// What lies directly below a node.
    fn open(
        &self,
        node: Self::Node,
    ) -> Opened<impl Iterator<Item = (Aabb, Self::Node)>, impl Iterator<Item = Numbered>>;
    /// The number of a node, different for each, and small enough to count nodes with.
    fn number(&self, node: Self::Node) -> usize;
    /// How far from the boxes of its leaves a point of a triangle may be, world units. Zero where every leaf's box holds its
    /// triangles whole; otherwise triangles are cut, and several leaves may name the same.
    fn slack(&self) -> f64 {
        0.0
    }
}

/// A triangle with its number.
pub type Numbered = (u32, [Vec3; 3]);

/// What lies below a node.
pub enum Opened<Children, Primitives> {
    /// Boxes and nodes.
    Inner(Children),
    /// The triangles in a leaf.
    Leaf(Primitives),
}

/// How far the box around a part of a triangle may be from a point that was computed on it, in a scene whose largest
/// |coordinate| is `scale`: parts are cut in double precision, which errs by less than 2⁻⁴⁸ of it.
pub(crate) fn slack_of_cut(scale: f32) -> f64 {
    f64::from(scale) * (1.0 / (1_u64 << 40) as f64)
}

impl<H: Hierarchy> Hierarchy for &H {
    type Primitives = H::Primitives;
    type Node = H::Node;
    fn primitives(&self) -> &H::Primitives {
        (**self).primitives()
    }
    fn root(&self) -> Option<H::Node> {
        (**self).root()
    }
    #[inline(always)]
    fn open(
        &self,
        node: H::Node,
    ) -> Opened<impl Iterator<Item = (Aabb, H::Node)>, impl Iterator<Item = Numbered>> {
        (**self).open(node)
    }
    #[inline(always)]
    fn number(&self, node: H::Node) -> usize {
        (**self).number(node)
    }
    fn slack(&self) -> f64 {
        (**self).slack()
    }
}

/// A closed box in double precision, in which everything below a node lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Smallest coordinates, world units.
    pub lower: [f64; 3],
    /// Largest coordinates, world units.
    pub upper: [f64; 3],
}

impl Extent {
    /// A box that is larger by `slack` on each side.
    #[inline(always)]
    pub fn new(bounds: &Aabb, slack: f64) -> Self {
        let Aabb { lower, upper } = bounds;
        let [a, b, c] = [lower.x, lower.y, lower.z].map(f64::from);
        let [d, e, f] = [upper.x, upper.y, upper.z].map(f64::from);
        Self {
            lower: [a - slack, b - slack, c - slack],
            upper: [d + slack, e + slack, f + slack],
        }
    }

    /// The box of a triangle.
    #[inline(always)]
    pub fn of(triangle: [Vec3; 3]) -> Self {
        Self::new(&Aabb::of(triangle), 0.0)
    }

    /// The square of the distance to a point, 0 inside. Rounded so that it is never more than the square that is computed for
    /// a triangle in the box (see `geometry/triangle/closest.rs`).
    #[inline(always)]
    pub fn distance_squared(&self, p: [f64; 3]) -> f64 {
        let [x, y, z] = [
            self.beyond(0, p[0]),
            self.beyond(1, p[1]),
            self.beyond(2, p[2]),
        ];
        x * x + y * y + z * z
    }
    /// How far a coordinate lies outside.
    #[inline(always)]
    fn beyond(&self, axis: usize, x: f64) -> f64 {
        let (below, above) = (self.lower[axis] - x, x - self.upper[axis]);
        let outside = if below > above { below } else { above };
        if outside > 0.0 { outside } else { 0.0 }
    }

    /// Whether both share a point.
    #[inline(always)]
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.lower[k] <= other.upper[k] && other.lower[k] <= self.upper[k])
    }
}
