//! A short row of slots, and the cheapest cut between two of them: [`sweep`](crate::accel::bvh::build::sweep) for rows whose length
//! is known when this is compiled.
//!
//! *How it works.* What lies before and what lies behind each cut is gathered first, one minimum of eight lanes a slot; areas and
//! costs follow for all cuts at once.

use crate::accel::bvh::build::Sides;
use crate::accel::bvh::build::sweep::{Block, Choice, Cut, cost};
use crate::simd::{F, Floats, Lanes};

/// What lies in each slot: bounds and number. Slots may be empty.
pub(super) struct Row<const N: usize> {
    pub sides: [Sides; N],
    pub counts: [u32; N],
}

impl<const N: usize> Row<N> {
    pub const EMPTY: Self = Self {
        sides: [Sides::EMPTY; N],
        counts: [0; N],
    };

    /// The cheapest cut that leaves something on both sides.
    #[inline(always)]
    pub fn cheapest_cut<S: Lanes<8>>(&self, s: S, block: Block) -> Option<Cut> {
        let mut before = [Sides::EMPTY; N];
        let mut around = Sides::EMPTY.lanes(s);
        for at in 1..N {
            around = self.sides[at - 1].lanes(s).min(around);
            before[at] = Sides::of_lanes::<S>(around);
        }
        let mut behind = [Sides::EMPTY; N];
        let mut around = Sides::EMPTY.lanes(s);
        for at in (1..N).rev() {
            around = self.sides[at].lanes(s).min(around);
            behind[at] = Sides::of_lanes::<S>(around);
        }
        let mut left = [0; N];
        let mut all = self.counts[0];
        for at in 1..N {
            left[at] = all;
            all += self.counts[at];
        }
        let mut costs = [0.0; N];
        for at in 0..N {
            costs[at] = cost(before[at].half_area(), left[at], block)
                + cost(behind[at].half_area(), all - left[at], block);
        }
        let mut choice = Choice::NONE;
        for at in 1..N {
            choice.offer(at, costs[at], left[at], all - left[at]);
        }
        choice.cut()
    }

    /// What is around the slots before `at`, and around the others.
    #[inline(always)]
    pub fn around<S: Lanes<8>>(&self, s: S, at: usize) -> [Sides; 2] {
        let mut around = [Sides::EMPTY.lanes(s); 2];
        for (i, sides) in self.sides.iter().enumerate() {
            let half = &mut around[usize::from(i >= at)];
            *half = sides.lanes(s).min(*half);
        }
        [
            Sides::of_lanes::<S>(around[0]),
            Sides::of_lanes::<S>(around[1]),
        ]
    }

    /// Of what fell into either.
    #[cfg(feature = "parallel")]
    #[inline(always)]
    pub fn merge<S: Lanes<8>>(&mut self, s: S, other: &Self) {
        for slot in 0..N {
            self.add::<S>(s, slot, other.sides[slot].lanes(s), other.counts[slot]);
        }
    }

    /// Lays some more into a slot.
    #[inline(always)]
    pub fn add<S: Lanes<8>>(&mut self, s: S, slot: usize, sides: F<S, 8>, count: u32) {
        // A minimum, not a choice: the compiler would write that with a mask, and what is written so cannot be read soon.
        self.sides[slot] = Sides::of_lanes::<S>(sides.min(self.sides[slot].lanes(s)));
        self.counts[slot] += count;
    }
}
