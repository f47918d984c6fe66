//! Built-in scenes by name: `NAME[:N][,seed=S]`, read in one place.

use super::{city, crowd, plants, soup, sponge, teapot_in_stadium, terrain};
use crate::scene::Scene;
use std::ops::RangeInclusive;

/// A scene that code makes.
struct Builtin {
    name: &'static str,
    /// `None` for a scene that is always the same.
    size: Option<Size>,
    /// Makes it, of a number of things and a seed.
    make: fn(u32, u64) -> Scene,
}

/// What `N` counts.
struct Size {
    what: &'static str,
    default: u32,
    range: RangeInclusive<u32>,
}

const fn size(what: &'static str, default: u32, range: RangeInclusive<u32>) -> Option<Size> {
    Some(Size {
        what,
        default,
        range,
    })
}

/// All of them. Ranges end where a scene would take several gigabytes (plants and sponges as instances).
const BUILTINS: [Builtin; 9] = [
    Builtin {
        name: "teapot-in-stadium",
        size: None,
        make: |_, _| teapot_in_stadium(),
    },
    Builtin {
        name: "even-spheres",
        size: size("spheres", 1000, 1..=100_000),
        make: crowd::even_spheres,
    },
    Builtin {
        name: "long-thin",
        size: size("triangles", 1000, 1..=10_000_000),
        make: crowd::long_thin,
    },
    Builtin {
        name: "overlapping",
        size: size("things", 300, 1..=1_000_000),
        make: crowd::overlapping,
    },
    Builtin {
        name: "plants",
        size: size("plants", 3000, 1..=2_000_000),
        make: plants::plants,
    },
    Builtin {
        name: "city",
        size: size("houses", 2000, 1..=500_000),
        make: city::city,
    },
    Builtin {
        name: "terrain",
        size: size("triangles", 200_000, 8..=50_000_000),
        make: terrain::terrain,
    },
    Builtin {
        name: "soup",
        size: size("triangles", 10_000, 1..=20_000_000),
        make: soup::soup,
    },
    Builtin {
        name: "sponge",
        size: size("levels", 6, 1..=9),
        make: sponge::sponge,
    },
];

/// Why a text names no built-in scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnknownBuiltin {
    /// No scene has this name.
    #[error("no built-in scene is called `{name}`; there are {}", list())]
    Name {
        /// The name.
        name: String,
    },
    /// The scene is always the same.
    #[error("`{name}` takes no settings, but `{setting}` was given")]
    Fixed {
        /// The scene.
        name: &'static str,
        /// What was given.
        setting: String,
    },
    /// The number of things does not fit.
    #[error(
        "`{given}` is no number of {what} for `{name}`: expected {least} to {most}, such as {default}{}",
        if *most < 20_000 { "" } else { ", 20k or 1M" }
    )]
    Size {
        /// The scene.
        name: &'static str,
        /// What it consists of.
        what: &'static str,
        /// What was given.
        given: String,
        /// The least number.
        least: u32,
        /// The largest number.
        most: u32,
        /// The number of who gives none.
        default: u32,
    },
    /// Neither a number nor a seed.
    #[error(
        "`{name}` has no setting `{setting}`; it has a number of {what} and seed=0…{}",
        u64::MAX
    )]
    Setting {
        /// The scene.
        name: &'static str,
        /// What it consists of.
        what: &'static str,
        /// What was given.
        setting: String,
    },
}

/// The scene of that name: `NAME`, `NAME:N`, `NAME:N,seed=S` or `NAME:seed=S`, where `N` may end in `k` or `M`.
///
/// ```
/// let scene = boxwood_scene::builtin::by_name("soup:2k,seed=7")?;
/// assert_eq!(scene.triangle_count(), 2000);
/// # Ok::<(), boxwood_scene::builtin::UnknownBuiltin>(())
/// ```
///
/// # Errors
/// When there is no such scene, and what there is; when the number does not fit, and which do.
pub fn by_name(text: &str) -> Result<Scene, UnknownBuiltin> {
    let (name, settings) = match text.split_once(':') {
        None => (text, None),
        Some((name, settings)) => (name, Some(settings)),
    };
    let Some(found) = BUILTINS.iter().find(|builtin| builtin.name == name) else {
        return Err(UnknownBuiltin::Name { name: text.into() });
    };
    let name = found.name;
    let Some(size) = &found.size else {
        return match settings {
            None => Ok((found.make)(0, 0)),
            Some(setting) => Err(UnknownBuiltin::Fixed {
                name,
                setting: setting.into(),
            }),
        };
    };
    let (mut n, mut seed) = (size.default, 0);
    let mut sized = false;
    for setting in settings.iter().flat_map(|settings| settings.split(',')) {
        if let Some(given) = setting.strip_prefix("seed=") {
            seed = given.parse().map_err(|_| UnknownBuiltin::Setting {
                name,
                what: size.what,
                setting: setting.into(),
            })?;
        } else if setting.contains('=') || std::mem::replace(&mut sized, true) {
            return Err(UnknownBuiltin::Setting {
                name,
                what: size.what,
                setting: setting.into(),
            });
        } else {
            let fits = number(setting).filter(|n| size.range.contains(n));
            n = fits.ok_or_else(|| UnknownBuiltin::Size {
                name,
                what: size.what,
                given: setting.into(),
                least: *size.range.start(),
                most: *size.range.end(),
                default: size.default,
            })?;
        }
    }
    Ok((found.make)(n, seed))
}

/// `1500`, `20k`, `10M`.
fn number(text: &str) -> Option<u32> {
    let (digits, unit) = match text.strip_suffix('M') {
        Some(digits) => (digits, 1_000_000),
        None => match text.strip_suffix('k') {
            Some(digits) => (digits, 1000),
            None => (text, 1),
        },
    };
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit());
    let count: u32 = plain.then(|| digits.parse().ok()).flatten()?;
    count.checked_mul(unit)
}

/// All names without settings.
pub fn names() -> impl Iterator<Item = &'static str> {
    BUILTINS.iter().map(|builtin| builtin.name)
}

/// All names as one writes them: `teapot-in-stadium, even-spheres:N, …`.
pub fn list() -> String {
    let each: Vec<String> = BUILTINS
        .iter()
        .map(|builtin| match builtin.size {
            None => builtin.name.to_string(),
            Some(_) => format!("{}:N", builtin.name),
        })
        .collect();
    each.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_may_have_a_unit() {
        for (text, n) in [("0", 0), ("12", 12), ("20k", 20_000), ("10M", 10_000_000)] {
            assert_eq!(number(text), Some(n));
        }
        for text in [
            "",
            "k",
            "-1",
            "+1",
            "1.5k",
            "1K",
            "5000M",
            "99999999999",
            "1e3",
            " 1",
        ] {
            assert_eq!(number(text), None, "{text}");
        }
    }

    #[test]
    fn defaults_are_in_their_ranges() {
        for builtin in &BUILTINS {
            if let Some(size) = &builtin.size {
                assert!(size.range.contains(&size.default), "{}", builtin.name);
            }
        }
    }

    #[test]
    fn errors_say_what_there_is() {
        let error = |text: &str| by_name(text).expect_err(text).to_string();
        assert_eq!(
            error("teapot"),
            "no built-in scene is called `teapot`; there are teapot-in-stadium, even-spheres:N, \
             long-thin:N, overlapping:N, plants:N, city:N, terrain:N, soup:N, sponge:N"
        );
        assert_eq!(
            error("city:0"),
            "`0` is no number of houses for `city`: expected 1 to 500000, such as 2000, 20k or 1M"
        );
        assert_eq!(
            error("teapot-in-stadium:3"),
            "`teapot-in-stadium` takes no settings, but `3` was given"
        );
        assert_eq!(
            error("soup:3,size=2"),
            "`soup` has no setting `size=2`; it has a number of triangles and \
             seed=0…18446744073709551615"
        );
        for text in [
            "soup:",
            "soup:1,",
            "soup:x",
            "soup:1,2",
            "soup:seed=-1",
            "soup:1 ",
        ] {
            assert!(by_name(text).is_err(), "{text}");
        }
    }

    #[test]
    fn settings_come_in_any_order() {
        let count = |text: &str| by_name(text).expect(text).triangle_count();
        assert_eq!(count("soup:7"), 7);
        assert_eq!(count("soup:7,seed=1"), 7);
        assert_eq!(count("soup:seed=1,7"), 7);
        assert_eq!(count("soup:seed=1"), count("soup"));
    }
}
