//! A handful of items: sorted along each axis, every cut between two of them is tried.
//!
//! *How it works.* So few need no sorting: each is compared with each, on all axes at once, and its place is the number of
//! those before it.

use super::least_size;
use super::row::Row;
use crate::accel::Axes;
use crate::accel::bvh::build::Item;
use crate::accel::bvh::build::sweep::{Block, Cut};
use crate::simd::Lanes;

/// How many a handful is.
pub(super) const FEW: usize = 8;

/// The cheapest cut, and the order along its axis.
pub(super) struct Found {
    pub cut: Cut,
    order: [u8; FEW],
}

impl Found {
    /// Brings the items into the order that was cut.
    #[inline(always)]
    pub fn put_in_order(&self, items: &mut [Item]) {
        let Some(&first) = items.first() else {
            return;
        };
        let mut old = [first; FEW];
        old[..items.len()].copy_from_slice(items);
        for (item, from) in items.iter_mut().zip(self.order) {
            *item = old[usize::from(from) % FEW];
        }
    }
}

/// The cheapest cut between at most [`FEW`] items.
#[inline(always)]
pub(super) fn cheapest_cut<S: Lanes<8>>(
    s: S,
    items: &[Item],
    axes: Axes,
    block: Block,
) -> Option<Found> {
    let orders = orders(items);
    let mut sizes = [0.0_f32; 3];
    for axis in 0..3 {
        let middle = |place: usize| {
            items
                .get(usize::from(orders[axis][place]))
                .map_or(0.0, |item| item.middle_along(axis))
        };
        sizes[axis] = middle(items.len().min(FEW) - 1) - middle(0);
    }
    let least = least_size(axes, sizes);
    let mut best: Option<Found> = None;
    for (axis, order) in orders.into_iter().enumerate() {
        if sizes[axis] < least {
            continue;
        }
        let mut row = Row::<FEW>::EMPTY;
        for (slot, place) in order.into_iter().enumerate() {
            if let Some(item) = items.get(usize::from(place)) {
                row.sides[slot] = item.sides();
                row.counts[slot] = 1;
            }
        }
        if axes.has(axis)
            && let Some(cut) = row.cheapest_cut(s, block)
            && best.as_ref().is_none_or(|best| cut.is_better(&best.cut))
        {
            best = Some(Found { cut, order });
        }
    }
    best
}

/// Who comes where along each axis. Places without an item come last.
#[inline(always)]
fn orders(items: &[Item]) -> [[u8; FEW]; 3] {
    let mut keys = [[i32::MAX; FEW]; 3];
    for (i, item) in items.iter().enumerate().take(FEW) {
        let middle = item.middle();
        for axis in 0..3 {
            // Negative floats ascend when all bits but the sign are flipped: then NaN has a place too.
            let bits = middle[axis].to_bits() as i32;
            keys[axis][i] = bits ^ ((bits >> 31) as u32 >> 1) as i32;
        }
    }
    let mut orders = [[0; FEW]; 3];
    // All loops have the same length always: what is foreseen is fast.
    for axis in 0..3 {
        let mut places = [0; FEW];
        for i in 0..FEW {
            for lane in 0..FEW {
                // Of equal ones the first comes first.
                let before = if i < lane {
                    keys[axis][i] <= keys[axis][lane]
                } else {
                    keys[axis][i] < keys[axis][lane]
                };
                places[lane] += i32::from(before);
            }
        }
        for i in 0..FEW {
            orders[axis][places[i] as usize % FEW] = i as u8;
        }
    }
    orders
}
