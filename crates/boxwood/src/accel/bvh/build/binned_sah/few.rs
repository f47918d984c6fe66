//! A handful of items: sorted along each axis, every cut between two of them is tried.
//!
//! *How it works.* So few need no sorting: each is compared with each, on all axes at once, and its place is the number of
//! those before it.

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
    let mut best: Option<Found> = None;
    for (axis, order) in orders.into_iter().enumerate() {
        let mut row = Row::<FEW>::EMPTY;
        for (slot, place) in order.into_iter().enumerate().take(items.len()) {
            row.sides[slot] = items[usize::from(place) % FEW].sides();
            row.counts[slot] = 1;
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

/// Who comes where along each axis.
#[inline(always)]
fn orders(items: &[Item]) -> [[u8; FEW]; 3] {
    let mut keys = [[0_i32; 4]; FEW];
    for (key, item) in keys.iter_mut().zip(items) {
        // Negative floats ascend when all bits but the sign are flipped: then NaN has a place too.
        let middle = item.middle();
        for k in 0..4 {
            let bits = middle[k].to_bits() as i32;
            key[k] = bits ^ ((bits >> 31) as u32 >> 1) as i32;
        }
    }
    let keys = &keys[..items.len()];
    let mut places = [[0_i32; 4]; FEW];
    for i in 1..keys.len() {
        for j in 0..i {
            for k in 0..4 {
                // Of equal ones the first comes first.
                let before = i32::from(keys[i][k] < keys[j][k]);
                places[j][k] += before;
                places[i][k] += 1 - before;
            }
        }
    }
    let mut orders = [[0; FEW]; 3];
    for i in 0..keys.len() {
        for axis in 0..3 {
            orders[axis][places[i][axis] as usize % FEW] = i as u8;
        }
    }
    orders
}
