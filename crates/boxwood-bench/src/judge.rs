//! Who is right where a peer's answer differs from Boxwood's.
//!
//! *How it works.* Boxwood's answers are those of its own judge to the bit. A peer agrees when both miss, or when its `t`
//! is Boxwood's to 1e-5. Where it does not, the testkit's oracle is asked in double precision about the triangles that the
//! two name: it knows whether a ray meets a triangle for certain and between which distances, misses it for certain, or
//! whether rounding decides.

use boxwood::{Hit, Ray, TriangleMesh};
use boxwood_testkit::oracle::{self, Verdict};
use rayon::prelude::*;
use serde::Serialize;

/// How many answers differ, by who is wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Disagreements {
    /// The peer missed a triangle that the ray certainly meets, or hit one behind it.
    pub missed: u32,
    /// The peer hit a triangle that the ray certainly does not meet there.
    pub invented: u32,
    /// The peer's `t` on the right triangle is further off than rounding explains.
    pub inexact: u32,
    /// Rounding decides, for rays along edges and near planes: both are right.
    pub ties: u32,
    /// Boxwood is wrong.
    pub ours: u32,
    /// Beyond the number that is looked into.
    pub unjudged: u32,
    /// The first few rays that somebody is wrong about, by number among those that the peer was asked.
    pub examples: Vec<usize>,
}

impl Disagreements {
    /// All of them.
    pub fn total(&self) -> u32 {
        self.missed + self.invented + self.inexact + self.ties + self.ours + self.unjudged
    }

    /// How many of them are the peer's fault; of those that were not judged the same share as of those like them.
    pub fn wrong(&self) -> u32 {
        let judged = u64::from(self.invented + self.ties + self.ours).max(1);
        let unjudged = u64::from(self.unjudged) * u64::from(self.invented) / judged;
        self.missed + self.invented + self.inexact + unjudged as u32
    }

    /// Adds those of others; the examples, which are of one kind of rays, stay behind.
    pub fn add(&mut self, other: &Self) {
        self.missed += other.missed;
        self.invented += other.invented;
        self.inexact += other.inexact;
        self.ties += other.ties;
        self.ours += other.ours;
        self.unjudged += other.unjudged;
    }

    fn count(&mut self, ray: usize, cause: Cause) {
        if cause != Cause::Tie && self.examples.len() < EXAMPLES {
            self.examples.push(ray);
        }
        *match cause {
            Cause::Missed => &mut self.missed,
            Cause::Invented => &mut self.invented,
            Cause::Inexact => &mut self.inexact,
            Cause::Tie => &mut self.ties,
            Cause::Ours => &mut self.ours,
        } += 1;
    }
}

/// Where several triangles are searched, the last of these counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Cause {
    Missed,
    Inexact,
    Invented,
    Tie,
    Ours,
}

/// Distances may differ by so much of themselves.
const TOLERANCE: f64 = 1.0e-5;
/// The most answers that are looked into for one peer and kind of rays; where nobody names a triangle all are searched.
const MOST: usize = 20_000;
const MOST_SEARCHES: usize = 50;
const EXAMPLES: usize = 8;

/// Whether a ray meets a triangle within its interval, and between which distances.
#[derive(Clone, Copy)]
enum Meeting {
    Surely(f64, f64),
    Perhaps,
    No,
}

fn meeting(mesh: &TriangleMesh, ray: &Ray, primitive: u32) -> Meeting {
    if primitive as usize >= mesh.triangles().len() {
        return Meeting::No;
    }
    let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
    match oracle::verdict(mesh.triangle(primitive as usize), ray) {
        Verdict::Missed => Meeting::No,
        Verdict::Doubtful => Meeting::Perhaps,
        Verdict::Met(from, to) if to < t_min || from > t_max => Meeting::No,
        Verdict::Met(from, to) if from >= t_min && to <= t_max => Meeting::Surely(from, to),
        Verdict::Met(..) => Meeting::Perhaps,
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE * a.abs().max(b.abs())
}

/// Whether a distance lies between two others, or as good as.
fn between(t: f32, from: f64, to: f64) -> bool {
    let t = f64::from(t);
    (from <= t && t <= to) || near(t, from) || near(t, to)
}

/// Holds a peer's nearest hits against Boxwood's.
pub fn closest(
    mesh: &TriangleMesh,
    rays: &[Ray],
    ours: &[Option<Hit>],
    theirs: &[Option<Hit>],
) -> Disagreements {
    let mut found = Disagreements::default();
    for (i, ((ray, ours), theirs)) in rays.iter().zip(ours).zip(theirs).enumerate() {
        let cause = match (ours, theirs) {
            (None, None) => continue,
            (Some(a), Some(b)) if near(a.t.into(), b.t.into()) => continue,
            _ if found.total() as usize >= MOST => {
                found.unjudged += 1;
                continue;
            }
            (Some(a), Some(b)) if a.primitive == b.primitive => {
                match meeting(mesh, ray, a.primitive) {
                    Meeting::Surely(from, to) if !between(b.t, from, to) => Cause::Inexact,
                    Meeting::Surely(..) | Meeting::Perhaps => Cause::Tie,
                    Meeting::No => Cause::Ours,
                }
            }
            (Some(a), None) => passed_over(meeting(mesh, ray, a.primitive), f32::INFINITY),
            (Some(a), Some(b)) if a.t < b.t => passed_over(meeting(mesh, ray, a.primitive), b.t),
            (Some(a), Some(b)) => found_alone(meeting(mesh, ray, b.primitive), b, a.t),
            (None, Some(b)) => found_alone(meeting(mesh, ray, b.primitive), b, f32::INFINITY),
        };
        found.count(i, cause);
    }
    found
}

/// Boxwood hit a triangle, the peer one that is further away, or none.
fn passed_over(meeting: Meeting, theirs: f32) -> Cause {
    match meeting {
        Meeting::Surely(_, to) if to < theirs.into() => Cause::Missed,
        Meeting::Surely(..) | Meeting::Perhaps => Cause::Tie,
        Meeting::No => Cause::Ours,
    }
}

/// The peer hit a triangle, Boxwood one that is further away, or none.
fn found_alone(meeting: Meeting, theirs: &Hit, ours: f32) -> Cause {
    match meeting {
        // Somewhere else on the ray than the peer says.
        Meeting::Surely(from, to) if !between(theirs.t, from, to) => Cause::Invented,
        Meeting::Surely(_, to) if to < ours.into() => Cause::Ours,
        Meeting::Surely(..) | Meeting::Perhaps => Cause::Tie,
        Meeting::No => Cause::Invented,
    }
}

/// Holds a peer's answers to whether anything is there against Boxwood's nearest hits.
pub fn occluded(
    mesh: &TriangleMesh,
    rays: &[Ray],
    ours: &[Option<Hit>],
    theirs: &[bool],
) -> Disagreements {
    let mut found = Disagreements::default();
    let mut searches = 0;
    for (i, ((ray, ours), &theirs)) in rays.iter().zip(ours).zip(theirs).enumerate() {
        if ours.is_some() == theirs {
            continue;
        }
        let cause = match ours {
            Some(hit) => passed_over(meeting(mesh, ray, hit.primitive), f32::INFINITY),
            None if searches == MOST_SEARCHES => {
                found.unjudged += 1;
                continue;
            }
            None => {
                searches += 1;
                // What a peer has seen it does not say.
                let cause_of = |primitive: u32| match meeting(mesh, ray, primitive) {
                    Meeting::Surely(..) => Cause::Ours,
                    Meeting::Perhaps => Cause::Tie,
                    Meeting::No => Cause::Invented,
                };
                let all = (0..mesh.triangles().len() as u32).into_par_iter();
                all.map(cause_of).max().unwrap_or(Cause::Invented)
            }
        };
        found.count(i, cause);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall() -> TriangleMesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        TriangleMesh::new(corners, [[0_u32, 1, 2]]).expect("a good mesh")
    }

    fn hit(t: f32) -> Option<Hit> {
        Some(Hit {
            t,
            u: 0.0,
            v: 0.0,
            primitive: 0,
            instance: 0,
        })
    }

    #[test]
    fn causes_are_told_apart() {
        let mesh = wall();
        let towards = Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]);
        let beside = Ray::new([0.8, 0.8, 1.0], [0.0, 0.0, -1.0]);
        let edge = Ray::new([0.0, 0.5, 1.0], [0.0, 0.0, -1.0]);
        let ask = |ray: Ray, ours, theirs| closest(&mesh, &[ray], &[ours], &[theirs]);
        let none = Disagreements::default();
        assert_eq!(ask(towards, hit(1.0), hit(1.000_001)), none);
        assert_eq!(ask(beside, None, None), none);
        assert_eq!(ask(towards, hit(1.0), None).missed, 1);
        assert_eq!(ask(towards, None, hit(1.0)).ours, 1);
        assert_eq!(ask(towards, hit(1.0), hit(1.1)).inexact, 1);
        assert_eq!(ask(beside, None, hit(1.0)).invented, 1);
        assert_eq!(ask(beside, hit(1.0), None).ours, 1);
        assert_eq!(ask(edge, hit(1.0), None).ties, 1);
        assert_eq!(ask(towards.until(0.5), None, hit(1.0)).invented, 1);
        let any = |ray: Ray, ours, theirs| occluded(&mesh, &[ray], &[ours], &[theirs]);
        assert_eq!(any(towards, hit(1.0), true), none);
        assert_eq!(any(towards, hit(1.0), false).missed, 1);
        assert_eq!(any(towards, None, true).ours, 1);
        assert_eq!(any(edge, None, true).ties, 1);
        assert_eq!(any(beside, None, true).invented, 1);
    }
}
