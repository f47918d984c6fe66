//! Cameras: made by hand or around a box, and the rays through their pixels.

use crate::RenderError;
use boxwood::{Aabb, Ray, Vec3};
use boxwood_scene::{Camera, Projection};

/// A camera at `eye` that looks at `at`, with `up` pointing up in the image (`image x = forward × up`).
///
/// Where `up` runs along the view (or is zero), the axis that is furthest from the view takes its place.
///
/// # Errors
/// When `eye` and `at` are one point or not finite, or the field of view is not between 0 and 180 degrees.
pub fn look_at(
    eye: [f32; 3],
    at: [f32; 3],
    up: [f32; 3],
    vfov_radians: f32,
) -> Result<Camera, RenderError> {
    if !(vfov_radians > 0.0 && vfov_radians < std::f32::consts::PI) {
        return Err(RenderError::FieldOfView {
            degrees: vfov_radians.to_degrees(),
        });
    }
    let forward = (Vec3::from(at) - Vec3::from(eye)).normalized();
    if !(Vec3::from(eye).is_finite() && forward.is_finite() && forward != Vec3::ZERO) {
        return Err(RenderError::NoDirection { eye, at });
    }
    let (_, up) = right_and_up(forward, up.into());
    Ok(Camera {
        name: String::new(),
        eye,
        forward: forward.to_array(),
        up: up.to_array(),
        projection: Projection::Perspective { vfov: vfov_radians },
    })
}

/// A three-quarter view from the front right and a little above that just shows all of a box, with a small margin.
///
/// The front is the side of +z where up is y, and the side of −y where up is z. An empty box is taken for the unit
/// cube around the origin; a flat or tiny one is shown from as near as floats can tell.
pub fn frame(bounds: &Aabb, up: [f32; 3], vfov_radians: f32, aspect: f32) -> Camera {
    let unit = Aabb::new([-0.5; 3], [0.5; 3]);
    let finite = bounds.lower.is_finite() && bounds.upper.is_finite();
    let bounds = if bounds.is_empty() || !finite {
        unit
    } else {
        *bounds
    };
    let vfov = if vfov_radians > 0.01 && vfov_radians < 3.0 {
        vfov_radians
    } else {
        0.7
    };
    let aspect = if aspect > 0.0 && aspect.is_finite() {
        aspect
    } else {
        1.0
    };

    let [right, up, front] = upright_frame(up.into());
    let forward = -(front * 0.83 + right * 0.42 + up * 0.36).normalized();
    let (image_x, image_y) = right_and_up(forward, up);
    let centre = bounds.centroid();
    let half = bounds.size() * 0.5;
    let tangent = libm::tanf(0.5 * vfov);
    let mut distance = 0.0_f32;
    for corner in 0..8 {
        let sign = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let p = half * Vec3::new(sign(0), sign(1), sign(2));
        let nearer = p.dot(forward);
        distance = distance
            .max(p.dot(image_x).abs() / (tangent * aspect) - nearer)
            .max(p.dot(image_y).abs() / tangent - nearer);
    }
    // A single point still wants a distance, and one that floats of this size can hold.
    let least = (centre.abs().max_element() * 1.0e-4).max(f32::MIN_POSITIVE);
    let distance = if distance > 0.0 { 1.06 * distance } else { 1.0 };
    Camera {
        name: String::new(),
        eye: (centre - forward * distance.max(least)).to_array(),
        forward: forward.to_array(),
        up: image_y.to_array(),
        projection: Projection::Perspective { vfov },
    }
}

/// The ray through the middle of a pixel, counted from the upper left corner of an image of `size` pixels; its direction has
/// unit length.
pub fn pixel_ray(camera: &Camera, size: [u32; 2], [x, y]: [u32; 2]) -> Ray {
    Lens::new(camera, size).ray(x as f32 + 0.5, y as f32 + 0.5)
}

/// Right, up and front of a world: x, y, z where up is y; x, z, −y where up is z.
pub(crate) fn upright_frame(up: Vec3) -> [Vec3; 3] {
    let up = if up.is_finite() && up != Vec3::ZERO {
        up.normalized()
    } else {
        Vec3::new(0.0, 1.0, 0.0)
    };
    let x = if up.x.abs() < 0.9 {
        Vec3::new(1.0, 0.0, 0.0)
    } else {
        Vec3::new(0.0, -up.x, 0.0)
    };
    let right = (x - up * x.dot(up)).normalized();
    [right, up, right.cross(up)]
}

/// The image's x and y for a view; any where `up` does not help.
fn right_and_up(forward: Vec3, up: Vec3) -> (Vec3, Vec3) {
    let mut right = forward.cross(up.normalized());
    // Below this the rounding of the inputs decides, not their meaning.
    if !(right.length() > 1.0e-5) {
        let size = forward.abs();
        let mut axis = Vec3::ZERO;
        axis[if size.y <= size.x && size.y <= size.z {
            1
        } else if size.z <= size.x {
            2
        } else {
            0
        }] = 1.0;
        right = forward.cross(axis);
    }
    let right = right.normalized();
    (right, right.cross(forward).normalized())
}

/// A camera made ready to send rays through an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    eye: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    parallel: bool,
    /// One pixel, in units of `right` and `up`: at distance 1 for a perspective, anywhere for a parallel projection.
    pixel: f32,
    middle: [f32; 2],
}

impl Lens {
    /// Prepares a camera for an image of `size` pixels; odd vectors are put right.
    pub fn new(camera: &Camera, [width, height]: [u32; 2]) -> Self {
        let forward = Vec3::from(camera.forward).normalized();
        let forward = if forward.is_finite() && forward != Vec3::ZERO {
            forward
        } else {
            Vec3::new(0.0, 0.0, -1.0)
        };
        let (right, up) = right_and_up(forward, camera.up.into());
        let (parallel, half_height) = match camera.projection {
            Projection::Perspective { vfov } => (false, libm::tanf(0.5 * vfov)),
            Projection::Orthographic { height } => (true, 0.5 * height),
        };
        Self {
            eye: camera.eye.into(),
            forward,
            right,
            up,
            parallel,
            pixel: 2.0 * half_height / height as f32,
            middle: [0.5 * width as f32, 0.5 * height as f32],
        }
    }

    /// The ray through a point of the image, in pixels from its upper left corner; its direction has unit length.
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        let dx = (x - self.middle[0]) * self.pixel;
        let dy = (self.middle[1] - y) * self.pixel;
        let aside = self.right * dx + self.up * dy;
        if self.parallel {
            Ray::new(self.eye + aside, self.forward)
        } else {
            Ray::new(self.eye, (self.forward + aside).normalized())
        }
    }

    /// How wide a pixel is at the eye, and how much wider it gets per unit of distance.
    pub fn footprint(&self) -> (f32, f32) {
        if self.parallel {
            (self.pixel, 0.0)
        } else {
            (0.0, self.pixel)
        }
    }

    /// How far a point lies from the eye along the view.
    pub fn depth(&self, p: Vec3) -> f32 {
        (p - self.eye).dot(self.forward)
    }

    /// Where the light comes from when nobody set one: over the left shoulder of who looks, and always from above.
    /// Within the scene it comes from steeply above, where roofs and walls let it in most often.
    pub fn over_the_shoulder(&self, world_up: Vec3, scene: &Aabb) -> Vec3 {
        let within = scene.contains(&Aabb::new(self.eye, self.eye));
        let rise = if within { 3.2 } else { 0.9 };
        let left_and_back = (-self.right) * 0.55 - self.forward * 0.65;
        // The part along the world's up is replaced, so that a camera that looks up does not move the sun below.
        let level = left_and_back - world_up * left_and_back.dot(world_up);
        (level + world_up * rise).normalized()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: [f32; 3] = [0.0, 1.0, 0.0];

    fn close(a: Vec3, b: [f32; 3]) {
        assert!((a - Vec3::from(b)).length() < 1.0e-6, "{a:?} {b:?}");
    }

    #[test]
    fn right_is_right_and_the_field_of_view_is_vertical() {
        let camera =
            look_at([0.0; 3], [0.0, 0.0, -2.0], UP, 90_f32.to_radians()).expect("a camera");
        let lens = Lens::new(&camera, [200, 100]);
        close(lens.ray(100.0, 50.0).direction, [0.0, 0.0, -1.0]);
        let half = 0.5_f32.sqrt();
        close(lens.ray(100.0, 0.0).direction, [0.0, half, -half]);
        close(lens.ray(150.0, 50.0).direction, [half, 0.0, -half]);
        assert_eq!(lens.depth(Vec3::new(5.0, 6.0, -3.0)), 3.0);
    }

    #[test]
    fn parallel_rays_are_parallel() {
        let camera = Camera {
            name: String::new(),
            eye: [0.0, 0.0, 5.0],
            forward: [0.0, 0.0, -1.0],
            up: UP,
            projection: Projection::Orthographic { height: 4.0 },
        };
        let ray = Lens::new(&camera, [8, 8]).ray(8.0, 0.0);
        close(ray.direction, [0.0, 0.0, -1.0]);
        close(ray.origin, [2.0, 2.0, 5.0]);
    }

    #[test]
    fn odd_wishes() {
        let same = look_at([1.0; 3], [1.0; 3], UP, 1.0).expect_err("no direction");
        assert!(
            same.to_string().contains("the two points must differ"),
            "{same}"
        );
        assert!(look_at([0.0; 3], [0.0, f32::NAN, 0.0], UP, 1.0).is_err());
        let wide = look_at([0.0; 3], [1.0; 3], UP, 3.5).expect_err("too wide");
        assert!(wide.to_string().contains("between 0 and 180"), "{wide}");
        let down = look_at([0.0, 5.0, 0.0], [0.0; 3], UP, 1.0).expect("straight down is legal");
        let (f, u) = (Vec3::from(down.forward), Vec3::from(down.up));
        assert!(f.dot(u).abs() < 1.0e-6 && (u.length() - 1.0).abs() < 1.0e-6);
    }

    #[test]
    fn frames_show_every_corner_and_fill_the_image() {
        let boxes = [
            Aabb::new([-1.0; 3], [1.0; 3]),
            Aabb::new([1000.0, -3.0, 5.0], [1004.0, -3.0, 9.0]),
            Aabb::new([0.0; 3], [1.0e-4, 2.0e-4, 3.0e-5]),
            Aabb::new([-4.0e5, 0.0, 0.0], [5.0e5, 1.0e4, 1.0]),
        ];
        for bounds in boxes {
            for up in [UP, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] {
                for aspect in [0.4_f32, 1.0, 2.5] {
                    let camera = frame(&bounds, up, 0.7, aspect);
                    let lens = Lens::new(&camera, [(aspect * 1000.0) as u32, 1000]);
                    let mut widest = 0.0_f32;
                    for corner in 0..8 {
                        let pick = |axis: usize| {
                            if corner >> axis & 1 == 0 {
                                bounds.lower[axis]
                            } else {
                                bounds.upper[axis]
                            }
                        };
                        let p = Vec3::new(pick(0), pick(1), pick(2)) - lens.eye;
                        let depth = p.dot(lens.forward);
                        assert!(depth > 0.0);
                        let x = p.dot(lens.right).abs() / (depth * lens.pixel * lens.middle[0]);
                        let y = p.dot(lens.up).abs() / (depth * lens.pixel * lens.middle[1]);
                        widest = widest.max(x).max(y);
                    }
                    assert!(
                        widest < 1.0 && widest > 0.8,
                        "{bounds:?} {up:?} {aspect}: {widest}"
                    );
                    assert!(Vec3::from(camera.up).dot(Vec3::from(up)) > 0.5);
                }
            }
        }
    }

    #[test]
    fn nothing_and_a_point_can_be_framed() {
        for bounds in [Aabb::EMPTY, Aabb::new([7.0; 3], [7.0; 3])] {
            let camera = frame(&bounds, UP, 0.7, 1.5);
            assert!(Vec3::from(camera.eye).is_finite());
            let target = if bounds.is_empty() {
                Vec3::ZERO
            } else {
                bounds.lower
            };
            let to = (target - Vec3::from(camera.eye)).normalized();
            assert!(to.dot(Vec3::from(camera.forward)) > 0.999);
        }
    }
}
