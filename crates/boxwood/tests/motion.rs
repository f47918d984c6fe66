//! Meshes that move: every structure has the judge's bits at every moment, and none leaks at any.

use boxwood::{
    Aabb, Affine, BinnedSah, BruteForce, BuildError, Bvh, Counters, Hit, Instance, Instances,
    Intersect, Isa, KdSah, KdTree, Limits, MotionBvh, MotionError, MovingMesh, Object, PreparedRay,
    Primitives, Quality, Query, Ray, Surfaces, Timed, TraversalStats, TriangleMesh, Vec3, WideSah,
};
use boxwood_testkit::agreement::Judged;
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Model, Random, effort, shapes, soups};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Where the mesh is at a moment, by the definition and nothing else, in the boxes of all of its way.
struct Frozen<'a> {
    mesh: &'a MovingMesh,
    then: TriangleMesh,
}

impl<'a> Frozen<'a> {
    fn new(mesh: &'a MovingMesh, time: f32) -> Self {
        let time = if time > 0.0 { time.min(1.0) } else { 0.0 };
        let at = time * (mesh.keys() - 1) as f32;
        let [before, part] = [at.floor(), at - at.floor()];
        let (near, far, weight) = match part {
            0.0 => (before, before, 0.0),
            _ if part <= 0.5 => (before, before + 1.0, part),
            _ => (before + 1.0, before, 1.0 - part),
        };
        let [near, far] = [near, far].map(|key| mesh.positions(key as usize).iter());
        let places = near.zip(far).map(|(a, b)| {
            let [a, b] = [a.to_array(), b.to_array()];
            [0, 1, 2].map(|k| a[k] - (a[k] - b[k]) * weight)
        });
        let then = TriangleMesh::new(places, mesh.triangles().iter().copied());
        Self {
            mesh,
            then: then.expect("between good meshes"),
        }
    }
}

impl Primitives for Frozen<'_> {
    fn len(&self) -> usize {
        self.then.len()
    }
    fn bounds(&self, i: usize) -> Aabb {
        let keys = 0..self.mesh.keys();
        let corners = self.mesh.triangles()[i];
        Aabb::of(keys.flat_map(|key| corners.map(|v| self.mesh.positions(key)[v as usize])))
    }
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        self.then.offer(i, ray, query, counters)
    }
    const WITHIN_SLACK: bool = true;
}

type Motion = fn(Vec3, usize, &mut Random) -> Vec3;

/// Where a vertex is at a later key.
const MOTIONS: [(&str, Motion); 8] = [
    ("rests", |p, _, _| p),
    ("a little", |p, _, random| p + random.in_cube() * 0.01),
    ("anywhere", |_, _, random| random.in_cube()),
    ("along", |p, key, _| {
        p + Vec3::new(3.0 * key as f32, 0.0, -0.5)
    }),
    ("turned over", |p, _, _| Vec3::new(-p.x, -p.y, p.z)),
    ("far away", |p, _, _| {
        p * 3.0 + Vec3::new(1.0e5, -2.0e6, 7.0)
    }),
    ("beyond the doors", |p, _, _| p * 1.0e15),
    ("into a point", |_, _, _| Vec3::splat(1.0)),
];

fn moving(model: &Model, motion: Motion, keys: usize, random: &mut Random) -> MovingMesh {
    let mut to = |key| -> Vec<Vec3> {
        let positions = model.positions.iter();
        positions.map(|&p| motion(p.into(), key, random)).collect()
    };
    let later: Vec<_> = (1..keys).map(&mut to).collect();
    MovingMesh::new(model.mesh(), later).expect("finite")
}

fn rays(frozen: &Frozen<'_>, count: usize, random: &mut Random) -> Vec<Ray> {
    let targets = Targets::of_mesh(&frozen.then);
    let judge = BruteForce::new(frozen);
    let of = |(_, kind)| sample(kind, effort(count), &targets, &judge, random);
    KINDS.into_iter().flat_map(of).collect()
}

/// Asks everything of trees that move, of both widths, on every instruction set.
fn check(mesh: &MovingMesh, times: &[f32], count: usize, case: &str, random: &mut Random) -> usize {
    let mut hits = 0;
    let eight = WideSah::<8>::default().build_moving(mesh);
    let sixteen = WideSah::<16>::default().build_moving(mesh);
    let cut = WideSah::<8> {
        quality: Quality::Ultra,
        ..WideSah::default()
    };
    let cut = cut.build_moving(mesh);
    for &time in times {
        let frozen = Frozen::new(mesh, time);
        let rays = rays(&frozen, count, random);
        let judged = Judged::new(&frozen, &rays);
        hits += judged.compared().hits;
        let case = format!("{case} at {time}");
        for isa in Isa::available() {
            let name = |what: &str| format!("{what} {isa}");
            let eight = eight.clone().with_isa(isa);
            judged.check(&eight.at(time), &name("8 children"), &case);
            let sixteen = sixteen.clone().with_isa(isa);
            judged.check(&sixteen.at(time), &name("16 children"), &case);
            let cut = cut.clone().with_isa(isa);
            judged.check(&cut.at(time), &name("cut"), &case);
        }
    }
    hits
}

fn scenes(random: &mut Random) -> Vec<(&'static str, Model)> {
    vec![
        ("sphere", shapes::sphere(16, 8)),
        ("soup", soups::random(150, random)),
        ("slivers", soups::slivers(60, random)),
        ("duplicates", soups::duplicates(40, random)),
        ("grid", soups::grid(80, random)),
        ("one", soups::random(1, random)),
        ("nothing", Model::default()),
    ]
}

#[test]
fn moving_trees_agree_at_all_times() {
    let mut random = Random::new(41);
    let mut hits = 0;
    for (name, model) in scenes(&mut random) {
        for (how, motion) in MOTIONS {
            let keys = 1 + random.below(4);
            let mesh = moving(&model, motion, keys, &mut random);
            let times = [0.0, random.unit(), 0.5, random.unit(), 1.0, f32::NAN];
            let case = format!("{name} moved {how}, {keys} keys");
            hits += check(&mesh, &times, 1, &case, &mut random);
        }
    }
    assert!(hits > 3000, "{hits}");
}

#[test]
fn moving_trees_agree_at_every_scale() {
    let mut random = Random::new(42);
    let mut hits = 0;
    for (scale, offset) in [
        (1.0e-30, 0.0),
        (1.0e-6, 3.0),
        (1.0e3, 1.0e4),
        (1.0e30, 0.0),
        // Seen from the middle.
        (1.0, 1.0e4),
        (1.0, 4.0e6),
    ] {
        let model = soups::random(100, &mut random);
        let start = model.clone().placed(scale, offset);
        let mut later = model;
        for p in &mut later.positions {
            *p = (Vec3::from(*p) + random.in_cube()).to_array();
        }
        let later = later.placed(scale, offset);
        let mesh = MovingMesh::new(start.mesh(), [later.positions]).expect("finite");
        let times = [0.0, random.unit(), random.unit(), 1.0];
        let case = format!("scale {scale:e}, offset {offset:e}");
        hits += check(&mesh, &times, 3, &case, &mut random);
    }
    assert!(hits > 300, "{hits}");
}

/// A coordinate of any kind: small whole numbers, any size, often zero.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        (-4_i32..5).prop_map(|x| x as f32),
        -1.0_f32..1.0,
        Just(-0.0),
        any::<i32>().prop_map(|bits| f32::from_bits(bits as u32 & 0xbfff_ffff)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Structures that know nothing of motion, too.
    #[test]
    fn any_motion_agrees(
        keys in 1_usize..5,
        corners in prop::collection::vec(prop::array::uniform3(coordinate()), 60),
        time in prop_oneof![0.0_f32..1.0, Just(f32::INFINITY), any::<f32>()],
        seed in any::<u64>(),
    ) {
        let vertices = corners.len() / keys / 3 * 3;
        prop_assume!(vertices > 0);
        let mut keys = corners.chunks_exact(vertices).map(<[_]>::to_vec);
        let triangles = (0..vertices as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let first = TriangleMesh::new(keys.next().expect("a key"), triangles);
        let mesh = MovingMesh::new(first.expect("finite"), keys);
        let mesh = mesh.expect("no way is longer than floats");
        let mut random = Random::new(seed);
        check(&mesh, &[time], 1, "any", &mut random);

        let frozen = Frozen::new(&mesh, time);
        let rays = rays(&frozen, 1, &mut random);
        let judged = Judged::new(&frozen, &rays);
        let tree = BinnedSah::default().build(&mesh);
        let kd = KdTree::new(&mesh, KdSah::default().build(&mesh));
        judged.check(&BruteForce::new(&mesh).at(time), "judge", "any");
        judged.check(&Bvh::new(&mesh, tree).at(time), "boxes of all of the way", "any");
        judged.check(&kd.at(time), "kd-tree", "any");
        judged.check(&WideSah::<16>::default().build(&mesh).at(time), "wide", "any");
    }
}

/// A hit as bits, so that zeros of both signs differ.
fn bits(hit: Option<Hit>) -> Option<[u32; 5]> {
    hit.map(|h| {
        let [t, u, v] = [h.t, h.u, h.v].map(f32::to_bits);
        [t, u, v, h.primitive, h.instance]
    })
}

/// The bits of meshes at rest, zeros of vertices with their signs.
#[test]
fn keys_are_meshes_at_rest() {
    let mut random = Random::new(43);
    let mut hits = 0;
    for keys in [1, 2, 3, 7] {
        let model = soups::grid(100, &mut random);
        let signed = |p: Vec3, random: &mut Random| {
            let one = |x: f32| {
                if x == 0.0 && random.one_in(2) {
                    -0.0
                } else {
                    x
                }
            };
            Vec3::from(p.to_array().map(one))
        };
        let mut random_places = |_| -> Vec<Vec3> {
            let places = model.positions.iter();
            places.map(|&p| signed(p.into(), &mut random)).collect()
        };
        let poses: Vec<_> = (0..keys).map(&mut random_places).collect();
        let rest = |key: usize| {
            let mesh = TriangleMesh::new(poses[key].clone(), model.triangles.clone());
            mesh.expect("finite")
        };
        let mesh = MovingMesh::new(rest(0), poses[1..].to_vec()).expect("finite");
        let moving = WideSah::<8>::default().build_moving(&mesh);
        for key in 0..keys {
            let rest = rest(key);
            let time = key as f32 / (keys - 1).max(1) as f32;
            let judge = BruteForce::new(&rest);
            let targets = Targets::of_mesh(&rest);
            // Thirds are no floats: at the ends the moment is the key's own.
            let exact = time * (keys - 1) as f32 == key as f32;
            for (_, kind) in KINDS {
                for ray in sample(kind, effort(20), &targets, &judge, &mut random) {
                    let (found, expected) =
                        (moving.at(time).closest_hit(&ray), judge.closest_hit(&ray));
                    if exact {
                        assert_eq!(bits(found), bits(expected), "key {key} of {keys}, {ray:?}");
                        hits += usize::from(found.is_some());
                    }
                }
            }
        }
    }
    assert!(hits > 500, "{hits}");
}

#[test]
fn outside_of_the_shutter_the_ends_count() {
    let mut random = Random::new(44);
    let model = soups::random(100, &mut random);
    let mesh = moving(&model, |_, _, random| random.in_cube(), 3, &mut random);
    let moving = WideSah::<8>::default().build_moving(&mesh);
    let rays = rays(&Frozen::new(&mesh, 0.0), 10, &mut random);
    for (time, end) in [
        (f32::NAN, 0.0),
        (-0.0, 0.0),
        (-3.0, 0.0),
        (f32::NEG_INFINITY, 0.0),
        (1.0_f32.next_up(), 1.0),
        (f32::INFINITY, 1.0),
    ] {
        for ray in &rays {
            let [found, expected] = [time, end].map(|t| moving.at(t).closest_hit(ray));
            assert_eq!(bits(found), bits(expected), "{time}, {ray:?}");
        }
    }
}

/// Closed shapes that bulge and turn: what lies in the middle sees no gap at any moment.
#[test]
fn none_escapes_what_moves() {
    let mut random = Random::new(45);
    for (name, model) in [
        ("sphere", shapes::sphere(60, 30)),
        ("cube", shapes::cube(15)),
    ] {
        for (scale, offset) in [(1.0, 0.0), (1.0e-3, 1.0e3), (1.0e6, 0.0), (1.0, 1.0e5)] {
            let key = |turn: f32, random: &mut Random| -> Vec<[f32; 3]> {
                let place = |&[x, y, z]: &[f32; 3], random: &mut Random| {
                    let p = Vec3::new(x - turn * y, y + turn * x, z) * random.between(0.9, 1.1);
                    p.to_array().map(|x| (x + offset) * scale)
                };
                model.positions.iter().map(|p| place(p, random)).collect()
            };
            let first = model.clone().placed(scale, offset).mesh();
            let later = [key(0.3, &mut random), key(0.1, &mut random)];
            let mesh = MovingMesh::new(first, later).expect("finite");
            let eight = WideSah::<8>::default().build_moving(&mesh);
            let sixteen = WideSah::<16>::default().build_moving(&mesh);
            let sixteen = Isa::available()
                .into_iter()
                .map(|isa| sixteen.clone().with_isa(isa));
            let sixteen: Vec<_> = sixteen.collect();
            for _ in 0..effort(1_000) {
                let time = random.unit();
                let triangle = random.below(mesh.len());
                let rest = mesh.at(time);
                let [a, b, _] = rest.corners(triangle).expect("a triangle");
                let anywhere = random.unit();
                let target = a + (b - a) * random.pick(&[0.0, 0.5, anywhere]);
                let inside = random.in_cube() * 0.1;
                let inside = Vec3::from(inside.to_array().map(|x| (x + offset) * scale));
                let ray = Ray::new(inside, target - inside);
                let found = eight.at(time).closest_hit(&ray);
                assert!(
                    found.is_some(),
                    "{name} {scale:e} {offset:e} {time} {ray:?}"
                );
                for other in &sixteen {
                    assert_eq!(bits(other.at(time).closest_hit(&ray)), bits(found));
                }
            }
        }
    }
}

/// A ball of many triangles that goes far.
fn comet() -> (MovingMesh, Vec<Ray>, Vec<f32>) {
    let mut random = Random::new(46);
    let model = shapes::sphere(60, 30);
    let mesh = moving(
        &model,
        |p, _, _| p + Vec3::new(8.0, 0.0, 0.0),
        2,
        &mut random,
    );
    let times: Vec<f32> = (0..400).map(|_| random.unit()).collect();
    let towards = |time: &f32| {
        let at = Vec3::new(8.0 * time, 0.0, 0.0) + random.in_cube();
        let eye = Vec3::new(4.0, 1.0, 9.0);
        Ray::new(eye, at - eye)
    };
    let rays = times.iter().map(towards).collect();
    (mesh, rays, times)
}

#[test]
fn boxes_that_move_are_entered_less_than_boxes_of_all_of_the_way() {
    let (mesh, rays, times) = comet();
    let count = |structure: &dyn Fn(&Ray, f32, &mut TraversalStats) -> Option<Hit>| {
        let mut stats = TraversalStats::default();
        let asked = rays.iter().zip(&times);
        let hits = asked.filter(|(ray, time)| structure(ray, **time, &mut stats).is_some());
        assert!(hits.count() > 100);
        stats
    };
    let moving = WideSah::<8>::default().build_moving(&mesh);
    let whole = WideSah::<8>::default().build(&mesh);
    let moving_stats = count(&|ray, time, stats| moving.at(time).closest_hit_counted(ray, stats));
    let whole_stats = count(&|ray, time, stats| whole.at(time).closest_hit_counted(ray, stats));
    assert!(
        3 * moving_stats.nodes < 2 * whole_stats.nodes,
        "{moving_stats:?} {whole_stats:?}"
    );
    assert!(10 * moving_stats.leaves < whole_stats.leaves);
    assert!(10 * moving_stats.primitives < whole_stats.primitives);
    // As many on every machine, and explained step by step.
    for isa in Isa::available() {
        let moving = moving.clone().with_isa(isa);
        let stats = count(&|ray, time, stats| moving.at(time).closest_hit_counted(ray, stats));
        assert_eq!(stats, moving_stats, "{isa}");
    }
    for (ray, &time) in rays.iter().zip(&times) {
        let told = moving.at(time).explain(ray);
        assert_eq!(told.is_empty(), mesh.is_empty(), "{ray:?}");
    }
}

#[test]
fn each_ray_has_a_time_of_its_own() {
    let (mesh, rays, times) = comet();
    let moving = WideSah::<16>::default().build_moving(&mesh);
    let (mut hits, mut dark) = (vec![None; rays.len()], vec![false; rays.len()]);
    moving.closest_hits_at(&rays, &times, &mut hits);
    moving.occluded_each_at(&rays, &times, &mut dark);
    for (i, (ray, &time)) in rays.iter().zip(&times).enumerate() {
        let one = moving.at(time).closest_hit(ray);
        assert_eq!(bits(hits[i]), bits(one));
        assert_eq!(bits(moving.closest_hit_seen(ray, 1, time)), bits(one));
        assert_eq!(bits(moving.closest_hit_seen(ray, 0, time)), None);
        assert_eq!(dark[i], one.is_some());
        if let Some(hit) = one {
            // Where it met the mesh as it was then.
            let surface = mesh.at(time).surface(ray, &hit);
            let away = surface.position - Vec3::new(8.0 * time, 0.0, 0.0);
            assert!((away.length() - 1.0).abs() < 0.02, "{away:?}");
        }
    }
}

#[test]
fn objects_that_move_inside_are_placed() {
    let (mesh, rays, times) = comet();
    let mesh = Arc::new(mesh);
    let moving = Arc::new(WideSah::<8>::default().build_moving(mesh.clone()));
    let object = Object::new(&*mesh, moving.clone());
    let placed = Instances::new([object], [Instance::new(0, Affine::IDENTITY)]);
    let placed = placed.expect("a good placement");
    let world = BruteForce::new(&placed);
    for (ray, &time) in rays.iter().zip(&times) {
        let [found, expected] = [
            world.at(time).closest_hit(ray),
            moving.at(time).closest_hit(ray),
        ];
        assert_eq!(bits(found), bits(expected), "{time}");
    }
}

#[test]
fn bad_motions_are_refused_in_a_sentence() {
    let mesh = || TriangleMesh::new([[0.0; 3], [1.0; 3], [2.0; 3]], [[0_u32, 1, 2]]);
    let refused = |later: Vec<Vec<[f32; 3]>>| {
        let made = MovingMesh::new(mesh().expect("good"), later);
        made.expect_err("refused")
    };
    assert_eq!(
        refused(vec![vec![[1.0; 3]; 3], vec![[1.0; 3]; 2]]).to_string(),
        "at key 2, triangle 0 names vertex 2, but there are 2"
    );
    assert_eq!(
        refused(vec![vec![[f32::NAN; 3]; 3]]).to_string(),
        "at key 1, triangle 0 names vertex 0, which is not finite"
    );
    let far = [[-3.0e38; 3], [1.0, 3.0e38, 1.0], [2.0; 3]];
    assert_eq!(
        refused(vec![far.to_vec(), far.map(|p| p.map(|x| -x)).to_vec()]),
        MotionError::TooFar { vertex: 0, key: 2 }
    );
    let many = vec![vec![[0.0; 3]; 3]; MovingMesh::MOST_KEYS];
    assert_eq!(
        refused(many).to_string(),
        "there are 65537 keys, but at most 65536 can be told apart"
    );
}

#[test]
fn builds_obey_their_limits() {
    let (mesh, ..) = comet();
    let build = |limits: &Limits<'_>| -> Result<MotionBvh<&MovingMesh, 8>, BuildError> {
        WideSah::default().build_moving_within(&mesh, limits)
    };
    let needed = |memory| {
        let limits = Limits {
            memory: Some(memory),
            ..Limits::NONE
        };
        build(&limits).err()
    };
    let bytes = Intersect::statistics(&build(&Limits::NONE).expect("no limit")).bytes;
    assert!(matches!(needed(bytes), Some(BuildError::Memory { .. })));
    assert_eq!(needed(4 * bytes), None);
    let shares = std::sync::Mutex::new(Vec::new());
    let watch = |share: f32| {
        shares.lock().expect("not poisoned").push(share);
        ControlFlow::Continue(())
    };
    let limits = Limits {
        watch: Some(&watch),
        ..Limits::NONE
    };
    assert!(build(&limits).is_ok());
    let shares = shares.into_inner().expect("not poisoned");
    assert!(
        shares.last() == Some(&1.0) && shares.len() > 3,
        "{shares:?}"
    );
    // Cancelled wherever it is: also while it is fitted to a key.
    for after in [0.1, 0.9] {
        let watch = |share: f32| {
            if share < after {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let limits = Limits {
            watch: Some(&watch),
            ..Limits::NONE
        };
        assert_eq!(build(&limits).err(), Some(BuildError::Cancelled));
    }
}
