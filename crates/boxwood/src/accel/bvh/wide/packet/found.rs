//! What the rays of a packet have met so far.

use super::gather::most;
use super::{GROUPS, LANES, ROW, Row};
use crate::geometry::Hit;
use crate::geometry::triangle::block::Meetings;
use crate::query::Query;
use crate::simd::{F, Floats, Lanes, Mask};
use alloc::vec::Vec;

/// No primitive.
const NONE: u32 = u32::MAX;

/// The best hits so far. Rows are written whole: read so soon after single numbers were written, they would wait for those.
pub struct Found {
    /// Where each ray's interval ends; below every `t_min` for a ray that asks no more.
    pub t_max: Row,
    /// Groups of which no ray asks any more.
    pub closed: [bool; GROUPS],
    t: Row,
    u: Row,
    v: Row,
    primitive: [[u32; LANES]; GROUPS],
    /// Rays for the loop that looks at boxes of triangles; see [`Stop::Uncovered`](crate::geometry::triangle::block::Stop).
    uncovered: Vec<usize>,
}

impl Found {
    pub const NOTHING: Self = Self {
        t_max: ROW,
        closed: [false; GROUPS],
        t: ROW,
        u: ROW,
        v: ROW,
        primitive: [[NONE; LANES]; GROUPS],
        uncovered: Vec::new(),
    };

    /// Forgets all, but for the ends of intervals.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.primitive = [[NONE; LANES]; GROUPS];
        self.closed = [false; GROUPS];
    }

    /// Writes down where rays have met a triangle; what then is the end of each one's interval.
    #[inline(always)]
    pub fn keep<S: Lanes<LANES>>(
        &mut self,
        s: S,
        met: &Meetings<S>,
        id: u32,
        group: usize,
        ordered: bool,
    ) -> F<S, LANES> {
        let load = F::<S, LANES>::load;
        let t_max = load(s, &self.t_max[group]);
        if ordered && (met.rays & t_max.le(met.t)).bits() != 0 {
            return self.keep_first(s, met, id, group);
        }
        for lane in lanes(met.rays.bits()) {
            self.primitive[group][lane] = id;
        }
        let rows = [
            (&mut self.t, met.t),
            (&mut self.u, met.u),
            (&mut self.v, met.v),
        ];
        for (row, new) in rows {
            let old = load(s, &row[group]);
            row[group] = new.choose(met.rays, old).to_array();
        }
        let nothing = F::<S, LANES>::splat(s, f32::NEG_INFINITY);
        let end = if ordered { met.t } else { nothing };
        let t_max = end.choose(met.rays, t_max);
        self.t_max[group] = t_max.to_array();
        self.closed[group] = nothing.lt(t_max).bits() == 0;
        t_max
    }

    /// The same where some are as near as what was met before: the primitive with the lowest number counts.
    #[cold]
    fn keep_first<S: Lanes<LANES>>(
        &mut self,
        s: S,
        met: &Meetings<S>,
        id: u32,
        group: usize,
    ) -> F<S, LANES> {
        let [t, u, v] = [met.t, met.u, met.v].map(Floats::to_array);
        for lane in lanes(met.rays.bits()) {
            if t[lane] < self.t_max[group][lane] || id < self.primitive[group][lane] {
                self.primitive[group][lane] = id;
                self.t[group][lane] = t[lane];
                self.u[group][lane] = u[lane];
                self.v[group][lane] = v[lane];
                self.t_max[group][lane] = t[lane];
            }
        }
        F::<S, LANES>::load(s, &self.t_max[group])
    }

    /// Leaves rays to the loop that looks at boxes of triangles.
    #[cold]
    pub fn leave_alone<S: Lanes<LANES>>(&mut self, s: S, rays: u32, group: usize) -> F<S, LANES> {
        for lane in lanes(rays) {
            self.uncovered.push(group * LANES + lane);
            self.primitive[group][lane] = NONE;
            self.t_max[group][lane] = f32::NEG_INFINITY;
        }
        F::<S, LANES>::load(s, &self.t_max[group])
    }

    /// The end of the longest interval.
    #[inline(always)]
    pub fn latest<S: Lanes<LANES>>(&self, s: S) -> f32 {
        let load = F::<S, LANES>::load;
        let [a, b, c, d] = &self.t_max;
        let latest = (load(s, a).max(load(s, b))).max(load(s, c).max(load(s, d)));
        most(latest.to_array())
    }

    /// Shows each query what its ray has met.
    pub fn answer<Q: Query>(&self, queries: &mut [Q]) {
        for (index, query) in queries.iter_mut().enumerate() {
            let (group, lane) = (index / LANES % GROUPS, index % LANES);
            let primitive = self.primitive[group][lane];
            if primitive != NONE {
                let _ = query.offer(Hit {
                    t: self.t[group][lane],
                    u: self.u[group][lane],
                    v: self.v[group][lane],
                    primitive,
                    instance: 0,
                });
            }
        }
    }

    /// Whether a ray's answer may not be complete yet.
    pub fn is_open(&self, index: usize) -> bool {
        self.t_max[index / LANES % GROUPS][index % LANES] > f32::NEG_INFINITY
    }

    /// Takes the rays that were left for the other loop.
    pub fn take_uncovered(&mut self) -> Vec<usize> {
        core::mem::take(&mut self.uncovered)
    }
}

/// The lanes of some bits.
#[inline(always)]
fn lanes(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            lane % LANES
        })
    })
}
