//! The tables that every loader fills and every renderer reads.

use crate::image::Image;
use crate::material::Material;
use boxwood::{Aabb, Affine};

/// Everything a file said: geometry, where it stands, what it looks like, what lights it and who watches.
///
/// Loaders guarantee that every index is in range, every position finite and every attribute list empty or as long as
/// the positions. World space is right-handed; `up` says which way is up.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Meshes in file order, each with one material. A mesh that no instance places is left out.
    pub meshes: Vec<Mesh>,
    /// Every placement of a mesh, depth first in the file's hierarchy.
    pub instances: Vec<Instance>,
    /// What can be placed as a whole: trees of leaves, forests of such trees. A group places only groups before it.
    pub groups: Vec<Group>,
    /// Placements of groups.
    pub placed_groups: Vec<PlacedGroup>,
    /// Materials; index 0 exists whenever there is a mesh.
    pub materials: Vec<Material>,
    /// Images that materials name.
    pub images: Vec<Image>,
    /// Lights in world space. Emissive materials shine besides.
    pub lights: Vec<Light>,
    /// Cameras in world space.
    pub cameras: Vec<Camera>,
    /// What rays see that leave the scene; `None` when the file says nothing.
    pub environment: Option<Environment>,
    /// The direction that a camera without other wishes calls up: `[0, 1, 0]`, or `[0, 0, 1]` for STL.
    pub up: [f32; 3],
    /// One clear sentence for each thing that was passed over, naming the file and the place.
    pub warnings: Vec<String>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            meshes: Vec::new(),
            instances: Vec::new(),
            groups: Vec::new(),
            placed_groups: Vec::new(),
            materials: Vec::new(),
            images: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            environment: None,
            up: [0.0, 1.0, 0.0],
            warnings: Vec::new(),
        }
    }
}

/// Triangles with one material, in object space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The file's name for it; may be empty.
    pub name: String,
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Three vertices each, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit vertex normals, or none.
    pub normals: Vec<[f32; 3]>,
    /// Unit tangents with the sign of the bitangent last (`bitangent = sign · normal × tangent`), or none.
    pub tangents: Vec<[f32; 4]>,
    /// Texture coordinates, `v` pointing *down* from the image's first row (as in glTF), or none.
    pub uvs: Vec<[f32; 2]>,
    /// The second set of texture coordinates, or none.
    pub uvs1: Vec<[f32; 2]>,
    /// Linear colours with alpha that multiply the material's, or none.
    pub colors: Vec<[f32; 4]>,
    /// Index of the material.
    pub material: u32,
    /// Where `normals` is empty: whether a renderer may make smooth ones (scans, old OBJ files) or must show the
    /// facets (glTF, STL).
    pub smooth: bool,
}

/// One placement of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the mesh.
    pub mesh: u32,
    /// From the mesh's object space to world space.
    pub transform: Affine,
}

/// Placed meshes and groups that can be placed as a whole, many times.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// Placements of meshes in the group's space.
    pub instances: Vec<Instance>,
    /// Placements of groups that come before this one.
    pub groups: Vec<PlacedGroup>,
}

/// One placement of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedGroup {
    /// Index of the group.
    pub group: u32,
    /// From the group's space to the space it is placed in.
    pub transform: Affine,
}

/// A light with its place in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The file's name for it; may be empty.
    pub name: String,
    /// What kind of light.
    pub kind: LightKind,
}

/// Kinds of light. Colours are linear RGB; directions are unit vectors in world space.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Shines from a point into all directions.
    Point {
        /// Where.
        position: [f32; 3],
        /// Radiant intensity; irradiance falls with the square of the distance.
        intensity: [f32; 3],
        /// Nothing beyond this distance is lit; infinite when the file says nothing.
        range: f32,
    },
    /// Shines from infinitely far away.
    Directional {
        /// Where the light travels to.
        direction: [f32; 3],
        /// Irradiance on a surface that faces it.
        irradiance: [f32; 3],
    },
    /// Shines from a point into a cone.
    Spot {
        /// Where.
        position: [f32; 3],
        /// The axis of the cone, away from the light.
        direction: [f32; 3],
        /// Radiant intensity on the axis.
        intensity: [f32; 3],
        /// Full intensity within this half angle, in radians.
        inner: f32,
        /// Darkness beyond this half angle, in radians.
        outer: f32,
        /// Nothing beyond this distance is lit; infinite when the file says nothing.
        range: f32,
    },
    /// A ball that shines; casts soft shadows.
    Sphere {
        /// The middle.
        center: [f32; 3],
        /// In world units.
        radius: f32,
        /// Radiance of its surface.
        radiance: [f32; 3],
    },
    /// A parallelogram that shines on the side of `edge_u × edge_v`; casts soft shadows.
    Rectangle {
        /// One corner.
        corner: [f32; 3],
        /// From the corner to the next.
        edge_u: [f32; 3],
        /// From the corner to the one before.
        edge_v: [f32; 3],
        /// Radiance of its surface.
        radiance: [f32; 3],
    },
}

/// A camera in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The file's name for it; may be empty.
    pub name: String,
    /// Where it stands.
    pub eye: [f32; 3],
    /// Unit vector to where it looks.
    pub forward: [f32; 3],
    /// Unit vector that points up in the image.
    pub up: [f32; 3],
    /// How it maps directions to the image.
    pub projection: Projection,
}

/// How a camera maps the world to its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Central projection.
    Perspective {
        /// Vertical field of view in radians.
        vfov: f32,
    },
    /// Parallel projection.
    Orthographic {
        /// Height of the image in world units.
        height: f32,
    },
}

/// Light from infinitely far away in every direction.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Index of a latitude-longitude image in [`Scene::images`]: its first row is straight up, its centre column
    /// is direction −z (`u = ½ + atan2(x, −z) / 2π`, `v = acos(y) / π` in a y-up frame).
    pub image: u32,
    /// Multiplies the image.
    pub intensity: f32,
}

impl Scene {
    /// How many triangles when every placement counts.
    pub fn triangle_count(&self) -> u64 {
        self.count(|mesh| self.meshes[mesh as usize].triangles.len() as u64)
    }

    /// How many triangles when each mesh counts once.
    pub fn unique_triangle_count(&self) -> u64 {
        self.meshes.iter().map(|m| m.triangles.len() as u64).sum()
    }

    /// How many placements of meshes there are, those in placed groups included.
    pub fn placement_count(&self) -> u64 {
        self.count(|_| 1)
    }

    /// The sum over all placements of what is counted in a mesh, given by its index; at most `u64::MAX`.
    pub fn count(&self, in_mesh: impl Fn(u32) -> u64) -> u64 {
        let direct = |instances: &[Instance]| {
            let each = instances.iter().map(|placed| in_mesh(placed.mesh));
            each.fold(0, u64::saturating_add)
        };
        let groups = |placed: &[PlacedGroup], counts: &[u64]| {
            let each = placed.iter().map(|placed| counts[placed.group as usize]);
            each.fold(0, u64::saturating_add)
        };
        let mut counts: Vec<u64> = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            counts.push(direct(&group.instances).saturating_add(groups(&group.groups, &counts)));
        }
        direct(&self.instances).saturating_add(groups(&self.placed_groups, &counts))
    }

    /// Around every placement's vertices; empty when there is none. Groups are placed by their boxes, so that it may be larger
    /// than need be where there are any.
    pub fn bounds(&self) -> Aabb {
        let direct = |instances: &[Instance]| {
            instances.iter().fold(Aabb::EMPTY, |around, instance| {
                let mesh = &self.meshes[instance.mesh as usize];
                let used = mesh.triangles.iter().flatten();
                let points = used.map(|&v| instance.transform.point(mesh.positions[v as usize]));
                around.union(Aabb::of(points))
            })
        };
        let groups = |placed: &[PlacedGroup], boxes: &[Aabb]| {
            placed.iter().fold(Aabb::EMPTY, |around, placed| {
                around.union(placed.transform.bounds(&boxes[placed.group as usize]))
            })
        };
        let mut boxes: Vec<Aabb> = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            boxes.push(direct(&group.instances).union(groups(&group.groups, &boxes)));
        }
        direct(&self.instances).union(groups(&self.placed_groups, &boxes))
    }
}
