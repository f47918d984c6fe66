//! The questions: nearest hit, any hit, all hits, the first few, and filters around any of them.

use super::Query;
use crate::geometry::{Hit, Ray};
use crate::simd::alone;
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Break, Continue};

/// The nearest hit; of equally near ones that of the lowest (instance, primitive).
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// Behind every hit that may come, as long as nothing was found.
    best: Hit,
}

impl Closest {
    /// Nothing found yet.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self {
            best: Hit {
                t: ray.end(),
                u: 0.0,
                v: 0.0,
                primitive: u32::MAX,
                instance: u32::MAX,
            },
        }
    }
    /// What was found; `None` for a miss.
    #[inline]
    pub fn hit(&self) -> Option<Hit> {
        let Hit {
            t,
            u,
            v,
            primitive,
            instance,
        } = &self.best;
        let (primitive, instance) = (alone(primitive), alone(instance));
        (primitive & instance != u32::MAX).then(|| Hit {
            t: alone(t),
            u: alone(u),
            v: alone(v),
            primitive,
            instance,
        })
    }
}

impl Query for Closest {
    const ONE_HIT: bool = true;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        if hit.is_before(&self.best) {
            self.best = hit;
        }
        Continue(())
    }
}

/// Is anything in the interval? Stops at the first hit.
#[derive(Clone, Copy, Debug)]
pub struct Occluded {
    t_max: f32,
    found: Option<(u32, u32)>,
}

impl Occluded {
    /// Nothing found yet.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self {
            t_max: ray.end(),
            found: None,
        }
    }
    /// Whether anything was found.
    #[inline]
    pub fn found(&self) -> bool {
        self.found.is_some()
    }
    /// The (instance, primitive) that was found. Which of those in the interval it is depends on the structure.
    #[inline]
    pub fn occluder(&self) -> Option<(u32, u32)> {
        self.found
    }
}

impl Query for Occluded {
    const ORDERED: bool = false;
    const ONE_HIT: bool = true;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        self.found = Some((hit.instance, hit.primitive));
        Break(())
    }
}

/// Every hit in the interval, each once.
#[derive(Clone, Debug)]
pub struct AllHits {
    t_max: f32,
    hits: Vec<Hit>,
}

impl AllHits {
    /// Nothing found yet.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self {
            t_max: ray.end(),
            hits: Vec::new(),
        }
    }
    /// All hits, nearest first; those with equal `t` by (instance, primitive). A structure that keeps a primitive in
    /// several places may have shown a hit twice: it counts once, while the two roots of a sphere stay two unless their
    /// `t` is the same.
    pub fn sorted(mut self) -> Vec<Hit> {
        // Stable, so that of a primitive's equal hits (both roots of a sphere that the ray touches) the first one stays,
        // whatever else was found: as in `Closest` and `FirstHits`.
        self.hits.sort_by(Hit::order);
        self.hits.dedup_by(|a, b| a.order(b).is_eq());
        self.hits
    }
}

impl Query for AllHits {
    const ORDERED: bool = false;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        self.hits.push(hit);
        Continue(())
    }
}

/// The first `k` hits along the ray, each once: peeling layers without visiting what lies behind them.
#[derive(Clone, Debug)]
pub struct FirstHits {
    t_max: f32,
    k: usize,
    /// Sorted; at most `k`.
    hits: Vec<Hit>,
}

impl FirstHits {
    /// Nothing found yet. With `k = 0` nothing ever will be.
    #[inline]
    pub fn new(ray: &Ray, k: usize) -> Self {
        Self {
            // Nothing lies within a negative interval.
            t_max: if k == 0 { -1.0 } else { ray.end() },
            k,
            hits: Vec::new(),
        }
    }
    /// At most `k` hits, nearest first; those with equal `t` by (instance, primitive).
    pub fn sorted(self) -> Vec<Hit> {
        self.hits
    }
}

impl Query for FirstHits {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        if self.k == 0 {
            return Break(());
        }
        if let Err(place) = self.hits.binary_search_by(|other| other.order(&hit)) {
            self.hits.insert(place, hit);
            self.hits.truncate(self.k);
            if self.hits.len() == self.k {
                self.t_max = self.hits[self.k - 1].t;
            }
        }
        Continue(())
    }
}

/// Only the hits that `keep` accepts reach the inner query: cut-outs, back-face culling, "not the surface I came from".
#[derive(Clone, Copy, Debug)]
pub struct Filter<Q, K> {
    /// The query that sees what passes.
    pub inner: Q,
    /// Which hits pass.
    pub keep: K,
}

impl<Q: Query, K: FnMut(&Hit) -> bool> Query for Filter<Q, K> {
    const ORDERED: bool = Q::ORDERED;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.inner.t_max()
    }
    #[inline(always)]
    fn mask(&self) -> u32 {
        self.inner.mask()
    }
    #[inline(always)]
    fn time(&self) -> f32 {
        self.inner.time()
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        if (self.keep)(&hit) {
            self.inner.offer(hit)
        } else {
            Continue(())
        }
    }
}

/// The inner query as asked with a visibility mask and at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Seen<Q> {
    /// The query.
    pub inner: Q,
    /// Only primitives whose own mask shares a bit are met.
    pub mask: u32,
    /// The moment; primitives that move say what it means.
    pub time: f32,
}

impl<Q: Query> Query for Seen<Q> {
    const ORDERED: bool = Q::ORDERED;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.inner.t_max()
    }
    #[inline(always)]
    fn mask(&self) -> u32 {
        self.mask
    }
    #[inline(always)]
    fn time(&self) -> f32 {
        self.time
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        self.inner.offer(hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(t: f32, primitive: u32) -> Hit {
        Hit {
            t,
            u: 0.0,
            v: 0.0,
            primitive,
            instance: 0,
        }
    }

    fn ray() -> Ray {
        Ray::new([0.0; 3], [0.0, 0.0, 1.0])
    }

    #[test]
    fn the_lowest_primitive_wins_a_tie() {
        for order in [[1, 2], [2, 1]] {
            let mut query = Closest::new(&ray());
            for primitive in order {
                assert!(query.offer(hit(1.0, primitive)).is_continue());
            }
            assert_eq!(query.hit().map(|h| h.primitive), Some(1));
        }
    }

    #[test]
    fn all_hits_come_sorted_and_once() {
        let mut query = AllHits::new(&ray());
        for (t, primitive) in [(3.0, 0), (1.0, 5), (1.0, 2), (3.0, 0), (1.0, 5), (2.0, 0)] {
            assert!(query.offer(hit(t, primitive)).is_continue());
        }
        let found: Vec<_> = query.sorted().iter().map(|h| (h.t, h.primitive)).collect();
        assert_eq!(found, [(1.0, 2), (1.0, 5), (2.0, 0), (3.0, 0)]);
    }

    #[test]
    fn first_hits_are_the_head_of_all_hits() {
        let offers = [(3.0, 0), (1.0, 5), (1.0, 2), (3.0, 0), (1.0, 5), (2.0, 0)];
        let expected = [(1.0, 2), (1.0, 5), (2.0, 0), (3.0, 0)];
        for k in 0..6 {
            let mut query = FirstHits::new(&ray(), k);
            for (t, primitive) in offers {
                if t <= query.t_max() {
                    let _ = query.offer(hit(t, primitive));
                }
            }
            let found: Vec<_> = query.sorted().iter().map(|h| (h.t, h.primitive)).collect();
            assert_eq!(found, expected[..k.min(4)]);
        }
    }
}
