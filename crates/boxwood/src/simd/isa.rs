//! The instruction sets by name.

use super::Level;
use alloc::vec::Vec;
use core::fmt;
use core::str::FromStr;

/// An instruction set that this machine has: `portable` (everywhere), `avx2` and `avx512` (x86-64, found at run time), `neon`
/// (64-bit ARM) or `simd128` (WebAssembly that is compiled with `-C target-feature=+simd128`).
///
/// Answers do not depend on it, only their time does (but see [`Precision::Fast`](crate::Precision::Fast)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Isa(Level);

impl Isa {
    /// The best one, or the one that the environment variable `BOXWOOD_ISA` names, if the machine has it. Looked up once.
    pub fn best() -> Self {
        #[cfg(feature = "std")]
        {
            static BEST: std::sync::OnceLock<Isa> = std::sync::OnceLock::new();
            *BEST.get_or_init(|| {
                let named = std::env::var("BOXWOOD_ISA").ok();
                named
                    .and_then(|name| name.parse().ok())
                    .unwrap_or_else(Self::fastest)
            })
        }
        #[cfg(not(feature = "std"))]
        Self::fastest()
    }

    fn fastest() -> Self {
        let all = Self::available();
        all[all.len() - 1]
    }

    /// All that this machine has, `portable` first.
    pub fn available() -> Vec<Self> {
        Level::available().into_iter().map(Self).collect()
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.0.name()
    }

    pub(crate) fn level(self) -> Level {
        self.0
    }
}

impl Default for Isa {
    fn default() -> Self {
        Self::best()
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The machine has no instruction set of that name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this machine has no such instruction set")]
pub struct UnknownIsa;

impl FromStr for Isa {
    type Err = UnknownIsa;

    fn from_str(text: &str) -> Result<Self, UnknownIsa> {
        let mut all = Self::available().into_iter();
        all.find(|isa| isa.name() == text).ok_or(UnknownIsa)
    }
}
