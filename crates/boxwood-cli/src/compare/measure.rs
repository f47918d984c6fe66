//! Structures held against each other on the same rays: answers first, then the clock.
//!
//! *How it works.* Each structure gets a [`Share`] of every workload: all rays, or evenly spread ones where it is so slow
//! that all would take too long. The nearest hits of its share must be the reference's, bit for bit; steps are counted on
//! the way. Then the structures take turns on one thread, and the median of the rounds counts.

use super::build::Built;
use super::report::{Traced, bin_of};
use crate::cast::median;
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use boxwood::{Hit, Intersect, Ray, TraversalStats};
use boxwood_render::workload::RayKind;
use rayon::prelude::*;
use std::time::Instant;

/// Rays of one kind, with the right answers.
pub struct Workload {
    pub kind: RayKind,
    /// Whether anything in the way is all that is asked.
    pub occlusion: bool,
    pub rays: Vec<Ray>,
    expected: Vec<Option<Hit>>,
}

/// The most seconds that a structure's rays of one kind may take in one round, on one thread.
const TURN: f64 = 0.4;
/// Rays that find out how fast a structure is.
const PROBE: usize = 16;

impl Workload {
    /// Asks the reference, in the caller's pool.
    pub fn new(kind: RayKind, occlusion: bool, rays: Vec<Ray>, reference: &dyn Intersect) -> Self {
        let mut expected = vec![None; rays.len()];
        reference.closest_hits(&rays, &mut expected);
        Self {
            kind,
            occlusion,
            rays,
            expected,
        }
    }

    /// How many rays hit something.
    pub fn hits(&self) -> usize {
        self.expected.iter().flatten().count()
    }

    /// What is asked, in the words of the report.
    pub fn question(&self) -> &'static str {
        if self.occlusion {
            "occluded"
        } else {
            "closest"
        }
    }

    /// The rays that a structure has time for.
    fn share(&self, structure: &dyn Intersect) -> Share {
        let n = self.rays.len();
        let probe: Vec<usize> = spread(n, PROBE.min(n)).collect();
        let start = Instant::now();
        for &i in &probe {
            std::hint::black_box(structure.closest_hit(&self.rays[i]));
        }
        let each = start.elapsed().as_secs_f64() / probe.len().max(1) as f64;
        // A structure that is not yet in the caches looks slow.
        let affordable = (TURN / each.max(1e-9)) as usize;
        let count = if affordable * 4 >= n {
            n
        } else {
            affordable.max(1)
        };
        let chosen: Vec<usize> = spread(n, count).collect();
        Share {
            rays: chosen.iter().map(|&i| self.rays[i]).collect(),
            hits: chosen
                .iter()
                .filter(|&&i| self.expected[i].is_some())
                .count(),
            chosen,
        }
    }
}

/// `count` of the numbers below `n`, evenly spread.
fn spread(n: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count).map(move |i| (i as u128 * n as u128 / count as u128) as usize)
}

/// The rays of a workload that one structure is asked.
struct Share {
    chosen: Vec<usize>,
    rays: Vec<Ray>,
    hits: usize,
}

/// What all rays of a structure's share cost.
#[derive(Clone, Default)]
struct Counted {
    stats: TraversalStats,
    histogram: Vec<u64>,
}

impl Counted {
    fn add(&mut self, one: &TraversalStats) {
        self.stats.nodes += one.nodes;
        self.stats.leaves += one.leaves;
        self.stats.primitives += one.primitives;
        self.count(bin_of(one.nodes + one.primitives), 1);
    }

    fn count(&mut self, bin: usize, rays: u64) {
        if self.histogram.len() <= bin {
            self.histogram.resize(bin + 1, 0);
        }
        self.histogram[bin] += rays;
    }

    fn merge(mut self, other: Self) -> Self {
        self.stats.nodes += other.stats.nodes;
        self.stats.leaves += other.stats.leaves;
        self.stats.primitives += other.stats.primitives;
        for (bin, rays) in other.histogram.into_iter().enumerate() {
            self.count(bin, rays);
        }
        self
    }
}

/// One kind of rays through all structures, and the histograms of their steps.
pub struct Round {
    pub traced: Vec<Traced>,
    pub histograms: Vec<Vec<u64>>,
}

/// Checks, counts and times one workload.
///
/// # Errors
/// A sentence when two structures disagree.
pub fn measure(
    built: &[&Built<'_>],
    workload: &Workload,
    rounds: u32,
    progress: &Progress,
    (done, of): (usize, usize),
) -> Outcome<Round> {
    let mut shares = Vec::new();
    let mut counted = Vec::new();
    for each in built {
        let share = workload.share(&*each.structure);
        counted.push(check(each, workload, &share)?);
        shares.push(share);
    }
    let mut times = vec![Vec::new(); built.len()];
    for round in 0..rounds as usize {
        progress.at(done + round + 1, of);
        for ((each, share), times) in built.iter().zip(&shares).zip(&mut times) {
            let start = Instant::now();
            let hits = trace(&*each.structure, &share.rays, workload.occlusion);
            times.push(start.elapsed().as_secs_f64());
            if hits != share.hits && each.kind.is_exact() {
                return Err(disagreement(each, workload, "a second time, some ray"));
            }
        }
    }
    let traced = times.iter_mut().zip(&shares).zip(&counted);
    let traced = traced.map(|((times, share), counted)| {
        let n = share.rays.len();
        let per_ray = |count: u64| (n > 0).then(|| count as f64 / n as f64);
        Traced {
            kind: workload.kind.name(),
            // The clock may be too coarse for a few rays.
            mrays_per_second: (n > 0).then(|| n as f64 / median(times).max(1e-9) / 1e6),
            speedup: None,
            nodes_per_ray: per_ray(counted.stats.nodes),
            leaves_per_ray: per_ray(counted.stats.leaves),
            primitives_per_ray: per_ray(counted.stats.primitives),
            rays_asked: n,
        }
    });
    Ok(Round {
        traced: traced.collect(),
        histograms: counted.into_iter().map(|c| c.histogram).collect(),
    })
}

/// The loop that is timed: single rays, one after the other.
fn trace(structure: &dyn Intersect, rays: &[Ray], occlusion: bool) -> usize {
    if occlusion {
        rays.iter().filter(|ray| structure.occluded(ray)).count()
    } else {
        rays.iter()
            .filter(|ray| structure.closest_hit(ray).is_some())
            .count()
    }
}

/// Holds every answer of a structure against the right one, and counts the steps of what will be timed.
fn check(each: &Built<'_>, workload: &Workload, share: &Share) -> Outcome<Counted> {
    let structure = &*each.structure;
    let held = if each.kind.is_exact() {
        &share.chosen[..]
    } else {
        &[]
    };
    let wrong = held.par_iter().find_first(|&&i| {
        let ray = &workload.rays[i];
        let found = structure.closest_hit(ray);
        bits(found) != bits(workload.expected[i])
            || (workload.occlusion && structure.occluded(ray) != found.is_some())
    });
    if let Some(i) = wrong {
        return Err(disagreement(each, workload, &format!("ray {i}")));
    }
    let count = |mut counted: Counted, ray: &Ray| {
        let mut one = TraversalStats::default();
        if workload.occlusion {
            structure.occluded_counted(ray, &mut one);
        } else {
            structure.closest_hit_counted(ray, &mut one);
        }
        counted.add(&one);
        counted
    };
    let counted = share.rays.par_iter().fold(Counted::default, count);
    Ok(counted.reduce(Counted::default, Counted::merge))
}

/// A hit's bits: `-0` is not `0` here.
fn bits(hit: Option<Hit>) -> Option<[u32; 5]> {
    hit.map(|h| {
        [
            h.t.to_bits(),
            h.u.to_bits(),
            h.v.to_bits(),
            h.primitive,
            h.instance,
        ]
    })
}

fn disagreement(each: &Built<'_>, workload: &Workload, what: &str) -> Failure {
    Failure::new(format!(
        "{}: {what} of the {} rays is answered otherwise than by {}; this is a fault of Boxwood, please report it",
        each.kind,
        workload.kind,
        boxwood::StructureKind::default()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_spread() {
        assert_eq!(spread(10, 3).collect::<Vec<_>>(), [0, 3, 6]);
        assert_eq!(spread(4, 4).collect::<Vec<_>>(), [0, 1, 2, 3]);
        assert_eq!(spread(0, 0).count(), 0);
    }

    #[test]
    fn counts_add_up() {
        let ray = |nodes, primitives| TraversalStats {
            nodes,
            primitives,
            ..Default::default()
        };
        let [mut a, mut b] = [Counted::default(), Counted::default()];
        a.add(&ray(0, 0));
        b.add(&ray(1, 2));
        b.add(&ray(0, 1));
        let sum = a.merge(b);
        assert_eq!((sum.stats.nodes, sum.stats.primitives), (1, 3));
        assert_eq!(sum.histogram, [1, 0, 1, 0, 1]);
    }
}
