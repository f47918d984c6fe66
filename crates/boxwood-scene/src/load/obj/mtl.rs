//! Material libraries: MTL files and the images they name.
//!
//! *How it works.* Each `newmtl` gathers [`Phong`] parameters line by line, which become a [`Material`] when the next
//! one begins. Nothing in a library is worth losing the scene: what is wrong becomes a warning with file and line.

use super::Line;
use super::cursor::{Cursor, quoted};
use super::map::MapStatement;
use super::phong::Phong;
use super::warnings::Warnings;
use crate::load::Source;
use crate::{Image, Material, SceneError, TextureMap};
use std::collections::{HashMap, HashSet};
use std::io;

/// Everything that the libraries of a scene hold.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<Material>,
    pub(super) images: Vec<Image>,
    pub(super) warnings: Vec<String>,
    /// Libraries asked for, whether they were found or not.
    seen: HashSet<String>,
    names: HashSet<String>,
    /// Index in `images` by path; `None` for those that cannot be used.
    image_of: HashMap<String, Option<u32>>,
}

/// A scene that names more libraries than this means harm.
const MOST_LIBRARIES: usize = 1000;

impl Library {
    /// Reads the libraries that a `mtllib` statement names; `false` when one of them is missing.
    pub(super) fn load(
        &mut self,
        names: &str,
        source: Source<'_>,
        line: Line,
        warnings: &mut Warnings,
    ) -> bool {
        let mut all_found = true;
        for name in split_names(names) {
            let path = to_path(name);
            if self.seen.len() == MOST_LIBRARIES || !self.seen.insert(path.clone()) {
                continue;
            }
            match source.files.read(&path) {
                Ok(bytes) => self.parse(&bytes, &path, source),
                Err(error) => {
                    all_found = false;
                    let name = quoted(path.as_bytes());
                    warnings.each(
                        line,
                        format!(
                            "material library {name} cannot be read ({error}); grey materials take its place"
                        ),
                    );
                }
            }
        }
        all_found
    }

    fn parse(&mut self, bytes: &[u8], path: &str, source: Source<'_>) {
        let mut warnings = Warnings::new(path);
        if matches!(bytes, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]) || bytes.contains(&0) {
            warnings.each(
                Line(1),
                "the material library is not text in UTF-8 or ASCII; passed over",
            );
            self.warnings.extend(warnings.finish());
            return;
        }
        let mut cursor = Cursor::new(bytes);
        let mut open: Option<Phong> = None;
        while !cursor.is_done() {
            if cursor.skip_blanks() {
                let line = Line(cursor.line());
                match cursor.word() {
                    b"newmtl" => {
                        self.push(open.take());
                        let name = cursor.name();
                        if !self.names.insert(name.clone()) {
                            warnings.of_kind("again", line, || {
                                let name = quoted(name.as_bytes());
                                format!("material {name} is defined again; the first one counts")
                            });
                        }
                        open = Some(Phong::new(name));
                    }
                    word => match &mut open {
                        Some(phong) => {
                            let map = |statement: &MapStatement, warnings: &mut Warnings| {
                                self.map(statement, path, source, line, warnings)
                            };
                            phong.statement(word, &mut cursor, line, &mut warnings, map);
                        }
                        None => warnings.of_kind("before newmtl", line, || {
                            format!("{} stands before any newmtl; passed over", quoted(word))
                        }),
                    },
                }
            }
            cursor.next_line();
        }
        self.push(open);
        self.warnings.extend(warnings.finish());
    }

    fn push(&mut self, phong: Option<Phong>) {
        self.materials.extend(phong.map(Phong::into_material));
    }

    /// The texture that a statement describes; `None`, after a warning, when its image cannot be used.
    fn map(
        &mut self,
        statement: &MapStatement,
        library: &str,
        source: Source<'_>,
        line: Line,
        warnings: &mut Warnings,
    ) -> Option<TextureMap> {
        let path = to_path(&statement.name);
        let folder = library.rfind('/').map_or("", |end| &library[..=end]);
        let path = format!("{folder}{path}");
        let image = match self.image_of.get(&path) {
            Some(&known) => known,
            None => {
                let image = match read_image(&path, source) {
                    Ok(image) => {
                        self.images.push(image);
                        Some(self.images.len() as u32 - 1)
                    }
                    Err(problem) => {
                        let name = quoted(path.as_bytes());
                        let problem = format!("image {name} {problem}; the material goes without");
                        warnings.each(line, problem);
                        None
                    }
                };
                self.image_of.insert(path, image);
                image
            }
        };
        Some(statement.texture(image?))
    }
}

/// Reads an image where the library says, or, when it names a folder of somebody else's computer, beside the scene.
fn read_image(path: &str, source: Source<'_>) -> Result<Image, String> {
    let beside = path.rsplit('/').next().unwrap_or(path);
    let bytes = match source.files.read(path) {
        Err(error) if beside != path && error.kind() == io::ErrorKind::NotFound => {
            (source.files.read(beside)).map_err(|_| error)
        }
        result => result,
    };
    let bytes = bytes.map_err(|error| format!("cannot be read ({error})"))?;
    Image::from_bytes(path, bytes).map_err(|error| match error {
        SceneError::Malformed { problem, .. } => format!("cannot be used ({problem})"),
        error => format!("cannot be used ({error})"),
    })
}

/// The names in a `mtllib` statement. They may hold blanks: a name goes on until a word ends in `.mtl`.
fn split_names(names: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut start = 0;
    let mut at = 0;
    for word in names.split_inclusive([' ', '\t']) {
        at += word.len();
        let word = word.trim_end();
        let is_end = (word.len().checked_sub(4))
            .and_then(|dot| word.get(dot..))
            .is_some_and(|end| end.eq_ignore_ascii_case(".mtl"));
        if is_end {
            found.push(names[start..at].trim());
            start = at;
        }
    }
    let last = names[start..].trim();
    if !last.is_empty() {
        found.push(last);
    }
    found
}

/// A name as a path with `/` between its parts, without quotes around it or `./` before it.
fn to_path(name: &str) -> String {
    let name = name.trim_matches('"').replace('\\', "/");
    let mut path = name.as_str();
    while let Some(rest) = path.strip_prefix("./") {
        path = rest;
    }
    path.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn library_names_may_hold_blanks() {
        assert_eq!(split_names("a.mtl b.MTL"), ["a.mtl", "b.MTL"]);
        assert_eq!(
            split_names("my house.mtl\tb.mtl"),
            ["my house.mtl", "b.mtl"]
        );
        assert_eq!(split_names("no extension"), ["no extension"]);
        assert!(split_names("").is_empty());
    }

    #[test]
    fn back_slashes_become_slashes() {
        assert_eq!(to_path(".\\wood.jpg"), "wood.jpg");
        assert_eq!(to_path("\"C:\\a b\\c.png\""), "C:/a b/c.png");
    }
}
