//! Builders as text: one table per builder reads its settings, writes them and explains them.

use super::{Axes, BuildError, Limits, UnknownStructure};
use crate::primitive::Primitives;
use crate::query::Intersect;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt;
use core::ops::RangeInclusive;

/// A builder that has a name and makes a whole structure: what [`StructureKind`](super::StructureKind) is a list of.
pub(crate) trait Settings: Default + Copy + PartialEq {
    /// The whole name, as `bvh:binned`.
    const NAME: &'static str;
    /// Every setting by name, ready to be read and written.
    fn settings(&mut self) -> Vec<Setting<'_>>;
    /// Builds the structure.
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError>;
}

/// One setting of a builder.
pub(crate) struct Setting<'a> {
    name: &'static str,
    value: Box<dyn Value + 'a>,
}

impl<'a> Setting<'a> {
    /// A setting of any kind.
    pub fn new(name: &'static str, value: impl Value + 'a) -> Self {
        let value = Box::new(value);
        Self { name, value }
    }
    /// A whole number.
    pub fn count(name: &'static str, value: &'a mut usize, range: RangeInclusive<usize>) -> Self {
        Self::new(name, Number { value, range })
    }
    /// A number.
    pub fn real(name: &'static str, value: &'a mut f32, range: RangeInclusive<f32>) -> Self {
        Self::new(name, Number { value, range })
    }
    /// The axes that may be divided.
    pub fn axes(value: &'a mut Axes) -> Self {
        Self::new("axes", value)
    }
}

/// How a setting is read and written.
pub(crate) trait Value {
    /// Takes the value from a text; `false` when it does not fit.
    fn read(&mut self, text: &str) -> bool;
    /// The value as text.
    fn write(&self) -> String;
    /// What fits, in a few words: `2…64`.
    fn expected(&self) -> String;
}

/// A number within a range.
struct Number<'a, T> {
    value: &'a mut T,
    range: RangeInclusive<T>,
}

impl<T: PartialOrd + Copy + fmt::Display + core::str::FromStr> Value for Number<'_, T> {
    fn read(&mut self, text: &str) -> bool {
        match text.parse() {
            Ok(n) if self.range.contains(&n) => {
                *self.value = n;
                true
            }
            _ => false,
        }
    }
    fn write(&self) -> String {
        self.value.to_string()
    }
    fn expected(&self) -> String {
        format!("{}…{}", self.range.start(), self.range.end())
    }
}

impl Value for &mut Axes {
    fn read(&mut self, text: &str) -> bool {
        text.parse().map(|axes| **self = axes).is_ok()
    }
    fn write(&self) -> String {
        self.to_string()
    }
    fn expected(&self) -> String {
        "xyz".into()
    }
}

/// Reads `name=value` texts into a builder.
pub(crate) fn read<'t, S: Settings>(
    texts: impl IntoIterator<Item = &'t str>,
) -> Result<S, UnknownStructure> {
    let mut builder = S::default();
    for text in texts {
        let found = text.split_once('=').and_then(|(name, value)| {
            let settings = builder.settings();
            let setting = settings.into_iter().find(|s| s.name == name)?;
            Some((setting, value))
        });
        let Some((mut setting, value)) = found else {
            return Err(UnknownStructure::Setting {
                structure: S::NAME,
                setting: text.to_string(),
                known: known::<S>(),
            });
        };
        if !setting.value.read(value) {
            return Err(UnknownStructure::Value {
                setting: text.to_string(),
                expected: setting.value.expected(),
            });
        }
    }
    Ok(builder)
}

/// Writes a builder's name and those settings that are not the default.
pub(crate) fn write<S: Settings>(builder: &S, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str(S::NAME)?;
    let (mut builder, mut default) = (*builder, S::default());
    let mut mark = if S::NAME.contains(':') { ',' } else { ':' };
    for (mine, theirs) in builder.settings().iter().zip(default.settings()) {
        let value = mine.value.write();
        if value != theirs.value.write() {
            write!(f, "{mark}{}={value}", mine.name)?;
            mark = ',';
        }
    }
    Ok(())
}

/// All settings of a builder and what fits: `bins=2…64, leaf=1…64 and axes=xyz`.
pub(crate) fn known<S: Settings>() -> String {
    let mut builder = S::default();
    let settings = builder.settings();
    let all: Vec<String> = settings
        .iter()
        .map(|s| format!("{}={}", s.name, s.value.expected()))
        .collect();
    match all.split_last() {
        None => "none".into(),
        Some((only, [])) => only.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
    }
}
