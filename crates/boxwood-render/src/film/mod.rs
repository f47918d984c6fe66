//! The film: linear light, and what each pixel shows beside it.

mod exr;
mod png;

use crate::View;
use crate::colour::{of_number, roll_off};
use crate::views::legend;
use boxwood::Vec3;

pub use self::png::PngOptions;

/// A rendered image: rows from the top, floats without any tone curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    pub(crate) size: [u32; 2],
    pub(crate) view: View,
    pub(crate) brightened: f32,
    pub(crate) pixels: Vec<Pixel>,
}

/// What a pixel holds. Light, albedo and normal are means over its samples; the rest belongs to the ray through its
/// middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Linear radiance, surroundings included; black when another view than [`View::Shaded`] was rendered.
    pub radiance: [f32; 3],
    /// The part of `radiance` that comes straight from the surroundings.
    pub background: [f32; 3],
    /// The share of the pixel that is not surroundings.
    pub coverage: f32,
    /// The share that shows unlit materials, which no tone curve may change.
    pub unlit: f32,
    /// Linear base colour; black where there is nothing.
    pub albedo: [f32; 3],
    /// Shading normal in world space on the side of the camera, shorter than 1 where several meet; zero where there is
    /// nothing.
    pub normal: [f32; 3],
    /// Distance along the view in world units; infinite where there is nothing.
    pub depth: f32,
    /// Number of the triangle among all unique triangles, in file order; `u32::MAX` where there is nothing.
    pub primitive: u32,
    /// Index of the material; `u32::MAX` where there is nothing.
    pub material: u32,
    /// Nodes and leaves that the ray opened.
    pub nodes: u32,
    /// Primitives that it tested.
    pub primitives: u32,
}

impl Film {
    /// How many times brighter the picture is than the sky and key light of a scene without lights would leave it: 1 to 4,
    /// chosen so that the mean surface is not too dim; 1 for a scene with lights. Already in every pixel.
    pub fn brightened(&self) -> f32 {
        self.brightened
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The view that was asked for.
    pub fn view(&self) -> View {
        self.view
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// A view as linear colours. Light is exposed by `gain` and rolled off; all else is shown as it is.
    fn picture(&self, view: View, gain: f32, transparent: bool) -> Vec<Vec3> {
        let each = |f: &dyn Fn(&Pixel) -> Vec3| self.pixels.iter().map(f).collect();
        match view {
            View::Shaded => each(&|p| {
                let light = Vec3::from(p.radiance);
                let light = if transparent {
                    uncovered(light - Vec3::from(p.background), p.coverage)
                } else {
                    light
                };
                let light = light * gain;
                roll_off(light) * (1.0 - p.unlit) + light * p.unlit
            }),
            View::Normals => each(&|p| {
                let half = Vec3::splat(0.5);
                let shown = Vec3::from(p.normal) * 0.5 + half * p.coverage.min(1.0);
                Vec3::from(shown.to_array().map(as_stored))
            }),
            View::Depth => self.depths(),
            View::Primitives => each(&|p| numbered(p.primitive)),
            View::Materials => each(&|p| numbered(p.material)),
            View::Albedo => each(&|p| p.albedo.into()),
            View::Cost => {
                let costs: Vec<u32> = self
                    .pixels
                    .iter()
                    .map(|p| p.nodes.saturating_add(p.primitives))
                    .collect();
                legend::picture(&costs, self.size.map(|n| n as usize))
            }
        }
    }

    /// White at the nearest depth of the image, dark grey at the farthest, black where there is nothing.
    fn depths(&self) -> Vec<Vec3> {
        let found = self
            .pixels
            .iter()
            .map(|p| p.depth)
            .filter(|d| d.is_finite());
        let (near, far) = found.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), d| {
            (a.min(d), b.max(d))
        });
        let range = if far > near { far - near } else { 1.0 };
        self.pixels
            .iter()
            .map(|p| {
                if p.depth.is_finite() {
                    Vec3::splat(as_stored(1.0 - 0.85 * ((p.depth - near) / range)))
                } else {
                    Vec3::ZERO
                }
            })
            .collect()
    }
}

/// The colour of what covers a part of a pixel.
fn uncovered(light: Vec3, coverage: f32) -> Vec3 {
    if coverage > 1.0 / 1024.0 {
        (light / coverage).max(Vec3::ZERO)
    } else {
        Vec3::ZERO
    }
}

fn numbered(n: u32) -> Vec3 {
    if n == u32::MAX {
        Vec3::ZERO
    } else {
        of_number(n)
    }
}

/// The linear value whose sRGB byte is a share of 255: data views are read by their bytes.
fn as_stored(share: f32) -> f32 {
    let byte = (share.clamp(0.0, 1.0) * 255.0 + 0.5) as usize;
    crate::colour::SRGB[byte]
}
