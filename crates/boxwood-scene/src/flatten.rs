//! Every placement of every mesh as one set of triangles, and the way back from a hit.

use crate::Scene;
use boxwood::{Aabb, MeshError, TriangleMesh};

/// A scene's triangles in world space, for structures to be built over.
///
/// The numbering is the one that hits are ordered by: first the triangles of every mesh's first placement, in file order
/// (so far flat numbers *are* unique numbers), then those of every second placement, and so on. Of two equally near hits
/// the lower (instance, primitive) is therefore the lower flat number.
#[derive(Clone, Debug)]
pub struct FlatScene {
    /// The triangles; each placed mesh is an object of its own.
    pub mesh: TriangleMesh,
    /// By first flat triangle, ascending.
    parts: Vec<Part>,
}

/// One placement of a mesh among the flat triangles.
#[derive(Clone, Copy, Debug)]
struct Part {
    /// Its first flat triangle.
    first: u32,
    /// The unique number of the mesh's first triangle.
    unique: u32,
    mesh: u32,
    placement: u32,
    nth: u32,
}

/// What a flat triangle is in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Located {
    /// Index in [`Scene::meshes`].
    pub mesh: u32,
    /// Index of the triangle in that mesh.
    pub triangle: u32,
    /// Number of the triangle among all unique triangles, in file order.
    pub primitive: u32,
    /// Index in [`Scene::instances`].
    pub placement: u32,
    /// Which placement of its mesh this is, depth first; 0 for a mesh placed once.
    pub instance: u32,
}

impl Scene {
    /// Lays every placement out in world space. Takes 12 bytes per placed vertex and triangle.
    ///
    /// # Errors
    /// [`MeshError`] when a placement moves a vertex beyond the floats, or when there are more triangles than can be
    /// numbered or than there is memory for.
    ///
    /// # Panics
    /// When an instance names a mesh that does not exist, which no loader does.
    pub fn flatten(&self) -> Result<FlatScene, MeshError> {
        let mut unique = 0_u32;
        let firsts: Vec<u32> = self
            .meshes
            .iter()
            .map(|mesh| {
                let first = unique;
                unique = unique.saturating_add(mesh.triangles.len() as u32);
                first
            })
            .collect();
        let mut placed = vec![0_u32; self.meshes.len()];
        let mut parts: Vec<Part> = (0..)
            .zip(&self.instances)
            .map(|(placement, instance)| {
                let nth = placed[instance.mesh as usize];
                placed[instance.mesh as usize] += 1;
                Part {
                    first: 0,
                    unique: firsts[instance.mesh as usize],
                    mesh: instance.mesh,
                    placement,
                    nth,
                }
            })
            .collect();
        parts.sort_unstable_by_key(|part| (part.nth, part.mesh));

        let count = self.triangle_count();
        let too_many = MeshError::TooMany {
            triangles: usize::try_from(count).unwrap_or(usize::MAX),
        };
        let vertices: u64 = self
            .instances
            .iter()
            .map(|i| self.meshes[i.mesh as usize].positions.len() as u64)
            .sum();
        if count.max(vertices) >= u64::from(u32::MAX) {
            return Err(too_many);
        }
        // Few bytes of a file can place many triangles many times.
        let no_room = |_| MeshError::NoMemory {
            triangles: count as usize,
        };
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        positions
            .try_reserve_exact(vertices as usize)
            .map_err(no_room)?;
        triangles
            .try_reserve_exact(count as usize)
            .map_err(no_room)?;
        for part in &mut parts {
            let mesh = &self.meshes[part.mesh as usize];
            let transform = self.instances[part.placement as usize].transform;
            let base = positions.len() as u32;
            part.first = triangles.len() as u32;
            if transform == boxwood::Affine::IDENTITY {
                positions.extend_from_slice(&mesh.positions);
            } else {
                positions.extend(
                    mesh.positions
                        .iter()
                        .map(|&p| transform.point(p).to_array()),
                );
            }
            triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| base + v)));
        }
        // Placements of empty meshes would hide the part that really begins at their place.
        parts.retain(|part| !self.meshes[part.mesh as usize].triangles.is_empty());
        // Each placed mesh is an object, which ends where the next one begins.
        let ends = parts.iter().skip(1).map(|part| part.first);
        Ok(FlatScene {
            mesh: TriangleMesh::new(positions, triangles)?.with_objects(ends),
            parts,
        })
    }

    /// Around every placement's vertices; empty when there is none.
    pub fn bounds(&self) -> Aabb {
        self.instances.iter().fold(Aabb::EMPTY, |around, instance| {
            let mesh = &self.meshes[instance.mesh as usize];
            let used = mesh.triangles.iter().flatten();
            let points = used.map(|&v| instance.transform.point(mesh.positions[v as usize]));
            around.union(Aabb::of(points))
        })
    }
}

impl FlatScene {
    /// What flat triangle `i` is in the scene. A binary search over the placements.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn locate(&self, i: u32) -> Located {
        let after = self.parts.partition_point(|part| part.first <= i);
        let part = &self.parts[after - 1];
        let triangle = i - part.first;
        Located {
            mesh: part.mesh,
            triangle,
            primitive: part.unique + triangle,
            placement: part.placement,
            instance: part.nth,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Mesh};
    use boxwood::{Affine, BoundingBoxes, Intersect, ObjectBoxes, Primitives};

    fn mesh(triangles: u32) -> Mesh {
        Mesh {
            positions: (0..triangles + 2)
                .map(|i| [i as f32, (i % 2) as f32, 0.0])
                .collect(),
            triangles: (0..triangles).map(|i| [i, i + 1, i + 2]).collect(),
            ..Mesh::default()
        }
    }

    fn scene() -> Scene {
        let place = |mesh, z| Instance {
            mesh,
            transform: Affine::translation([0.0, 0.0, z]),
        };
        Scene {
            meshes: vec![mesh(2), mesh(3), mesh(0), mesh(1)],
            instances: vec![
                place(1, 10.0),
                place(3, 0.0),
                place(1, 20.0),
                place(2, 0.0),
                place(0, 0.0),
            ],
            ..Scene::default()
        }
    }

    #[test]
    fn first_placements_come_first_in_file_order() {
        let scene = scene();
        let flat = scene.flatten().expect("a good scene");
        assert_eq!(scene.triangle_count(), 9);
        assert_eq!(scene.unique_triangle_count(), 6);
        let found: Vec<_> = (0..9)
            .map(|i| {
                let l = flat.locate(i);
                (l.primitive, l.instance, l.mesh, l.triangle, l.placement)
            })
            .collect();
        assert_eq!(
            found,
            [
                (0, 0, 0, 0, 4),
                (1, 0, 0, 1, 4),
                (2, 0, 1, 0, 0),
                (3, 0, 1, 1, 0),
                (4, 0, 1, 2, 0),
                (5, 0, 3, 0, 1),
                (2, 1, 1, 0, 2),
                (3, 1, 1, 1, 2),
                (4, 1, 1, 2, 2),
            ]
        );
        assert_eq!(flat.mesh.triangle(2)[0].z, 10.0);
        assert_eq!(flat.mesh.triangle(6)[0].z, 20.0);
    }

    #[test]
    fn placed_meshes_are_objects() {
        let flat = scene().flatten().expect("a good scene");
        let ends: Vec<usize> = (0..9).map(|i| flat.mesh.object_end(i)).collect();
        assert_eq!(ends, [2, 2, 5, 5, 5, 6, 9, 9, 9]);
        let boxes = ObjectBoxes.build(&flat.mesh);
        let found = Intersect::statistics(&BoundingBoxes::new(&flat.mesh, boxes));
        assert_eq!((found.leaves, found.largest_leaf), (4, 3));
    }

    #[test]
    fn bounds_are_those_of_the_flat_mesh() {
        let around = scene().bounds();
        assert_eq!(around, Aabb::new([0.0; 3], [4.0, 1.0, 20.0]));
        assert!(Scene::default().bounds().is_empty());
    }

    #[test]
    fn a_scene_of_nothing_is_legal() {
        let flat = Scene::default().flatten().expect("legal");
        assert_eq!(flat.mesh.triangles().len(), 0);
    }
}
