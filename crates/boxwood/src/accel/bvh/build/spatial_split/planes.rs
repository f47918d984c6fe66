//! Planes that cut references in two: which is best, and cutting there.
//!
//! *How it works.* Each axis is divided into equal bins. A reference enlarges every bin that it lies in by its part there,
//! begins in the first and ends in the last; a sweep over the bins gives the cost of the planes between them.

use super::{References, Splitter};
use crate::accel::bvh::build::sweep::{Cut, Slot, cheapest_cut};
use crate::accel::bvh::build::{Item, Sides};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;

/// The most bins there may be.
pub(super) const MAX_BINS: usize = 64;

/// A plane and what cutting there costs.
pub(super) struct Plane {
    axis: usize,
    at: f32,
    pub cut: Cut,
}

/// The bins along one axis.
struct Bins {
    axis: usize,
    count: usize,
    lower: f32,
    width: f32,
    /// Bins per unit of length.
    scale: f32,
}

impl Bins {
    /// `None` where there is no length to divide, or an infinite one.
    fn new(bounds: &Aabb, axis: usize, count: usize) -> Option<Self> {
        let size = bounds.upper[axis] - bounds.lower[axis];
        let (width, scale) = (size / count as f32, count as f32 / size);
        let usable = width > 0.0 && width.is_finite() && scale.is_finite();
        usable.then_some(Self {
            axis,
            count,
            lower: bounds.lower[axis],
            width,
            scale,
        })
    }
    /// Where bin `i` begins.
    fn plane(&self, i: usize) -> f32 {
        self.lower + self.width * i as f32
    }
    fn bin(&self, place: f32) -> usize {
        (((place - self.lower) * self.scale) as usize).min(self.count - 1)
    }
}

impl<P: Primitives + Sync> Splitter<'_, P> {
    /// The part of a reference between two planes; empty where only its box lies there.
    fn part(&self, item: &Item, axis: usize, lower: f32, upper: f32) -> Aabb {
        let mut cell = item.bounds();
        cell.lower[axis] = cell.lower[axis].max(lower);
        cell.upper[axis] = cell.upper[axis].min(upper);
        let part = self.space.part(self.primitives, item.id() as usize, &cell);
        part.intersection(item.bounds())
    }

    /// The cheapest plane that the node's spare references pay for.
    pub(super) fn best_plane(&self, part: &References) -> Option<Plane> {
        let most = (part.items.len() + part.spare) as u32;
        // Few references do not need many planes.
        let count = self.settings.bins.min(4 + part.items.len() / 8);
        let mut best: Option<Plane> = None;
        for axis in self.settings.axes.iter() {
            let Some(bins) = Bins::new(&part.bounds, axis, count) else {
                continue;
            };
            let slots = self.fill(&part.items, &bins);
            let cut = cheapest_cut(count, most, self.block, &mut [0.0; MAX_BINS], |i| slots[i]);
            if let Some(cut) = cut
                && best.as_ref().is_none_or(|best| cut.is_better(&best.cut))
            {
                let at = bins.plane(cut.at);
                best = Some(Plane { axis, at, cut });
            }
        }
        best
    }

    fn fill(&self, items: &[Item], bins: &Bins) -> [Slot; MAX_BINS] {
        let mut slots = [Slot {
            sides: Sides::EMPTY,
            begin: 0,
            end: 0,
        }; MAX_BINS];
        let axis = bins.axis;
        for item in items {
            let first = bins.bin(item.bounds().lower[axis]);
            let last = bins.bin(item.bounds().upper[axis]).max(first);
            slots[first].begin += 1;
            slots[last].end += 1;
            if first == last {
                slots[first].sides = slots[first].sides.around(&item.sides());
                continue;
            }
            for i in first..=last {
                let part = self.part(item, axis, bins.plane(i), bins.plane(i + 1));
                if !part.is_empty() {
                    slots[i].sides = slots[i].sides.around(&Sides::of(&part));
                }
            }
        }
        slots
    }

    /// Both sides of a plane; `None` when all lies on one side after all.
    pub(super) fn cut_at(&self, part: &References, plane: &Plane) -> Option<[References; 2]> {
        let &Plane { axis, at, .. } = plane;
        let mut left = Vec::with_capacity(part.items.len());
        let mut right = Vec::with_capacity(part.items.len());
        let mut crossing = Vec::new();
        for item in &part.items {
            if item.bounds().upper[axis] <= at {
                left.push(*item);
            } else if !(item.bounds().lower[axis] < at) {
                right.push(*item);
            } else {
                let lower = self.part(item, axis, f32::NEG_INFINITY, at);
                let upper = self.part(item, axis, at, f32::INFINITY);
                match (lower.is_empty(), upper.is_empty()) {
                    (false, false) => crossing.push((*item, [lower, upper])),
                    (_, true) => left.push(*item),
                    (true, false) => right.push(*item),
                }
            }
        }
        let [mut to_left, mut to_right] = [Item::around(&left), Item::around(&right)];
        for (_, [lower, upper]) in &crossing {
            to_left = to_left.union(*lower);
            to_right = to_right.union(*upper);
        }
        let mut on_left = left.len() + crossing.len();
        let mut on_right = right.len() + crossing.len();
        let cost = |bounds: Aabb, count: usize| bounds.half_area() * count as f32;
        for (item, [lower, upper]) in crossing {
            let with_left = to_left.union(item.bounds());
            let with_right = to_right.union(item.bounds());
            let both = cost(to_left, on_left) + cost(to_right, on_right);
            let only_left = cost(with_left, on_left) + cost(to_right, on_right - 1);
            let only_right = cost(to_left, on_left - 1) + cost(with_right, on_right);
            if only_left < both && only_left <= only_right {
                left.push(item);
                to_left = with_left;
                on_right -= 1;
            } else if only_right < both {
                right.push(item);
                to_right = with_right;
                on_left -= 1;
            } else {
                left.push(item.with_bounds(&lower));
                right.push(item.with_bounds(&upper));
            }
        }
        let added = (left.len() + right.len()).checked_sub(part.items.len())?;
        // Even where both sides hold a part of everything, it ends: the spare references do.
        let divided = !left.is_empty() && !right.is_empty() && added <= part.spare;
        divided.then(|| [References::of(left, 0), References::of(right, 0)])
    }
}
