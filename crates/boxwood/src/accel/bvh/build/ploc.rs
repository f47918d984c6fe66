//! Joins neighbours from the leaves up: nearly as fast as the curve alone, nearly as good as the heuristic.
//!
//! *How it works.* The primitives lie along a Morton curve, each a cluster. Every cluster looks a few places to both sides
//! for the one with which its box would be smallest; pairs that have chosen each other become one cluster, in the place of
//! the first. That is repeated until one is left. At last small subtrees become leaves where that is cheaper.
//!
//! Of equally good partners the one is chosen whose number differs in the lowest bits: so identical primitives pair up
//! at once, instead of one after the other. Where few pairs agree all the same (boxes whose distances grow exponentially),
//! neighbours on the curve are joined: the number of rounds is logarithmic for every input.
//!
//! *Cost.* O(n · radius); about three searches a primitive.
//!
//! *Source.* Meister & Bittner 2018, *Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction*.

mod partners;

use super::curve::{CURVE_BYTES_EACH, along_curve};
use super::top_down::work;
use super::{BYTES_EACH, BinaryNode, BinaryTree, Item};
use crate::accel::bvh::refine::{Refine, collapse_leaves};
use crate::accel::bvh::tree::MAX_LEAF;
use crate::accel::limits::Site;
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use alloc::vec::Vec;
use core::ops::Range;
use partners::{CHUNK, MAX_RADIUS, Scratch};
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// The builder by clustering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ploc {
    /// How many places to each side a cluster looks for a partner, 1 to 256.
    pub radius: usize,
    /// Most primitives in a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: usize,
    /// The axes that the curve follows.
    pub axes: Axes,
    /// What is done to the tree afterwards.
    pub refine: Refine,
}

/// Clusters that one thread joins at once.
const RUN: usize = 4096;
/// Where less than this part of the clusters agree, neighbours on the curve are joined.
const TOO_FEW: usize = 16;

impl Default for Ploc {
    fn default() -> Self {
        Self {
            radius: 8,
            max_leaf: 8,
            axes: Axes::XYZ,
            refine: Refine::NONE,
        }
    }
}

impl Ploc {
    fn tree(
        &self,
        primitives: &(impl Primitives + Sync),
        limits: &Limits<'_>,
    ) -> Result<BinaryTree, BuildError> {
        let count = primitives.len();
        let site = Site::new(limits, work(count, self.refine));
        let clusters = 2 * size_of::<BinaryNode>() + size_of::<u32>();
        let bytes = BYTES_EACH + CURVE_BYTES_EACH + clusters;
        if count == 0 || !site.take(bytes.saturating_mul(count)) {
            return site.finish(BinaryTree::default());
        }
        let Some((codes, items)) = along_curve(primitives, self.axes, &site) else {
            return site.finish(BinaryTree::default());
        };
        drop(codes);
        let cluster_of = |(place, item): (usize, &Item)| BinaryNode {
            bounds: Aabb::EMPTY.union(item.bounds()),
            first: place as u32,
            count: 1,
        };
        #[cfg(feature = "parallel")]
        let items_in_order = items.par_iter();
        #[cfg(not(feature = "parallel"))]
        let items_in_order = items.iter();
        let clusters = items_in_order.clone().enumerate();
        #[cfg(feature = "parallel")]
        let clusters = clusters.exactly();
        let clusters = clusters.map(cluster_of).collect();
        let order = items_in_order.map(Item::id).collect();
        drop(items);
        let radius = self.radius.clamp(1, MAX_RADIUS);
        let mut tree = BinaryTree {
            nodes: cluster(clusters, radius, &site),
            order,
        };
        if !site.is_over() {
            self.refine.apply(&mut tree, &site);
            collapse_leaves(&mut tree, self.max_leaf);
        }
        site.finish(tree)
    }
}

/// Joins clusters until one is left, which is the first node.
fn cluster(mut clusters: Vec<BinaryNode>, radius: usize, site: &Site<'_>) -> Vec<BinaryNode> {
    let mut nodes = Vec::with_capacity(2 * clusters.len());
    // The root's place.
    nodes.push(clusters[0]);
    let (mut partners, mut joined) = (Vec::new(), Vec::new());
    while clusters.len() > 1 {
        if !find_partners(&clusters, radius, &mut partners, site) {
            return nodes;
        }
        let pairs = join(&clusters, &partners, &mut joined, &mut nodes);
        if pairs * TOO_FEW < clusters.len() {
            nodes.truncate(nodes.len() - 2 * pairs);
            let last = clusters.len() - 1;
            partners.clear();
            // The last of an odd number stays alone.
            partners.extend((0..=last).map(|i| (i ^ 1).min(last) as u32));
            join(&clusters, &partners, &mut joined, &mut nodes);
        }
        core::mem::swap(&mut clusters, &mut joined);
    }
    nodes[0] = clusters[0];
    nodes
}

/// For each cluster the one that it would like to join; `false` when the build is over.
fn find_partners(
    clusters: &[BinaryNode],
    radius: usize,
    partners: &mut Vec<u32>,
    site: &Site<'_>,
) -> bool {
    partners.resize(clusters.len(), 0);
    let find_some = |scratch: &mut Scratch, (chunk, partners): (usize, &mut [u32])| {
        if site.advance(4 * partners.len()) {
            scratch.find(clusters, radius, chunk * CHUNK, partners);
        }
    };
    #[cfg(feature = "parallel")]
    partners
        .par_chunks_mut(CHUNK)
        .enumerate()
        .exactly()
        .for_each_init(Scratch::new, find_some);
    #[cfg(not(feature = "parallel"))]
    {
        let mut scratch = Scratch::new();
        let chunks = partners.chunks_mut(CHUNK).enumerate();
        chunks.for_each(|chunk| find_some(&mut scratch, chunk));
    }
    !site.is_over()
}

/// What becomes of a cluster in one round.
enum Fate {
    /// It stays as it is.
    Alone,
    /// It becomes a node above itself and this one.
    First(usize),
    /// It has gone into the place of the first of its pair.
    Second,
}

#[inline(always)]
fn fate(i: usize, partners: &[u32]) -> Fate {
    let partner = partners[i] as usize;
    if partner == i || partners[partner] as usize != i {
        Fate::Alone
    } else if partner < i {
        Fate::Second
    } else {
        Fate::First(partner)
    }
}

/// Joins those who have chosen each other: the clusters that are left, and the nodes of the pairs behind the others. How
/// many pairs there were.
fn join(
    clusters: &[BinaryNode],
    partners: &[u32],
    joined: &mut Vec<BinaryNode>,
    nodes: &mut Vec<BinaryNode>,
) -> usize {
    const BLANK: BinaryNode = BinaryNode {
        bounds: Aabb::EMPTY,
        first: 0,
        count: 0,
    };
    let runs = (0..clusters.len()).step_by(RUN);
    let runs = runs.map(|first| first..(first + RUN).min(clusters.len()));
    let runs: Vec<Range<usize>> = runs.collect();
    // How many pairs begin in a run, and how many clusters are left of it.
    let count = |run: &Range<usize>| {
        run.clone().fold((0, 0), |(pairs, left), i| {
            let (first, gone) = match fate(i, partners) {
                Fate::Alone => (0, 0),
                Fate::First(_) => (1, 0),
                Fate::Second => (0, 1),
            };
            (pairs + first, left + 1 - gone)
        })
    };
    #[cfg(feature = "parallel")]
    let counts: Vec<(usize, usize)> = runs.par_iter().map(count).collect();
    #[cfg(not(feature = "parallel"))]
    let counts: Vec<(usize, usize)> = runs.iter().map(count).collect();
    let pairs = counts.iter().map(|count| count.0).sum();
    let before = nodes.len();
    nodes.resize(before + 2 * pairs, BLANK);
    joined.clear();
    joined.resize(clusters.len() - pairs, BLANK);
    // Each run writes to slices of its own.
    let mut rest = (&mut joined[..], &mut nodes[before..]);
    let mut at = before;
    let mut tasks = Vec::with_capacity(runs.len());
    for (run, &(pairs, left)) in runs.into_iter().zip(&counts) {
        let (joined, others) = core::mem::take(&mut rest.0).split_at_mut(left);
        let (nodes, more) = core::mem::take(&mut rest.1).split_at_mut(2 * pairs);
        rest = (others, more);
        tasks.push((run, at, joined, nodes));
        at += 2 * pairs;
    }
    let write =
        |(run, at, joined, nodes): (Range<usize>, usize, &mut [BinaryNode], &mut [BinaryNode])| {
            let left = run.filter_map(|i| match fate(i, partners) {
                Fate::Alone => Some((i, i)),
                Fate::First(partner) => Some((i, partner)),
                Fate::Second => None,
            });
            let mut pairs = (at as u32..).step_by(2).zip(nodes.as_chunks_mut::<2>().0);
            for (to, (i, partner)) in joined.iter_mut().zip(left) {
                *to = clusters[i];
                if partner != i
                    && let Some((first, [a, b])) = pairs.next()
                {
                    (*a, *b) = (clusters[i], clusters[partner]);
                    *to = BinaryNode {
                        bounds: a.bounds.union(b.bounds),
                        first,
                        count: 0,
                    };
                }
            }
        };
    #[cfg(feature = "parallel")]
    tasks.into_par_iter().exactly().for_each(write);
    #[cfg(not(feature = "parallel"))]
    tasks.into_iter().for_each(write);
    pairs
}

bvh_builder!(
    Ploc,
    "bvh:ploc",
    |builder| [
        Setting::count("radius", &mut builder.radius, 1..=MAX_RADIUS),
        Setting::count("leaf", &mut builder.max_leaf, 1..=MAX_LEAF),
        Setting::axes(&mut builder.axes),
    ],
    +refine
);
