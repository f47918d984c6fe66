//! The cheapest place to cut a row in two by the surface-area heuristic.
//!
//! *How it works.* One sweep from the right notes what everything behind each cut costs, one from the left adds what lies
//! before it. A row is of primitives, or of bins that know how many begin and how many end in them.
//!
//! *Cost.* Two unions and one product a slot.

use super::Sides;

/// One place in a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub sides: Sides,
    /// How many primitives begin here: they count on the left of every later cut.
    pub begin: u32,
    /// How many end here: they count on the right of every earlier cut.
    pub end: u32,
}

/// Where to cut, and what it costs in areas times primitives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    /// The first slot of the right half.
    pub at: usize,
    pub cost: f32,
    /// How many primitives lie on the side that has fewer.
    smaller_half: u32,
}

impl Cut {
    /// Cheaper, or as cheap and more even: boxes along a line have no area, and all cuts through them cost nothing.
    #[inline(always)]
    pub fn is_better(&self, other: &Self) -> bool {
        self.cost < other.cost
            || (self.cost == other.cost && self.smaller_half > other.smaller_half)
    }
}

/// The most primitives that a structure tests at once.
pub(super) const MAX_BLOCK: usize = 16;

/// How many primitives are tested at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block {
    mask: u32,
}

impl Block {
    pub const ONE: Self = Self { mask: 0 };

    /// So many, or the next power of two.
    pub fn of(size: usize) -> Self {
        Self {
            mask: size.next_power_of_two() as u32 - 1,
        }
    }

    /// The places of so many blocks that all have one.
    #[inline(always)]
    fn filled(self, count: u32) -> u32 {
        (count + self.mask) & !self.mask
    }

    /// What some primitives weigh that are tested in blocks.
    ///
    /// Half of it by the blocks that they would fill alone, half by their number: blocks alone would force rows of long
    /// primitives into fours, their number alone leaves a quarter of all places empty.
    #[inline(always)]
    pub fn weight(self, count: u32) -> f32 {
        0.5 * (count as f32 + self.filled(count) as f32)
    }
}

/// What some primitives cost in a box of such an area: a number, even for infinite boxes that are flat.
#[inline(always)]
pub(super) fn cost(area: f32, count: u32, block: Block) -> f32 {
    let cost = area * block.weight(count);
    if cost < f32::INFINITY {
        cost
    } else {
        f32::INFINITY
    }
}

/// The best of some cuts.
///
/// Cost above evenness in one number, the least of which is the best: positive floats ascend like whole numbers. A
/// branch would be foreseen badly.
pub(super) struct Choice {
    best: u64,
    at: usize,
}

impl Choice {
    pub const NONE: Self = Self {
        best: u64::MAX,
        at: 0,
    };

    /// A cut with so many primitives on its two sides, if that is some.
    #[inline(always)]
    pub fn offer(&mut self, at: usize, cost: f32, left: u32, right: u32) {
        let cut = u64::from(cost.to_bits()) << 32 | u64::from(!left.min(right));
        let counts = (left != 0) & (right != 0);
        let cut = if counts { cut } else { u64::MAX };
        self.at = if cut < self.best { at } else { self.at };
        self.best = self.best.min(cut);
    }

    #[inline(always)]
    pub fn cut(self) -> Option<Cut> {
        (self.best != u64::MAX).then(|| Cut {
            at: self.at,
            cost: f32::from_bits((self.best >> 32) as u32),
            smaller_half: !(self.best as u32),
        })
    }
}

/// The cheapest cut of a row of `len` slots that leaves primitives on both sides and, where some are cut in two, at most
/// `most` in all. A test takes a block of primitives at once. `behind` is scratch for at least `len` numbers.
#[inline(always)]
pub(super) fn cheapest_cut(
    len: usize,
    most: u32,
    block: Block,
    behind: &mut [f32],
    slot: impl Fn(usize) -> Slot,
) -> Option<Cut> {
    let mut sides = Sides::EMPTY;
    let mut right = 0;
    for i in (1..len).rev() {
        let slot = slot(i);
        (sides, right) = (sides.around(&slot.sides), right + slot.end);
        behind[i] = cost(sides.half_area(), right, block);
    }
    let mut choice = Choice::NONE;
    let mut sides = Sides::EMPTY;
    let mut left = 0;
    for at in 1..len {
        let before = slot(at - 1);
        (sides, left) = (sides.around(&before.sides), left + before.begin);
        if at > 1 {
            right -= before.end;
        }
        if left + right <= most {
            let cost = cost(sides.half_area(), left, block) + behind[at];
            choice.offer(at, cost, left, right);
        }
    }
    choice.cut()
}
