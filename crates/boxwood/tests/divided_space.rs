//! Structures that divide space: what they keep to when memory is short, when somebody cancels, and when nothing separates.

use boxwood::accel::bsp_tree;
use boxwood::accel::octree;
use boxwood::{
    Aabb, Axes, BspSah, BspTree, BuildError, Intersect, Limits, Octree, OctreeBuilder, Ray,
    StructureKind, TriangleMesh,
};
use boxwood_testkit::structures::pool;
use boxwood_testkit::{Random, agreement, shapes, soups};
use std::ops::ControlFlow::{Break, Continue};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

fn kinds() -> [StructureKind; 2] {
    ["octree", "bsp"].map(|name| name.parse().expect("a good name"))
}

fn soup(count: usize) -> TriangleMesh {
    soups::random(count, &mut Random::new(5)).mesh()
}

#[test]
fn a_memory_cap_is_kept_or_refused() {
    let mesh = soup(3_000);
    let ray = Ray::new([-3.0, 0.1, 0.2], [1.0, 0.0, 0.0]);
    for kind in kinds() {
        let whole = kind.build(&mesh);
        let (mut built, mut refused, mut smaller) = (0, 0, 0);
        for power in 10..26 {
            let cap = 1 << power;
            let limits = Limits {
                memory: Some(cap),
                ..Limits::NONE
            };
            match kind.build_within(&mesh, &limits) {
                Ok(structure) => {
                    built += 1;
                    let bytes = structure.statistics().bytes;
                    assert!(bytes <= cap, "{kind}: {bytes} of {cap}");
                    smaller += usize::from(bytes < whole.statistics().bytes);
                    assert_eq!(structure.all_hits(&ray), whole.all_hits(&ray), "{kind}");
                }
                Err(BuildError::Memory { needed, allowed }) => {
                    refused += 1;
                    assert!(needed > allowed && allowed == cap, "{kind}: {needed} {cap}");
                }
                Err(error) => panic!("{kind}: {error}"),
            }
        }
        assert!(built > 3 && refused > 3, "{kind}: {built} {refused}");
        assert!(smaller > 0, "{kind}: little memory makes a smaller tree");
    }
}

#[test]
fn a_build_ends_when_somebody_says_so() {
    let mesh = soup(3_000);
    for kind in kinds() {
        for end in [0.0, 0.3, 0.9, 1.0] {
            let last = AtomicU32::new(0);
            let watch = |share: f32| {
                assert!((0.0..=1.0).contains(&share), "{kind}: {share}");
                last.fetch_max(share.to_bits(), Relaxed);
                if share >= end {
                    Break(())
                } else {
                    Continue(())
                }
            };
            let limits = Limits {
                watch: Some(&watch),
                ..Limits::NONE
            };
            let built = kind.build_within(&mesh, &limits).map(|_| ());
            assert_eq!(built, Err(BuildError::Cancelled), "{kind} at {end}");
            let last = f32::from_bits(last.load(Relaxed));
            assert!(
                last < end + 0.5,
                "{kind}: told to end at {end}, asked at {last}"
            );
        }
    }
}

/// Neither identical nor overlapping triangles, nor a fan around one corner, may multiply without end.
#[test]
fn references_are_bounded() {
    let fan = (0..4_000).map(|i| {
        let at = |k: i32| {
            let angle = k as f32 * 0.001_57;
            [angle.cos(), angle.sin(), 0.3]
        };
        [[0.0; 3], at(i), at(i + 1)]
    });
    let fan = boxwood_testkit::Model::of_triangles(fan);
    let overlapping = (0..500).map(|i| {
        let far = 1.0 + i as f32 * 1.0e-5;
        [[-far, -far, far], [far, -far, -far], [0.0, far, 0.0]]
    });
    let overlapping = boxwood_testkit::Model::of_triangles(overlapping);
    for (name, model) in [
        ("identical", soups::identical(4_000)),
        ("fan", fan),
        ("overlapping", overlapping),
    ] {
        let mesh = model.mesh();
        let n = mesh.triangles().len();
        for kind in kinds() {
            let found = kind.build(&mesh).statistics();
            assert!(
                found.references <= 24 * n + 1_024,
                "{name}, {kind}: {found:?}"
            );
            assert!(found.bytes <= 600 * n + 16_384, "{name}, {kind}: {found:?}");
            assert!(found.depth <= bsp_tree::MAX_DEPTH.max(octree::MAX_DEPTH));
        }
    }
}

#[test]
fn trees_do_not_depend_on_threads() {
    let mesh = soups::mixed_sizes(20_000, &mut Random::new(3)).mesh();
    let octree = pool(1).install(|| OctreeBuilder::default().build(&mesh));
    for threads in [2, 3] {
        let other = pool(threads).install(|| OctreeBuilder::default().build(&mesh));
        assert!(octree == other, "octree, {threads} threads");
    }
    let mesh = soup(1_500);
    let bsp = pool(1).install(|| BspSah::default().build(&mesh));
    for threads in [2, 3] {
        let other = pool(threads).install(|| BspSah::default().build(&mesh));
        assert!(bsp == other, "bsp, {threads} threads");
    }
}

#[test]
fn planes_lean_only_where_they_may() {
    let mesh = shapes::sphere(20, 12).mesh();
    let below_limit = BspSah::default();
    let leaning = |builder: BspSah| {
        let data = builder.build(&mesh);
        let (mut sides, slanted) = (0, data.is_slanted());
        BspTree::new(&mesh, data).cells(&mut |cell| sides += cell.sides.len());
        (sides > 0, slanted)
    };
    assert_eq!(leaning(below_limit), (true, true));
    assert_eq!(
        leaning(BspSah {
            limit: 100,
            ..below_limit
        }),
        (false, false)
    );
    // In the plane, walls stand upright: whatever leans does so in x and y.
    let axes = Axes::XY;
    let data = BspSah {
        axes,
        ..below_limit
    }
    .build(&mesh);
    let bounds = Intersect::bounds(&BspTree::new(&mesh, data.clone()));
    BspTree::new(&mesh, data).cells(&mut |cell| {
        let [lower, upper] = [cell.bounds.lower.z, cell.bounds.upper.z];
        assert_eq!([lower, upper], [bounds.lower.z, bounds.upper.z], "{cell:?}");
    });
}

/// Every triangle is in the leaf of each of its corners' surroundings, and leaves fill the root.
#[test]
fn leaves_fill_the_root() {
    let mesh = soup(400);
    let around = Aabb::of(mesh.positions().iter().copied());
    let octree = Octree::new(&mesh, OctreeBuilder::default().build(&mesh));
    let volume = |b: &Aabb| {
        let size = b.intersection(around).size();
        f64::from(size.x) * f64::from(size.y) * f64::from(size.z)
    };
    let mut filled = 0.0;
    octree.cells(&mut |cell| {
        if cell.primitives.is_some() {
            filled += volume(&cell.bounds);
        }
    });
    let whole = volume(&around);
    assert!(
        (filled - whole).abs() < 1.0e-4 * whole,
        "{filled} of {whole}"
    );
}

#[test]
fn a_ray_along_the_planes_asks_both_sides() {
    let mut random = Random::new(8);
    let mesh = soups::grid(200, &mut random).mesh();
    let mut rays = Vec::new();
    for i in 0..60 {
        let triangle = mesh.triangle(i);
        let edge = triangle[1] - triangle[0];
        // Along edges and in the planes of triangles, which are planes of the tree.
        rays.push(Ray::new(triangle[0] - edge * 3.0, edge));
        rays.push(Ray::new(triangle[2] - edge, edge * 2.0));
        rays.push(Ray::new(
            triangle[0],
            triangle[1] + triangle[2] - triangle[0] * 2.0,
        ));
    }
    assert!(agreement::check(&mesh, &rays, "along the planes").hits > 10);
}
