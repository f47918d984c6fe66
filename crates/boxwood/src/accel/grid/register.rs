//! Putting every primitive into its cells, by as many threads as there are.

use super::counted::{BYTES_EACH, Reference};
use crate::accel::limits::Site;
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Break, Continue};
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

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

/// Asks `cells_of` for the cells of every primitive whose box is finite and not empty. `None` when that are more
/// references than `most` or than there is memory for, in which case nothing is taken from the site.
///
/// The parts are in the order of the primitives, whoever made them.
pub(crate) fn register<P: Primitives + Sync>(
    primitives: &P,
    site: &Site<'_>,
    most: usize,
    cells_of: &(impl Fn(usize, &Aabb, &mut dyn FnMut(u32) -> ControlFlow<()>) -> ControlFlow<()> + Sync),
) -> Option<Vec<Vec<Reference>>> {
    let n = primitives.len();
    let (taken, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let part = |number: usize| {
        let mut part: Vec<Reference> = Vec::new();
        // How many of them the site knows of: it is told before they are many.
        let mut told = 0;
        let places = number * TOGETHER..n.min((number + 1) * TOGETHER);
        let count = places.len();
        if failed.load(Relaxed) || !site.advance(count) {
            return part;
        }
        for i in places {
            let around = primitives.bounds(i);
            if around.is_empty() || !(around.lower.is_finite() && around.upper.is_finite()) {
                continue;
            }
            let mut put = |cell| {
                part.push(Reference {
                    cell,
                    primitive: i as u32,
                });
                if part.len() <= told {
                    return Continue(());
                }
                if part.len() > most || !site.advance(0) || !site.try_take(AT_ONCE * BYTES_EACH) {
                    return Break(());
                }
                told += AT_ONCE;
                Continue(())
            };
            if cells_of(i, &around, &mut put).is_break() {
                failed.store(true, Relaxed);
                site.give(told * BYTES_EACH);
                return Vec::new();
            }
        }
        site.give((told - part.len().min(told)) * BYTES_EACH);
        let before = taken.fetch_add(part.len(), Relaxed);
        if before + part.len() <= most {
            return part;
        }
        failed.store(true, Relaxed);
        Vec::new()
    };
    let numbers = 0..n.div_ceil(TOGETHER);
    #[cfg(feature = "parallel")]
    let parts: Vec<_> = numbers.into_par_iter().map(part).collect();
    #[cfg(not(feature = "parallel"))]
    let parts: Vec<_> = numbers.map(part).collect();
    if failed.into_inner() {
        site.give(taken.into_inner() * BYTES_EACH);
        return None;
    }
    Some(parts)
}
