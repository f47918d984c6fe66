//! Every placement of every mesh as one set of triangles, and the way back from a hit.

use crate::scene::{Instance, PlacedGroup, Scene};
use boxwood::{Affine, MeshError, TriangleMesh};

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
    nth: u32,
    transform: Affine,
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
    /// Which placement of its mesh this is, in the order of the scene; 0 for a mesh placed once.
    pub instance: u32,
}

impl Scene {
    /// Lays every placement out in world space, those in placed groups after all others. Takes 12 bytes per placed vertex and
    /// triangle.
    ///
    /// # Errors
    /// [`MeshError`] when a placement moves a vertex beyond the floats, or when there are more triangles than can be
    /// numbered or than there is memory for.
    ///
    /// # Panics
    /// When an instance names a mesh that does not exist, which no loader does.
    pub fn flatten(&self) -> Result<FlatScene, MeshError> {
        let count = self.triangle_count();
        let vertices = self.count(|mesh| self.meshes[mesh as usize].positions.len() as u64);
        let most = count.max(vertices).max(self.placement_count());
        if most >= u64::from(u32::MAX) {
            return Err(MeshError::TooMany {
                triangles: usize::try_from(count).unwrap_or(usize::MAX),
            });
        }
        let mut placed = self.instances.clone();
        for group in &self.placed_groups {
            self.unfold(group, &Affine::IDENTITY, &mut placed);
        }
        self.lay_out(&placed)
    }

    /// Adds what a placed group places.
    fn unfold(&self, placed: &PlacedGroup, outer: &Affine, all: &mut Vec<Instance>) {
        let group = &self.groups[placed.group as usize];
        let here = placed.transform.then(outer);
        all.extend(group.instances.iter().map(|instance| Instance {
            transform: instance.transform.then(&here),
            ..*instance
        }));
        for inner in &group.groups {
            self.unfold(inner, &here, all);
        }
    }

    /// The number of each mesh's first triangle among all unique triangles, in file order.
    pub fn first_triangles(&self) -> Vec<u32> {
        let mut unique = 0_u32;
        self.meshes
            .iter()
            .map(|mesh| {
                let first = unique;
                unique = unique.saturating_add(mesh.triangles.len() as u32);
                first
            })
            .collect()
    }

    /// Lays some placements of its meshes out in world space: those of meshes that are placed once, for who keeps the others as
    /// instances. Numbers are given as by [`Scene::flatten`].
    ///
    /// # Errors
    /// As [`Scene::flatten`].
    ///
    /// # Panics
    /// When an instance names a mesh that does not exist.
    pub fn lay_out(&self, placed: &[Instance]) -> Result<FlatScene, MeshError> {
        let firsts = self.first_triangles();
        let mut times = vec![0_u32; self.meshes.len()];
        let mut parts: Vec<Part> = placed
            .iter()
            .map(|instance| {
                let times = &mut times[instance.mesh as usize];
                *times += 1;
                Part {
                    first: 0,
                    unique: firsts[instance.mesh as usize],
                    mesh: instance.mesh,
                    nth: *times - 1,
                    transform: instance.transform,
                }
            })
            .collect();
        // Stable, though no two are the same.
        parts.sort_by_key(|part| (part.nth, part.mesh));

        let meshes = || {
            placed
                .iter()
                .map(|instance| &self.meshes[instance.mesh as usize])
        };
        let count: u64 = meshes().map(|mesh| mesh.triangles.len() as u64).sum();
        let vertices: u64 = meshes().map(|mesh| mesh.positions.len() as u64).sum();
        if count.max(vertices) >= u64::from(u32::MAX) {
            return Err(MeshError::TooMany {
                triangles: usize::try_from(count).unwrap_or(usize::MAX),
            });
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
            let transform = part.transform;
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
}

impl FlatScene {
    /// What flat triangle `i` is in the scene. A binary search over the placements.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn locate(&self, i: u32) -> Located {
        self.locate_placed(i).0
    }

    /// The same, with the transform that its mesh was laid out by.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn locate_placed(&self, i: u32) -> (Located, &Affine) {
        let after = self.parts.partition_point(|part| part.first <= i);
        let part = &self.parts[after - 1];
        let triangle = i - part.first;
        let located = Located {
            mesh: part.mesh,
            triangle,
            primitive: part.unique + triangle,
            instance: part.nth,
        };
        (located, &part.transform)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Mesh};
    use boxwood::{Aabb, BoundingBoxes, Intersect, ObjectBoxes, Primitives};

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
                (l.primitive, l.instance, l.mesh, l.triangle)
            })
            .collect();
        assert_eq!(
            found,
            [
                (0, 0, 0, 0),
                (1, 0, 0, 1),
                (2, 0, 1, 0),
                (3, 0, 1, 1),
                (4, 0, 1, 2),
                (5, 0, 3, 0),
                (2, 1, 1, 0),
                (3, 1, 1, 1),
                (4, 1, 1, 2),
            ]
        );
        assert_eq!(flat.mesh.triangle(2)[0].z, 10.0);
        assert_eq!(flat.mesh.triangle(6)[0].z, 20.0);
    }

    #[test]
    fn groups_are_unfolded() {
        let mut scene = scene();
        let place = |group, x| PlacedGroup {
            group,
            transform: Affine::translation([x, 0.0, 0.0]),
        };
        let instances = vec![Instance {
            mesh: 3,
            transform: Affine::translation([0.0, 7.0, 0.0]),
        }];
        scene.groups = vec![
            crate::Group {
                instances,
                groups: Vec::new(),
            },
            crate::Group {
                instances: Vec::new(),
                groups: vec![place(0, 1.0), place(0, 2.0)],
            },
        ];
        scene.placed_groups = vec![place(1, 10.0), place(0, 100.0)];
        assert_eq!((scene.triangle_count(), scene.placement_count()), (12, 8));
        let flat = scene.flatten().expect("a good scene");
        let last: Vec<f32> = (9..12).map(|i| flat.mesh.triangle(i)[0].x).collect();
        assert_eq!(last, [11.0, 12.0, 100.0]);
        let numbers: Vec<u32> = (9..12).map(|i| flat.locate(i).instance).collect();
        assert_eq!(numbers, [1, 2, 3]);
        assert_eq!(scene.bounds().upper.x, 102.0);
        // Doubled so often that no number holds it.
        for i in 2..80 {
            scene.groups.push(crate::Group {
                instances: Vec::new(),
                groups: vec![place(i - 1, 0.0); 2],
            });
        }
        scene.placed_groups = vec![place(79, 0.0)];
        assert_eq!(scene.placement_count(), u64::MAX);
        assert!(scene.flatten().is_err());
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
