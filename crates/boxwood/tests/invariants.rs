//! What holds for every tree of every builder, over boxes of any kind.

use boxwood::accel::bvh::MAX_DEPTH;
use boxwood::accel::bvh::refine;
use boxwood::{
    Aabb, BinaryTree, BinnedSah, BuildError, Counters, EqualCounts, Hit, Lbvh, Limits, Median,
    Middle, Ploc, PreparedRay, Primitives, Query, Ray, Refine, SpatialSplit, StructureKind,
    SweepSah, inspect,
};
use boxwood_testkit::{Random, agreement, soups};
use proptest::prelude::*;
use std::ops::ControlFlow;

/// Boxes as primitives of a user's own. Each claims to be hit wherever it is asked, which structures must see through.
#[derive(Clone, Debug)]
struct Boxes(Vec<Aabb>);

impl Primitives for Boxes {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, i: usize) -> Aabb {
        self.0[i]
    }
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        _: &PreparedRay,
        query: &mut Q,
        _: &mut C,
    ) -> ControlFlow<()> {
        for t in [0.0, 0.5, 1.0, 3.0, f32::NAN, f32::INFINITY, -1.0] {
            query.offer(Hit {
                t: t + i as f32 * 1.0e-3,
                u: 0.0,
                v: 0.0,
                primitive: i as u32,
                instance: 0,
            })?;
        }
        ControlFlow::Continue(())
    }
}

/// Whole numbers, so that ties are frequent, with a few that no box should have.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        40 => (-4_i8..5).prop_map(f32::from),
        4 => any::<f32>(),
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(f32::NEG_INFINITY),
        1 => Just(-0.0),
        1 => Just(1.0e-40),
        1 => Just(f32::MAX),
    ]
}

/// Any box: upright, inverted, empty, infinite, of NaN.
fn wild_box() -> impl Strategy<Value = Aabb> {
    let corners = (
        prop::array::uniform3(coordinate()),
        prop::array::uniform3(coordinate()),
    );
    (corners, any::<u8>()).prop_map(|((a, b), inverted)| match inverted {
        0..16 => Aabb::new(a, b),
        16..24 => Aabb::EMPTY,
        _ => Aabb::of([a, b]),
    })
}

/// Upright boxes on the grid, many of them equal or flat.
fn tame_box() -> impl Strategy<Value = Aabb> {
    let corner = prop::array::uniform3((-4_i8..5).prop_map(f32::from));
    let size = prop::array::uniform3((0_i8..3).prop_map(f32::from));
    (corner, size).prop_map(|(p, s)| Aabb::new(p, [p[0] + s[0], p[1] + s[1], p[2] + s[2]]))
}

fn holds(boxes: &Boxes, tree: &BinaryTree, most: usize) -> Result<(), TestCaseError> {
    prop_assert_eq!(inspect::validate(tree, boxes), Ok(()));
    let n = boxes.0.len();
    let mut order = tree.order.clone();
    order.sort_unstable();
    prop_assert!(order.into_iter().eq(0..n as u32));
    let found = inspect::Statistics::of_tree(tree);
    prop_assert_eq!((found.primitives, found.references), (n, n));
    prop_assert_eq!(found.nodes + found.leaves, tree.nodes.len());
    prop_assert_eq!(found.nodes, found.leaves.saturating_sub(1));
    prop_assert!(found.largest_leaf <= most && found.depth <= MAX_DEPTH);
    prop_assert_eq!(found.bytes, 32 * tree.nodes.len() + 4 * n);
    prop_assert!(!found.sah_cost.is_nan() && found.sah_cost >= 0.0);
    Ok(())
}

/// What holds for trees that cut primitives: every part is somewhere, and there are not too many.
fn holds_with_cuts(
    boxes: &Boxes,
    tree: &BinaryTree,
    most: usize,
    budget: f32,
) -> Result<(), TestCaseError> {
    prop_assert_eq!(inspect::validate(tree, boxes), Ok(()));
    let n = boxes.0.len();
    let found = inspect::Statistics::of_tree(tree);
    prop_assert_eq!((found.primitives, found.references), (n, tree.order.len()));
    prop_assert!(found.references as f32 <= budget * n as f32);
    prop_assert!(found.largest_leaf <= most && found.depth <= MAX_DEPTH);
    Ok(())
}

fn all_hold(boxes: &Boxes, bins: usize, leaf: usize) -> Result<(), TestCaseError> {
    // Settings beyond their range are brought into it.
    let most = leaf.clamp(1, 64);
    let max_leaf = leaf;
    let refine = Refine {
        reinsert: bins % 3,
        rotate: bins % 2,
    };
    let binned = BinnedSah {
        bins,
        max_leaf,
        ..Default::default()
    };
    let median = Median {
        max_leaf,
        ..Default::default()
    };
    let middle = Middle {
        max_leaf,
        refine,
        ..Default::default()
    };
    let equal = EqualCounts {
        max_leaf,
        refine,
        ..Default::default()
    };
    let sweep = SweepSah {
        max_leaf,
        refine,
        ..Default::default()
    };
    let lbvh = Lbvh {
        max_leaf,
        block: bins,
        refine,
        ..Default::default()
    };
    let ploc = Ploc {
        radius: bins,
        max_leaf,
        refine,
        ..Default::default()
    };
    for tree in [
        binned.build(boxes),
        median.build(boxes),
        middle.build(boxes),
        equal.build(boxes),
        sweep.build(boxes),
        lbvh.build(boxes),
        ploc.build(boxes),
    ] {
        holds(boxes, &tree, most)?;
    }
    let spatial = SpatialSplit {
        budget: 2.0,
        alpha: 0.0,
        bins,
        max_leaf,
        refine,
        ..Default::default()
    };
    holds_with_cuts(boxes, &spatial.build(boxes), most, 2.0)
}

/// Refinements keep trees whole, and the three that optimise never raise the cost.
fn refinements_hold(boxes: &Boxes, tree: &BinaryTree) -> Result<(), TestCaseError> {
    let cost = |tree: &BinaryTree| inspect::Statistics::of_tree(tree).sah_cost;
    type Refinement<'a> = (&'a str, &'a dyn Fn(&mut BinaryTree));
    let refinements: [Refinement<'_>; 3] = [
        ("reinsertion", &|tree| refine::reinsertion(tree, 3)),
        ("rotation", &|tree| refine::rotation(tree, 3)),
        ("collapse", &|tree| refine::collapse_leaves(tree, 6)),
    ];
    for (name, refinement) in refinements {
        let mut refined = tree.clone();
        refinement(&mut refined);
        prop_assert_eq!(inspect::validate(&refined, boxes), Ok(()), "{}", name);
        let (before, after) = (cost(tree), cost(&refined));
        prop_assert!(after <= before * 1.000_01, "{name}: {before} to {after}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn trees_of_tame_boxes_are_whole(
        boxes in prop::collection::vec(tame_box(), 0..300), bins in 0_usize..80, leaf in 0_usize..70,
    ) {
        all_hold(&Boxes(boxes), bins, leaf)?;
    }

    #[test]
    fn trees_of_wild_boxes_are_whole(
        boxes in prop::collection::vec(wild_box(), 0..100), bins in 0_usize..80, leaf in 0_usize..20,
    ) {
        all_hold(&Boxes(boxes), bins, leaf)?;
    }

    /// Even primitives that lie about where they are hit, with boxes that are none, look the same in every structure.
    #[test]
    fn wild_boxes_agree(
        boxes in prop::collection::vec(wild_box(), 0..40),
        rays in prop::collection::vec((prop::array::uniform3(coordinate()), prop::array::uniform3(coordinate())), 1..6),
    ) {
        let rays: Vec<Ray> = rays.into_iter().map(|(o, d)| Ray::new(o, d)).collect();
        agreement::check(&Boxes(boxes.clone()), &rays, &format!("boxes {boxes:?}"));
    }

    /// The cost is that of the definition, summed by hand.
    #[test]
    fn costs_add_up(boxes in prop::collection::vec(tame_box(), 1..100)) {
        let tree = BinnedSah::default().build(&Boxes(boxes));
        let area = |b: &Aabb| f64::from(b.half_area());
        let whole = area(&tree.nodes[0].bounds);
        let sum: f64 = tree.nodes.iter().map(|n| area(&n.bounds) * f64::from(n.count.max(1))).sum();
        let expected = if whole > 0.0 { (sum / whole) as f32 } else { 0.0 };
        let found = inspect::Statistics::of_tree(&tree).sah_cost;
        prop_assert!((found - expected).abs() <= 1.0e-5 * expected, "{found} {expected}");
    }

    #[test]
    fn refinements_keep_trees_whole(boxes in prop::collection::vec(tame_box(), 0..200)) {
        let boxes = Boxes(boxes);
        refinements_hold(&boxes, &Median::default().build(&boxes))?;
        refinements_hold(&boxes, &Median { max_leaf: 1, ..Default::default() }.build(&boxes))?;
        let cut = SpatialSplit { budget: 3.0, alpha: 0.0, max_leaf: 1, ..Default::default() };
        refinements_hold(&boxes, &cut.build(&boxes))?;
    }

    #[test]
    fn refitting_follows(
        boxes in prop::collection::vec((tame_box(), tame_box()), 0..100),
    ) {
        let (before, after): (Vec<Aabb>, Vec<Aabb>) = boxes.into_iter().unzip();
        let (before, after) = (Boxes(before), Boxes(after));
        let cut = SpatialSplit { budget: 3.0, alpha: 0.0, max_leaf: 1, ..Default::default() };
        for mut tree in [BinnedSah::default().build(&before), cut.build(&before)] {
            refine::refit(&mut tree, &after);
            prop_assert_eq!(inspect::validate(&tree, &after), Ok(()));
        }
    }
}

/// No point of a triangle is lost where it is cut: some leaf that names it is around the point.
#[test]
fn parts_cover_their_triangles() {
    let mut random = Random::new(5);
    for mesh in [
        soups::needles(300, &mut random).mesh(),
        soups::slivers(300, &mut random).mesh(),
        soups::grid(300, &mut random).mesh(),
    ] {
        let builder = SpatialSplit {
            budget: 4.0,
            alpha: 0.0,
            max_leaf: 1,
            ..Default::default()
        };
        let tree = builder.build(&mesh);
        assert!(10 * tree.order.len() > 11 * mesh.len(), "little was cut");
        let slack = 1.0e-6;
        for i in 0..mesh.len() {
            let leaves: Vec<Aabb> = tree
                .nodes
                .iter()
                .filter(|n| n.is_leaf() && tree.order[n.places()].contains(&(i as u32)))
                .map(|n| n.bounds)
                .collect();
            let [a, b, c] = mesh.triangle(i);
            for _ in 0..20 {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let p = a + (b - a) * u + (c - a) * v;
                let holds = |leaf: &Aabb| {
                    (0..3).all(|k| leaf.lower[k] - slack <= p[k] && p[k] <= leaf.upper[k] + slack)
                };
                assert!(leaves.iter().any(holds), "triangle {i} at {p:?}");
            }
        }
    }
}

/// Every builder ends when it is told to, and takes no more than it is given.
#[test]
fn limits_end_every_build() {
    let mesh = soups::random(20_000, &mut Random::new(4)).mesh();
    for name in [
        "median",
        "middle",
        "equal",
        "binned",
        "sweep",
        "sweep,reinsert=3,rotate=2",
        "sbvh",
        "lbvh",
        "ploc",
        "ploc,reinsert=2",
    ] {
        let kind: StructureKind = format!("bvh:{name}").parse().expect("a good name");
        let tight = Limits {
            memory: Some(100_000),
            ..Limits::NONE
        };
        let refused = kind.build_within(&mesh, &tight).err();
        assert!(
            matches!(
                refused,
                Some(BuildError::Memory {
                    allowed: 100_000,
                    ..
                })
            ),
            "{name}: {refused:?}"
        );
        for end in [0.0, 0.3, 0.9] {
            let watch = |share: f32| {
                if share >= end {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            let watched = Limits {
                watch: Some(&watch),
                ..Limits::NONE
            };
            let ended = kind.build_within(&mesh, &watched).err();
            assert_eq!(ended, Some(BuildError::Cancelled), "{name} at {end}");
        }
    }
}
