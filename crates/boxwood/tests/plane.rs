//! Scenes in the plane: hits found by hand, and structures that agree on them.

use boxwood::geometry::Figure;
use boxwood::plane::{self, Scene};
use boxwood::{BruteForce, Intersect, Ray, Surfaces};
use boxwood_testkit::agreement::{self, Compared};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Random, effort};

fn figures() -> Scene {
    Scene::new()
        .segment([6.0, -1.0], [6.0, 3.0])
        .circle([4.0, 1.0], 1.0)
        .triangle([[1.0, 5.0], [0.0, 3.0], [2.0, 3.0]])
        .rectangle([8.0, 0.0], [9.0, 2.0])
}

/// Where a ray meets the figures: `t` and number.
fn met(scene: &Scene, ray: Ray) -> Vec<(f32, u32)> {
    let prisms = scene.prisms().expect("good figures");
    let hits = BruteForce::new(&prisms).all_hits(&ray);
    hits.iter().map(|hit| (hit.t, hit.primitive)).collect()
}

#[test]
fn hits_by_hand() {
    let scene = figures();
    for (origin, direction, expected) in [
        (
            [0.0, 1.0],
            [1.0, 0.0],
            &[(3.0, 1), (5.0, 1), (6.0, 0), (8.0, 3), (9.0, 3)][..],
        ),
        // From inside the circle, backwards; twice as fast.
        ([4.0, 1.0], [-2.0, 0.0], &[(0.5, 1)]),
        // Through the middle of the triangle, and through its edges half way up.
        ([1.0, 0.0], [0.0, 1.0], &[(3.0, 2), (5.0, 2)]),
        ([-1.0, 4.0], [1.0, 0.0], &[(1.5, 2), (2.5, 2)]),
        // Along the segment, and just past its end.
        ([6.0, -2.0], [0.0, 1.0], &[(1.0, 0), (5.0, 0)]),
        ([0.0, -1.0], [1.0, 0.0], &[(6.0, 0)]),
        ([0.0, -1.01], [1.0, 0.0], &[]),
        // Touching the circle from below.
        (
            [0.0, 0.0],
            [1.0, 0.0],
            &[(4.0, 1), (6.0, 0), (8.0, 3), (9.0, 3)],
        ),
    ] {
        let found = met(&scene, plane::ray(origin, direction));
        assert_eq!(found, expected, "{origin:?} {direction:?}");
    }
}

#[test]
fn surfaces_face_outwards_in_the_plane() {
    let prisms = figures().prisms().expect("good figures");
    let judge = BruteForce::new(&prisms);
    for (origin, direction, normal, uv) in [
        ([0.0, 1.0], [1.0, 0.0], [-1.0, 0.0], [0.5, 0.5]),
        ([7.0, 1.0], [-1.0, 0.0], [-1.0, 0.0], [0.5, 0.5]),
        ([1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.5, 0.5]),
        ([7.0, 1.0], [1.0, 0.0], [-1.0, 0.0], [0.5, 0.5]),
    ] {
        let ray = plane::ray(origin, direction);
        let hit = judge.closest_hit(&ray).expect("straight ahead");
        let surface = prisms.surface(&ray, &hit);
        let [x, y, z] = surface.normal.to_array();
        assert!((x - normal[0]).abs() < 1.0e-6 && (y - normal[1]).abs() < 1.0e-6 && z == 0.0);
        assert_eq!([hit.u, hit.v], uv, "{hit:?}");
        assert_eq!(surface.position.z, 0.0);
        assert!((surface.position - ray.at(hit.t)).length() < 1.0e-5);
    }
}

#[test]
fn bad_figures_are_refused_in_a_sentence() {
    let refused = |scene: Scene| scene.prisms().expect_err("refused").to_string();
    let nan = f32::NAN;
    for (scene, sentence) in [
        (
            Scene::new().segment([1.0; 2], [1.0; 2]),
            "figure 0: its length is zero",
        ),
        (
            Scene::new().segment([nan, 0.0], [1.0; 2]),
            "figure 0: its one end is not finite",
        ),
        (
            figures().circle([0.0; 2], -1.0),
            "figure 4: its radius must not be negative, but is -1",
        ),
        (
            Scene::new().circle([0.0, nan], 1.0),
            "figure 0: its centre is not finite",
        ),
        (
            Scene::new().triangle([[0.0; 2], [1.0; 2], [2.0; 2]]),
            "figure 0: its area is zero",
        ),
        (
            Scene::new().rectangle([1.0; 2], [0.0; 2]),
            "figure 0: its lower corner must be at most its upper corner",
        ),
    ] {
        assert_eq!(refused(scene), sentence);
    }
}

fn random_scene(count: usize, scale: f32, offset: f32, random: &mut Random) -> Scene {
    let mut figures = Vec::new();
    while figures.len() < count {
        let mut point = |size: f32| {
            let p = random.in_cube() * size;
            [p.x, p.y]
        };
        let middle = point(1.0);
        let near = |[x, y]: [f32; 2]| [middle[0] + x, middle[1] + y].map(|x| (x + offset) * scale);
        let [a, b, c] = [(); 3].map(|()| near(point(0.2)));
        figures.push(match figures.len() % 4 {
            0 => Figure::Segment { from: a, to: b },
            1 => Figure::Circle {
                centre: a,
                radius: 0.1 * scale,
            },
            2 => Figure::Triangle { corners: [a, b, c] },
            _ => Figure::Rectangle {
                lower: [a[0].min(b[0]), a[1].min(b[1])],
                upper: [a[0].max(b[0]), a[1].max(b[1])],
            },
        });
    }
    figures.into_iter().collect()
}

/// In the plane, and across it: a prism is a shape like any other.
#[test]
fn structures_agree() {
    for (seed, (scale, offset)) in [
        (1.0, 0.0),
        (1.0e-3, 0.0),
        (1.0e5, 0.0),
        (1.0, 1.0e3),
        (1.0e-30, 0.0),
        (1.0e30, 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        let mut random = Random::new(seed as u64);
        let prisms = random_scene(60, scale, offset, &mut random).prisms();
        let prisms = prisms.expect("good figures");
        let (judge, targets) = (BruteForce::new(&prisms), Targets::of_boxes(&prisms));
        let mut flat = Vec::new();
        for i in 0..effort(60) {
            let at = |random: &mut Random| {
                let p = random.in_cube() * 1.5;
                [p.x, p.y].map(|x| (x + offset) * scale)
            };
            let ([ox, oy], [tx, ty]) = (at(&mut random), at(&mut random));
            let ray = match i % 4 {
                0 => plane::ray([ox, oy], [scale, 0.0]),
                1 => plane::ray([ox, oy], [0.0, -scale]),
                _ => plane::ray([ox, oy], [tx - ox, ty - oy]),
            };
            flat.push(ray);
            let hits = judge.all_hits(&ray);
            flat.extend(hits.iter().take(1).map(|hit| ray.until(hit.t)));
        }
        let case = format!("plane, seed {seed}");
        let found = agreement::check(&prisms, &flat, &case);
        assert!(
            3 * found.hits > found.rays,
            "{case} tests nothing: {found:?}"
        );
        let mut found = Compared::default();
        for (kind, of_kind) in KINDS {
            let rays = sample(of_kind, effort(4), &targets, &judge, &mut random);
            let compared = agreement::check(&prisms, &rays, &format!("{case}, rays `{kind}`"));
            found.rays += compared.rays;
            found.hits += compared.hits;
        }
        assert!(
            10 * found.hits > found.rays,
            "{case} tests nothing: {found:?}"
        );
    }
}
