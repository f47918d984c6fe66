//! Growing a tree from the root: everything in one part, divided until a builder has enough of it.
//!
//! A builder says what a part is and how to divide it ([`Divide`]); nodes, order, depth, threads and limits are here.
//! Most parts are slices of items that are reordered in place: for those a closure is enough ([`top_down`]).

use super::{BYTES_EACH, Item, items};
use crate::accel::bvh::refine::Refine;
use crate::accel::bvh::tree::{BinaryNode, BinaryTree, MAX_DEPTH};
use crate::accel::limits::Site;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;
use core::marker::PhantomData;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// How a builder divides what a node holds.
pub(super) trait Divide: Sync {
    /// What a node holds.
    type Part: Send;
    /// How many primitives.
    fn len(&self, part: &Self::Part) -> usize;
    /// Around all of them.
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
    subtree(
        all,
        0,
        &Work {
            divide,
            site,
            expected,
        },
    )
}

/// What all parts of one build share.
struct Work<'a, D> {
    divide: &'a D,
    site: &'a Site<'a>,
    /// The depth that leaves are expected to have: progress goes by it.
    expected: usize,
}

/// Builds the tree of a part that lies at some depth. Its root comes first.
fn subtree<D: Divide>(part: D::Part, depth: usize, work: &Work<'_, D>) -> BinaryTree {
    let divide = work.divide;
    // Said to be a leaf or not when its part is divided.
    let undecided = |part: &D::Part| BinaryNode {
        bounds: divide.bounds(part),
        first: 0,
        count: 0,
    };
    let mut tree = BinaryTree {
        nodes: alloc::vec![undecided(&part)],
        order: Vec::new(),
    };
    let mut open = alloc::vec![(0, part, depth)];
    while let Some((node, part, depth)) = open.pop() {
        if work.site.is_over() {
            return tree;
        }
        let len = divide.len(&part);
        let may_choose = depth + levels(len) < MAX_DEPTH;
        let halves = match divide.divide(part, may_choose) {
            Divided::Leaf(part) => {
                work.site
                    .advance(len * (1 + work.expected.saturating_sub(depth)));
                let first = tree.order.len();
                divide.list(&part, &mut tree.order);
                tree.nodes[node].first = first as u32;
                tree.nodes[node].count = (tree.order.len() - first) as u32;
                continue;
            }
            Divided::Halves(halves) => halves,
        };
        work.site.advance(len);
        let pair = tree.nodes.len();
        tree.nodes[node].first = pair as u32;
        let [left, right] = halves;
        #[cfg(feature = "parallel")]
        if len > SEQUENTIAL {
            let (left, right) = rayon::join(
                || subtree(left, depth + 1, work),
                || subtree(right, depth + 1, work),
            );
            append_pair(&mut tree, [left, right]);
            continue;
        }
        tree.nodes.extend([undecided(&left), undecided(&right)]);
        open.push((pair + 1, right, depth + 1));
        open.push((pair, left, depth + 1));
    }
    tree
}

/// Two finished subtrees behind what is there: both roots, then what is below the one and the other.
#[cfg(feature = "parallel")]
fn append_pair(tree: &mut BinaryTree, halves: [BinaryTree; 2]) {
    let (at, places) = (tree.nodes.len(), tree.order.len());
    // Children in the left half move by `at + 1`, those in the right half by the left half's length more.
    let moves = [
        (at + 1, places),
        (at + halves[0].nodes.len(), places + halves[0].order.len()),
    ];
    let moved = |node: &BinaryNode, (children, places): (usize, usize)| BinaryNode {
        first: node.first + if node.is_leaf() { places } else { children } as u32,
        ..*node
    };
    // Exactly, because doubling would take more than the builder has asked for.
    let more: usize = halves.iter().map(|half| half.nodes.len()).sum();
    tree.nodes.reserve_exact(more);
    tree.order
        .reserve_exact(halves[0].order.len() + halves[1].order.len());
    for (half, by) in halves.iter().zip(moves) {
        tree.nodes.push(moved(&half.nodes[0], by));
    }
    for (half, by) in halves.iter().zip(moves) {
        tree.nodes
            .extend(half.nodes[1..].iter().map(|node| moved(node, by)));
        tree.order.extend(&half.order);
    }
}

/// What a builder says of some items.
pub(super) enum Split {
    /// They stay together.
    Leaf,
    /// They were reordered, and the second half begins here.
    At(usize),
    /// They lie all in one place, or no cut is worth more than another: cut them in the middle.
    Halve,
}

/// Splits slices top-down: `split` reorders its slice and says where to cut.
pub(super) fn top_down<P: Primitives>(
    primitives: &P,
    axes: Axes,
    limits: &Limits<'_>,
    split: &(impl Fn(&mut [Item], &Extent) -> Split + Sync),
) -> Result<BinaryTree, BuildError> {
    top_down_refined(primitives, axes, Refine::NONE, limits, split)
}

/// The same, and refines the tree.
pub(super) fn top_down_refined<P: Primitives>(
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
            Split::At(_) | Split::Halve => part.len() / 2,
        };
        Divided::Halves(part.split_at_mut(cut).into())
    }
    fn list(&self, part: &Self::Part, order: &mut Vec<u32>) {
        order.extend(part.iter().map(|item| item.id));
    }
}

/// Where the middles of some primitives lie.
pub(super) struct Extent {
    pub around: Aabb,
    pub axes: Axes,
}

impl Extent {
    pub fn of(items: &[Item], axes: Axes) -> Self {
        #[cfg(feature = "parallel")]
        if items.len() > 16 * SEQUENTIAL {
            let around = items
                .par_chunks(SEQUENTIAL)
                .map(|items| Aabb::of(items.iter().map(Item::centroid)))
                .reduce(|| Aabb::EMPTY, Aabb::union);
            return Self { around, axes };
        }
        Self {
            around: Aabb::of(items.iter().map(Item::centroid)),
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
