//! Names for structures and their settings: what the command line and Python speak.

use super::boxes::ObjectBoxes;
use super::brute_force::Exhaustive;
use super::bsp_tree::BspSah;
use super::bvh::{
    BinnedSah, CompactSah, EqualCounts, Forecast, Lbvh, Median, Middle, Ploc, SpatialSplit, Survey,
    SweepSah, WideSah,
};
use super::grid::GridBuilder;
use super::kd_tree::{KdLecture, KdSah};
use super::octree::OctreeBuilder;
use super::settings::{self, Settings};
use super::two_level_grid::TwoLevelGridBuilder;
use super::{BuildError, Limits, limits};
use crate::primitive::Primitives;
use crate::query::Intersect;
use alloc::borrow::Cow;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString};
use core::fmt;
use core::str::FromStr;

/// One line per structure: everything else follows from its builder's [`Settings`].
macro_rules! kinds {
    ($($(#[$doc:meta])* $variant:ident($builder:ty),)*) => {
        /// A structure by name, with its settings: `NAME[:SETTING[,SETTING]…]`.
        ///
        /// The names are those of [`StructureKind::all`]; `bvh` alone is `bvh:binned`. What settings a structure has,
        /// says [`StructureKind::settings`].
        ///
        /// ```
        /// use boxwood::StructureKind;
        /// let kind: StructureKind = "bvh:binned,bins=32".parse()?;
        /// assert_eq!(kind.to_string(), "bvh:binned,bins=32");
        /// assert_eq!("bvh".parse::<StructureKind>()?, StructureKind::default());
        /// # Ok::<(), boxwood::UnknownStructure>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum StructureKind {
            $($(#[$doc])* $variant($builder),)*
        }

        impl StructureKind {
            /// All of them with their default settings: one table for printing, help texts and tests.
            pub fn all() -> impl Iterator<Item = Self> {
                [$(Self::$variant(<$builder>::default()),)*].into_iter()
            }
            /// The name without settings.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => <$builder as Settings>::NAME,)*
                }
            }
            /// What settings there are and what fits: `bins=2…64, leaf=1…64, axes=xyz, …`.
            pub fn settings(&self) -> String {
                match self {
                    $(Self::$variant(_) => settings::known::<$builder>(),)*
                }
            }
            /// Builds the structure. Pass `&mesh`, `Arc<mesh>` or the mesh itself.
            ///
            /// # Errors
            /// When the limits end the build.
            pub fn build_within<'a, P: Primitives + Send + Sync + 'a>(
                &self,
                primitives: P,
                limits: &Limits<'_>,
            ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
                match self {
                    $(Self::$variant(builder) => builder.structure(primitives, limits),)*
                }
            }
            fn read<'t>(
                name: &str,
                settings: impl IntoIterator<Item = &'t str>,
            ) -> Result<Self, UnknownStructure> {
                $(if name == <$builder as Settings>::NAME {
                    return settings::read(settings).map(Self::$variant);
                })*
                let known = Self::all().map(|kind| kind.name());
                Err(UnknownStructure::Name {
                    name: name.to_string(),
                    known: known.collect::<alloc::vec::Vec<_>>().join(", "),
                })
            }
        }

        impl fmt::Display for StructureKind {
            /// Names those settings that are not the default.
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self {
                    $(Self::$variant(builder) => settings::write(builder, f),)*
                }
            }
        }
    };
}

kinds! {
    /// The judge: [`BruteForce`](super::brute_force::BruteForce).
    BruteForce(Exhaustive),
    /// [`BoundingBoxes`](super::boxes::BoundingBoxes).
    Boxes(ObjectBoxes),
    /// [`UniformGrid`](super::grid::UniformGrid).
    Grid(GridBuilder),
    /// [`TwoLevelGrid`](super::two_level_grid::TwoLevelGrid).
    TwoLevelGrid(TwoLevelGridBuilder),
    /// [`Octree`](super::octree::Octree).
    Octree(OctreeBuilder),
    /// [`KdTree`](super::kd_tree::KdTree) over [`KdLecture`].
    KdLecture(KdLecture),
    /// [`KdTree`](super::kd_tree::KdTree) over [`KdSah`].
    KdSah(KdSah),
    /// [`BspTree`](super::bsp_tree::BspTree).
    Bsp(BspSah),
    /// [`Bvh`](super::bvh::Bvh) over [`Median`].
    Median(Median),
    /// [`Bvh`](super::bvh::Bvh) over [`Middle`].
    Middle(Middle),
    /// [`Bvh`](super::bvh::Bvh) over [`EqualCounts`].
    EqualCounts(EqualCounts),
    /// [`Bvh`](super::bvh::Bvh) over [`SweepSah`].
    Sweep(SweepSah),
    /// [`Bvh`](super::bvh::Bvh) over [`BinnedSah`].
    Binned(BinnedSah),
    /// [`Bvh`](super::bvh::Bvh) over [`Lbvh`].
    Lbvh(Lbvh),
    /// [`Bvh`](super::bvh::Bvh) over [`Ploc`].
    Ploc(Ploc),
    /// [`Bvh`](super::bvh::Bvh) over [`SpatialSplit`].
    SpatialSplit(SpatialSplit),
    /// [`WideBvh`](super::bvh::WideBvh) with nodes of 8 children.
    Wide8(WideSah<8>),
    /// [`WideBvh`](super::bvh::WideBvh) with nodes of 16 children.
    Wide16(WideSah<16>),
    /// [`CompactBvh`](super::bvh::CompactBvh).
    Compact(CompactSah),
}

/// What a name without a method means.
const DEFAULT_METHODS: [(&str, &str); 2] = [("bvh", "binned"), ("kd", "sah")];

impl Default for StructureKind {
    fn default() -> Self {
        Self::Binned(BinnedSah::default())
    }
}

impl StructureKind {
    /// Whether its answers have the bits of the exhaustive test. All have, but for wide trees with
    /// [`Precision::Fast`](super::bvh::Precision::Fast).
    pub fn is_exact(&self) -> bool {
        match self {
            Self::Wide8(wide) => wide.precision.is_exact(),
            Self::Wide16(wide) => wide.precision.is_exact(),
            _ => true,
        }
    }

    /// What building and tracing it is expected to take by so many threads; `None` where there is no model of costs: of all but wide
    /// trees whose binary tree is made by a [`Quality`](super::bvh::Quality) and no other setting.
    pub fn forecast(&self, survey: &Survey, threads: usize) -> Option<Forecast> {
        match self {
            Self::Wide8(wide) => wide.forecast(survey, threads),
            Self::Wide16(wide) => wide.forecast(survey, threads),
            _ => None,
        }
    }

    /// Builds the structure without limits. Pass `&mesh`, `Arc<mesh>` or the mesh itself.
    pub fn build<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
    ) -> Box<dyn Intersect + 'a> {
        limits::unlimited(self.build_within(primitives, &Limits::NONE))
    }
}

/// Why a text names no structure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnknownStructure {
    /// No structure has this name.
    #[error("no structure is called `{name}`; there are {known}")]
    Name {
        /// The name.
        name: String,
        /// What there is.
        known: String,
    },
    /// The structure has no such setting.
    #[error("`{structure}` has no setting `{setting}`; it has {known}")]
    Setting {
        /// The structure.
        structure: &'static str,
        /// The text between the commas.
        setting: String,
        /// What there is.
        known: String,
    },
    /// The value does not fit.
    #[error("`{setting}` does not fit: expected {expected}")]
    Value {
        /// The text between the commas.
        setting: String,
        /// What fits.
        expected: String,
    },
}

impl FromStr for StructureKind {
    type Err = UnknownStructure;

    fn from_str(text: &str) -> Result<Self, UnknownStructure> {
        let (family, settings) = text.split_once(':').unwrap_or((text, ""));
        let mut settings = settings.split(',').filter(|s| !s.is_empty()).peekable();
        let default = DEFAULT_METHODS.iter().find(|(name, _)| *name == family);
        // The method comes first; without one it is the family's default.
        let method = settings
            .next_if(|s| !s.contains('='))
            .or(default.map(|(_, method)| *method));
        let name = match method {
            Some(method) => Cow::Owned(format!("{family}:{method}")),
            None => Cow::Borrowed(family),
        };
        Self::read(&name, settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_both_ways() {
        for kind in StructureKind::all() {
            assert_eq!(kind.to_string(), kind.name());
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        for text in [
            "brute",
            "bvh:median,leaf=1",
            "bvh:binned,bins=8,leaf=2,axes=xy",
        ] {
            let kind: StructureKind = text.parse().expect("a good name");
            assert_eq!(kind.to_string(), text);
        }
        assert_eq!(
            "bvh:leaf=3".parse::<StructureKind>().map(|k| k.to_string()),
            Ok("bvh:binned,leaf=3".to_string())
        );
    }

    #[test]
    fn errors_say_what_there_is() {
        let error = |text: &str| {
            let parsed = text.parse::<StructureKind>();
            parsed.expect_err("no such structure").to_string()
        };
        assert!(
            error("quadtree").starts_with("no structure is called `quadtree`; there are brute, ")
        );
        assert!(error("bvh:quick").starts_with("no structure is called `bvh:quick`"));
        assert_eq!(
            error("bvh:median,bins=3"),
            "`bvh:median` has no setting `bins=3`; it has leaf=1…64 and axes=xyz"
        );
        assert_eq!(error("bvh:leaf=0"), "`leaf=0` does not fit: expected 1…64");
        assert!(error("brute:1").starts_with("no structure is called `brute:1`"));
        assert_eq!(
            error("brute:x=1"),
            "`brute` has no setting `x=1`; it has none"
        );
    }
}
