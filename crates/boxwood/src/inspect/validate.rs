//! Whether a tree is whole: the first flaw, as a value.

use crate::accel::bvh::{BinaryTree, MAX_DEPTH};
use crate::primitive::Primitives;

/// What is wrong with a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TreeFlaw {
    /// Primitives without a node, or nodes without primitives.
    #[error("{primitives} primitives, but {ordered} places in the order and {nodes} nodes")]
    Count {
        /// How many primitives there are.
        primitives: usize,
        /// How many places the order has.
        ordered: usize,
        /// How many nodes there are.
        nodes: usize,
    },
    /// A node that is named by no parent, or by more than one.
    #[error("node {node} has {parents} parents, expected 1")]
    Parents {
        /// The node.
        node: usize,
        /// How many nodes name it.
        parents: usize,
    },
    /// A node whose child is the root.
    #[error("node {node} has the root as a child")]
    Root {
        /// The node.
        node: usize,
    },
    /// A child or a place that does not exist.
    #[error("node {node} names what does not exist")]
    Dangling {
        /// The node.
        node: usize,
    },
    /// A leaf deeper than traversal stacks allow.
    #[error("node {node} lies deeper than {MAX_DEPTH}")]
    TooDeep {
        /// The node.
        node: usize,
    },
    /// Something sticks out of a node's box.
    #[error("something below node {node} sticks out of its box")]
    SticksOut {
        /// The node.
        node: usize,
    },
    /// A primitive that is in no leaf, or in more than one.
    #[error("primitive {primitive} is in {times} leaves, expected 1")]
    Times {
        /// The primitive.
        primitive: usize,
        /// How often it was found.
        times: usize,
    },
}

/// Looks at all of a tree: every node has one parent, every box holds what is below it, every primitive is in one leaf,
/// and no leaf is too deep. Linear time, 4 bytes per node and primitive.
///
/// # Errors
/// The first flaw found.
pub fn validate(tree: &BinaryTree, primitives: &impl Primitives) -> Result<(), TreeFlaw> {
    let (nodes, order) = (&tree.nodes, &tree.order);
    if order.len() != primitives.len() || nodes.is_empty() != order.is_empty() {
        return Err(TreeFlaw::Count {
            primitives: primitives.len(),
            ordered: order.len(),
            nodes: nodes.len(),
        });
    }
    let mut parents = alloc::vec![0_u32; nodes.len()];
    let mut times = alloc::vec![0_u32; order.len()];
    let mut open = alloc::vec![(0, 0)];
    while let Some((index, depth)) = open.pop() {
        let Some(node) = nodes.get(index) else {
            continue;
        };
        if depth > MAX_DEPTH {
            return Err(TreeFlaw::TooDeep { node: index });
        }
        if node.is_leaf() {
            let places = order
                .get(node.places())
                .ok_or(TreeFlaw::Dangling { node: index })?;
            for &id in places {
                let found = times
                    .get_mut(id as usize)
                    .ok_or(TreeFlaw::Dangling { node: index })?;
                *found += 1;
                // Before the next leaf is read: leaves that share places would make the work quadratic.
                if *found > 1 {
                    return Err(TreeFlaw::Times {
                        primitive: id as usize,
                        times: *found as usize,
                    });
                }
                if !node.bounds.contains(&primitives.bounds(id as usize)) {
                    return Err(TreeFlaw::SticksOut { node: index });
                }
            }
            continue;
        }
        for child in node.children() {
            let below = nodes.get(child).ok_or(TreeFlaw::Dangling { node: index })?;
            if child == 0 {
                return Err(TreeFlaw::Root { node: index });
            }
            parents[child] += 1;
            if parents[child] > 1 {
                return Err(TreeFlaw::Parents {
                    node: child,
                    parents: parents[child] as usize,
                });
            }
            if !node.bounds.contains(&below.bounds) {
                return Err(TreeFlaw::SticksOut { node: index });
            }
            open.push((child, depth + 1));
        }
    }
    if let Some(node) = (1..nodes.len()).find(|&node| parents[node] != 1) {
        return Err(TreeFlaw::Parents { node, parents: 0 });
    }
    match times.iter().position(|&found| found != 1) {
        Some(primitive) => Err(TreeFlaw::Times {
            primitive,
            times: times[primitive] as usize,
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aabb, Median, TriangleMesh};

    fn strip() -> TriangleMesh {
        let positions = (0..20).map(|i| [i as f32, (i % 2) as f32, 0.0]);
        TriangleMesh::new(positions, (0..18_u32).map(|i| [i, i + 1, i + 2])).expect("a good mesh")
    }

    /// Every kind of damage is found.
    #[test]
    fn flaws_are_found() {
        let mesh = strip();
        let good = Median::default().build(&mesh);
        assert_eq!(validate(&good, &mesh), Ok(()));
        let leaf = good
            .nodes
            .iter()
            .position(|n| n.is_leaf())
            .expect("has leaves");
        let damage = |harm: &dyn Fn(&mut BinaryTree)| {
            let mut tree = good.clone();
            harm(&mut tree);
            validate(&tree, &mesh).expect_err("damaged")
        };
        assert!(matches!(
            damage(&|t| t.order.truncate(3)),
            TreeFlaw::Count { ordered: 3, .. }
        ));
        assert!(matches!(
            damage(&|t| t.order[0] = t.order[1]),
            TreeFlaw::Times { .. }
        ));
        assert!(matches!(
            damage(&|t| t.order[0] = 99),
            TreeFlaw::Dangling { .. }
        ));
        assert!(matches!(
            damage(&|t| t.nodes[0].first = 99),
            TreeFlaw::Dangling { node: 0 }
        ));
        assert!(matches!(
            damage(&|t| t.nodes[0].first = 0),
            TreeFlaw::Root { node: 0 }
        ));
        assert!(matches!(
            damage(&|t| t.nodes[leaf].count += 1),
            TreeFlaw::Times { .. } | TreeFlaw::Dangling { .. } | TreeFlaw::SticksOut { .. }
        ));
        assert_eq!(
            damage(&|t| t.nodes[leaf].bounds = Aabb::EMPTY),
            TreeFlaw::SticksOut { node: leaf }
        );
    }
}
