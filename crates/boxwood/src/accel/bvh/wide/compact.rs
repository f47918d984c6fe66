//! The builder of compact trees by name.

use super::{CompactBvh, Gathering, Precision, Quality, WideSah};
use crate::accel::bvh::Refine;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::{Limits, unlimited};
use crate::accel::settings::{Setting, Settings};
use crate::accel::{Axes, BuildError};
use crate::primitive::Primitives;
use crate::query::Intersect;
use crate::simd::Isa;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// A [`CompactBvh`]: the tree of a [`WideSah`] of 8 children with quantised boxes, and leaves that hold numbers.
///
/// ```
/// use boxwood::{CompactBvh, CompactSah, Intersect, Ray, TriangleMesh};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
/// let bvh: CompactBvh<&TriangleMesh> = CompactSah::default().build(&mesh);
/// let hit = bvh.closest_hit(&Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]));
/// assert_eq!(hit.map(|hit| hit.t), Some(1.0));
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompactSah {
    /// What makes the binary tree.
    pub quality: Quality,
    /// Bins per axis, 2 to 64, of all qualities but the lowest.
    pub bins: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the binary tree before it is collapsed.
    pub refine: Refine,
    /// How the nodes of the binary tree are gathered into wide ones.
    pub gathering: Gathering,
    /// What the tree is walked with.
    pub isa: Isa,
}

impl Default for CompactSah {
    fn default() -> Self {
        let WideSah {
            quality,
            bins,
            axes,
            refine,
            gathering,
            isa,
            rebraid: _,
            precision: _,
        } = WideSah::<8>::default();
        Self {
            quality,
            bins,
            axes,
            refine,
            gathering,
            isa,
        }
    }
}

impl CompactSah {
    /// Builds the structure.
    ///
    /// # Panics
    /// When there are more than a quarter of a billion primitives.
    pub fn build<P: Primitives + Sync>(&self, primitives: P) -> CompactBvh<P> {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Builds the structure within limits.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within<P: Primitives + Sync>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<CompactBvh<P>, BuildError> {
        let wide = WideSah::<8> {
            quality: self.quality,
            bins: self.bins,
            axes: self.axes,
            refine: self.refine,
            gathering: self.gathering,
            isa: self.isa,
            // What lies small holds its objects whole.
            rebraid: 1,
            precision: Precision::Exact,
        };
        wide.laid_out(primitives, limits)
    }
}

impl<P: Primitives + Sync> CompactBvh<P> {
    /// Lays a tree out that a builder of this crate made for these primitives. [`inspect::validate`](crate::inspect::validate) looks at
    /// trees from elsewhere.
    ///
    /// # Panics
    /// As [`WideBvh::new`](super::WideBvh::new).
    pub fn of(primitives: P, tree: &BinaryTree) -> Self {
        unlimited(Self::within(
            primitives,
            tree,
            Gathering::Optimal,
            &Limits::NONE,
        ))
    }
}

impl Settings for CompactSah {
    const NAME: &'static str = "compact";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        let mut all = Vec::from([
            Setting::new("quality", &mut self.quality),
            Setting::count("bins", &mut self.bins, 2..=64),
            Setting::axes(&mut self.axes),
            Setting::new("gathering", &mut self.gathering),
            Setting::new("isa", &mut self.isa),
        ]);
        all.extend(self.refine.settings());
        all
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        Ok(Box::new(self.build_within(primitives, limits)?))
    }
}
