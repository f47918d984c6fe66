//! Which nodes of a binary tree become the children of one wide node, and which subtrees one leaf.
//!
//! *How it works.* For each subtree and each number of places up to `N`, the cheapest way to hang it into so many places of
//! a parent is found from the ways of its two halves: as one node of its own, as one leaf, or with its halves side by
//! side. The choices are kept, and read from the root down.
//!
//! *Cost.* O(n N²) time; `N + 4` bytes for each inner node of the binary tree and 4 for each leaf.
//!
//! *Source.* Ylitie, Karras & Laine 2017, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, section
//! 4.1 (after Wald, Benthin & Boulos 2008).

use super::gathering::Gathering;
use super::leaf::Leaves;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::Site;
use crate::accel::sah::half_area;
use crate::primitive::Primitives;
use alloc::vec;
use alloc::vec::Vec;

/// What opening a wide node costs, in units of one block of primitives.
const NODE_COST: f32 = 1.5;

/// What becomes of each node of a binary tree.
pub struct Plan<'a, const N: usize> {
    tree: &'a BinaryTree,
    gathering: Gathering,
    /// Most primitives in a leaf that is made of a subtree.
    max_leaf: usize,
    /// For each inner node and each number of places `j`, how many of them its first half gets (at `j − 1`): 0 where it takes
    /// one place less. For one place: how many the first half gets in a node of its own, 0 where it becomes a leaf.
    choices: Vec<[u8; N]>,
    /// For each node, how much surface there is below for each unit of expected cost.
    promises: Vec<f32>,
}

/// What is known of a subtree.
struct Below<const N: usize> {
    /// The expected cost by number of places.
    costs: [f32; N],
    primitives: usize,
    /// Of all primitives below.
    surface: f32,
}

impl<const N: usize> Below<N> {
    const NOTHING: Self = Self {
        costs: [0.0; N],
        primitives: 0,
        surface: 0.0,
    };
}

impl<'a, const N: usize> Plan<'a, N> {
    /// Makes the plan; empty where the site says that the build is over.
    pub fn new<P: Primitives>(
        primitives: &P,
        tree: &'a BinaryTree,
        max_leaf: usize,
        gathering: Gathering,
        site: &Site<'_>,
    ) -> Self {
        let mut plan = Self {
            tree,
            gathering,
            max_leaf,
            choices: Vec::new(),
            promises: Vec::new(),
        };
        let (nodes, inner) = (tree.nodes.len(), tree.nodes.len() / 2);
        if nodes > 0 && site.take(inner * size_of::<[u8; N]>() + nodes * size_of::<f32>()) {
            plan.choices = vec![[0; N]; inner];
            plan.promises = vec![0.0; nodes];
            plan.weigh(primitives, 0, site);
        }
        plan
    }

    /// Bytes taken.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.choices) + size_of_val(&*self.promises)
    }

    fn weigh<P: Primitives>(&mut self, primitives: &P, index: usize, site: &Site<'_>) -> Below<N> {
        let node = self.tree.nodes[index];
        let area = half_area(&node.bounds) as f32;
        let leaf = |count: usize| area * count.div_ceil(Leaves::LANES) as f32;
        let below = if node.is_leaf() {
            let ids = &self.tree.order[node.places()];
            Below {
                costs: [leaf(ids.len()); N],
                primitives: ids.len(),
                surface: ids.iter().map(|&id| surface(primitives, id as usize)).sum(),
            }
        } else {
            if !site.advance(1) {
                return Below::NOTHING;
            }
            let [a, b] = node
                .children()
                .map(|child| self.weigh(primitives, child, site));
            let count = a.primitives + b.primitives;
            if self.gathering == Gathering::Greedy {
                return self.weigh_greedily(index, area, [a, b]);
            }
            let mut costs = [f32::INFINITY; N];
            let mut choice = [0; N];
            for j in 2..=N {
                for k in 1..j {
                    let cost = a.costs[k - 1] + b.costs[j - k - 1];
                    if cost < costs[j - 1] {
                        (costs[j - 1], choice[j - 1]) = (cost, k as u8);
                    }
                }
            }
            let (own, together) = (area * NODE_COST + costs[N - 1], leaf(count));
            // Written so that boxes without area, or with an infinite one, stay together.
            (costs[0], choice[0]) = if count <= self.max_leaf && !(own < together) {
                (together, 0)
            } else {
                // Costs may be infinite or NaN: then any way does.
                (own, choice[N - 1].max(1))
            };
            for j in 1..N {
                if !(costs[j] < costs[j - 1]) {
                    (costs[j], choice[j]) = (costs[j - 1], 0);
                }
            }
            let place = self.inner(index);
            self.choices[place] = choice;
            Below {
                costs,
                primitives: count,
                surface: a.surface + b.surface,
            }
        };
        self.promises[index] = below.surface / below.costs[0];
        below
    }

    /// Of a subtree with two halves where nothing is chosen: what fits into a block becomes a leaf.
    fn weigh_greedily(&mut self, index: usize, area: f32, [a, b]: [Below<N>; 2]) -> Below<N> {
        let primitives = a.primitives + b.primitives;
        let fits = primitives <= Leaves::LANES;
        let place = self.inner(index);
        self.choices[place][0] = u8::from(!fits);
        let cost = if fits {
            area
        } else {
            // Of a node's places each has a share.
            area * NODE_COST / (N - 1) as f32 + a.costs[0] + b.costs[0]
        };
        let surface = a.surface + b.surface;
        self.promises[index] = surface / cost;
        Below {
            costs: [cost; N],
            primitives,
            surface,
        }
    }

    /// The number of an inner node among its like: pairs of children lie side by side from node 1 on.
    fn inner(&self, index: usize) -> usize {
        (self.tree.nodes[index].first as usize - 1) / 2
    }

    /// Whether a subtree that takes one place is a leaf.
    pub fn is_leaf(&self, index: usize) -> bool {
        self.tree.nodes[index].is_leaf() || self.choices[self.inner(index)][0] == 0
    }

    /// The children of the wide node made of a subtree; the last one is the one where a ray finds some hit soonest.
    ///
    /// That one has the most surface for its cost: a ray that asks for any hit takes it first.
    pub fn children(&self, index: usize, found: &mut Vec<usize>) {
        found.clear();
        let [a, b] = self.tree.nodes[index].children();
        match self.gathering {
            Gathering::Optimal => {
                let for_first = usize::from(self.choices[self.inner(index)][0]);
                self.places(a, for_first, found);
                self.places(b, N - for_first, found);
            }
            Gathering::Greedy => {
                found.extend([a, b]);
                while found.len() < N
                    && let Some(place) = self.largest(found)
                {
                    let [a, b] = self.tree.nodes[found[place]].children();
                    found[place] = a;
                    found.push(b);
                }
            }
        }
        found.sort_by(|&a, &b| self.promises[a].total_cmp(&self.promises[b]));
    }

    /// Which of some nodes that can be opened has the most surface.
    fn largest(&self, nodes: &[usize]) -> Option<usize> {
        let area = |place: usize| half_area(&self.tree.nodes[nodes[place]].bounds);
        (0..nodes.len())
            .filter(|&place| !self.is_leaf(nodes[place]))
            .max_by(|&a, &b| area(a).total_cmp(&area(b)))
    }

    /// The nodes that take so many places for a subtree.
    fn places(&self, index: usize, mut count: usize, found: &mut Vec<usize>) {
        while count > 1 && !self.tree.nodes[index].is_leaf() {
            let for_first = usize::from(self.choices[self.inner(index)][count - 1]);
            if for_first > 0 {
                let [a, b] = self.tree.nodes[index].children();
                self.places(a, for_first, found);
                self.places(b, count - for_first, found);
                return;
            }
            count -= 1;
        }
        found.push(index);
    }

    /// How many places of the order a subtree has.
    pub fn count(&self, index: usize) -> usize {
        let node = &self.tree.nodes[index];
        if node.is_leaf() {
            return node.count as usize;
        }
        node.children().map(|child| self.count(child)).iter().sum()
    }

    /// The primitives of a subtree, ascending and each once, so that of equal hits the first is right; spatial splits may
    /// have brought parts together again.
    pub fn primitives(&self, index: usize, ids: &mut Vec<u32>) {
        ids.clear();
        let mut open = vec![index];
        while let Some(index) = open.pop() {
            let node = &self.tree.nodes[index];
            if node.is_leaf() {
                ids.extend_from_slice(&self.tree.order[node.places()]);
            } else {
                open.extend(node.children());
            }
        }
        ids.sort_unstable();
        ids.dedup();
    }
}

/// The surface of a primitive; of one that is not a triangle, roughly.
fn surface(primitives: &impl Primitives, id: usize) -> f32 {
    match primitives.corners(id) {
        Some([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
        None => 0.5 * primitives.bounds(id).half_area(),
    }
}
