//! What houses are dressed in: small pictures of one window that repeat.

use crate::image::Image;
use image::{ImageFormat, Rgb, RgbImage};
use std::io::Cursor;

/// Pixels along each side of a picture.
const SIDE: u32 = 32;

/// A wall with windows.
pub(super) struct Facade {
    pub name: &'static str,
    /// sRGB.
    wall: [u8; 3],
    glass: [u8; 3],
    /// The window's left, right, top and bottom within 32 by 32.
    window: [u32; 4],
    /// Width and height of one window with its wall, in metres.
    pub module: [f32; 2],
}

/// From cottage to tower.
pub(super) const FACADES: [Facade; 6] = [
    facade(
        "plaster, cream",
        [226, 212, 184],
        [70, 84, 98],
        [10, 22, 7, 24],
        [3.4, 3.1],
    ),
    facade(
        "brick",
        [150, 84, 62],
        [58, 68, 80],
        [9, 22, 7, 25],
        [3.1, 3.2],
    ),
    facade(
        "plaster, rose",
        [214, 168, 146],
        [66, 78, 92],
        [10, 21, 6, 24],
        [3.0, 3.1],
    ),
    facade(
        "stone",
        [188, 184, 174],
        [62, 76, 90],
        [8, 24, 6, 26],
        [3.6, 3.4],
    ),
    facade(
        "bands",
        [206, 208, 206],
        [52, 74, 92],
        [0, 32, 10, 26],
        [4.0, 3.6],
    ),
    facade(
        "glass",
        [92, 108, 116],
        [58, 92, 112],
        [2, 30, 2, 28],
        [2.8, 3.8],
    ),
];

const fn facade(
    name: &'static str,
    wall: [u8; 3],
    glass: [u8; 3],
    window: [u32; 4],
    module: [f32; 2],
) -> Facade {
    Facade {
        name,
        wall,
        glass,
        window,
        module,
    }
}

impl Facade {
    /// One window in its wall, as a PNG.
    pub fn picture(&self) -> Option<Image> {
        let [left, right, top, bottom] = self.window;
        let picture = RgbImage::from_fn(SIDE, SIDE, |x, y| {
            let inside = left <= x && x < right && top <= y && y < bottom;
            // A bar across the glass and a sill below it.
            let bar = inside && x == SIDE / 2 && right - left < SIDE;
            let sill = y == bottom && left <= x + 1 && x < right + 1;
            Rgb(match (inside && !bar, bar || sill) {
                (true, _) => self.glass.map(|c| c.saturating_sub((y - top) as u8)),
                (_, true) => self.wall.map(|c| c.saturating_add(24)),
                _ => self.wall.map(|c| c - (x * 7 + y * 13) as u8 % 5),
            })
        });
        let mut bytes = Vec::new();
        picture
            .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
            .ok()?;
        Image::from_bytes(format!("{}.png", self.name), bytes).ok()
    }
}
