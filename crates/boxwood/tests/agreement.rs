//! Every structure returns the bits of the judge, and the judge is right.

use boxwood::{BruteForce, Intersect, MollerTrumbore, Ray, TriangleMesh};
use boxwood_testkit::agreement::{self, Compared};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::scenes::SCENES;
use boxwood_testkit::{Random, Spheres, effort, oracle, soups};

/// Scenes that nothing can hit, that rays meet by luck only, or whose products leave the floats: everything misses.
const BARREN: [&str; 4] = ["empty", "any floats", "random, 1e-30", "mixed sizes, 1e30"];
/// Kinds of rays of which most miss by design.
const BLIND: [&str; 3] = ["in the plane", "special values", "turned round"];

fn rays_each() -> usize {
    effort(5)
}

#[test]
fn triangles_agree() {
    for (number, (name, make)) in SCENES.into_iter().enumerate() {
        let mut found = Compared::default();
        for (round, triangles) in [12, 300].into_iter().enumerate() {
            let seed = 10 * number as u64 + round as u64;
            let mut random = Random::new(seed);
            let mesh = make(triangles, &mut random).mesh();
            let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh));
            for (kind, of_kind) in KINDS {
                let rays = sample(of_kind, rays_each(), &targets, &judge, &mut random);
                let case = format!("scene `{name}`, seed {seed}, rays `{kind}`");
                let compared = agreement::check(&mesh, &rays, &case);
                found.rays += compared.rays;
                found.hits += compared.hits;
            }
        }
        let enough = BARREN.contains(&name) || 10 * found.hits > found.rays;
        assert!(enough, "scene `{name}` tests nothing: {found:?}");
    }
}

#[test]
fn every_kind_of_ray_hits() {
    let mut random = Random::new(1);
    let mesh = soups::random(300, &mut random).mesh();
    let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh));
    for (kind, of_kind) in KINDS {
        let rays = sample(of_kind, 200, &targets, &judge, &mut random);
        let hits = rays.iter().filter(|ray| judge.occluded(ray)).count();
        let least = if BLIND.contains(&kind) { 20 } else { 80 };
        assert!(
            hits > least,
            "rays `{kind}` test nothing: {hits} hits of 200"
        );
    }
}

#[test]
fn moller_trumbore_agrees_with_its_own_judge() {
    for (number, (name, make)) in SCENES.into_iter().enumerate() {
        let seed = 1000 + number as u64;
        let mut random = Random::new(seed);
        let mesh = MollerTrumbore(make(60, &mut random).mesh());
        let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh.0));
        for (kind, of_kind) in KINDS {
            let rays = sample(of_kind, rays_each() / 2, &targets, &judge, &mut random);
            let case = format!("Möller-Trumbore, scene `{name}`, seed {seed}, rays `{kind}`");
            agreement::check(&mesh, &rays, &case);
        }
    }
}

/// A primitive of the user's own, with two hits each, masks and movement.
#[test]
fn spheres_agree() {
    let mut found = Compared::default();
    for seed in 0..6 {
        let mut random = Random::new(seed);
        let spheres = Spheres::random(80, seed % 2 == 0, &mut random);
        let (judge, targets) = (BruteForce::new(&spheres), Targets::of_boxes(&spheres));
        for (kind, of_kind) in KINDS {
            let rays = sample(of_kind, rays_each(), &targets, &judge, &mut random);
            let case = format!("spheres, seed {seed}, rays `{kind}`");
            let compared = agreement::check(&spheres, &rays, &case);
            found.rays += compared.rays;
            found.hits += compared.hits;
        }
    }
    assert!(3 * found.hits > found.rays, "tests nothing: {found:?}");
}

/// Sizes and directions just within and just beyond those for which the slack is proven, in all combinations.
#[test]
fn all_agree_at_the_doors() {
    let mut hits = 0;
    for (i, size) in [-41, -30, -21, -20, -19, -18, 0, 20, 31, 36, 38, 41]
        .into_iter()
        .enumerate()
    {
        for (k, length) in [-42, -38, -20, 0, 20, 30, 34, 35, 36, 37, 42]
            .into_iter()
            .enumerate()
        {
            let seed = (100 * i + k) as u64;
            let mut random = Random::new(seed);
            let speck = 2.0_f32.powi(-17 - random.below(4) as i32);
            let specks = soups::specks(60, speck, &mut random);
            let model = soups::slivers(40, &mut random).with(&specks);
            let mesh = model.placed(2.0_f32.powi(size), 0.0).mesh();
            let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh));
            let by = 2.0_f32.powi(length - size);
            let mut rays = Vec::new();
            for (_, of_kind) in &KINDS[..6] {
                for _ in 0..effort(2) {
                    let ray = of_kind(&targets, &mut random);
                    let ray = Ray::new(ray.origin, ray.direction * by);
                    rays.push(ray);
                    // Intervals that end or begin at a hit: boxes must not be passed over by a hair.
                    let hits = judge.all_hits(&ray);
                    rays.extend(hits.iter().take(2).map(|hit| ray.until(hit.t)));
                    rays.extend(hits.iter().take(2).map(|hit| ray.from(hit.t)));
                }
            }
            let case = format!("doors, size 2^{size}, direction 2^{length}, seed {seed}");
            hits += agreement::check(&mesh, &rays, &case).hits;
        }
    }
    assert!(hits > 500, "{hits}");
}

/// Large enough that builders really work side by side.
#[test]
fn a_large_mesh_agrees() {
    let mut random = Random::new(7);
    let mesh = soups::mixed_sizes(9_000, &mut random)
        .with(&soups::random(9_000, &mut random))
        .mesh();
    let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh));
    for (kind, of_kind) in KINDS {
        let rays = sample(of_kind, effort(3), &targets, &judge, &mut random);
        agreement::check(&mesh, &rays, &format!("large mesh, rays `{kind}`"));
    }
}

/// The judge against double precision, wherever double precision is sure.
#[test]
fn the_judge_is_right() {
    // At these sizes nothing leaves the normal floats, which is what the bounds take for granted.
    let tame = |name: &str| !["any floats", "random, 1e-30", "mixed sizes, 1e30"].contains(&name);
    let (mut asked, mut sure, mut same, mut worst) = (0, 0, 0, 0.0_f64);
    for (number, (name, make)) in SCENES.into_iter().enumerate() {
        if !tame(name) {
            continue;
        }
        let seed = 2000 + number as u64;
        let mut random = Random::new(seed);
        let mesh = make(120, &mut random).mesh();
        let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh));
        for (kind, of_kind) in KINDS {
            if ["special values", "tiny and huge directions"].contains(&kind) {
                continue;
            }
            for i in 0..2 * rays_each() {
                // The oracle knows no interval.
                let ray = of_kind(&targets, &mut random)
                    .from(0.0)
                    .until(f32::INFINITY);
                if ray.direction.length_squared() == 0.0 {
                    continue;
                }
                let case = || format!("scene `{name}`, seed {seed}, rays `{kind}`, {i}: {ray:?}");
                let found = judge.closest_hit(&ray);
                if let Some(flaw) = oracle::contradicts(&mesh, &ray, found) {
                    panic!("{flaw}; {}", case());
                }
                asked += 1;
                for hit in judge.all_hits(&ray) {
                    let triangle = mesh.triangle(hit.primitive as usize);
                    let off = oracle::distance_over_bound(triangle, &ray, &hit);
                    assert!(off <= 1.0, "{off} times the bound: {hit:?}, {}", case());
                    worst = worst.max(off);
                }
                if let Some(nearest) = nearest(&mesh, &ray) {
                    sure += 1;
                    same += usize::from(found.is_some_and(|hit| hit.primitive == nearest));
                }
            }
        }
    }
    // Ties, and doubtful triangles in front of a sure one, are frequent by design.
    assert!(
        3 * sure > asked,
        "{sure} of {asked} rays meet something for certain"
    );
    assert!(10 * same > 7 * sure, "{same} of {sure} the same");
    assert!(worst > 0.01, "the bound of {worst} is no bound");
}

/// The triangle that is nearest for certain.
fn nearest(mesh: &TriangleMesh, ray: &Ray) -> Option<u32> {
    let met = |i: usize| match oracle::verdict(mesh.triangle(i), ray) {
        oracle::Verdict::Met(from, to) if from >= 0.0 => Some((from + to, i as u32)),
        _ => None,
    };
    let met = (0..mesh.triangles().len()).filter_map(met);
    met.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}
