//! The scene that a command line names: a file, or one that Boxwood makes itself.

use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use boxwood_scene::{FlatScene, Format, Scene};
use std::path::Path;
use std::time::Instant;

/// A scene with what is said about it.
pub struct SceneFile {
    /// As the user wrote it.
    pub name: String,
    /// `obj`, `ply`, `stl`, `gltf` or `built-in`.
    pub format: &'static str,
    pub scene: Scene,
    /// What reading it took.
    pub seconds: f64,
}

/// Reads the scene.
///
/// # Errors
/// One sentence that names the file.
pub fn open(path: &Path) -> Outcome<SceneFile> {
    let start = Instant::now();
    let name = path.display().to_string();
    let _progress = Progress::spinner(format!("Reading {name}"));
    let scene = Scene::load(path)?;
    let format = match Format::of_path(path) {
        Some(Format::Obj) => "obj",
        Some(Format::Ply) => "ply",
        Some(Format::Stl) => "stl",
        Some(Format::Gltf) | None => "gltf",
    };
    Ok(SceneFile {
        name,
        format,
        scene,
        seconds: start.elapsed().as_secs_f64(),
    })
}

impl SceneFile {
    /// Every placement as one set of triangles.
    pub fn flatten(&self) -> Outcome<FlatScene> {
        self.scene
            .flatten()
            .map_err(|e| Failure::new(format!("{}: {e}", self.name)))
    }
}
