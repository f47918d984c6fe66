//! Cuts where the surface-area heuristic, sampled at a few planes, is lowest.
//!
//! *How it works.* On each axis the primitives fall into equal bins by their middles; one sweep from either side gives the
//! cost of cutting between any two bins. The cheapest cut of the three axes is taken, unless keeping the primitives
//! together is cheaper and they are few enough for a leaf. A handful of primitives is sorted instead, and every cut
//! between two of them is tried.
//!
//! What is around a half is known when its parent has been divided, so that a level takes one pass that fills the bins of
//! all axes, one that parts the primitives, and one that looks where their middles lie.
//!
//! *Cost.* O(n log n), three bin look-ups per primitive and level.
//!
//! *Source.* Wald 2007, *On Fast Construction of SAH-based Bounding Volume Hierarchies*.

mod bins;
mod few;

use super::sweep::{Block, Cut};
use super::top_down::{Divide, Divided, grow, work};
use super::{BYTES_EACH, BinaryTree, Item, Sides, items};
use crate::accel::bvh::refine::Refine;
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::limits::Site;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;
use bins::{Bins, MAX_BINS};
use core::marker::PhantomData;
use few::FEW;

const MAX_BLOCK: usize = 16;

/// The binned builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BinnedSah {
    /// Bins per axis, 2 to 64.
    pub bins: usize,
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// How many primitives the structure tests at once, 1 to 16, rounded up to a power of two: cuts that leave no places
    /// empty are then preferred.
    pub block: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

impl Default for BinnedSah {
    fn default() -> Self {
        Self {
            bins: 16,
            max_leaf: 8,
            block: 1,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

impl BinnedSah {
    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let count = primitives.len();
        let site = Site::new(limits, work(count, self.refine));
        if count == 0 || !site.take(BYTES_EACH.saturating_mul(count)) {
            return site.finish(BinaryTree::default());
        }
        let binned = Binned {
            settings: Self {
                bins: self.bins.clamp(2, MAX_BINS),
                max_leaf: self.max_leaf.clamp(1, MAX_LEAF),
                block: self.block.clamp(1, MAX_BLOCK),
                ..*self
            },
            items: PhantomData,
        };
        let mut items = items(primitives);
        let all = Slice::of(&mut items);
        let mut tree = grow(&binned, all, &site);
        drop(items);
        self.refine.apply(&mut tree, &site);
        site.finish(tree)
    }
}

/// The settings at work, on slices of one list.
struct Binned<'i> {
    settings: BinnedSah,
    items: PhantomData<fn(&'i mut [Item])>,
}

/// Some items, what is around them and what is around their middles: known when their parent was divided.
struct Slice<'i> {
    items: &'i mut [Item],
    around: Sides,
    /// Not kept where there are no more than [`FEW`].
    middles: Sides,
}

impl<'i> Slice<'i> {
    fn of(items: &'i mut [Item]) -> Self {
        Self {
            around: Item::sides_around(items),
            middles: Item::around_middles(items),
            items,
        }
    }
    /// Two slices of one whose boxes are known.
    fn halves(self, at: usize, around: [Sides; 2]) -> [Self; 2] {
        let (left, right) = self.items.split_at_mut(at);
        let half = |items: &'i mut [Item], around| Self {
            middles: if items.len() > FEW {
                Item::around_middles(items)
            } else {
                Sides::EMPTY
            },
            items,
            around,
        };
        [half(left, around[0]), half(right, around[1])]
    }
    /// Two slices of one about which nothing is known.
    fn halved(self) -> [Self; 2] {
        let (left, right) = self.items.split_at_mut(self.items.len() / 2);
        [Self::of(left), Self::of(right)]
    }
}

impl<'i> Divide for Binned<'i> {
    type Part = Slice<'i>;

    fn len(&self, part: &Slice<'i>) -> usize {
        part.items.len()
    }
    fn bounds(&self, part: &Slice<'i>) -> Aabb {
        part.around.bounds()
    }
    fn list(&self, part: &Slice<'i>, order: &mut Vec<u32>) {
        order.extend(part.items.iter().map(Item::id));
    }
    fn divide(&self, part: Slice<'i>, may_choose: bool) -> Divided<Slice<'i>> {
        match part.items.len() {
            0 | 1 => Divided::Leaf(part),
            2..=FEW => self.divide_few(part, may_choose),
            // Most parts are small, and clearing bins that nobody asked for would take longer than filling the others.
            _ if self.settings.bins <= 16 => self.divide_many::<16>(part, may_choose),
            _ => self.divide_many::<MAX_BINS>(part, may_choose),
        }
    }
}

impl<'i> Binned<'i> {
    fn block(&self) -> Block {
        Block::of(self.settings.block)
    }
    /// Whether items stay together although they could be cut.
    fn stay(&self, part: &Slice<'i>, cut: &Cut) -> bool {
        let (len, area) = (part.items.len(), part.around.half_area());
        let together = PRIMITIVE_COST * len as f32 * area;
        let apart = NODE_COST * area + PRIMITIVE_COST * cut.cost;
        // Written so that a box without area, or with an infinite one, stays together.
        len <= self.settings.max_leaf && !(apart < together)
    }

    /// Where there is no cut, or none may be chosen.
    fn undecided(&self, part: Slice<'i>) -> Divided<Slice<'i>> {
        if part.items.len() <= self.settings.max_leaf {
            Divided::Leaf(part)
        } else {
            Divided::Halves(part.halved())
        }
    }

    fn divide_few(&self, part: Slice<'i>, may_choose: bool) -> Divided<Slice<'i>> {
        let Some(found) = few::cheapest_cut(part.items, self.settings.axes, self.block()) else {
            return self.undecided(part);
        };
        if self.stay(&part, &found.cut) {
            return Divided::Leaf(part);
        }
        if !may_choose {
            return Divided::Halves(part.halved());
        }
        found.put_in_order(part.items);
        let at = found.cut.at;
        let (left, right) = part.items.split_at(at);
        let around = [left, right].map(Item::sides_around);
        Divided::Halves(part.halves(at, around))
    }

    fn divide_many<const N: usize>(&self, part: Slice<'i>, may_choose: bool) -> Divided<Slice<'i>> {
        // Few items do not need many bins.
        let count = self.settings.bins.min(4 + part.items.len() / 2);
        let bins = Bins::new(count, &part.middles);
        let filled = bins.fill::<N>(part.items);
        let cuts = self.settings.axes.iter().filter_map(|axis| {
            let cut = filled.cheapest_cut(axis, count, self.block());
            cut.map(|cut| (axis, cut))
        });
        let best = cuts.reduce(|a, b| if b.1.is_better(&a.1) { b } else { a });
        let Some((axis, cut)) = best else {
            return self.undecided(part);
        };
        if self.stay(&part, &cut) {
            return Divided::Leaf(part);
        }
        if !may_choose {
            return Divided::Halves(part.halved());
        }
        let around = filled.around(axis, cut.at);
        let at = bins.part(part.items, axis, cut.at);
        Divided::Halves(part.halves(at, around))
    }
}

bvh_builder!(
    BinnedSah,
    "bvh:binned",
    |builder| [
        Setting::count("bins", &mut builder.bins, 2..=MAX_BINS),
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::count("block", &mut builder.block, 1..=MAX_BLOCK),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
