//! Trees that hold placed objects part by part: the same bits as the judge's, nothing twice, nothing opened in vain.

use boxwood::{
    Affine, BruteForce, BuildError, Instance, Instances, Intersect, Limits, Object, Part,
    Primitives, Ray, TriangleMesh, WideBvh, WideSah,
};
use boxwood_testkit::agreement::{Compared, Judged};
use boxwood_testkit::placed::{self, mesh_object};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Random, effort, shapes, soups};
use std::collections::HashSet;
use std::ops::ControlFlow::{Break, Continue};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

fn object(mesh: TriangleMesh, kind: &str) -> Object {
    mesh_object(kind.parse().expect("a kind"), mesh)
}

fn builder<const N: usize>(rebraid: usize) -> WideSah<N> {
    WideSah {
        rebraid,
        ..WideSah::default()
    }
}

/// Turned objects, one over the other.
fn heap(count: usize, stretch: [f32; 3], random: &mut Random) -> Arc<Instances> {
    let objects = [
        object(shapes::sphere(24, 16).mesh(), "wide8"),
        object(shapes::terrain(24, random).mesh(), "wide16"),
        object(soups::random(300, random).mesh(), "wide8:rebraid=1"),
        // These show no parts.
        object(soups::random(100, random).mesh(), "bvh:binned"),
        object(shapes::torus(16, 8).mesh(), "wide8:quality=ultra"),
    ];
    let place = |i: usize| {
        let transform = Affine::scale(stretch)
            .then(&placed::turn(random))
            .then(&Affine::translation(random.in_cube() * 0.2));
        let mask = random.pick(&[u32::MAX, u32::MAX, 0b010, 0b101]);
        Instance::new((i % objects.len()) as u32, transform).masked(mask)
    };
    let places: Vec<_> = (0..count).map(place).collect();
    set_of(objects, places)
}

fn set_of(
    objects: impl IntoIterator<Item = Object>,
    places: impl IntoIterator<Item = Instance>,
) -> Arc<Instances> {
    Arc::new(Instances::new(objects, places).expect("good instances"))
}

fn agree(set: &Arc<Instances>, case: &str, seed: u64) {
    let mut random = Random::new(seed);
    let judge = BruteForce::new(&**set);
    let targets = Targets::of_boxes(&**set);
    let trees: [(&str, Box<dyn Intersect + '_>); 4] = [
        (
            "2",
            Box::new(with_parts(builder::<8>(2).build(set.clone()))),
        ),
        (
            "8",
            Box::new(with_parts(builder::<8>(8).build(set.clone()))),
        ),
        (
            "16",
            Box::new(with_parts(builder::<16>(16).build(set.clone()))),
        ),
        (
            "portable",
            Box::new(with_parts(
                WideSah {
                    isa: "portable".parse().expect("it is everywhere"),
                    ..builder::<16>(16)
                }
                .build(set.clone()),
            )),
        ),
    ];
    let mut found = Compared::default();
    for (kind, of_kind) in KINDS {
        let rays = sample(of_kind, effort(40), &targets, &judge, &mut random);
        let judged = Judged::new(&**set, &rays);
        for (name, tree) in &trees {
            judged.check(&**tree, name, &format!("{case}, rays `{kind}`"));
        }
        let compared = judged.compared();
        found.rays += compared.rays;
        found.hits += compared.hits;
    }
    assert!(4 * found.hits > found.rays, "{case}: {found:?}");
}

fn with_parts<const N: usize>(tree: WideBvh<Arc<Instances>, N>) -> WideBvh<Arc<Instances>, N> {
    assert!(tree.has_parts(), "objects that overlap are opened");
    tree
}

#[test]
fn turned_objects_agree() {
    for seed in 0..3 {
        let set = heap(16, [1.0; 3], &mut Random::new(seed));
        agree(&set, &format!("heap {seed}"), seed);
    }
}

#[test]
fn stretched_and_mirrored_objects_agree() {
    agree(
        &heap(16, [1.0, -1.2, 0.8], &mut Random::new(5)),
        "stretched",
        5,
    );
}

#[test]
fn objects_of_all_sizes_agree() {
    let mut random = Random::new(40);
    let mesh = shapes::terrain(20, &mut random).mesh();
    let place = |_| Instance::new(0, placed::transform(4, &mut random));
    let places: Vec<_> = (0..120).map(place).collect();
    agree(&set_of([object(mesh, "wide8")], places), "of all sizes", 6);
}

#[test]
fn objects_within_objects_agree() {
    let mut random = Random::new(9);
    for inner in [1, 8] {
        let set = heap(16, [1.0; 3], &mut random);
        let structure: Arc<dyn Intersect> = Arc::new(builder::<8>(inner).build(set.clone()));
        let object = Object::of_instances(set.clone(), structure).expect("not too deep");
        let place = |_| {
            let to = Affine::translation(random.in_cube() * 0.1);
            Instance::new(0, placed::turn(&mut random).then(&to))
        };
        let outer = set_of([object], (0..12).map(place));
        // Only those that lie whole in the inner tree can be opened by the outer one.
        assert_eq!(builder::<8>(8).build(outer.clone()).has_parts(), inner == 1);
        if inner == 1 {
            agree(&outer, "nested", 70);
        }
    }
}

/// Boxes of parts are padded for every distance: rays from very far away lose nothing that whole boxes keep.
#[test]
fn far_away_rays_agree() {
    let mut random = Random::new(31);
    let set = heap(16, [1.0; 3], &mut random);
    let tree = with_parts(builder::<16>(32).build(set.clone()));
    let targets = Targets::of_boxes(&*set);
    let judge = BruteForce::new(&*set);
    let mut hits = 0;
    for far in [3.0, 30.0, 1.0e3, 1.0e4, 1.0e5, 1.0e6] {
        let (_, aimed) = KINDS[0];
        let rays = sample(aimed, effort(300), &targets, &judge, &mut random);
        // To where something was hit, from so far away.
        let rays: Vec<Ray> = rays
            .iter()
            .filter_map(|ray| {
                let target = ray.at(judge.closest_hit(ray)?.t);
                let from = random.direction() * far;
                Some(Ray::new(target + from, from * -1.0))
            })
            .collect();
        let judged = Judged::new(&*set, &rays);
        judged.check(&tree, "parts", &format!("{far} away"));
        hits += judged.compared().hits;
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn no_hit_is_shown_twice() {
    let mut random = Random::new(12);
    let set = heap(16, [1.0; 3], &mut random);
    let tree = with_parts(builder::<8>(16).build(set.clone()));
    let judge = BruteForce::new(&*set);
    let mut hits = 0;
    for _ in 0..effort(500) {
        let ray = Ray::new(random.in_cube() * 3.0, random.direction());
        let mut seen = HashSet::new();
        tree.visit(&ray, &mut |hit| {
            let new = seen.insert((hit.instance, hit.primitive, hit.t.to_bits()));
            assert!(new, "{hit:?} twice, {ray:?}");
            Continue(f32::MAX)
        });
        assert_eq!(seen.len(), judge.all_hits(&ray).len());
        hits += seen.len();
    }
    assert!(hits > 500, "{hits}");
}

/// The parts of a tree hold each of its primitives once, and their boxes hold the primitives.
#[test]
fn parts_are_disjoint_and_complete() {
    let mesh = soups::random(500, &mut Random::new(2)).mesh();
    let tree = object(mesh.clone(), "wide8").structure().clone();
    let mut open = vec![(Intersect::bounds(&*tree), Part::ALL)];
    let mut leaves = Vec::new();
    while let Some((bounds, part)) = open.pop() {
        let before = open.len();
        tree.parts(part, &mut |below, part| {
            assert!(bounds.contains(&below), "{below:?} in {bounds:?}");
            open.push((below, part));
        });
        if open.len() == before {
            leaves.push((bounds, part));
        }
    }
    assert!(leaves.len() > 60, "{}", leaves.len());
    let mut found = vec![0; mesh.len()];
    for i in 0..mesh.len() {
        let triangle = mesh.corners(i).expect("a triangle");
        let middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
        let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        let ray = Ray::new(middle + normal, normal * -1.0);
        for &(_, part) in &leaves {
            let mut met = false;
            tree.relay(
                &ray,
                boxwood::Relay {
                    part,
                    ordered: false,
                    mask: u32::MAX,
                    time: 0.0,
                    stats: None,
                    visit: &mut |hit| {
                        met |= hit.primitive == i as u32;
                        Continue(f32::MAX)
                    },
                },
            );
            found[i] += u32::from(met);
        }
    }
    assert!(found.iter().all(|&times| times == 1), "{found:?}");
}

#[test]
fn nothing_is_opened_in_vain() {
    let mut random = Random::new(3);
    let ball = object(shapes::sphere(24, 16).mesh(), "wide8");
    let apart = |i: usize| {
        let to = [3.0 * (i % 5) as f32, 3.0 * (i / 5) as f32, 0.0];
        Instance::new(0, Affine::translation(to))
    };
    let set = set_of([ball.clone()], (0..25).map(apart));
    assert!(!builder::<8>(16).build(set.clone()).has_parts());
    // Neither what shows no parts, nor what is asked to stay whole.
    let crowd = heap(16, [1.0; 3], &mut random);
    assert!(!builder::<8>(1).build(crowd).has_parts());
    let plain = object(shapes::sphere(24, 16).mesh(), "bvh:binned");
    let here = vec![Instance::new(0, Affine::IDENTITY); 9];
    let set = set_of([plain], here.clone());
    assert!(!builder::<8>(16).build(set.clone()).has_parts());
    // Nor what is stretched so much that no box could be proven.
    let flat = Affine::scale([1.0, 1.0e-3, 1.0]);
    let flat = vec![Instance::new(0, flat.then(&placed::turn(&mut random))); 9];
    let set = set_of([ball.clone()], flat);
    assert!(!builder::<8>(16).build(set.clone()).has_parts());
    let set = set_of([ball], here);
    let leaves = |rebraid: usize| {
        let tree = builder::<8>(rebraid).build(set.clone());
        Intersect::statistics(&tree).leaves
    };
    assert_eq!(leaves(1), 9);
    for most in [3, 16, 64] {
        let found = leaves(most);
        assert!(9 < found && found <= 9 * most, "{found} of {most}");
    }
}

#[test]
fn what_moves_is_whole_again() {
    let mut random = Random::new(17);
    let set = heap(16, [1.0; 3], &mut random);
    let mut tree = builder::<8>(16).build(set.clone());
    assert!(tree.has_parts());
    let to = [(3, Affine::translation([0.0, 1.0, 0.0]))];
    tree.update(|set| Arc::make_mut(set).move_to(&to))
        .expect("a good place");
    assert!(!tree.has_parts());
    let set = tree.primitives().clone();
    let judge = BruteForce::new(&*set);
    let (_, of_kind) = KINDS[0];
    let rays = sample(
        of_kind,
        effort(200),
        &Targets::of_boxes(&*set),
        &judge,
        &mut random,
    );
    Judged::new(&*set, &rays).check(&tree, "moved", "after a move");
}

#[test]
fn limits_are_obeyed() {
    let set = heap(200, [1.0; 3], &mut Random::new(23));
    let asked = AtomicUsize::new(0);
    for until in [0.05, 0.2, 0.4, 0.9] {
        let watch = |share: f32| {
            asked.fetch_add(1, Relaxed);
            if share >= until {
                Break(())
            } else {
                Continue(())
            }
        };
        let limits = Limits {
            watch: Some(&watch),
            ..Limits::NONE
        };
        let built = builder::<8>(16).build_within(set.clone(), &limits);
        assert!(matches!(built, Err(BuildError::Cancelled)), "{until}");
    }
    assert!(asked.load(Relaxed) >= 4);
    let within = |memory: usize| {
        let limits = Limits {
            memory: Some(memory),
            ..Limits::NONE
        };
        builder::<8>(16).build_within(set.clone(), &limits)
    };
    assert!(matches!(within(1000), Err(BuildError::Memory { .. })));
    // With little room there is a tree over whole objects, with more one over parts.
    assert!(!within(200_000).expect("enough for whole ones").has_parts());
    assert!(within(20_000_000).expect("enough").has_parts());
}

#[test]
fn progress_only_grows() {
    let set = heap(200, [1.0; 3], &mut Random::new(23));
    let last = std::sync::Mutex::new(0.0_f32);
    let watch = |share: f32| {
        let mut last = last.lock().expect("one thread at a time");
        assert!(*last <= share && share <= 1.0, "{share} after {last}");
        *last = share;
        Continue(())
    };
    let limits = Limits {
        watch: Some(&watch),
        ..Limits::NONE
    };
    builder::<8>(16)
        .build_within(set.clone(), &limits)
        .expect("built");
    assert_eq!(*last.lock().expect("nobody else"), 1.0);
}

/// The same entries however many threads build.
#[test]
fn threads_change_nothing() {
    let set = heap(100, [1.0; 3], &mut Random::new(29));
    let built = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a pool");
        pool.install(|| builder::<16>(8).build(set.clone()).to_bytes())
    };
    assert_eq!(built(1), built(3));
}

/// Saved trees bear no parts, and are not taken for whole.
#[test]
fn a_saved_tree_of_parts_is_refused() {
    let set = heap(16, [1.0; 3], &mut Random::new(37));
    let tree = builder::<8>(16).build(set.clone());
    assert_eq!(tree.validate(), Ok(()));
    let bytes = tree.to_bytes();
    let mut rest = &bytes[..];
    let opened = WideBvh::<_, 8>::open(set, bytes.len() as u64, |to| {
        let (head, tail) = rest.split_at(to.len());
        to.copy_from_slice(head);
        rest = tail;
        Ok::<(), ()>(())
    });
    assert!(opened.is_err());
}
