//! What a picture can show of a scene besides light.

mod colour_map;
mod digits;
mod heat_map;
pub(crate) mod legend;

pub use colour_map::{inferno, inferno_srgb};
pub use heat_map::HeatScale;

use std::fmt;
use std::str::FromStr;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum View {
    /// Light.
    #[default]
    Shaded,
    /// Shading normals in world space, −1 to 1 as dark to bright.
    Normals,
    /// Distance along the view, near bright and far dark.
    Depth,
    /// A colour for each triangle of the file.
    Primitives,
    /// A colour for each material.
    Materials,
    /// Base colours.
    Albedo,
    /// How many nodes were opened and primitives tested, with a legend.
    Cost,
}

impl View {
    /// All views, in the order of their names in help texts.
    pub const ALL: [Self; 7] = [
        Self::Shaded,
        Self::Normals,
        Self::Depth,
        Self::Primitives,
        Self::Materials,
        Self::Albedo,
        Self::Cost,
    ];

    /// As a user writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shaded => "shaded",
            Self::Normals => "normals",
            Self::Depth => "depth",
            Self::Primitives => "primitives",
            Self::Materials => "materials",
            Self::Albedo => "albedo",
            Self::Cost => "cost",
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// No view has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no view is called `{0}`; there are shaded, normals, depth, primitives, materials, albedo and cost"
)]
pub struct UnknownView(String);

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(text: &str) -> Result<Self, UnknownView> {
        let found = Self::ALL.into_iter().find(|view| view.name() == text);
        found.ok_or_else(|| UnknownView(text.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_both_ways() {
        for view in View::ALL {
            assert_eq!(view.to_string().parse(), Ok(view));
        }
        let error = "xray"
            .parse::<View>()
            .expect_err("no such view")
            .to_string();
        for view in View::ALL {
            assert!(error.contains(view.name()), "{error}");
        }
    }
}
