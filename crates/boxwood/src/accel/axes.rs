//! Which axes a builder may divide: all three in space, two of them in a plane.

use crate::geometry::Vec3;
use core::fmt;
use core::str::FromStr;

/// A set of axes, never empty. A structure that may not divide z treats a scene of tall prisms as one in the plane.
///
/// As text: `xyz`, `xy`, `z`, …
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes(u8);

impl Axes {
    /// All three.
    pub const XYZ: Self = Self(0b111);
    /// The plane.
    pub const XY: Self = Self(0b011);

    /// Those axes that are marked; `None` when none is.
    pub fn new([x, y, z]: [bool; 3]) -> Option<Self> {
        let bits = u8::from(x) | u8::from(y) << 1 | u8::from(z) << 2;
        (bits != 0).then_some(Self(bits))
    }
    /// Whether axis 0, 1 or 2 may be divided.
    #[inline(always)]
    pub fn has(self, axis: usize) -> bool {
        self.0 >> axis & 1 == 1
    }
    /// The axes that may be divided, in order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..3).filter(move |&axis| self.has(axis))
    }
    /// How many there are: 1, 2 or 3.
    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }
    /// The one along which a size is largest; of equal ones the first.
    pub fn longest(self, size: Vec3) -> usize {
        let longer = |best: usize, axis: usize| if size[axis] > size[best] { axis } else { best };
        self.iter().reduce(longer).unwrap_or(0)
    }
}

impl Default for Axes {
    fn default() -> Self {
        Self::XYZ
    }
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.iter()
            .try_for_each(|axis| f.write_str(["x", "y", "z"][axis]))
    }
}

/// A text that names no axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("axes are some of x, y and z, each once, as in `xy`")]
pub struct UnknownAxes;

impl FromStr for Axes {
    type Err = UnknownAxes;

    fn from_str(text: &str) -> Result<Self, UnknownAxes> {
        let mut marked = [false; 3];
        for letter in text.chars() {
            let axis = "xyz".find(letter).ok_or(UnknownAxes)?;
            if core::mem::replace(&mut marked[axis], true) {
                return Err(UnknownAxes);
            }
        }
        Self::new(marked).ok_or(UnknownAxes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;

    #[test]
    fn text_goes_both_ways() {
        for text in ["xyz", "xy", "xz", "yz", "x", "y", "z"] {
            let axes: Axes = text.parse().expect("good axes");
            assert_eq!(axes.to_string(), text);
            assert_eq!(axes.count(), text.len());
        }
        for text in ["", "xx", "xyw", "X"] {
            assert!(text.parse::<Axes>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_longest_is_one_of_them() {
        let size = Vec3::new(1.0, 2.0, 3.0);
        assert_eq!(Axes::XYZ.longest(size), 2);
        assert_eq!(Axes::XY.longest(size), 1);
        assert_eq!(Axes::XYZ.longest(Vec3::ZERO), 0);
    }
}
