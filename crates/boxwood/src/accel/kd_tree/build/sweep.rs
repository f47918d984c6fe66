//! The cost of every plane of a cell where a primitive's part begins or ends, in one pass over them in order.
//!
//! *How it works.* Beginnings, ends and flat parts are sorted each by itself, as whole numbers that sort like floats; going
//! through all three at once gives at each place how many parts begin before it, lie in it and end behind it.

use super::{Cut, Item};
use crate::geometry::Aabb;
use alloc::vec::Vec;

/// The areas of a cell's parts, as shares of its own.
pub(super) struct Surface {
    lower: [f64; 3],
    upper: [f64; 3],
    /// By axis: the share of the two sides across it, and by how much a share grows per unit of length along it.
    sides: [(f64, f64); 3],
    plane_cost: f64,
    /// What remains of the cost where one half is empty.
    rebated: f64,
}

impl Surface {
    /// `None` for a cell that is a point. A cell that is a line counts by lengths instead of areas.
    pub fn of(cell: &Aabb, plane_cost: f64, empty: f32) -> Option<Self> {
        let lower = cell.lower.to_array().map(f64::from);
        let upper = cell.upper.to_array().map(f64::from);
        let size = [0, 1, 2].map(|k| upper[k] - lower[k]);
        let [x, y, z] = size;
        let area = x * y + y * z + z * x;
        let sides = if area > 0.0 {
            [(y * z, y + z), (z * x, z + x), (x * y, x + y)].map(|(s, r)| (s / area, r / area))
        } else {
            let length = x + y + z;
            if !(length > 0.0) {
                return None;
            }
            [(0.0, 1.0 / length); 3]
        };
        Some(Self {
            lower,
            upper,
            sides,
            plane_cost,
            rebated: 1.0 - f64::from(empty),
        })
    }

    /// What it costs to cut at a plane with so many primitives on either side.
    #[inline(always)]
    pub fn cost(&self, axis: usize, plane: f32, [below, above]: [usize; 2]) -> f64 {
        let plane = f64::from(plane);
        let (side, per_length) = self.sides[axis];
        let share_below = side + per_length * (plane - self.lower[axis]);
        let share_above = side + per_length * (self.upper[axis] - plane);
        let cost = self.plane_cost + share_below * below as f64 + share_above * above as f64;
        if below == 0 || above == 0 {
            cost * self.rebated
        } else {
            cost
        }
    }
}

/// The cheapest cut so far.
pub(super) struct Best {
    cost: f64,
    pub cut: Option<Cut>,
}

impl Best {
    /// Nothing yet; only what costs less is taken.
    pub fn at_most(cost: f64) -> Self {
        Self { cost, cut: None }
    }
    #[inline(always)]
    pub fn offer(&mut self, cost: f64, cut: Cut) {
        if cost < self.cost {
            self.cost = cost;
            self.cut = Some(cut);
        }
    }
}

/// Places on one axis, as [`key`]s in order, strictly within a range.
#[derive(Default)]
pub(super) struct Events {
    begins: Vec<u32>,
    ends: Vec<u32>,
    flats: Vec<u32>,
    /// How many parts begin at or before the range's start.
    begun: usize,
    /// How many parts end at or before it.
    ended: usize,
}

/// A float as a number that sorts like it. There are no NaN and no negative zeros.
#[inline(always)]
fn key(x: f32) -> u32 {
    let bits = x.to_bits();
    bits ^ (((bits as i32 >> 31) as u32) | 1 << 31)
}

#[inline(always)]
fn place(key: u32) -> f32 {
    let mask = if key >> 31 == 1 { 1 << 31 } else { u32::MAX };
    f32::from_bits(key ^ mask)
}

impl Events {
    /// Takes all places strictly within a range.
    pub fn gather(&mut self, items: &[Item], axis: usize, (from, to): (f32, f32)) {
        self.begins.clear();
        self.ends.clear();
        self.flats.clear();
        (self.begun, self.ended) = (0, 0);
        for item in items {
            let (lower, upper) = (item.bounds.lower[axis], item.bounds.upper[axis]);
            let (begins, ends) = (from < lower && lower < to, from < upper && upper < to);
            self.begun += usize::from(lower <= from);
            self.ended += usize::from(upper <= from);
            if begins {
                self.begins.push(key(lower));
                if lower == upper {
                    self.flats.push(key(lower));
                }
            }
            if ends {
                self.ends.push(key(upper));
            }
        }
        self.begins.sort_unstable();
        self.ends.sort_unstable();
        self.flats.sort_unstable();
    }

    /// Offers every place; there are `n` items.
    pub fn sweep(&self, n: usize, axis: usize, surface: &Surface, best: &mut Best) {
        let (begins, ends, flats) = (&self.begins[..], &self.ends[..], &self.flats[..]);
        let (mut begun, mut ended, mut flat) = (0, 0, 0);
        loop {
            let next = match (begins.get(begun), ends.get(ended)) {
                (Some(&b), Some(&e)) => b.min(e),
                (Some(&next), None) | (None, Some(&next)) => next,
                (None, None) => return,
            };
            let below = self.begun + begun;
            let lying = flat;
            begun = past(begins, begun, next);
            ended = past(ends, ended, next);
            flat = past(flats, flat, next);
            let above = n - self.ended - ended;
            let (plane, lying) = (place(next), flat - lying);
            let cut = |flat_below| Cut {
                axis,
                plane,
                flat_below,
            };
            best.offer(surface.cost(axis, plane, [below + lying, above]), cut(true));
            if lying > 0 {
                best.offer(
                    surface.cost(axis, plane, [below, above + lying]),
                    cut(false),
                );
            }
        }
    }
}

/// Past all that equal `next`.
#[inline(always)]
fn past(sorted: &[u32], mut at: usize, next: u32) -> usize {
    while sorted.get(at) == Some(&next) {
        at += 1;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_sort_like_floats() {
        let places = [f32::MIN, -2.0, -1.0e-40, 0.0, 1.0e-40, 1.0, 1.5, f32::MAX];
        assert!(places.windows(2).all(|w| key(w[0]) < key(w[1])));
        assert!(places.iter().all(|&x| place(key(x)) == x));
    }

    fn items(ranges: &[(f32, f32)]) -> Vec<Item> {
        let item = |(id, &(lower, upper)): (usize, &(f32, f32))| Item {
            bounds: Aabb::new([lower, 0.0, 0.0], [upper, 1.0, 1.0]),
            id: id as u32,
        };
        ranges.iter().enumerate().map(item).collect()
    }

    /// The least cost of all planes, counted one by one.
    fn by_hand(items: &[Item], cell: &Aabb, surface: &Surface) -> f64 {
        let mut least = f64::INFINITY;
        for place in items
            .iter()
            .flat_map(|i| [i.bounds.lower.x, i.bounds.upper.x])
        {
            if !(cell.lower.x < place && place < cell.upper.x) {
                continue;
            }
            let lies = |i: &&Item| i.bounds.lower.x == place && i.bounds.upper.x == place;
            let lying = items.iter().filter(lies).count();
            let below = items.iter().filter(|i| i.bounds.lower.x < place).count();
            let above = items.iter().filter(|i| i.bounds.upper.x > place).count();
            for sides in [[below + lying, above], [below, above + lying]] {
                least = least.min(surface.cost(0, place, sides));
            }
        }
        least
    }

    #[test]
    fn the_sweep_counts_right() {
        let ranges = [
            (0.0, 1.0),
            (0.0, 3.0),
            (1.0, 1.0),
            (1.0, 1.0),
            (1.0, 2.0),
            (2.5, 8.0),
            (3.0, 3.0),
            (7.0, 8.0),
            (-0.0, 8.0),
        ];
        for count in 1..=ranges.len() {
            let mut items = items(&ranges[..count]);
            for item in &mut items {
                item.bounds.lower.x += 0.0;
            }
            let cell = Aabb::new([0.0, 0.0, 0.0], [8.0, 1.0, 1.0]);
            let surface = Surface::of(&cell, 0.5, 0.2).expect("a cell");
            let mut best = Best::at_most(f64::INFINITY);
            let mut events = Events::default();
            events.gather(&items, 0, (0.0, 8.0));
            events.sweep(count, 0, &surface, &mut best);
            assert_eq!(best.cost, by_hand(&items, &cell, &surface), "{count}");
            // In two ranges that share a border, all but the border is found.
            let mut halves = Best::at_most(f64::INFINITY);
            for range in [(0.0, 2.75), (2.75, 8.0)] {
                events.gather(&items, 0, range);
                events.sweep(count, 0, &surface, &mut halves);
            }
            assert_eq!(halves.cost, best.cost, "{count}");
        }
    }

    #[test]
    fn cells_without_area_count_by_length() {
        let line = Aabb::new([0.0; 3], [4.0, 0.0, 0.0]);
        let surface = Surface::of(&line, 0.5, 0.0).expect("a line");
        assert_eq!(surface.cost(0, 1.0, [4, 4]), 0.5 + 4.0);
        let point = Aabb::new([1.0; 3], [1.0; 3]);
        assert!(Surface::of(&point, 0.5, 0.0).is_none());
    }
}
