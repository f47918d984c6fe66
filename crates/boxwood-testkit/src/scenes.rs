//! The catalogue: named scenes of every temper, each from a seed.

use crate::{Model, Random, shapes, soups};

/// Makes a scene of about so many triangles.
pub type Make = fn(usize, &mut Random) -> Model;

/// All scenes, by name.
pub const SCENES: [(&str, Make); 29] = [
    ("empty", |_, _| Model::default()),
    ("one triangle", |_, r| soups::random(1, r)),
    ("random", soups::random),
    ("grid", soups::grid),
    ("small grid", |_, r| soups::grid(9, r)),
    ("flat in x", |n, r| soups::flat(n, 0, r)),
    ("flat in y", |n, r| soups::flat(n, 1, r)),
    ("flat in z", |n, r| soups::flat(n, 2, r)),
    ("slivers", soups::slivers),
    ("duplicates", soups::duplicates),
    ("identical", |n, _| soups::identical(n)),
    ("fan", soups::fan),
    ("needles", soups::needles),
    ("line", |n, _| soups::line(n, 0.1, 1.0)),
    ("exponential line", |n, _| {
        soups::line(n, 1.0e-3, libm::pow(1.0e9, 1.0 / n.max(1) as f64))
    }),
    ("mixed sizes", soups::mixed_sizes),
    ("any floats", soups::any_floats),
    ("sphere", |n, _| shapes::sphere(side(n), side(n).max(3))),
    ("vase", |n, _| shapes::vase(side(n), side(n))),
    ("terrain", |n, r| shapes::terrain(side(n), r)),
    ("ball in a box", |n, _| {
        let ball = shapes::sphere(side(n / 2), side(n / 2).max(3));
        shapes::cube(3).placed(50.0, 0.0).with(&ball)
    }),
    ("random, 1e-3", |n, r| {
        soups::random(n, r).placed(1.0e-3, 0.0)
    }),
    ("torus, 1e6", |n, _| {
        shapes::torus(side(n), side(n)).placed(1.0e6, 0.0)
    }),
    ("sphere, far from the origin", |n, r| {
        let offset = r.pick(&[1.0e3, 1.0e5, 1.0e6]);
        shapes::sphere(side(n), side(n).max(3)).placed(1.0, offset)
    }),
    ("slivers, at the doors", |n, r| {
        // Just within and just beyond the sizes for which the slack is proven.
        let scale = r.pick(&[1.0e-10, 1.0e-6, 3.0e-6, 1.0e5, 3.0e8, 2.0e11, 2.0e12]);
        soups::slivers(n, r).placed(scale, 0.0)
    }),
    ("random, 1e-30", |n, r| {
        soups::random(n, r).placed(1.0e-30, 0.0)
    }),
    ("mixed sizes, 1e30", |n, r| {
        soups::mixed_sizes(n, r).placed(1.0e30, 0.0)
    }),
    ("terrain, where a map puts it", |n, r| {
        let terrain = shapes::terrain(side(n), r).placed(1.0e3, 0.0);
        terrain.moved([5.0e5, 4.0e6, 0.0])
    }),
    ("random, far along one axis", |n, r| {
        let mut by = [0.0; 3];
        by[r.below(3)] = r.pick(&[1.0e2, -1.0e4, 3.0e6, -1.0e7]);
        soups::random(n, r).moved(by)
    }),
];

/// The cells along a side of a square grid of `triangles` triangles.
fn side(triangles: usize) -> u32 {
    ((triangles as f64 / 2.0).sqrt() as u32).max(3)
}
