//! Up to four items: every way to part them is tried, not only the cuts across an axis.
//!
//! *How it works.* The last item goes right. Each lane stands for a set of the three others that goes left: what is around it and around
//! the rest is found for all sets at once, a plane after the other.

use crate::accel::bvh::build::Sides;
use crate::accel::bvh::build::sweep::Block;
use crate::simd::{F, Floats, Lanes};

pub(super) const FOUR: usize = 4;

/// How many sets there are.
const SETS: usize = 8;

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
    /// The cheapest of all ways to part two to four items, of which the last lies at the end.
    #[inline(always)]
    pub fn of<S: Lanes<SETS>>(s: S, len: usize, all: &[Sides; FOUR], weights: &Weights) -> Self {
        let none = F::<S, SETS>::splat(s, f32::INFINITY);
        let (mut left, mut right) = ([none; 6], [none; 6]);
        for plane in 0..6 {
            right[plane] = F::<S, SETS>::splat(s, all[FOUR - 1].plane(plane));
            for item in 0..FOUR - 1 {
                let at = F::<S, SETS>::splat(s, all[item].plane(plane));
                left[plane] = (at + F::<S, SETS>::load(s, &IN[item])).min(left[plane]);
                right[plane] = (at + F::<S, SETS>::load(s, &OUT[item])).min(right[plane]);
            }
        }
        let weigh = &weights.0[len.min(FOUR)];
        let cost = half_area(s, &left) * F::<S, SETS>::load(s, &weigh[0])
            + half_area(s, &right) * F::<S, SETS>::load(s, &weigh[1]);
        // What is no number is dearest.
        let costs = cost.min(none).to_array();
        let mut set = 1;
        for other in 2..SETS {
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

    /// Whether an item goes left.
    #[inline(always)]
    pub fn goes_left(&self, item: usize, len: usize) -> bool {
        item + 1 < len && self.set >> item & 1 == 1
    }

    /// How many go left.
    #[inline(always)]
    pub fn left(&self, len: usize) -> usize {
        (self.set & ((1 << (len - 1)) - 1)).count_ones() as usize
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

    fn part(boxes: &[Aabb], block: Block) -> Parted {
        let mut sides = [Sides::EMPTY; FOUR];
        let (last, others) = boxes.split_last().expect("some boxes");
        for (sides, b) in sides.iter_mut().zip(others) {
            *sides = Sides::of(b);
        }
        sides[FOUR - 1] = Sides::of(last);
        Parted::of(Portable, boxes.len(), &sides, &Weights::of(block))
    }

    /// Boxes on a line: near ones stay together, whatever their order.
    #[test]
    fn neighbours_stay_together() {
        let orders: [&[f32]; 4] = [
            &[0.0, 9.0],
            &[0.0, 9.0, 1.0],
            &[9.0, 0.0, 10.0, 1.0],
            &[0.0, 2.0, 1.0, 30.0],
        ];
        for places in orders {
            let boxes = places
                .iter()
                .map(|&x| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]));
            let boxes: Vec<Aabb> = boxes.collect();
            let parted = part(&boxes, Block::ONE);
            let mut around = [Aabb::EMPTY; 2];
            let mut left = 0;
            for (i, b) in boxes.iter().enumerate() {
                let goes_left = parted.goes_left(i, boxes.len());
                left += usize::from(goes_left);
                let half = &mut around[usize::from(!goes_left)];
                *half = half.union(*b);
            }
            assert_eq!(left, parted.left(boxes.len()));
            assert_eq!(
                around,
                parted.around.map(|sides| sides.bounds()),
                "{places:?}"
            );
            let [a, b] = around.map(|half| half.size().x);
            assert!(a < 4.0 && b < 4.0, "{places:?}");
        }
    }

    #[test]
    fn boxes_that_are_infinite_are_parted_too() {
        let endless = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        for len in 2..=FOUR {
            let left = part(&[endless; FOUR][..len], Block::of(4)).left(len);
            assert!((1..len).contains(&left));
        }
    }
}
