//! Meshes and rays at the ends of what is legal: bounded work, no panic, the judge's answer.

use boxwood::accel::bvh::MAX_DEPTH;
use boxwood::{
    BinaryTree, BinnedSah, BruteForce, Bvh, EqualCounts, Hit, Intersect, Lbvh, Median, Middle,
    Ploc, Ray, SpatialSplit, SweepSah, TraversalStats, TriangleMesh, inspect,
};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Random, agreement, effort, soups, structures};

/// The trees of all builders, looked at closely.
fn trees(mesh: &TriangleMesh) -> [(&'static str, BinaryTree); 9] {
    let small = BinnedSah {
        bins: 2,
        max_leaf: 1,
        ..Default::default()
    };
    let trees = [
        ("median", Median::default().build(mesh)),
        ("binned", BinnedSah::default().build(mesh)),
        ("binned,bins=2,leaf=1", small.build(mesh)),
        ("middle", Middle::default().build(mesh)),
        ("equal", EqualCounts::default().build(mesh)),
        ("sweep", SweepSah::default().build(mesh)),
        ("sbvh", SpatialSplit::default().build(mesh)),
        ("lbvh", Lbvh::default().build(mesh)),
        ("ploc", Ploc::default().build(mesh)),
    ];
    for (name, tree) in &trees {
        assert_eq!(inspect::validate(tree, mesh), Ok(()), "{name}");
        let found = inspect::Statistics::of_tree(tree);
        assert!(found.depth <= MAX_DEPTH, "{name}: {found:?}");
        assert!(found.largest_leaf <= 8, "{name}: {found:?}");
    }
    trees
}

fn id(hit: Option<Hit>) -> Option<u32> {
    hit.map(|h| h.primitive)
}

#[test]
fn an_empty_mesh_is_a_legal_scene() {
    let mesh = TriangleMesh::default();
    let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    agreement::check(&mesh, &[ray], "empty mesh");
    for entry in structures::all() {
        let name = entry.name();
        let structure = entry.build(&mesh);
        assert!(structure.bounds().is_empty(), "{name}");
        assert_eq!(structure.closest_hit(&ray), None, "{name}");
        assert_eq!(structure.statistics().sah_cost, 0.0, "{name}");
        structure.closest_hits(&[], &mut []);
    }
}

#[test]
fn a_hundred_thousand_identical_triangles() {
    let mesh = soups::identical(100_000).mesh();
    for (name, tree) in trees(&mesh) {
        let depth = inspect::Statistics::of_tree(&tree).depth;
        assert!(depth <= 17, "{name}: halving 100,000 takes {depth} levels");
        let bvh = Bvh::new(&mesh, tree);
        let ray = Ray::new([0.25, 0.25, -1.0], [0.0, 0.0, 1.0]);
        assert_eq!(id(bvh.closest_hit(&ray)), Some(0), "{name}");
        assert_eq!(bvh.all_hits(&ray).len(), 100_000, "{name}");
        let first: Vec<u32> = bvh
            .first_hits(&ray, 3)
            .iter()
            .map(|h| h.primitive)
            .collect();
        assert_eq!(first, [0, 1, 2], "{name}");
        // Whether anything is there is soon known.
        let mut stats = TraversalStats::default();
        assert!(bvh.occluded_counted(&ray, &mut stats), "{name}");
        assert!(
            stats.primitives <= 8 && stats.nodes <= 17,
            "{name}: {stats:?}"
        );
    }
}

#[test]
fn a_long_line_of_triangles() {
    const COUNT: usize = 100_000;
    // Even steps, and steps that grow from 10⁻³⁰ to 10²⁶, which drives the heuristic to peel triangle by triangle.
    for (first, growth) in [(1.0, 1.0), (1.0e-30, 1.0013)] {
        let mesh = soups::line(COUNT, first, growth).mesh();
        for (name, tree) in trees(&mesh) {
            let case = format!("{name}, growth {growth}");
            let bvh = Bvh::new(&mesh, tree);
            let mut random = Random::new(3);
            for _ in 0..effort(50) {
                // Between two triangles, in both directions.
                let i = random.below(COUNT - 1);
                let [a, b] = [i, i + 1].map(|i| mesh.triangle(i)[0].x);
                let from = [a * 0.5 + b * 0.5, 0.25, 0.25];
                if !(a < from[0] && from[0] < b) {
                    continue;
                }
                let mut stats = TraversalStats::default();
                for (direction, expected) in [(1.0, i + 1), (-1.0, i)] {
                    let ray = Ray::new(from, [direction, 0.0, 0.0]);
                    let hit = bvh.closest_hit_counted(&ray, &mut stats);
                    let distance = if direction > 0.0 {
                        b - from[0]
                    } else {
                        from[0] - a
                    };
                    // At the far end neighbours are one and the same; the distance counts.
                    assert_eq!(hit.map(|h| h.t), Some(distance), "{case}, {ray:?}");
                    if growth == 1.0 {
                        assert_eq!(id(hit), Some(expected as u32), "{case}, {ray:?}");
                        assert!(stats.primitives < 1_000, "{case}, {ray:?}: {stats:?}");
                    }
                }
            }
            assert!(
                bvh.occluded(&Ray::new([-1.0, 0.1, 0.1], [1.0, 0.0, 0.0])),
                "{case}"
            );
            assert!(
                !bvh.occluded(&Ray::new([0.5, 0.9, 0.9], [1.0, 0.0, 0.0])),
                "{case}"
            );
        }
    }
}

/// Numbers stay those of the list, whatever lies between.
#[test]
fn triangles_without_area_are_kept_and_never_hit() {
    let mut triangles = Vec::new();
    for i in 0..40 {
        let z = i as f32;
        triangles.push([[0.0, 0.0, z], [4.0, 0.0, z], [0.0, 4.0, z]]);
        // On the way of the rays: a point, an edge there and back, three on a line.
        triangles.push([[1.0, 1.0, z + 0.25]; 3]);
        triangles.push([
            [0.0, 1.0, z + 0.5],
            [4.0, 1.0, z + 0.5],
            [0.0, 1.0, z + 0.5],
        ]);
        triangles.push([
            [0.0, 0.0, z + 0.75],
            [1.0, 1.0, z + 0.75],
            [3.0, 3.0, z + 0.75],
        ]);
    }
    let mesh = boxwood_testkit::Model::of_triangles(triangles).mesh();
    let ray = Ray::new([1.0, 1.0, -1.0], [0.0, 0.0, 2.0]);
    agreement::check(&mesh, &[ray], "without area");
    for entry in structures::all() {
        let name = entry.name();
        let hits = entry.build(&mesh).all_hits(&ray);
        let found: Vec<u32> = hits.iter().map(|h| h.primitive).collect();
        let expected: Vec<u32> = (0..40).map(|i| 4 * i).collect();
        assert_eq!(found, expected, "{name}");
    }
}

/// Rays in the sides of boxes and in the planes of flat ones, with zeros of both signs.
#[test]
fn rays_in_box_planes() {
    let mut random = Random::new(9);
    let mut hits = 0;
    for (round, grid) in [
        soups::grid(80, &mut random),
        soups::flat(80, 2, &mut random),
    ]
    .into_iter()
    .enumerate()
    {
        let mesh = grid.mesh();
        let mut rays = Vec::new();
        for _ in 0..effort(150) {
            let corners = [(); 3].map(|()| {
                let i = random.below(mesh.triangles().len());
                mesh.triangle(i)[random.below(3)]
            });
            let origin = [corners[0].x, corners[1].y, corners[2].z];
            let direction = [(); 3].map(|()| random.pick(&[0.0, -0.0, 1.0, -1.0]));
            let ray = Ray::new(origin, direction);
            let back = [0, 1, 2].map(|k| origin[k] - 16.0 * direction[k]);
            rays.extend([ray, Ray::new(back, direction)]);
        }
        hits += agreement::check(&mesh, &rays, &format!("box planes, round {round}")).hits;
    }
    assert!(hits > 40, "{hits}");
}

/// Near the largest and the smallest floats: nothing panics, and all agree even where little can be hit.
#[test]
fn the_ends_of_the_floats() {
    let max = f32::MAX;
    let tiny = f32::from_bits(1);
    for (name, far) in [
        ("largest", max),
        ("half", max / 2.0),
        ("subnormal", tiny),
        ("1e-40", 1.0e-40),
    ] {
        let mesh = boxwood_testkit::Model::of_triangles([
            [[-far, -far, 0.0], [far, -far, 0.0], [0.0, far, 0.0]],
            [[far, far, far], [far, -far, far], [-far, far, far]],
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            [[-far, 0.0, -far], [far, 0.0, -far], [0.0, 0.0, far]],
        ]);
        let mesh = mesh.mesh();
        let mut rays = Vec::new();
        for from in [0.0, 0.25, -1.0, far, -far, far / 3.0] {
            for along in [0.0, -0.0, 1.0, tiny, -far, f32::NAN, f32::INFINITY] {
                rays.push(Ray::new([from, 0.25, -1.0], [along, 0.0, 1.0]));
                rays.push(Ray::new([0.25, from, from], [0.1, along, -1.0]));
                rays.push(Ray::new([from; 3], [along; 3]));
            }
        }
        let hits = agreement::check(&mesh, &rays, name).hits;
        assert!(hits > 0, "{name}");
    }
}

#[test]
fn a_triangle_at_any_ordinary_size_is_hit() {
    for power in -100..=100 {
        let s = 2.0_f32.powi(power);
        let mesh = boxwood_testkit::Model::of_triangles([[[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0]]]);
        let mesh = mesh.mesh();
        for entry in structures::all() {
            let name = entry.name();
            // As long as products stay within the floats, all sizes are alike.
            let expected = (-40..=40).contains(&power).then_some(1.0);
            let hit = entry
                .build(&mesh)
                .closest_hit(&Ray::new([0.25 * s, 0.25 * s, -s], [0.0, 0.0, s]));
            assert!(
                hit.is_none_or(|h| h.t == 1.0),
                "{name} at 2^{power}: {hit:?}"
            );
            assert!(expected.is_none() || hit.is_some(), "{name} at 2^{power}");
        }
    }
}

/// Where floats are as coarse as the cells of a grid.
#[test]
fn subnormal_scenes_agree() {
    let mut hits = 0;
    for seed in 0..effort(6) as u64 {
        let mut random = Random::new(seed);
        let scale = random.pick(&[1.0e-37, 1.0e-39, 1.0e-41, 1.0e-43]);
        let soup = soups::random(30, &mut random).with(&soups::slivers(20, &mut random));
        let mesh = soup.placed(scale, 0.0).mesh();
        let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh));
        let mut rays = Vec::new();
        for (_, kind) in KINDS {
            rays.extend(sample(kind, 3, &targets, &judge, &mut random));
        }
        hits += agreement::check(&mesh, &rays, &format!("{scale:e}, seed {seed}")).hits;
    }
    assert!(hits > 20, "{hits} hits test nothing");
}
