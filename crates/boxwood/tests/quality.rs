//! Trees stay as good as they were: their costs are recorded, and a worse tree fails.

use boxwood::{BinnedSah, Median, TriangleMesh, inspect};
use boxwood_testkit::{Random, shapes, soups};

/// The surface-area cost of a builder's tree.
fn costs(mesh: &TriangleMesh) -> [f32; 3] {
    let few_bins = BinnedSah {
        bins: 4,
        ..Default::default()
    };
    [
        Median::default().build(mesh),
        few_bins.build(mesh),
        BinnedSah::default().build(mesh),
    ]
    .map(|tree| inspect::Statistics::of_tree(&tree).sah_cost)
}

/// `(scene, mesh, costs of median, binned with 4 bins, binned)`.
fn recorded() -> [(&'static str, TriangleMesh, [f32; 3]); 6] {
    let mut random = Random::new(11);
    let ball = shapes::sphere(60, 40);
    [
        ("sphere", ball.mesh(), [40.528, 29.138, 28.617]),
        (
            "terrain",
            shapes::terrain(60, &mut random).mesh(),
            [24.175, 17.422, 17.309],
        ),
        (
            "random",
            soups::random(4_000, &mut random).mesh(),
            [155.93, 131.09, 129.02],
        ),
        (
            "needles",
            soups::needles(1_000, &mut random).mesh(),
            [440.86, 375.40, 360.29],
        ),
        (
            "ball in a stadium",
            shapes::cube(8).placed(100.0, 0.0).with(&ball).mesh(),
            [45.581, 23.628, 22.107],
        ),
        (
            "mixed sizes",
            soups::mixed_sizes(4_000, &mut random).mesh(),
            [221.40, 158.46, 150.07],
        ),
    ]
}

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
        let [median, few_bins, binned] = costs(&mesh);
        assert!(binned <= median, "{name}: {binned} against {median}");
        assert!(
            binned <= 1.02 * few_bins,
            "{name}: {binned} against {few_bins}"
        );
        if ["ball in a stadium", "mixed sizes"].contains(&name) {
            assert!(binned < 0.8 * median, "{name}: {binned} against {median}");
        }
    }
}
