//! STL (stereolithography): triangles and nothing else, as text or as packed records.
//!
//! *How it works.* A file whose length is exactly what its count asks for is binary, whatever its first word; else a
//! text that begins with `solid` is ascii; else it is a damaged binary file, and the message says how. Vertices at the
//! same position become one ([`weld`]); triangles stay in file order, those without area too. The normals in the file
//! are ignored: the order of the vertices decides. By custom `z` is up.
//!
//! *Cost.* Linear in the bytes; nearly all of it goes to finding equal vertices.
//!
//! *Source.* 3D Systems 1989, "StereoLithography Interface Specification".

mod ascii;
mod binary;
mod weld;

use super::Source;
use super::file::{File, scene_of};
use crate::error::Place;
use crate::{Mesh, Scene, SceneError};

/// Reads a scene: a mesh for each solid that has triangles.
pub fn read(bytes: &[u8], source: Source<'_>) -> Result<Scene, SceneError> {
    let file = File::new(bytes, source);
    if bytes.is_empty() {
        return Err(file.error(Place::File, "the file is empty; expected an STL model"));
    }
    let mut warnings = Vec::new();
    let meshes = if !binary::has_exact_length(bytes) && is_text(bytes) {
        ascii::read(file)?
    } else {
        let mesh = binary::read(file, &mut warnings)?;
        Some(mesh)
            .filter(|mesh| !mesh.triangles.is_empty())
            .into_iter()
            .collect()
    };
    if meshes.is_empty() {
        warnings.push(file.warning(Place::File, "the file has no triangles: nothing to show"));
    }
    let mut scene = scene_of(meshes, warnings);
    scene.up = [0.0, 0.0, 1.0];
    Ok(scene)
}

/// Whether the file begins with `solid` and goes on as text: the records of a binary file have zero bytes.
fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    let text = ascii::without_mark(start).trim_ascii_start();
    let solid = text
        .get(..5)
        .is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    let ends = text.get(5).is_none_or(u8::is_ascii_whitespace);
    solid && ends && !start.contains(&0)
}

/// A mesh that shows its facets.
fn mesh_of(name: String, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name,
        positions,
        triangles,
        smooth: false,
        ..Mesh::default()
    }
}
