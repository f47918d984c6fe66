//! Wavefront OBJ with MTL materials.
//!
//! *How it works.* One pass over the bytes: [`statements`] reads vertices into lists and faces through a
//! [`mesh_builder`] into meshes; the material libraries that were named come last ([`mtl`]), when it is known who uses
//! them. A new mesh begins where object, group or material change between two faces, so that the triangles stay in
//! file order and each mesh has one material. *Cost.* Linear, well over 100 MB/s on one core; memory a small multiple
//! of the file. *Source.* Wavefront, *Advanced Visualizer Manual*, appendix B1 (OBJ) and 5 (MTL), and what exporters
//! really write.

mod cursor;
mod map;
mod mesh_builder;
mod mtl;
mod number;
mod phong;
mod statements;
mod vertices;
mod warnings;

use super::Source;
use crate::error::Place;
use crate::scene::Instance;
use crate::{Material, Scene, SceneError};
use boxwood::Affine;
use statements::{Document, Usage};
use std::collections::HashMap;
use warnings::Warnings;

/// The number of a line, counted from 1.
#[derive(Clone, Copy)]
struct Line(usize);

/// Reads a scene.
///
/// # Errors
/// [`SceneError::Malformed`] for numbers that are none, coordinates that are not finite and indices that name no
/// vertex; [`SceneError::Unsupported`] for UTF-16. Everything else that is wrong becomes a warning.
pub fn read(bytes: &[u8], source: Source<'_>) -> Result<Scene, SceneError> {
    check_is_text(bytes, source.name)?;
    let mut document = statements::read(bytes, source.name)?;
    let mut library = mtl::Library::default();
    let mut all_found = true;
    for (line, names) in &document.libraries {
        all_found &= library.load(names, source, *line, &mut document.warnings);
    }
    let materials = bind(&mut document, &mut library, all_found);
    let instances = (0..document.meshes.len() as u32).map(|mesh| Instance {
        mesh,
        transform: Affine::IDENTITY,
    });
    let mut warnings: Vec<String> = document.warnings.finish().collect();
    warnings.extend(library.warnings);
    Ok(Scene {
        instances: instances.collect(),
        meshes: document.meshes,
        materials,
        images: library.images,
        warnings,
        ..Scene::default()
    })
}

/// Turns each mesh's material from a number of a `usemtl` name into an index of the scene's materials, and returns
/// those: first the libraries', then a default one for each name that no library has.
fn bind(
    document: &mut Document,
    library: &mut mtl::Library,
    all_libraries_found: bool,
) -> Vec<Material> {
    let mut materials = std::mem::take(&mut library.materials);
    let mut known = HashMap::new();
    for (index, material) in materials.iter().enumerate() {
        known.entry(material.name.clone()).or_insert(index as u32);
    }
    let bound: Vec<u32> = (document.usages.iter())
        .map(|Usage { name, line }| match known.get(name) {
            Some(&index) => index,
            None => {
                if all_libraries_found && !name.is_empty() {
                    unknown_material(&mut document.warnings, *line, name);
                }
                materials.push(Material {
                    name: name.clone(),
                    ..Material::default()
                });
                materials.len() as u32 - 1
            }
        })
        .collect();
    for mesh in &mut document.meshes {
        mesh.material = bound[mesh.material as usize];
    }
    materials
}

fn unknown_material(warnings: &mut Warnings, line: Line, name: &str) {
    warnings.of_kind("unknown material", line, || {
        let name = cursor::quoted(name.as_bytes());
        format!("no material library has the material {name}; a grey one takes its place")
    });
}

/// Refuses what cannot be an OBJ file before anybody wonders about its words.
fn check_is_text(bytes: &[u8], file: &str) -> Result<(), SceneError> {
    // Indices are 32 bits wide, and a corner takes two bytes or more.
    const LARGEST: u64 = 2 * u32::MAX as u64;
    let unsupported = |what: &str| SceneError::Unsupported {
        file: file.to_owned(),
        place: Place::File,
        what: what.to_owned(),
    };
    if matches!(bytes, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]) {
        return Err(unsupported("text in UTF-16 (UTF-8 or ASCII was expected)"));
    }
    if bytes.len() as u64 > LARGEST {
        return Err(unsupported("an OBJ file of more than 8 GiB"));
    }
    let malformed = |place, problem: &str| SceneError::Malformed {
        file: file.to_owned(),
        place,
        problem: problem.to_owned(),
    };
    if bytes.trim_ascii().is_empty() {
        return Err(malformed(
            Place::File,
            "is empty, but OBJ statements such as \"v 0 0 0\" were expected",
        ));
    }
    if let Some(at) = bytes.iter().take(4096).position(|&byte| byte == 0) {
        return Err(malformed(
            Place::Byte(at as u64),
            "a zero byte; OBJ files are text, this one is binary",
        ));
    }
    Ok(())
}
