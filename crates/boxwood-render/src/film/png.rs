//! PNG: eight bits of sRGB.

use super::Film;
use crate::colour::to_srgb_bytes;
use crate::{RenderError, View};
use boxwood::Vec3;

/// How a film becomes a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PngOptions {
    /// What to show. A film that was rendered for another view than [`View::Shaded`] holds no light.
    pub view: View,
    /// Stops by which light is made brighter before the tone curve.
    pub exposure: f32,
    /// Leave the surroundings out: alpha is the share of the pixel that something covers.
    pub transparent: bool,
}

impl Film {
    /// The film as a PNG. Light is multiplied by 2 to the exposure; what is too bright is bent back softly above 0.8
    /// instead of being cut off; unlit surfaces and all other views keep their colours. The same film and options give the
    /// same bytes.
    ///
    /// # Errors
    /// When the encoder fails.
    pub fn png(&self, options: &PngOptions) -> Result<Vec<u8>, RenderError> {
        let gain = if options.exposure == 0.0 {
            1.0
        } else {
            libm::exp2f(options.exposure)
        };
        let colours = self.picture(options.view, gain, options.transparent);
        // The strip of the legend covers what it covers.
        let see_through = options.transparent && options.view != View::Cost;
        let bytes: Vec<u8> = if see_through {
            let covered = self
                .pixels
                .iter()
                .map(|p| (p.coverage.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
            let rgba = |(c, alpha): (&Vec3, u8)| {
                let [r, g, b] = to_srgb_bytes(*c);
                [r, g, b, alpha]
            };
            colours.iter().zip(covered).flat_map(rgba).collect()
        } else {
            colours.iter().flat_map(|&c| to_srgb_bytes(c)).collect()
        };
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.size[0], self.size[1]);
        encoder.set_color(if see_through {
            png::ColorType::Rgba
        } else {
            png::ColorType::Rgb
        });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(out)
    }
}
