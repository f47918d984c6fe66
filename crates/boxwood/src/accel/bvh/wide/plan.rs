//! Which nodes of a binary tree become the children of one wide node, and which subtrees one leaf.
//!
//! *How it works.* For each subtree and each number of places up to `N`, the cheapest way to hang it into so many places of
//! a parent is found from the ways of its two halves: as one node of its own, as one leaf, or with its halves side by
//! side. The choices are kept, and read from the root down.
//!
//! A subtree of few leaves needs few places, and most are such. Subtrees are weighed side by side.
//!
//! *Cost.* O(n N) time; `N + 12` bytes for each inner node of the binary tree.
//!
//! *Source.* Ylitie, Karras & Laine 2017, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, section
//! 4.1 (after Wald, Benthin & Boulos 2008).

use super::gathering::Gathering;
use super::leaf::Leaves;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::Site;
use crate::accel::sah::half_area;
use crate::primitive::Primitives;
#[cfg(feature = "parallel")]
use crate::threads;
use alloc::vec;
use alloc::vec::Vec;

/// What opening a wide node costs, in units of one block of primitives.
pub const NODE_COST: f32 = 1.5;

/// What becomes of each node of a binary tree.
pub struct Plan<'a, const N: usize> {
    tree: &'a BinaryTree,
    gathering: Gathering,
    /// In the order of the tree, where pairs of children lie side by side from node 1 on.
    pairs: Vec<Pair<N>>,
}

/// What is known of two nodes side by side, and of the one above them.
#[derive(Clone, Copy)]
struct Pair<const N: usize> {
    /// For each number of places `j` of the node above, how many of them the first gets (at `j − 1`): 0 where the node takes
    /// one place less. For one place: how many the first gets in a wide node of its own, 0 where both become one leaf.
    choices: [u8; N],
    /// For each, how much surface there is below for each unit of expected cost.
    promises: [f32; 2],
    /// How many primitives there are below both.
    primitives: u32,
}

impl<const N: usize> Pair<N> {
    const BLANK: Self = Self {
        choices: [0; N],
        promises: [0.0; 2],
        primitives: 0,
    };
}

/// What is known of a subtree.
struct Below<const N: usize> {
    /// The expected cost by number of places; infinite for more than it can use.
    costs: [f32; N],
    /// The most places that it can use, and as many costs as are known.
    places: usize,
    primitives: u32,
    /// Of all primitives below.
    surface: f32,
}

impl<const N: usize> Below<N> {
    const NOTHING: Self = Self {
        costs: [0.0; N],
        places: 1,
        primitives: 0,
        surface: 0.0,
    };

    fn promise(&self) -> f32 {
        self.surface / self.costs[0]
    }
}

impl<'a, const N: usize> Plan<'a, N> {
    /// Makes the plan for a tree that lies [depth-first](BinaryTree::is_depth_first); empty where the site says that the build
    /// is over. Leaves that are made of subtrees have at most `max_leaf` primitives.
    pub fn new<P: Primitives + Sync>(
        primitives: &P,
        tree: &'a BinaryTree,
        max_leaf: usize,
        gathering: Gathering,
        site: &Site<'_>,
    ) -> Self {
        let mut pairs = Vec::new();
        let count = tree.nodes.len() / 2;
        if !tree.nodes.is_empty() && site.take(count * size_of::<Pair<N>>()) {
            pairs = vec![Pair::BLANK; count];
            let scales = Scales {
                tree,
                primitives,
                gathering,
                max_leaf: max_leaf as u32,
                site,
            };
            scales.weigh(0, &mut pairs);
        }
        Self {
            tree,
            gathering,
            pairs,
        }
    }

    /// Bytes taken.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.pairs)
    }

    /// What is known of the children of an inner node.
    fn pair(&self, index: usize) -> &Pair<N> {
        &self.pairs[(self.tree.nodes[index].first as usize - 1) / 2]
    }

    /// Whether a subtree that takes one place is a leaf.
    pub fn is_leaf(&self, index: usize) -> bool {
        self.tree.nodes[index].is_leaf() || self.pair(index).choices[0] == 0
    }

    /// The children of the wide node made of a subtree; the last one is the one where a ray finds some hit soonest.
    ///
    /// That one has the most surface for its cost: a ray that asks for any hit takes it first.
    pub fn children(&self, index: usize, found: &mut Vec<usize>) {
        found.clear();
        let [a, b] = self.tree.nodes[index].children();
        match self.gathering {
            Gathering::Optimal => {
                let for_first = usize::from(self.pair(index).choices[0]);
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
        found.sort_by(|&a, &b| self.promise(a).total_cmp(&self.promise(b)));
    }

    /// How much surface there is below a node, but the root, for each unit of expected cost.
    fn promise(&self, index: usize) -> f32 {
        self.pairs[(index - 1) / 2].promises[(index - 1) % 2]
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
            let for_first = usize::from(self.pair(index).choices[count - 1]);
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
            node.count as usize
        } else {
            self.pair(index).primitives as usize
        }
    }

    /// The primitives of a subtree, ascending and each once, so that of equal hits the first is right; spatial splits may
    /// have brought parts together again.
    pub fn primitives(&self, index: usize, ids: &mut Vec<u32>) {
        ids.clear();
        self.list(index, ids);
        ids.sort_unstable();
        ids.dedup();
    }

    fn list(&self, index: usize, ids: &mut Vec<u32>) {
        let node = &self.tree.nodes[index];
        if node.is_leaf() {
            ids.extend_from_slice(&self.tree.order[node.places()]);
        } else {
            for child in node.children() {
                self.list(child, ids);
            }
        }
    }
}

/// What weighs subtrees.
struct Scales<'a, P> {
    tree: &'a BinaryTree,
    primitives: &'a P,
    gathering: Gathering,
    max_leaf: u32,
    site: &'a Site<'a>,
}

/// Subtrees of fewer inner nodes are weighed by one thread.
const SEQUENTIAL: usize = 1024;

impl<P: Primitives + Sync> Scales<'_, P> {
    /// Weighs a subtree, whose pairs are given.
    fn weigh<const N: usize>(&self, index: usize, pairs: &mut [Pair<N>]) -> Below<N> {
        let node = &self.tree.nodes[index];
        let area = half_area(&node.bounds) as f32;
        let [own, below @ ..] = pairs else {
            let ids = self.tree.order.get(node.places()).unwrap_or(&[]);
            let surfaces = ids.iter().map(|&id| surface(self.primitives, id as usize));
            let mut costs = [f32::INFINITY; N];
            costs[0] = leaf_cost(area, node.count);
            return Below {
                costs,
                places: 1,
                primitives: node.count,
                surface: surfaces.sum(),
            };
        };
        let [a, b] = node.children();
        // The pairs below the right child come last.
        let right = &self.tree.nodes[b];
        let of_left = if right.is_leaf() {
            below.len()
        } else {
            (right.first - node.first) as usize / 2 - 1
        };
        let many = below.len() > SEQUENTIAL;
        if many && !self.site.advance(SEQUENTIAL) {
            return Below::NOTHING;
        }
        let (left, right) = below.split_at_mut(of_left);
        #[cfg(feature = "parallel")]
        let halves = if many {
            let (a, b) = threads::join(|| self.weigh(a, left), || self.weigh(b, right));
            [a, b]
        } else {
            [self.weigh(a, left), self.weigh(b, right)]
        };
        #[cfg(not(feature = "parallel"))]
        let halves = [self.weigh(a, left), self.weigh(b, right)];
        own.promises = [halves[0].promise(), halves[1].promise()];
        own.primitives = halves[0].primitives + halves[1].primitives;
        match self.gathering {
            Gathering::Optimal => self.choose(area, &halves, own),
            Gathering::Greedy => self.join(area, &halves, own),
        }
    }

    /// Chooses how many places each half gets.
    fn choose<const N: usize>(
        &self,
        area: f32,
        [a, b]: &[Below<N>; 2],
        own: &mut Pair<N>,
    ) -> Below<N> {
        let mut costs = [f32::INFINITY; N];
        let mut choices = [0_u32; N];
        let places = (a.places + b.places).min(N);
        // `b`'s costs behind as many that are infinite: one step of the window to the left is one place more for `a`. All rows have
        // the same length, and are walked in lanes.
        let behind = [[f32::INFINITY; N], b.costs];
        for k in 1..=a.places.min(N - 1) {
            let of_first = a.costs[k - 1];
            let of_second = &behind.as_flattened()[N - k..][..N];
            for j in 0..N {
                let cost = of_first + of_second[j];
                let less = cost < costs[j];
                costs[j] = if less { cost } else { costs[j] };
                choices[j] = if less { k as u32 } else { choices[j] };
            }
        }
        let mut choices = choices.map(|choice| choice as u8);
        let apart = area * NODE_COST + costs[places - 1];
        let together = leaf_cost(area, own.primitives);
        // Written so that boxes without area, or with an infinite one, stay together.
        (costs[0], choices[0]) = if own.primitives <= self.max_leaf && !(apart < together) {
            (together, 0)
        } else {
            // Costs may be infinite or NaN: then any way does.
            (apart, choices[places - 1].max(1))
        };
        for j in 1..places {
            if !(costs[j] < costs[j - 1]) {
                (costs[j], choices[j]) = (costs[j - 1], 0);
            }
        }
        own.choices = choices;
        Below {
            costs,
            places,
            primitives: own.primitives,
            surface: a.surface + b.surface,
        }
    }

    /// Of a subtree with two halves where nothing is chosen: what fits into a block becomes a leaf.
    fn join<const N: usize>(
        &self,
        area: f32,
        [a, b]: &[Below<N>; 2],
        own: &mut Pair<N>,
    ) -> Below<N> {
        let fits = own.primitives as usize <= Leaves::LANES;
        own.choices[0] = u8::from(!fits);
        let cost = if fits {
            area
        } else {
            // Of a node's places each has a share.
            area * NODE_COST / (N - 1) as f32 + a.costs[0] + b.costs[0]
        };
        Below {
            costs: [cost; N],
            places: 1,
            primitives: own.primitives,
            surface: a.surface + b.surface,
        }
    }
}

fn leaf_cost(area: f32, primitives: u32) -> f32 {
    area * primitives.div_ceil(Leaves::LANES as u32) as f32
}

/// The surface of a primitive; of one that is not a triangle, roughly.
fn surface(primitives: &impl Primitives, id: usize) -> f32 {
    match primitives.corners(id) {
        Some([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
        None => 0.5 * primitives.bounds(id).half_area(),
    }
}
