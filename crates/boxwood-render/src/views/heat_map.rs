//! Heat maps that can be compared: one scale for several pictures of cost.
//!
//! *How it works.* A [`HeatScale`] is made from all the maps that shall be compared. It is linear where they are of a size,
//! and logarithmic where one is many times another, so that neither drowns. Colours are Inferno's; each map becomes a PNG
//! of 256 colours.

use super::colour_map::inferno_srgb;
use crate::RenderError;

/// Maps whose high ends differ more than this are shown on a logarithmic scale.
const FAR_APART: f64 = 3.0;

/// A common scale for maps of costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatScale {
    most: u32,
    logarithmic: bool,
}

impl HeatScale {
    /// The scale that fits all of the maps. It ends at the round number that all but one value in two hundred of the most
    /// expensive map stay below: one unlucky pixel does not darken the rest.
    pub fn of<'a>(maps: impl IntoIterator<Item = &'a [u32]>) -> Self {
        let highs: Vec<u32> = maps.into_iter().map(high).collect();
        let most = highs.iter().copied().max().unwrap_or(0).max(1);
        let least = highs.iter().copied().min().unwrap_or(0).max(1);
        Self {
            most: round_up(most),
            logarithmic: f64::from(most) > FAR_APART * f64::from(least),
        }
    }

    /// The value at the end of the scale.
    pub fn most(&self) -> u32 {
        self.most
    }

    /// Whether equal steps of colour are equal factors (of the value plus one) instead of equal differences.
    pub fn is_logarithmic(&self) -> bool {
        self.logarithmic
    }

    /// Where a value stands on the scale, 0 to 1.
    pub fn share(&self, cost: u32) -> f32 {
        let (cost, most) = (cost.min(self.most), self.most);
        if self.logarithmic {
            libm::log2f(1.0 + cost as f32) / libm::log2f(1.0 + most as f32)
        } else {
            cost as f32 / most as f32
        }
    }

    /// The sRGB colour of a place on the scale, 0 (nearly black) to 1 (pale yellow).
    pub fn colour(share: f32) -> [u8; 3] {
        inferno_srgb(share)
    }

    /// The map as a PNG in colours.
    ///
    /// # Errors
    /// When the sides do not fit the map, or are 0.
    pub fn png(&self, costs: &[u32], size: [u32; 2]) -> Result<Vec<u8>, RenderError> {
        let palette = (0..=255_u8).flat_map(|i| Self::colour(f32::from(i) / 255.0));
        let palette = Some(palette.collect());
        let bytes = costs.iter().map(|&cost| byte(self.share(cost)));
        encode(&bytes.collect::<Vec<_>>(), size, palette)
    }

    /// The map as a grey PNG whose every step is one and the same factor, `log2(1 + cost) / log2(1 + most)`, whatever the
    /// scale itself is: the difference of two such pictures is the ratio of their costs.
    ///
    /// # Errors
    /// When the sides do not fit the map, or are 0.
    pub fn grey_png(&self, costs: &[u32], size: [u32; 2]) -> Result<Vec<u8>, RenderError> {
        let scale = Self {
            logarithmic: true,
            ..*self
        };
        let bytes = costs.iter().map(|&cost| byte(scale.share(cost)));
        encode(&bytes.collect::<Vec<_>>(), size, None)
    }
}

fn byte(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn encode(
    bytes: &[u8],
    [width, height]: [u32; 2],
    palette: Option<Vec<u8>>,
) -> Result<Vec<u8>, RenderError> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    match palette {
        None => encoder.set_color(png::ColorType::Grayscale),
        Some(palette) => {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(palette);
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(out)
}

/// What all but one in two hundred stay below.
fn high(costs: &[u32]) -> u32 {
    let mut sorted = costs.to_vec();
    sorted.sort_unstable();
    let place = sorted.len().saturating_sub(1 + sorted.len() / 200);
    sorted.get(place).copied().unwrap_or(0)
}

/// The next of 1, 2, 4, 6, 8, 10, 20, 40 …: halves stay whole.
fn round_up(n: u32) -> u32 {
    let mut unit = 1_u32;
    while n > unit.saturating_mul(10) {
        unit = unit.saturating_mul(10);
    }
    [2, 4, 6, 8, 10]
        .into_iter()
        .map(|k| unit.saturating_mul(k))
        .find(|&m| m >= n)
        .unwrap_or(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round_and_ignore_the_odd_pixel() {
        assert_eq!(
            [1, 2, 3, 11, 19, 47, 99, 101].map(round_up),
            [2, 2, 4, 20, 20, 60, 100, 200]
        );
        assert!(round_up(u32::MAX) == u32::MAX);
        let mut costs = vec![37; 1000];
        costs[5] = 9000;
        assert_eq!(HeatScale::of([&costs[..]]).most(), 40);
        assert_eq!(HeatScale::of([]).most(), 2);
    }

    #[test]
    fn one_scale_serves_all() {
        let [low, middle, high] = [vec![20; 8], vec![37; 8], vec![9000; 8]];
        let near = HeatScale::of([&low[..], &middle]);
        assert_eq!((near.most(), near.is_logarithmic()), (40, false));
        assert_eq!(near.share(10), 0.25);
        let far = HeatScale::of([&low[..], &high]);
        assert_eq!((far.most(), far.is_logarithmic()), (10_000, true));
        assert_eq!([far.share(0), far.share(u32::MAX)], [0.0, 1.0]);
        assert!(far.share(100) > 0.49 && far.share(100) < 0.51);
    }

    #[test]
    fn maps_become_pictures_of_their_size() {
        let scale = HeatScale::of([&[1, 2, 3, 4, 5, 6][..]]);
        for png in [scale.png(&[0; 6], [3, 2]), scale.grey_png(&[0; 6], [3, 2])] {
            let png = png.expect("a picture");
            assert!(png.starts_with(b"\x89PNG"));
            assert_eq!((png[19], png[23]), (3, 2));
        }
        assert!(scale.png(&[0; 6], [4, 2]).is_err());
        assert!(scale.png(&[], [0, 0]).is_err());
    }
}
