//! What holds for every kd-tree: its cells tile the world, its bounds are kept, and it stays as good as it was.

use boxwood::accel::kd_tree::{AxisRule, MAX_DEPTH, PlaneRule};
use boxwood::inspect::{Event, Statistics};
use boxwood::{
    Aabb, BuildError, Intersect, KdLecture, KdSah, KdTree, Limits, Ray, Step, StructureKind,
    TriangleMesh,
};
use boxwood_testkit::structures::pool;
use boxwood_testkit::{Random, shapes, soups};
use std::ops::ControlFlow;
use std::sync::Mutex;

fn kinds() -> Vec<StructureKind> {
    [
        "kd:sah",
        "kd:sah,leaf=1,empty=0.9,depth=64,budget=64",
        "kd:sah,axes=xz",
        "kd:lecture",
        "kd:lecture,axis=longest,split=median,leaf=1",
        "kd:lecture,axes=y,budget=8",
    ]
    .map(|text| text.parse().expect("a good name"))
    .into()
}

fn volume(b: &Aabb) -> f64 {
    let [x, y, z] = b.size().to_array().map(f64::from);
    x * y * z
}

#[test]
fn the_cells_tile_the_world() {
    let mut random = Random::new(3);
    let mesh = soups::mixed_sizes(2_000, &mut random).mesh();
    for kind in kinds() {
        let tree = kind.build(&mesh);
        let (mut leaves, mut inner, mut references) = (Vec::new(), 0, 0);
        tree.cells(&mut |cell| match cell.primitives {
            Some(count) => {
                references += count as usize;
                leaves.push(cell.bounds);
            }
            None => inner += 1,
        });
        let found = tree.statistics();
        assert_eq!((found.leaves, found.nodes), (leaves.len(), inner), "{kind}");
        assert_eq!(found.references, references, "{kind}");
        assert_eq!(leaves.len(), inner + 1, "{kind}");
        assert!(leaves.len() > 10, "{kind} tests nothing");
        // They fill the world and no two share more than a side.
        let sum: f64 = leaves.iter().map(volume).sum();
        let whole = volume(&tree.bounds());
        assert!(
            (sum / whole - 1.0).abs() < 1.0e-6,
            "{kind}: {sum} of {whole}"
        );
        for _ in 0..200 {
            let (b, at) = (tree.bounds(), random.in_cube());
            let p = [0, 1, 2].map(|k| b.centroid()[k] + 0.49 * at[k] * b.size()[k]);
            let is_in = |l: &&Aabb| l.contains(&Aabb::new(p, p));
            assert_eq!(leaves.iter().filter(is_in).count(), 1, "{kind}: {p:?}");
        }
        // Axes that may not be divided are not.
        if kind.to_string().contains("axes=y") {
            let b = tree.bounds();
            let whole = |l: &Aabb| (l.lower.x, l.upper.x) == (b.lower.x, b.upper.x);
            assert!(leaves.iter().all(whole), "{kind}");
        }
    }
}

#[test]
fn budget_and_depth_are_obeyed() {
    let mut random = Random::new(4);
    let scenes = [
        ("identical", soups::identical(3_000).mesh()),
        ("needles", soups::needles(1_000, &mut random).mesh()),
        ("mixed", soups::mixed_sizes(3_000, &mut random).mesh()),
    ];
    for (name, mesh) in &scenes {
        let n = mesh.triangles().len();
        for budget in [1.0, 1.5, 4.0, 64.0] {
            for depth in [0, 5, MAX_DEPTH] {
                let sah = KdSah {
                    budget,
                    max_depth: Some(depth),
                    ..Default::default()
                };
                let lecture = KdLecture {
                    budget,
                    max_depth: Some(depth),
                    ..Default::default()
                };
                for partition in [sah.build(mesh), lecture.build(mesh)] {
                    let found = KdTree::new(mesh, partition).statistics();
                    let case = format!("{name}, budget {budget}, depth {depth}: {found:?}");
                    let most = (budget * n as f32) as usize + 16;
                    assert!(found.references <= most && found.leaves <= most, "{case}");
                    assert!(found.depth <= depth, "{case}");
                    assert!(found.references >= n, "{case}");
                }
            }
        }
    }
}

/// Steps that grow by a thousandth each tempt the heuristic to peel triangle by triangle.
#[test]
fn the_depth_is_not_used_up_by_peeling() {
    let mesh = soups::line(20_000, 1.0, 1.001).mesh();
    let found = KdTree::new(&mesh, KdSah::default().build(&mesh)).statistics();
    assert!(found.largest_leaf <= 64, "{found:?}");
}

#[test]
fn memory_is_kept_within_the_limit() {
    let mut random = Random::new(5);
    let mesh = soups::random(5_000, &mut random).mesh();
    for kind in kinds() {
        let free = kind.build(&mesh).statistics();
        let (mut refused, mut smaller, mut same) = (0, 0, 0);
        for shift in 8..28 {
            let memory = 1_usize << shift;
            let limits = Limits {
                memory: Some(memory),
                ..Limits::NONE
            };
            match kind.build_within(&mesh, &limits) {
                Err(error) => {
                    assert!(
                        matches!(error, BuildError::Memory { allowed, .. } if allowed == memory)
                    );
                    refused += 1;
                }
                Ok(tree) => {
                    let found = tree.statistics();
                    assert!(found.bytes <= memory, "{kind}: {found:?} in {memory}");
                    smaller += usize::from(found.references < free.references);
                    same += usize::from(found == free);
                }
            }
        }
        assert!(
            refused > 5 && smaller > 0 && same > 0,
            "{kind}: {refused} {smaller} {same}"
        );
    }
}

#[test]
fn builds_tell_of_progress_and_can_be_cancelled() {
    let mut random = Random::new(6);
    let mesh = soups::random(30_000, &mut random).mesh();
    for kind in kinds() {
        let told = Mutex::new(Vec::new());
        let watch = |share: f32| {
            told.lock().expect("no panic").push(share);
            ControlFlow::Continue(())
        };
        let limits = Limits {
            watch: Some(&watch),
            ..Limits::NONE
        };
        assert!(kind.build_within(&mesh, &limits).is_ok());
        let told = told.into_inner().expect("no panic");
        assert!(
            told.len() > 10 && told.last() == Some(&1.0),
            "{kind}: {told:?}"
        );
        let cancel = |_: f32| ControlFlow::Break(());
        let limits = Limits {
            watch: Some(&cancel),
            ..Limits::NONE
        };
        let ended = kind.build_within(&mesh, &limits).map(|_| ());
        assert_eq!(ended, Err(BuildError::Cancelled), "{kind}");
    }
}

#[test]
fn threads_change_nothing() {
    let mut random = Random::new(7);
    let mesh = soups::random(40_000, &mut random).mesh();
    let build = |threads| {
        pool(threads).install(|| {
            (
                KdSah::default().build(&mesh),
                KdLecture::default().build(&mesh),
            )
        })
    };
    let expected = build(1);
    for threads in [2, 3, 8] {
        // Not `assert_eq!`, which would print a million nodes.
        assert!(build(threads) == expected, "{threads} threads");
    }
}

#[test]
fn a_ray_is_explained_step_by_step() {
    let mesh = shapes::sphere(30, 20).mesh();
    let tree = KdTree::new(&mesh, KdSah::default().build(&mesh));
    let events = tree.explain(&Ray::new([-3.0, 0.1, 0.2], [1.0, 0.0, 0.0]));
    let count = |is: fn(&Step) -> bool| {
        let steps = events
            .iter()
            .filter(|e| matches!(e, Event::Step(step) if is(step)));
        steps.count()
    };
    assert!(matches!(events[0], Event::Step(Step::Box { node: 0, .. })));
    assert!(count(|s| matches!(s, Step::Plane { near: true, .. })) > 2);
    assert!(count(|s| matches!(s, Step::Leaf { .. })) > 0);
    // What lies behind the hit is dropped.
    assert!(count(|s| matches!(s, Step::Resumed { dropped: true, .. })) > 0);
    assert!(events.iter().any(|e| matches!(e, Event::Hit { .. })));
}

/// The surface-area cost and references per primitive of a builder's tree.
fn quality(mesh: &TriangleMesh) -> [Statistics; 3] {
    let median = KdLecture {
        axis: AxisRule::Longest,
        split: PlaneRule::Median,
        ..Default::default()
    };
    [
        KdLecture::default().build(mesh),
        median.build(mesh),
        KdSah::default().build(mesh),
    ]
    .map(|partition| KdTree::new(mesh, partition).statistics())
}

/// `(scene, mesh, costs of middle in turn, median of the longest, surface area)`.
fn recorded() -> [(&'static str, TriangleMesh, [f32; 3]); 4] {
    let mut random = Random::new(11);
    let ball = shapes::sphere(60, 40);
    [
        ("sphere", ball.mesh(), [76.101, 147.91, 51.743]),
        (
            "random",
            soups::random(4_000, &mut random).mesh(),
            [157.63, 184.04, 135.37],
        ),
        (
            "ball in a stadium",
            shapes::cube(8).placed(100.0, 0.0).with(&ball).mesh(),
            [39.879, 225.66, 47.249],
        ),
        (
            "mixed sizes",
            soups::mixed_sizes(4_000, &mut random).mesh(),
            [107.72, 165.46, 95.041],
        ),
    ]
}

#[test]
fn no_tree_is_worse_than_recorded() {
    let mut report = String::new();
    for (name, mesh, expected) in recorded() {
        for (found, expected) in quality(&mesh).into_iter().zip(expected) {
            // Half a percent for other machines' sines. Much better is worth recording too.
            if !(0.95 * expected..=1.005 * expected).contains(&found.sah_cost) {
                report += &format!("{name}: {} instead of {expected}\n", found.sah_cost);
            }
        }
    }
    assert!(report.is_empty(), "other costs than recorded:\n{report}");
}

#[test]
fn the_heuristic_pays() {
    for (name, mesh, _) in recorded() {
        let [middle, median, sah] = quality(&mesh).map(|found| found.sah_cost);
        assert!(sah < 0.8 * median, "{name}: {sah} against {median}");
        // Halving happens to fit a small ball in the middle of a large room.
        let least = if name == "ball in a stadium" {
            1.25
        } else {
            0.9
        };
        assert!(sah < least * middle, "{name}: {sah} against {middle}");
    }
}
