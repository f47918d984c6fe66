//! Up to four items: every way to part them is tried, not only the cuts across an axis.
//!
//! *How it works.* The last item goes right. Each lane stands for a set of the three others that goes left: what is around it and around
//! the rest is found for all sets at once, a plane after the other.

use crate::accel::bvh::build::sweep::Block;
use crate::accel::bvh::build::{Item, Sides};
use crate::simd::{F, Floats, Lanes};

pub(super) const FOUR: usize = 4;

/// How many sets there are.
const SETS: usize = 8;

/// All sets with something in them; of equally good ones the more even one is taken.
const EVEN_FIRST: [usize; SETS - 1] = [3, 5, 6, 1, 2, 4, 7];

/// For each item but the last and each set, what is added to its planes: nothing where it is in the set.
const IN: [[f32; SETS]; FOUR - 1] = added(1);
/// The same where it is not.
const OUT: [[f32; SETS]; FOUR - 1] = added(0);

const fn added(when: usize) -> [[f32; SETS]; FOUR - 1] {
    let mut all = [[f32::INFINITY; SETS]; FOUR - 1];
    let mut at = 0;
    while at < (FOUR - 1) * SETS {
        let (item, set) = (at / SETS, at % SETS);
        if set >> item & 1 == when {
            all[item][set] = 0.0;
        }
        at += 1;
    }
    all
}

/// What the two sides of each set weigh, by the number of items; infinite where nothing would go left.
pub(super) struct Weights([[[f32; SETS]; 2]; FOUR + 1]);

impl Weights {
    pub fn of(block: Block) -> Self {
        let mut weights = [[[f32::INFINITY; SETS]; 2]; FOUR + 1];
        for (len, [left, right]) in weights.iter_mut().enumerate().skip(2) {
            for set in 0..SETS {
                let count = (set & ((1 << (len - 1)) - 1)).count_ones();
                if count > 0 {
                    left[set] = block.weight(count);
                    right[set] = block.weight(len as u32 - count);
                }
            }
        }
        Self(weights)
    }
}

/// The cheapest way to part some items.
pub(super) struct Parted {
    pub cost: f32,
    /// Around those that go left, and around the others.
    pub around: [Sides; 2],
    set: usize,
}

impl Parted {
    /// The cheapest of all ways to part two to four items.
    #[inline(always)]
    pub fn of<S: Lanes<SETS>>(s: S, items: &[Item], weights: &Weights) -> Self {
        let len = items.len().min(FOUR);
        let mut all = [Sides::EMPTY; FOUR];
        for i in 0..len - 1 {
            all[i] = items[i].sides();
        }
        all[FOUR - 1] = items[len - 1].sides();
        let none = F::<S, SETS>::splat(s, f32::INFINITY);
        let (mut left, mut right) = ([none; 6], [none; 6]);
        for plane in 0..6 {
            // A minimum passes over what is no number when it comes first.
            right[plane] = F::<S, SETS>::splat(s, all[FOUR - 1].plane(plane)).min(none);
            for item in 0..FOUR - 1 {
                let at = F::<S, SETS>::splat(s, all[item].plane(plane));
                left[plane] = (at + F::<S, SETS>::load(s, &IN[item])).min(left[plane]);
                right[plane] = (at + F::<S, SETS>::load(s, &OUT[item])).min(right[plane]);
            }
        }
        let weigh = &weights.0[len];
        let cost = half_area(s, &left) * F::<S, SETS>::load(s, &weigh[0])
            + half_area(s, &right) * F::<S, SETS>::load(s, &weigh[1]);
        // What is no number is dearest.
        let costs = cost.min(none).to_array();
        let mut set = EVEN_FIRST[0];
        for other in EVEN_FIRST {
            set = if costs[other] < costs[set] {
                other
            } else {
                set
            };
        }
        Self {
            cost: costs[set],
            around: [lane(&left, set), lane(&right, set)],
            set,
        }
    }

    /// Brings those that go left to the front: how many they are.
    #[inline(always)]
    pub fn part(&self, items: &mut [Item]) -> usize {
        let len = items.len().min(FOUR);
        let set = self.set & ((1 << (len - 1)) - 1);
        let left = set.count_ones() as usize;
        let mut old = [items[0]; FOUR];
        old[..len].copy_from_slice(&items[..len]);
        let mut next = [left, 0];
        for i in 0..len {
            let next = &mut next[set >> i & 1];
            items[*next] = old[i];
            *next += 1;
        }
        left
    }
}

#[inline(always)]
fn half_area<S: Lanes<SETS>>(s: S, planes: &[F<S, SETS>; 6]) -> F<S, SETS> {
    let zero = F::<S, SETS>::splat(s, 0.0);
    let x = (zero - planes[3] - planes[0]).max(zero);
    let y = (zero - planes[4] - planes[1]).max(zero);
    let z = (zero - planes[5] - planes[2]).max(zero);
    x * y + y * z + z * x
}

/// What is around the items of one set.
#[inline(always)]
fn lane<F: Floats<SETS>>(planes: &[F; 6], set: usize) -> Sides {
    let mut all = [0.0; 6];
    for plane in 0..6 {
        all[plane] = planes[plane].to_array()[set & (SETS - 1)];
    }
    Sides::of_planes(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;
    use crate::simd::Portable;

    /// Some boxes on a line: at least cost, near ones stay together, whatever their order.
    #[test]
    fn neighbours_stay_together() {
        let weights = Weights::of(Block::ONE);
        let item = |x: f32, id: u32| Item::new(&Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]), id);
        for (places, near) in [
            (vec![0.0, 9.0], 1),
            (vec![0.0, 9.0, 1.0], 2),
            (vec![9.0, 0.0, 10.0, 1.0], 2),
            (vec![0.0, 2.0, 1.0, 30.0], 3),
        ] {
            let mut items: Vec<Item> = places.iter().zip(0..).map(|(&x, id)| item(x, id)).collect();
            let parted = Parted::of(Portable, &items, &weights);
            let left = parted.part(&mut items);
            let far = |item: &Item| item.bounds().lower.x > 5.0;
            assert!(left == near || left == places.len() - near, "{places:?}");
            for (half, around) in [&items[..left], &items[left..]].iter().zip(parted.around) {
                assert_eq!(around.bounds(), Item::around(half));
                assert!(half.iter().all(far) || !half.iter().any(far), "{places:?}");
            }
            let mut ids: Vec<u32> = items.iter().map(Item::id).collect();
            ids.sort_unstable();
            assert!(ids.into_iter().eq(0..places.len() as u32));
        }
    }

    #[test]
    fn boxes_that_are_infinite_are_parted_too() {
        let weights = Weights::of(Block::of(4));
        let endless = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        for len in 2..=FOUR {
            let mut items: Vec<Item> = (0..len as u32).map(|id| Item::new(&endless, id)).collect();
            let left = Parted::of(Portable, &items, &weights).part(&mut items);
            assert_eq!(left.min(len - left), len / 2);
        }
    }
}
