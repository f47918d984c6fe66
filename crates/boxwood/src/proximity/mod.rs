//! What is asked of space instead of along a ray: what is near, what reaches into a region, what is inside.
//!
//! *How it works.* A structure shows its nodes ([`Hierarchy`]); one walk ([`search`]) goes down them with any question
//! ([`Search`]); [`Proximity`] asks the usual ones, and every structure that shows its nodes has it. Trees that were built for
//! rays serve as they are.
//!
//! | question | answer |
//! |---|---|
//! | [`closest_point`](Proximity::closest_point), [`nearest`](Proximity::nearest), [`within`](Proximity::within) | points of triangles, by distance |
//! | [`overlapping`](Proximity::overlapping), [`overlaps`](Proximity::overlaps) | triangles that reach into a box, a [`Ball`], a [`ConvexRegion`] or your own [`Region`] |
//! | [`intersections`](Proximity::intersections), [`intersects`](Proximity::intersects) | pairs of triangles of two trees that meet; exact |
//! | [`winding`](Proximity::winding) | whether a point is inside a closed mesh; exact |
//! | [`winding_number`](Proximity::winding_number), [`FastWinding`] | whether it is inside one with holes |
//!
//! *Why every structure agrees to the bit.* What a triangle's answer is belongs to the triangle: it is computed in double
//! precision from its own corners, by the same operations everywhere, or decided by exact signs. Boxes only leave out. A box
//! is computed to be no farther than any triangle in it, without any slack, because all roundings are monotone
//! (`geometry/triangle/closest.rs`); so nothing that counts is left out. Equal distances are told apart by the lowest number.
//! Trees that cut triangles have boxes around parts; there, boxes are larger by a proven bound ([`Hierarchy::slack`]), and what
//! is met twice counts once. [`BruteForce`](crate::BruteForce), which has one leaf, is the judge.
//!
//! *What is legal.* An empty mesh is near nothing. Triangles without area are the segments and points that they look
//! like. A point that is infinite or NaN is near nothing and inside nothing. A radius is a closed bound; a negative or NaN
//! one reaches nothing, an infinite one everything. Nothing panics on data.
//!
//! ```
//! use boxwood::proximity::{Ball, Proximity};
//! use boxwood::{TriangleMesh, WideSah};
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let mesh = TriangleMesh::new(corners, [[0_u32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
//! let tree = WideSah::<8>::default().build(&mesh);
//! let closest = tree.closest_point([0.2, 0.1, -2.0]).expect("there are triangles");
//! assert_eq!((closest.distance, closest.primitive), (2.0, 0));
//! assert_eq!(tree.overlapping(&Ball::new([0.2, 0.2, 0.0], 0.1)), [0]);
//! assert!(tree.winding([0.1, 0.1, 0.1]).is_inside() && !tree.winding([1.0, 1.0, 1.0]).is_inside());
//! # Ok::<(), boxwood::MeshError>(())
//! ```

mod convex;
mod hierarchy;
mod inside;
mod nearest;
mod overlap;
mod pairs;
mod search;
mod winding;

pub use convex::{ConvexRegion, HalfSpace};
pub(crate) use hierarchy::slack_of_cut;
pub use hierarchy::{Extent, Hierarchy, Numbered, Opened};
pub use inside::{Crossings, Winding};
pub use nearest::{Closest, ClosestPoint, Nearest, Within};
pub use overlap::{Ball, Overlapping, Region};
pub use search::{Search, search};
pub use winding::FastWinding;

use crate::geometry::Vec3;
use crate::query::each_chunk;
use crate::simd::exactly;
use alloc::vec::Vec;
use search::search_with;

/// Points per chunk of a batch: enough to keep a stack, few enough to share out.
const CHUNK: usize = 256;

/// What every structure that shows its nodes answers.
///
/// Everything here is answered in the float mode that exact answers need, whatever mode the caller's thread is in (see
/// [`exactly`]). The batch calls take slices of points and run in the caller's rayon pool when the feature `parallel` is on;
/// answers do not depend on the threads.
pub trait Proximity: Hierarchy {
    /// The closest point of all triangles; of several triangles at one distance that of the one with the lowest number.
    /// `None` where there are no triangles, or the point is infinite or NaN.
    fn closest_point(&self, point: impl Into<[f32; 3]>) -> Option<ClosestPoint> {
        self.closest_point_within(point, f32::INFINITY)
    }

    /// The same, no farther away than `radius` (world units, closed).
    fn closest_point_within(
        &self,
        point: impl Into<[f32; 3]>,
        radius: f32,
    ) -> Option<ClosestPoint> {
        let point = point.into().into();
        exactly(|| asked(self, Closest::new(point, radius), &mut Vec::new()).found())
    }

    /// The closest points of the `k` closest triangles, nearest first, then by number; fewer where there are fewer.
    ///
    /// ```
    /// # use boxwood::{BruteForce, TriangleMesh, proximity::Proximity};
    /// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    /// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2], [1, 3, 2]])?;
    /// let found = BruteForce::new(&mesh).nearest([-1.0, 0.0, 0.0], 5);
    /// let distances: Vec<_> = found.iter().map(|p| (p.distance, p.primitive)).collect();
    /// assert_eq!(distances, [(1.0, 0), (1.4142135, 1)]);
    /// # Ok::<(), boxwood::MeshError>(())
    /// ```
    fn nearest(&self, point: impl Into<[f32; 3]>, k: usize) -> Vec<ClosestPoint> {
        let point = point.into().into();
        exactly(|| asked(self, Nearest::new(point, k, f32::INFINITY), &mut Vec::new()).found())
    }

    /// The closest points of all triangles within `radius` (world units, closed), nearest first, then by number.
    ///
    /// ```
    /// # use boxwood::{BruteForce, TriangleMesh, proximity::Proximity};
    /// let mesh = TriangleMesh::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0_u32, 1, 2]])?;
    /// let judge = BruteForce::new(&mesh);
    /// assert_eq!(judge.within([0.0, 0.0, 2.0], 2.0).len(), 1);
    /// assert_eq!(judge.within([0.0, 0.0, 2.0], 1.9).len(), 0);
    /// # Ok::<(), boxwood::MeshError>(())
    /// ```
    fn within(&self, point: impl Into<[f32; 3]>, radius: f32) -> Vec<ClosestPoint> {
        let point = point.into().into();
        exactly(|| asked(self, Within::new(point, radius), &mut Vec::new()).found())
    }

    /// The triangles that reach into a region, in ascending order; touching counts.
    ///
    /// ```
    /// # use boxwood::{Aabb, BruteForce, TriangleMesh, proximity::Proximity};
    /// let mesh = TriangleMesh::new([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]], [[0_u32, 1, 2]])?;
    /// let judge = BruteForce::new(&mesh);
    /// assert_eq!(judge.overlapping(&Aabb::new([2.0, 2.0, 0.0], [3.0; 3])), [0]);
    /// assert_eq!(judge.overlapping(&Aabb::new([2.5, 2.5, 0.0], [3.0; 3])), []);
    /// # Ok::<(), boxwood::MeshError>(())
    /// ```
    fn overlapping(&self, region: &impl Region) -> Vec<u32> {
        exactly(|| asked(self, Overlapping::new(region), &mut Vec::new()).found())
    }

    /// Whether any triangle reaches into a region.
    fn overlaps(&self, region: &impl Region) -> bool {
        exactly(|| {
            !asked(self, Overlapping::any(region), &mut Vec::new())
                .found()
                .is_empty()
        })
    }

    /// All pairs of a triangle of this tree and one of the other that share a point, in ascending order. Exact: touching
    /// counts, a gap of a rounding does not. Asked of a tree and itself, it includes each triangle with itself and with its
    /// neighbours.
    ///
    /// ```
    /// # use boxwood::{BruteForce, TriangleMesh, proximity::Proximity};
    /// let flat = TriangleMesh::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0_u32, 1, 2]])?;
    /// let upright = TriangleMesh::new([[0.1, 0.1, 0.0], [0.1, 0.2, 1.0], [0.2, 0.1, 1.0]], [[0_u32, 1, 2]])?;
    /// assert_eq!(BruteForce::new(&flat).intersections(&BruteForce::new(&upright)), [[0, 0]]);
    /// # Ok::<(), boxwood::MeshError>(())
    /// ```
    fn intersections(&self, other: &impl Hierarchy) -> Vec<[u32; 2]> {
        exactly(|| pairs::all(self, other))
    }

    /// Whether any triangle of this tree shares a point with one of the other. Exact.
    fn intersects(&self, other: &impl Hierarchy) -> bool {
        exactly(|| pairs::any(self, other))
    }

    /// How often the surface winds around a point, and whether the point lies on it. Exact for meshes without borders; see
    /// [`Winding`].
    fn winding(&self, point: impl Into<[f32; 3]>) -> Winding {
        let point = point.into().into();
        exactly(|| asked(self, Crossings::new(point), &mut Vec::new()).winding())
    }

    /// The generalised winding number: nearly 1 inside a closed mesh and nearly 0 outside, and in between near holes, where
    /// 1/2 is the natural bound. NaN for a point that is infinite or NaN.
    ///
    /// Looks at every triangle, whatever the tree, and returns the same bits for each; [`FastWinding`] is for many points.
    fn winding_number(&self, point: impl Into<[f32; 3]>) -> f64 {
        let point = point.into().into();
        exactly(|| winding::exact(self.primitives(), point))
    }

    /// [`Proximity::closest_point`] of many points.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn closest_points<P: Into<[f32; 3]> + Copy + Sync>(
        &self,
        points: &[P],
        answers: &mut [Option<ClosestPoint>],
    ) where
        Self: Sync,
    {
        each(
            self,
            points,
            answers,
            |p| Closest::new(p, f32::INFINITY),
            |found| found.found(),
        );
    }

    /// [`Proximity::nearest`] of many points.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn nearest_each<P: Into<[f32; 3]> + Copy + Sync>(
        &self,
        points: &[P],
        k: usize,
        answers: &mut [Vec<ClosestPoint>],
    ) where
        Self: Sync,
    {
        each(
            self,
            points,
            answers,
            |p| Nearest::new(p, k, f32::INFINITY),
            |found| found.found(),
        );
    }

    /// [`Proximity::within`] of many points.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn within_each<P: Into<[f32; 3]> + Copy + Sync>(
        &self,
        points: &[P],
        radius: f32,
        answers: &mut [Vec<ClosestPoint>],
    ) where
        Self: Sync,
    {
        each(
            self,
            points,
            answers,
            |p| Within::new(p, radius),
            Within::found,
        );
    }

    /// [`Proximity::winding`] of many points.
    ///
    /// # Panics
    /// When the slices differ in length.
    fn windings<P: Into<[f32; 3]> + Copy + Sync>(&self, points: &[P], answers: &mut [Winding])
    where
        Self: Sync,
    {
        each(self, points, answers, Crossings::new, Crossings::winding);
    }
}

impl<H: Hierarchy> Proximity for H {}

/// A question with its answers.
fn asked<H: Hierarchy, S: Search>(tree: &H, mut question: S, stack: &mut Vec<(f64, H::Node)>) -> S {
    search_with(tree, &mut question, &mut (), stack);
    question
}

/// The same question from many points.
fn each<H: Hierarchy + Sync, P: Into<[f32; 3]> + Copy + Sync, S: Search, A: Send>(
    tree: &H,
    points: &[P],
    answers: &mut [A],
    question: impl Fn(Vec3) -> S + Sync + Send,
    answer: impl Fn(S) -> A + Sync + Send,
) {
    assert_eq!(points.len(), answers.len(), "one answer per point");
    each_chunk(CHUNK, points, answers, |points, answers| {
        let mut stack = Vec::new();
        for (point, place) in points.iter().zip(answers) {
            *place = answer(asked(tree, question((*point).into().into()), &mut stack));
        }
    });
}
