//! Opening placed objects whose boxes overlap: the tree then stands over parts of them.
//!
//! *How it works.* Where boxes of objects overlap, a ray has to ask one object after the other from its root, whichever holds the nearest hit. So an
//! object that shares much of its box with others is replaced by the parts that the root of its own tree has, and these by theirs, those first that share
//! the most surface with others, until there are as many entries as the builder's settings allow. The tree is built over what there is then, as over
//! anything; a ray enters the object's tree at the part that it has met. What an object shares with others is asked of a binary tree over all of them.
//!
//! A primitive that is opened counts as one that was [cut](super::WideBvh): it lies in several leaves, each of which holds a part. Boxes of
//! parts are met with [`PARTS_SLACK`](crate::primitive::PARTS_SLACK) times the slack, and rays outside the doors are shown each primitive as a whole.
//!
//! *Cost.* O(n log n), where boxes do not overlap everywhere; what one of them shares is counted up to a bound.
//!
//! *Source.* Benthin, Woop, Wald & Áfra 2017, *Improved Two-Level BVHs using Partial Re-Braiding*, who open while the tree is built.

use super::leaf::NONE;
use super::{Layout, WideBvh, WideSah};
use crate::accel::bvh::BinnedSah;
use crate::accel::bvh::tree::BinaryTree;
use crate::accel::limits::{Limits, Site};
use crate::accel::sah::half_area;
use crate::accel::{Axes, BuildError};
use crate::geometry::{Aabb, PreparedRay};
use crate::primitive::Primitives;
use crate::query::{Counters, Part, Query};
use crate::simd::{Level, Vectorize};
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Ordering;
use core::ops::ControlFlow::{self, Continue};

/// What a leaf will hold.
#[derive(Clone, Copy, Debug)]
struct Entry {
    bounds: Aabb,
    primitive: u32,
    part: Part,
}

/// All of them, as builders see them.
pub struct Entries(Vec<Entry>);

impl Entries {
    /// The bytes that they take.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

impl Primitives for Entries {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, i: usize) -> Aabb {
        self.0[i].bounds
    }
    fn offer<Q: Query, C: Counters>(
        &self,
        _: usize,
        _: &PreparedRay,
        _: &mut Q,
        _: &mut C,
    ) -> ControlFlow<()> {
        Continue(())
    }
    const COMPOSITE: bool = true;
}

/// What shares less than so many times its surface with others, all in all, stays whole: parts of an object have more surface than all of it, and to
/// enter several costs more than it saves where few overlap.
const LEAST_SHARE: f64 = 5.0;
/// There are at most so many entries more than primitives: enough for the large ones, which rays meet most. Thousands of small ones that overlap, as the
/// plants of a meadow do, gain nothing by it.
const MOST_MORE: usize = 1 << 12;
/// What a box shares with others is counted up to so many times its own surface.
const MOST_SHARED: f64 = 8.0;
/// And among so many others.
const MOST_MET: usize = 64;

/// More bytes than an entry, and what is built over it, take at any time.
const EACH: usize = 512;

/// The entries of a tree over these primitives, at most `most` times as many; `None` where none was opened.
///
/// # Errors
/// When the limits end the build.
pub fn entries<P: Primitives + Sync>(
    primitives: &P,
    axes: Axes,
    most: usize,
    limits: &Limits<'_>,
) -> Result<Option<Entries>, BuildError> {
    let count = primitives.len();
    if !P::COMPOSITE || most < 2 || count < 2 {
        return Ok(None);
    }
    let room = most.saturating_mul(count).min(count + MOST_MORE);
    let watch = |share: f32| limits.watch.map_or(Continue(()), |watch| watch(share));
    let [before, after] = [0.0, 0.5].map(|from| move |share: f32| watch(from + 0.5 * share));
    let afterwards = Limits {
        watch: Some(&after),
        ..*limits
    };
    let site = Site::new(&afterwards, count);
    // Where the tree may not take so much, it stands over whole primitives.
    if !site.try_take(room.saturating_mul(EACH)) {
        return Ok(None);
    }
    let whole = |i: usize| Entry {
        bounds: primitives.bounds(i),
        primitive: i as u32,
        part: Part::ALL,
    };
    let whole = Entries((0..count).map(whole).collect());
    let builder = BinnedSah {
        max_leaf: 1,
        axes,
        ..BinnedSah::default()
    };
    let beforehand = Limits {
        watch: Some(&before),
        ..*limits
    };
    let over = builder.build_within(&whole, &beforehand)?;
    let neighbours = Neighbours {
        all: &whole.0,
        tree: &over,
    };
    let mut parts = |entry: &Entry| {
        let mut parts = Vec::new();
        primitives.parts(entry.primitive as usize, entry.part, &mut |bounds, part| {
            parts.push(Entry {
                bounds,
                part,
                ..*entry
            });
        });
        parts
    };
    let opened = open(&neighbours, room, &mut parts, &site);
    site.finish(opened.map(|mut entries| {
        fill(&mut entries, &whole.0);
        Entries(entries)
    }))
}

/// An entry that may be opened.
struct Waiting {
    shared: f64,
    number: usize,
}

impl Ord for Waiting {
    /// The one that shares the most is the greatest; of equal ones the first.
    fn cmp(&self, other: &Self) -> Ordering {
        (self.shared.total_cmp(&other.shared)).then(other.number.cmp(&self.number))
    }
}
impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Waiting {}

/// Opens what shares most, until there are `room` entries.
fn open(
    neighbours: &Neighbours<'_>,
    room: usize,
    parts: &mut dyn FnMut(&Entry) -> Vec<Entry>,
    site: &Site<'_>,
) -> Option<Vec<Entry>> {
    let mut entries = neighbours.all.to_vec();
    let waiting = |entries: &[Entry], number: usize| {
        let entry = &entries[number];
        let shared = neighbours.shared(entry);
        (shared > LEAST_SHARE * half_area(&entry.bounds)).then_some(Waiting { shared, number })
    };
    let mut heap = BinaryHeap::new();
    for number in 0..entries.len() {
        if site.advance(1) {
            heap.extend(waiting(&entries, number));
        }
    }
    while let Some(Waiting { number, .. }) = heap.pop() {
        if site.is_over() {
            break;
        }
        let within = parts(&entries[number]);
        // One that needs more room than there is may be followed by one that needs less.
        if within.is_empty() || entries.len() + within.len() - 1 > room {
            continue;
        }
        for (i, part) in within.into_iter().enumerate() {
            let number = if i == 0 { number } else { entries.len() };
            if i == 0 {
                entries[number] = part;
            } else {
                entries.push(part);
            }
            heap.extend(waiting(&entries, number));
        }
    }
    let any = entries.iter().any(|entry| entry.part != Part::ALL);
    any.then_some(entries)
}

/// Who lies where, all being whole.
struct Neighbours<'a> {
    all: &'a [Entry],
    tree: &'a BinaryTree,
}

impl Neighbours<'_> {
    /// How much of its half surface an entry shares with others, each counted.
    fn shared(&self, entry: &Entry) -> f64 {
        let most = MOST_SHARED * half_area(&entry.bounds);
        let (mut sum, mut met) = (0.0, 0);
        let mut open = Vec::from([0_usize]);
        while let Some(node) = open.pop() {
            let Some(node) = self.tree.nodes.get(node) else {
                continue;
            };
            if node.bounds.intersection(entry.bounds).is_empty() {
                continue;
            }
            if !node.is_leaf() {
                open.extend(node.children());
                continue;
            }
            for &i in &self.tree.order[node.first as usize..][..node.count as usize] {
                let other = &self.all[i as usize];
                if other.primitive != entry.primitive {
                    sum += half_area(&other.bounds.intersection(entry.bounds));
                    met += 1;
                }
            }
            if sum > most || met > MOST_MET {
                break;
            }
        }
        sum.min(most)
    }
}

/// Makes the boxes together as large as those of whole primitives: all structures over them have the same bounds, and rays the same slack.
fn fill(entries: &mut [Entry], whole: &[Entry]) {
    let around = whole.iter().fold(Aabb::EMPTY, |b, e| b.union(e.bounds));
    let there = |entry: &&mut Entry| !entry.bounds.is_empty();
    for axis in 0..3 {
        let (lower, upper) = (around.lower[axis], around.upper[axis]);
        let least = entries.iter_mut().filter(there);
        let least = least.min_by(|a, b| a.bounds.lower[axis].total_cmp(&b.bounds.lower[axis]));
        if let Some(entry) = least {
            entry.bounds.lower[axis] = lower;
        }
        let greatest = entries.iter_mut().filter(there);
        let greatest =
            greatest.max_by(|a, b| a.bounds.upper[axis].total_cmp(&b.bounds.upper[axis]));
        if let Some(entry) = greatest {
            entry.bounds.upper[axis] = upper;
        }
    }
}

impl<P: Primitives + Sync, const N: usize, L: Layout> WideBvh<P, N, L>
where
    Level: Vectorize<N>,
{
    /// The tree over primitives and entries of theirs.
    ///
    /// # Errors
    /// When the limits end the build.
    pub(super) fn braided(
        builder: &WideSah<N>,
        primitives: P,
        entries: Entries,
        tree: &BinaryTree,
        limits: &Limits<'_>,
    ) -> Result<Self, BuildError> {
        let over = WideBvh::<Entries, N, L>::within(entries, tree, builder.gathering, limits)?;
        let Entries(entries) = &over.primitives;
        let entry = |id: u32| entries[id as usize];
        let mut leaves = over.leaves;
        // Where entries have come together, their primitives are offered as a whole.
        let parts = (0..leaves.len()).map(|block| match leaves.places(block) {
            [id, NONE, ..] => entry(id).part,
            _ => Part::ALL,
        });
        let parts = parts.collect();
        leaves.renumber(|id| entry(id).primitive);
        Ok(Self {
            bounds: over.bounds,
            frame: over.frame,
            primitives,
            root: over.root,
            nodes: over.nodes,
            leaves,
            cut: true,
            parts,
            isa: over.isa,
            precision: over.precision,
            depth: over.depth,
        })
    }
}
