//! `boxwood info`: what is in a scene.

use crate::args::InfoArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use crate::terminal::{self, Channel, grouped};
use boxwood_scene::{LightKind, Mesh, Scene};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// What is in a scene, by number.
#[derive(Serialize)]
struct Contents<'a> {
    file: &'a str,
    format: &'a str,
    /// Every placement counts.
    triangles: u64,
    /// Each mesh counts once.
    unique_triangles: u64,
    /// Of exactly zero area; every placement counts.
    degenerate: u64,
    meshes: usize,
    /// Placements of meshes, those in placed groups included.
    instances: u64,
    bounds: Option<Bounds>,
    materials: usize,
    textures: usize,
    lights: usize,
    cameras: Vec<String>,
    memory_bytes: u64,
    warnings: &'a [String],
}

#[derive(Serialize)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

pub fn run(args: &InfoArgs) -> Outcome {
    let file = scene_file::open(&args.scene)?;
    let contents = {
        let _progress = Progress::spinner("Counting");
        Contents::of(&file)
    };
    if args.json {
        Channel::Stdout.say(serde_json::to_string_pretty(&contents)?)
    } else {
        Channel::Stdout.say(contents.table(&file.scene))
    }
}

impl<'a> Contents<'a> {
    fn of(file: &'a SceneFile) -> Self {
        let scene = &file.scene;
        let degenerate: Vec<u64> = scene.meshes.iter().map(degenerate).collect();
        let bounds = scene.bounds();
        Self {
            file: &file.name,
            format: file.format,
            triangles: scene.triangle_count(),
            unique_triangles: scene.unique_triangle_count(),
            degenerate: scene.count(|mesh| degenerate[mesh as usize]),
            meshes: scene.meshes.len(),
            instances: scene.placement_count(),
            bounds: (!bounds.is_empty()).then(|| Bounds {
                min: bounds.lower.to_array(),
                max: bounds.upper.to_array(),
            }),
            materials: scene.materials.len(),
            textures: scene.images.len(),
            lights: scene.lights.len(),
            cameras: file.camera_names(),
            memory_bytes: memory(scene),
            warnings: &scene.warnings,
        }
    }

    fn table(&self, scene: &Scene) -> String {
        let mut lines = vec![("file", format!("{} ({})", self.file, self.format))];
        let mut triangles = grouped(self.triangles);
        let mut notes = Vec::new();
        if self.unique_triangles != self.triangles {
            notes.push(format!("{} unique", grouped(self.unique_triangles)));
        }
        if self.degenerate > 0 {
            notes.push(format!("{} of zero area", grouped(self.degenerate)));
        }
        if !notes.is_empty() {
            triangles += &format!(" ({})", notes.join(", "));
        }
        lines.push(("triangles", triangles));
        lines.push(("meshes", grouped(self.meshes as u64)));
        lines.push(("instances", grouped(self.instances)));
        match &self.bounds {
            None => lines.push(("bounds", "empty".to_string())),
            Some(Bounds { min, max }) => {
                let size = [0, 1, 2].map(|axis| max[axis] - min[axis]);
                lines.push(("bounds", format!("{} to {}", point(min), point(max))));
                lines.push(("size", size.map(|x| x.to_string()).join(" x ")));
            }
        }
        lines.push(("materials", grouped(self.materials as u64)));
        lines.push(("textures", textures(scene)));
        lines.push(("lights", lights(scene)));
        lines.push((
            "cameras",
            match self.cameras.len() {
                0 => "0".to_string(),
                n => format!("{} ({})", grouped(n as u64), self.cameras.join(", ")),
            },
        ));
        lines.push(("memory", terminal::bytes(self.memory_bytes)));
        lines.push(("warnings", grouped(self.warnings.len() as u64)));
        let mut text: Vec<String> = lines
            .iter()
            .map(|(name, value)| format!("{name:<10} {value}"))
            .collect();
        text.extend(self.warnings.iter().map(|warning| format!("  {warning}")));
        text.join("\n")
    }
}

fn point(p: &[f32; 3]) -> String {
    let [x, y, z] = p;
    format!("({x}, {y}, {z})")
}

/// How many, and how many of each size: `17 (12 of 512x512, 5 of 1024x1024)`.
fn textures(scene: &Scene) -> String {
    let mut sizes = BTreeMap::new();
    for image in &scene.images {
        *sizes.entry(image.size).or_insert(0_u64) += 1;
    }
    let sizes: Vec<String> = sizes
        .iter()
        .rev()
        .map(|([width, height], count)| format!("{} of {width}x{height}", grouped(*count)))
        .collect();
    listed(scene.images.len(), &sizes)
}

/// How many, and how many of each kind.
fn lights(scene: &Scene) -> String {
    let mut kinds = BTreeMap::new();
    for light in &scene.lights {
        let kind = match light.kind {
            LightKind::Point { .. } => "point",
            LightKind::Directional { .. } => "directional",
            LightKind::Spot { .. } => "spot",
            LightKind::Sphere { .. } => "sphere",
            LightKind::Rectangle { .. } => "rectangle",
        };
        *kinds.entry(kind).or_insert(0_u64) += 1;
    }
    let kinds: Vec<String> = kinds
        .iter()
        .map(|(kind, count)| format!("{} {kind}", grouped(*count)))
        .collect();
    listed(scene.lights.len(), &kinds)
}

fn listed(count: usize, parts: &[String]) -> String {
    let count = grouped(count as u64);
    if parts.is_empty() {
        count
    } else {
        format!("{count} ({})", parts.join(", "))
    }
}

/// How many triangles have exactly zero area in the mesh's own space. In double precision the differences and products of
/// floats of similar size are exact, so rounding makes no triangle flat.
fn degenerate(mesh: &Mesh) -> u64 {
    let flat = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].map(f64::from));
        let edge = |to: [f64; 3]| [to[0] - a[0], to[1] - a[1], to[2] - a[2]];
        let (e1, e2) = (edge(b), edge(c));
        (0..3).all(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            e1[j] * e2[k] == e1[k] * e2[j]
        })
    };
    mesh.triangles
        .par_iter()
        .with_min_len(4096)
        .filter(|t| flat(t))
        .count() as u64
}

/// Bytes of the scene's tables: geometry and images as they are kept.
fn memory(scene: &Scene) -> u64 {
    let meshes = scene.meshes.iter().map(|mesh| {
        size_of_val(&*mesh.positions)
            + size_of_val(&*mesh.triangles)
            + size_of_val(&*mesh.normals)
            + size_of_val(&*mesh.tangents)
            + size_of_val(&*mesh.uvs)
            + size_of_val(&*mesh.uvs1)
            + size_of_val(&*mesh.colors)
    });
    let images = scene.images.iter().map(|image| image.bytes.len());
    let tables = size_of_val(&*scene.meshes)
        + size_of_val(&*scene.instances)
        + size_of_val(&*scene.placed_groups)
        + size_of_val(&*scene.materials)
        + (scene.groups.iter())
            .map(|group| size_of_val(&*group.instances) + size_of_val(&*group.groups))
            .sum::<usize>();
    (meshes.chain(images).sum::<usize>() + tables) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: Vec<[f32; 3]>) -> Mesh {
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        Mesh {
            triangles: triangles.collect(),
            positions,
            ..Mesh::default()
        }
    }

    #[test]
    fn only_exactly_flat_triangles_are_degenerate() {
        let flat = mesh(vec![
            // A point, a repeated corner, three points in a row.
            [0.1; 3],
            [0.1; 3],
            [0.1; 3],
            [1.0, 2.0, 3.0],
            [0.5; 3],
            [1.0, 2.0, 3.0],
            [0.0; 3],
            [0.1; 3],
            [0.2; 3],
        ]);
        assert_eq!(degenerate(&flat), 3);
        let thin = mesh(vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.5, f32::MIN_POSITIVE, 0.0],
            [0.1; 3],
            [0.2; 3],
            [0.3; 3],
        ]);
        // The float 0.3 is not three times the float 0.1, yet all lie on the diagonal.
        assert_eq!(degenerate(&thin), 1);
    }
}
