//! How a wide node finds its children.

use core::fmt;
use core::str::FromStr;

/// How the nodes of a binary tree are gathered into wide ones.
///
/// As text: `optimal`, `greedy`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gathering {
    /// At the least expected cost, found for every subtree and number of places (Ylitie, Karras & Laine 2017).
    #[default]
    Optimal,
    /// Always the child with the largest surface is replaced by its two, until all places are taken (Wald, Benthin & Boulos
    /// 2008): built a little faster, walked a little slower.
    Greedy,
}

impl fmt::Display for Gathering {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Optimal => "optimal",
            Self::Greedy => "greedy",
        })
    }
}

/// A text that names no way of gathering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("nodes are gathered in a way that is `optimal` or `greedy`")]
pub struct UnknownGathering;

impl FromStr for Gathering {
    type Err = UnknownGathering;
    fn from_str(text: &str) -> Result<Self, UnknownGathering> {
        match text {
            "optimal" => Ok(Self::Optimal),
            "greedy" => Ok(Self::Greedy),
            _ => Err(UnknownGathering),
        }
    }
}
