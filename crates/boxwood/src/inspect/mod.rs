//! Looking at a tree: what it is made of, what it should cost, whether it is whole.

mod statistics;
mod validate;

pub use statistics::Statistics;
pub use validate::{TreeFlaw, validate};
