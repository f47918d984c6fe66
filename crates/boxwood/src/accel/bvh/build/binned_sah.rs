//! Cuts where the surface-area heuristic, sampled at a few planes, is lowest.
//!
//! *How it works.* On each axis the primitives fall into equal bins by their middles; one sweep from either side gives the
//! cost of cutting between any two bins. The cheapest cut of the three axes is taken, unless keeping the primitives
//! together is cheaper and they are few enough for a leaf. A handful of primitives is sorted instead, and every cut
//! between two of them is tried; of four, every way to part them.
//!
//! What is around a half is known when its parent has been divided, so that a level takes one pass that fills the bins of
//! all axes, one that parts the primitives, and one that looks where their middles lie.
//!
//! *Cost.* O(n log n), three bin look-ups per primitive and level.
//!
//! *Source.* Wald 2007, *On Fast Construction of SAH-based Bounding Volume Hierarchies*.

mod bins;
mod few;
mod four;
mod row;

use super::sweep::{Block, Cut, MAX_BLOCK};
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
use crate::simd::{Isa, Kernel, Level, Simd, Vectorize};
use alloc::vec::Vec;
use bins::{Bins, MAX_BINS};
use core::marker::PhantomData;
use few::FEW;
use four::{FOUR, Parted, Weights};
use row::Row;
#[cfg(feature = "parallel")]
use {
    super::top_down::SEQUENTIAL, crate::simd::Portable, crate::threads::Exactly, rayon::prelude::*,
};

/// For so many items and fewer, axes along which their middles lie close together are left out.
const SOME: usize = 32;

/// How far apart middles lie along an axis that counts: where few lie only half as far apart as along another axis, there is hardly ever a
/// better cut.
#[inline(always)]
fn least_size(axes: Axes, sizes: [f32; 3]) -> f32 {
    let mut longest = f32::NEG_INFINITY;
    for axis in 0..3 {
        if axes.has(axis) && sizes[axis] > longest {
            longest = sizes[axis];
        }
    }
    0.5 * longest
}

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
    /// The bytes that so many primitives take while their tree is built.
    pub(crate) fn bytes(count: usize) -> usize {
        BYTES_EACH.saturating_mul(count)
    }

    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let count = primitives.len();
        let site = Site::new(limits, work(count, self.refine));
        if count == 0 || !site.take(Self::bytes(count)) {
            return site.finish(BinaryTree::default());
        }
        let block = Block::of(self.block.clamp(1, MAX_BLOCK));
        let binned = Binned {
            settings: Self {
                bins: self.bins.clamp(2, MAX_BINS),
                max_leaf: self.max_leaf.clamp(1, MAX_LEAF),
                ..*self
            },
            block,
            weights: Weights::of(block),
            level: Isa::best().level(),
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
    block: Block,
    weights: Weights,
    level: Level,
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
    #[inline(always)]
    fn of(items: &'i mut [Item]) -> Self {
        Self {
            around: Item::sides_around(items),
            middles: Item::around_middles(items),
            items,
        }
    }
    /// Two slices of one whose boxes are known.
    #[inline(always)]
    fn halves(self, at: usize, around: [Sides; 2]) -> [Self; 2] {
        let (left, right) = self.items.split_at_mut(at);
        [Self::half(left, around[0]), Self::half(right, around[1])]
    }
    #[inline(always)]
    fn half(items: &'i mut [Item], around: Sides) -> Self {
        Self {
            middles: if items.len() > FEW {
                Item::around_middles(items)
            } else {
                Sides::EMPTY
            },
            items,
            around,
        }
    }
    /// Two slices of one about which nothing is known.
    #[inline(always)]
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
        if part.items.len() < 2 {
            return Divided::Leaf(part);
        }
        Vectorize::<8>::vectorize(
            self.level,
            Step {
                binned: self,
                part,
                may_choose,
            },
        )
    }
}

/// One division.
struct Step<'a, 'i> {
    binned: &'a Binned<'i>,
    part: Slice<'i>,
    may_choose: bool,
}

impl<'i> Kernel<8> for Step<'_, 'i> {
    type Output = Divided<Slice<'i>>;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Divided<Slice<'i>> {
        let Self {
            binned,
            part,
            may_choose,
        } = self;
        let len = part.items.len();
        let settings = &binned.settings;
        if !may_choose {
            return binned.undecided(part);
        }
        if len <= FOUR && settings.axes == Axes::XYZ {
            return binned.divide_four(s, part);
        }
        if len <= FEW {
            return binned.divide_few(s, part);
        }
        // Few items do not need many bins, and most parts are small: clearing bins that nobody asked for would take longer than
        // filling the others.
        match settings.bins.min(4 + len / 8) {
            count @ ..=8 => binned.divide_many::<S, 8>(s, part, count),
            count @ ..=16 => binned.divide_many::<S, 16>(s, part, count),
            count @ ..=32 => binned.divide_many::<S, 32>(s, part, count),
            count => binned.divide_many::<S, MAX_BINS>(s, part, count),
        }
    }
}

impl<'i> Binned<'i> {
    /// Whether items stay together although they could be parted at such a cost.
    #[inline(always)]
    fn stay(&self, part: &Slice<'i>, cost: f32) -> bool {
        let (len, area) = (part.items.len(), part.around.half_area());
        let together = PRIMITIVE_COST * len as f32 * area;
        let apart = NODE_COST * area + PRIMITIVE_COST * cost;
        // Written so that a box without area, or with an infinite one, stays together.
        len <= self.settings.max_leaf && !(apart < together)
    }

    /// Where there is no cut, or none may be chosen.
    #[inline(always)]
    fn undecided(&self, part: Slice<'i>) -> Divided<Slice<'i>> {
        if part.items.len() <= self.settings.max_leaf {
            Divided::Leaf(part)
        } else {
            Divided::Halves(part.halved())
        }
    }

    #[inline(always)]
    fn divide_four<S: Simd>(&self, s: S, part: Slice<'i>) -> Divided<Slice<'i>> {
        let parted = Parted::of(s, part.items, &self.weights);
        if self.stay(&part, parted.cost) {
            return Divided::Leaf(part);
        }
        let at = parted.part(part.items);
        Divided::Halves(part.halves(at, parted.around))
    }

    #[inline(always)]
    fn divide_few<S: Simd>(&self, s: S, part: Slice<'i>) -> Divided<Slice<'i>> {
        let Some(found) = few::cheapest_cut(s, part.items, self.settings.axes, self.block) else {
            return self.undecided(part);
        };
        if self.stay(&part, found.cut.cost) {
            return Divided::Leaf(part);
        }
        found.put_in_order(part.items);
        let at = found.cut.at;
        let (left, right) = part.items.split_at(at);
        let around = [Item::sides_around(left), Item::sides_around(right)];
        Divided::Halves(part.halves(at, around))
    }

    #[inline(always)]
    fn divide_many<S: Simd, const N: usize>(
        &self,
        s: S,
        part: Slice<'i>,
        count: usize,
    ) -> Divided<Slice<'i>> {
        let bins = Bins::new(count, &part.middles);
        let mut rows = [const { Row::<N>::EMPTY }; 3];
        self.fill(s, &bins, part.items, &mut rows);
        let mut best: Option<(usize, Cut)> = None;
        let size = part.middles.bounds().size();
        let least = if part.items.len() <= SOME {
            least_size(self.settings.axes, size.to_array())
        } else {
            f32::NEG_INFINITY
        };
        for axis in 0..3 {
            if self.settings.axes.has(axis)
                && !(size[axis] < least)
                && let Some(cut) = rows[axis].cheapest_cut(s, self.block)
                && best.as_ref().is_none_or(|best| cut.is_better(&best.1))
            {
                best = Some((axis, cut));
            }
        }
        let Some((axis, cut)) = best else {
            return self.undecided(part);
        };
        if self.stay(&part, cut.cost) {
            return Divided::Leaf(part);
        }
        let around = rows[axis].around(s, cut.at);
        let at = bins.part(part.items, axis, cut.at);
        Divided::Halves(part.halves(at, around))
    }

    /// Fills bins, by many threads where there is much.
    #[inline(always)]
    fn fill<S: Simd, const N: usize>(
        &self,
        s: S,
        bins: &Bins,
        items: &[Item],
        rows: &mut [Row<N>; 3],
    ) {
        #[cfg(feature = "parallel")]
        if items.len() > 8 * SEQUENTIAL {
            let fill = |items| {
                let fill = Fill { bins, items };
                Vectorize::<8>::vectorize(self.level, fill)
            };
            // Unions and sums of whole numbers: the order does not count.
            let merge = |mut all: [Row<N>; 3], other: [Row<N>; 3]| {
                for (all, other) in all.iter_mut().zip(&other) {
                    all.merge(Portable, other);
                }
                all
            };
            let parts = items.par_chunks(2 * SEQUENTIAL).exactly().map(fill);
            *rows = parts.reduce(|| [const { Row::EMPTY }; 3], merge);
            return;
        }
        bins.fill(s, items, rows);
    }
}

/// The share of one thread in filling bins.
#[cfg(feature = "parallel")]
struct Fill<'a, const N: usize> {
    bins: &'a Bins,
    items: &'a [Item],
}

#[cfg(feature = "parallel")]
impl<const N: usize> Kernel<8> for Fill<'_, N> {
    type Output = [Row<N>; 3];
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [Row<N>; 3] {
        let mut rows = [const { Row::EMPTY }; 3];
        self.bins.fill(s, self.items, &mut rows);
        rows
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::TriangleMesh;

    /// However long the scene is along the axes that may not be divided.
    #[test]
    fn an_axis_that_is_alone_is_always_cut() -> Result<(), Box<dyn core::error::Error>> {
        let corners = (0..100).flat_map(|i| {
            let x = ((i * 37) % 100) as f32;
            let z = 1000.0 * ((i * 61) % 100) as f32;
            [[x, 0.0, z], [x + 0.5, 0.0, z], [x, 0.5, z]]
        });
        let triangles = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2_u32]);
        let mesh = TriangleMesh::new(corners, triangles)?;
        let builder = BinnedSah {
            max_leaf: 1,
            axes: "x".parse()?,
            ..BinnedSah::default()
        };
        let places = builder.build(&mesh).order;
        assert!(places.is_sorted_by_key(|&i| (i * 37) % 100), "{places:?}");
        Ok(())
    }
}
