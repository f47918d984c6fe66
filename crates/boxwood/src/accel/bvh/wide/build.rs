//! Builders of wide trees by name.

use super::leaf::Leaves;
use super::{Gathering, Layout, Precision, Quality, Survey, WideBvh, braid};
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::bvh::{BinnedSah, Lbvh, Refine, SpatialSplit};
use crate::accel::limits::{Limits, unlimited};
use crate::accel::settings::{Setting, Settings, Value};
use crate::accel::{Axes, BuildError};
use crate::primitive::Primitives;
use crate::query::Intersect;
use crate::simd::{Isa, Level, Vectorize, exactly};
use alloc::boxed::Box;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::ops::ControlFlow::Continue;

/// A wide tree of `N` children (8 or 16): a binary tree of the quality that is asked for, by default from the binned surface-area heuristic, collapsed at the least
/// expected cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WideSah<const N: usize> {
    /// What makes the binary tree.
    pub quality: Quality,
    /// Bins per axis, 2 to 64, of all qualities but the lowest.
    pub bins: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the binary tree before it is collapsed.
    pub refine: Refine,
    /// How many leaves there may be for each placed object, on average, where objects that overlap are opened and lie in the tree part by part; 1
    /// leaves all of them whole. There are at most 4096 leaves more than objects. Other primitives are always whole. What moves should be: after an
    /// [update](WideBvh::update) each leaf shows all of its object.
    pub rebraid: usize,
    /// How the nodes of the binary tree are gathered into wide ones.
    pub gathering: Gathering,
    /// What the tree is walked with.
    pub isa: Isa,
    /// How exactly boxes and triangles are met.
    pub precision: Precision,
}

impl<const N: usize> Default for WideSah<N> {
    fn default() -> Self {
        Self {
            quality: Quality::Balanced,
            bins: 32,
            axes: Axes::XYZ,
            refine: Refine::NONE,
            rebraid: 8,
            gathering: Gathering::Optimal,
            isa: Isa::best(),
            precision: Precision::Exact,
        }
    }
}

impl<const N: usize> WideSah<N> {
    /// Raised whenever the same settings make another tree of the same primitives: what is kept under the settings' names, in a cache,
    /// should have this in the name too.
    pub const REVISION: u32 = 2;

    /// What makes parts of the binary tree anew, of whole primitives.
    pub(super) fn binary<P: Primitives>(&self) -> BinnedSah {
        BinnedSah {
            bins: self.bins,
            max_leaf: Self::max_leaf::<P>(),
            block: Self::max_leaf::<P>(),
            axes: self.axes,
            refine: self.refinement(),
        }
    }

    /// Most primitives in a leaf of the binary tree.
    fn max_leaf<P: Primitives>() -> usize {
        if P::COMPOSITE { 1 } else { Leaves::LANES }
    }

    /// What is done to the binary tree.
    fn refinement(&self) -> Refine {
        Refine {
            reinsert: self.refine.reinsert.max(self.quality.rounds()),
            ..self.refine
        }
    }

    /// Makes the binary tree.
    fn tree<P: Primitives + Sync>(
        &self,
        primitives: &P,
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let (axes, refine, max_leaf) = (self.axes, self.refinement(), Self::max_leaf::<P>());
        match self.quality {
            Quality::Fast => Lbvh {
                max_leaf,
                block: Leaves::LANES,
                axes,
                refine,
            }
            .build_within(primitives, limits),
            Quality::Ultra if !P::COMPOSITE && Survey::of(primitives).splits_pay() => {
                self.with_splits().build_within(primitives, limits)
            }
            _ => self.binary::<P>().build_within(primitives, limits),
        }
    }

    /// What makes the binary tree of the highest quality where splits pay.
    fn with_splits(&self) -> SpatialSplit {
        SpatialSplit {
            object_bins: self.bins,
            max_leaf: Leaves::LANES,
            block: Leaves::LANES,
            axes: self.axes,
            refine: self.refinement(),
            ..SpatialSplit::default()
        }
    }

    /// The bytes that primitives take at the worst moment of a build: the binary tree's, which is larger than a wide one and what
    /// collapsing takes.
    pub(super) fn peak_bytes(&self, survey: &Survey) -> usize {
        let count = survey.primitives;
        let bytes = match self.quality {
            Quality::Fast => Lbvh::bytes(count),
            Quality::Ultra if survey.splits_pay() => self.with_splits().bytes(count),
            _ => BinnedSah::bytes(count),
        };
        // Where each has a leaf of its own, the binary tree is four times as large as others when it is refined and collapsed.
        if survey.composite { 2 * bytes } else { bytes }
    }
}

impl<const N: usize> WideSah<N>
where
    Level: Vectorize<N>,
{
    /// Builds the structure.
    ///
    /// # Panics
    /// When there are more than a quarter of a billion primitives.
    pub fn build<P: Primitives + Sync>(&self, primitives: P) -> WideBvh<P, N> {
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
    ) -> Result<WideBvh<P, N>, BuildError> {
        let bvh: WideBvh<P, N> = self.laid_out(primitives, limits)?;
        Ok(bvh.with_precision(self.precision))
    }

    /// The same in any layout, looked at exactly.
    pub(super) fn laid_out<P: Primitives + Sync, L: Layout>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<WideBvh<P, N, L>, BuildError> {
        // The tree is the greater part of the work.
        let watch = |share: f32| limits.watch.map_or(Continue(()), |watch| watch(share));
        let opens = P::COMPOSITE && self.rebraid > 1;
        let begun = if opens { OPENING } else { 0.0 };
        let entries = if opens {
            let opening = Limits {
                watch: Some(&|share| watch(OPENING * share)),
                ..*limits
            };
            exactly(|| braid::entries(&primitives, self.axes, self.rebraid, &opening))?
        } else {
            None
        };
        let memory = limits.memory.map(|most| {
            let taken = entries.as_ref().map_or(0, braid::Entries::bytes);
            most.saturating_sub(taken)
        });
        let for_tree = Limits {
            watch: Some(&|share| watch(begun + (TREE - begun) * share)),
            memory,
        };
        let rest = Limits {
            watch: Some(&|share| watch(TREE + (1.0 - TREE) * share)),
            memory,
        };
        let built = match entries {
            Some(entries) => {
                let tree = self.tree(&entries, &for_tree)?;
                WideBvh::braided(self, primitives, entries, &tree, &rest)?
            }
            None => {
                let tree = self.tree(&primitives, &for_tree)?;
                WideBvh::within(primitives, &tree, self.gathering, &rest)?
            }
        };
        Ok(built.with_isa(self.isa))
    }
}

impl Value for &mut Isa {
    fn read(&mut self, text: &str) -> bool {
        text.parse().map(|isa| **self = isa).is_ok()
    }
    fn write(&self) -> String {
        self.to_string()
    }
    fn expected(&self) -> String {
        // The same text on every machine, so that documentation is too.
        "portable|avx2|avx512|neon|simd128".into()
    }
}

impl Value for &mut Gathering {
    fn read(&mut self, text: &str) -> bool {
        text.parse().map(|gathering| **self = gathering).is_ok()
    }
    fn write(&self) -> String {
        self.to_string()
    }
    fn expected(&self) -> String {
        "optimal|greedy".into()
    }
}

impl Value for &mut Quality {
    fn read(&mut self, text: &str) -> bool {
        text.parse().map(|quality| **self = quality).is_ok()
    }
    fn write(&self) -> String {
        self.to_string()
    }
    fn expected(&self) -> String {
        Quality::ALL.map(|quality| quality.to_string()).join("|")
    }
}

impl Value for &mut Precision {
    fn read(&mut self, text: &str) -> bool {
        text.parse().map(|precision| **self = precision).is_ok()
    }
    fn write(&self) -> String {
        self.to_string()
    }
    fn expected(&self) -> String {
        "exact|fast".into()
    }
}

/// Which share of the work is done when placed objects have been opened.
const OPENING: f32 = 0.25;
/// Which share of the work is done when the binary tree is.
const TREE: f32 = 0.75;

macro_rules! named {
    ($($n:literal: $name:literal),*) => {$(
        impl Settings for WideSah<$n> {
            const NAME: &'static str = $name;
            fn settings(&mut self) -> Vec<Setting<'_>> {
                let mut all = Vec::from([
                    Setting::new("quality", &mut self.quality),
                    Setting::count("bins", &mut self.bins, 2..=64),
                    Setting::axes(&mut self.axes),
                    Setting::count("rebraid", &mut self.rebraid, 1..=64),
                    Setting::new("gathering", &mut self.gathering),
                    Setting::new("isa", &mut self.isa),
                    Setting::new("precision", &mut self.precision),
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
    )*};
}
named!(8: "wide8", 16: "wide16");
