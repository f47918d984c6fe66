//! A scene under construction: materials, meshes and placements by number.

use crate::material::Material;
use crate::scene::{Instance, Mesh, Scene};
use boxwood::Affine;

/// Collects the tables of a [`Scene`].
#[derive(Default)]
pub(super) struct Stage {
    pub scene: Scene,
}

impl Stage {
    /// Adds a material.
    pub fn material(&mut self, material: Material) -> u32 {
        self.scene.materials.push(material);
        self.scene.materials.len() as u32 - 1
    }

    /// Adds a mesh that stands nowhere yet.
    pub fn mesh(&mut self, name: &str, mesh: Mesh, material: u32) -> u32 {
        self.scene.meshes.push(Mesh {
            name: name.into(),
            material,
            ..mesh
        });
        self.scene.meshes.len() as u32 - 1
    }

    /// Places a mesh.
    pub fn place(&mut self, mesh: u32, transform: Affine) {
        self.scene.instances.push(Instance { mesh, transform });
    }

    /// Adds a mesh that is already in world space.
    pub fn build(&mut self, name: &str, mesh: Mesh, material: u32) {
        let mesh = self.mesh(name, mesh, material);
        self.place(mesh, Affine::IDENTITY);
    }
}

/// A dielectric of one colour.
pub(super) fn paint(name: &str, [r, g, b]: [f32; 3], roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: [r, g, b, 1.0],
        roughness,
        ..Material::default()
    }
}
