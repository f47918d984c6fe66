//! Everybody on the same rays: answers first, then the clock.
//!
//! *How it works.* Boxwood's structures must give the reference's bits for every ray and way of asking, and the reference
//! those of the exhaustive test on a sample. Peers are held against the same answers, and what differs is judged. Then all
//! take turns, round by round, in one pinned thread whose own time counts; a ratio is made of two turns of one round, so
//! that what slows the machine for longer than a turn slows both. A peer that would keep the others waiting is given
//! blocks of rays from all over the workload instead of all; times are per ray.

use crate::failure::{Outcome, failed};
use crate::judge::{self, Disagreements};
use crate::machine::thread_seconds;
use crate::peers::{Built, FlushToZero, Way};
use crate::rays::Kind;
use boxwood::{BruteForce, Hit, Intersect, Ray, TraversalStats, TriangleMesh};
use rayon::prelude::*;
use serde::Serialize;
use std::borrow::Cow;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Question {
    /// The nearest hit.
    Closest,
    /// Whether anything is in the way.
    Occluded,
}

impl Question {
    pub const ALL: [Self; 2] = [Self::Closest, Self::Occluded];
}

impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Closest => "closest",
            Self::Occluded => "occluded",
        })
    }
}

/// Someone who is ready.
pub struct Ready<'a> {
    pub name: String,
    pub built: Box<dyn Built + 'a>,
}

/// How quiet the machine was meanwhile.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Noise {
    /// By how much of itself the core's clock rose or fell between rounds.
    pub clock_drift: f64,
    /// The share of the time in which the thread had to wait for others; `None` where several trace.
    pub waited: Option<f64>,
}

/// Multiplications, each waiting for the one before, whose time tells the core's clock: about 3 ms.
const CHAIN: u32 = 2_000_000;

/// Seconds for the chain.
fn clock() -> f64 {
    let start = thread_seconds();
    let product = (0..CHAIN).fold(black_box(3_u64), |x, _| {
        black_box(x).wrapping_mul(0x9e37_79b9)
    });
    black_box(product);
    thread_seconds() - start
}

/// Rays of one kind with the right answers.
pub struct Workload {
    pub kind: Kind,
    pub rays: Vec<Ray>,
    expected: Vec<Option<Hit>>,
}

/// Triangle tests of the exhaustive judge for each workload, and the least number of its rays.
const JUDGED: usize = 40_000_000;
const LEAST_JUDGED: usize = 4;

impl Workload {
    /// Asks the reference, in the caller's pool, and the exhaustive judge about a sample.
    ///
    /// # Errors
    /// When the judge disagrees.
    pub fn new(
        kind: Kind,
        rays: Vec<Ray>,
        mesh: &TriangleMesh,
        reference: &dyn Intersect,
    ) -> Outcome<Self> {
        let mut expected = vec![None; rays.len()];
        reference.closest_hits(&rays, &mut expected);
        let sample = (JUDGED / mesh.triangles().len().max(1)).clamp(LEAST_JUDGED, 1000);
        let step = (rays.len() / sample).max(1);
        let judge = BruteForce::new(mesh);
        let wrong = (0..rays.len())
            .into_par_iter()
            .step_by(step)
            .find_any(|&i| bits(judge.closest_hit(&rays[i])) != bits(expected[i]));
        if let Some(i) = wrong {
            return Err(failed(format!(
                "{kind}: the exhaustive test answers ray {i} otherwise; this is a fault of Boxwood, please report it"
            )));
        }
        Ok(Self {
            kind,
            rays,
            expected,
        })
    }

    /// How many rays hit something.
    pub fn hits(&self) -> usize {
        self.expected.iter().flatten().count()
    }
}

/// One contestant's turns on one workload, by one way of asking.
#[derive(Clone, Debug, Serialize)]
pub struct Turns {
    pub contestant: String,
    pub way: Way,
    /// Whether it is one of Boxwood's own.
    pub own: bool,
    /// How many of the rays it was asked.
    pub rays_asked: usize,
    /// Nanoseconds per ray in each round.
    pub nanoseconds: Vec<f64>,
    /// Steps per ray, for Boxwood's own.
    pub nodes_per_ray: Option<f64>,
    pub leaves_per_ray: Option<f64>,
    pub primitives_per_ray: Option<f64>,
    /// How many answers differ from Boxwood's.
    pub disagreements: Disagreements,
}

/// The longest turn of a peer, in seconds.
const TURN: f64 = 1.0;
/// Rays that find out how fast a peer is, and the rays of a block.
const PROBE: usize = 1024;
const BLOCK: usize = 256;
/// Rays of one task where several threads trace.
const TASK: usize = 4096;

/// One contestant and the rays it is asked.
struct Player<'a> {
    built: &'a dyn Built,
    rays: Cow<'a, [Ray]>,
    turns: Turns,
}

/// Answers of the largest workload; made once, so that no turn pays for fresh memory.
#[derive(Default)]
pub struct Answers {
    hits: Vec<Option<Hit>>,
    occluded: Vec<bool>,
}

/// Checks everybody, then lets them take turns. To be called in the pool that traces.
///
/// # Errors
/// When one of Boxwood's structures gives a wrong answer.
pub fn measure(
    mesh: &TriangleMesh,
    ready: &[Ready<'_>],
    workload: &Workload,
    question: Question,
    rounds: u32,
    answers: &mut Answers,
) -> Outcome<(Vec<Turns>, Noise)> {
    answers.hits.resize(workload.rays.len(), None);
    answers.occluded.resize(workload.rays.len(), false);
    let mut players = Vec::new();
    for each in ready {
        for &way in each.built.ways() {
            if way.wants_coherence() && !workload.kind.is_coherent() {
                continue;
            }
            players.push(player(mesh, each, way, workload, question, answers)?);
        }
    }
    let mut chains = Vec::new();
    let (wall, own) = (Instant::now(), thread_seconds());
    for _ in 0..rounds {
        chains.push(clock());
        for player in &mut players {
            let seconds = clocked(
                player.built,
                player.turns.way,
                question,
                &player.rays,
                answers,
            );
            let per_ray = seconds * 1e9 / player.rays.len().max(1) as f64;
            // The clock may be too coarse for a few rays.
            player.turns.nanoseconds.push(per_ray.max(1e-3));
        }
    }
    let (least, most) = chains
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(a, b), &x| (a.min(x), b.max(x)));
    let share = (thread_seconds() - own) / wall.elapsed().as_secs_f64().max(1e-9);
    let noise = Noise {
        clock_drift: most / least.max(1e-9) - 1.0,
        waited: (rayon::current_num_threads() == 1).then_some((1.0 - share).max(0.0)),
    };
    let turns = players.into_iter().map(|player| player.turns);
    Ok((turns.collect(), noise))
}

/// Chooses a contestant's rays, checks its answers and counts its steps.
fn player<'a>(
    mesh: &TriangleMesh,
    each: &'a Ready<'_>,
    way: Way,
    workload: &'a Workload,
    question: Question,
    answers: &mut Answers,
) -> Outcome<Player<'a>> {
    let built = &*each.built;
    let (rays, expected) = share(built, way, workload, question, answers);
    ask(built, way, question, &rays, answers);
    let (hits, occluded) = (&answers.hits[..rays.len()], &answers.occluded[..rays.len()]);
    let mut turns = Turns {
        contestant: each.name.clone(),
        way,
        own: built.own().is_some(),
        rays_asked: rays.len(),
        nanoseconds: Vec::new(),
        nodes_per_ray: None,
        leaves_per_ray: None,
        primitives_per_ray: None,
        disagreements: Disagreements::default(),
    };
    if built.is_exact() {
        let wrong = (0..rays.len()).find(|&i| match question {
            Question::Closest => bits(hits[i]) != bits(expected[i]),
            Question::Occluded => occluded[i] != expected[i].is_some(),
        });
        if let Some(i) = wrong {
            return Err(failed(format!(
                "{} answers ray {i} of {} wrongly ({question}, {way}); this is a fault of Boxwood, please report it",
                each.name, workload.kind
            )));
        }
    } else {
        turns.disagreements = match question {
            Question::Closest => judge::closest(mesh, &rays, &expected, hits),
            Question::Occluded => judge::occluded(mesh, &rays, &expected, occluded),
        };
    }
    if let Some(own) = built.own() {
        // The steps of a single ray; batches take the same or others.
        if way == Way::Single {
            let mut stats = TraversalStats::default();
            for ray in &*rays {
                match question {
                    Question::Closest => drop(own.closest_hit_counted(ray, &mut stats)),
                    Question::Occluded => drop(own.occluded_counted(ray, &mut stats)),
                }
            }
            let per_ray = |steps: u64| Some(steps as f64 / rays.len().max(1) as f64);
            turns.nodes_per_ray = per_ray(stats.nodes);
            turns.leaves_per_ray = per_ray(stats.leaves);
            turns.primitives_per_ray = per_ray(stats.primitives);
        }
    }
    Ok(Player { built, rays, turns })
}

/// All rays with their answers, or blocks of them for a slow peer.
fn share<'a>(
    built: &dyn Built,
    way: Way,
    workload: &'a Workload,
    question: Question,
    answers: &mut Answers,
) -> (Cow<'a, [Ray]>, Cow<'a, [Option<Hit>]>) {
    let n = workload.rays.len();
    if built.own().is_none() && n > PROBE {
        let probe = blocks(&workload.rays, PROBE);
        // The first time, caches are cold.
        ask(built, way, question, &probe, answers);
        let seconds = clocked(built, way, question, &probe, answers);
        let fits = (TURN / seconds.max(1e-9) * probe.len() as f64) as usize;
        if fits < n {
            let fits = fits.max(PROBE);
            return (
                blocks(&workload.rays, fits).into(),
                blocks(&workload.expected, fits).into(),
            );
        }
    }
    (
        Cow::Borrowed(&workload.rays),
        Cow::Borrowed(&workload.expected),
    )
}

/// About `wanted` of the elements, in blocks from all over.
fn blocks<T: Copy>(all: &[T], wanted: usize) -> Vec<T> {
    let count = all.len().div_ceil(BLOCK);
    let chosen = wanted.div_ceil(BLOCK).clamp(1, count.max(1));
    let block = |i: usize| all.chunks(BLOCK).nth(i * count / chosen).unwrap_or(&[]);
    (0..chosen).flat_map(|i| block(i).iter().copied()).collect()
}

/// The seconds of one turn: of this thread where it is alone, of the wall's clock where there are several.
fn clocked(
    built: &dyn Built,
    way: Way,
    question: Question,
    rays: &[Ray],
    answers: &mut Answers,
) -> f64 {
    if rayon::current_num_threads() == 1 {
        let start = thread_seconds();
        ask(built, way, question, rays, answers);
        thread_seconds() - start
    } else {
        let start = Instant::now();
        ask(built, way, question, rays, answers);
        start.elapsed().as_secs_f64()
    }
}

/// One turn. Peers run with flush-to-zero, Boxwood as its users do.
fn ask(built: &dyn Built, way: Way, question: Question, rays: &[Ray], answers: &mut Answers) {
    let hits = &mut answers.hits[..rays.len()];
    let occluded = &mut answers.occluded[..rays.len()];
    let closest = |rays: &[Ray], hits: &mut [Option<Hit>]| {
        let _flush = built.own().is_none().then(FlushToZero::new);
        built.closest(way, rays, hits);
    };
    let any = |rays: &[Ray], occluded: &mut [bool]| {
        let _flush = built.own().is_none().then(FlushToZero::new);
        built.occluded(way, rays, occluded);
    };
    // A batch of Boxwood's uses the threads of the pool by itself.
    let alone = rayon::current_num_threads() == 1 || way == Way::Batch;
    match question {
        Question::Closest if alone => closest(rays, hits),
        Question::Closest => rays
            .par_chunks(TASK)
            .zip(hits.par_chunks_mut(TASK))
            .for_each(|(rays, hits)| closest(rays, hits)),
        Question::Occluded if alone => any(rays, occluded),
        Question::Occluded => rays
            .par_chunks(TASK)
            .zip(occluded.par_chunks_mut(TASK))
            .for_each(|(rays, occluded)| any(rays, occluded)),
    }
}

/// A hit's bits: `-0` is not `0` here.
fn bits(hit: Option<Hit>) -> Option<[u32; 5]> {
    hit.map(|h| {
        let [t, u, v] = [h.t, h.u, h.v].map(f32::to_bits);
        [t, u, v, h.primitive, h.instance]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::{Contestant, Subject};
    use boxwood::StructureKind;
    use boxwood_scene::builtin;

    #[test]
    fn blocks_come_from_all_over() {
        let all: Vec<usize> = (0..10_000).collect();
        let some = blocks(&all, 1000);
        assert_eq!(some.len(), 1024);
        assert_eq!((some[0], some[255], some[256]), (0, 255, 2560));
        assert_eq!(blocks(&all, 20_000), all);
        assert!(blocks(&[0_u8; 0], 5).is_empty());
    }

    #[test]
    fn own_structures_agree_however_asked() {
        let mesh = builtin::by_name("soup:500").expect("it exists");
        let mesh = mesh.flatten().expect("a good scene").mesh;
        let subject = Subject::new(mesh);
        let reference = StructureKind::default().build(&subject.mesh);
        let rays: Vec<Ray> = (0..300)
            .map(|i| Ray::new([0.0; 3], [i as f32 - 150.0, 20.0, 100.0]))
            .collect();
        let workload = Workload::new(Kind::Tile, rays, &subject.mesh, &*reference).expect("right");
        let finished = Contestant::Boxwood(StructureKind::default()).build(&subject, 1);
        let ready = [Ready {
            name: "own".to_string(),
            built: finished.expect("no limits").built,
        }];
        for question in Question::ALL {
            let mut answers = Answers::default();
            let turns = measure(&subject.mesh, &ready, &workload, question, 3, &mut answers);
            let (turns, noise) = turns.expect("all agree");
            assert!(noise.clock_drift >= 0.0 && noise.waited.is_none_or(|w| w <= 1.0));
            assert_eq!(turns.len(), 2);
            assert!(
                turns
                    .iter()
                    .all(|t| t.nanoseconds.len() == 3 && t.rays_asked == 300)
            );
            assert!(turns[0].nodes_per_ray.is_some_and(|n| n > 0.0));
        }
    }
}
