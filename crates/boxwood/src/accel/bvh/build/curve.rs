//! Primitives in the order of a curve through space.

use super::{Item, items};
use crate::accel::Axes;
use crate::accel::limits::Site;
use crate::geometry::Aabb;
use crate::geometry::morton::{self, Coded, Grid};
use crate::primitive::Primitives;
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use {super::top_down::SEQUENTIAL, crate::threads::Exactly, rayon::prelude::*};

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
