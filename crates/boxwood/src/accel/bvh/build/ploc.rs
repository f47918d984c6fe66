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

use super::lbvh::{CURVE_BYTES_EACH, along_curve};
#[cfg(feature = "parallel")]
use super::top_down::SEQUENTIAL;
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
#[cfg(feature = "parallel")]
use rayon::prelude::*;

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

/// The widest search.
const MAX_RADIUS: usize = 256;
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
        let clusters = size_of::<BinaryNode>() + size_of::<u32>();
        let bytes = BYTES_EACH + CURVE_BYTES_EACH + clusters;
        if count == 0 || !site.take(bytes.saturating_mul(count)) {
            return site.finish(BinaryTree::default());
        }
        let (codes, items) = along_curve(primitives, self.axes);
        drop(codes);
        let order = items.iter().map(Item::id).collect();
        let clusters = items.iter().enumerate().map(|(place, item)| BinaryNode {
            bounds: Aabb::EMPTY.union(item.bounds()),
            first: place as u32,
            count: 1,
        });
        let clusters = clusters.collect();
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
    let mut partners = Vec::new();
    while clusters.len() > 1 {
        if !site.advance(4 * clusters.len()) {
            return nodes;
        }
        find_partners(&clusters, radius, &mut partners);
        let agree = |i: usize| partners[partners[i] as usize] as usize == i;
        let pairs = (0..clusters.len()).filter(|&i| agree(i)).count() / 2;
        if pairs * TOO_FEW < clusters.len() {
            let last = clusters.len() - 1;
            partners.clear();
            // The last of an odd number stays alone.
            partners.extend((0..=last).map(|i| (i ^ 1).min(last) as u32));
        }
        let mut kept = 0;
        for i in 0..clusters.len() {
            let partner = partners[i] as usize;
            let agree = partner != i && partners[partner] as usize == i;
            // The second of a pair has gone into the place of the first.
            if agree && partner < i {
                continue;
            }
            clusters[kept] = if agree {
                let pair = [clusters[i], clusters[partner]];
                let first = nodes.len() as u32;
                nodes.extend(pair);
                BinaryNode {
                    bounds: pair[0].bounds.union(pair[1].bounds),
                    first,
                    count: 0,
                }
            } else {
                clusters[i]
            };
            kept += 1;
        }
        clusters.truncate(kept);
    }
    nodes[0] = clusters[0];
    nodes
}

/// For each cluster the one that it would like to join.
fn find_partners(clusters: &[BinaryNode], radius: usize, partners: &mut Vec<u32>) {
    let find = |i: usize| partner(clusters, i, radius) as u32;
    #[cfg(feature = "parallel")]
    if clusters.len() > SEQUENTIAL {
        (0..clusters.len())
            .into_par_iter()
            .with_min_len(SEQUENTIAL / 4)
            .map(find)
            .collect_into_vec(partners);
        return;
    }
    partners.clear();
    partners.extend((0..clusters.len()).map(find));
}

/// The cluster within the radius with which the common box is smallest.
///
/// Pairs are compared by area, then by the bits in which their numbers differ, which no two pairs of one cluster share:
/// so the best pair of all has chosen each other, and every round joins some.
#[inline]
fn partner(clusters: &[BinaryNode], i: usize, radius: usize) -> usize {
    let mine = clusters[i].bounds;
    let mut best = (f32::INFINITY, usize::MAX, i);
    let first = i.saturating_sub(radius);
    let last = (i + radius).min(clusters.len() - 1);
    for (j, other) in (first..).zip(&clusters[first..=last]) {
        let area = mine.union(other.bounds).half_area();
        // An infinite box that is flat has the area NaN.
        let area = if area < f32::INFINITY {
            area
        } else {
            f32::INFINITY
        };
        let differ = i ^ j;
        if area <= best.0 && j != i && (area < best.0 || differ < best.1) {
            best = (area, differ, j);
        }
    }
    best.2
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
