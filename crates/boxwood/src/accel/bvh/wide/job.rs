//! Which quality makes building and tracing together shortest, told before anything is built.
//!
//! *How it works.* A [`Survey`] looks once at every primitive. From what it finds a [`Forecast`] follows for each quality: what the
//! build takes, what it keeps, and what a ray takes. A [`Job`] says how many rays there are to come and what may be spent, and
//! takes the quality whose build and rays together are shortest.
//!
//! Times are *nominal*: formulas whose constants were measured once ([`COSTS`]). Nobody looks at a clock, so the same job makes the
//! same choice, and the same tree, on every machine; on a slower one builds and rays both take longer, and the choice hardly changes.
//!
//! *Cost.* O(n), a few nanoseconds a primitive.
//!
//! *Source.* The expected number of boxes that a line meets is that of the surface-area heuristic (Goldsmith & Salmon 1987).

use super::leaf::Leaves;
use super::node::Node;
use super::{Quality, WideBvh, WideSah};
use crate::accel::sah::half_area;
use crate::accel::{BuildError, Limits};
use crate::geometry::Aabb;
use crate::math;
use crate::pieces;
use crate::primitive::Primitives;
use crate::simd::{Level, Vectorize, exactly};

/// What a tree is built for.
///
/// ```
/// use boxwood::{Intersect, Job, Quality, Ray, Survey, TriangleMesh, WideSah};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
/// let job = Job { rays: 1_000_000, seconds: Some(0.5), threads: 2, ..Job::default() };
/// let bvh = WideSah::<8>::build_for(&mesh, &job).expect("there is no limit of memory");
/// assert!(bvh.occluded(&Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0])));
///
/// // What the choice was made by.
/// let survey = Survey::of(&mesh);
/// let forecast = job.plan::<8>(&survey);
/// assert!(forecast.build_seconds <= 0.5);
/// assert!(forecast.total(&job) <= Quality::Ultra.forecast::<8>(&survey, 2).total(&job));
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job {
    /// How many single rays will be traced.
    pub rays: u64,
    /// The most nominal seconds that building should take. Where no quality is that quick, the quickest is taken.
    pub seconds: Option<f64>,
    /// The most bytes that building may take, as in [`Limits::memory`]. Where no quality is expected to need so little, the one
    /// that needs least is tried.
    pub bytes: Option<usize>,
    /// How many threads build and trace, at least 1. Part of the job and not looked up: choices do not depend on the machine.
    pub threads: usize,
}

impl Default for Job {
    /// A million rays by one thread, without limits.
    fn default() -> Self {
        Self {
            rays: 1_000_000,
            seconds: None,
            bytes: None,
            threads: 1,
        }
    }
}

impl Job {
    /// The forecast of the quality that is done first, among those that keep within what may be spent.
    pub fn plan<const N: usize>(&self, survey: &Survey) -> Forecast {
        let all = Quality::ALL.map(|quality| quality.forecast::<N>(survey, self.threads));
        // The first of equal ones: it builds faster.
        let least = |of: &dyn Fn(&Forecast) -> f64, among: &dyn Fn(&Forecast) -> bool| {
            let found = all.iter().filter(|forecast| among(forecast));
            found.min_by(|a, b| of(a).total_cmp(&of(b))).copied()
        };
        let fits = |f: &Forecast| self.bytes.is_none_or(|bytes| f.peak_bytes <= bytes);
        let in_time = |f: &Forecast| self.seconds.is_none_or(|most| f.build_seconds <= most);
        let soonest = least(&|f| f.total(self), &|f| fits(f) && in_time(f));
        soonest
            .or_else(|| least(&|f| f.build_seconds, &fits))
            .or_else(|| least(&|f| f.peak_bytes as f64, &|_| true))
            .unwrap_or(all[0])
    }
}

/// What a forecast goes by: found once for any number of forecasts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Survey {
    /// How many primitives there are.
    pub primitives: usize,
    /// Whether they lie in leaves as triangles.
    pub triangles: bool,
    /// Whether they are made of others, as placed objects are: then each has a leaf of its own.
    pub composite: bool,
    /// How many of the primitives' boxes a random line meets that meets the box around everything.
    pub boxes_met: f64,
    /// How many of the primitives, as far as triangles are concerned; of others, as many as boxes.
    pub primitives_met: f64,
}

/// So many primitives are added up by one thread; the sum does not depend on the threads.
const CHUNK: usize = 1 << 15;

impl Survey {
    /// Looks at every primitive once.
    pub fn of<P: Primitives + Sync>(primitives: &P) -> Self {
        exactly(|| Self::taken(primitives))
    }

    fn taken<P: Primitives + Sync>(primitives: &P) -> Self {
        let count = primitives.len();
        let some = |chunk: usize| {
            let (mut around, mut boxes, mut own) = (Aabb::EMPTY, 0.0, 0.0);
            for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                let bounds = primitives.bounds(i);
                let area = half_area(&bounds);
                around = around.union(bounds);
                boxes += area;
                own += match primitives.corners(i) {
                    Some([a, b, c]) => 0.5 * f64::from((b - a).cross(c - a).length()),
                    None => area,
                };
            }
            (around, boxes, own)
        };
        let chunks = pieces::each(count.div_ceil(CHUNK), some);
        let (mut around, mut boxes, mut own) = (Aabb::EMPTY, 0.0, 0.0);
        for chunk in chunks {
            around = around.union(chunk.0);
            (boxes, own) = (boxes + chunk.1, own + chunk.2);
        }
        // A flat scene has an area too; what is infinite or no number tells nothing.
        let share = |sum: f64| {
            let share = sum / half_area(&around);
            if share.is_finite() { share } else { 0.0 }
        };
        let boxes_met = share(boxes);
        Self {
            primitives: count,
            triangles: P::TRIANGLES,
            composite: P::COMPOSITE,
            boxes_met,
            primitives_met: share(own).min(boxes_met),
        }
    }
}

/// So many boxes must be entered in vain for spatial splits to pay: they spare some of these, but their upper nodes suit long random
/// lines more than rays that stay near some small thing.
const IN_VAIN: f64 = 5.0;

impl Survey {
    /// Whether primitives are so long that cutting them is worth more than it costs.
    pub(super) fn splits_pay(&self) -> bool {
        self.boxes_met - self.primitives_met > IN_VAIN
    }
}

/// What a quality is expected to take for some primitives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Forecast {
    /// The quality.
    pub quality: Quality,
    /// Nominal seconds that building takes.
    pub build_seconds: f64,
    /// Nominal seconds that one thread takes for a single ray, as the mean over camera, shadow, ambient, bounced and random rays.
    pub ray_seconds: f64,
    /// Bytes in use at the worst moment of building, without the primitives: with so much as [`Limits::memory`] a build ends well,
    /// and with two thirds of it does not.
    pub peak_bytes: usize,
    /// Bytes of the finished tree.
    pub resident_bytes: usize,
}

impl Forecast {
    /// Nominal seconds for all of a job, whose rays are shared among its threads.
    pub fn total(&self, job: &Job) -> f64 {
        self.build_seconds + job.rays as f64 * self.ray_seconds / job.threads.max(1) as f64
    }

    /// From how many rays on the other one is done first; `None` where it never is, or always.
    pub fn overtaken_by(&self, other: &Self, threads: usize) -> Option<f64> {
        let later = other.build_seconds - self.build_seconds;
        let saved = (self.ray_seconds - other.ray_seconds) / threads.max(1) as f64;
        (later > 0.0 && saved > 0.0).then(|| later / saved)
    }
}

/// What a quality costs.
struct Cost {
    /// Nanoseconds for each primitive, and for each primitive and halving of their number.
    build: [f64; 2],
    /// The share of the build that one thread does alone.
    alone: f64,
    /// The time of a ray over that in a tree of the default quality.
    ray: f64,
    /// The share of that time that is spared for each box that a line enters in vain.
    spared: f64,
    /// Blocks of leaves, and nodes of 8 children, for each primitive.
    blocks: f64,
    nodes: f64,
}

/// Of one thread of the machine of `docs/decisions/0012-presets.md`, in the order of [`Quality::ALL`]; the last row is of scenes where
/// splits pay. The shares that one thread does alone are estimates.
const COSTS: [Cost; 4] = [
    Cost {
        build: [265.0, 9.0],
        alone: 0.1,
        ray: 1.16,
        spared: 0.0,
        blocks: 0.33,
        nodes: 0.053,
    },
    Cost {
        build: [410.0, 14.0],
        alone: 0.1,
        ray: 1.0,
        spared: 0.0,
        blocks: 0.31,
        nodes: 0.046,
    },
    Cost {
        build: [1200.0, 37.0],
        alone: 0.3,
        ray: 1.0,
        spared: 0.004,
        blocks: 0.315,
        nodes: 0.047,
    },
    Cost {
        build: [5000.0, 183.0],
        alone: 0.2,
        ray: 1.0,
        spared: 0.008,
        blocks: 0.335,
        nodes: 0.05,
    },
];

/// Nanoseconds of a ray among few primitives, a line through which meets one box.
const RAY: f64 = 25.8;
/// With which powers they grow: with the boxes that a line meets, and with the number of primitives.
const BOXES: f64 = 0.33;
const PRIMITIVES: f64 = 0.18;
/// What 16 children take instead of 8: time of a ray, and bytes of nodes, which are less full.
const SIXTEEN: [f64; 2] = [0.83, 1.15];
/// At least so much of a ray's time is left, whatever is spared.
const LEAST: f64 = 0.75;

impl Quality {
    /// What a wide tree of `N` children takes in this quality, other settings being the default ones.
    pub fn forecast<const N: usize>(self, survey: &Survey, threads: usize) -> Forecast {
        let made_as = match self {
            Self::Ultra if !survey.splits_pay() => Self::High,
            _ => self,
        };
        let cost = &COSTS[made_as as usize];
        let [time, size] = if N == 16 { SIXTEEN } else { [1.0, 1.0] };
        let count = survey.primitives as f64;
        let halvings = math::log2(count.max(1.0));
        let alone = cost.alone + (1.0 - cost.alone) / threads.max(1) as f64;
        let build = count * (cost.build[0] + cost.build[1] * halvings) * alone;
        let blocks = cost.blocks * Leaves::block_bytes(survey.triangles) as f64;
        let nodes = cost.nodes * size * size_of::<Node<8>>() as f64;
        let in_vain = survey.boxes_met - survey.primitives_met;
        let growth = BOXES * math::log2(survey.boxes_met.max(1.0)) + PRIMITIVES * halvings;
        let ray = RAY * time * math::exp2(growth);
        let ray = ray * (cost.ray - cost.spared * in_vain).max(LEAST);
        Forecast {
            quality: self,
            build_seconds: build * 1e-9,
            ray_seconds: ray * 1e-9,
            peak_bytes: WideSah::<N>::of(self).peak_bytes(survey),
            resident_bytes: (count * (blocks + nodes)) as usize,
        }
    }
}

impl<const N: usize> WideSah<N> {
    /// The builder that is right for a job: of the quality that [`Job::plan`] chooses.
    pub fn for_job<P: Primitives + Sync>(primitives: &P, job: &Job) -> Self {
        Self::of(job.plan::<N>(&Survey::of(primitives)).quality)
    }

    /// What is expected of this builder; `None` where more is set than the quality, the instruction set and the precision.
    pub fn forecast(&self, survey: &Survey, threads: usize) -> Option<Forecast> {
        let preset = Self {
            isa: self.isa,
            precision: self.precision,
            ..Self::of(self.quality)
        };
        (*self == preset).then(|| self.quality.forecast::<N>(survey, threads))
    }

    /// The default settings in a quality.
    fn of(quality: Quality) -> Self {
        Self {
            quality,
            ..Self::default()
        }
    }
}

impl<const N: usize> WideSah<N>
where
    Level: Vectorize<N>,
{
    /// Builds the tree that is right for a job, within the job's memory.
    ///
    /// # Errors
    /// When the build takes more memory than the job allows.
    pub fn build_for<P: Primitives + Sync>(
        primitives: P,
        job: &Job,
    ) -> Result<WideBvh<P, N>, BuildError> {
        let limits = Limits {
            memory: job.bytes,
            ..Limits::NONE
        };
        Self::for_job(&primitives, job).build_within(primitives, &limits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn survey(primitives: usize) -> Survey {
        Survey {
            primitives,
            triangles: true,
            composite: false,
            boxes_met: 20.0,
            primitives_met: 5.0,
        }
    }

    /// The forecasts of all qualities.
    fn all(survey: &Survey) -> [Forecast; 4] {
        Quality::ALL.map(|quality| quality.forecast::<8>(survey, 2))
    }

    #[test]
    fn more_rays_are_worth_more_building() {
        let survey = survey(1 << 20);
        let plans = (0..13).map(|exponent| {
            let job = Job {
                rays: 10_u64.pow(exponent),
                threads: 2,
                ..Job::default()
            };
            let plan = job.plan::<8>(&survey);
            let least = all(&survey).map(|f| f.total(&job));
            let least = least.into_iter().fold(f64::INFINITY, f64::min);
            assert_eq!(plan.total(&job), least);
            plan
        });
        let plans: Vec<Forecast> = plans.collect();
        assert!(plans.is_sorted_by(|a, b| a.build_seconds <= b.build_seconds));
        assert!(plans.is_sorted_by(|a, b| a.ray_seconds >= b.ray_seconds));
        let [first, .., last] = &plans[..] else {
            unreachable!("thirteen plans");
        };
        assert_eq!(last.quality, Quality::Ultra);
        assert_ne!(first.quality, last.quality);
        let crossing = first.overtaken_by(last, 2).expect("more rays do");
        let job = |rays: f64| Job {
            rays: rays as u64,
            threads: 2,
            ..Job::default()
        };
        for (factor, sooner) in [(0.9, first), (1.1, last)] {
            let job = job(factor * crossing);
            assert!(
                [first, last]
                    .iter()
                    .all(|f| f.total(&job) >= sooner.total(&job))
            );
        }
        assert_eq!(last.overtaken_by(first, 2), None);
    }

    #[test]
    fn what_may_be_spent_is_kept_to() {
        let survey = survey(1 << 20);
        let forecasts = all(&survey);
        for forecast in &forecasts {
            let short = Job {
                rays: u64::MAX,
                seconds: Some(forecast.build_seconds),
                threads: 2,
                ..Job::default()
            };
            assert!(short.plan::<8>(&survey).build_seconds <= forecast.build_seconds);
            let small = Job {
                rays: u64::MAX,
                bytes: Some(forecast.peak_bytes),
                threads: 2,
                ..Job::default()
            };
            assert!(small.plan::<8>(&survey).peak_bytes <= forecast.peak_bytes);
        }
        let hopeless = Job {
            seconds: Some(0.0),
            bytes: Some(0),
            ..Job::default()
        };
        let least = forecasts.iter().map(|f| f.peak_bytes).min();
        assert_eq!(Some(hopeless.plan::<8>(&survey).peak_bytes), least);
        let hurried = Job {
            bytes: None,
            threads: 2,
            ..hopeless
        };
        let quickest = forecasts.iter().map(|f| f.build_seconds);
        let quickest = quickest.fold(f64::INFINITY, f64::min);
        assert_eq!(hurried.plan::<8>(&survey).build_seconds, quickest);
    }

    #[test]
    fn nothing_and_numbers_without_end_are_planned_too() {
        for (primitives, met) in [(0, 0.0), (1, 0.0), (usize::MAX >> 12, 1e300)] {
            let survey = Survey {
                boxes_met: met,
                primitives_met: 0.0,
                ..survey(primitives)
            };
            let job = Job {
                threads: 0,
                ..Job::default()
            };
            let plan = job.plan::<16>(&survey);
            assert!(
                plan.total(&job) >= 0.0 && plan.ray_seconds > 0.0,
                "{plan:?}"
            );
        }
    }
}
