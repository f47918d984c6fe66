//! How the boxes of a node's children lie in it.
//!
//! *How it works.* Whoever walks a wide tree asks a node for the planes across an axis, near ones and far ones, a lane for each
//! child, and need not know what they are made of: floats as they are, or [bytes on a grid](super::quantised::Quantised).

use crate::geometry::{Aabb, Vec3};
use crate::simd::{F, Floats, Lanes, Plain, Row, Rows};

/// The boxes of at most `N` children, as the tree's frame sees them.
pub trait Boxes<const N: usize>: Plain {
    /// Whether they are larger than those that they are made of: then they need not lie where the frame sees a float of the world.
    const ROUNDED: bool;
    /// Of some children; no ray enters the places of others.
    fn new(boxes: &[Aabb]) -> Self;
    /// The box of a child.
    fn bounds(&self, lane: usize) -> Aabb;
    /// The planes across an axis, first those that a ray meets first, which are in row `near`.
    fn planes<S: Lanes<N>>(&self, s: S, axis: usize, near: Row<N, 6>) -> [F<S, N>; 2];
    /// How far a ray goes for each child: to its `t_max`, or less than nowhere in a place without a child whose planes are not enough.
    fn ends<S: Lanes<N>>(&self, s: S, t_max: F<S, N>) -> F<S, N>;
    /// The sums of lower and upper planes, by axis.
    fn middles(&self) -> [[f32; N]; 3];
}

/// Lower x, upper x, lower y, upper y, lower z, upper z.
impl<const N: usize> Boxes<N> for Rows<N, 6> {
    const ROUNDED: bool = false;

    fn new(boxes: &[Aabb]) -> Self {
        let mut rows = Self([[0.0; N]; 6]);
        for lane in 0..N {
            // A box that no ray enters: its planes are at the wrong ends of everything.
            rows.set(lane, boxes.get(lane).unwrap_or(&Aabb::EMPTY));
        }
        rows
    }

    #[inline(always)]
    fn bounds(&self, lane: usize) -> Aabb {
        let side = |k: usize| Vec3::from([0, 2, 4].map(|axis| self.0[axis + k][lane]));
        Aabb::new(side(0), side(1))
    }

    #[inline(always)]
    fn planes<S: Lanes<N>>(&self, s: S, _: usize, near: Row<N, 6>) -> [F<S, N>; 2] {
        [
            F::<S, N>::load(s, self.at(near)),
            F::<S, N>::load(s, self.at(near.neighbour())),
        ]
    }

    #[inline(always)]
    fn ends<S: Lanes<N>>(&self, _: S, t_max: F<S, N>) -> F<S, N> {
        t_max
    }

    #[inline(always)]
    fn middles(&self) -> [[f32; N]; 3] {
        let mut middles = [[0.0; N]; 3];
        for (axis, row) in middles.iter_mut().enumerate() {
            for lane in 0..N {
                row[lane] = self.0[2 * axis][lane] + self.0[2 * axis + 1][lane];
            }
        }
        middles
    }
}

impl<const N: usize> Rows<N, 6> {
    /// Writes one box.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.0[2 * axis][lane] = bounds.lower[axis];
            self.0[2 * axis + 1][lane] = bounds.upper[axis];
        }
    }
}
