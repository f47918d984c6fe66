//! Newell's teapot: bicubic Bézier patches cut into triangles.
//!
//! *How it works.* Each patch is evaluated on a square grid, in double precision, and rounded once at the end. The
//! Bernstein weights of a parameter and of its mirror image are mirror images to the last bit, and the sums are
//! symmetric: whichever way two patches run along the edge they share, they compute the same points, so the seams are
//! closed without any search for equal vertices. Normals come from the derivatives; where a patch closes over a pole
//! its first row has no direction along `u`, and the mixed derivative, which is the limit of that direction, stands in.
//!
//! *Cost.* `64 n² − 8 n` triangles for `n` subdivisions; 16 evaluations of a few hundred operations per vertex.
//!
//! *Openings.* As in the original, the lid lies loose within the rim, and handle and spout end inside the body.

use super::newell::{PATCHES, POINTS};
use crate::scene::Mesh;

/// The finest tessellation: some 4 million triangles.
pub const MAX_SUBDIVISIONS: u32 = 256;

/// The teapot with `subdivisions` squares along each side of its 32 patches, each cut into two triangles.
///
/// It stands on the plane `y = 0`, is 3.15 units tall, turns about the y axis and points its spout towards +x. Normals
/// are those of the smooth surface; texture coordinates run once over each patch, downwards and from left to right as
/// seen from outside. `subdivisions` is brought into `2..=`[`MAX_SUBDIVISIONS`]: with one, the tip of the spout would
/// fold into a line.
pub fn teapot(subdivisions: u32) -> Mesh {
    let n = subdivisions.clamp(2, MAX_SUBDIVISIONS);
    let weights: Vec<Weights> = (0..=n).map(|i| Weights::new(i, n)).collect();
    let mut mesh = Mesh {
        name: "teapot".into(),
        smooth: true,
        ..Mesh::default()
    };
    for patch in &PATCHES {
        let first = mesh.positions.len() as u32;
        for (j, v) in (0..=n).zip(&weights) {
            for (i, u) in (0..=n).zip(&weights) {
                let (position, normal) = evaluate(patch, u, v);
                mesh.positions.push(upright(position));
                mesh.normals.push(upright(normal));
                mesh.uvs
                    .push([((n - i) as f32) / n as f32, j as f32 / n as f32]);
            }
        }
        let pole = patch[..4].iter().all(|&point| point == patch[0]);
        let vertex = |i: u32, j: u32| first + j * (n + 1) + i;
        for j in 0..n {
            for i in 0..n {
                let (a, b) = (vertex(i, j), vertex(i + 1, j));
                let (c, d) = (vertex(i + 1, j + 1), vertex(i, j + 1));
                // At a pole a and b are the same point.
                if !(pole && j == 0) {
                    mesh.triangles.push([a, b, c]);
                }
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

/// The cubic Bernstein polynomials at one parameter, and their derivatives.
struct Weights {
    value: [f64; 4],
    slope: [f64; 4],
}

impl Weights {
    /// At the parameter `i / n`. Swapping `i` and `n − i` reverses `value` exactly.
    fn new(i: u32, n: u32) -> Self {
        let t = f64::from(i) / f64::from(n);
        let s = f64::from(n - i) / f64::from(n);
        Self {
            value: [s * s * s, 3.0 * (s * s * t), 3.0 * (t * t * s), t * t * t],
            slope: [
                -3.0 * s * s,
                3.0 * s * (s - 2.0 * t),
                3.0 * t * (2.0 * s - t),
                3.0 * t * t,
            ],
        }
    }
}

/// Point and unit normal of a patch, z up.
fn evaluate(patch: &[u16; 16], u: &Weights, v: &Weights) -> ([f64; 3], [f64; 3]) {
    let position = weighted(patch, &u.value, &v.value);
    let along_v = weighted(patch, &u.value, &v.slope);
    let mut along_u = weighted(patch, &u.slope, &v.value);
    if dot(along_u, along_u) < 1.0e-20 {
        along_u = weighted(patch, &u.slope, &v.slope);
    }
    let normal = cross(along_u, along_v);
    let length = dot(normal, normal).sqrt();
    (position, normal.map(|x| x / length))
}

/// The sum of all control points, weighted along both parameters, in an order that its own mirror image shares.
fn weighted(patch: &[u16; 16], u: &[f64; 4], v: &[f64; 4]) -> [f64; 3] {
    let sum = |w: &[f64; 4], p: [f64; 4]| (w[0] * p[0] + w[3] * p[3]) + (w[1] * p[1] + w[2] * p[2]);
    std::array::from_fn(|axis| {
        let point = |k: usize| POINTS[usize::from(patch[k])][axis];
        let row = |r: usize| sum(u, std::array::from_fn(|c| point(4 * r + c)));
        sum(v, std::array::from_fn(row))
    })
}

/// From z up to y up, in single precision, without negative zeros.
fn upright([x, y, z]: [f64; 3]) -> [f32; 3] {
    [x, z, -y].map(|c| (c + 0.0) as f32)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
