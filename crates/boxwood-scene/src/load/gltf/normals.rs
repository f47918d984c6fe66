//! Vertex normals that point nowhere, made good from the triangles around them.

use super::matrix::{cross, unit};
use crate::Mesh;

/// Replaces normals that are not numbers by the mean of the triangles around them, larger triangles counting more;
/// where there are none with an area, by `0 0 1`. Returns whether there was anything to do.
pub fn repair(mesh: &mut Mesh) -> bool {
    if mesh.normals.iter().all(|n| !n[0].is_nan()) {
        return false;
    }
    let point = |vertex: u32| mesh.positions[vertex as usize].map(f64::from);
    let mut sums = vec![[0.0; 3]; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        if triangle
            .iter()
            .all(|&v| !mesh.normals[v as usize][0].is_nan())
        {
            continue;
        }
        let [a, b, c] = triangle.map(point);
        let edge = |to: [f64; 3]| std::array::from_fn(|k| to[k] - a[k]);
        let normal = cross(edge(b), edge(c));
        for vertex in triangle {
            for (sum, part) in sums[vertex as usize].iter_mut().zip(normal) {
                *sum += part;
            }
        }
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sums) {
        if normal[0].is_nan() {
            *normal = unit(sum).unwrap_or([0.0, 0.0, 1.0]).map(|x| x as f32);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_broken_changes() {
        let nan = [f32::NAN; 3];
        let mut mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [5.0; 3]],
            triangles: vec![[0, 1, 2]],
            normals: vec![[1.0, 0.0, 0.0], nan, nan, nan],
            ..Mesh::default()
        };
        assert!(repair(&mut mesh));
        let up = [0.0, 1.0, 0.0];
        assert_eq!(mesh.normals, [[1.0, 0.0, 0.0], up, up, [0.0, 0.0, 1.0]]);
        assert!(!repair(&mut mesh));
    }
}
