//! Scenes made by code: no file needed, the same bits on every machine.
//!
//! *How it works.* Each scene has a name and a function that fills the tables of a [`Scene`]. Only the four basic
//! operations, square roots and the functions of `libm` are used, so every machine computes the same scene.
//!
//! The scenes are hard on structures each in its own way. [`names()`] lists them; those that take a number (`city:2000`) can
//! be made in any size, and each seed makes another one.
//!
//! *Source.* "Teapot in a stadium" is an old name for what troubles grids and octrees: a small thing with all the
//! detail in the middle of a large one (E. Haines, "Spline Surface Rendering, and What's Wrong with Octrees", *Ray
//! Tracing News* 1(2), 1988).

mod city;
mod crowd;
mod facade;
mod foliage;
mod names;
mod newell;
mod oval;
mod pitch;
mod plants;
mod random;
mod seats;
mod solids;
mod soup;
mod sponge;
mod stadium;
mod stage;
mod still_life;
mod teapot;
mod terrain;
#[cfg(test)]
mod tests;

pub use names::{UnknownBuiltin, by_name, list, names};
pub use teapot::{MAX_SUBDIVISIONS, teapot};

use crate::scene::{Camera, Light, LightKind, Projection, Scene};
use boxwood::Vec3;
use stage::Stage;

/// Newell's teapot in glazed clay on the centre spot of a stadium 186 m long, among glass, mirror and brass, in the
/// light of a late afternoon.
///
/// The cameras are `main`, close to the table, and `overview`, high up in the stands.
pub fn teapot_in_stadium() -> Scene {
    let mut stage = Stage::default();
    still_life::still_life(&mut stage);
    pitch::pitch(&mut stage);
    stadium::stadium(&mut stage);
    let mut scene = stage.scene;
    scene.lights = vec![
        sun([0.58, -0.5, -0.64]),
        // A white cloth held over the table, out of the picture: it softens the shadows and shines in the glaze.
        Light {
            name: "softbox".into(),
            kind: LightKind::Rectangle {
                corner: [0.6, 2.6, 1.2],
                edge_u: [1.2, 0.0, 0.0],
                edge_v: [0.0, 0.5, -0.9],
                radiance: [1.6, 1.7, 1.9],
            },
        },
    ];
    scene.cameras = vec![
        camera("main", [0.2, 0.785, 1.2], [0.12, 0.87, 0.0], 44.0),
        camera("overview", [-56.0, 19.0, 52.0], [-2.0, 3.0, 0.0], 50.0),
    ];
    scene
}

/// A late sun whose light travels along a direction.
fn sun(direction: [f32; 3]) -> Light {
    Light {
        name: "sun".into(),
        kind: LightKind::Directional {
            direction: Vec3::from(direction).normalized().to_array(),
            irradiance: [3.4, 3.0, 2.4],
        },
    }
}

/// A camera with a level horizon; the vertical field of view is in degrees.
fn camera(name: &str, eye: [f32; 3], target: [f32; 3], vfov: f32) -> Camera {
    let forward = (Vec3::from(target) - Vec3::from(eye)).normalized();
    let right = forward.cross(Vec3::new(0.0, 1.0, 0.0)).normalized();
    Camera {
        name: name.into(),
        eye,
        forward: forward.to_array(),
        up: right.cross(forward).to_array(),
        projection: Projection::Perspective {
            vfov: vfov.to_radians(),
        },
    }
}
