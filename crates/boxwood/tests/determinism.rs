//! Threads change nothing: the same trees node for node, the same answers ray for ray.

use boxwood::{
    BinaryTree, BinnedSah, Bvh, EqualCounts, Intersect, Lbvh, Median, Middle, Ploc, Ray, Refine,
    SpatialSplit, SweepSah,
};
use boxwood_testkit::structures::pool;
use boxwood_testkit::{Model, Random, shapes, soups};

/// Large enough to be built and binned side by side.
fn models() -> [(&'static str, Model); 3] {
    let mut random = Random::new(1);
    [
        (
            "random",
            soups::random(60_000, &mut random).with(&soups::mixed_sizes(8_000, &mut random)),
        ),
        ("grid", soups::grid(20_000, &mut random)),
        ("sphere", shapes::sphere(150, 100)),
    ]
}

#[test]
fn trees_do_not_depend_on_threads() {
    for (name, model) in models() {
        let mesh = model.mesh();
        let builders = [
            BinnedSah::default(),
            BinnedSah {
                bins: 5,
                max_leaf: 1,
                ..Default::default()
            },
        ];
        for builder in builders {
            let expected = pool(1).install(|| builder.build(&mesh));
            for threads in [2, 3, 8] {
                let tree = pool(threads).install(|| builder.build(&mesh));
                // Not `assert_eq!`, which would print a million nodes.
                assert!(tree == expected, "{builder:?}, {name}, {threads} threads");
            }
        }
        let refine = Refine {
            reinsert: 1,
            rotate: 1,
        };
        let all: [(&str, &(dyn Fn() -> BinaryTree + Sync)); 7] = [
            ("median", &|| Median::default().build(&mesh)),
            ("middle", &|| Middle::default().build(&mesh)),
            ("equal", &|| EqualCounts::default().build(&mesh)),
            ("sweep", &|| {
                SweepSah {
                    refine,
                    ..Default::default()
                }
                .build(&mesh)
            }),
            ("sbvh", &|| SpatialSplit::default().build(&mesh)),
            ("lbvh", &|| Lbvh::default().build(&mesh)),
            ("ploc", &|| Ploc::default().build(&mesh)),
        ];
        for (builder, build) in all {
            let expected = pool(1).install(build);
            for threads in [2, 3, 8] {
                let tree = pool(threads).install(build);
                assert!(tree == expected, "{builder}, {name}, {threads} threads");
            }
        }
    }
}

#[test]
fn batches_do_not_depend_on_threads() {
    let mut random = Random::new(2);
    let mesh = soups::random(2_000, &mut random).mesh();
    let bvh = Bvh::new(&mesh, BinnedSah::default().build(&mesh));
    for count in [0, 1, 63, 64, 65, 5_000] {
        let rays: Vec<Ray> = (0..count)
            .map(|_| Ray::new(random.in_cube() * 2.0, random.direction()))
            .collect();
        let expected: Vec<_> = rays.iter().map(|ray| bvh.closest_hit(ray)).collect();
        for threads in [1, 2, 3, 8] {
            let mut hits = vec![None; count];
            let mut occluded = vec![false; count];
            pool(threads).install(|| {
                bvh.closest_hits(&rays, &mut hits);
                bvh.occluded_each(&rays, &mut occluded);
            });
            assert_eq!(hits, expected, "{threads} threads");
            assert!(
                occluded
                    .iter()
                    .zip(&hits)
                    .all(|(o, hit)| *o == hit.is_some())
            );
        }
    }
}
