//! What lies around a scene: a sky of its own, or an image. It is seen, it lights, and it is reflected.
//!
//! *How it works.* As light it is [`Harmonics`]: nine numbers a channel give the irradiance for any normal. As a background
//! and in mirrors it is looked up, the coarser the rougher the surface. An image's sun (few pixels with much of the light)
//! is taken out of the harmonics and becomes a light that casts shadows.

mod harmonics;
mod map;
mod sky;

use crate::camera::upright_frame;
use crate::shade::texture::Texture;
use boxwood::Vec3;
use harmonics::Harmonics;
use map::Map;
pub(crate) use map::Sun;
use sky::Sky;

/// The surroundings, ready for questions. Directions are unit vectors in world space.
pub(crate) struct Environment {
    kind: Kind,
    ambient: Harmonics,
    /// Right, up and front of the world.
    frame: [Vec3; 3],
    /// The part of an image that is a light of its own, in world space.
    pub sun: Option<Sun>,
}

enum Kind {
    Sky(Sky),
    Map(Map),
}

impl Environment {
    /// A clear sky over pale ground, `brightness` times as bright as a screen's white at the horizon.
    pub fn sky(up: Vec3, brightness: f32) -> Self {
        let sky = Sky { brightness };
        let ambient = Harmonics::project(64, 32, |d| sky.radiance(d.y, 0.0));
        Self {
            kind: Kind::Sky(sky),
            ambient,
            frame: upright_frame(up),
            sun: None,
        }
    }

    /// A latitude-longitude image, row 0 straight up, its centre column towards −z of a y-up world.
    pub fn image(up: Vec3, image: Texture, intensity: f32) -> Self {
        let (map, sun) = Map::new(image, intensity);
        let ambient = map.ambient();
        let mut environment = Self {
            kind: Kind::Map(map),
            ambient,
            frame: upright_frame(up),
            sun: None,
        };
        environment.sun = sun.map(|sun| Sun {
            direction: environment.to_world(sun.direction),
            ..sun
        });
        environment
    }

    /// What a ray sees that leaves the scene.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let local = self.to_local(direction);
        match &self.kind {
            Kind::Sky(sky) => sky.radiance(local.y, 0.0),
            Kind::Map(map) => map.radiance(local),
        }
    }

    /// What a surface of a perceptual roughness reflects on average from around a direction, a sun left out.
    pub fn blurred(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let local = self.to_local(direction);
        match &self.kind {
            Kind::Sky(sky) => sky.radiance(local.y, roughness),
            Kind::Map(map) => {
                let smooth = map.blurred(local, roughness);
                let rough = self.ambient.irradiance(local) * std::f32::consts::FRAC_1_PI;
                crate::colour::mix(smooth, rough, roughness * roughness)
            }
        }
    }

    /// The light that falls on a surface with a normal, nothing standing in the way, a sun left out.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.ambient.irradiance(self.to_local(normal))
    }

    fn to_local(&self, d: Vec3) -> Vec3 {
        let [x, y, z] = self.frame;
        Vec3::new(d.dot(x), d.dot(y), d.dot(z))
    }

    fn to_world(&self, d: Vec3) -> Vec3 {
        let [x, y, z] = self.frame;
        x * d.x + y * d.y + z * d.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_is_above_whatever_is_up() {
        for up in [Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)] {
            let sky = Environment::sky(up, 1.0);
            let (above, below) = (sky.radiance(up), sky.radiance(-up));
            assert!(above.z > above.x, "blue above: {above:?}");
            assert!(below.x > below.z, "earth below: {below:?}");
            assert!(sky.irradiance(up).y > 1.5 * sky.irradiance(-up).y);
            assert!(sky.irradiance(-up).y > 0.0);
        }
    }

    /// One bright row at the top, one bright column at −z, one at +x: they appear where the convention says.
    #[test]
    fn images_face_the_right_way() {
        let (width, height) = (64, 32);
        let mut pixels = vec![[0.1, 0.1, 0.1]; width * height];
        pixels[..width].fill([0.0, 9.0, 0.0]);
        let equator = 16 * width;
        for row in [equator - width, equator] {
            pixels[row + 31] = [5.0, 0.0, 0.0];
            pixels[row + 32] = [5.0, 0.0, 0.0];
            pixels[row + 47] = [0.0, 0.0, 5.0];
            pixels[row + 48] = [0.0, 0.0, 5.0];
        }
        let texture = Texture::from_floats([width as u32, height as u32], pixels);
        let around = Environment::image(Vec3::new(0.0, 1.0, 0.0), texture, 1.0);
        let up = around.radiance(Vec3::new(0.0, 1.0, 0.0));
        let ahead = around.radiance(Vec3::new(0.0, 0.0, -1.0));
        let right = around.radiance(Vec3::new(1.0, 0.0, 0.0));
        assert!(
            up.y > 8.0 && ahead.x > 4.0 && right.z > 4.0,
            "{up:?} {ahead:?} {right:?}"
        );
    }

    #[test]
    fn a_sun_in_an_image_becomes_a_light() {
        let mut pixels = vec![[0.5, 0.5, 0.5]; 128 * 64];
        for (row, column) in [(20, 96), (20, 97), (21, 96), (21, 97)] {
            pixels[row * 128 + column] = [4000.0, 4000.0, 3000.0];
        }
        let texture = Texture::from_floats([128, 64], pixels);
        let around = Environment::image(Vec3::new(0.0, 1.0, 0.0), texture, 1.0);
        let sun = around.sun.as_ref().expect("a sun");
        assert!(sun.direction.x > 0.7 && sun.direction.y > 0.3, "{sun:?}");
        assert!(sun.irradiance.x > 10.0 && sun.irradiance.z < sun.irradiance.x);
        // What is left is the even grey around: irradiance π / 2.
        let left = around.irradiance(Vec3::new(1.0, 0.0, 0.0));
        assert!(
            (left.x - 0.5 * std::f32::consts::PI).abs() < 0.2,
            "{left:?}"
        );
    }
}
