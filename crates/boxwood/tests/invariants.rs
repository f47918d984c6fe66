//! What holds for every tree of every builder, over boxes of any kind.

use boxwood::accel::bvh::MAX_DEPTH;
use boxwood::{
    Aabb, BinaryTree, BinnedSah, Counters, Hit, Median, PreparedRay, Primitives, Query, Ray,
    inspect,
};
use boxwood_testkit::agreement;
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

fn all_hold(boxes: &Boxes, bins: usize, leaf: usize) -> Result<(), TestCaseError> {
    let binned = BinnedSah {
        bins,
        max_leaf: leaf,
        ..Default::default()
    };
    // Settings beyond their range are brought into it.
    let most = leaf.clamp(1, 64);
    holds(boxes, &binned.build(boxes), most)?;
    holds(
        boxes,
        &Median {
            max_leaf: leaf,
            ..Default::default()
        }
        .build(boxes),
        most,
    )
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
}
