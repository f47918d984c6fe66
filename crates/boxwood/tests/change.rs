//! Trees that follow their primitives answer as the judge does, and stay about as good as new ones.

use boxwood::{
    Aabb, BruteForce, Decision, Intersect, Isa, Ray, SpatialSplit, TraversalStats, TriangleMesh,
    Updated, Upkeep, Vec3, WideBvh, WideSah,
};
use boxwood_testkit::agreement::Judged;
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Model, Random, effort, shapes, soups};

type Motion = fn(Vec3, &mut Random) -> Vec3;

/// Where a vertex goes.
const MOTIONS: [(&str, Motion); 7] = [
    ("a little", |p, random| p + random.in_cube() * 0.01),
    ("anywhere", |_, random| random.in_cube()),
    ("twisted", |p, _| turned(p, 3.0 * p.z)),
    ("flat", |p, _| Vec3::new(p.x, p.y, 0.5)),
    ("far away", |p, _| p * 3.0 + Vec3::new(1.0e5, -2.0e6, 7.0)),
    ("beyond the doors", |p, _| p * 1.0e-15),
    ("into a point", |_, _| Vec3::splat(1.0)),
];

/// About the z axis.
fn turned(p: Vec3, angle: f32) -> Vec3 {
    let (s, c) = (sine(angle), sine(angle + std::f32::consts::FRAC_PI_2));
    Vec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z)
}

/// A sine that is the same on every machine.
fn sine(x: f32) -> f32 {
    let turn = x / std::f32::consts::TAU;
    let t = turn - turn.floor() - 0.5;
    // Bhaskara's parabola: good enough for a test.
    16.0 * t * (t.abs() - 0.5)
}

fn moved(model: &Model, motion: Motion, random: &mut Random) -> Vec<Vec3> {
    let to = |&p: &[f32; 3]| motion(Vec3::from(p), random);
    model.positions.iter().map(to).collect()
}

fn rays(mesh: &TriangleMesh, count: usize, random: &mut Random) -> Vec<Ray> {
    let targets = Targets::of_mesh(mesh);
    let judge = BruteForce::new(mesh);
    let of = |(_, kind)| sample(kind, effort(count), &targets, &judge, random);
    KINDS.into_iter().flat_map(of).collect()
}

#[test]
fn trees_that_follow_agree() {
    let mut random = Random::new(11);
    let scenes = [
        ("sphere", shapes::sphere(24, 12)),
        ("soup", soups::random(300, &mut random)),
        ("slivers", soups::slivers(120, &mut random)),
        ("duplicates", soups::duplicates(60, &mut random)),
        ("one", soups::random(1, &mut random)),
        ("nothing", Model::default()),
    ];
    let mut hits = 0;
    for (name, model) in scenes {
        let start = model.mesh();
        let cut = SpatialSplit::default().build(&start);
        for (how, motion) in MOTIONS {
            let mut mesh = start.clone();
            let to = moved(&model, motion, &mut random);
            mesh.move_vertices(to).expect("finite");
            let rays = rays(&mesh, 4, &mut random);
            let judged = Judged::new(&mesh, &rays);
            hits += judged.compared().hits;
            let case = format!("{name} moved {how}");
            for isa in Isa::available() {
                let mut eight = WideSah::<8>::default().build(&start).with_isa(isa);
                eight.update(|shown| *shown = &mesh);
                judged.check(&eight, &format!("wide8 {isa}"), &case);
                let mut sixteen = WideSah::<16>::default().build(&start).with_isa(isa);
                sixteen.update(|shown| *shown = &mesh);
                judged.check(&sixteen, &format!("wide16 {isa}"), &case);
                let mut cut = WideBvh::<_, 8>::new(&start, &cut).with_isa(isa);
                cut.update(|shown| *shown = &mesh);
                judged.check(&cut, &format!("cut {isa}"), &case);
            }
        }
    }
    assert!(hits > 1000, "{hits}");
}

/// What follows primitives that stay is as it was: boxes, and the order in which they are met.
#[test]
fn where_nothing_moves_nothing_changes() {
    let mut random = Random::new(12);
    for model in [
        shapes::sphere(40, 30),
        soups::random(2000, &mut random),
        soups::grid(500, &mut random),
    ] {
        let mesh = model.mesh();
        let rays = rays(&mesh, 10, &mut random);
        let look = |bvh: &dyn Intersect| {
            let mut seen: Vec<(Aabb, Option<u32>)> = Vec::new();
            bvh.cells(&mut |cell| seen.push((cell.bounds, cell.primitives)));
            let mut stats = TraversalStats::default();
            for ray in &rays {
                bvh.closest_hit_counted(ray, &mut stats);
                bvh.occluded_counted(ray, &mut stats);
            }
            (seen, stats)
        };
        let mut eight = WideSah::<8>::default().build(&mesh);
        let mut sixteen = WideSah::<16>::default().build(&mesh);
        let before = (look(&eight), look(&sixteen));
        eight.update(|_| ());
        sixteen.update(|_| ());
        assert!(before == (look(&eight), look(&sixteen)));
    }
}

#[test]
#[should_panic(expected = "a tree for other primitives")]
fn a_tree_does_not_follow_a_mesh_with_more_triangles() {
    let (few, more) = (shapes::sphere(8, 4).mesh(), shapes::sphere(9, 5).mesh());
    let mut bvh = WideSah::<8>::default().build(&few);
    bvh.update(|shown| *shown = &more);
}

/// Plays a film, looks at each frame, and says what was done.
fn film(
    model: &Model,
    rays_per_frame: f64,
    frames: usize,
    place: impl Fn(usize, Vec3) -> Vec3,
) -> Vec<Updated> {
    let mut random = Random::new(13);
    let mut kept = Upkeep::new(model.mesh(), WideSah::<8>::default(), rays_per_frame);
    let mut done = Vec::new();
    for frame in 1..=frames {
        let to = model.positions.iter().map(|&p| place(frame, Vec3::from(p)));
        let (moved, updated) = kept.update(|mesh| mesh.move_vertices(to));
        moved.expect("finite");
        assert!(updated.cost <= updated.fitted, "{updated:?}");
        if updated.decision == Decision::Refit {
            assert_eq!(updated.cost, updated.fitted);
        }
        if frame % 5 == 0 || updated.decision != Decision::Refit {
            let mesh = kept.bvh().primitives();
            let rays = rays(mesh, 2, &mut random);
            let judged = Judged::new(mesh, &rays);
            judged.check(kept.bvh(), "kept", &format!("frame {frame}"));
        }
        done.push(updated);
    }
    done
}

fn count(done: &[Updated], what: impl Fn(Decision) -> bool) -> usize {
    done.iter().filter(|u| what(u.decision)).count()
}

/// A mesh that is twisted more and more is built anew now and then, and never costs much more than it did.
#[test]
fn a_twisted_mesh_stays_cheap() {
    let model = shapes::sphere(120, 80);
    let twist = |frame: usize, p: Vec3| turned(p, 0.3 * frame as f32 * p.z);
    let done = film(&model, 1.0e5, 30, twist);
    let careless = film(&model, 0.0, 30, twist);
    assert_eq!(count(&careless, |d| d == Decision::Refit), 30);
    let built = count(&done, |d| d == Decision::Rebuild);
    assert!((1..15).contains(&built), "{built} times");
    let cost = |done: &[Updated]| done.iter().map(|u| u.cost).sum::<f64>();
    assert!(
        cost(&done) < 0.7 * cost(&careless),
        "{} {}",
        cost(&done),
        cost(&careless)
    );
    // The same film, the same decisions.
    assert_eq!(film(&model, 1.0e5, 30, twist), done);
}

/// Where only a part of a mesh is torn apart, only that is built anew.
#[test]
fn a_part_that_explodes_is_built_anew() {
    let near = shapes::sphere(60, 40);
    let model = shapes::sphere(150, 100).placed(4.0, 3.0).with(&near);
    let first = model.positions.len() - near.positions.len();
    let corner = Vec3::from(model.positions[first]);
    let explode = |frame: usize, p: Vec3| {
        if p.length_squared() > 1.1 {
            return p;
        }
        // Neighbours go different ways.
        let hash = (p.x.to_bits() ^ p.y.to_bits().rotate_left(9)).wrapping_mul(0x9e37_79b9);
        let to = |shift: u32| (hash >> shift & 0xff) as f32 / 128.0 - 1.0;
        p + Vec3::new(to(0), to(8), to(16)) * (0.02 * frame as f32)
    };
    assert!(corner.length_squared() < 1.1);
    let done = film(&model, 2.0e5, 12, explode);
    let parts = count(&done, |d| matches!(d, Decision::Parts { .. }));
    assert!(parts > 0, "{done:?}");
    for updated in done {
        if let Decision::Parts { primitives, .. } = updated.decision {
            assert!(primitives <= near.triangles.len() + 300, "{primitives}");
            assert!(updated.cost < updated.fitted);
        }
    }
}

/// Nothing that threads do shows.
#[test]
fn threads_change_nothing() {
    let model = shapes::sphere(100, 70);
    let twist = |frame: usize, p: Vec3| turned(p, 0.8 * frame as f32 * p.z);
    let play = |threads: usize| {
        boxwood_testkit::structures::pool(threads).install(|| film(&model, 1.0e5, 6, twist))
    };
    assert_eq!(play(1), play(3));
}
