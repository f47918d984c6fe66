//! The nodes as questions about space see them.

use super::WideBvh;
use super::layout::Layout;
use super::node::Child;
use crate::geometry::Aabb;
use crate::primitive::Triangles;
use crate::proximity::{Hierarchy, Numbered, Opened, slack_of_cut};

/// A node by its number (0 is the root, and the children of node `i` are `i N + 1` and so on) and what it holds.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    number: u32,
    child: Child,
}

impl<P: Triangles, const N: usize, L: Layout> Hierarchy for WideBvh<P, N, L> {
    type Primitives = P;
    type Node = Place;
    fn primitives(&self) -> &P {
        &self.primitives
    }
    fn root(&self) -> Option<Place> {
        let child = self.root;
        (child != Child::NOTHING).then_some(Place { number: 0, child })
    }
    #[inline(always)]
    fn open(
        &self,
        node: Place,
    ) -> Opened<impl Iterator<Item = (Aabb, Place)>, impl Iterator<Item = Numbered>> {
        let parent = node.child;
        if parent.is_leaf() {
            return Opened::Leaf(self.leaves.numbered(&self.primitives, parent.blocks()));
        }
        let slots = self.nodes[parent.index()].slots();
        Opened::Inner(slots.map(move |(lane, bounds, child)| {
            let number = parent.number::<N>(lane);
            (self.in_world(&bounds), Place { number, child })
        }))
    }
    #[inline(always)]
    fn number(&self, node: Place) -> usize {
        node.number as usize
    }
    fn slack(&self) -> f64 {
        if self.cut {
            slack_of_cut(self.frame.scale)
        } else {
            0.0
        }
    }
}
