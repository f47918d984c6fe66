//! Many simple things in a cube: what is easy for a grid, and what is hard for all.
//!
//! *How it works.* Points follow a sequence that fills the cube evenly for every number of them. *Source.* M. Roberts
//! 2018, *The Unreasonable Effectiveness of Quasirandom Sequences*: steps of powers of the generalised golden ratio.

use super::random::Random;
use super::solids::{ball, cuboid, facets, frame, set_down};
use super::stage::{PALETTE, Stage, paint};
use super::{camera, sun};
use crate::scene::{Mesh, Scene};
use boxwood::Vec3;

/// `n` spheres of equal size, evenly spread in the cube from −1 to 1: 320 triangles each. What a uniform grid is made for.
pub(super) fn even_spheres(n: u32, seed: u64) -> Scene {
    let mut stage = Stage::default();
    let mut random = Random::new(seed, 0);
    let meshes = PALETTE.map(|(name, color)| {
        let material = stage.material(paint(name, color, 0.25));
        stage.mesh(&format!("{name} sphere"), ball(2), material)
    });
    let spacing = 2.0 / libm::cbrt(f64::from(n));
    let radius = (0.27 * spacing) as f32;
    let start = [(); 3].map(|()| f64::from(random.unit()));
    for i in 0..n {
        let p = even(start, i).map(|x| (2.0 * x - 1.0) as f32 * (1.0 - radius));
        stage.place(meshes[random.below(meshes.len())], set_down(0.0, radius, p));
    }
    stage.drop_unplaced();
    lit(stage.scene)
}

/// Point `i` of an even sequence in the unit cube.
fn even(start: [f64; 3], i: u32) -> [f64; 3] {
    /// The real root of x⁴ = x + 1.
    const RATIO: f64 = 1.220_744_084_605_759_5;
    let mut step = 1.0;
    start.map(|begin| {
        step /= RATIO;
        let x = begin + f64::from(i) * step;
        x - x.floor()
    })
}

/// `n` slivers across the cube from −1 to 1, all near its diagonals: their boxes are nearly the whole cube, and they fill
/// nothing of it. What only cuts help against.
pub(super) fn long_thin(n: u32, seed: u64) -> Scene {
    let mut stage = Stage::default();
    let mut random = Random::new(seed, 1);
    let mut meshes = PALETTE.map(|_| facets(Vec::new(), Vec::new()));
    for i in 0..n as usize {
        let mut corner = [0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 });
        corner[0] = -1.0;
        let corner = Vec3::from(corner) * 0.72;
        let from = corner + random.in_cube() * 0.28;
        let to = random.in_cube() * 0.28 - corner;
        let across = (to - from).cross(random.direction()).normalized();
        let width = random.between(0.008, 0.02);
        let middle = from + (to - from) * random.between(0.3, 0.7);
        add(
            &mut meshes[i / 4 % PALETTE.len()],
            [from, to, inside(middle + across * width)],
        );
    }
    build_each(&mut stage, "slivers", meshes);
    lit(stage.scene)
}

/// `n` boxes and triangles, turned every way and so large that everything overlaps everything: no box is ever empty of
/// others. What spoils bounding volumes.
pub(super) fn overlapping(n: u32, seed: u64) -> Scene {
    let mut stage = Stage::default();
    let mut random = Random::new(seed, 2);
    let boxes = PALETTE.map(|(name, color)| {
        let material = stage.material(paint(name, color, 0.4));
        let cube = cuboid([-1.0; 3], [1.0; 3]);
        stage.mesh(&format!("{name} box"), cube, material)
    });
    let mut triangles = PALETTE.map(|_| facets(Vec::new(), Vec::new()));
    for i in 0..n as usize {
        let color = random.below(PALETTE.len());
        let x = random.direction();
        let y = x.cross(random.direction()).normalized();
        if i % 2 == 0 {
            let [a, b, c] = [(); 3].map(|()| random.between(0.08, 0.4));
            let at = random.in_cube() * 0.55;
            // A random direction may run along x: then there is no second axis, and the box keeps the usual ones.
            let [x, y, z] = if y.is_finite() && y != Vec3::ZERO {
                [x, y, x.cross(y)]
            } else {
                [
                    Vec3::new(1.0, 0.0, 0.0),
                    Vec3::new(0.0, 1.0, 0.0),
                    Vec3::new(0.0, 0.0, 1.0),
                ]
            };
            stage.place(boxes[color], frame(x * a, y * b, z * c, at));
        } else {
            let corners = [(); 3].map(|()| random.in_cube());
            add(&mut triangles[color], corners);
        }
    }
    for (mesh, (k, (name, _))) in triangles.into_iter().zip(PALETTE.iter().enumerate()) {
        if !mesh.triangles.is_empty() {
            let material = stage.scene.meshes[boxes[k] as usize].material;
            stage.build(&format!("{name} triangles"), mesh, material);
        }
    }
    stage.drop_unplaced();
    lit(stage.scene)
}

/// A triangle with vertices of its own.
pub(super) fn add(mesh: &mut Mesh, corners: [Vec3; 3]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners.map(Vec3::to_array));
    mesh.triangles.push([first, first + 1, first + 2]);
}

/// One mesh and material per colour of the palette, without those that are empty.
pub(super) fn build_each(stage: &mut Stage, what: &str, meshes: [Mesh; PALETTE.len()]) {
    for (mesh, (name, color)) in meshes.into_iter().zip(PALETTE) {
        if !mesh.triangles.is_empty() {
            let material = stage.material(paint(name, color, 0.6));
            stage.build(&format!("{name} {what}"), mesh, material);
        }
    }
}

/// With a sun, and a camera that sees the whole cube.
pub(super) fn lit(mut scene: Scene) -> Scene {
    scene.lights = vec![sun([-0.45, -0.8, -0.4])];
    scene.cameras = vec![camera("main", [2.3, 1.9, 3.9], [0.0, -0.04, 0.0], 33.0)];
    scene
}

/// The nearest point of the cube from −1 to 1.
fn inside(p: Vec3) -> Vec3 {
    p.to_array().map(|x| x.clamp(-1.0, 1.0)).into()
}
