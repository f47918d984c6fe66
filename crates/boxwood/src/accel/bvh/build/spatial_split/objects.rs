//! Cuts between references, which leave all of them whole.
//!
//! *How it works.* Few references are sorted along each axis, and every cut is tried. Many may fall into bins by their middles
//! instead, and the cuts between bins are tried: sooner done, and in scenes where little things lie among large ones the trees are even
//! better, because bins cut space where sorting cuts numbers.

use super::Splitter;
use super::planes::MAX_BINS;
use crate::accel::bvh::build::sweep::{Cut, Slot, cheapest_cut};
use crate::accel::bvh::build::{Item, Sides};
use crate::primitive::Primitives;
use alloc::vec::Vec;

/// So many references and fewer are always sorted.
const FEW: usize = 32;

/// A cut: how many references lie before it, what it costs, and their numbers in order.
pub(super) struct ObjectCut {
    pub at: usize,
    pub cost: f32,
    /// The references of the first half, then those of the second, in the low bits.
    pub keys: Vec<u64>,
}

impl<P: Primitives + Sync> Splitter<'_, P> {
    /// The cheapest cut between references.
    pub(super) fn object_cut(&self, items: &[Item]) -> Option<ObjectCut> {
        let bins = self.settings.object_bins.min(4 + items.len() / 8);
        if self.settings.object_bins > 1 && items.len() > FEW {
            self.cut_between_bins(items, bins)
        } else {
            self.cut_anywhere(items)
        }
    }

    fn cut_anywhere(&self, items: &[Item]) -> Option<ObjectCut> {
        // Most rows are short: no need to ask for memory.
        let mut short = [0.0; 64];
        let mut long = Vec::new();
        let behind = if items.len() <= short.len() {
            &mut short[..]
        } else {
            long.resize(items.len(), 0.0);
            &mut long[..]
        };
        let mut keys = Vec::with_capacity(items.len());
        let mut best: Option<(Cut, Vec<u64>)> = None;
        for axis in self.settings.axes.iter() {
            keys.clear();
            keys.extend((0..).zip(items).map(|(i, item)| item.key(axis, i)));
            keys.sort_unstable();
            let cut = cheapest_cut(items.len(), u32::MAX, self.block, behind, |i| Slot {
                sides: items[keys[i] as u32 as usize].sides(),
                begin: 1,
                end: 1,
            });
            let Some(cut) = cut else {
                continue;
            };
            match &mut best {
                Some((best, _)) if !cut.is_better(best) => {}
                Some((best, best_keys)) => {
                    *best = cut;
                    core::mem::swap(best_keys, &mut keys);
                }
                None => {
                    let keys = core::mem::replace(&mut keys, Vec::with_capacity(items.len()));
                    best = Some((cut, keys));
                }
            }
        }
        best.map(|(cut, keys)| ObjectCut {
            at: cut.at,
            cost: cut.cost,
            keys,
        })
    }

    /// Where all middles are one there is no cut between bins, and those in the order of their numbers are tried.
    fn cut_between_bins(&self, items: &[Item], count: usize) -> Option<ObjectCut> {
        let middles = Item::around_middles(items).bounds();
        let (lower, size) = (middles.lower, middles.size());
        let bin = |item: &Item, axis: usize| {
            // A little less than all, so that the last middle falls into the last bin; what is no number into the first.
            let scale = count as f32 * 0.999_999 / size[axis];
            let place = (item.middle_along(axis) - lower[axis]) * scale;
            (place as usize).min(count - 1)
        };
        let mut best: Option<(usize, Cut)> = None;
        for axis in self.settings.axes.iter() {
            let mut slots = [Slot {
                sides: Sides::EMPTY,
                begin: 0,
                end: 0,
            }; MAX_BINS];
            for item in items {
                let slot = &mut slots[bin(item, axis)];
                slot.sides = slot.sides.around(&item.sides());
                slot.begin += 1;
                slot.end += 1;
            }
            let behind = &mut [0.0; MAX_BINS];
            let cut = cheapest_cut(count, u32::MAX, self.block, behind, |i| slots[i]);
            if let Some(cut) = cut
                && best.as_ref().is_none_or(|(_, best)| cut.is_better(best))
            {
                best = Some((axis, cut));
            }
        }
        let Some((axis, cut)) = best else {
            return self.cut_anywhere(items);
        };
        let goes_left = |i: &u64| bin(&items[*i as usize], axis) < cut.at;
        let mut keys = Vec::with_capacity(items.len());
        keys.extend((0..items.len() as u64).filter(goes_left));
        let at = keys.len();
        keys.extend((0..items.len() as u64).filter(|i| !goes_left(i)));
        Some(ObjectCut {
            at,
            cost: cut.cost,
            keys,
        })
    }
}
