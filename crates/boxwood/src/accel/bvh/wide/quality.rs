//! How much time a wide tree is worth.

use core::fmt;
use core::str::FromStr;

/// What makes the binary tree that a wide one is collapsed from.
///
/// As text: `fast`, `balanced`, `high`, `ultra`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Along a Morton curve ([`Lbvh`](crate::Lbvh)): for scenes that are built anew for every picture.
    Fast,
    /// The binned surface-area heuristic ([`BinnedSah`](crate::BinnedSah)).
    #[default]
    Balanced,
    /// The same, and two rounds of reinsertion: for millions of rays.
    High,
    /// Spatial splits ([`SpatialSplit`](crate::SpatialSplit)) where primitives are long, and two rounds of reinsertion: for very many rays.
    /// Where few boxes are entered in vain ([`Survey`](crate::Survey)) nothing is cut, and it is the same as [`High`](Self::High).
    Ultra,
}

impl Quality {
    /// From the fastest to build to the fastest to trace.
    pub const ALL: [Self; 4] = [Self::Fast, Self::Balanced, Self::High, Self::Ultra];

    /// Rounds of reinsertion that are done in any case.
    pub(super) fn rounds(self) -> usize {
        match self {
            Self::Fast | Self::Balanced => 0,
            Self::High | Self::Ultra => 2,
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::High => "high",
            Self::Ultra => "ultra",
        })
    }
}

/// A text that names no quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a quality is `fast`, `balanced`, `high` or `ultra`")]
pub struct UnknownQuality;

impl FromStr for Quality {
    type Err = UnknownQuality;
    fn from_str(text: &str) -> Result<Self, UnknownQuality> {
        match text {
            "fast" => Ok(Self::Fast),
            "balanced" => Ok(Self::Balanced),
            "high" => Ok(Self::High),
            "ultra" => Ok(Self::Ultra),
            _ => Err(UnknownQuality),
        }
    }
}
