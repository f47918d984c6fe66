//! Growing a tree from the root: everything in one part, divided until a builder has enough of it.
//!
//! A builder says what a part is and how to divide it ([`Divide`]); nodes, order, depth, threads and limits are here.
//! Most parts are slices of items that are reordered in place: for those a closure is enough ([`top_down`]).

use super::{BYTES_EACH, Item, items};
#[cfg(feature = "parallel")]
use crate::accel::bvh::assemble::Parts;
use crate::accel::bvh::refine::Refine;
use crate::accel::bvh::tree::{BinaryNode, BinaryTree, MAX_DEPTH};
use crate::accel::limits::Site;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
#[cfg(feature = "parallel")]
use crate::threads;
use alloc::vec::Vec;
use core::marker::PhantomData;

/// How a builder divides what a node holds.
pub(super) trait Divide: Sync {
    /// What a node holds.
    type Part: Send;
    /// How many primitives.
    fn len(&self, part: &Self::Part) -> usize;
    /// Around all of them; asked for leaves only.
    fn bounds(&self, part: &Self::Part) -> Aabb;
    /// Divides a part, never into one that is empty or that holds more primitives than the whole.
    ///
    /// Where it may not choose, because the tree would grow too deep, it has to cut in the middle or to make a leaf.
    fn divide(&self, part: Self::Part, may_choose: bool) -> Divided<Self::Part>;
    /// Appends the primitives of a leaf to the order.
    fn list(&self, part: &Self::Part, order: &mut Vec<u32>);
}

/// What becomes of a part.
pub(super) enum Divided<P> {
    /// It stays together.
    Leaf(P),
    /// It falls in two.
    Halves([P; 2]),
}

/// Below this many primitives a subtree is built by one thread.
#[cfg(feature = "parallel")]
pub(super) const SEQUENTIAL: usize = 4096;

/// So many levels are enough to halve `len` things down to single ones.
pub(super) fn levels(len: usize) -> usize {
    (usize::BITS - len.saturating_sub(1).leading_zeros()) as usize
}

/// The units of work in growing and refining a tree over `len` primitives: one per primitive and level.
pub(super) fn work(len: usize, refine: Refine) -> usize {
    len.saturating_mul(levels(len) + 1 + refine.work())
}

/// Grows the tree of everything.
pub(super) fn grow<D: Divide>(divide: &D, all: D::Part, site: &Site<'_>) -> BinaryTree {
    let expected = levels(divide.len(&all));
    let work = Work {
        divide,
        site,
        expected,
    };
    #[cfg(feature = "parallel")]
    return parts(all, 0, &work).join();
    #[cfg(not(feature = "parallel"))]
    subtree(all, 0, &work)
}

/// What all parts of one build share.
struct Work<'a, D> {
    divide: &'a D,
    site: &'a Site<'a>,
    /// The depth that leaves are expected to have: progress goes by it.
    expected: usize,
}

impl<D: Divide> Work<'_, D> {
    /// Divides a part that lies at some depth, and tells the site.
    fn divide(&self, part: D::Part, depth: usize) -> Divided<D::Part> {
        let len = self.divide.len(&part);
        let may_choose = depth + levels(len) < MAX_DEPTH;
        let divided = self.divide.divide(part, may_choose);
        self.site.advance(match divided {
            Divided::Leaf(_) => len * (1 + self.expected.saturating_sub(depth)),
            Divided::Halves(_) => len,
        });
        divided
    }
}

/// Builds the tree of a part that lies at some depth; large ones side by side.
#[cfg(feature = "parallel")]
fn parts<D: Divide>(part: D::Part, depth: usize, work: &Work<'_, D>) -> Parts {
    if work.divide.len(&part) <= SEQUENTIAL || work.site.is_over() {
        return Parts::Whole(subtree(part, depth, work));
    }
    match work.divide(part, depth) {
        Divided::Leaf(part) => Parts::Whole(leaf(part, work)),
        Divided::Halves([left, right]) => {
            let (left, right) = threads::join(
                || parts(left, depth + 1, work),
                || parts(right, depth + 1, work),
            );
            let bounds = left.bounds().union(right.bounds());
            Parts::pair([left, right], bounds)
        }
    }
}

const UNDECIDED: BinaryNode = BinaryNode {
    bounds: Aabb::EMPTY,
    first: 0,
    count: 0,
};

/// A tree of one leaf.
#[cfg(feature = "parallel")]
fn leaf<D: Divide>(part: D::Part, work: &Work<'_, D>) -> BinaryTree {
    let mut order = Vec::new();
    work.divide.list(&part, &mut order);
    let root = BinaryNode {
        bounds: work.divide.bounds(&part),
        first: 0,
        count: order.len() as u32,
    };
    BinaryTree {
        nodes: alloc::vec![root],
        order,
    }
}

/// Builds the tree of a part that lies at some depth, by one thread. Its root comes first.
fn subtree<D: Divide>(part: D::Part, depth: usize, work: &Work<'_, D>) -> BinaryTree {
    let len = work.divide.len(&part);
    // Leaves of two are the fewest that most builders come to.
    let mut nodes = Vec::with_capacity(len);
    let mut order = Vec::with_capacity(len);
    nodes.push(UNDECIDED);
    let mut open = alloc::vec![(0, part, depth)];
    while let Some((node, part, depth)) = open.pop() {
        if work.site.is_over() {
            break;
        }
        match work.divide(part, depth) {
            Divided::Leaf(part) => {
                let first = order.len();
                work.divide.list(&part, &mut order);
                nodes[node] = BinaryNode {
                    bounds: work.divide.bounds(&part),
                    first: first as u32,
                    count: (order.len() - first) as u32,
                };
            }
            Divided::Halves([left, right]) => {
                let pair = nodes.len();
                nodes[node].first = pair as u32;
                nodes.extend([UNDECIDED; 2]);
                open.push((pair + 1, right, depth + 1));
                open.push((pair, left, depth + 1));
            }
        }
    }
    // Children come after their parents.
    for i in (0..nodes.len()).rev() {
        let first = nodes[i].first as usize;
        if !nodes[i].is_leaf()
            && let Some([a, b]) = nodes.get(first..first + 2)
        {
            nodes[i].bounds = a.bounds.union(b.bounds);
        }
    }
    BinaryTree { nodes, order }
}

/// What a builder says of some items.
pub(super) enum Split {
    /// They stay together.
    Leaf,
    /// They were reordered, and the second half begins here; where that leaves nothing on one side they are cut in the
    /// middle.
    At(usize),
}

/// Splits slices top-down: `split` reorders its slice and says where to cut.
pub(super) fn top_down<P: Primitives + Sync>(
    primitives: &P,
    axes: Axes,
    limits: &Limits<'_>,
    split: &(impl Fn(&mut [Item], &Extent) -> Split + Sync),
) -> Result<BinaryTree, BuildError> {
    top_down_refined(primitives, axes, Refine::NONE, limits, split)
}

/// The same, and refines the tree.
pub(super) fn top_down_refined<P: Primitives + Sync>(
    primitives: &P,
    axes: Axes,
    refine: Refine,
    limits: &Limits<'_>,
    split: &(impl Fn(&mut [Item], &Extent) -> Split + Sync),
) -> Result<BinaryTree, BuildError> {
    let site = Site::new(limits, work(primitives.len(), refine));
    if primitives.is_empty() || !site.take(BYTES_EACH.saturating_mul(primitives.len())) {
        return site.finish(BinaryTree::default());
    }
    let mut items = items(primitives);
    let slices = Slices {
        axes,
        split,
        items: PhantomData,
    };
    let mut tree = grow(&slices, &mut items[..], &site);
    drop(items);
    refine.apply(&mut tree, &site);
    site.finish(tree)
}

/// Parts that are slices of one list.
struct Slices<'i, 's, S> {
    axes: Axes,
    split: &'s S,
    items: PhantomData<fn(&'i mut [Item])>,
}

impl<'i, S: Fn(&mut [Item], &Extent) -> Split + Sync> Divide for Slices<'i, '_, S> {
    type Part = &'i mut [Item];

    fn len(&self, part: &Self::Part) -> usize {
        part.len()
    }
    fn bounds(&self, part: &Self::Part) -> Aabb {
        Item::around(part)
    }
    fn divide(&self, part: Self::Part, may_choose: bool) -> Divided<Self::Part> {
        let cut = match (self.split)(part, &Extent::of(part, self.axes)) {
            Split::Leaf => return Divided::Leaf(part),
            Split::At(cut) if may_choose && 0 < cut && cut < part.len() => cut,
            Split::At(_) => part.len() / 2,
        };
        Divided::Halves(part.split_at_mut(cut).into())
    }
    fn list(&self, part: &Self::Part, order: &mut Vec<u32>) {
        order.extend(part.iter().map(Item::id));
    }
}

/// Where the middles of some primitives lie.
pub(super) struct Extent {
    pub around: Aabb,
    pub axes: Axes,
}

impl Extent {
    pub fn of(items: &[Item], axes: Axes) -> Self {
        Self {
            around: Item::around_middles(items).bounds(),
            axes,
        }
    }
    /// The longest axis that may be divided, and its length.
    pub fn longest(&self) -> (usize, f32) {
        let size = self.around.size();
        let axis = self.axes.longest(size);
        (axis, size[axis])
    }
}
