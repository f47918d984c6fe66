//! Questions about space: every tree returns the bits of the judge, and the judge is right.

use boxwood::proximity::{
    Ball, ClosestPoint, ConvexRegion, FastWinding, HalfSpace, Hierarchy, Proximity, Region, Winding,
};
use boxwood::{
    Aabb, BinnedSah, BruteForce, Bvh, CompactBvh, CompactSah, KdSah, KdTree, SpatialSplit,
    TriangleMesh, Vec3, WideBvh, WideSah,
};
use boxwood_testkit::scenes::SCENES;
use boxwood_testkit::{Random, effort, shapes, soups};

/// A closest point as bits.
fn bits(p: &ClosestPoint) -> [u32; 7] {
    let [x, y, z] = p.point.to_array();
    let [d, x, y, z, u, v] = [p.distance, x, y, z, p.u, p.v].map(f32::to_bits);
    [d, x, y, z, u, v, p.primitive]
}

/// Everything that is asked of every tree over a mesh.
struct Questions {
    points: Vec<Vec3>,
    radii: Vec<f32>,
    boxes: Vec<Aabb>,
    balls: Vec<Ball>,
    convex: Vec<ConvexRegion>,
    other: TriangleMesh,
}

/// What is answered, bit by bit.
#[derive(PartialEq, Debug)]
struct Answers {
    closest: Vec<Option<[u32; 7]>>,
    nearest: Vec<Vec<[u32; 7]>>,
    within: Vec<Vec<[u32; 7]>>,
    overlapping: Vec<Vec<u32>>,
    pairs: Vec<[u32; 2]>,
    windings: Vec<Winding>,
    numbers: Vec<u64>,
}

impl Questions {
    fn about(mesh: &TriangleMesh, random: &mut Random) -> Self {
        let corners: Vec<Vec3> = (0..mesh.triangles().len())
            .flat_map(|i| mesh.triangle(i))
            .collect();
        let bounds = Aabb::of(corners.iter().copied());
        let size = bounds.scale().clamp(f32::MIN_POSITIVE, 1.0e37);
        let mut points = vec![Vec3::ZERO, Vec3::splat(f32::MAX), Vec3::splat(f32::NAN)];
        let around = |random: &mut Random, by: f32| {
            let at = if corners.is_empty() {
                Vec3::ZERO
            } else {
                corners[random.below(corners.len())]
            };
            let p = at + random.in_cube() * by;
            if p.is_finite() { p } else { at }
        };
        for _ in 0..effort(8) {
            let by = random.pick(&[0.0, 1.0e-7, 1.0e-3, 0.1, 1.0, 3.0]) * size;
            points.push(around(random, by));
        }
        // In the planes of cells and boxes, and on triangles.
        for _ in 0..effort(4).min(corners.len()) {
            let [a, b, c] = mesh.triangle(random.below(corners.len() / 3));
            points.push(a * 0.5 + b * 0.5);
            points.push(a * 0.25 + b * 0.25 + c * 0.5);
            points.push(Vec3::new(a.x, b.y, c.z));
        }
        let radii = points.iter().map(|_| random.unit() * size).collect();
        let some = |random: &mut Random| around(random, 0.2 * size);
        let boxes = (0..effort(6))
            .map(|_| Aabb::of([some(random), some(random)]))
            .chain([
                Aabb::EMPTY,
                Aabb::new([-f32::INFINITY; 3], [f32::INFINITY, 0.0, 0.0]),
            ])
            .collect();
        let balls = (0..effort(6))
            .map(|_| Ball::new(some(random), random.pick(&[0.0, 0.01, 0.3]) * size))
            .collect();
        let convex = (0..effort(6))
            .map(|_| {
                let planes = random.below(6);
                let middle = some(random);
                ConvexRegion::new((0..planes).map(|_| {
                    let normal = random.direction();
                    HalfSpace::behind(middle + normal * (0.2 * size), normal)
                }))
            })
            .collect();
        let model = soups::random(20, random).placed(size.min(1.0e37), 0.0);
        let mut other: Vec<[Vec3; 3]> = (0..20).map(|i| model.mesh().triangle(i)).collect();
        // Neighbours: meetings at corners and along edges.
        other.extend((0..5.min(mesh.triangles().len())).map(|i| mesh.triangle(i)));
        let corners = other
            .iter()
            .flatten()
            .map(|p| if p.is_finite() { *p } else { Vec3::ZERO });
        let numbers = (0..other.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        Self {
            points,
            radii,
            boxes,
            balls,
            convex,
            other: TriangleMesh::new(corners.clone(), numbers).expect("finite corners"),
        }
    }

    fn ask<H: Hierarchy + Sync>(&self, tree: &H) -> Answers {
        let list = |found: Vec<ClosestPoint>| found.iter().map(bits).collect::<Vec<_>>();
        let mut closest = vec![None; self.points.len()];
        tree.closest_points(&self.points, &mut closest);
        let mut windings = vec![Winding::default(); self.points.len()];
        tree.windings(&self.points, &mut windings);
        let mut nearest = vec![Vec::new(); self.points.len()];
        tree.nearest_each(&self.points, 5, &mut nearest);
        for (i, &p) in self.points.iter().enumerate() {
            assert_eq!(tree.closest_point(p), closest[i]);
            assert_eq!(tree.nearest(p, 1).first(), closest[i].as_ref());
            assert_eq!(tree.winding(p), windings[i]);
        }
        let mut overlapping = Vec::new();
        overlapping.extend(self.boxes.iter().map(|b| whole(tree, b)));
        overlapping.extend(self.balls.iter().map(|b| whole(tree, b)));
        overlapping.extend(self.convex.iter().map(|c| whole(tree, c)));
        let other = BinnedSah::default().build(&self.other);
        let other = Bvh::new(&self.other, other);
        let pairs = tree.intersections(&other);
        assert_eq!(tree.intersects(&other), !pairs.is_empty());
        let turned = |&[a, b]: &[u32; 2]| [b, a];
        let mut back: Vec<_> = other.intersections(tree).iter().map(turned).collect();
        back.sort_unstable();
        assert_eq!(back, pairs);
        let points = self.points.iter().zip(&self.radii);
        Answers {
            closest: closest
                .iter()
                .map(|found| found.as_ref().map(bits))
                .collect(),
            nearest: nearest.into_iter().map(list).collect(),
            within: points.map(|(&p, &r)| list(tree.within(p, r))).collect(),
            overlapping,
            pairs,
            windings,
            numbers: self
                .points
                .iter()
                .map(|&p| tree.winding_number(p).to_bits())
                .collect(),
        }
    }
}

fn whole(tree: &impl Proximity, region: &impl Region) -> Vec<u32> {
    let found = tree.overlapping(region);
    assert_eq!(tree.overlaps(region), !found.is_empty());
    found
}

/// Asks every tree; returns what the judge said.
fn check(mesh: &TriangleMesh, questions: &Questions, case: &str) -> Answers {
    let expected = questions.ask(&BruteForce::new(mesh));
    let same = |name: &str, found: Answers| assert_eq!(found, expected, "{name}, {case}");
    let binned = BinnedSah::default().build(mesh);
    let small = BinnedSah {
        max_leaf: 1,
        ..Default::default()
    }
    .build(mesh);
    let cut = SpatialSplit {
        budget: 4.0,
        alpha: 0.0,
        ..Default::default()
    }
    .build(mesh);
    same("wide8", questions.ask(&WideSah::<8>::default().build(mesh)));
    same(
        "wide16",
        questions.ask(&WideSah::<16>::default().build(mesh)),
    );
    same(
        "wide8, cut",
        questions.ask(&WideBvh::<_, 8>::new(mesh, &cut)),
    );
    same("compact", questions.ask(&CompactSah::default().build(mesh)));
    same("compact, cut", questions.ask(&CompactBvh::of(mesh, &cut)));
    same("bvh", questions.ask(&Bvh::new(mesh, binned)));
    same("bvh, leaf=1", questions.ask(&Bvh::new(mesh, small)));
    same("bvh, cut", questions.ask(&Bvh::new(mesh, cut)));
    same(
        "kd",
        questions.ask(&KdTree::new(mesh, KdSah::default().build(mesh))),
    );
    expected
}

#[test]
fn every_tree_agrees() {
    let (mut met, mut pairs, mut inside) = (0, 0, 0);
    for (number, (name, make)) in SCENES.into_iter().enumerate() {
        for (round, triangles) in [10, 200].into_iter().enumerate() {
            let seed = 10 * number as u64 + round as u64;
            let mut random = Random::new(seed);
            let mesh = make(triangles, &mut random).mesh();
            let questions = Questions::about(&mesh, &mut random);
            let found = check(&mesh, &questions, &format!("scene `{name}`, seed {seed}"));
            let near = found.closest.iter().flatten().count();
            assert!(
                mesh.triangles().is_empty() || near + 1 == questions.points.len(),
                "{name}"
            );
            met += found
                .overlapping
                .iter()
                .filter(|ids| !ids.is_empty())
                .count();
            pairs += found.pairs.len();
            inside += found.windings.iter().filter(|w| w.is_inside()).count();
        }
    }
    assert!(
        met > 300 && pairs > 1000 && inside > 100,
        "{met} {pairs} {inside}"
    );
}

/// Points from weights: all of a triangle in small steps.
fn samples([a, b, c]: [Vec3; 3]) -> impl Iterator<Item = [f64; 3]> {
    let wide = move |v: Vec3| v.to_array().map(f64::from);
    let (a, b, c) = (wide(a), wide(b), wide(c));
    (0..=12).flat_map(move |i| {
        (0..=12 - i).map(move |k| {
            let (u, v) = (f64::from(i) / 12.0, f64::from(k) / 12.0);
            core::array::from_fn(|n| a[n] * (1.0 - u - v) + b[n] * u + c[n] * v)
        })
    })
}

fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn the_closest_point_is_on_the_triangle_and_no_other_is_nearer() {
    for (number, (name, make)) in SCENES.into_iter().enumerate() {
        let mut random = Random::new(500 + number as u64);
        let mesh = make(40, &mut random).mesh();
        let questions = Questions::about(&mesh, &mut random);
        let judge = BruteForce::new(&mesh);
        for &p in questions.points.iter().filter(|p| p.is_finite()) {
            let Some(found) = judge.closest_point(p) else {
                assert!(mesh.triangles().is_empty());
                continue;
            };
            let wide = |v: Vec3| v.to_array().map(f64::from);
            let [a, b, c] = mesh.triangle(found.primitive as usize).map(wide);
            let (u, v) = (f64::from(found.u), f64::from(found.v));
            assert!(
                u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1.0e-6,
                "{name}: {found:?}"
            );
            let weighed = core::array::from_fn(|k| a[k] * (1.0 - u - v) + b[k] * u + c[k] * v);
            let size = [a, b, c]
                .iter()
                .flatten()
                .fold(0.0, |m: f64, x| m.max(x.abs()));
            let off = distance(weighed, wide(found.point));
            assert!(
                off <= 1.0e-6 * size + 1.0e-44,
                "{name}: {off} off {found:?}"
            );
            let (from, d) = (wide(p), f64::from(found.distance.min(f32::MAX)));
            let rounding =
                1.0e-6 * d + 1.0e-12 * (size + f64::from(p.abs().max_element())) + 1.0e-44;
            for i in 0..mesh.triangles().len() {
                for q in samples(mesh.triangle(i)) {
                    let other = distance(from, q);
                    assert!(
                        other >= d - rounding,
                        "{name}: {i} is at {other}, not {d} of {found:?}"
                    );
                }
            }
        }
    }
}

/// A point is inside a ball exactly if it is, and holes make the number fall off gently.
#[test]
fn closed_meshes_have_an_inside() {
    let mut random = Random::new(3);
    let meshes = [
        ("sphere", shapes::sphere(24, 16).mesh()),
        ("torus", shapes::torus(20, 12).mesh()),
        ("cube", shapes::cube(4).mesh()),
    ];
    for (name, mesh) in meshes {
        let tree = WideSah::<8>::default().build(&mesh);
        let fast = FastWinding::new(&tree);
        let faster = FastWinding::new(&tree).with_accuracy(1.5);
        let mut worst = [0.0_f64; 2];
        let (mut inside, mut doubtful) = (0, 0);
        for i in 0..effort(2000) {
            // Every other point straight below a corner: above it, many triangles meet.
            let p = if i % 2 == 0 {
                random.in_cube() * 1.5
            } else {
                let corner = mesh.positions()[random.below(mesh.positions().len())];
                Vec3::new(corner.x, corner.y, random.between(-1.5, 1.5))
            };
            let winding = tree.winding(p);
            let number = tree.winding_number(p);
            assert!(
                winding.number == 0 || winding.number == 1,
                "{name}: {winding:?} at {p:?}"
            );
            inside += winding.number;
            if winding.on_surface {
                continue;
            }
            // Angles are as good as doubles, but right at the surface nothing but signs tells.
            let near = tree.closest_point(p).expect("a mesh").distance < 1.0e-6;
            doubtful += usize::from(near);
            if !near {
                assert!(
                    (number - winding.number as f64).abs() < 1.0e-9,
                    "{name}: {number} at {p:?}"
                );
                let about = fast.winding_number(p);
                let errors = [about, faster.winding_number(p)].map(|x| (x - number).abs());
                worst = [worst[0].max(errors[0]), worst[1].max(errors[1])];
                assert!(
                    (about - number).abs() < 0.03,
                    "{name}: {about}, not {number}, at {p:?}"
                );
            }
        }
        assert!(
            inside > 100 && doubtful < 200,
            "{name}: {inside} {doubtful}"
        );
        assert!(
            worst[0] < 0.5 * worst[1],
            "{name}: accuracy does nothing: {worst:?}"
        );
        // Corners lie on the surface, exactly; the point a hair off does not.
        for &corner in mesh.positions() {
            assert!(tree.winding(corner).on_surface, "{name}: {corner:?}");
            let off = Vec3::new(corner.x * 1.01, corner.y * 1.01, corner.z * 1.01);
            assert!(!tree.winding(off).on_surface, "{name}: {off:?}");
        }
        // Inside out, and two of a kind.
        let turned = mesh.triangles().iter().map(|&[a, b, c]| [a, c, b]);
        let turned = TriangleMesh::new(mesh.positions().iter().copied(), turned).expect("a mesh");
        let twice = mesh.triangles().iter().chain(mesh.triangles()).copied();
        let twice = TriangleMesh::new(mesh.positions().iter().copied(), twice).expect("a mesh");
        for _ in 0..200 {
            let p = random.in_cube();
            let number = tree.winding(p).number;
            assert_eq!(BruteForce::new(&turned).winding(p).number, -number);
            assert_eq!(BruteForce::new(&twice).winding(p).number, 2 * number);
        }
    }
}

#[test]
fn fast_winding_numbers_are_near_whatever_the_tree() {
    let mut random = Random::new(4);
    let mesh = shapes::vase(60, 40).mesh();
    let cut = SpatialSplit {
        budget: 4.0,
        alpha: 0.0,
        ..Default::default()
    }
    .build(&mesh);
    let cut = FastWinding::new(Bvh::new(&mesh, cut));
    let kd = FastWinding::new(KdTree::new(&mesh, KdSah::default().build(&mesh)));
    let wide = FastWinding::new(WideSah::<16>::default().build(&mesh));
    let judge = BruteForce::new(&mesh);
    let points: Vec<Vec3> = (0..effort(300)).map(|_| random.in_cube() * 1.5).collect();
    let mut numbers = vec![0.0; points.len()];
    wide.winding_numbers(&points, &mut numbers);
    let mut worst = 0.0_f64;
    for (&p, &number) in points.iter().zip(&numbers) {
        assert_eq!(number.to_bits(), wide.winding_number(p).to_bits());
        let exact = judge.winding_number(p);
        for about in [number, cut.winding_number(p), kd.winding_number(p)] {
            worst = worst.max((about - exact).abs());
        }
    }
    assert!(worst < 0.02, "{worst}");
    assert!(worst > 1.0e-9, "nothing was taken together: {worst}");
    assert!(wide.winding_number([f32::NAN, 0.0, 0.0]).is_nan());
    let nothing = TriangleMesh::default();
    assert_eq!(
        FastWinding::new(BruteForce::new(&nothing)).winding_number([0.0; 3]),
        0.0
    );
}

/// Whether a point is certain to be in a region.
type Holds<'a> = &'a dyn Fn([f64; 3]) -> bool;

/// Boxes, balls and half-spaces against points of the triangles, which are certain to be in them.
#[test]
fn no_sample_in_a_region_is_overlooked() {
    let mut random = Random::new(6);
    let mesh = soups::random(150, &mut random).mesh();
    let tree = WideSah::<8>::default().build(&mesh);
    let mut seen = [0; 2];
    for _ in 0..effort(60) {
        let (p, q) = (random.in_cube(), random.in_cube() * 0.5);
        let b = Aabb::of([p, p + q]);
        let ball = Ball::new(p, random.unit() * 0.5);
        let normals = [(); 3].map(|()| random.direction());
        let wedge = ConvexRegion::new(normals.map(|n| HalfSpace::behind(p, n)));
        let in_box = |x: [f64; 3]| {
            (0..3).all(|k| f64::from(b.lower[k]) <= x[k] && x[k] <= f64::from(b.upper[k]))
        };
        let centre = p.to_array().map(f64::from);
        let in_ball = |x: [f64; 3]| distance(x, centre) < f64::from(ball.radius) - 1.0e-9;
        let in_wedge = |x: [f64; 3]| {
            let before = |n: &Vec3| {
                (0..3)
                    .map(|k| f64::from(n[k]) * (x[k] - centre[k]))
                    .sum::<f64>()
            };
            normals.iter().all(|n| before(n) < -1.0e-6)
        };
        let regions: [(Vec<u32>, Holds<'_>); 3] = [
            (whole(&tree, &b), &in_box),
            (whole(&tree, &ball), &in_ball),
            (whole(&tree, &wedge), &in_wedge),
        ];
        for (found, holds) in regions {
            for i in 0..mesh.triangles().len() {
                let sure = samples(mesh.triangle(i)).any(holds);
                let listed = found.contains(&(i as u32));
                assert!(listed || !sure, "{i}");
                seen[0] += usize::from(listed);
                seen[1] += usize::from(sure);
            }
        }
    }
    // What is listed without a sample inside is touched at a rim: there must be little of it.
    assert!(seen[1] > 500 && 3 * seen[0] < 5 * seen[1], "{seen:?}");
}

/// Meshes on a grid of whole numbers, where everything touches: pairs as a slow search in double precision finds them.
#[test]
fn meeting_triangles_are_those_that_share_samples() {
    let mut random = Random::new(8);
    let (mut sure, mut listed) = (0, 0);
    for _ in 0..effort(10) {
        let a = soups::grid(40, &mut random).mesh();
        let b = soups::grid(40, &mut random).mesh();
        let cut = SpatialSplit {
            budget: 4.0,
            alpha: 0.0,
            ..Default::default()
        }
        .build(&a);
        let (tree, other) = (Bvh::new(&a, cut), WideSah::<8>::default().build(&b));
        let found = tree.intersections(&other);
        listed += found.len();
        for i in 0..40 {
            for k in 0..40 {
                // Twelfths of whole numbers: shared corners, thirds and halves coincide up to rounding.
                let close = |p: [f64; 3]| samples(b.triangle(k)).any(|q| distance(p, q) < 1.0e-12);
                if samples(a.triangle(i)).any(close) {
                    sure += 1;
                    assert!(found.contains(&[i as u32, k as u32]), "{i}, {k}");
                }
            }
        }
    }
    assert!(sure > 500 && listed < 3 * sure, "{sure} of {listed}");
}

/// Callers that flush subnormal numbers to zero, or round upwards, get the same bits.
#[test]
#[allow(unsafe_code, reason = "to set a mode is a promise")]
fn careless_callers_get_the_same() {
    let mut differ = false;
    for (seed, scale) in [(1, 1.0), (2, 1.0e-20), (3, 1.0e-38), (4, 1.0e-41)] {
        let mut random = Random::new(seed);
        let mesh = soups::random(60, &mut random).with(&soups::slivers(20, &mut random));
        let mesh = mesh.placed(scale, 0.0).mesh();
        let questions = Questions::about(&mesh, &mut random);
        let expected = check(&mesh, &questions, "usual mode");
        let mut found = None;
        // SAFETY: all floats are computed behind the doors of the library, or compared as bits.
        unsafe { boxwood::carelessly(|| found = Some(check(&mesh, &questions, "careless"))) };
        assert!(found == Some(expected), "{scale}");
        // The same without a door: the mode counts.
        let raw = |p: &Vec3| {
            let mut search = boxwood::proximity::Closest::new(*p, f32::INFINITY);
            boxwood::proximity::search(&BruteForce::new(&mesh), &mut search, &mut ());
            search.found().map(|found| bits(&found))
        };
        let usual: Vec<_> = questions.points.iter().map(raw).collect();
        let mut careless = Vec::new();
        // SAFETY: as above; what is computed otherwise is only compared.
        let modes = unsafe {
            boxwood::carelessly(|| careless = questions.points.iter().map(raw).collect())
        };
        differ |= usual != careless || !modes;
    }
    assert!(differ, "the mode does not count: this tests nothing");
}

/// One triangle, none, and questions at the ends of what is legal.
#[test]
fn nothing_panics() {
    let nothing = TriangleMesh::default();
    let mut random = Random::new(9);
    let questions = Questions::about(&nothing, &mut random);
    let found = check(&nothing, &questions, "empty");
    assert!(found.closest.iter().all(Option::is_none) && found.pairs.is_empty());
    let mesh = soups::any_floats(30, &mut random).mesh();
    let tree = WideSah::<8>::default().build(&mesh);
    let ends = [
        0.0,
        -0.0,
        1.0e-45,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NAN,
    ];
    let mut found = 0;
    for code in 0..ends.len().pow(3) {
        let [x, y, z] = [1, 7, 49].map(|by| ends[code / by % 7]);
        let p = [x, y, z];
        let judge = BruteForce::new(&mesh);
        assert_eq!(
            tree.nearest(p, usize::MAX).len(),
            if Vec3::from(p).is_finite() { 30 } else { 0 }
        );
        for radius in ends {
            let near = tree.within(p, radius);
            let as_judged = judge.within(p, radius);
            assert_eq!(near.len(), as_judged.len(), "{p:?} {radius}");
            found += near.len();
            assert_eq!(
                tree.overlapping(&Ball::new(p, radius)).len(),
                as_judged.len(),
                "{p:?} {radius}"
            );
            let b = Aabb::new(p, [radius; 3]);
            assert_eq!(tree.overlapping(&b), judge.overlapping(&b), "{b:?}");
            let region = ConvexRegion::new([HalfSpace::new(p, radius)]);
            assert_eq!(
                tree.overlapping(&region),
                judge.overlapping(&region),
                "{p:?} {radius}"
            );
        }
        assert_eq!(tree.winding(p), judge.winding(p));
        assert_eq!(tree.winding_number(p).is_nan(), !Vec3::from(p).is_finite());
    }
    assert!(found > 1000, "{found}");
}
