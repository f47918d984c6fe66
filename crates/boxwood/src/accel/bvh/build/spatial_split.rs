//! Cuts by the surface-area heuristic, and cuts primitives in two where boxes would overlap too much.
//!
//! *How it works.* A node's references are sorted along each axis and the cheapest of all cuts between them is found, as
//! [`SweepSah`](super::SweepSah) does, or, where there are many, the cheapest between bins. Where the two boxes of that cut overlap by more than a small part of the scene's
//! area, planes are weighed too: references that a plane crosses are clipped, and each side counts its part. The cheaper of
//! both is taken. A reference that is cheaper left whole on one side than cut ("unsplit") stays whole.
//!
//! Each cut adds references; all may be [`budget`](SpatialSplit::budget) times the primitives. What a node does not use
//! goes to its two sides by their numbers of references, so that the tree does not depend on the order of work.
//!
//! *Cost.* O(n log² n) and the clipping: some five times the sweep's time.
//!
//! *Source.* Stich, Friedrich & Dietrich 2009, *Spatial Splits in Bounding Volume Hierarchies*.

mod objects;
mod planes;

use super::sweep::{Block, MAX_BLOCK};
use super::top_down::{Divide, Divided, grow, work};
use super::{BYTES_EACH, BinaryTree, Item, Sides, items};
use crate::accel::bvh::refine::Refine;
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::cells::Space;
use crate::accel::limits::Site;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;
use planes::MAX_BINS;

/// The builder with spatial splits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialSplit {
    /// References per primitive, 1 to 4: at 1 nothing is cut.
    pub budget: f32,
    /// Which part of the scene's area two boxes must overlap by before planes are weighed.
    pub alpha: f32,
    /// Planes per axis, and one more, 2 to 64.
    pub bins: usize,
    /// Between how many bins by their middles the references of larger nodes are cut, 2 to 64, as [`BinnedSah`](super::BinnedSah)
    /// does; 0 sorts them and tries every cut, as the paper does.
    pub object_bins: usize,
    /// Most references in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// How many primitives the structure tests at once, 1 to 16, rounded up to a power of two: cuts that leave no places
    /// empty are then preferred.
    pub block: usize,
    /// The axes that may be divided.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

/// The most references per primitive.
const MAX_BUDGET: f32 = 4.0;

impl Default for SpatialSplit {
    fn default() -> Self {
        Self {
            budget: 1.3,
            alpha: 3.0e-4,
            bins: 8,
            object_bins: 0,
            max_leaf: 8,
            block: 1,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

impl SpatialSplit {
    /// The most references that there may be to so many primitives.
    fn most_references(&self, count: usize) -> usize {
        // Numbers of places and nodes have 32 bits.
        let most = (f64::from(self.budget.clamp(1.0, MAX_BUDGET)) * count as f64) as usize;
        most.min(u32::MAX as usize / 2).max(count)
    }

    /// The bytes that so many primitives take while their tree is built.
    pub(crate) fn bytes(&self, count: usize) -> usize {
        // A node's references and those of its sides exist at once.
        let bytes = BYTES_EACH + 2 * size_of::<Item>();
        bytes.saturating_mul(self.most_references(count))
    }

    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let count = primitives.len();
        let site = Site::new(limits, work(count, self.refine));
        let most = self.most_references(count);
        if count == 0 || !site.take(self.bytes(count)) {
            return site.finish(BinaryTree::default());
        }
        let references = items(primitives);
        let bounds = Item::around(&references);
        let splitter = Splitter {
            block: Block::of(self.block.clamp(1, MAX_BLOCK)),
            settings: Self {
                bins: self.bins.clamp(2, MAX_BINS),
                object_bins: self.object_bins.min(MAX_BINS),
                max_leaf: self.max_leaf.clamp(1, MAX_LEAF),
                ..*self
            },
            least_overlap: self.alpha * bounds.half_area(),
            space: Space::of(primitives),
            primitives,
        };
        let all = References {
            bounds,
            spare: most - count,
            items: references,
        };
        let mut tree = grow(&splitter, all, &site);
        self.refine.apply(&mut tree, &site);
        site.finish(tree)
    }
}

struct Splitter<'p, P> {
    settings: SpatialSplit,
    block: Block,
    least_overlap: f32,
    space: Space,
    primitives: &'p P,
}

/// What a node holds: whole primitives and parts of some.
struct References {
    bounds: Aabb,
    items: Vec<Item>,
    /// How many references may be added.
    spare: usize,
}

impl References {
    fn of(items: Vec<Item>, spare: usize) -> Self {
        Self {
            bounds: Item::around(&items),
            items,
            spare,
        }
    }
}

impl<P: Primitives + Sync> Divide for Splitter<'_, P> {
    type Part = References;

    fn len(&self, part: &References) -> usize {
        part.items.len()
    }
    fn bounds(&self, part: &References) -> Aabb {
        part.bounds
    }
    fn list(&self, part: &References, order: &mut Vec<u32>) {
        order.extend(part.items.iter().map(Item::id));
    }
    fn divide(&self, part: References, may_choose: bool) -> Divided<References> {
        let len = part.items.len();
        let Some(object) = self.object_cut(&part.items) else {
            return Divided::Leaf(part);
        };
        let item = |key: &u64| part.items[*key as u32 as usize];
        let around = |keys: &[u64]| {
            let sides = keys.iter().map(|key| item(key).sides());
            let around = sides.fold(Sides::EMPTY, |a, b| a.around(&b));
            around.bounds()
        };
        let at = if may_choose { object.at } else { len / 2 };
        let (left, right) = object.keys.split_at(at);
        let bounds = [around(left), around(right)];
        let mut cost = object.cost;
        let mut spatial = None;
        if may_choose
            && part.spare > 0
            && bounds[0].intersection(bounds[1]).half_area() > self.least_overlap
            && let Some(plane) = self.best_plane(&part)
            && plane.cut.cost < cost
        {
            spatial = self.cut_at(&part, &plane);
            if spatial.is_some() {
                cost = plane.cut.cost;
            }
        }
        if len <= self.settings.max_leaf {
            let area = part.bounds.half_area();
            let together = PRIMITIVE_COST * len as f32 * area;
            let apart = NODE_COST * area + PRIMITIVE_COST * cost;
            // Written so that a box without area, or with an infinite one, stays together.
            if !(apart < together) {
                return Divided::Leaf(part);
            }
        }
        let [mut left, mut right] = spatial.unwrap_or_else(|| {
            [(left, bounds[0]), (right, bounds[1])].map(|(keys, bounds)| References {
                bounds,
                items: keys.iter().map(item).collect(),
                spare: 0,
            })
        });
        let (on_left, on_right) = (left.items.len(), right.items.len());
        let rest = part.spare - (on_left + on_right - len).min(part.spare);
        left.spare = (rest as u64 * on_left as u64 / (on_left + on_right) as u64) as usize;
        right.spare = rest - left.spare;
        Divided::Halves([left, right])
    }
}

bvh_builder!(
    SpatialSplit,
    "bvh:sbvh",
    |builder| [
        Setting::real("budget", &mut builder.budget, 1.0..=MAX_BUDGET),
        Setting::real("alpha", &mut builder.alpha, 0.0..=1.0),
        Setting::count("bins", &mut builder.bins, 2..=MAX_BINS),
        Setting::count("objectbins", &mut builder.object_bins, 0..=MAX_BINS),
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::count("block", &mut builder.block, 1..=MAX_BLOCK),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
