//! Files in: one module per format, the same tables out.

mod decimal;
mod file;
mod gltf;
mod obj;
mod ply;
mod stl;
mod text;

use crate::{Scene, SceneError};
use std::io;
use std::path::{Path, PathBuf};

/// The formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ with MTL.
    Obj,
    /// Stanford PLY.
    Ply,
    /// Stereolithography.
    Stl,
    /// glTF 2.0, as JSON or as GLB.
    Gltf,
}

impl Format {
    /// The format that a file name's extension speaks of, in upper or lower case; `None` when it is unknown.
    pub fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }
}

/// Where a scene comes from: its name for messages, and the files it may name in turn.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// How errors and warnings call it.
    pub name: &'a str,
    /// Gives the bytes of the files it names: material libraries, buffers, images.
    pub files: &'a dyn Files,
}

/// Gives the bytes of files that a scene names.
pub trait Files {
    /// The bytes of `name`, a path relative to the scene as the scene wrote it, with `/` between its parts.
    ///
    /// # Errors
    /// What the system says when there is no such file.
    fn read(&self, name: &str) -> io::Result<Vec<u8>>;
}

/// Files named relative to a folder. A scene may name them by `..` too, as real ones do.
#[derive(Clone, Debug)]
pub struct Folder(pub PathBuf);

impl Files for Folder {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let path = self.0.join(name);
        // A scene may name anything; a device or a pipe would be read for ever.
        if !std::fs::metadata(&path)?.is_file() {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "it is not a regular file",
            ));
        }
        std::fs::read(path)
    }
}

/// No files at all: for a scene that stands alone in memory.
#[derive(Clone, Copy, Debug)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!("{name} was asked for, but the scene came from memory"),
        ))
    }
}

impl Scene {
    /// Reads a scene file; its extension says which format.
    ///
    /// # Errors
    /// [`SceneError`], in one sentence with file and place. What can be passed over becomes a warning instead.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let format = Format::of_path(path).ok_or_else(|| SceneError::UnknownFormat {
            file: path.to_path_buf(),
        })?;
        let bytes = std::fs::read(path).map_err(|source| SceneError::Io {
            file: path.to_path_buf(),
            source,
        })?;
        let folder = Folder(path.parent().unwrap_or(Path::new("")).to_path_buf());
        let source = Source {
            name: &path.display().to_string(),
            files: &folder,
        };
        Self::from_bytes(format, &bytes, source)
    }

    /// Reads a scene from memory. Files that it names come from `source.files`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_bytes(
        format: Format,
        bytes: &[u8],
        source: Source<'_>,
    ) -> Result<Self, SceneError> {
        match format {
            Format::Obj => obj::read(bytes, source),
            Format::Ply => ply::read(bytes, source),
            Format::Stl => stl::read(bytes, source),
            Format::Gltf => gltf::read(bytes, source),
        }
    }
}
