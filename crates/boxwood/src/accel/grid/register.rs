//! Putting every primitive into its cells, by as many threads as there are.

use super::counted::{BYTES_EACH, Reference};
use crate::accel::limits::Site;
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Break, Continue};
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// So many primitives are put into their cells by one thread at a time.
const TOGETHER: usize = 256;
/// Memory is asked for so many references at a time.
const AT_ONCE: usize = 4096;

/// No grid holds more references for so many primitives: what would is made coarser.
pub(crate) fn most_references(primitives: usize) -> usize {
    primitives
        .saturating_mul(32)
        .saturating_add(1 << 18)
        .min(1 << 28)
}

/// Where the cells of a primitive are written down.
pub(crate) struct Register<'a> {
    site: &'a Site<'a>,
    /// No part may hold more.
    most: usize,
    part: Vec<Reference>,
    /// How many of them the site knows of: it is told before they are many.
    told: usize,
    primitive: u32,
}

impl Register<'_> {
    /// The primitive lies in this cell, which it has not been put into before. Breaks where that is too much.
    #[inline(always)]
    pub fn put(&mut self, cell: u32) -> ControlFlow<()> {
        if self.part.len() == self.told && !self.tell() {
            return Break(());
        }
        self.part.push(Reference {
            cell,
            primitive: self.primitive,
        });
        Continue(())
    }

    #[cold]
    fn tell(&mut self) -> bool {
        if self.part.len() > self.most
            || !self.site.advance(0)
            || !self.site.try_take(AT_ONCE * BYTES_EACH)
        {
            return false;
        }
        self.part.reserve_exact(AT_ONCE);
        self.told += AT_ONCE;
        true
    }
}

/// Asks `cells_of` for the cells of every primitive whose box is finite and not empty. `None` when that are more
/// references than `most` or than there is memory for, in which case nothing is taken from the site.
///
/// The parts are in the order of the primitives, whoever made them.
pub(crate) fn register<P: Primitives + Sync>(
    primitives: &P,
    site: &Site<'_>,
    most: usize,
    cells_of: &(impl Fn(usize, &Aabb, &mut Register<'_>) -> ControlFlow<()> + Sync),
) -> Option<Vec<Vec<Reference>>> {
    let n = primitives.len();
    let (taken, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let part = |number: usize| {
        let places = number * TOGETHER..n.min((number + 1) * TOGETHER);
        if failed.load(Relaxed) || !site.advance(places.len()) {
            return Vec::new();
        }
        let mut register = Register {
            site,
            most,
            part: Vec::new(),
            told: 0,
            primitive: 0,
        };
        for i in places {
            let around = primitives.bounds(i);
            if around.is_empty() || !(around.lower.is_finite() && around.upper.is_finite()) {
                continue;
            }
            register.primitive = i as u32;
            if cells_of(i, &around, &mut register).is_break() {
                failed.store(true, Relaxed);
                site.give(register.told * BYTES_EACH);
                return Vec::new();
            }
        }
        let Register { mut part, told, .. } = register;
        part.shrink_to_fit();
        site.give((told - part.len()) * BYTES_EACH);
        let before = taken.fetch_add(part.len(), Relaxed);
        if before + part.len() <= most {
            return part;
        }
        failed.store(true, Relaxed);
        Vec::new()
    };
    let numbers = 0..n.div_ceil(TOGETHER);
    #[cfg(feature = "parallel")]
    let parts: Vec<_> = numbers.into_par_iter().exactly().map(part).collect();
    #[cfg(not(feature = "parallel"))]
    let parts: Vec<_> = numbers.map(part).collect();
    if failed.into_inner() {
        site.give(taken.into_inner() * BYTES_EACH);
        return None;
    }
    Some(parts)
}
