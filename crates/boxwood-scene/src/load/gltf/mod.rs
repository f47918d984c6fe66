//! glTF 2.0, as JSON (`.gltf`) or with its data in one container (`.glb`).
//!
//! *How it works.* The bytes are taken apart ([`container`]), the JSON becomes tables ([`json`], [`schema`]), and a
//! [`File`] follows indices through them, checks every one and keeps a budget of memory. The nodes are put in order
//! ([`hierarchy`]); each primitive of a mesh that the scene shows becomes one [`Mesh`](crate::Mesh), and each of its
//! places one [`Instance`](crate::Instance) ([`placement`]).
//!
//! *What is left out.* Animations; points and lines; occlusion textures; the finer extensions of materials (clear
//! coat, sheen, …), without a word; compressed geometry, with an error where the file requires it. Skins and morph
//! targets are shown at rest. Intensities of lights keep the file's numbers.
//!
//! *Cost.* One pass over what is used; memory in proportion to the files read: about 25 bytes of tables at worst for
//! each byte of JSON, and never more than 64 times all that was read, and 64 MiB, for the scene.
//!
//! *Why not the `gltf` crate.* Its readers index without checks and its checks refuse what we do read
//! (`KHR_mesh_quantization`, `extras` of any type); its model lacks texture transforms of normal maps, and a table
//! of empty objects takes it hundreds of times the file's size.
//!
//! *Source.* glTF 2.0 (ISO/IEC 12113:2022) and the extensions named where they are read.

mod accessors;
mod container;
mod deform;
mod file;
mod hierarchy;
mod images;
mod json;
mod materials;
mod matrix;
mod normals;
mod placement;
mod primitives;
mod schema;
mod topology;
mod uri;

use self::file::File;
use self::hierarchy::Hierarchy;
use self::images::Images;
use super::Source;
use crate::{Scene, SceneError};

/// Reads a scene.
pub fn read(bytes: &[u8], source: Source<'_>) -> Result<Scene, SceneError> {
    let parts = container::split(bytes).map_err(|(place, problem)| SceneError::Malformed {
        file: source.name.to_owned(),
        place,
        problem,
    })?;
    let mut file = File::parse(&parts, source)?;
    file.read_buffers(parts.binary)?;
    for (number, name) in json::unknown_extensions(&file.root) {
        let path = format!("extensionsUsed[{number}]");
        file.warn(path, format!("the extension {name} is passed over"));
    }

    let mut scene = Scene::default();
    let hierarchy = Hierarchy::read(&file)?;
    let mut images = Images::default();
    scene.materials = materials::read(&file, &mut images)?;
    scene.images = images.found;
    let default_material = scene.materials.len() as u32;
    placement::meshes(&file, &hierarchy, default_material, &mut scene)?;
    if scene
        .meshes
        .iter()
        .any(|mesh| mesh.material == default_material)
    {
        scene.materials.push(materials::default());
    }
    placement::cameras_and_lights(&file, &hierarchy, &mut scene)?;
    if scene.instances.is_empty() {
        file.warn("nodes", "no node of the scene shows a triangle");
    }
    scene.warnings = file.into_warnings();
    Ok(scene)
}
