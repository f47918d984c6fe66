//! The tree above groups of primitives that lie along the curve.
//!
//! *How it works.* A run of `m` groups becomes `2 m - 1` nodes, so everything has its place before it is made, and large
//! runs are cut side by side.

use super::{BinaryTree, Item, levels};
use crate::accel::bvh::tree::{BinaryNode, MAX_DEPTH};
use crate::accel::limits::Site;
use crate::geometry::Aabb;
use crate::geometry::morton::Coded;
#[cfg(feature = "parallel")]
use crate::threads;
use alloc::vec;
use core::ops::Range;

/// Runs of fewer groups are cut by one thread.
const FEW: usize = 1024;

/// The tree of primitives in groups, each of which begins where it is said and ends where the next one begins.
pub(super) fn tree(codes: &[Coded], items: &[Item], starts: &[u32], site: &Site<'_>) -> BinaryTree {
    let groups = starts.len() - 1;
    let mut nodes = vec![BLANK; 2 * groups - 1];
    let mut order = vec![0; items.len()];
    let cuts = Cuts {
        codes,
        items,
        starts,
        site,
    };
    if let [root, below @ ..] = &mut nodes[..] {
        cuts.grow(
            0..groups,
            0,
            root,
            Below {
                nodes: below,
                first: 1,
                order: &mut order,
            },
        );
    }
    BinaryTree { nodes, order }
}

const BLANK: BinaryNode = BinaryNode {
    bounds: Aabb::EMPTY,
    first: 0,
    count: 0,
};

struct Cuts<'a> {
    codes: &'a [Coded],
    items: &'a [Item],
    starts: &'a [u32],
    site: &'a Site<'a>,
}

/// Where the nodes below some node go, and the primitives.
struct Below<'a> {
    nodes: &'a mut [BinaryNode],
    /// The number of the first one.
    first: usize,
    order: &'a mut [u32],
}

impl Cuts<'_> {
    /// Cuts a run of groups; its root lies at some depth.
    fn grow(&self, run: Range<usize>, depth: usize, root: &mut BinaryNode, below: Below<'_>) {
        if run.len() > FEW && self.site.is_over() {
            return;
        }
        if run.len() < 2 {
            self.put(run.start, root, below.order);
            return;
        }
        let middle = self.middle(&run, depth);
        let halves = [run.start..middle, middle..run.end];
        let (pair, rest) = below.nodes.split_at_mut(2);
        let of_left = 2 * (halves[0].len() - 1);
        let nodes = rest.split_at_mut(of_left);
        let place = self.starts[middle] - self.starts[run.start];
        let order = below.order.split_at_mut(place as usize);
        let first = below.first + 2;
        let left = Below {
            nodes: nodes.0,
            first,
            order: order.0,
        };
        let right = Below {
            nodes: nodes.1,
            first: first + of_left,
            order: order.1,
        };
        let [of_left, of_right] = halves;
        // One advance for each part that one thread does, whose parent was shared.
        if run.len() > FEW {
            let small = [(&of_left, left.order.len()), (&of_right, right.order.len())];
            let small = small.into_iter().filter(|(run, _)| run.len() <= FEW);
            let places: usize = small.map(|(_, places)| places).sum();
            self.site.advance(places * levels(self.items.len()));
        }
        if let [a, b] = pair {
            let grow_left = || self.grow(of_left, depth + 1, a, left);
            let grow_right = || self.grow(of_right, depth + 1, b, right);
            #[cfg(feature = "parallel")]
            if run.len() > FEW {
                threads::join(grow_left, grow_right);
            } else {
                grow_left();
                grow_right();
            }
            #[cfg(not(feature = "parallel"))]
            {
                grow_left();
                grow_right();
            }
            *root = BinaryNode {
                bounds: a.bounds.union(b.bounds),
                first: below.first as u32,
                count: 0,
            };
        }
    }

    /// Where a run of two groups and more is cut.
    fn middle(&self, run: &Range<usize>, depth: usize) -> usize {
        let code = |group: usize| self.codes[self.starts[group] as usize].code;
        let differing = code(run.start) ^ code(run.end - 1);
        if differing == 0 || depth + levels(run.len()) >= MAX_DEPTH {
            return run.start + run.len() / 2;
        }
        let bit = 1 << differing.ilog2();
        let (mut low, mut high) = (run.start, run.end - 1);
        // The first one has a zero there, the last one has not.
        while high - low > 1 {
            let between = low.midpoint(high);
            if code(between) & bit == 0 {
                low = between;
            } else {
                high = between;
            }
        }
        high
    }

    /// Makes a leaf of a group. Of equal hits the first is right, so that numbers ascend.
    fn put(&self, group: usize, leaf: &mut BinaryNode, order: &mut [u32]) {
        let places = self.starts[group] as usize..self.starts[group + 1] as usize;
        let items = &self.items[places.clone()];
        for (id, item) in order.iter_mut().zip(items) {
            *id = item.id();
        }
        order.sort_unstable();
        *leaf = BinaryNode {
            bounds: Item::around(items),
            first: places.start as u32,
            count: places.len() as u32,
        };
    }
}
