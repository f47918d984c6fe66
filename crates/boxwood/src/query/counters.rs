//! Counting steps; free when nobody counts.

use crate::geometry::Aabb;

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
    /// Whether anything is counted at all: structures with several loops take the same one on every machine for those who
    /// count.
    const COUNTS: bool = true;
    /// Whether [`Counters::step`] wants to hear: structures ask this before they put a step into words.
    const EXPLAINS: bool = false;
    /// What exactly happened, for those who explain a ray. Beside the counts, not instead of them.
    #[inline(always)]
    fn step(&mut self, _step: Step) {}
}

/// One step of a traversal, for those who explain a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Step {
    /// The ray was held against a node's or a cell's box, in which it lies from `enter` to `leave` (both erring to the
    /// outside). `node` is a number of the structure's own.
    Box {
        /// The node or cell.
        node: u32,
        /// Its box.
        bounds: Aabb,
        /// Where the ray enters the box; beyond `leave` where it misses it.
        enter: f32,
        /// Where the ray leaves the box.
        leave: f32,
        /// What became of it.
        verdict: Verdict,
    },
    /// A plane divides a node: the side the ray comes from is asked first.
    Plane {
        /// The node.
        node: u32,
        /// The plane's normal; a unit axis in most structures.
        normal: [f32; 3],
        /// `normal · p` for its points.
        offset: f32,
        /// Where the ray crosses it; NaN when it runs along.
        t: f32,
        /// Whether the side the ray comes from is visited.
        near: bool,
        /// Whether the other side is visited.
        far: bool,
    },
    /// A node that was put aside is taken up again, or dropped because a hit lies in front of it.
    Resumed {
        /// The node.
        node: u32,
        /// Where the ray enters it.
        enter: f32,
        /// Whether it is dropped.
        dropped: bool,
    },
    /// The primitives of a leaf or a cell come next.
    Leaf {
        /// The leaf or cell.
        node: u32,
        /// How many primitives it names.
        primitives: u32,
    },
    /// A primitive is tested.
    Primitive {
        /// The primitive.
        primitive: u32,
    },
    /// A primitive is passed over because the ray has met it in an earlier cell.
    Repeated {
        /// The primitive.
        primitive: u32,
    },
}

/// What became of a box that a ray was held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Verdict {
    /// Opened at once.
    Opened,
    /// Put aside, because another one comes first.
    Deferred,
    /// The ray's line passes it.
    Missed,
    /// It ends before the ray's interval begins.
    Behind,
    /// It begins beyond the ray's interval, which the hits so far have shortened.
    Beyond,
}

impl Step {
    /// A box met at `slabs`, its entry and its exit, by a ray whose interval still is from `t_min` to `t_max`. One that
    /// is not rejected is `otherwise`: opened, or deferred.
    #[cold]
    pub(crate) fn of_box(
        node: u32,
        bounds: Aabb,
        slabs: (f32, f32),
        t_min: f32,
        t_max: f32,
        otherwise: Verdict,
    ) -> Step {
        let (enter, leave) = slabs;
        let verdict = if !(enter <= leave) {
            Verdict::Missed
        } else if !(t_min <= leave) {
            Verdict::Behind
        } else if !(enter <= t_max) {
            Verdict::Beyond
        } else {
            otherwise
        };
        Step::Box {
            node,
            bounds,
            enter,
            leave,
            verdict,
        }
    }
}

impl Counters for () {
    const COUNTS: bool = false;
}

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
