//! Triangles without any order: the plainest stress there is.

use super::crowd::{add, build_each, lit};
use super::random::Random;
use super::solids::facets;
use super::stage::{PALETTE, Stage};
use crate::scene::Scene;

/// `n` triangles, evenly spread in the cube from −1 to 1 and as large as lets a ray meet some: each takes the room that
/// there is for it.
pub(super) fn soup(n: u32, seed: u64) -> Scene {
    let mut random = Random::new(seed, 3);
    let mut meshes = PALETTE.map(|_| facets(Vec::new(), Vec::new()));
    let size = (1.3 / libm::cbrt(f64::from(n))) as f32;
    let size = size.min(0.5);
    let room = 1.0 - size;
    for _ in 0..n {
        let mesh = &mut meshes[random.below(PALETTE.len())];
        let middle = random.in_cube() * room;
        add(mesh, [(); 3].map(|()| middle + random.direction() * size));
    }
    let mut stage = Stage::default();
    build_each(&mut stage, "triangles", meshes);
    lit(stage.scene)
}
