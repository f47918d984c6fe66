//! Whether a tree is whole: the first flaw, as a value.

use crate::accel::bvh::{BinaryTree, MAX_DEPTH};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use crate::simd::exactly;

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
    /// A primitive that is in no leaf, in more than one although none was cut, or twice in one.
    #[error("primitive {primitive} was found {times} times, expected once in each of its leaves")]
    Times {
        /// The primitive.
        primitive: usize,
        /// How often it was found.
        times: usize,
    },
    /// A place in the order that no leaf names, or more than one.
    #[error("place {place} of the order is in {leaves} leaves, expected 1")]
    Place {
        /// The place.
        place: usize,
        /// How many leaves name it.
        leaves: usize,
    },
    /// A primitive whose leaves are not around all of it.
    #[error("primitive {primitive} sticks out of its leaves")]
    Uncovered {
        /// The primitive.
        primitive: usize,
    },
    /// A wide node that does not say of each octant which child comes when, or has a box without a child.
    #[error("node {node} is no node")]
    Node {
        /// The node.
        node: usize,
    },
    /// A block of a wide tree's leaves that does not hold what its places say, or has gaps.
    #[error("block {block} of the leaves does not hold its primitives")]
    Block {
        /// The block.
        block: usize,
    },
    /// A wide tree whose own numbers are not those of its nodes.
    #[error("the tree's {what} does not follow from its nodes")]
    Whole {
        /// `root`, `bounds`, `depth` or `cut`.
        what: &'static str,
    },
}

/// Looks at all of a tree: every node has one parent, every box holds what is below it, every primitive is in one leaf,
/// and no leaf is too deep. Linear time, 4 bytes per node, 36 per primitive, 1 per place.
///
/// Where the order is longer than there are primitives, some were cut and lie in several leaves: then the boxes of a
/// primitive's leaves must together reach as far as it does, and each of them must hold some of its box. That is
/// necessary, not sufficient: that no part between them is missing remains the builder's promise.
///
/// # Errors
/// The first flaw found.
pub fn validate(tree: &BinaryTree, primitives: &impl Primitives) -> Result<(), TreeFlaw> {
    exactly(|| examine(tree, primitives))
}

fn examine(tree: &BinaryTree, primitives: &impl Primitives) -> Result<(), TreeFlaw> {
    let (nodes, order) = (&tree.nodes, &tree.order);
    if order.len() < primitives.len() || nodes.is_empty() != order.is_empty() {
        return Err(TreeFlaw::Count {
            primitives: primitives.len(),
            ordered: order.len(),
            nodes: nodes.len(),
        });
    }
    let mut parents = alloc::vec![0_u32; nodes.len()];
    let cuts = order.len() > primitives.len();
    let mut taken = alloc::vec![false; order.len()];
    let mut found = alloc::vec![Found::default(); primitives.len()];
    let mut open = alloc::vec![(0, 0)];
    while let Some((index, depth)) = open.pop() {
        let Some(node) = nodes.get(index) else {
            continue;
        };
        if depth > MAX_DEPTH {
            return Err(TreeFlaw::TooDeep { node: index });
        }
        if node.is_leaf() {
            let ids = order
                .get(node.places())
                .ok_or(TreeFlaw::Dangling { node: index })?;
            for (place, &id) in node.places().zip(ids) {
                // Before the next leaf is read: leaves that share places would make the work quadratic.
                if core::mem::replace(&mut taken[place], true) {
                    return Err(TreeFlaw::Place { place, leaves: 2 });
                }
                let primitive = id as usize;
                let found = found
                    .get_mut(primitive)
                    .ok_or(TreeFlaw::Dangling { node: index })?;
                let bounds = primitives.bounds(primitive);
                let again = found.last_leaf == Some(index as u32);
                *found = Found {
                    times: found.times + 1,
                    last_leaf: Some(index as u32),
                    around: found.around.union(node.bounds),
                };
                if again || (!cuts && found.times > 1) {
                    let times = found.times as usize;
                    return Err(TreeFlaw::Times { primitive, times });
                }
                let holds = if cuts {
                    bounds.is_empty() || !node.bounds.intersection(bounds).is_empty()
                } else {
                    node.bounds.contains(&bounds)
                };
                if !holds {
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
    if let Some(place) = taken.iter().position(|taken| !taken) {
        return Err(TreeFlaw::Place { place, leaves: 0 });
    }
    for (primitive, found) in found.iter().enumerate() {
        if found.times == 0 {
            return Err(TreeFlaw::Times {
                primitive,
                times: 0,
            });
        }
        if !found.around.contains(&primitives.bounds(primitive)) {
            return Err(TreeFlaw::Uncovered { primitive });
        }
    }
    Ok(())
}

/// What was found of a primitive.
#[derive(Clone, Copy)]
struct Found {
    times: u32,
    last_leaf: Option<u32>,
    /// Around all of its leaves.
    around: Aabb,
}

impl Default for Found {
    fn default() -> Self {
        Self {
            times: 0,
            last_leaf: None,
            around: Aabb::EMPTY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Median, SpatialSplit, TriangleMesh};

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
            TreeFlaw::Place { .. } | TreeFlaw::Dangling { .. } | TreeFlaw::SticksOut { .. }
        ));
        assert_eq!(
            damage(&|t| t.nodes[leaf].bounds = Aabb::EMPTY),
            TreeFlaw::SticksOut { node: leaf }
        );
    }

    /// Trees that cut primitives are whole as long as nothing is lost.
    #[test]
    fn flaws_of_cut_primitives_are_found() {
        // Needles from corner to corner, side by side.
        let needle = |i: u8| {
            let x = f32::from(i) * 0.1;
            [[x, 0.0, 0.0], [x + 0.05, 0.0, 0.0], [x + 9.0, 9.0, 9.0]]
        };
        let positions = (0..4).flat_map(needle);
        let triangles = (0..4_u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let mesh = TriangleMesh::new(positions, triangles).expect("a good mesh");
        let builder = SpatialSplit {
            budget: 4.0,
            max_leaf: 1,
            ..SpatialSplit::default()
        };
        let good = builder.build(&mesh);
        assert_eq!(validate(&good, &mesh), Ok(()));
        assert!(good.order.len() > 4, "{good:?}");
        let leaf = |t: &BinaryTree, id: u32| {
            let holds = |n: &crate::accel::bvh::BinaryNode| {
                n.is_leaf() && t.order[n.places()].contains(&id)
            };
            t.nodes.iter().position(holds).expect("is in a leaf")
        };
        let mut tree = good.clone();
        let first = leaf(&tree, 0);
        tree.nodes[first].bounds.lower = good.nodes[first].bounds.upper;
        assert_eq!(
            validate(&tree, &mesh),
            Err(TreeFlaw::Uncovered { primitive: 0 })
        );
        let mut tree = good.clone();
        tree.nodes[first].bounds = Aabb::EMPTY;
        assert_eq!(
            validate(&tree, &mesh),
            Err(TreeFlaw::SticksOut { node: first })
        );
        let mut tree = good;
        tree.order.push(0);
        let place = tree.order.len() - 1;
        assert_eq!(
            validate(&tree, &mesh),
            Err(TreeFlaw::Place { place, leaves: 0 })
        );
    }
}
