//! Callers whose threads flush subnormal numbers to zero, or round otherwise, get the same trees and the same bits.

use boxwood::accel::bvh::refine;
use boxwood::{
    BinaryTree, BinnedSah, BruteForce, Closest, EqualCounts, Hit, Intersect, Lbvh, Median, Middle,
    Ploc, Query, Ray, SpatialSplit, StructureKind, SweepSah, Traverse, TriangleMesh, Vec3,
};
use boxwood_testkit::agreement;
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Model, Random, effort, shapes, soups, structures};
use rayon::{ThreadPool, ThreadPoolBuilder};

type Bits = Option<[u32; 4]>;

fn bits(hit: Option<Hit>) -> Bits {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive])
}

#[allow(unsafe_code, reason = "to set a mode is a promise")]
fn carelessly(work: impl FnOnce()) -> bool {
    // SAFETY: all floats of these tests are computed behind the doors of the library, or compared.
    unsafe { boxwood::carelessly(work) }
}

/// Whether this machine has another mode at all.
fn has_modes() -> bool {
    carelessly(|| {})
}

/// Runs `work` in a careless mode, which it has to leave as it was.
fn careless<R>(work: impl FnOnce() -> R) -> R {
    let mut done = None;
    let left_alone = carelessly(|| done = Some(work()));
    assert!(left_alone || !has_modes(), "the caller's mode was changed");
    done.expect("it ran")
}

/// Threads that are all in a careless mode.
fn careless_pool() -> ThreadPool {
    ThreadPoolBuilder::new()
        .num_threads(3)
        .spawn_handler(|thread| {
            std::thread::spawn(|| careless(|| thread.run()));
            Ok(())
        })
        .build()
        .expect("the system gives threads")
}

/// Meshes whose coordinates, distances or weights come near the subnormal numbers.
fn models(random: &mut Random) -> Vec<(&'static str, Model)> {
    let mut models = vec![
        ("any floats", soups::any_floats(40, random)),
        (
            "needles",
            soups::needles(20, random).with(&soups::slivers(40, random)),
        ),
    ];
    for (name, scale) in [("1e-20", 1.0e-20), ("1e-37", 1.0e-37), ("1e-41", 1.0e-41)] {
        let soup = soups::random(30, random).with(&soups::slivers(20, random));
        models.push((name, soup.with(&shapes::sphere(6, 5)).placed(scale, 0.0)));
    }
    // Features of 1e-22 in a scene of size 1: rays that begin among them have subnormal products.
    let specks = soups::random(50, random).placed(1.0e-22, 0.0);
    models.push(("specks", specks.with(&shapes::cube(2))));
    models
}

fn rays(mesh: &TriangleMesh, random: &mut Random) -> Vec<Ray> {
    let (judge, targets) = (BruteForce::new(mesh), Targets::of_mesh(mesh));
    let mut rays = Vec::new();
    for (_, kind) in KINDS {
        rays.extend(sample(kind, effort(2), &targets, &judge, random));
    }
    // Near the origin, where the small things are; directions as small as they, and a bundle that runs together.
    for i in 0..effort(24) {
        let size = 10.0_f32.powi(-20 - (i % 22) as i32);
        let towards = random.direction() * random.pick(&[1.0, size, 1.0 / size.max(1.0e-36)]);
        rays.push(Ray::new(random.in_cube() * size, towards));
    }
    let eye = Vec3::new(0.3, 0.2, 2.0) * targets_size(mesh);
    rays.extend((0..64).map(|_| {
        let aside = random.in_cube() * (0.2 * eye.length());
        Ray::new(eye, aside - eye)
    }));
    rays
}

fn targets_size(mesh: &TriangleMesh) -> f32 {
    let of = |p: &Vec3| p.abs().max_element();
    mesh.positions().iter().map(of).fold(0.0, f32::max)
}

/// Whatever is asked of whatever structure, single rays, batches and packets, by one thread and by others.
#[test]
fn every_structure_answers_the_same() {
    let (mut differ_without, mut hits) = (0, 0);
    let pool = careless_pool();
    for (name, model) in models(&mut Random::new(1)) {
        let mesh = model.mesh();
        let rays = rays(&mesh, &mut Random::new(2));
        let judge = BruteForce::new(&mesh);
        let expected: Vec<Bits> = rays.iter().map(|r| bits(judge.closest_hit(r))).collect();
        hits += expected.iter().flatten().count();
        // Rays for which the mode counts: the loop itself does not look at it.
        let raw = careless(|| {
            let answer = |ray: &Ray| {
                let mut query = Closest::new(ray);
                judge.traverse(ray, &mut query, &mut ());
                bits(query.hit())
            };
            rays.iter().map(answer).collect::<Vec<_>>()
        });
        differ_without += raw.iter().zip(&expected).filter(|(a, b)| a != b).count();

        careless(|| {
            let built_so = BruteForce::new(&mesh);
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(
                    bits(built_so.closest_hit(ray)),
                    *expected,
                    "{name}: {ray:?}"
                );
            }
            agreement::check(&mesh, &rays, name);
        });
        pool.install(|| {
            for entry in structures::all().filter(|entry| entry.threads().is_none()) {
                let structure = structures::over_mesh(entry.kind(), &mesh);
                let mut closest = vec![None; rays.len()];
                let mut occluded = vec![false; rays.len()];
                structure.closest_hits(&rays, &mut closest);
                structure.occluded_each(&rays, &mut occluded);
                for i in 0..rays.len() {
                    let case = || format!("{}, {name}: {:?}", entry.name(), rays[i]);
                    assert_eq!(bits(closest[i]), expected[i], "{}", case());
                    assert_eq!(occluded[i], expected[i].is_some(), "{}", case());
                }
            }
        });
    }
    assert!(hits > 300, "{hits} hits test nothing");
    assert!(
        differ_without > 100 || !has_modes(),
        "the mode counts for {differ_without} rays only: this tests nothing"
    );
}

/// On careless threads of a pool too, of which each part of a large tree may be built by another.
#[test]
fn every_builder_makes_the_same() {
    let mut random = Random::new(3);
    let mesh = soups::random(28_000, &mut random)
        .placed(2.0e-38, 0.0)
        .with(&soups::mixed_sizes(6_000, &mut random).placed(1.0e-36, 0.0))
        .mesh();
    let pool = careless_pool();
    let refined = || {
        let mut tree = Ploc::default().build(&mesh);
        refine::rotation(&mut tree, 1);
        refine::reinsertion(&mut tree, 1);
        refine::collapse_leaves(&mut tree, 4);
        refine::refit(&mut tree, &mesh);
        tree
    };
    let builders: [(&str, &(dyn Fn() -> BinaryTree + Sync)); 9] = [
        ("median", &|| Median::default().build(&mesh)),
        ("middle", &|| Middle::default().build(&mesh)),
        ("equal", &|| EqualCounts::default().build(&mesh)),
        ("sweep", &|| SweepSah::default().build(&mesh)),
        ("binned", &|| BinnedSah::default().build(&mesh)),
        ("lbvh", &|| Lbvh::default().build(&mesh)),
        ("ploc", &|| Ploc::default().build(&mesh)),
        ("sbvh", &|| SpatialSplit::default().build(&mesh)),
        ("refined", &refined),
    ];
    for (name, build) in builders {
        let expected = build();
        assert!(careless(build) == expected, "{name}, careless caller");
        assert!(pool.install(build) == expected, "{name}, careless threads");
    }
    for kind in ["grid", "grid2", "octree", "kd:sah", "kd:lecture", "wide8"] {
        let kind: StructureKind = kind.parse().expect("it exists");
        let build = || format!("{:?}", structures::over_mesh(kind, &mesh).statistics());
        let expected = build();
        assert_eq!(careless(build), expected, "{kind}, careless caller");
        assert_eq!(pool.install(build), expected, "{kind}, careless threads");
    }
}

/// A whole frame within `exactly`, through the loop that does not look: the judge's bits.
#[test]
fn the_loop_itself_may_be_asked_exactly() {
    let mut random = Random::new(4);
    let mesh = soups::random(50, &mut random).placed(1.0e-20, 0.0).mesh();
    let judge = BruteForce::new(&mesh);
    let rays = rays(&mesh, &mut random);
    let ask = || -> Vec<Bits> {
        let mut queries: Vec<_> = rays.iter().map(Closest::new).collect();
        judge.traverse_each(&rays, &mut queries, &mut ());
        queries.into_iter().map(|q| bits(q.hit())).collect()
    };
    let expected = ask();
    let hits = expected.iter().flatten().count();
    assert!(hits > 5, "{hits} hits test nothing");
    assert_eq!(careless(|| boxwood::exactly(ask)), expected);
}

/// A question of one's own that panics: the caller's mode is back.
#[test]
fn panics_leave_the_mode_alone() {
    let mesh = shapes::cube(1).mesh();
    let judge = BruteForce::new(&mesh);
    let ray = Ray::new([0.1, 0.2, 5.0], [0.0, 0.0, -1.0]);
    careless(|| {
        let asked = std::panic::catch_unwind(|| {
            judge.closest_hit_where(&ray, &mut |_| panic!("on purpose"));
        });
        assert!(asked.is_err());
        let mut query = Closest::new(&ray);
        judge.traverse(&ray, &mut query, &mut ());
        assert!(query.t_max() < 5.0);
    });
}
