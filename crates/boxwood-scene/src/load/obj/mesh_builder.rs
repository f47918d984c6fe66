//! Collects faces into one mesh with its own vertex list.
//!
//! *How it works.* OBJ corners are triples (position, texture coordinate, normal); every different triple becomes one
//! vertex. `heads[position]` is the first vertex with that position and `next` chains the others. A head left over from
//! an earlier mesh is told by looking: the vertex it names is too far, or has another position, so nothing is ever
//! cleared (Briggs & Torczon 1993, *An Efficient Representation for Sparse Sets*). Chains longer than a few links go to
//! a hash map. *Cost.* One look-up per corner, constant; 4 bytes per position of the file, 16 per vertex of the mesh.

use super::vertices::Vertices;
use crate::Mesh;
use std::collections::HashMap;

/// "Not there", as an index.
pub(super) const NONE: u32 = u32::MAX;

/// Where a corner finds its attributes, counted from 0; [`NONE`] for those that it lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// How far a chain is followed before the hash map is asked.
const LONGEST_CHAIN: usize = 16;

/// A mesh that grows.
#[derive(Default)]
pub(super) struct MeshBuilder {
    mesh: Mesh,
    corners: Vec<Corner>,
    next: Vec<u32>,
    heads: Vec<u32>,
    far: HashMap<Corner, u32>,
}

impl MeshBuilder {
    pub(super) fn is_empty(&self) -> bool {
        self.mesh.triangles.is_empty()
    }

    /// The vertex of a corner, old or new.
    #[inline]
    pub(super) fn vertex(&mut self, corner: Corner, from: &Vertices) -> u32 {
        let position = corner.position as usize;
        if self.heads.len() <= position {
            self.heads.resize(from.positions.len(), NONE);
        }
        let head = self.heads[position];
        let mut at = match self.corners.get(head as usize) {
            Some(first) if first.position == corner.position => head,
            _ => NONE,
        };
        let first = at;
        let mut links = 0;
        while at != NONE {
            if self.corners[at as usize] == corner {
                return at;
            }
            links += 1;
            if links == LONGEST_CHAIN {
                return self.far_vertex(corner, from);
            }
            at = self.next[at as usize];
        }
        let new = self.push(corner, from);
        self.next[new as usize] = first;
        self.heads[position] = new;
        new
    }

    #[cold]
    fn far_vertex(&mut self, corner: Corner, from: &Vertices) -> u32 {
        if let Some(&old) = self.far.get(&corner) {
            return old;
        }
        let new = self.push(corner, from);
        self.far.insert(corner, new);
        new
    }

    #[inline]
    fn push(&mut self, corner: Corner, from: &Vertices) -> u32 {
        let new = self.corners.len() as u32;
        self.corners.push(corner);
        self.next.push(NONE);
        let mesh = &mut self.mesh;
        mesh.positions
            .push(from.positions[corner.position as usize]);
        attribute(
            &mut mesh.uvs,
            new,
            from.uvs.get(corner.uv as usize),
            [0.0; 2],
        );
        let normal = from.normals.get(corner.normal as usize);
        attribute(
            &mut mesh.normals,
            new,
            normal.filter(|&&n| n != [0.0; 3]),
            [0.0; 3],
        );
        let color = from.colors.get(corner.position as usize);
        attribute(&mut mesh.colors, new, color, [1.0; 4]);
        new
    }

    #[inline]
    pub(super) fn push_triangle(&mut self, triangle: [u32; 3]) {
        self.mesh.triangles.push(triangle);
    }

    /// The mesh so far; the builder starts anew.
    pub(super) fn finish(&mut self) -> Mesh {
        self.corners.clear();
        self.next.clear();
        self.far.clear();
        let mut mesh = std::mem::take(&mut self.mesh);
        fill_normals(&mut mesh);
        mesh.positions.shrink_to_fit();
        mesh.triangles.shrink_to_fit();
        mesh.normals.shrink_to_fit();
        mesh.uvs.shrink_to_fit();
        mesh.colors.shrink_to_fit();
        mesh
    }
}

/// Appends vertex `index`'s value to a list that stays empty until somebody has a value.
#[inline]
fn attribute<T: Copy>(list: &mut Vec<T>, index: u32, value: Option<&T>, missing: T) {
    match value {
        Some(&value) => {
            if list.len() < index as usize {
                list.resize(index as usize, missing);
            }
            list.push(value);
        }
        None if list.is_empty() => {}
        None => list.push(missing),
    }
}

/// Vertices without normal in a mesh with normals get the mean of their faces.
fn fill_normals(mesh: &mut Mesh) {
    let normals = &mut mesh.normals;
    let missing: Vec<bool> = normals.iter().map(|&n| n == [0.0; 3]).collect();
    if !missing.contains(&true) {
        return;
    }
    let mut sums = vec![[0.0_f64; 3]; normals.len()];
    for triangle in &mesh.triangles {
        let normal = crate::normals::area_normal(&mesh.positions, *triangle);
        for &vertex in triangle {
            for (sum, n) in sums[vertex as usize].iter_mut().zip(normal) {
                *sum += n;
            }
        }
    }
    for ((normal, sum), _) in normals.iter_mut().zip(sums).zip(missing).filter(|x| x.1) {
        *normal = crate::normals::unit(sum).unwrap_or([0.0, 0.0, 1.0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(position: u32, uv: u32) -> Corner {
        Corner {
            position,
            uv,
            normal: NONE,
        }
    }

    #[test]
    fn equal_corners_share_a_vertex_however_many_a_position_has() {
        let count = 100;
        let from = Vertices {
            positions: vec![[1.0; 3], [2.0; 3]],
            uvs: (0..count).map(|i| [i as f32, 0.0]).collect(),
            ..Default::default()
        };
        let mut builder = MeshBuilder::default();
        for _ in 0..2 {
            for uv in 0..count {
                assert_eq!(builder.vertex(corner(0, uv), &from), uv);
            }
        }
        assert_eq!(builder.vertex(corner(1, 0), &from), count);
        let mesh = builder.finish();
        assert_eq!(mesh.positions.len(), 101);
        assert_eq!(mesh.uvs[70], [70.0, 0.0]);
        // The heads still name vertices of the first mesh; the second must not believe them.
        assert_eq!(builder.vertex(corner(1, 5), &from), 0);
        assert_eq!(builder.vertex(corner(0, 5), &from), 1);
        assert_eq!(builder.finish().positions, [[2.0; 3], [1.0; 3]]);
    }

    #[test]
    fn attributes_that_only_some_corners_have_are_filled() {
        let from = Vertices {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            uvs: vec![[0.5; 2]],
            normals: vec![[1.0, 0.0, 0.0]],
            ..Default::default()
        };
        let mut builder = MeshBuilder::default();
        let bare = |position| corner(position, NONE);
        let full = Corner {
            position: 2,
            uv: 0,
            normal: 0,
        };
        let ids = [bare(0), full, bare(1)].map(|c| builder.vertex(c, &from));
        builder.push_triangle(ids);
        let mesh = builder.finish();
        assert_eq!(mesh.uvs, [[0.0; 2], [0.5; 2], [0.0; 2]]);
        assert_eq!(
            mesh.normals,
            [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]
        );
    }
}
