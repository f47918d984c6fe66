//! Counting steps; free when nobody counts.

/// Told of every step of a traversal. The methods are empty by default, and `()` compiles to nothing.
pub trait Counters {
    /// An inner node (or a cell) was opened.
    #[inline(always)]
    fn node(&mut self) {}
    /// A leaf was opened.
    #[inline(always)]
    fn leaf(&mut self) {}
    /// Primitives were tested.
    #[inline(always)]
    fn primitives(&mut self, _count: usize) {}
}

impl Counters for () {}

/// How many steps were taken. Adds up over as many rays as it is shown to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalStats {
    /// Inner nodes opened.
    pub nodes: u64,
    /// Leaves opened.
    pub leaves: u64,
    /// Primitives tested.
    pub primitives: u64,
}

impl Counters for TraversalStats {
    #[inline(always)]
    fn node(&mut self) {
        self.nodes += 1;
    }
    #[inline(always)]
    fn leaf(&mut self) {
        self.leaves += 1;
    }
    #[inline(always)]
    fn primitives(&mut self, count: usize) {
        self.primitives += count as u64;
    }
}
