//! The pitch: striped grass, white lines, goals and corner flags, and the ground around the building.
//!
//! *How it works.* Grass and ground are rectangles that tile the plane y = 0. Lines lie 4 mm above the grass, curved
//! ones 6 mm and spots 8 mm, so that none shares a plane with what it crosses. x runs from goal to goal.

use super::solids::{cuboid, facets, prism, set_down};
use super::stage::{Stage, paint};
use crate::scene::Mesh;
use boxwood::Affine;

/// Half the pitch, to the outer edge of its lines, in metres.
const HALF: [f32; 2] = [52.5, 34.0];
/// Width of the lines.
const LINE: f32 = 0.12;
const STRIPES: u32 = 20;
/// Half of the grass around the pitch; it reaches under the stands.
const LAWN: [f32; 2] = [62.0, 43.0];
/// Half of the world.
const GROUND: [f32; 2] = [400.0, 400.0];

/// A rectangle `[x₀, z₀, x₁, z₁]` seen from above.
type Rectangle = [f32; 4];

/// Lays the ground out.
pub(super) fn pitch(stage: &mut Stage) {
    let light = stage.material(paint("grass, light", [0.1, 0.25, 0.035], 1.0));
    let dark = stage.material(paint("grass, dark", [0.055, 0.165, 0.022], 1.0));
    let asphalt = stage.material(paint("asphalt", [0.16, 0.16, 0.17], 1.0));
    let white = stage.material(paint("line", [0.85, 0.87, 0.85], 1.0));
    let wood = stage.material(paint("goal, white", [0.85, 0.85, 0.85], 0.3));

    let edge = |i: u32| HALF[0] * (2.0 * i as f32 / STRIPES as f32 - 1.0);
    for (name, material, remainder) in [("light", light, 0), ("dark", dark, 1)] {
        let stripes = (0..STRIPES)
            .filter(|i| i % 2 == remainder)
            .map(|i| [edge(i), -HALF[1], edge(i + 1), HALF[1]]);
        stage.build(
            &format!("grass, {name} stripes"),
            flat(stripes, 0.0),
            material,
        );
    }
    stage.build("lawn", flat(border(HALF, LAWN), 0.0), dark);
    stage.build("ground", flat(border(LAWN, GROUND), 0.0), asphalt);
    stage.build("lines, straight", flat(straight_lines(), 0.004), white);
    stage.build("lines, curved", curved_lines(), white);
    stage.build("spots", spots(), white);
    goals(stage, wood);
    corner_flags(stage, wood);
}

/// Four rectangles that fill what lies between two about the origin.
fn border(inner: [f32; 2], outer: [f32; 2]) -> [Rectangle; 4] {
    frame_of([-inner[0], -inner[1], inner[0], inner[1]], outer)
}

/// Four rectangles between `inner` and the rectangle about the origin of half sizes `outer`.
fn frame_of([x0, z0, x1, z1]: Rectangle, outer: [f32; 2]) -> [Rectangle; 4] {
    [
        [-outer[0], -outer[1], outer[0], z0],
        [-outer[0], z1, outer[0], outer[1]],
        [-outer[0], z0, x0, z1],
        [x1, z0, outer[0], z1],
    ]
}

/// Rectangles at a height, facing up.
fn flat(rectangles: impl IntoIterator<Item = Rectangle>, height: f32) -> Mesh {
    let mut mesh = facets(Vec::new(), Vec::new());
    for [x0, z0, x1, z1] in rectangles {
        let first = mesh.positions.len() as u32;
        let corners = [[x0, z0], [x0, z1], [x1, z1], [x1, z0]];
        mesh.positions.extend(corners.map(|[x, z]| [x, height, z]));
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|k| first + k)));
    }
    mesh
}

/// The outline, the halfway line, and goal and penalty areas; lines that meet touch and do not overlap.
fn straight_lines() -> Vec<Rectangle> {
    let [x, z] = HALF;
    let mut lines = border([x - LINE, z - LINE], HALF).to_vec();
    lines.push([-0.5 * LINE, LINE - z, 0.5 * LINE, z - LINE]);
    for (depth, half) in [(5.5, 9.16), (16.5, 20.16)] {
        let (from, to) = (x - depth, x - LINE);
        for [a, b, c, d] in [
            [from, -half, from + LINE, half],
            [from + LINE, -half, to, LINE - half],
            [from + LINE, half - LINE, to, half],
        ] {
            lines.extend([[a, b, c, d], [-c, b, -a, d]]);
        }
    }
    lines
}

/// The centre circle, the arcs of the penalty areas and the quarter circles in the corners.
fn curved_lines() -> Mesh {
    let mut mesh = facets(Vec::new(), Vec::new());
    arc(&mut mesh, [0.0, 0.0], 9.15, [0.0, 360.0], 96);
    // The arc begins where the circle about the penalty spot leaves the area: 5.5 m before the spot.
    let reach = libm::acos(5.5 / 9.15).to_degrees();
    for side in [-1.0, 1.0] {
        let facing = if side < 0.0 { 0.0 } else { 180.0 };
        let spot = [side * (HALF[0] - 11.0), 0.0];
        arc(&mut mesh, spot, 9.15, [facing - reach, facing + reach], 24);
        for end in [-1.0f32, 1.0] {
            let begin = match (side < 0.0, end < 0.0) {
                (true, true) => 0.0,
                (false, true) => 90.0,
                (false, false) => 180.0,
                (true, false) => 270.0,
            };
            let corner = [side * HALF[0], end * HALF[1]];
            arc(&mut mesh, corner, 1.0, [begin, begin + 90.0], 8);
        }
    }
    mesh
}

/// A line along a circle whose outer edge has the radius; degrees from +x towards +z.
fn arc(mesh: &mut Mesh, [x, z]: [f32; 2], radius: f32, [from, to]: [f64; 2], pieces: u32) {
    let first = mesh.positions.len() as u32;
    for i in 0..=pieces {
        let degrees = from + (to - from) * f64::from(i) / f64::from(pieces);
        let (sin, cos) = libm::sincos(degrees.to_radians());
        for r in [radius - LINE, radius] {
            mesh.positions
                .push([x + r * cos as f32, 0.006, z + r * sin as f32]);
        }
    }
    for i in 0..pieces {
        let a = first + 2 * i;
        mesh.triangles
            .extend([[a, a + 2, a + 3], [a, a + 3, a + 1]]);
    }
}

/// Centre and penalty spots.
fn spots() -> Mesh {
    let spot = |x: f32| [x - 0.11, -0.11, x + 0.11, 0.11];
    flat([0.0, 11.0 - HALF[0], HALF[0] - 11.0].map(spot), 0.008)
}

/// Two frames of 7.32 m by 2.44 m, with the bars that would hold a net.
fn goals(stage: &mut Stage, material: u32) {
    let bars = [
        cuboid([-0.06, -0.1, -3.78], [0.06, 2.44, -3.66]),
        cuboid([-0.06, -0.1, 3.66], [0.06, 2.44, 3.78]),
        cuboid([-0.06, 2.44, -3.78], [0.06, 2.56, 3.78]),
        cuboid([1.5, 0.0, -3.74], [1.56, 0.06, 3.74]),
    ];
    let mut meshes = bars.map(|bar| stage.mesh("goal", bar, material)).to_vec();
    for z in [-3.72, 3.72] {
        // From the crossbar down to the ground behind.
        let mut stay = prism(
            &[[2.44, 0.0], [2.5, 0.0], [0.06, 1.53], [0.0, 1.5]],
            -0.03,
            0.03,
        );
        for p in &mut stay.positions {
            *p = [p[2], p[1], z - p[0]];
        }
        meshes.push(stage.mesh("goal stay", stay, material));
    }
    for (degrees, x) in [(0.0, HALF[0] - 0.06), (180.0, 0.06 - HALF[0])] {
        for &mesh in &meshes {
            stage.place(mesh, set_down(degrees, 1.0, [x, 0.0, 0.0]));
        }
    }
}

/// A pole with a small cloth at each corner.
fn corner_flags(stage: &mut Stage, material: u32) {
    let yellow = stage.material(paint("corner cloth", [0.85, 0.6, 0.06], 0.8));
    let pole = cuboid([-0.02, -0.1, -0.02], [0.02, 1.5, 0.02]);
    let pole = stage.mesh("corner pole", pole, material);
    let cloth = prism(&[[1.1, 0.02], [1.48, 0.02], [1.3, 0.5]], -0.005, 0.005);
    let cloth = stage.mesh("corner cloth", cloth, yellow);
    for x in [-HALF[0], HALF[0]] {
        for z in [-HALF[1], HALF[1]] {
            let at = Affine::translation([x, 0.0, z]);
            stage.place(pole, at);
            stage.place(cloth, set_down(super::stadium::WIND, 1.0, [x, 0.0, z]));
        }
    }
}
