//! A file in memory and the sentences about it.

use super::Source;
use crate::error::Place;
use crate::{Instance, Material, Mesh, Scene, SceneError};
use boxwood::Affine;
use std::fmt::Display;
use std::path::Path;

/// What a loader reads, and how messages call it.
#[derive(Clone, Copy)]
pub struct File<'a> {
    /// All of it.
    pub bytes: &'a [u8],
    /// Its name in errors and warnings.
    pub name: &'a str,
}

impl<'a> File<'a> {
    /// The bytes under the name that the source gives them.
    pub fn new(bytes: &'a [u8], source: Source<'a>) -> Self {
        let name = source.name;
        Self { bytes, name }
    }

    /// The file's name without folder and extension.
    pub fn stem(&self) -> String {
        let stem = Path::new(self.name).file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// An error about `place`.
    #[cold]
    pub fn error(&self, place: Place, problem: impl Display) -> SceneError {
        SceneError::Malformed {
            file: self.name.to_owned(),
            place,
            problem: problem.to_string(),
        }
    }

    /// A warning about `place`, in the form that errors have.
    pub fn warning(&self, place: Place, text: impl Display) -> String {
        format!("{}{place}: {text}", self.name)
    }

    /// The line of the byte at `offset`. Lines count from 1 and end with `\n`, `\r\n` or `\r`.
    pub fn line_of(&self, offset: usize) -> Place {
        let before = &self.bytes[..offset.min(self.bytes.len())];
        let feeds = before.iter().filter(|b| **b == b'\n').count();
        let lone_returns = (0..before.len())
            .filter(|i| before[*i] == b'\r' && self.bytes.get(i + 1) != Some(&b'\n'))
            .count();
        Place::Line(1 + feeds + lone_returns)
    }

    /// The last line that says something: where a text ends that ends too early.
    pub fn last_line(&self) -> Place {
        self.line_of(self.bytes.trim_ascii_end().len())
    }

    /// The byte at `offset`.
    pub fn byte(&self, offset: usize) -> Place {
        Place::Byte(offset as u64)
    }
}

/// A scene of these meshes, each standing once where its coordinates say, all with one plain material.
pub fn scene_of(meshes: Vec<Mesh>, warnings: Vec<String>) -> Scene {
    Scene {
        instances: (0..meshes.len() as u32)
            .map(|mesh| Instance {
                mesh,
                transform: Affine::IDENTITY,
            })
            .collect(),
        materials: meshes
            .first()
            .map(|_| Material::default())
            .into_iter()
            .collect(),
        meshes,
        warnings,
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways() {
        let file = File {
            bytes: b"a\nb\r\nc\rd\n\n",
            name: "folder/some.thing.ply",
        };
        let lines: Vec<_> = [0, 2, 5, 7].map(|at| file.line_of(at)).into();
        assert_eq!(lines, [1, 2, 3, 4].map(Place::Line));
        assert_eq!(file.last_line(), Place::Line(4));
        assert_eq!(file.stem(), "some.thing");
        assert_eq!(
            file.warning(file.byte(5), "what"),
            "folder/some.thing.ply, byte 5: what"
        );
    }
}
