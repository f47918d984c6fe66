//! Images that materials name: kept as encoded bytes until somebody wants their pixels.

use crate::SceneError;
use crate::error::Place;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// An image that a scene names. Its pixels stay encoded until [`Image::decode`].
#[derive(Clone, Debug)]
pub struct Image {
    /// The file's name for it: usually the path.
    pub name: String,
    /// Encoded bytes (PNG, JPEG, TGA, BMP, GIF, WebP, HDR, EXR).
    pub bytes: Arc<[u8]>,
    /// Width and height in pixels, from the header.
    pub size: [u32; 2],
}

/// Pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageData {
    /// As stored: sRGB for colour, linear for the rest; alpha last (255 where the image has none).
    Bytes {
        /// Width and height.
        size: [u32; 2],
        /// `width · height` pixels.
        pixels: Vec<[u8; 4]>,
        /// Whether the image has an alpha channel of its own.
        has_alpha: bool,
    },
    /// Linear radiance (HDR, EXR).
    Floats {
        /// Width and height.
        size: [u32; 2],
        /// `width · height` pixels.
        pixels: Vec<[f32; 3]>,
    },
}

/// No image side may be longer, and no decoder may take more memory (1 GiB): a few bytes can promise any size.
const MAX_SIDE: u32 = 1 << 15;
const MAX_BYTES: u64 = 1 << 30;

impl Image {
    /// Takes encoded bytes and reads their header. `name` helps to tell the format where the bytes do not (TGA).
    ///
    /// # Errors
    /// [`SceneError::Malformed`] when the header is of no known format.
    pub fn from_bytes(
        name: impl Into<String>,
        bytes: impl Into<Arc<[u8]>>,
    ) -> Result<Self, SceneError> {
        let mut image = Self {
            name: name.into(),
            bytes: bytes.into(),
            size: [0; 2],
        };
        let (width, height) = image
            .reader()?
            .into_dimensions()
            .map_err(|e| image.malformed(e))?;
        image.size = [width, height];
        Ok(image)
    }

    /// The pixels.
    ///
    /// # Errors
    /// [`SceneError::Malformed`] when the bytes end early or say nonsense.
    pub fn decode(&self) -> Result<ImageData, SceneError> {
        let decoded = self.reader()?.decode().map_err(|e| self.malformed(e))?;
        let size = [decoded.width(), decoded.height()];
        Ok(match decoded {
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => ImageData::Floats {
                size,
                pixels: decoded.into_rgb32f().pixels().map(|p| p.0).collect(),
            },
            bytes => ImageData::Bytes {
                size,
                has_alpha: bytes.color().has_alpha(),
                pixels: bytes.into_rgba8().pixels().map(|p| p.0).collect(),
            },
        })
    }

    fn reader(&self) -> Result<ImageReader<Cursor<&[u8]>>, SceneError> {
        let mut reader = ImageReader::new(Cursor::new(&*self.bytes))
            .with_guessed_format()
            .map_err(|e| self.malformed(e))?;
        if reader.format().is_none() {
            let format = ImageFormat::from_path(Path::new(&self.name))
                .map_err(|_| self.malformed("not a kind of image that can be read"))?;
            reader.set_format(format);
        }
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(MAX_BYTES);
        reader.limits(limits);
        Ok(reader)
    }

    fn malformed(&self, problem: impl ToString) -> SceneError {
        SceneError::Malformed {
            file: self.name.clone(),
            place: Place::File,
            problem: problem.to_string(),
        }
    }
}
