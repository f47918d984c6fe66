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

    /// Leaves out meshes that stand nowhere, and numbers the others anew.
    pub fn drop_unplaced(&mut self) {
        let scene = &mut self.scene;
        let mut used = vec![false; scene.meshes.len()];
        for instance in &scene.instances {
            used[instance.mesh as usize] = true;
        }
        let mut next = 0;
        let numbers: Vec<u32> = used
            .iter()
            .map(|&used| {
                next += u32::from(used);
                next.saturating_sub(1)
            })
            .collect();
        let mut keep = used.iter().copied();
        scene.meshes.retain(|_| keep.next().unwrap_or(true));
        for instance in &mut scene.instances {
            instance.mesh = numbers[instance.mesh as usize];
        }
    }

    /// Adds a mesh that is already in world space.
    pub fn build(&mut self, name: &str, mesh: Mesh, material: u32) {
        let mesh = self.mesh(name, mesh, material);
        self.place(mesh, Affine::IDENTITY);
    }
}

/// Colours that go together, for crowds of things.
pub(super) const PALETTE: [(&str, [f32; 3]); 6] = [
    ("rust", [0.56, 0.13, 0.045]),
    ("ochre", [0.72, 0.42, 0.08]),
    ("ivory", [0.8, 0.76, 0.64]),
    ("sage", [0.24, 0.38, 0.2]),
    ("teal", [0.03, 0.26, 0.3]),
    ("slate", [0.1, 0.13, 0.22]),
];

/// A dielectric of one colour.
pub(super) fn paint(name: &str, [r, g, b]: [f32; 3], roughness: f32) -> Material {
    Material {
        name: name.into(),
        base_color: [r, g, b, 1.0],
        roughness,
        ..Material::default()
    }
}
