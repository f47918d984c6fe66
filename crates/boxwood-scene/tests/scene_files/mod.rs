//! Real scene files, from the folder that the environment variable `BOXWOOD_SCENES` names, and what is said of them.

use boxwood_scene::{Scene, SceneError};
use std::path::{Path, PathBuf};

/// The folder, or `None` (and a line that says so) where there is none.
pub fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("BOXWOOD_SCENES").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: BOXWOOD_SCENES does not name a folder of scenes");
    }
    folder
}

/// All files of a folder with this extension, in the order of their names.
pub fn with_extension(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(extension))
        })
        .collect();
    found.sort();
    found
}

/// How many triangles have no area at all.
pub fn degenerate(scene: &Scene) -> usize {
    let without_area = |corners: [[f32; 3]; 3]| {
        let [a, b, c] = corners.map(|p| p.map(f64::from));
        let e: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
        let f: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
        (0..3).all(|k| e[(k + 1) % 3] * f[(k + 2) % 3] == e[(k + 2) % 3] * f[(k + 1) % 3])
    };
    scene
        .meshes
        .iter()
        .flat_map(|m| {
            m.triangles
                .iter()
                .map(|t| t.map(|i| m.positions[i as usize]))
        })
        .filter(|corners| without_area(*corners))
        .count()
}

/// The box around everything that triangles name.
pub fn bounds(scene: &Scene) -> [[f32; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for mesh in &scene.meshes {
        for vertex in mesh.triangles.as_flattened() {
            for (k, c) in mesh.positions[*vertex as usize].into_iter().enumerate() {
                bounds[0][k] = bounds[0][k].min(c);
                bounds[1][k] = bounds[1][k].max(c);
            }
        }
    }
    bounds
}

/// The only thing that is said of a file: its error, or its only warning.
pub fn only_sentence(result: Result<Scene, SceneError>) -> String {
    match result {
        Err(error) => error.to_string(),
        Ok(scene) => {
            let [warning] = scene.warnings.as_slice() else {
                panic!("one warning is expected: {:?}", scene.warnings);
            };
            warning.clone()
        }
    }
}
