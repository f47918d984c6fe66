//! The camera that a command line asks for.

use crate::args::CameraArgs;
use crate::failure::{Failure, Outcome};
use crate::scene_file::SceneFile;
use boxwood_render::camera;
use boxwood_scene::{Camera, Projection};

/// Vertical field of view of a camera that nobody described.
const FOV: f32 = 40.0;

/// The camera the user asked for, the scene's first, or one that shows everything; and its name when it is the scene's.
pub fn choose(
    args: &CameraArgs,
    file: &SceneFile,
    [width, height]: [u32; 2],
) -> Outcome<(Camera, Option<String>)> {
    let names = file.camera_names();
    let own = |i: usize| {
        let mut camera = file.scene.cameras[i].clone();
        if let Some(degrees) = args.fov {
            camera.projection = Projection::Perspective {
                vfov: degrees.to_radians(),
            };
        }
        Ok((camera, Some(names[i].clone())))
    };
    if let Some(wanted) = &args.camera {
        let found = names.iter().position(|name| name == wanted);
        return match found {
            Some(i) => own(i),
            None if names.is_empty() => Err(Failure::new(format!(
                "{}: has no cameras of its own, so none is called `{wanted}`",
                file.name
            ))),
            None => Err(Failure::new(format!(
                "{}: no camera is called `{wanted}`; there are {}",
                file.name,
                names.join(", ")
            ))),
        };
    }
    let described = args.eye.is_some() || args.up.is_some();
    if !described && !names.is_empty() {
        return own(0);
    }
    let up = args.up.map_or(file.scene.up, |up| up.0);
    if up == [0.0; 3] {
        return Err(Failure::new("--up 0,0,0 gives no direction"));
    }
    let vfov = args.fov.unwrap_or(FOV).to_radians();
    let bounds = file.scene.bounds();
    let chosen = match args.eye {
        None => camera::frame(&bounds, up, vfov, width as f32 / height as f32),
        Some(eye) => {
            let middle = if bounds.is_empty() {
                [0.0; 3]
            } else {
                bounds.centroid().to_array()
            };
            camera::look_at(eye.0, args.look_at.map_or(middle, |at| at.0), up, vfov)?
        }
    };
    Ok((chosen, None))
}
