//! A few dozen items: sorted along each axis once, every cut between two of them is tried, down to the leaves.
//!
//! *How it works.* So few need no sorting: each is compared with each, and its place is the number of those before it. What is around
//! the items before and behind every cut is gathered, one minimum of eight lanes an item; when a part is divided, its three orders
//! are too.

use super::four::{FOUR, Parted};
use super::{Binned, Slice};
use crate::accel::bvh::build::sweep::Choice;
use crate::accel::bvh::build::{Item, Sides};
use crate::accel::bvh::tree::{BinaryNode, BinaryTree};
use crate::simd::{Floats, Kernel, Lanes, Simd};

/// The most items of which a subtree is made so.
pub(super) const SMALL: usize = 32;

/// The deepest that such a subtree can be.
pub(super) const LEVELS: usize = SMALL - 1;

/// Axes along which middles lie so much closer together than along another one are not looked at.
const SHORT: f32 = 0.5;

/// Makes the subtree of at most [`SMALL`] items; its root is a node that is there.
pub(super) struct Small<'a, 'i> {
    pub binned: &'a Binned<'i>,
    pub part: Slice<'i>,
    pub root: usize,
    pub tree: &'a mut BinaryTree,
}

/// Places in the orders, what is around the items there, and their node.
#[derive(Clone, Copy)]
struct Run {
    node: usize,
    start: usize,
    end: usize,
    around: Sides,
}

/// What all runs share.
struct Table<'a> {
    items: &'a [Item],
    /// The items along each axis.
    orders: [[u8; SMALL]; 3],
    /// Which of them go left.
    goes_left: [bool; SMALL],
    /// What is around those before, and around those behind a cut.
    before: [Sides; SMALL],
    behind: [Sides; SMALL],
}

/// How a run is divided: items are marked.
struct Found {
    cost: f32,
    left: usize,
    around: [Sides; 2],
}

impl Kernel<8> for Small<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Self {
            binned,
            part,
            root,
            tree,
        } = self;
        let len = part.items.len().min(SMALL);
        let mut table = Table {
            items: &part.items[..len],
            orders: orders(&part.items[..len]),
            goes_left: [false; SMALL],
            before: [Sides::EMPTY; SMALL],
            behind: [Sides::EMPTY; SMALL],
        };
        let first = Run {
            node: root,
            start: 0,
            end: len,
            around: part.around,
        };
        let mut open = [first; SMALL];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let run = open[count % SMALL];
            let found = if run.end - run.start < 2 {
                None
            } else {
                table.divide(s, binned, &run)
            };
            let place = match found {
                Some(found) => {
                    let (at, pair) = (run.start + found.left, tree.nodes.len());
                    let [left, right] = found.around;
                    open[count % SMALL] = Run {
                        node: pair + 1,
                        start: at,
                        end: run.end,
                        around: right,
                    };
                    open[(count + 1) % SMALL] = Run {
                        node: pair,
                        start: run.start,
                        end: at,
                        around: left,
                    };
                    count += 2;
                    tree.nodes.extend([BinaryNode::UNDECIDED; 2]);
                    (pair as u32, 0)
                }
                None => {
                    let first = tree.order.len() as u32;
                    for &item in &table.orders[0][run.start..run.end] {
                        tree.order.push(table.items[usize::from(item)].id());
                    }
                    (first, (run.end - run.start) as u32)
                }
            };
            tree.nodes[run.node] = BinaryNode {
                bounds: run.around.bounds(),
                first: place.0,
                count: place.1,
            };
        }
    }
}

impl Table<'_> {
    /// Divides a run of two items or more, unless they stay together.
    #[inline(always)]
    fn divide<S: Simd>(&mut self, s: S, binned: &Binned<'_>, run: &Run) -> Option<Found> {
        let axes = binned.settings.axes;
        let len = run.end - run.start;
        let of_four = len <= FOUR && axes.count() == 3;
        let found = if of_four {
            self.part_four(s, binned, run)
        } else {
            self.cut(s, binned, run)?
        };
        if binned.stay(len, run.around.half_area(), found.cost) {
            return None;
        }
        // Parts of four are found in any order.
        for order in &mut self.orders[..if of_four { 1 } else { 3 }] {
            let order = &mut order[run.start..run.end];
            let mut right = [0; SMALL];
            let (mut to_left, mut to_right) = (0, 0);
            for i in 0..order.len() {
                let item = order[i];
                let goes_left = usize::from(self.goes_left[usize::from(item) % SMALL]);
                // Both are written and one of them counts: which, nobody could foresee.
                order[to_left] = item;
                right[to_right % SMALL] = item;
                to_left += goes_left;
                to_right += 1 - goes_left;
            }
            order[to_left..].copy_from_slice(&right[..to_right]);
        }
        Some(found)
    }

    /// The cheapest way to part up to four.
    #[inline(always)]
    fn part_four<S: Lanes<8>>(&mut self, s: S, binned: &Binned<'_>, run: &Run) -> Found {
        let order = &self.orders[0][run.start..run.end];
        let mut sides = [Sides::EMPTY; FOUR];
        let last = order.len() - 1;
        for (i, &item) in order.iter().enumerate() {
            sides[if i == last { FOUR - 1 } else { i }] = self.items[usize::from(item)].sides();
        }
        let parted = Parted::of(s, order.len(), &sides, &binned.weights);
        for (i, &item) in order.iter().enumerate() {
            self.goes_left[usize::from(item) % SMALL] = parted.goes_left(i, order.len());
        }
        Found {
            cost: parted.cost,
            left: parted.left(order.len()),
            around: parted.around,
        }
    }

    /// The cheapest cut across an axis; none where no axis may be divided.
    #[inline(always)]
    fn cut<S: Lanes<8>>(&mut self, s: S, binned: &Binned<'_>, run: &Run) -> Option<Found> {
        let len = run.end - run.start;
        let mut best = Choice::NONE;
        let mut best_axis = 0;
        let mut around = [Sides::EMPTY; 2];
        let mut sizes = [0.0; 3];
        for axis in 0..3 {
            let middle = |place: usize| {
                let item = self.orders[axis][place % SMALL];
                self.items[usize::from(item)].middle_along(axis)
            };
            if binned.settings.axes.has(axis) {
                sizes[axis] = middle(run.end - 1) - middle(run.start);
            }
        }
        let longest = sizes[0].max(sizes[1]).max(sizes[2]);
        for axis in 0..3 {
            // Along short sides there is hardly ever a better cut.
            if !binned.settings.axes.has(axis) || sizes[axis] < SHORT * longest {
                continue;
            }
            let order = &self.orders[axis][run.start..run.end];
            let mut gathered = Sides::EMPTY.lanes(s);
            for at in 1..len {
                let item = &self.items[usize::from(order[at - 1])];
                gathered = item.sides().lanes(s).min(gathered);
                self.before[at % SMALL] = Sides::of_lanes::<S>(gathered);
            }
            let mut gathered = Sides::EMPTY.lanes(s);
            for at in (1..len).rev() {
                let item = &self.items[usize::from(order[at])];
                gathered = item.sides().lanes(s).min(gathered);
                self.behind[at % SMALL] = Sides::of_lanes::<S>(gathered);
            }
            let mut choice = Choice::NONE;
            for at in 1..len {
                let (left, right) = (at as u32, (len - at) as u32);
                let cost = binned.cost(self.before[at % SMALL].half_area(), left)
                    + binned.cost(self.behind[at % SMALL].half_area(), right);
                choice.offer(at, cost, left, right);
            }
            if choice.is_better(&best) {
                (best, best_axis) = (choice, axis);
                let at = choice.at() % SMALL;
                around = [self.before[at], self.behind[at]];
            }
        }
        let cut = best.cut()?;
        let order = &self.orders[best_axis][run.start..run.end];
        for (place, &item) in order.iter().enumerate() {
            self.goes_left[usize::from(item) % SMALL] = place < cut.at;
        }
        Some(Found {
            cost: cut.cost,
            left: cut.at,
            around,
        })
    }
}

/// Who comes where along each axis.
#[inline(always)]
fn orders(items: &[Item]) -> [[u8; SMALL]; 3] {
    const GROUP: usize = 8;
    let mut keys = [[[i32::MAX; GROUP]; SMALL / GROUP]; 3];
    for (i, item) in items.iter().enumerate() {
        let middle = item.middle();
        for axis in 0..3 {
            // Negative floats ascend when all bits but the sign are flipped: then NaN has a place too. The last bits make a number
            // of each that no other has.
            let bits = middle[axis].to_bits() as i32;
            let ascending = bits ^ ((bits >> 31) as u32 >> 1) as i32;
            keys[axis][i / GROUP][i % GROUP] = ascending & !(SMALL as i32 - 1) | i as i32;
        }
    }
    let mut orders = [[0; SMALL]; 3];
    for axis in 0..3 {
        let mut places = [[0; GROUP]; SMALL / GROUP];
        for (keys_of_group, places) in keys[axis]
            .iter()
            .zip(&mut places)
            .take(items.len().div_ceil(GROUP))
        {
            for i in 0..items.len() {
                let other = keys[axis][i / GROUP][i % GROUP];
                for lane in 0..GROUP {
                    places[lane] += i32::from(other < keys_of_group[lane]);
                }
            }
        }
        for i in 0..items.len() {
            orders[axis][places[i / GROUP][i % GROUP] as usize % SMALL] = i as u8;
        }
    }
    orders
}
