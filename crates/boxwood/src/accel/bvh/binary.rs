//! The readable layout: the builder's own nodes, one ray, one loop.

use super::tree::{BinaryTree, MAX_DEPTH};
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{self, Statistics, TreeFlaw};
use crate::primitive::{self, Primitives};
use crate::query::{Counters, Query, Traverse};

/// A binary hierarchy over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct Bvh<P> {
    primitives: P,
    tree: BinaryTree,
}

impl<P: Primitives> Bvh<P> {
    /// Takes a tree that a builder of this crate made for these primitives.
    ///
    /// # Panics
    /// When the tree names a primitive that does not exist. See [`Bvh::checked`] for trees from elsewhere.
    pub fn new(primitives: P, tree: BinaryTree) -> Self {
        assert!(
            tree.order
                .iter()
                .all(|&id| (id as usize) < primitives.len()),
            "a tree for other primitives"
        );
        Self { primitives, tree }
    }

    /// Takes a tree from anywhere, and looks at all of it first.
    ///
    /// # Errors
    /// The first flaw that [`inspect::validate`] finds.
    pub fn checked(primitives: P, tree: BinaryTree) -> Result<Self, TreeFlaw> {
        inspect::validate(&tree, &primitives)?;
        Ok(Self { primitives, tree })
    }

    /// The tree.
    pub fn tree(&self) -> &BinaryTree {
        &self.tree
    }
    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
}

impl<P: Primitives> Traverse for Bvh<P> {
    fn bounds(&self) -> Aabb {
        let root = self.tree.nodes.first();
        root.map_or(Aabb::EMPTY, |root| root.bounds)
    }

    fn statistics(&self) -> Statistics {
        Statistics::of_tree(&self.tree)
    }

    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let Some(ray) = PreparedRay::new(ray, Traverse::bounds(self).scale()) else {
            return;
        };
        let nodes = &self.tree.nodes[..];
        // Where primitives are cut, a leaf's box holds a part of each, but such a ray may hit it anywhere in its own box.
        if self.tree.order.len() > self.primitives.len() && !ray.is_tame() {
            primitive::offer_all(&self.primitives, &ray, query, counters);
            return;
        }
        let mut stack = [(0_u32, 0.0_f32); MAX_DEPTH];
        let mut pending = 0;
        let mut current = 0;
        if nodes.is_empty() || ray.enters(&nodes[0].bounds, query.t_max()).is_none() {
            return;
        }
        loop {
            let node = &nodes[current];
            let mut next = None;
            if node.is_leaf() {
                counters.leaf();
                for &id in &self.tree.order[node.places()] {
                    if primitive::offer(&self.primitives, id as usize, &ray, query, counters)
                        .is_break()
                    {
                        return;
                    }
                }
            } else {
                counters.node();
                let [a, b] = node.children();
                let t_max = query.t_max();
                let to_a = ray.enters(&nodes[a].bounds, t_max);
                let to_b = ray.enters(&nodes[b].bounds, t_max);
                next = match (to_a, to_b) {
                    (None, None) => None,
                    (Some(_), None) => Some(a),
                    (None, Some(_)) => Some(b),
                    (Some(to_a), Some(to_b)) => {
                        let a_first = !Q::ORDERED || to_a <= to_b;
                        let (near, far) = if a_first {
                            (a, (b as u32, to_b))
                        } else {
                            (b, (a as u32, to_a))
                        };
                        stack[pending] = far;
                        pending += 1;
                        Some(near)
                    }
                };
            }
            // A box that is entered exactly at `t_max` may hold an equal hit of a lower primitive: only beyond is passed.
            while next.is_none() {
                if pending == 0 {
                    return;
                }
                pending -= 1;
                let (index, entry) = stack[pending];
                if entry <= query.t_max() {
                    next = Some(index as usize);
                }
            }
            current = next.unwrap_or(0);
        }
    }
}
