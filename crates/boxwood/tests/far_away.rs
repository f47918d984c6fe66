//! Scenes far from the world's origin: wide trees see their boxes from the middle of the scene, and nobody notices but the clock.

use boxwood::inspect::Event;
use boxwood::{
    Aabb, BinaryTree, BinnedSah, BruteForce, Bvh, CompactBvh, Intersect, Isa, Ray, SpatialSplit,
    Step, TraversalStats, TriangleMesh, Vec3, WideBvh, WideSah,
};
use boxwood_testkit::adversary::{Named, compare};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Model, Random, effort, shapes, soups};

/// Whole trees and trees of cut primitives, at every level of the machine.
fn wide_trees(mesh: &TriangleMesh) -> Vec<Named<'_>> {
    let whole = BinnedSah::default().build(mesh);
    let cut = SpatialSplit::default().build(mesh);
    let mut all: Vec<Named<'_>> = Vec::new();
    for isa in Isa::available() {
        for (name, tree) in [("whole", &whole), ("cut", &cut)] {
            let eight = WideBvh::<_, 8>::new(mesh, tree).with_isa(isa);
            let sixteen = WideBvh::<_, 16>::new(mesh, tree).with_isa(isa);
            all.push((format!("wide8, {name}, {isa}"), Box::new(eight)));
            all.push((format!("wide16, {name}, {isa}"), Box::new(sixteen)));
            let compact = CompactBvh::of(mesh, tree).with_isa(isa);
            all.push((format!("compact, {name}, {isa}"), Box::new(compact)));
        }
    }
    all
}

/// Some 64 rays beside one another, which run together.
fn bundle(ray: Ray, random: &mut Random) -> Vec<Ray> {
    let width = random.pick(&[1.0e-1, 1.0e-3, 1.0e-5]) * ray.direction.length();
    (0..64)
        .map(|_| Ray {
            direction: ray.direction + random.in_cube() * width,
            ..ray
        })
        .collect()
}

/// Every kind of ray, bundles of some, rays from the world's origin and from far beyond the scene, and some outside the doors.
fn rays(mesh: &TriangleMesh, random: &mut Random) -> Vec<Ray> {
    let (judge, targets) = (BruteForce::new(mesh), Targets::of_mesh(mesh));
    let mut rays = Vec::new();
    for (_, kind) in KINDS {
        rays.extend(sample(kind, 4, &targets, &judge, random));
    }
    for _ in 0..8 {
        let at = mesh.positions()[random.below(mesh.positions().len())];
        let beyond = at * random.pick(&[2.0, -1.0, 1.0e2]);
        for from in [Vec3::ZERO, beyond] {
            let ray = Ray::new(from, at - from);
            rays.extend([ray, ray.until(1.0), Ray::new(from, ray.direction * 1.0e-20)]);
        }
    }
    for _ in 0..3 {
        rays.extend(bundle(random.pick(&rays), random));
    }
    rays
}

fn moved_anywhere(random: &mut Random) -> (String, Model) {
    let model = match random.below(5) {
        0 => shapes::sphere(12, 8),
        1 => shapes::terrain(8, random),
        2 => soups::slivers(80, random),
        3 => soups::mixed_sizes(80, random),
        _ => soups::grid(60, random),
    };
    let scale = 10.0_f32.powi(random.below(6) as i32 - 2);
    let by = [(); 3].map(|()| {
        let far = 10.0_f32.powi(random.below(7) as i32);
        random.pick(&[0.0, far, -far, 1.7 * far])
    });
    let name = format!("moved by {by:?}, times {scale:e}");
    (name, model.moved(by).placed(scale, 0.0))
}

#[test]
fn scenes_anywhere_agree_by_every_way_of_asking() {
    let (mut asked, mut hits) = (0, 0);
    for seed in 0..effort(40) as u64 {
        let mut random = Random::new(seed);
        let (name, model) = moved_anywhere(&mut random);
        let mesh = model.mesh();
        let rays = rays(&mesh, &mut random);
        let found = compare(&mesh, &rays, &wide_trees(&mesh), &mut random);
        let first = found.differences.first();
        assert_eq!(first, None, "seed {seed}, {name}");
        (asked, hits) = (asked + found.rays, hits + found.hits);
    }
    assert!(4 * hits > asked, "tests nothing: {hits} hits of {asked}");
}

/// What a ray through the scene costs: nodes, leaves and triangles of all rays.
fn steps(structure: &dyn Intersect, rays: &[Ray]) -> TraversalStats {
    let mut stats = TraversalStats::default();
    for ray in rays {
        structure.closest_hit_counted(ray, &mut stats);
    }
    stats
}

/// From one point of the scene's surroundings to another.
fn through(bounds: Aabb, count: usize) -> Vec<Ray> {
    let mut random = Random::new(4);
    let (middle, size) = (bounds.centroid(), bounds.size());
    (0..count)
        .map(|_| {
            let [a, b] = [(); 2].map(|()| middle + random.in_cube() * size);
            Ray::between(a, b)
        })
        .collect()
}

#[test]
fn a_scene_far_away_costs_no_more_steps() {
    let near = shapes::sphere(60, 40);
    let far = near.clone().moved([1.0e4, -2.0e4, 5.0e3]);
    let of = |model: &Model| {
        let mesh = model.mesh();
        let rays = through(BruteForce::new(&mesh).bounds(), 2_000);
        let wide = steps(&WideSah::<8>::default().build(&mesh), &rays);
        let binary = steps(&Bvh::new(&mesh, BinnedSah::default().build(&mesh)), &rays);
        (wide, binary)
    };
    let ((near, near_binary), (far, far_binary)) = (of(&near), of(&far));
    let is_close = |a: u64, b: u64| 20 * a.abs_diff(b) <= b;
    assert!(
        is_close(far.nodes, near.nodes)
            && is_close(far.leaves, near.leaves)
            && is_close(far.primitives, near.primitives),
        "{far:?} instead of {near:?}"
    );
    // So that the above says something: a tree that sees the same boxes from the world's origin opens more of them.
    assert!(
        far_binary.leaves > 2 * near_binary.leaves,
        "{far_binary:?}, {near_binary:?}"
    );
}

/// Where the other mesh stands.
const THERE: Vec3 = Vec3::new(4096.0, 0.0, -4096.0);

/// A tree near the origin and the same one moved by powers of two, which no coordinate loses a bit to.
fn here_and_there() -> [(TriangleMesh, BinaryTree); 2] {
    let mut random = Random::new(6);
    let mut here = soups::random(300, &mut random);
    for p in &mut here.positions {
        *p = p.map(|x| (x * 1024.0).round() / 1024.0);
    }
    let there = here.clone().moved(THERE.to_array());
    let mesh = here.mesh();
    let tree = BinnedSah::default().build(&mesh);
    let mut moved = tree.clone();
    for node in &mut moved.nodes {
        node.bounds = beside(node.bounds);
    }
    [(mesh, tree), (there.mesh(), moved)]
}

fn beside(b: Aabb) -> Aabb {
    Aabb {
        lower: b.lower + THERE,
        upper: b.upper + THERE,
    }
}

#[test]
fn cells_are_shown_where_they_are_in_the_world() {
    let [here, there] = here_and_there().map(|(mesh, tree)| {
        let wide = WideBvh::<_, 8>::new(mesh, &tree);
        let mut cells = Vec::new();
        Intersect::cells(&wide, &mut |cell| cells.push((cell.node, cell.bounds)));
        cells
    });
    assert!(here.len() > 50);
    let expected: Vec<_> = here.into_iter().map(|(n, b)| (n, beside(b))).collect();
    assert_eq!(there, expected);
}

#[test]
fn cells_of_compact_trees_hold_those_of_wide_ones() {
    let cells = |structure: &dyn Intersect| {
        let mut cells = Vec::new();
        structure.cells(&mut |cell| cells.push((cell.node, cell.bounds, cell.primitives)));
        cells
    };
    for (mesh, tree) in here_and_there() {
        let wide = cells(&WideBvh::<_, 8>::new(&mesh, &tree));
        let compact = cells(&CompactBvh::of(&mesh, &tree));
        assert!(wide.len() == compact.len() && wide.len() > 50);
        for (exact, rounded) in wide.iter().zip(&compact) {
            assert_eq!((exact.0, exact.2), (rounded.0, rounded.2));
            assert!(rounded.1.contains(&exact.1), "{rounded:?} of {exact:?}");
        }
    }
}

#[test]
fn explanations_tell_of_the_world_and_of_the_same_steps() {
    let [here, there] = here_and_there().map(|(mesh, tree)| WideBvh::<_, 8>::new(mesh, &tree));
    // What a ray is held against, and the leaves that it comes to.
    let told = |wide: &WideBvh<TriangleMesh, 8>, ray: &Ray| {
        let (mut boxes, mut leaves) = (Vec::new(), Vec::new());
        for event in wide.explain(ray) {
            match event {
                Event::Step(Step::Box { node, bounds, .. }) => boxes.push((node, bounds)),
                Event::Step(Step::Leaf { node, .. }) => leaves.push(node),
                _ => {}
            }
        }
        (boxes, leaves)
    };
    for ray in through(Intersect::bounds(&there), 200) {
        let near = Ray {
            origin: ray.origin - THERE,
            ..ray
        };
        let (mut boxes, leaves) = told(&here, &near);
        for (_, bounds) in &mut boxes {
            *bounds = beside(*bounds);
        }
        assert_eq!(told(&there, &ray), (boxes, leaves), "{ray:?}");
    }
}

/// Distances are computed in the world: no box may be passed over for being shown a little elsewhere.
#[test]
fn questions_about_space_agree() {
    use boxwood::Proximity;
    let mut random = Random::new(9);
    let model = soups::random(400, &mut random).moved([3.0e3, 0.0, -7.0e2]);
    let mesh = model.mesh();
    let wide = WideSah::<16>::default().build(&mesh);
    let binary = Bvh::new(&mesh, BinnedSah::default().build(&mesh));
    for _ in 0..500 {
        let p = Vec3::from([3.0e3, 0.0, -7.0e2]) + random.in_cube() * 3.0;
        let [a, b] = [wide.closest_point(p), binary.closest_point(p)];
        assert_eq!(a, b, "{p:?}");
    }
}
