//! Images: found once each, kept encoded.
//!
//! *How it works.* Textures that show the same image share it, and images with the same file or the same bytes share
//! those. An image that is absent or broken is a warning: the surface is shown without it.

use super::file::File;
use super::schema::{Image as Said, Index};
use super::uri::{self, Target};
use crate::{Image, SceneError};
use std::collections::HashMap;
use std::sync::Arc;

/// The images that materials have asked for so far.
#[derive(Default)]
pub struct Images {
    /// For the scene.
    pub found: Vec<Image>,
    /// What each image of the file became; `None` when it cannot be shown.
    known: HashMap<u32, Option<u32>>,
    bytes: HashMap<Origin, Arc<[u8]>>,
}

#[derive(PartialEq, Eq, Hash)]
enum Origin {
    View(u32),
    File(String),
}

impl Images {
    /// The number of an image in the scene, or `None`, with a warning, when it cannot be shown.
    pub fn find(
        &mut self,
        file: &File<'_>,
        index: Index,
        path: impl FnOnce() -> String,
    ) -> Result<Option<u32>, SceneError> {
        if let Some(&known) = self.known.get(&index.0) {
            return Ok(known);
        }
        let said = file.at(&file.root.images, index, "image", path)?;
        let image = self.load(file, said, index.0)?.map(|image| {
            self.found.push(image);
            self.found.len() as u32 - 1
        });
        self.known.insert(index.0, image);
        Ok(image)
    }

    fn load(
        &mut self,
        file: &File<'_>,
        said: &Said,
        number: u32,
    ) -> Result<Option<Image>, SceneError> {
        let path = |key: &str| format!("images[{number}].{key}");
        let mut name = match &*said.name {
            "" => format!("images[{number}]"),
            name => name.to_owned(),
        };
        let without = |key: &str, problem: String| {
            file.warn(
                path(key),
                format!("{problem}; the surface is shown without it"),
            );
            Ok(None)
        };
        let (key, bytes) = match (&said.uri, said.buffer_view) {
            (Some(uri), _) => match uri::resolve(uri) {
                Err(problem) => return without("uri", problem),
                Ok(Target::Data(bytes)) => ("uri", bytes.into()),
                Ok(Target::File(path)) => {
                    let bytes =
                        self.bytes_of(Origin::File(path.clone()), || file.read_beside(&path));
                    name = path;
                    match bytes {
                        Ok(bytes) => ("uri", bytes),
                        Err(e) => return without("uri", format!("{name} cannot be read: {e}")),
                    }
                }
            },
            (None, Some(view)) => {
                let (_, bytes) = file.view(view, || path("bufferView"))?;
                let bytes = self.bytes_of(Origin::View(view.0), || {
                    file.spend(bytes.len() as u64, || path("bufferView"))?;
                    Ok::<_, SceneError>(bytes.to_vec())
                })?;
                ("bufferView", bytes)
            }
            (None, None) => {
                return without(
                    "uri",
                    "the image has neither a uri nor a buffer view".to_owned(),
                );
            }
        };
        match Image::from_bytes(name, bytes) {
            Ok(image) => Ok(Some(image)),
            Err(SceneError::Malformed { file, problem, .. }) => without(
                key,
                format!("{file} is not an image that can be read ({problem})"),
            ),
            Err(other) => without(key, other.to_string()),
        }
    }

    fn bytes_of<E>(
        &mut self,
        origin: Origin,
        read: impl FnOnce() -> Result<Vec<u8>, E>,
    ) -> Result<Arc<[u8]>, E> {
        if let Some(bytes) = self.bytes.get(&origin) {
            return Ok(bytes.clone());
        }
        let bytes: Arc<[u8]> = read()?.into();
        self.bytes.insert(origin, bytes.clone());
        Ok(bytes)
    }
}
