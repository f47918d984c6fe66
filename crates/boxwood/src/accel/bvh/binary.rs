//! The readable layout: one ray, one loop, two boxes at a time.
//!
//! *How it works.* An inner node holds the boxes of both its children, plane beside plane, in one cache line: opening it
//! asks both slab tests at once, four planes an operation. The near child comes next and the far one waits on a stack with
//! the distance at which the ray enters it.
//!
//! *Cost.* 64 bytes per inner node and 4 per primitive.
//!
//! *Source.* Aila & Laine 2009, *Understanding the Efficiency of Ray Traversal on GPUs* (children's boxes in the parent).

use super::tree::{BinaryTree, MAX_DEPTH};
use crate::geometry::pair::{BoxPair, PairRay};
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{self, Cell, Statistics, TreeFlaw};
use crate::primitive::{self, Primitives, Triangles};
use crate::proximity::{Hierarchy, Numbered, Opened, slack_of_cut};
use crate::query::{Counters, Query, Step, Traverse, Verdict};
use crate::simd::exactly;
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// A binary hierarchy over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct Bvh<P> {
    primitives: P,
    bounds: Aabb,
    root: Child,
    /// Inner nodes: both children's boxes, and what they hold.
    pairs: Vec<BoxPair>,
    order: Vec<u32>,
}

/// What a node's box holds: the pair `first` when `count` is 0, else so many places of the order from `first` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Child {
    first: u32,
    count: u32,
}

impl Child {
    fn words(self) -> [u32; 2] {
        [self.first, self.count]
    }
    /// The child on one side of an inner node.
    #[inline(always)]
    fn of(pair: &BoxPair, side: usize) -> Self {
        let [first, count] = pair.words(side);
        Self { first, count }
    }
}

impl<P: Primitives> Bvh<P> {
    /// Takes a tree that a builder of this crate made for these primitives.
    ///
    /// # Panics
    /// When the tree is for fewer or more primitives. See [`Bvh::checked`] for trees from elsewhere.
    pub fn new(primitives: P, tree: BinaryTree) -> Self {
        // Builders that split primitives name some of them more than once.
        let most = tree.order.iter().max().map_or(0, |&id| id as usize + 1);
        let fits = most == primitives.len() && tree.nodes.is_empty() == tree.order.is_empty();
        assert!(fits, "a tree for other primitives");
        let BinaryTree { nodes, order } = tree;
        // Every second node begins a pair of children: pair `i` holds the nodes `2 i + 1` and `2 i + 2`.
        let child = |index: usize| {
            let node = &nodes[index];
            let first = if node.is_leaf() {
                node.first
            } else {
                (node.first - 1) / 2
            };
            Child {
                first,
                count: node.count,
            }
        };
        let pair = |i: usize| {
            let [a, b] = [2 * i + 1, 2 * i + 2];
            BoxPair::new(
                [nodes[a].bounds, nodes[b].bounds],
                [child(a).words(), child(b).words()],
            )
        };
        let pairs = 0..nodes.len() / 2;
        #[cfg(feature = "parallel")]
        let pairs = pairs.into_par_iter().with_min_len(1024).exactly();
        let pairs = exactly(|| pairs.map(pair).collect());
        Self {
            primitives,
            bounds: nodes.first().map_or(Aabb::EMPTY, |root| root.bounds),
            root: if nodes.is_empty() {
                Child { first: 0, count: 0 }
            } else {
                child(0)
            },
            pairs,
            order,
        }
    }

    /// Takes a tree from anywhere, and looks at all of it first.
    ///
    /// # Errors
    /// The first flaw that [`inspect::validate`] finds.
    pub fn checked(primitives: P, tree: BinaryTree) -> Result<Self, TreeFlaw> {
        inspect::validate(&tree, &primitives)?;
        Ok(Self::new(primitives, tree))
    }

    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
}

impl<P: Primitives> Traverse for Bvh<P> {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn statistics(&self) -> Statistics {
        Statistics {
            bytes: size_of_val(&*self.pairs) + size_of_val(&*self.order),
            ..Statistics::of_cells(self.primitives.len(), self.bounds, |show| self.cells(show))
        }
    }

    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        if self.order.is_empty() {
            return;
        }
        let mut open = alloc::vec![(0, 0, self.bounds, self.root)];
        while let Some((node, depth, bounds, child)) = open.pop() {
            let leaf = child.count > 0;
            show(&Cell {
                node,
                depth,
                bounds,
                primitives: leaf.then_some(child.count),
                sides: &[],
            });
            if !leaf {
                let pair = &self.pairs[child.first as usize];
                for side in [1, 0] {
                    let node = 2 * child.first + side as u32 + 1;
                    open.push((node, depth + 1, pair.bounds(side), Child::of(pair, side)));
                }
            }
        }
    }

    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let Some(ray) = PreparedRay::new(ray, self.bounds.scale()) else {
            return;
        };
        // Where primitives are cut, a leaf's box holds a part of each, but such a ray may hit it anywhere in its own box.
        if self.order.len() > self.primitives.len() && !ray.is_tame() {
            primitive::offer_all(&self.primitives, &ray, query, counters);
            return;
        }
        if self.order.is_empty() {
            return;
        }
        let entered = ray.enters(&self.bounds, query.t_max()).is_some();
        if C::EXPLAINS {
            explain_root(&ray, &self.bounds, query.t_max(), counters);
        }
        if !entered {
            return;
        }
        let slabs = PairRay::new(&ray);
        // Numbers of nodes as in `cells`, less one: twice the pair, plus the side.
        let mut stack = [(0_u32, 0.0_f32); MAX_DEPTH];
        let mut pending = 0;
        let mut current = self.root;
        // The number of `current`, kept for those who explain.
        let mut number = 0;
        loop {
            if current.count == 0 {
                counters.node();
                let index = current.first;
                let pair = &self.pairs[index as usize];
                let ([to_a, to_b], [from_a, from_b]) = slabs.slabs(&ray, pair, query.t_max());
                let (meets_a, meets_b) = (to_a <= from_a, to_b <= from_b);
                let b_first = meets_b && (!meets_a || (Q::ORDERED && to_b < to_a));
                if C::EXPLAINS {
                    explain_pair(&ray, index, pair, b_first, query.t_max(), counters);
                }
                if meets_a || meets_b {
                    if meets_a && meets_b {
                        let far = if b_first { to_a } else { to_b };
                        stack[pending] = (2 * index + u32::from(!b_first), far);
                        pending += 1;
                    }
                    current = Child::of(pair, usize::from(b_first));
                    if C::EXPLAINS {
                        number = 2 * index + u32::from(b_first) + 1;
                    }
                    continue;
                }
            } else {
                counters.leaf();
                let first = current.first as usize;
                let places = first..first + current.count as usize;
                if C::EXPLAINS {
                    counters.step(Step::Leaf {
                        node: number,
                        primitives: current.count,
                    });
                }
                for &id in &self.order[places] {
                    if primitive::offer(&self.primitives, id as usize, &ray, query, counters)
                        .is_break()
                    {
                        return;
                    }
                }
            }
            // A box that is entered exactly at `t_max` may hold an equal hit of a lower primitive: only beyond is passed.
            loop {
                if pending == 0 {
                    return;
                }
                pending -= 1;
                let (node, enter) = stack[pending];
                let dropped = !(enter <= query.t_max());
                if C::EXPLAINS {
                    counters.step(Step::Resumed {
                        node: node + 1,
                        enter,
                        dropped,
                    });
                }
                if !dropped {
                    if C::EXPLAINS {
                        number = node + 1;
                    }
                    let pair = &self.pairs[node as usize / 2];
                    current = Child::of(pair, node as usize % 2);
                    break;
                }
            }
        }
    }
}

/// Nodes are numbered as in `cells`: 0 is the root, and the children of pair `i` are `2 i + 1` and `2 i + 2`.
impl<P: Triangles> Hierarchy for Bvh<P> {
    type Primitives = P;
    type Node = u32;
    fn primitives(&self) -> &P {
        &self.primitives
    }
    fn root(&self) -> Option<u32> {
        (!self.order.is_empty()).then_some(0)
    }
    #[inline(always)]
    fn open(
        &self,
        node: u32,
    ) -> Opened<impl Iterator<Item = (Aabb, u32)>, impl Iterator<Item = Numbered>> {
        let place = match node.checked_sub(1) {
            None => self.root,
            Some(below) => Child::of(&self.pairs[below as usize / 2], below as usize % 2),
        };
        if place.count > 0 {
            let first = place.first as usize;
            let places = first..first + place.count as usize;
            let triangle = |&id: &u32| (id, self.primitives.triangle(id as usize));
            return Opened::Leaf(self.order[places].iter().map(triangle));
        }
        let pair = &self.pairs[place.first as usize];
        let child = move |side| (pair.bounds(side), 2 * place.first + side as u32 + 1);
        Opened::Inner([0, 1].into_iter().map(child))
    }
    #[inline(always)]
    fn number(&self, node: u32) -> usize {
        node as usize
    }
    fn slack(&self) -> f64 {
        if self.order.len() > self.primitives.len() {
            slack_of_cut(self.bounds.scale())
        } else {
            0.0
        }
    }
}

#[cold]
fn explain_root<C: Counters>(ray: &PreparedRay, bounds: &Aabb, t_max: f32, counters: &mut C) {
    let slabs = ray.slabs(bounds);
    counters.step(Step::of_box(
        0,
        *bounds,
        slabs,
        ray.t_min,
        t_max,
        Verdict::Opened,
    ));
}

#[cold]
fn explain_pair<C: Counters>(
    ray: &PreparedRay,
    index: u32,
    pair: &BoxPair,
    b_first: bool,
    t_max: f32,
    counters: &mut C,
) {
    for side in [usize::from(b_first), usize::from(!b_first)] {
        let bounds = pair.bounds(side);
        let slabs = ray.slabs(&bounds);
        let otherwise = if side == usize::from(b_first) {
            Verdict::Opened
        } else {
            Verdict::Deferred
        };
        let node = 2 * index + side as u32 + 1;
        counters.step(Step::of_box(
            node, bounds, slabs, ray.t_min, t_max, otherwise,
        ));
    }
}
