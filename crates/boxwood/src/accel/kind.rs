//! Names for structures and their settings: what the command line and Python speak.

use super::brute_force::BruteForce;
use super::bvh::{BinnedSah, Bvh, Median};
use crate::primitive::Primitives;
use crate::query::Intersect;
use alloc::boxed::Box;
use alloc::string::{String, ToString};
use core::fmt;
use core::str::FromStr;

/// A structure by name, with its settings: `NAME[:SETTING[,SETTING]…]`.
///
/// | text | structure |
/// |---|---|
/// | `brute` | [`BruteForce`], the judge |
/// | `bvh`, `bvh:binned` | [`Bvh`] over [`BinnedSah`]; settings `bins=16`, `leaf=8` |
/// | `bvh:median` | [`Bvh`] over [`Median`]; setting `leaf=5` |
///
/// ```
/// use boxwood::StructureKind;
/// let kind: StructureKind = "bvh:binned,bins=32".parse()?;
/// assert_eq!(kind.to_string(), "bvh:binned,bins=32");
/// assert_eq!("bvh".parse::<StructureKind>()?, StructureKind::default());
/// # Ok::<(), boxwood::UnknownStructure>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StructureKind {
    /// [`BruteForce`].
    BruteForce,
    /// [`Bvh`] over [`BinnedSah`].
    Binned(BinnedSah),
    /// [`Bvh`] over [`Median`].
    Median(Median),
}

impl Default for StructureKind {
    fn default() -> Self {
        Self::Binned(BinnedSah::default())
    }
}

impl StructureKind {
    /// All of them with their default settings: one table for printing, help texts and tests.
    pub fn all() -> [Self; 3] {
        [
            Self::BruteForce,
            Self::Median(Median::default()),
            Self::Binned(BinnedSah::default()),
        ]
    }

    /// Builds the structure. Pass `&mesh`, `Arc<mesh>` or the mesh itself.
    pub fn build<'a, P: Primitives + Send + Sync + 'a>(
        self,
        primitives: P,
    ) -> Box<dyn Intersect + 'a> {
        let tree = match self {
            Self::BruteForce => return Box::new(BruteForce::new(primitives)),
            Self::Binned(builder) => builder.build(&primitives),
            Self::Median(builder) => builder.build(&primitives),
        };
        Box::new(Bvh::new(primitives, tree))
    }
}

impl fmt::Display for StructureKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Only settings that differ from the defaults are named.
        let setting = |f: &mut fmt::Formatter<'_>, name: &str, value: usize, default: usize| {
            if value == default {
                return Ok(());
            }
            write!(f, ",{name}={value}")
        };
        match self {
            Self::BruteForce => f.write_str("brute"),
            Self::Binned(b) => {
                let default = BinnedSah::default();
                f.write_str("bvh:binned")?;
                setting(f, "bins", b.bins, default.bins)?;
                setting(f, "leaf", b.max_leaf, default.max_leaf)
            }
            Self::Median(b) => {
                f.write_str("bvh:median")?;
                setting(f, "leaf", b.max_leaf, Median::default().max_leaf)
            }
        }
    }
}

/// Why a text names no structure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnknownStructure {
    /// No structure has this name.
    #[error("no structure is called `{0}`; there are brute, bvh:median and bvh:binned")]
    Name(String),
    /// The structure has no such setting.
    #[error("`{structure}` has no setting `{setting}`; it has {known}")]
    Setting {
        /// The structure.
        structure: &'static str,
        /// The text between the commas.
        setting: String,
        /// What there is.
        known: &'static str,
    },
    /// The value does not fit.
    #[error("`{setting}` must be a whole number from {from} to {to}")]
    Value {
        /// The text between the commas.
        setting: String,
        /// The least value.
        from: usize,
        /// The greatest value.
        to: usize,
    },
}

impl FromStr for StructureKind {
    type Err = UnknownStructure;

    fn from_str(text: &str) -> Result<Self, UnknownStructure> {
        let (name, settings) = text.split_once(':').unwrap_or((text, ""));
        let mut settings = settings.split(',').filter(|s| !s.is_empty()).peekable();
        match name {
            "brute" => match settings.next() {
                None => Ok(Self::BruteForce),
                Some(setting) => Err(UnknownStructure::Setting {
                    structure: "brute",
                    setting: setting.to_string(),
                    known: "none",
                }),
            },
            "bvh" => {
                // The method comes first; without one it is the default.
                let method = settings.next_if(|s| !s.contains('=')).unwrap_or("binned");
                match method {
                    "binned" => {
                        let mut builder = BinnedSah::default();
                        for setting in settings {
                            match setting.split_once('=') {
                                Some(("bins", n)) => builder.bins = number(setting, n, 2, 64)?,
                                Some(("leaf", n)) => builder.max_leaf = number(setting, n, 1, 64)?,
                                _ => {
                                    return Err(UnknownStructure::Setting {
                                        structure: "bvh:binned",
                                        setting: setting.to_string(),
                                        known: "bins=2…64 and leaf=1…64",
                                    });
                                }
                            }
                        }
                        Ok(Self::Binned(builder))
                    }
                    "median" => {
                        let mut builder = Median::default();
                        for setting in settings {
                            match setting.split_once('=') {
                                Some(("leaf", n)) => builder.max_leaf = number(setting, n, 1, 64)?,
                                _ => {
                                    return Err(UnknownStructure::Setting {
                                        structure: "bvh:median",
                                        setting: setting.to_string(),
                                        known: "leaf=1…64",
                                    });
                                }
                            }
                        }
                        Ok(Self::Median(builder))
                    }
                    _ => Err(UnknownStructure::Name(text.to_string())),
                }
            }
            _ => Err(UnknownStructure::Name(text.to_string())),
        }
    }
}

fn number(setting: &str, value: &str, from: usize, to: usize) -> Result<usize, UnknownStructure> {
    match value.parse() {
        Ok(n) if (from..=to).contains(&n) => Ok(n),
        _ => Err(UnknownStructure::Value {
            setting: setting.to_string(),
            from,
            to,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_both_ways() {
        for kind in StructureKind::all() {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        for text in ["brute", "bvh:median,leaf=1", "bvh:binned,bins=8,leaf=2"] {
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
        assert_eq!(
            error("quadtree"),
            "no structure is called `quadtree`; there are brute, bvh:median and bvh:binned"
        );
        assert_eq!(
            error("bvh:median,bins=3"),
            "`bvh:median` has no setting `bins=3`; it has leaf=1…64"
        );
        assert_eq!(
            error("bvh:leaf=0"),
            "`leaf=0` must be a whole number from 1 to 64"
        );
        assert_eq!(error("brute:1"), "`brute` has no setting `1`; it has none");
    }
}
