//! Wide trees asked in all three ways, at every level of the machine: the bits of the judge.

use boxwood::{
    AllHits, BruteForce, CompactBvh, CompactSah, Cuboid, Hit, Intersect, Isa, Precision, Query,
    Ray, Shapes, SpatialSplit, Traverse, TriangleMesh, Vec3, WideBvh, WideSah,
};
use boxwood_testkit::{Model, Random, shapes, soups};
use std::ops::ControlFlow::{self, Continue};

/// Asks rays one by one and as a batch, which makes packets of those that run together.
fn check<S: Traverse + Send + Sync>(
    structure: &S,
    judge: &[Option<Hit>],
    rays: &[Ray],
    case: &str,
) {
    let mut hits = vec![None; rays.len()];
    let mut occluded = vec![false; rays.len()];
    structure.closest_hits(rays, &mut hits);
    structure.occluded_each(rays, &mut occluded);
    for (i, (ray, expected)) in rays.iter().zip(judge).enumerate() {
        let bits = |hit: &Option<Hit>| {
            hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive))
        };
        assert_eq!(
            bits(&hits[i]),
            bits(expected),
            "{case}, batch, ray {i}: {ray:?}"
        );
        assert_eq!(
            bits(&structure.closest_hit(ray)),
            bits(expected),
            "{case}, single, ray {i}: {ray:?}"
        );
        assert_eq!(
            occluded[i],
            expected.is_some(),
            "{case}, any, ray {i}: {ray:?}"
        );
        assert_eq!(
            structure.occluded(ray),
            expected.is_some(),
            "{case}, {ray:?}"
        );
    }
}

fn check_all(mesh: &TriangleMesh, rays: &[Ray], case: &str) {
    let judge = BruteForce::new(mesh);
    let mut expected = vec![None; rays.len()];
    judge.closest_hits(rays, &mut expected);
    let cut = SpatialSplit::default().build(mesh);
    for isa in Isa::available() {
        let eight = WideSah::<8> {
            isa,
            ..Default::default()
        }
        .build(mesh);
        let sixteen = WideSah::<16> {
            isa,
            ..Default::default()
        }
        .build(mesh);
        check(&eight, &expected, rays, &format!("{case}, wide8 {isa}"));
        check(&sixteen, &expected, rays, &format!("{case}, wide16 {isa}"));
        let compact = CompactSah {
            isa,
            ..Default::default()
        }
        .build(mesh);
        check(&compact, &expected, rays, &format!("{case}, compact {isa}"));
        let compact = CompactBvh::of(mesh, &cut).with_isa(isa);
        check(
            &compact,
            &expected,
            rays,
            &format!("{case}, compact, cut {isa}"),
        );
        let cut = WideBvh::<_, 8>::new(mesh, &cut).with_isa(isa);
        check(
            &cut,
            &expected,
            rays,
            &format!("{case}, cut primitives {isa}"),
        );
    }
}

/// A pinhole camera's rays, tile by tile: they run together.
fn camera(eye: Vec3, towards: Vec3, tiles: usize) -> Vec<Ray> {
    let forward = towards - eye;
    let right = forward.cross(Vec3::new(0.1, 1.0, 0.2)).normalized() * 0.7;
    let up = right.cross(forward).normalized() * 0.7;
    let side = 8 * tiles;
    let at = |i: usize| 2.0 * (i as f32 + 0.5) / side as f32 - 1.0;
    let ray = |x: usize, y: usize| Ray::new(eye, forward + right * at(x) + up * at(y));
    (0..tiles * tiles)
        .flat_map(|tile| (0..64).map(move |i| (tile, i)))
        .map(|(tile, i)| ray(tile % tiles * 8 + i % 8, tile / tiles * 8 + i / 8))
        .collect()
}

#[test]
fn rays_that_run_together_agree() {
    let mut random = Random::new(5);
    let scenes = [
        ("terrain", shapes::terrain(40, &mut random)),
        ("sphere", shapes::sphere(30, 20)),
        ("soup", soups::random(700, &mut random)),
        ("one triangle", soups::random(1, &mut random)),
    ];
    for (name, model) in scenes {
        let mesh = model.mesh();
        // Straight along an axis, askew, and from inside.
        for eye in [[0.0, 0.0, 3.0], [2.0, 1.5, -2.5], [0.01, 0.02, 0.03]] {
            let mut rays = camera(Vec3::from(eye), Vec3::ZERO, 4);
            // A last packet that is not full.
            rays.truncate(rays.len() - 41);
            check_all(&mesh, &rays, name);
        }
    }
}

#[test]
fn nodes_smaller_than_the_slack_agree() {
    let mut random = Random::new(11);
    // A few hundred triangles where one float is hardly another, in a scene of ordinary size.
    let cluster = soups::random(300, &mut random).placed(1.0e-6, 0.7e6);
    let mesh = cluster.with(&shapes::cube(2)).mesh();
    for eye in [[0.0, 0.0, 3.0], [0.7, 0.7, -2.0], [0.1, 0.7, 0.7]] {
        let mut rays = camera(Vec3::from(eye), Vec3::from([0.7; 3]), 2);
        for ray in &mut rays {
            // At the cluster, not at all around it.
            let towards = Vec3::from([0.7; 3]) - ray.origin;
            ray.direction = towards + (ray.direction - towards) * 1.0e-6;
        }
        check_all(&mesh, &rays, "cluster");
    }
}

#[test]
fn a_compact_tree_is_small() {
    let mesh = shapes::sphere(60, 60).mesh();
    let wide = Traverse::statistics(&WideSah::<8>::default().build(&mesh));
    let compact = Traverse::statistics(&CompactSah::default().build(&mesh));
    // The same tree, but for the sizes of boxes.
    assert_eq!(
        (compact.nodes, compact.leaves, compact.references),
        (wide.nodes, wide.leaves, wide.references)
    );
    assert!(compact.bytes < 15 * mesh.triangles().len());
    assert!(4 * compact.bytes < wide.bytes);
    assert!(compact.sah_cost < 1.1 * wide.sah_cost);
}

#[test]
fn a_stranger_among_rays_that_run_together_agrees() {
    let mesh = shapes::sphere(30, 20).mesh();
    let rays = camera(Vec3::new(0.3, 0.4, 3.0), Vec3::ZERO, 3);
    let (o, d) = (rays[70].origin, rays[70].direction);
    let strangers = [
        Ray::new(o, d * -1.0),
        Ray::new(o, d * 1.0e30),
        Ray::new(o, d * 1.0e-30),
        Ray::new(o * 1.0e12, d),
        Ray::new(o, [f32::NAN, 0.0, 1.0]),
        Ray::new(o, [0.0; 3]),
        Ray::new(o, [0.0, -0.0, d.z]),
        Ray::new(o, d).from(5.0).until(4.0),
        Ray::new(o, d).until(f32::NEG_INFINITY),
        Ray::new(o, d).from(f32::NAN),
        Ray::new(o, d).until(f32::NAN),
        Ray::new(o, d).until(f32::INFINITY),
        Ray::new(o, d).from(-3.0).until(0.0),
    ];
    for stranger in strangers {
        for place in [64, 70, 127] {
            let mut rays = rays.clone();
            rays[place] = stranger;
            check_all(&mesh, &rays, "a stranger");
        }
    }
}

/// Rays whose directions lie on either side of an axis, or in it: signs, zeros and the longest axis change within a tile.
#[test]
fn tiles_across_axes_agree() {
    let mesh = shapes::cube(6).mesh();
    for towards in [
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 1.0, 1.0],
        [0.0, -1.0, 0.0],
    ] {
        let mut rays = camera(Vec3::ZERO, Vec3::from(towards), 2);
        for (i, ray) in rays.iter_mut().enumerate() {
            if i % 3 == 0 {
                let axis = i % 9 / 3;
                ray.direction[axis] = if i % 2 == 0 { 0.0 } else { -0.0 };
            }
        }
        check_all(&mesh, &rays, "across axes");
    }
}

/// Triangles so small that products of their edges leave the proof, in a scene that does not: such hits are held against
/// the triangle's own box.
#[test]
fn hits_beyond_the_proof_agree() {
    let mut random = Random::new(9);
    let tiny = (0..300).map(|_| {
        let p = random.in_cube() * 1.0e-3;
        let size = 10.0_f32.powf(random.between(-16.0, -12.0));
        [0; 3].map(|_| (p + random.in_cube() * size).to_array())
    });
    let model = Model::of_triangles(tiny.collect::<Vec<_>>()).with(&shapes::cube(2));
    let mesh = model.mesh();
    let mut uncovered = 0;
    let rays: Vec<Ray> = (0..6 * 64)
        .map(|i| {
            let [a, b, c] = mesh.triangle(i % 300);
            let [u, v, w] = random.weights();
            let from = random.in_cube() * if i % 2 == 0 { 0.5 } else { 1.0e-2 };
            uncovered += 1;
            Ray::new(from, a * u + b * v + c * w - from)
        })
        .collect();
    assert!(uncovered > 0);
    check_all(&mesh, &rays, "tiny");
}

/// A query of one's own that ends nearer than its ray, and one that sees only odd triangles.
struct Odd {
    t_max: f32,
    seen: Vec<Hit>,
}

impl Query for Odd {
    fn t_max(&self) -> f32 {
        self.t_max
    }
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        assert!(hit.t <= self.t_max, "{hit:?}");
        if hit.primitive % 2 == 1 {
            self.t_max = hit.t;
            self.seen.push(hit);
        }
        Continue(())
    }
}

#[test]
fn queries_of_ones_own_agree() {
    let mut random = Random::new(3);
    let mesh = soups::random(500, &mut random).mesh();
    let judge = BruteForce::new(&mesh);
    let rays = camera(Vec3::new(0.5, 0.4, 2.5), Vec3::ZERO, 2);
    let ask = |structure: &dyn Fn(&[Ray], &mut [Odd])| {
        let new = |_| Odd {
            t_max: 1.1,
            seen: Vec::new(),
        };
        let mut queries: Vec<Odd> = (0..rays.len()).map(new).collect();
        structure(&rays, &mut queries);
        let nearest = |q: Odd| q.seen.into_iter().min_by(Hit::order);
        queries.into_iter().map(nearest).collect::<Vec<_>>()
    };
    let expected = ask(&|rays, queries| judge.traverse_each(rays, queries, &mut ()));
    assert!(expected.iter().flatten().count() > 20);
    for isa in Isa::available() {
        let eight = WideSah::<8> {
            isa,
            ..Default::default()
        }
        .build(&mesh);
        let sixteen = WideSah::<16> {
            isa,
            ..Default::default()
        }
        .build(&mesh);
        assert_eq!(
            ask(&|r, q| eight.traverse_each(r, q, &mut ())),
            expected,
            "{isa}"
        );
        assert_eq!(
            ask(&|r, q| sixteen.traverse_each(r, q, &mut ())),
            expected,
            "{isa}"
        );
    }
    // All hits of rays that run together, each once.
    let wide = WideSah::<16>::default().build(&mesh);
    let mut queries: Vec<_> = rays.iter().map(AllHits::new).collect();
    wide.traverse_each(&rays, &mut queries, &mut ());
    for (ray, query) in rays.iter().zip(queries) {
        assert_eq!(query.sorted(), judge.all_hits(ray), "{ray:?}");
    }
}

/// The deepest tree and the largest leaves that builders may make.
#[test]
fn extreme_trees_agree() {
    let mut random = Random::new(8);
    let line = (0..300).map(|i| {
        let x = 1.5_f32.powi(i / 6 - 25);
        [[x, 0.0, 0.0], [x, 0.1 * x, 0.0], [x, 0.0, 0.1 * x]]
    });
    let same = (0..200).map(|_| [[0.5, -1.0, -1.0], [0.5, 1.0, -1.0], [0.5, 0.0, 1.0]]);
    let model = Model::of_triangles(line.chain(same).collect::<Vec<_>>());
    let mesh = model.mesh();
    let rays: Vec<Ray> = (0..400)
        .map(|_| {
            Ray::new(
                [-1.0, 0.01, 0.01],
                random.in_cube() * 0.05 + Vec3::new(1.0, 0.0, 0.0),
            )
        })
        .collect();
    check_all(&mesh, &rays, "a line");
    let judge = BruteForce::new(&mesh);
    for leaf in [1, 64] {
        let tree = boxwood::Median {
            max_leaf: leaf,
            ..Default::default()
        }
        .build(&mesh);
        for ray in &rays {
            let expected = judge.closest_hit(ray);
            assert_eq!(
                WideBvh::<_, 16>::new(&mesh, &tree).closest_hit(ray),
                expected
            );
        }
    }
}

#[test]
fn a_fast_tree_is_nearly_right() {
    let mesh = shapes::sphere(60, 40).mesh();
    let exact = WideSah::<16>::default().build(&mesh);
    let settings = WideSah::<16> {
        precision: Precision::Fast,
        ..WideSah::default()
    };
    let fast = settings.build(&mesh);
    let mut random = Random::new(9);
    let rays: Vec<Ray> = (0..20_000)
        .map(|_| Ray::new([0.0; 3], random.direction()))
        .collect();
    let mut batch = vec![None; rays.len()];
    fast.closest_hits(&rays, &mut batch);
    let near = |a: Option<Hit>, b: Option<Hit>| match (a, b) {
        (Some(a), Some(b)) => (a.t - b.t).abs() <= 1.0e-5,
        (a, b) => a.is_none() && b.is_none(),
    };
    let wrong = rays
        .iter()
        .zip(batch)
        .filter(|(ray, together)| {
            let right = exact.closest_hit(ray);
            !near(fast.closest_hit(ray), right)
                || !near(*together, right)
                || fast.occluded(ray) != right.is_some()
        })
        .count();
    assert!(wrong <= 2, "{wrong} of 20,000 answers are wrong");
    // Where it is allowed to differ, it does: the corners, seen from inside, let some rays out.
    let corners = mesh.positions().iter();
    let aimed: Vec<Ray> = corners
        .map(|&p| Ray::new([1.0e-3, 2.0e-3, 0.0], p))
        .collect();
    assert!(aimed.iter().all(|ray| exact.occluded(ray)));
    let bits = |hit: Option<Hit>| hit.map(|h| [h.t, h.u, h.v].map(f32::to_bits));
    let differ = |ray: &&Ray| bits(fast.closest_hit(ray)) != bits(exact.closest_hit(ray));
    assert!(aimed.iter().filter(differ).count() > 0);
}

#[test]
fn only_triangles_are_met_fast() {
    let cuboid = Cuboid::new([5.0, -9.0, -9.0], [6.0, 9.0, 9.0]);
    let shapes = Shapes::new([cuboid]).expect("a good shape");
    let settings = WideSah::<8> {
        precision: Precision::Fast,
        ..WideSah::default()
    };
    let ray = Ray::new([0.0; 3], [3.0, 1.0, 1.0]);
    let expected = BruteForce::new(&shapes).closest_hit(&ray);
    assert!(expected.is_some_and(|hit| hit.t < 1.7));
    assert_eq!(settings.build(&shapes).closest_hit(&ray), expected);
}
