//! Two ray-triangle tests: the canonical watertight one, and Möller–Trumbore for comparison.

pub(crate) mod block;
pub(crate) mod closest;
pub(crate) mod contact;
pub mod moller_trumbore;
pub mod overlap;
pub(crate) mod solid_angle;
pub mod watertight;

use super::{Ray, Surface, Vec3};

/// Where a triangle was met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Weight of vertex 1.
    pub u: f32,
    /// Weight of vertex 2.
    pub v: f32,
}

/// The unit normal, to the side from which the vertices run counter-clockwise; zero for a triangle without area.
///
/// In double precision, so that slivers have one too.
pub fn normal(vertices: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = vertices.map(|p| p.to_array().map(f64::from));
    let edge = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (e, f) = (edge(b), edge(c));
    let n = [
        e[1] * f[2] - e[2] * f[1],
        e[2] * f[0] - e[0] * f[2],
        e[0] * f[1] - e[1] * f[0],
    ];
    let largest = n.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest == 0.0 {
        return Vec3::ZERO;
    }
    Vec3::from(n.map(|x| (x / largest) as f32)).normalized()
}

/// The point of a triangle with the given weights of vertices 1 and 2, for a ray that met it there.
pub fn surface(vertices: [Vec3; 3], u: f32, v: f32, ray: &Ray) -> Surface {
    let [a, b, c] = vertices;
    let normal = normal(vertices);
    let w = 1.0 - u - v;
    let position = a * w + b * u + c * v;
    // An accepted hit of a later ray lies within 22 u D of this triangle along each axis, D its largest |V − origin|;
    // the position is right to 6 u S. Both by √3, with room for the rounding of the moved origin.
    let extent = [a, b, c]
        .iter()
        .fold(0.0, |m: f32, &p| m.max((p - position).abs().max_element()));
    let scale = [a, b, c]
        .iter()
        .fold(0.0, |m: f32, &p| m.max(p.abs().max_element()));
    Surface {
        position,
        normal,
        front: normal.dot(ray.direction) < 0.0,
        uv: [u, v],
        error: (48.0 * extent + 16.0 * scale) * (1.0 / (1 << 24) as f32),
    }
}
