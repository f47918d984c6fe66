//! Parts of a structure, by which rays may enter it without passing through its root.

/// Names a part of a structure: all of it, or what it has itself shown as a part ([`Traverse::parts`](super::Traverse::parts)).
///
/// To any other structure the name means nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Part(u32);

impl Part {
    /// Everything.
    pub const ALL: Self = Self(u32::MAX);

    /// The part that a structure knows by a number.
    pub fn new(number: u32) -> Self {
        Self(number)
    }
    /// The structure's own number for it.
    pub fn number(self) -> u32 {
        self.0
    }
}
