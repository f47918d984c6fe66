//! What can go wrong on the way to a picture, in one clear sentence each.

use boxwood::{InstanceError, MeshError};
use boxwood_scene::SceneError;

/// Why something could not be rendered or encoded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The scene's triangles cannot be laid out in the world.
    #[error("the scene cannot be laid out: {0}")]
    Mesh(#[from] MeshError),
    /// The scene's placements cannot be kept as instances.
    #[error("the scene cannot be laid out: {0}")]
    Instances(#[from] InstanceError),
    /// The environment image cannot be decoded.
    #[error("the environment cannot be read: {0}")]
    Environment(#[source] SceneError),
    /// The eye and the point it looks at are one, or not numbers.
    #[error(
        "the camera at {eye:?} looks at {at:?}, which gives no direction; the two points must differ and be finite"
    )]
    NoDirection {
        /// Where the camera stands.
        eye: [f32; 3],
        /// Where it should look.
        at: [f32; 3],
    },
    /// The field of view is not an angle that a flat image can show.
    #[error(
        "a vertical field of view of {degrees} degrees cannot be shown; it must lie between 0 and 180"
    )]
    FieldOfView {
        /// What was asked for.
        degrees: f32,
    },
    /// The image has no pixels, or more than memory should be asked for.
    #[error(
        "an image of {width} × {height} pixels cannot be made; each side must be 1 to 32768 and the area at most 2^28"
    )]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The PNG encoder failed.
    #[error("the PNG cannot be encoded: {0}")]
    Png(#[from] png::EncodingError),
    /// The EXR encoder failed.
    #[error("the EXR cannot be encoded: {0}")]
    Exr(#[from] exr::error::Error),
}
