//! Cuts where the bits of a curve through space change: the fastest builder.
//!
//! *How it works.* The primitives are sorted along a Morton curve. A node is a run of them; it is cut where the highest bit
//! that differs within the run goes from 0 to 1, which is a plane in the middle of a cell of the grid. Runs of equal codes
//! are halved. At last small subtrees become leaves where that is cheaper.
//!
//! *Cost.* O(n) to sort, O(n) unions a level.
//!
//! *Source.* Lauterbach et al. 2009, *Fast BVH Construction on GPUs*; the halving of equal codes is that of Karras 2012,
//! *Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees*.

#[cfg(feature = "parallel")]
use super::top_down::SEQUENTIAL;
use super::top_down::{Divide, Divided, grow, work};
use super::{BYTES_EACH, BinaryTree, Item, items};
use crate::accel::bvh::refine::{Refine, collapse_leaves};
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::limits::Site;
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::geometry::morton::{self, Coded, Grid};
use crate::primitive::Primitives;
use alloc::vec::Vec;
use core::marker::PhantomData;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// The builder along a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lbvh {
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

impl Default for Lbvh {
    fn default() -> Self {
        Self {
            max_leaf: 8,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

impl Lbvh {
    /// The bytes that so many primitives take while their tree is built.
    pub(crate) fn bytes(count: usize) -> usize {
        (BYTES_EACH + CURVE_BYTES_EACH).saturating_mul(count)
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
        let Some((codes, items)) = along_curve(primitives, self.axes, &site) else {
            return site.finish(BinaryTree::default());
        };
        let by_bits = ByBits { run: PhantomData };
        let mut tree = grow(&by_bits, (&codes[..], &items[..]), &site);
        drop((codes, items));
        if !site.is_over() {
            self.refine.apply(&mut tree, &site);
            collapse_leaves(&mut tree, self.max_leaf);
        }
        site.finish(tree)
    }
}

/// What sorting along the curve needs for each primitive.
pub(super) const CURVE_BYTES_EACH: usize = 2 * size_of::<Coded>() + size_of::<Item>();

/// The primitives in the order of a Morton curve, and their codes; `None` when the build is over.
pub(super) fn along_curve(
    primitives: &(impl Primitives + Sync),
    axes: Axes,
    site: &Site<'_>,
) -> Option<(Vec<Coded>, Vec<Item>)> {
    let unsorted = items(primitives);
    // Those that can be told apart: the others lie at the curve's beginning or end.
    let finite = |items: &[Item]| {
        let middles = items.iter().map(Item::centroid);
        Aabb::of(middles.filter(|middle| middle.is_finite()))
    };
    #[cfg(feature = "parallel")]
    let around = unsorted
        .par_chunks(SEQUENTIAL)
        .exactly()
        .map(finite)
        .reduce(|| Aabb::EMPTY, Aabb::union);
    #[cfg(not(feature = "parallel"))]
    let around = finite(&unsorted);
    let grid = Grid::over(&around, [0, 1, 2].map(|axis| axes.has(axis)));
    let coded = |item: &Item| Coded {
        code: grid.code(item.centroid()),
        id: item.id(),
    };
    #[cfg(feature = "parallel")]
    let mut codes: Vec<Coded> = unsorted.par_iter().exactly().map(coded).collect();
    #[cfg(not(feature = "parallel"))]
    let mut codes: Vec<Coded> = unsorted.iter().map(coded).collect();
    let mut spare = alloc::vec![Coded::default(); unsorted.len()];
    // A pass over the codes is a small part of what a level of a build takes.
    if !morton::sort(&mut codes, &mut spare, &|codes| site.advance(codes / 2)) {
        return None;
    }
    drop(spare);
    let item = |coded: &Coded| unsorted[coded.id as usize];
    #[cfg(feature = "parallel")]
    let items = codes.par_iter().map(item).collect();
    #[cfg(not(feature = "parallel"))]
    let items = codes.iter().map(item).collect();
    Some((codes, items))
}

struct ByBits<'r> {
    run: PhantomData<fn(&'r [Item])>,
}

impl<'r> Divide for ByBits<'r> {
    type Part = (&'r [Coded], &'r [Item]);

    fn len(&self, part: &Self::Part) -> usize {
        part.1.len()
    }
    fn bounds(&self, part: &Self::Part) -> Aabb {
        Item::around(part.1)
    }
    fn list(&self, part: &Self::Part, order: &mut Vec<u32>) {
        order.extend(part.1.iter().map(Item::id));
    }
    fn divide(&self, part: Self::Part, may_choose: bool) -> Divided<Self::Part> {
        let (codes, items) = part;
        let [first, .., last] = codes else {
            return Divided::Leaf(part);
        };
        let differing = first.code ^ last.code;
        let at = if differing == 0 || !may_choose {
            items.len() / 2
        } else {
            let bit = 1 << differing.ilog2();
            codes.partition_point(|coded| coded.code & bit == 0)
        };
        let (codes, items) = (codes.split_at(at), items.split_at(at));
        Divided::Halves([(codes.0, items.0), (codes.1, items.1)])
    }
}

bvh_builder!(
    Lbvh,
    "bvh:lbvh",
    |builder| [
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
