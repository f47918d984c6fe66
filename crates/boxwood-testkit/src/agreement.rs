//! Every structure returns the bits of the judge, however it is asked.

use crate::structures;
use boxwood::{Aabb, BruteForce, Hit, Intersect, Primitives, Ray, TraversalStats, exactly};
use std::ops::ControlFlow::Continue;

/// How much was compared: a test that hits nothing tests nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compared {
    /// Rays.
    pub rays: usize,
    /// Rays that hit something.
    pub hits: usize,
}

/// Asks every structure over `primitives` everything about every ray.
///
/// # Panics
/// At the first answer that differs from the judge's by a bit, naming structure, question, `case` and ray.
pub fn check<P: Primitives + Send + Sync>(primitives: &P, rays: &[Ray], case: &str) -> Compared {
    let judged = Judged::new(primitives, rays);
    for entry in structures::all() {
        judged.check(&*entry.build(primitives), &entry.name(), case);
    }
    judged.compared()
}

/// The same of one structure, however it was made.
///
/// # Panics
/// As [`check`].
pub fn check_one<P: Primitives + Send + Sync>(
    structure: &dyn Intersect,
    primitives: &P,
    rays: &[Ray],
    case: &str,
) -> Compared {
    let judged = Judged::new(primitives, rays);
    judged.check(structure, "the structure", case);
    judged.compared()
}

/// What the judge says of some rays, to hold any structure against.
pub struct Judged<'a> {
    rays: &'a [Ray],
    expected: Vec<Expected>,
    bounds: Aabb,
}

impl<'a> Judged<'a> {
    /// Asks the judge.
    pub fn new<P: Primitives + Send + Sync>(primitives: &P, rays: &'a [Ray]) -> Self {
        let judge = BruteForce::new(primitives);
        Self {
            rays,
            expected: rays.iter().map(|ray| Expected::of(&judge, ray)).collect(),
            bounds: Intersect::bounds(&judge),
        }
    }

    /// How much it is.
    pub fn compared(&self) -> Compared {
        Compared {
            rays: self.rays.len(),
            hits: self.expected.iter().filter(|e| !e.all.is_empty()).count(),
        }
    }

    /// Asks a structure over the same primitives everything about every ray.
    ///
    /// # Panics
    /// At the first answer that differs by a bit, naming structure, question, `case` and ray.
    pub fn check(&self, structure: &dyn Intersect, name: &str, case: &str) {
        let rays = self.rays;
        assert_eq!(
            bounds_bits(structure.bounds()),
            bounds_bits(self.bounds),
            "bounds of {name}, {case}"
        );
        let mut closest = vec![None; rays.len()];
        let mut occluded = vec![false; rays.len()];
        structure.closest_hits(rays, &mut closest);
        structure.occluded_each(rays, &mut occluded);
        let mut occluders = vec![None; rays.len()];
        structure.occluders(rays, &mut occluders);
        for (i, (ray, expected)) in rays.iter().zip(&self.expected).enumerate() {
            let question = |what: &str| format!("{what} of {name}, {case}, ray {i}: {ray:?}");
            expected.holds_for(structure, ray, &question);
            let first = expected.all.first().copied();
            assert_eq!(closest[i].map(Bits::of), first, "{}", question("batch"));
            assert_eq!(
                occluded[i],
                first.is_some(),
                "{}",
                question("batch of occlusion")
            );
            let met = || expected.all.iter().map(|Bits(bits)| (bits[4], bits[3]));
            assert!(
                match occluders[i] {
                    Some(occluder) => met().any(|met| met == occluder),
                    None => met().next().is_none(),
                },
                "{}",
                question("occluder")
            );
        }
    }
}

/// A hit as bits, so that `-0.0` and `0.0` differ: t, u, v, primitive, instance.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Bits([u32; 5]);

impl Bits {
    fn of(h: Hit) -> Self {
        let [t, u, v] = [h.t, h.u, h.v].map(f32::to_bits);
        Self([t, u, v, h.primitive, h.instance])
    }
}

impl std::fmt::Debug for Bits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [t, u, v, primitive, instance] = self.0;
        let [t, u, v] = [t, u, v].map(f32::from_bits);
        write!(
            f,
            "t {t:e} u {u:e} v {v:e} primitive {primitive}.{instance}"
        )
    }
}

fn bits(hits: Vec<Hit>) -> Vec<Bits> {
    hits.into_iter().map(Bits::of).collect()
}

fn bounds_bits(b: Aabb) -> [u32; 6] {
    let [[a, b, c], [d, e, f]] = [b.lower, b.upper].map(|p| p.to_array());
    // Zeros of both signs bound the same space.
    [a, b, c, d, e, f].map(|x| if x == 0.0 { 0 } else { x.to_bits() })
}

/// About a third of the hits. By primitive: of one primitive's equal hits, queries keep the first one only.
fn keep(hit: &Hit) -> bool {
    (hit.primitive.wrapping_mul(0x9e37_79b9) >> 16).is_multiple_of(3)
}

/// What the judge says of a ray: everything follows from all of its hits, except what masks and time change.
struct Expected {
    all: Vec<Bits>,
    kept: Option<Bits>,
    seen: [Option<Bits>; 2],
}

const SEEN: [(u32, f32); 2] = [(0b010, 0.5), (0, 0.0)];

impl Expected {
    fn of(judge: &dyn Intersect, ray: &Ray) -> Self {
        let all = judge.all_hits(ray);
        assert!(
            all.iter().all(|h| h.t.is_finite()),
            "hits at no distance: {all:?}, {ray:?}"
        );
        Self {
            kept: all.iter().copied().find(keep).map(Bits::of),
            seen: SEEN.map(|(mask, time)| judge.closest_hit_seen(ray, mask, time).map(Bits::of)),
            all: bits(all),
        }
    }

    fn holds_for(&self, s: &dyn Intersect, ray: &Ray, question: &dyn Fn(&str) -> String) {
        let (all, first) = (&self.all, self.all.first().copied());
        let any = first.is_some();
        let mut stats = TraversalStats::default();
        let same = |found: Option<Hit>, expected, what| {
            assert_eq!(found.map(Bits::of), expected, "{}", question(what));
        };
        same(s.closest_hit(ray), first, "closest hit");
        same(s.closest_hit_counted(ray, &mut stats), first, "counted");
        assert!(stats.primitives > 0 || !any, "{}", question("counts"));
        same(s.closest_hit_where(ray, &mut keep), self.kept, "filtered");
        for ((mask, time), seen) in SEEN.into_iter().zip(self.seen) {
            same(s.closest_hit_seen(ray, mask, time), seen, "masked");
            let found = s.occluded_seen(ray, mask, time);
            assert_eq!(found, seen.is_some(), "{}", question("masked occlusion"));
        }
        let is = |found: bool, expected: bool, what| {
            assert_eq!(found, expected, "{}", question(what));
        };
        is(s.occluded(ray), any, "occlusion");
        is(
            s.occluded_counted(ray, &mut stats),
            any,
            "counted occlusion",
        );
        let found = s.occluded_where(ray, &mut keep);
        is(found, self.kept.is_some(), "filtered occlusion");

        let list = |found: Vec<Hit>, expected: &[Bits], what| {
            assert_eq!(bits(found), expected, "{}", question(what));
        };
        list(s.all_hits(ray), all, "all hits");
        list(
            s.all_hits_counted(ray, &mut stats),
            all,
            "all hits, counted",
        );
        for k in [0, 1, 3] {
            list(s.first_hits(ray, k), &all[..k.min(all.len())], "first hits");
        }
        let mut visited = Vec::new();
        s.visit(ray, &mut |hit| {
            visited.push(hit);
            Continue(f32::INFINITY)
        });
        // Callers in any float mode are tested: hits at subnormal distances have an order.
        exactly(|| {
            visited.sort_by(Hit::order);
            visited.dedup_by(|a, b| a.order(b).is_eq());
        });
        list(visited, all, "visit");
    }
}
