//! Which primitives lie in a cell: shared by all structures that divide space.
//!
//! *How it works.* A cell is closed and a little larger than its planes say, so that a primitive on a border lies on both
//! sides. A mesh is asked for real overlap of triangle and cell; anything else is held against its box, because a hit
//! counts wherever it lies in that box. The walk through the cells then has to open every cell whose *padded* box the ray
//! meets ([`PreparedRay::crossing`]): the slack covers the distance between a hit and the point of the triangle it stands
//! for.
//!
//! *Rays outside the doors* (see [`PreparedRay`]) may hit a triangle anywhere in its padded box: [`Space::asks_all`] says
//! when a structure has to ask everything.

use crate::accel::Limits;
use crate::accel::limits::Site;
use crate::geometry::{Aabb, PreparedRay, Vec3};
use crate::primitive::{self, Primitives};
use crate::query::{Counters, Query, Step};
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Continue};
use core::ops::Range;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// The space that some primitives take.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Space {
    /// Around everything, as the judge has it.
    pub bounds: Aabb,
    /// Around what is divided into cells: every primitive whose box is finite and not empty. Empty when there is none.
    pub world: Aabb,
    /// Primitives with an infinite box: every ray asks them.
    pub everywhere: Vec<u32>,
    /// Whether triangles are held against cells instead of their boxes.
    exact: bool,
    /// How much larger a cell is than its planes say.
    pad: f32,
}

/// Below this size (2⁻¹²) a hit may lie away from its triangle, though within its box.
const LEAST_EXACT: f32 = 1.0 / 4096.0;
/// Above this size (2²⁸) as well.
const MOST_EXACT: f32 = (1_u64 << 28) as f32;
/// So many primitives are looked at by one thread at a time.
const TOGETHER: usize = 8192;

impl Space {
    /// Looks at every primitive once.
    pub fn of(primitives: &(impl Primitives + Sync)) -> Self {
        Self::within(primitives, &Site::new(&Limits::NONE, 1), 0)
    }

    /// The same, by as many threads as there are, for a site where this is so many units of work. Counts the memory it
    /// takes. Where the build is over, what is returned is worth nothing.
    pub fn within(primitives: &(impl Primitives + Sync), site: &Site<'_>, units: usize) -> Self {
        let n = primitives.len();
        let parts = n.div_ceil(TOGETHER);
        let part = |number: usize| {
            let mut part = Self::NOWHERE;
            if site.advance(units / parts) {
                let places = number * TOGETHER..n.min((number + 1) * TOGETHER);
                part.look(primitives, places, site);
            }
            part
        };
        #[cfg(feature = "parallel")]
        let looked: Vec<_> = (0..parts).into_par_iter().exactly().map(part).collect();
        #[cfg(not(feature = "parallel"))]
        let looked: Vec<_> = (0..parts).map(part).collect();
        let mut space = Self::NOWHERE;
        for part in looked {
            space.bounds = space.bounds.union(part.bounds);
            space.world = space.world.union(part.world);
            if site.reserve(&mut space.everywhere, part.everywhere.len()) {
                space.everywhere.extend_from_slice(&part.everywhere);
            }
            site.release(part.everywhere);
        }
        let scale = space.bounds.scale();
        space.exact = LEAST_EXACT < scale && scale < MOST_EXACT;
        // 8 units in the last place of the largest coordinate: for the rounding of cells and of overlap tests.
        space.pad = space.world.scale() * (8.0 / (1 << 24) as f32);
        space
    }

    const NOWHERE: Self = Self {
        bounds: Aabb::EMPTY,
        world: Aabb::EMPTY,
        everywhere: Vec::new(),
        exact: false,
        pad: 0.0,
    };

    fn look(&mut self, primitives: &impl Primitives, places: Range<usize>, site: &Site<'_>) {
        for i in places {
            let b = primitives.bounds(i);
            self.bounds = self.bounds.union(b);
            if b.is_empty() {
                continue;
            }
            if b.lower.is_finite() && b.upper.is_finite() {
                self.world = self.world.union(b);
            } else if site.reserve(&mut self.everywhere, 1) {
                self.everywhere.push(i as u32);
            } else {
                return;
            }
        }
    }

    /// Whether primitives are held against cells by more than their boxes.
    pub fn is_exact<P: Primitives>(&self) -> bool {
        self.exact && P::WITHIN_SLACK
    }

    /// How much larger a cell is than its planes say.
    pub fn pad(&self) -> f32 {
        self.pad
    }

    /// The same space with cells that are larger by so many units in the last place of the scene's largest coordinate.
    pub fn with_pad(self, units: f32) -> Self {
        let pad = self.bounds.scale() * (units / (1 << 24) as f32);
        Self {
            // An infinite box is a matter of those that are everywhere, not of the cells.
            pad: if pad < f32::INFINITY { pad } else { self.pad },
            ..self
        }
    }

    /// A cell as primitives are held against it.
    #[inline]
    pub fn padded(&self, cell: &Aabb) -> Aabb {
        Aabb {
            lower: cell.lower - Vec3::splat(self.pad),
            upper: cell.upper + Vec3::splat(self.pad),
        }
    }

    /// Whether primitive `i` belongs into a cell. Not to be asked of those that are [everywhere](Self::everywhere).
    #[inline]
    pub fn holds<P: Primitives>(&self, primitives: &P, i: usize, cell: &Aabb) -> bool {
        let cell = self.padded(cell);
        if self.is_exact::<P>() {
            primitives.overlaps(i, &cell)
        } else {
            !primitives.bounds(i).intersection(cell).is_empty()
        }
    }

    /// Around the part of primitive `i` that lies in a cell; empty when it does not belong there.
    #[inline]
    pub fn part<P: Primitives>(&self, primitives: &P, i: usize, cell: &Aabb) -> Aabb {
        let cell = self.padded(cell);
        if self.is_exact::<P>() {
            primitives.clipped_bounds(i, &cell)
        } else {
            primitives.bounds(i).intersection(cell)
        }
    }

    /// Whether cells cannot answer for this ray, so that [`Self::ask_all`] must.
    #[inline(always)]
    pub fn asks_all(&self, ray: &PreparedRay) -> bool {
        self.exact && !ray.is_tame()
    }

    /// Shows every primitive to the query, as the judge does.
    #[cold]
    pub fn ask_all<P: Primitives, Q: Query, C: Counters>(
        &self,
        primitives: &P,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) {
        primitive::offer_all(primitives, ray, query, counters);
    }

    /// Shows those primitives to the query that are everywhere: the first thing a walk does.
    #[inline(always)]
    pub fn ask_everywhere<P: Primitives, Q: Query, C: Counters>(
        &self,
        primitives: &P,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        for &i in &self.everywhere {
            primitive::offer(primitives, i as usize, ray, query, counters)?;
        }
        Continue(())
    }
}

/// Remembers which primitives a ray has met, so that one in several cells is tested once.
///
/// Each primitive has one place among [`PLACES`], where a later one may replace it: then it is tested again, which
/// costs time and changes no answer.
pub(crate) struct Mailbox([u32; PLACES]);

const PLACES: usize = 64;

impl Mailbox {
    /// Nobody was met.
    #[inline(always)]
    pub fn new() -> Self {
        Self([u32::MAX; PLACES])
    }
    /// Whether primitive `i` is met for the first time, as far as is remembered; remembers it.
    #[inline(always)]
    fn is_new(&mut self, i: u32) -> bool {
        let place = &mut self.0[i as usize % PLACES];
        core::mem::replace(place, i) != i
    }

    /// Shows those of a cell's primitives to the query that are met for the first time.
    #[inline(always)]
    pub fn offer<P: Primitives, Q: Query, C: Counters>(
        &mut self,
        primitives: &P,
        list: &[u32],
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        for &i in list {
            if self.is_new(i) {
                primitive::offer(primitives, i as usize, ray, query, counters)?;
            } else if C::EXPLAINS {
                counters.step(Step::Repeated { primitive: i });
            }
        }
        Continue(())
    }
}
