//! What one ray did: every step of its traversal, and every hit it was offered, in order.

use crate::geometry::Hit;
use crate::query::{Counters, Query, Step};
use alloc::vec::Vec;
use core::cell::RefCell;
use core::ops::ControlFlow;

/// Something that happened to a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The traversal took a step.
    Step(Step),
    /// A primitive was hit.
    Hit {
        /// The hit.
        hit: Hit,
        /// Where the ray's interval ends now: it is shorter than before when the hit is the best so far.
        t_max: f32,
    },
}

/// A record of what happens to a ray; its two ends, [`Explained::query`] and [`Explained::counters`], are handed to
/// [`Traverse::traverse`](crate::Traverse::traverse).
#[derive(Debug, Default)]
pub struct Explained {
    events: RefCell<Vec<Event>>,
}

impl Explained {
    /// The query, with its hits recorded.
    pub fn query<Q: Query>(&self, inner: Q) -> impl Query + use<'_, Q> {
        ExplainedQuery {
            events: &self.events,
            inner,
        }
    }
    /// Counters that record each step.
    pub fn counters(&self) -> impl Counters + use<'_> {
        ExplainedSteps(&self.events)
    }
    /// What happened.
    pub fn events(self) -> Vec<Event> {
        self.events.into_inner()
    }
}

struct ExplainedQuery<'a, Q> {
    events: &'a RefCell<Vec<Event>>,
    inner: Q,
}

impl<Q: Query> Query for ExplainedQuery<'_, Q> {
    const ORDERED: bool = Q::ORDERED;
    fn t_max(&self) -> f32 {
        self.inner.t_max()
    }
    fn mask(&self) -> u32 {
        self.inner.mask()
    }
    fn time(&self) -> f32 {
        self.inner.time()
    }
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        let flow = self.inner.offer(hit);
        let t_max = self.inner.t_max();
        self.events.borrow_mut().push(Event::Hit { hit, t_max });
        flow
    }
}

struct ExplainedSteps<'a>(&'a RefCell<Vec<Event>>);

impl Counters for ExplainedSteps<'_> {
    const EXPLAINS: bool = true;
    fn step(&mut self, step: Step) {
        self.0.borrow_mut().push(Event::Step(step));
    }
}
