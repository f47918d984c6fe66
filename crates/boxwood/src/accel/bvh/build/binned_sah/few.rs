//! A handful of items: sorted along each axis, every cut between two of them is tried.
//!
//! *How it works.* So few need no sorting: each is compared with each, on all axes at once, and its place is the number of
//! those before it.

use crate::accel::Axes;
use crate::accel::bvh::build::Item;
use crate::accel::bvh::build::sweep::{Block, Cut, Slot, cheapest_cut as cheapest_cut_of_row};

/// How many a handful is.
pub(super) const FEW: usize = 8;

/// The cheapest cut, and the order along its axis.
pub(super) struct Found {
    pub cut: Cut,
    order: [u8; FEW],
}

impl Found {
    /// Brings the items into the order that was cut.
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
pub(super) fn cheapest_cut(items: &[Item], axes: Axes, block: Block) -> Option<Found> {
    let orders = orders(items);
    let mut best: Option<Found> = None;
    for axis in axes.iter() {
        let order = orders[axis];
        let cut = cheapest_cut_of_row(items.len(), u32::MAX, block, &mut [0.0; FEW], |i| Slot {
            sides: items[usize::from(order[i])].sides(),
            begin: 1,
            end: 1,
        });
        if let Some(cut) = cut
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
        *key = item.middle().map(|place| {
            let bits = place.to_bits() as i32;
            bits ^ ((bits >> 31) as u32 >> 1) as i32
        });
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
