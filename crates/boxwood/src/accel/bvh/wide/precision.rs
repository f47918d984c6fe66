//! How exactly a wide tree looks: as the law wants it, or a little faster.

use crate::geometry::PreparedRay;
use core::fmt;
use core::str::FromStr;

/// How exactly boxes and triangles are met.
///
/// As text: `exact`, `fast`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Every answer has the bits of the exhaustive test, and no ray slips through an edge.
    #[default]
    Exact,
    /// Boxes without slack and edges without the errors of their products: a ray that is aimed at an edge or a corner may
    /// slip through or meet the neighbour, as with most libraries. The answers are no longer those of other structures, and
    /// they may depend on the instruction set and on the way of asking. Only meshes and tame rays are met so; other primitives and
    /// rays exactly, and explaining and counting go the exact way or the portable one.
    Fast,
}

impl Precision {
    /// Whether the law of equal answers holds.
    pub fn is_exact(self) -> bool {
        self == Self::Exact
    }

    /// How many units the slack of boxes is.
    #[inline(always)]
    pub(crate) fn slack(self) -> f32 {
        match self {
            Self::Exact => PreparedRay::SLACK,
            Self::Fast => 0.0,
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Exact => "exact",
            Self::Fast => "fast",
        })
    }
}

/// A text that names no precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a precision is `exact` or `fast`")]
pub struct UnknownPrecision;

impl FromStr for Precision {
    type Err = UnknownPrecision;
    fn from_str(text: &str) -> Result<Self, UnknownPrecision> {
        match text {
            "exact" => Ok(Self::Exact),
            "fast" => Ok(Self::Fast),
            _ => Err(UnknownPrecision),
        }
    }
}
