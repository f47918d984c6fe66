//! OpenEXR: everything the film holds, as it is.

use super::{Film, Pixel};
use crate::{RenderError, View};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
    WritableImage,
};
use std::io::Cursor;

impl Film {
    /// The film as an OpenEXR file, losslessly compressed. The same film gives the same bytes.
    ///
    /// | channel | type | what |
    /// |---|---|---|
    /// | `R G B` | float | linear radiance; the picture of the view when it is another than [`View::Shaded`] |
    /// | `A` | float | coverage |
    /// | `albedo.R/G/B`, `normal.X/Y/Z` | float | means over the pixel |
    /// | `depth.Z` | float | of the pixel's middle; infinite where there is nothing |
    /// | `primitive.id`, `material.id` | uint | of the pixel's middle; 4294967295 where there is nothing |
    /// | `cost.nodes`, `cost.primitives` | uint | of the ray through the pixel's middle |
    ///
    /// # Errors
    /// When the encoder fails.
    pub fn exr(&self) -> Result<Vec<u8>, RenderError> {
        let light: Vec<[f32; 3]> = match self.view {
            View::Shaded => self.pixels.iter().map(|p| p.radiance).collect(),
            other => self
                .picture(other, 1.0, false)
                .iter()
                .map(|c| c.to_array())
                .collect(),
        };
        let colour = |name: &str, i: usize| {
            channel(name, FlatSamples::F32(light.iter().map(|c| c[i]).collect()))
        };
        let float = |name: &str, f: &dyn Fn(&Pixel) -> f32| {
            channel(name, FlatSamples::F32(self.pixels.iter().map(f).collect()))
        };
        let whole = |name: &str, f: &dyn Fn(&Pixel) -> u32| {
            channel(name, FlatSamples::U32(self.pixels.iter().map(f).collect()))
        };
        let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::from_vec(vec![
            colour("R", 0),
            colour("G", 1),
            colour("B", 2),
            float("A", &|p| p.coverage),
            float("albedo.R", &|p| p.albedo[0]),
            float("albedo.G", &|p| p.albedo[1]),
            float("albedo.B", &|p| p.albedo[2]),
            float("normal.X", &|p| p.normal[0]),
            float("normal.Y", &|p| p.normal[1]),
            float("normal.Z", &|p| p.normal[2]),
            float("depth.Z", &|p| p.depth),
            whole("primitive.id", &|p| p.primitive),
            whole("material.id", &|p| p.material),
            whole("cost.nodes", &|p| p.nodes),
            whole("cost.primitives", &|p| p.primitives),
        ]);
        let size = self.size.map(|n| n as usize);
        let layer = Layer::new(
            (size[0], size[1]),
            LayerAttributes::default(),
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(channels),
        );
        let mut out = Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .non_parallel()
            .to_buffered(&mut out)?;
        Ok(out.into_inner())
    }
}

fn channel(name: &str, samples: FlatSamples) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, samples)
}
