//! The scenes that are measured, with the cameras that look at them.

use crate::failure::{Outcome, failed};
use boxwood::TriangleMesh;
use boxwood_render::camera::{frame, look_at};
use boxwood_scene::{Camera, Scene, builtin};
use std::fs;
use std::path::{Path, PathBuf};

/// A scene’s triangles and who looks at them.
pub struct Loaded {
    pub name: String,
    pub mesh: TriangleMesh,
    /// At least one; the first one's random rays stand for all.
    pub views: Vec<View>,
    pub up: [f32; 3],
}

pub struct View {
    pub name: String,
    pub camera: Camera,
}

/// A file of the scenes folder, or all PLY files of a folder in it, with its views: name, eye, look-at, degrees.
struct Known {
    name: &'static str,
    path: &'static str,
    views: &'static [(&'static str, [f32; 3], [f32; 3], f32)],
}

const KNOWN: [Known; 4] = [
    Known {
        name: "bunny",
        path: "bunny/stanford-bunny.obj",
        views: &[(
            "front",
            [0.049, 0.193, 0.329],
            [-0.017, 0.110, -0.002],
            40.0,
        )],
    },
    Known {
        name: "sponza",
        path: "sponza/sponza.obj",
        views: &[
            ("atrium", [-120.0, 15.0, -4.0], [0.0, 32.0, -4.0], 60.0),
            ("gallery", [100.0, 60.0, -4.0], [0.0, 40.0, 20.0], 65.0),
        ],
    },
    Known {
        name: "dragon",
        path: "dragon/dragon_vrip.ply",
        views: &[(
            "front",
            [0.082, 0.196, 0.348],
            [-0.006, 0.125, -0.005],
            40.0,
        )],
    },
    Known {
        name: "kitchen",
        path: "kitchen/models",
        views: &[("main", [1.211, 1.805, 3.852], [0.773, 1.763, 2.954], 35.98)],
    },
];

/// What is measured when nobody names a scene. 8000 plants are about a million triangles.
pub const DEFAULTS: [&str; 7] = [
    "bunny",
    "sponza",
    "dragon",
    "kitchen",
    "stadium",
    "terrain:5M",
    "plants:8k",
];

const FOLDER: &str = "BOXWOOD_SCENES";

/// The scene of that name: one of the list, a file, or one that code makes.
///
/// # Errors
/// One sentence that says what is missing.
pub fn open(name: &str) -> Outcome<Loaded> {
    if let Some(known) = KNOWN.iter().find(|known| known.name == name) {
        let folder = std::env::var_os(FOLDER).ok_or_else(|| {
            failed(format!(
                "its file is {} in the folder that {FOLDER} names, which is not set",
                known.path
            ))
        })?;
        let path = Path::new(&folder).join(known.path);
        let mesh = if path.is_dir() {
            merged(&path)?
        } else {
            Scene::load(&path)?.flatten()?.mesh
        };
        let view = |&(name, eye, at, degrees): &(&str, _, _, f32)| {
            let camera = look_at(eye, at, UP, degrees.to_radians())?;
            Ok(View {
                name: name.to_string(),
                camera,
            })
        };
        return Ok(Loaded {
            name: name.to_string(),
            mesh,
            views: known.views.iter().map(view).collect::<Outcome<_>>()?,
            up: UP,
        });
    }
    let path = Path::new(name);
    let scene = if path.is_file() {
        Scene::load(path)?
    } else {
        let builtin = if name == "stadium" {
            "teapot-in-stadium"
        } else {
            name
        };
        builtin::by_name(builtin)?
    };
    let flat = scene.flatten()?;
    let camera = scene.cameras.into_iter().next();
    let camera = camera.unwrap_or_else(|| {
        frame(
            &boxwood::Aabb::of(flat.mesh.positions().iter().copied()),
            scene.up,
            0.7,
            1.5,
        )
    });
    Ok(Loaded {
        name: path
            .file_name()
            .map_or(name.into(), |f| f.to_string_lossy().into_owned()),
        mesh: flat.mesh,
        views: vec![View {
            name: "main".to_string(),
            camera,
        }],
        up: scene.up,
    })
}

const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// All PLY files of a folder as one mesh, in the order of their names.
fn merged(folder: &Path) -> Outcome<TriangleMesh> {
    let cannot = |e: std::io::Error| failed(format!("{}: {e}", folder.display()));
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.extension().is_some_and(|e| e == "ply") {
            files.push(path);
        }
    }
    files.sort();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for file in &files {
        let mesh = Scene::load(file)?.flatten()?.mesh;
        let base = positions.len() as u32;
        positions.extend_from_slice(mesh.positions());
        triangles.extend(mesh.triangles().iter().map(|t| t.map(|v| base + v)));
    }
    Ok(TriangleMesh::new(positions, triangles)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_that_code_makes_have_a_camera() {
        let made = open("soup:100").expect("it exists");
        assert_eq!((made.mesh.triangles().len(), made.views.len()), (100, 1));
    }

    #[test]
    fn what_is_not_there_is_said() {
        let error = open("no-such-scene").err().expect("there is none");
        assert!(error.to_string().contains("no-such-scene"), "{error}");
    }

    #[test]
    fn real_cameras_see_their_scenes() {
        if std::env::var_os(FOLDER).is_none() {
            eprintln!("skipped: {FOLDER} is not set");
            return;
        }
        for name in ["bunny", "kitchen"] {
            let subject = open(name).expect("the folder is whole");
            assert!(subject.mesh.triangles().len() > 69_000, "{name}");
        }
    }
}
