//! The readable layout: the builder's own nodes, one ray, one loop.

use super::tree::{BinaryTree, MAX_DEPTH};
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{self, Cell, Statistics, TreeFlaw};
use crate::primitive::{self, Primitives};
use crate::query::{Counters, Query, Step, Traverse, Verdict};

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
    /// When the tree has another number of primitives. See [`Bvh::checked`] for trees from elsewhere.
    pub fn new(primitives: P, tree: BinaryTree) -> Self {
        assert_eq!(
            primitives.len(),
            tree.order.len(),
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

/// What happens to a node's box; `opened` is its lot where the ray enters it.
fn held(ray: &PreparedRay, node: usize, bounds: Aabb, t_max: f32, opened: Verdict) -> Step {
    let (enter, leave) = ray.slabs(&bounds);
    let verdict = if !(enter <= leave) {
        Verdict::Missed
    } else if leave < ray.t_min {
        Verdict::Behind
    } else if enter > t_max {
        Verdict::Beyond
    } else {
        opened
    };
    Step::Box {
        node: node as u32,
        bounds,
        enter,
        leave,
        verdict,
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

    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        let mut open = alloc::vec![(0, 0)];
        while let Some((index, depth)) = open.pop() {
            let Some(node) = self.tree.nodes.get(index) else {
                continue;
            };
            show(&Cell {
                node: index as u32,
                depth,
                bounds: node.bounds,
                primitives: node.is_leaf().then_some(node.count),
                sides: &[],
            });
            if !node.is_leaf() {
                let [a, b] = node.children();
                open.extend([(b, depth + 1), (a, depth + 1)]);
            }
        }
    }

    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let Some(ray) = PreparedRay::new(ray, Traverse::bounds(self).scale()) else {
            return;
        };
        let nodes = &self.tree.nodes[..];
        let mut stack = [(0_u32, 0.0_f32); MAX_DEPTH];
        let mut pending = 0;
        let mut current = 0;
        if C::EXPLAINS
            && let Some(root) = nodes.first()
        {
            counters.step(held(&ray, 0, root.bounds, query.t_max(), Verdict::Opened));
        }
        if nodes.is_empty() || ray.enters(&nodes[0].bounds, query.t_max()).is_none() {
            return;
        }
        loop {
            let node = &nodes[current];
            let mut next = None;
            if node.is_leaf() {
                counters.leaf();
                if C::EXPLAINS {
                    counters.step(Step::Leaf {
                        node: current as u32,
                        primitives: node.count,
                    });
                }
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
                if C::EXPLAINS {
                    let a_waits =
                        matches!((to_a, to_b), (Some(a), Some(b)) if Q::ORDERED && !(a <= b));
                    let b_waits = to_a.is_some() && !a_waits;
                    for (child, waits) in [(a, a_waits), (b, b_waits)] {
                        let opened = if waits {
                            Verdict::Deferred
                        } else {
                            Verdict::Opened
                        };
                        counters.step(held(&ray, child, nodes[child].bounds, t_max, opened));
                    }
                }
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
                if C::EXPLAINS {
                    counters.step(Step::Resumed {
                        node: index,
                        enter: entry,
                        dropped: !(entry <= query.t_max()),
                    });
                }
                if entry <= query.t_max() {
                    next = Some(index as usize);
                }
            }
            current = next.unwrap_or(0);
        }
    }
}
