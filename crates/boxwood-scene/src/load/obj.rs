//! Wavefront OBJ.

use super::Source;
use crate::error::Place;
use crate::{Scene, SceneError};

/// Reads a scene.
pub fn read(_bytes: &[u8], source: Source<'_>) -> Result<Scene, SceneError> {
    Err(SceneError::Unsupported {
        file: source.name.to_owned(),
        place: Place::File,
        what: "Wavefront OBJ".to_owned(),
    })
}
