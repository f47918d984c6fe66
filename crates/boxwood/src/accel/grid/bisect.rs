//! Rays that do not walk: from very far away, or outside the doors of [`PreparedRay`].
//!
//! *How it works.* The range of cells is cut in halves, the near one first, and the ray is asked of each half whether it
//! [enters](PreparedRay::enters) its box.
//!
//! *Why no hit is lost.* By the slack, a hit lies within the slabs of a cell that its primitive is registered in: of the one
//! that holds the point it stands for or, where primitives are registered by their boxes, of some cell of the
//! primitive's range on each axis, all of which have it. A larger box is entered no later and left no earlier, so no
//! half with that cell is passed over.
//!
//! *Cost.* A box per half, about three times that of walking. Where the slack is larger than a block, cells can tell
//! little, and every primitive is asked.

use super::lattice::{Lattice, Range};
use super::nested::{Block, Blocks, Nested};
use crate::accel::cells::Mailbox;
use crate::geometry::{Aabb, PreparedRay};
use crate::primitive::Primitives;
use crate::query::{Counters, Query, Step, Verdict};
use core::ops::ControlFlow::{self, Continue};

/// A ray on its way, and whom it asks.
struct Search<'a, B, P, Q, C> {
    nested: &'a Nested<B>,
    primitives: &'a P,
    ray: &'a PreparedRay,
    query: &'a mut Q,
    counters: &'a mut C,
    mailbox: Mailbox,
}

impl<B: Blocks> Nested<B> {
    /// Asks all cells that the ray may meet.
    #[cold]
    #[inline(never)]
    pub fn bisect_all<P: Primitives, Q: Query, C: Counters>(
        &self,
        primitives: &P,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) {
        let (top, space) = (self.top(), &self.space);
        let thinnest = top.size.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        if space.asks_all(ray) || !(ray.slack() < thinnest) {
            return space.ask_all(primitives, ray, query, counters);
        }
        let everywhere = space.ask_everywhere(primitives, ray, query, counters);
        if everywhere.is_break() {
            return;
        }
        let all = top.resolution.map(|n| [0, n - 1]);
        let mut search = Search {
            nested: self,
            primitives,
            ray,
            query,
            counters,
            mailbox: Mailbox::new(),
        };
        // Whether it came to its end or broke off, there is nothing left to do.
        let _ended = search.bisect(&top, None, all);
    }
}

impl<B: Blocks, P: Primitives, Q: Query, C: Counters> Search<'_, B, P, Q, C> {
    /// Some blocks, or some cells of a block.
    fn bisect(
        &mut self,
        lattice: &Lattice,
        block: Option<&Block>,
        range: Range,
    ) -> ControlFlow<()> {
        let bounds = lattice.bounds(&range);
        self.counters.node();
        if self.ray.enters(&bounds, self.query.t_max()).is_none() {
            return Continue(());
        }
        let span = range.map(|[first, last]| last - first);
        let axis = (0..3).max_by_key(|&k| span[k]).unwrap_or(0);
        if span[axis] > 0 {
            let middle = range[axis][0] + span[axis] / 2;
            let (mut near, mut far) = (range, range);
            near[axis][1] = middle;
            far[axis][0] = middle + 1;
            if self.ray.direction[axis] < 0.0 {
                core::mem::swap(&mut near, &mut far);
            }
            self.bisect(lattice, block, near)?;
            return self.bisect(lattice, block, far);
        }
        let place = range.map(|[first, _]| first);
        if let Some(block) = block {
            return self.ask(block.cell(place), bounds);
        }
        let number = lattice.number(place);
        if self.nested.blocks.is_empty(number, &self.nested.cells) {
            return Continue(());
        }
        let block = self.nested.blocks.block(number);
        let inner = lattice.inside(place, block.parts);
        let all = block.parts.map(|n| [0, n.saturating_sub(1)]);
        self.bisect(&inner, Some(&block), all)
    }

    /// The primitives of a cell.
    fn ask(&mut self, cell: usize, bounds: Aabb) -> ControlFlow<()> {
        if !self.nested.cells.is_filled(cell) {
            return Continue(());
        }
        let list = self.nested.cells.list(cell);
        self.counters.leaf();
        if C::EXPLAINS {
            let (enter, leave) = self.ray.slabs(&bounds);
            self.counters.step(Step::Box {
                node: cell as u32,
                bounds,
                enter,
                leave,
                verdict: Verdict::Opened,
            });
            self.counters.step(Step::Leaf {
                node: cell as u32,
                primitives: list.len() as u32,
            });
        }
        self.mailbox
            .offer(self.primitives, list, self.ray, self.query, self.counters)
    }
}
