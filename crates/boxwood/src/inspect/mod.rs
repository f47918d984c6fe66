//! Looking at a tree: what it is made of, what it should cost, whether it is whole.

mod cell;
mod explain;
mod statistics;
mod validate;

pub use cell::Cell;
pub use explain::{Event, Explained};
pub use statistics::Statistics;
pub use validate::{TreeFlaw, validate};
