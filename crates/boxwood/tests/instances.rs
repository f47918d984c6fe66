//! Instances: the answer is that of the ray within, and no hit is lost on the way there.

use boxwood::accel::bvh::refine::refit;
use boxwood::{
    Affine, BinnedSah, BruteForce, Bvh, Hit, Instance, Instances, Intersect, Lbvh, Object,
    Primitives, Ray, Surfaces, TriangleMesh, Vec3, WideBvh,
};
use boxwood_testkit::placed::{self, Placed, Recipe};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Random, effort, shapes, soups};
use std::sync::Arc;

fn object(mesh: TriangleMesh) -> Object {
    let mesh = Arc::new(mesh);
    let tree = BinnedSah::default().build(&mesh);
    Object::new(&mesh, Arc::new(WideBvh::<_, 8>::new(mesh.clone(), &tree)))
}

fn bits(hits: &[Hit]) -> Vec<[u32; 5]> {
    let of = |h: &Hit| {
        [
            h.t.to_bits(),
            h.u.to_bits(),
            h.v.to_bits(),
            h.primitive,
            h.instance,
        ]
    };
    hits.iter().map(of).collect()
}

/// The definition itself: nothing is asked but the objects' meshes, by the rays within.
#[test]
fn the_answer_is_that_of_the_ray_within() {
    let mut random = Random::new(5);
    let mesh = Arc::new(soups::random(40, &mut random).mesh());
    let object = Object::new(&mesh, Arc::new(BruteForce::new(mesh.clone())));
    let place = |_| Instance::new(0, placed::transform(3, &mut random));
    let set = Instances::new([object], (0..40).map(place).collect::<Vec<_>>()).expect("good");
    let (judge, within) = (BruteForce::new(&set), BruteForce::new(&mesh));
    let laid_out = (0..40).flat_map(|i| {
        let place = set.instance(i).transform;
        let triangle = |k: usize| mesh.triangle(k).map(|p| place.point(p));
        (0..mesh.len()).map(triangle).collect::<Vec<_>>()
    });
    let targets = Targets::of_triangles(laid_out);
    let mut hits = 0;
    for (kind, of_kind) in &KINDS[..6] {
        for _ in 0..effort(200) {
            let ray = of_kind(&targets, &mut random);
            let mut expected: Vec<Hit> = (0..40)
                .flat_map(|instance| {
                    let found = within.all_hits(&set.ray_within(&ray, instance));
                    found.into_iter().map(move |hit| Hit { instance, ..hit })
                })
                .collect();
            expected.sort_by(Hit::order);
            // No hit is lost to the boxes of the instances either.
            assert_eq!(
                bits(&judge.all_hits(&ray)),
                bits(&expected),
                "rays `{kind}`, {ray:?}"
            );
            hits += expected.len();
        }
    }
    assert!(hits > 1000, "{hits}");
}

/// Flat quads, closed up edge to edge by their meshes and met from near and from very far: the worst case for boxes, which
/// have no thickness of their own.
#[test]
fn no_ray_slips_through_a_turned_plain() {
    let corners = [
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ];
    let quad = TriangleMesh::new(corners, [[0_u32, 1, 2], [0, 2, 3]]).expect("a good mesh");
    let quad = object(quad);
    let mut random = Random::new(77);
    for far in [0.0, 3.0, 100.0, 1.0e4, 1.0e5] {
        for round in 0..effort(200) {
            // Turned, stretched, and then placed once more from within another set.
            let size = random.pick(&[1.0e-3, 1.0, 50.0]);
            let shape = Affine::scale([size, size * random.pick(&[1.0, 0.1, 8.0]), size]);
            let to = Affine::translation(random.in_cube() * random.pick(&[0.0, 1.0, 9.0]) * size);
            let inner = shape.then(&placed::turn(&mut random)).then(&to);
            let set = Instances::new([quad.clone()], [Instance::new(0, inner)]).expect("good");
            let set = Arc::new(set);
            let nested = placed::instances_object(1, set);
            let outer =
                placed::turn(&mut random).then(&Affine::translation(random.in_cube() * size));
            let set = Instances::new([nested], [Instance::new(0, outer)]).expect("good");
            let bvh = Bvh::new(&set, BinnedSah::default().build(&set));
            let place = set.transform_of(0).expect("the one");
            // From far away no ray can be aimed well.
            let end = if far > 1.0e3 { 0.5 } else { 0.98 };
            for _ in 0..20 {
                let [x, y] = [random.between(-end, end), random.between(-end, end)];
                let target = place.point([x, y, 0.0]);
                let side = place.normal([0.0, 0.0, 1.0]) + random.direction() * 0.7;
                let from = target + side * (size * (1.0 + far));
                let ray = Ray::new(from, target - from);
                let miss = || format!("{far} away, round {round}, at {x}, {y}: {ray:?}");
                assert!(bvh.closest_hit(&ray).is_some(), "{}", miss());
            }
        }
    }
}

/// Where nothing is moved, nothing changes.
#[test]
fn an_object_in_its_own_place_keeps_its_bits() {
    let mut random = Random::new(8);
    let mesh = soups::random(60, &mut random).mesh();
    let object = object(mesh.clone());
    let set = Instances::new([object], [Instance::new(0, Affine::IDENTITY)]).expect("good");
    let (judge, placed) = (BruteForce::new(&mesh), BruteForce::new(&set));
    let targets = Targets::of_mesh(&mesh);
    for (_, of_kind) in &KINDS[..6] {
        for ray in sample(*of_kind, effort(100), &targets, &judge, &mut random) {
            assert_eq!(
                bits(&judge.all_hits(&ray)),
                bits(&placed.all_hits(&ray)),
                "{ray:?}"
            );
        }
    }
}

/// A hundred thousand, by the structures that such scenes are made for.
#[test]
fn a_hundred_thousand_agree() {
    let mut random = Random::new(9);
    let Placed {
        instances: set,
        aims,
    } = placed::plain(100_000, &mut random);
    let judge = BruteForce::new(&set);
    let tree = BinnedSah::default().build(&set);
    let wide = WideBvh::<_, 8>::new(&set, &tree);
    let bvh = Bvh::new(&set, tree);
    let linear = Bvh::new(&set, Lbvh::default().build(&set));
    let targets = Targets::of_triangles(aims);
    let mut hits = 0;
    for (_, of_kind) in &KINDS[..4] {
        for _ in 0..effort(10) {
            let ray = of_kind(&targets, &mut random);
            let expected = judge.all_hits(&ray);
            hits += expected.len();
            for structure in [&bvh as &dyn Intersect, &wide, &linear] {
                assert_eq!(bits(&structure.all_hits(&ray)), bits(&expected), "{ray:?}");
                assert_eq!(
                    structure.closest_hit(&ray),
                    expected.first().copied(),
                    "{ray:?}"
                );
            }
        }
    }
    assert!(hits > 100, "{hits}");
}

/// Boxes in the world hold the placed vertices and are not much larger.
#[test]
fn boxes_are_tight() {
    let ball = shapes::sphere(64, 32).mesh();
    let object = object(ball.clone());
    let mut random = Random::new(3);
    for _ in 0..200 {
        let transform = placed::transform(3, &mut random);
        let set = Instances::new([object.clone()], [Instance::new(0, transform)]).expect("good");
        let points = ball.positions().iter().map(|&p| transform.point(p));
        let (exact, made) = (boxwood::Aabb::of(points), set.bounds(0));
        let larger = Vec3::splat(1.0e-4 * exact.scale());
        let around = boxwood::Aabb::new(made.lower - larger, made.upper + larger);
        assert!(around.contains(&exact), "{transform:?}");
        for axis in 0..3 {
            let (is, should) = (made.size()[axis], exact.size()[axis]);
            assert!(
                is < 1.5 * should + 0.003 * exact.scale(),
                "{is} {should} {transform:?}"
            );
        }
    }
}

/// Rays that leave a surface do not meet it again, whatever was done to it.
#[test]
fn surfaces_are_left_behind() {
    let mesh = Arc::new(shapes::sphere(24, 12).mesh());
    let object = Object::new(&mesh, Arc::new(BruteForce::new(mesh.clone())));
    let mut random = Random::new(12);
    let (mut left, mut tried) = (0, 0);
    for _ in 0..effort(300) {
        let transform = placed::transform(4, &mut random);
        let set = Instances::new([object.clone()], [Instance::new(0, transform)]).expect("good");
        let judge = BruteForce::new(&set);
        for _ in 0..5 {
            let from = transform.point(random.direction() * 3.0);
            let to = transform.point(random.in_cube() * 0.5);
            let ray = Ray::new(from, to - from);
            let Some(hit) = judge.closest_hit(&ray) else {
                continue;
            };
            let surface = set.surface(&ray, &hit, |_, ray, hit| mesh.surface(ray, hit));
            assert!(surface.front, "{transform:?}");
            assert!(surface.normal.dot(ray.direction) <= 0.0);
            let (at, off) = (ray.at(hit.t), surface.position);
            let bound = 1.0e-4 * (at - from).length().max(at.length());
            assert!((at - off).length() <= bound, "{at:?} {off:?}");
            // A ball is convex: nothing else is in the way outside.
            let out = Ray::new(surface.offset_origin(surface.normal), surface.normal);
            tried += 1;
            left += usize::from(!judge.occluded(&out));
        }
    }
    assert!(tried > 1000);
    assert_eq!(left, tried);
}

#[test]
fn moving_is_placing_anew() {
    let mut random = Random::new(21);
    let recipe = Recipe {
        count: 50,
        spread: 2,
        depth: 2,
    };
    let Placed {
        instances: mut set,
        aims,
    } = placed::set(recipe, true, &mut random);
    let targets = Targets::of_triangles(aims);
    let mut tree = BinnedSah::default().build(&set);
    let mut hits = 0;
    for round in 0..8 {
        let spread = if round == 3 { 8 } else { 1 };
        let moves: Vec<(usize, Affine)> = (0..10)
            .map(|_| (random.below(50), placed::transform(spread, &mut random)))
            .collect();
        set.move_to(&moves).expect("good moves");
        let instances: Vec<Instance> = (0..50).map(|i| set.instance(i)).collect();
        let anew = Instances::new(set.objects().to_vec(), instances).expect("good");
        for i in 0..50 {
            assert_eq!(set.bounds(i), anew.bounds(i), "round {round}, {i}");
        }
        refit(&mut tree, &set);
        let (bvh, judge) = (Bvh::new(&set, tree.clone()), BruteForce::new(&anew));
        for ray in sample(KINDS[0].1, effort(40), &targets, &judge, &mut random) {
            let expected = judge.all_hits(&ray);
            hits += expected.len();
            assert_eq!(
                bits(&bvh.all_hits(&ray)),
                bits(&expected),
                "round {round}, {ray:?}"
            );
        }
    }
    assert!(hits > 100, "{hits}");
    let before: Vec<_> = (0..50).map(|i| set.bounds(i)).collect();
    let flat = Affine::scale([0.0, 1.0, 1.0]);
    assert!(set.move_to(&[(1, Affine::IDENTITY), (2, flat)]).is_err());
    assert!(set.move_to(&[(50, Affine::IDENTITY)]).is_err());
    assert_eq!(before, (0..50).map(|i| set.bounds(i)).collect::<Vec<_>>());
}
