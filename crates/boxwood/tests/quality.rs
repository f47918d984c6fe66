//! Trees stay as good as they were: their costs are recorded, and a worse tree fails.

use boxwood::{
    BinnedSah, EqualCounts, Lbvh, Median, Middle, Ploc, Refine, SpatialSplit, SweepSah,
    TriangleMesh, inspect,
};
use boxwood_testkit::{Random, shapes, soups};

/// Costs of a median, binned with 4 bins, binned, middle, equal counts, sweep, spatial splits, LBVH and PLOC tree; of the sweep
/// tree rotated and reinserted.
type Costs = [f32; 11];

/// The surface-area cost of every builder's tree.
fn costs(mesh: &TriangleMesh) -> Costs {
    let few_bins = BinnedSah {
        bins: 4,
        ..Default::default()
    };
    let refined = |rotate: usize, reinsert: usize| SweepSah {
        refine: Refine { reinsert, rotate },
        ..Default::default()
    };
    [
        Median::default().build(mesh),
        few_bins.build(mesh),
        BinnedSah::default().build(mesh),
        Middle::default().build(mesh),
        EqualCounts::default().build(mesh),
        SweepSah::default().build(mesh),
        SpatialSplit::default().build(mesh),
        Lbvh::default().build(mesh),
        Ploc::default().build(mesh),
        refined(5, 0).build(mesh),
        refined(0, 5).build(mesh),
    ]
    .map(|tree| inspect::Statistics::of_tree(&tree).sah_cost)
}

fn recorded() -> [(&'static str, TriangleMesh, Costs); 6] {
    let mut random = Random::new(11);
    let ball = shapes::sphere(60, 40);
    [
        ("sphere", ball.mesh(), SPHERE),
        ("terrain", shapes::terrain(60, &mut random).mesh(), TERRAIN),
        ("random", soups::random(4_000, &mut random).mesh(), RANDOM),
        (
            "needles",
            soups::needles(1_000, &mut random).mesh(),
            NEEDLES,
        ),
        (
            "ball in a stadium",
            shapes::cube(8).placed(100.0, 0.0).with(&ball).mesh(),
            STADIUM,
        ),
        (
            "mixed sizes",
            soups::mixed_sizes(4_000, &mut random).mesh(),
            MIXED,
        ),
    ]
}

const SPHERE: Costs = [
    40.528, 29.138, 28.617, 33.315, 33.959, 28.441, 28.441, 31.509, 30.416, 28.300, 28.329,
];
const TERRAIN: Costs = [
    24.175, 17.422, 17.309, 20.155, 21.169, 17.326, 17.326, 21.570, 19.341, 17.321, 17.309,
];
const RANDOM: Costs = [
    155.93, 131.09, 129.02, 145.00, 151.41, 128.63, 128.61, 139.98, 132.78, 128.11, 124.62,
];
const NEEDLES: Costs = [
    440.86, 375.40, 362.19, 435.77, 423.00, 355.82, 355.29, 414.95, 329.91, 344.62, 326.61,
];
const STADIUM: Costs = [
    45.581, 23.628, 21.836, 26.878, 36.150, 21.836, 21.836, 24.295, 22.240, 20.937, 20.729,
];
const MIXED: Costs = [
    221.40, 158.46, 151.92, 200.38, 203.56, 146.09, 119.85, 196.44, 146.49, 125.45, 117.21,
];

#[test]
fn no_tree_is_worse_than_recorded() {
    let mut report = String::new();
    for (name, mesh, expected) in recorded() {
        let found = costs(&mesh);
        for (found, expected) in found.into_iter().zip(expected) {
            // Half a percent for other machines' sines. Much better is worth recording too.
            if !(0.95 * expected..=1.005 * expected).contains(&found) {
                report += &format!("{name}: {found} instead of {expected}\n");
            }
        }
    }
    assert!(report.is_empty(), "other costs than recorded:\n{report}");
}

#[test]
fn the_heuristic_pays_where_density_varies() {
    for (name, mesh, _) in recorded() {
        let [
            median,
            few_bins,
            binned,
            _,
            _,
            sweep,
            spatial,
            lbvh,
            ploc,
            rotated,
            reinserted,
        ] = costs(&mesh);
        assert!(binned <= median, "{name}: {binned} against {median}");
        assert!(
            binned <= 1.02 * few_bins,
            "{name}: {binned} against {few_bins}"
        );
        // The finer the choice of planes, the better; a greedy choice may still lose a little.
        assert!(sweep <= 1.02 * binned, "{name}: {sweep} against {binned}");
        assert!(spatial <= 1.02 * sweep, "{name}: {spatial} against {sweep}");
        assert!(ploc <= lbvh, "{name}: {ploc} against {lbvh}");
        assert!(rotated <= sweep, "{name}: {rotated} against {sweep}");
        assert!(reinserted < sweep, "{name}: {reinserted} against {sweep}");
        if ["ball in a stadium", "mixed sizes"].contains(&name) {
            assert!(binned < 0.8 * median, "{name}: {binned} against {median}");
        }
    }
}
