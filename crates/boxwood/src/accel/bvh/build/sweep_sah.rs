//! Cuts where the surface-area heuristic is lowest of all places.
//!
//! *How it works.* The primitives are sorted by their middles once for each axis. At every node the cut between any two
//! neighbours of any of the three rows is weighed; the cheapest is taken, unless keeping the primitives together is cheaper
//! and they are few enough for a leaf. The other two rows are then parted without losing their order, so that nothing is
//! ever sorted again.
//!
//! *Cost.* O(n log n), 140 bytes a primitive while it builds, beside the tree.
//!
//! *Source.* Goldsmith & Salmon 1987; MacDonald & Booth 1990; the presorted rows of Wald & Havran 2006 and Wald 2007.

use super::sweep::{Block, Cut, Slot, cheapest_cut};
#[cfg(feature = "parallel")]
use super::top_down::SEQUENTIAL;
use super::top_down::{Divide, Divided, grow, work};
use super::{BYTES_EACH, BinaryTree, Item, items};
use crate::accel::bvh::refine::Refine;
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::limits::Site;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::geometry::morton::{self, Coded};
use crate::primitive::Primitives;
use alloc::vec::Vec;
use core::marker::PhantomData;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// The builder by full sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepSah {
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

impl Default for SweepSah {
    fn default() -> Self {
        Self {
            max_leaf: 8,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

/// Three rows of items, and one more that parting needs. Weighing the cuts of a row takes a number for each item.
const ROWS: usize = 4;

impl SweepSah {
    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let count = primitives.len();
        let site = Site::new(limits, work(count, self.refine));
        let bytes = BYTES_EACH + (ROWS - 1) * size_of::<Item>() + 3 * size_of::<f32>();
        if count == 0 || !site.take(bytes.saturating_mul(count)) {
            return site.finish(BinaryTree::default());
        }
        let mut spare = items(primitives);
        let mut rows = [const { Vec::new() }; 3];
        for axis in self.axes.iter() {
            let Some(row) = sorted(&spare, axis, &site) else {
                return site.finish(BinaryTree::default());
            };
            rows[axis] = row;
        }
        let sweep = Sweep {
            axes: self.axes,
            max_leaf: self.max_leaf.clamp(1, MAX_LEAF),
            rows: PhantomData,
        };
        let all = Rows {
            bounds: Item::around(&spare),
            by_axis: rows.each_mut().map(|row| &mut row[..]),
            spare: &mut spare,
        };
        let mut tree = grow(&sweep, all, &site);
        drop((rows, spare));
        self.refine.apply(&mut tree, &site);
        site.finish(tree)
    }
}

/// What sorting along one axis needs for each item.
const SORT_BYTES_EACH: usize = 2 * size_of::<Coded>();

/// The items, which lie in the order of their numbers, by their middles along an axis; `None` when the build is over.
fn sorted(items: &[Item], axis: usize, site: &Site<'_>) -> Option<Vec<Item>> {
    let bytes = SORT_BYTES_EACH.saturating_mul(items.len());
    if !site.take(bytes) {
        return None;
    }
    let coded = |(place, item): (usize, &Item)| Coded {
        code: item.key(axis, 0) >> 32,
        id: place as u32,
    };
    #[cfg(feature = "parallel")]
    let mut codes: Vec<Coded> = items.par_iter().enumerate().exactly().map(coded).collect();
    #[cfg(not(feature = "parallel"))]
    let mut codes: Vec<Coded> = items.iter().enumerate().map(coded).collect();
    let mut spare = alloc::vec![Coded::default(); items.len()];
    let is_sorted = morton::sort(&mut codes, &mut spare, &|codes| site.advance(codes / 4));
    let item = |coded: &Coded| items[coded.id as usize];
    #[cfg(feature = "parallel")]
    let row = codes.par_iter().map(item).collect();
    #[cfg(not(feature = "parallel"))]
    let row = codes.iter().map(item).collect();
    site.give(bytes);
    is_sorted.then_some(row)
}

struct Sweep<'i> {
    axes: Axes,
    max_leaf: usize,
    rows: PhantomData<fn(&'i mut [Item])>,
}

/// The same items along each axis that may be divided.
struct Rows<'i> {
    bounds: Aabb,
    by_axis: [&'i mut [Item]; 3],
    /// As long as a row; what is in it does not count.
    spare: &'i mut [Item],
}

impl Sweep<'_> {
    /// The cheapest cut along one axis.
    fn cut(row: &[Item], axis: usize) -> Option<(usize, Cut)> {
        let weigh = |behind: &mut [f32]| {
            let cut = cheapest_cut(row.len(), u32::MAX, Block::ONE, behind, |i| Slot {
                sides: row[i].sides(),
                begin: 1,
                end: 1,
            });
            cut.map(|cut| (axis, cut))
        };
        // Most rows are short: no need to ask for memory.
        if row.len() <= 64 {
            weigh(&mut [0.0; 64])
        } else {
            weigh(&mut alloc::vec![0.0; row.len()])
        }
    }

    fn best_cut(&self, rows: &Rows<'_>) -> Option<(usize, Cut)> {
        let better = |a: (usize, Cut), b: (usize, Cut)| {
            if b.1.is_better(&a.1) { b } else { a }
        };
        let cut = |axis: usize| Self::cut(rows.by_axis[axis], axis);
        #[cfg(feature = "parallel")]
        if rows.spare.len() > 4 * SEQUENTIAL {
            let cuts: Vec<_> = (0..3_usize).into_par_iter().exactly().map(cut).collect();
            return cuts.into_iter().flatten().reduce(better);
        }
        self.axes.iter().filter_map(cut).reduce(better)
    }
}

impl<'i> Divide for Sweep<'i> {
    type Part = Rows<'i>;

    fn len(&self, part: &Rows<'i>) -> usize {
        part.spare.len()
    }
    fn bounds(&self, part: &Rows<'i>) -> Aabb {
        part.bounds
    }
    fn list(&self, part: &Rows<'i>, order: &mut Vec<u32>) {
        let row = &part.by_axis[self.axes.iter().next().unwrap_or(0)];
        order.extend(row.iter().map(Item::id));
    }
    fn divide(&self, part: Rows<'i>, may_choose: bool) -> Divided<Rows<'i>> {
        let len = part.spare.len();
        let Some((axis, cut)) = self.best_cut(&part) else {
            return Divided::Leaf(part);
        };
        if len <= self.max_leaf {
            let area = part.bounds.half_area();
            let together = PRIMITIVE_COST * len as f32 * area;
            let apart = NODE_COST * area + PRIMITIVE_COST * cut.cost;
            // Written so that a box without area, or with an infinite one, stays together.
            if !(apart < together) {
                return Divided::Leaf(part);
            }
        }
        let at = if may_choose { cut.at } else { len / 2 };
        let Rows { by_axis, spare, .. } = part;
        let first_right = &by_axis[axis][at];
        let border = first_right.key(axis, first_right.id());
        let mut bounds = [Aabb::EMPTY; 2];
        let mut axes = 0..3;
        let halves = by_axis.map(|row| {
            let this = axes.next().unwrap_or(0);
            if row.is_empty() {
                return row.split_at_mut(0);
            }
            if this == axis {
                let (left, right) = row.split_at_mut(at);
                bounds = [Item::around(left), Item::around(right)];
                return (left, right);
            }
            part_in_order(row, spare, |item| item.key(axis, item.id()) < border);
            row.split_at_mut(at)
        });
        let [x, y, z] = halves;
        let (left, right) = spare.split_at_mut(at);
        Divided::Halves([
            Rows {
                bounds: bounds[0],
                by_axis: [x.0, y.0, z.0],
                spare: left,
            },
            Rows {
                bounds: bounds[1],
                by_axis: [x.1, y.1, z.1],
                spare: right,
            },
        ])
    }
}

/// Brings those that go left before the others; both keep their order.
fn part_in_order(row: &mut [Item], spare: &mut [Item], goes_left: impl Fn(&Item) -> bool) {
    let (mut left, mut right) = (0, 0);
    for i in 0..row.len() {
        let item = row[i];
        // Both are written and one of them counts: which, nobody could foresee.
        row[left] = item;
        spare[right] = item;
        let goes_left = usize::from(goes_left(&item));
        left += goes_left;
        right += 1 - goes_left;
    }
    row[left..].copy_from_slice(&spare[..right]);
}

bvh_builder!(
    SweepSah,
    "bvh:sweep",
    |builder| [
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
