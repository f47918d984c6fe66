//! Closed shapes and frames to place them with.
//!
//! *How it works.* Every function returns one mesh without a name, its surface closed and its triangles counter-clockwise
//! from outside. Shapes with edges have no normals and show their facets; the ball has exact ones.

use crate::scene::Mesh;
use boxwood::{Affine, Vec3};

/// A flat-faced mesh.
pub(super) fn facets(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A box with faces along the axes: 12 triangles.
pub(super) fn cuboid(lower: [f32; 3], upper: [f32; 3]) -> Mesh {
    let corners = [
        [lower[1], lower[2]],
        [upper[1], lower[2]],
        [upper[1], upper[2]],
        [lower[1], upper[2]],
    ];
    prism(&corners, lower[0], upper[0])
}

/// A polygon in the `(y, z)` plane, drawn out along x from `from` to `to`: `4 n − 4` triangles for `n` corners.
///
/// The polygon is counter-clockwise with y to the right and z up, and its first corner sees all the others.
pub(super) fn prism(polygon: &[[f32; 2]], from: f32, to: f32) -> Mesh {
    let n = polygon.len() as u32;
    let layer = |x: f32| polygon.iter().map(move |&[y, z]| [x, y, z]);
    let mut triangles = Vec::new();
    for i in 0..n {
        let next = (i + 1) % n;
        triangles.extend([[i, next, n + next], [i, n + next, n + i]]);
    }
    for i in 1..n - 1 {
        triangles.extend([[0, i + 1, i], [n, n + i, n + i + 1]]);
    }
    facets(layer(from).chain(layer(to)).collect(), triangles)
}

/// A ball of radius 1 about the origin: an icosahedron whose triangles are cut in four `level` times and pushed out.
pub(super) fn ball(level: u32) -> Mesh {
    let golden = (1.0 + 5.0f64.sqrt()) / 2.0;
    let mut points: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [
        (-1.0, golden),
        (1.0, golden),
        (-1.0, -golden),
        (1.0, -golden),
    ] {
        points.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]]);
    }
    for p in &mut points {
        *p = unit(*p);
    }
    let mut triangles = icosahedron(&points);
    for _ in 0..level {
        let mut halves = std::collections::HashMap::new();
        let mut half = |a: u32, b: u32| {
            *halves.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let (p, q) = (points[a as usize], points[b as usize]);
                points.push(unit([p[0] + q[0], p[1] + q[1], p[2] + q[2]]));
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let positions: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| x as f32)).collect();
    Mesh {
        normals: positions.clone(),
        positions,
        triangles,
        smooth: true,
        ..Mesh::default()
    }
}

/// The 20 triangles of neighbours among the 12 corners, counter-clockwise from outside.
fn icosahedron(corners: &[[f64; 3]]) -> Vec<[u32; 3]> {
    let dot = |a: usize, b: usize| (0..3).map(|k| corners[a][k] * corners[b][k]).sum::<f64>();
    let volume = |a: usize, b: usize, c: usize| {
        let (a, b, c) = (corners[a], corners[b], corners[c]);
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            // Neighbours are 63° apart, the next ones 117°.
            for c in (b + 1..12).filter(|&c| dot(a, b) > 0.0 && dot(b, c) > 0.0 && dot(c, a) > 0.0)
            {
                let [a, b, c] = [a as u32, b as u32, c as u32];
                let outwards = volume(a as usize, b as usize, c as usize) > 0.0;
                triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    triangles
}

fn unit(p: [f64; 3]) -> [f64; 3] {
    let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    p.map(|x| x / length)
}

/// The map that takes the axes to `x`, `y` and `z` and the origin to `origin`.
pub(super) fn frame(x: Vec3, y: Vec3, z: Vec3, origin: Vec3) -> Affine {
    let row = |k: usize| [x[k], y[k], z[k], origin[k]];
    Affine {
        rows: [row(0), row(1), row(2)],
    }
}

/// A turn about the y axis by an angle in degrees, a scale, then a move: how a thing is set down.
pub(super) fn set_down(degrees: f64, scale: f32, at: [f32; 3]) -> Affine {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let (sin, cos) = (sin as f32 * scale, cos as f32 * scale);
    frame(
        Vec3::new(cos, 0.0, -sin),
        Vec3::new(0.0, scale, 0.0),
        Vec3::new(sin, 0.0, cos),
        at.into(),
    )
}
