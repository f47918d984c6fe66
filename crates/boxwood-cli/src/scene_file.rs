//! The scene that a command line names: a file, or one that Boxwood makes itself.

use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use boxwood_scene::builtin::{self, UnknownBuiltin};
use boxwood_scene::{FlatScene, Format, Scene};
use std::path::Path;
use std::time::Instant;

/// The scene of who names none.
pub const DEFAULT: &str = "teapot-in-stadium";

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

/// Reads a scene file; where there is none of that name, makes the built-in scene of that name.
///
/// # Errors
/// One sentence that names the file.
pub fn open(path: &Path) -> Outcome<SceneFile> {
    let start = Instant::now();
    let name = path.display().to_string();
    let _progress = Progress::spinner(format!("Reading {name}"));
    let (scene, format) = match Format::of_path(path) {
        // `try_exists` fails where the folder may not be searched; loading then says so.
        _ if matches!(path.try_exists(), Ok(false)) => (make(path)?, "built-in"),
        Some(Format::Obj) => (Scene::load(path)?, "obj"),
        Some(Format::Ply) => (Scene::load(path)?, "ply"),
        Some(Format::Stl) => (Scene::load(path)?, "stl"),
        Some(Format::Gltf) => (Scene::load(path)?, "gltf"),
        // Fails, and says which kinds there are.
        None => (Scene::load(path)?, "unknown"),
    };
    Ok(SceneFile {
        name,
        format,
        scene,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// The built-in scene of that name.
fn make(path: &Path) -> Outcome<Scene> {
    let name = path.display();
    let absent = || Failure::new(format!("{name}: there is no such file"));
    let made = builtin::by_name(path.to_str().ok_or_else(absent)?);
    made.map_err(|error| match error {
        // Who writes an extension means a file.
        UnknownBuiltin::Name { .. } if path.extension().is_some() => absent(),
        UnknownBuiltin::Name { .. } => Failure::new(format!(
            "{name}: there is no such file and no built-in scene of this name; built in: {}",
            builtin::list()
        )),
        error => Failure::new(format!("{name}: {error}")),
    })
}

impl SceneFile {
    /// Every placement as one set of triangles.
    ///
    /// # Errors
    /// One sentence that names the file.
    pub fn flatten(&self) -> Outcome<FlatScene> {
        self.scene
            .flatten()
            .map_err(|e| Failure::new(format!("{}: {e}", self.name)))
    }

    /// What its cameras answer to: their names, or their numbers from 0 where they have none.
    pub fn camera_names(&self) -> Vec<String> {
        (0..)
            .zip(&self.scene.cameras)
            .map(|(i, camera): (usize, _)| match camera.name.as_str() {
                "" => i.to_string(),
                name => name.to_string(),
            })
            .collect()
    }
}
