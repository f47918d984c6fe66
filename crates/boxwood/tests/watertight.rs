//! No ray leaves a closed mesh through an edge or a vertex.

use boxwood::{
    BinnedSah, BruteForce, Bvh, CompactBvh, Intersect, MollerTrumbore, Ray, Vec3, WideBvh,
};
use boxwood_testkit::{Model, Random, effort, shapes};

/// A closed shape around the origin and a point well inside: a torus holds its own ring, not the origin.
type Closed = (&'static str, Model, Vec3);

fn closed(fineness: u32) -> [Closed; 3] {
    [
        ("sphere", shapes::sphere(2 * fineness, fineness), Vec3::ZERO),
        (
            "torus",
            shapes::torus(2 * fineness, fineness),
            Vec3::new(1.0, 0.0, 0.0),
        ),
        ("cube", shapes::cube(fineness / 2), Vec3::ZERO),
    ]
}

const SCALES: [f32; 3] = [1.0e-3, 1.0, 1.0e6];
/// In units of the scale.
const OFFSETS: [f32; 4] = [0.0, 1.0e3, 1.0e5, 1.0e6];

/// A ray from inside, aimed exactly at a vertex or at a point of an edge, that meets nothing: the first of `count`.
fn leak(case: &Case, count: usize, s: &dyn Intersect) -> Option<Ray> {
    let (model, mut random) = (&case.model, Random::new(case.seed));
    (0..count).find_map(|_| {
        let inside = random.pick(&case.inside);
        let t = random.pick(&model.triangles);
        let [a, b] = [t[0], t[1]].map(|v| Vec3::from(model.positions[v as usize]));
        let anywhere = random.unit();
        let part = random.pick(&[0.0, 0.5, anywhere]);
        let target = a + (b - a) * part;
        // Rays to one target from many places, and of many lengths.
        let ray = Ray::new(inside, target - inside);
        let ray = Ray::new(inside, ray.direction * random.pick(&[1.0, 0.37, 1000.0]));
        s.closest_hit(&ray).is_none().then_some(ray)
    })
}

/// A shape in its place.
struct Case {
    name: String,
    model: Model,
    /// Points inside, so near to the middle that rounding at the offset cannot bring them outside.
    inside: [Vec3; 6],
    seed: u64,
}

/// Every shape at every scale and offset.
fn each(fineness: u32, check: impl Fn(&Case)) {
    for (shape, (name, model, middle)) in closed(fineness).into_iter().enumerate() {
        for (i, scale) in SCALES.into_iter().enumerate() {
            for (k, offset) in OFFSETS.into_iter().enumerate() {
                let seed = (100 * shape + 10 * i + k) as u64;
                let mut random = Random::new(seed);
                check(&Case {
                    name: format!("{name}, scale {scale:e}, offset {offset:e}, seed {seed}"),
                    model: model.clone().placed(scale, offset),
                    inside: [(); 6].map(|()| {
                        let start = middle + random.in_cube() * 0.1;
                        start.to_array().map(|x| (x + offset) * scale).into()
                    }),
                    seed,
                });
            }
        }
    }
}

#[test]
fn none_escapes_a_hierarchy() {
    each(40, |case| {
        let mesh = case.model.mesh();
        let tree = BinnedSah::default().build(&mesh);
        let wide = WideBvh::<_, 8>::new(&mesh, &tree);
        let found = leak(case, effort(1_000), &wide);
        assert_eq!(found, None, "wide8 leaks, {}", case.name);
        let compact = CompactBvh::of(&mesh, &tree);
        let found = leak(case, effort(1_000), &compact);
        assert_eq!(found, None, "compact leaks, {}", case.name);
        let bvh = Bvh::new(&mesh, tree);
        let found = leak(case, effort(1_000), &bvh);
        assert_eq!(found, None, "bvh:binned leaks, {}", case.name);
    });
}

#[test]
fn none_escapes_the_judge() {
    each(12, |case| {
        let judge = BruteForce::new(case.model.mesh());
        let leak = leak(case, effort(300), &judge);
        assert_eq!(leak, None, "brute leaks, {}", case.name);
    });
}

/// So the tests above can fail.
#[test]
fn moller_trumbore_leaks() {
    let leaky = std::cell::Cell::new(0);
    each(40, |case| {
        let mesh = MollerTrumbore(case.model.mesh());
        let bvh = Bvh::new(&mesh, BinnedSah::default().build(&mesh));
        let leaks = leak(case, 1_000, &bvh).is_some();
        leaky.set(leaky.get() + usize::from(leaks));
    });
    assert!(leaky.get() > 12, "only {leaky:?} of 36 cases leak");
}

/// Where no edge is met, a line through a closed surface crosses it an even number of times,
/// and from inside an odd number.
#[test]
fn crossings_pair_up() {
    let mut random = Random::new(5);
    for (name, model, inside) in closed(24) {
        let mesh = model.mesh();
        let bvh = Bvh::new(&mesh, BinnedSah::default().build(&mesh));
        for _ in 0..effort(500) {
            let start = inside + random.in_cube() * 0.1;
            let ray = Ray::new(start, random.direction());
            let hits = bvh.all_hits(&ray);
            // A hit on an edge counts for each of its triangles.
            let on_edge = |h: &boxwood::Hit| h.u.min(h.v).min(1.0 - h.u - h.v) < 1.0e-6;
            if !hits.iter().any(on_edge) {
                assert_eq!(hits.len() % 2, 1, "{name}: {ray:?} meets {hits:?}");
            }
        }
    }
}
