//! Ascii STL: solids, facets, loops and vertices in words.
//!
//! Keywords may be in upper or lower case and any white space may stand between words; only the name after `solid`
//! and `endsolid` ends with its line.

use super::mesh_of;
use super::weld::{Weld, check_count};
use crate::load::file::File;
use crate::load::text::{Text, quote};
use crate::{Mesh, SceneError};

/// Reads the solids that have triangles.
pub fn read(file: File<'_>) -> Result<Vec<Mesh>, SceneError> {
    let mark = file.bytes.len() - without_mark(file.bytes).len();
    let mut reader = Reader {
        file,
        text: Text {
            bytes: file.bytes,
            at: mark,
        },
    };
    let mut meshes = Vec::new();
    loop {
        reader.text.skip_white();
        if reader.text.at_end() {
            return Ok(meshes);
        }
        reader.expect("solid")?;
        let mesh = reader.solid()?;
        if !mesh.triangles.is_empty() {
            meshes.push(mesh);
        }
    }
}

/// The text after a UTF-8 byte-order mark.
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

struct Reader<'a> {
    file: File<'a>,
    text: Text<'a>,
}

impl<'a> Reader<'a> {
    /// What follows `solid`.
    fn solid(&mut self) -> Result<Mesh, SceneError> {
        let start = self.text.at;
        let name = self.name();
        let mut weld = Weld::default();
        let mut triangles = Vec::new();
        loop {
            let (word, at) = self.word("`facet` or `endsolid`")?;
            if word.eq_ignore_ascii_case(b"facet") {
                let corners = self.facet()?;
                triangles.push(corners.map(|corner| weld.vertex(corner)));
            } else if word.eq_ignore_ascii_case(b"endsolid") {
                self.skip_end_name();
                break;
            } else {
                return Err(self.unexpected(word, at, "`facet` or `endsolid`"));
            }
        }
        check_count(&self.file, || self.file.line_of(start), triangles.len())?;
        Ok(mesh_of(name, weld.positions, triangles))
    }

    /// The rest of the line, unless the first facet is on it too; the file's name where it is blank.
    fn name(&mut self) -> String {
        self.text.skip_blanks();
        let start = self.text.at;
        while !self.text.at_line_end() {
            let at = self.text.at;
            let word = self.text.word();
            let is = |keyword: &[u8]| word.eq_ignore_ascii_case(keyword);
            if is(b"endsolid") || (is(b"facet") && self.normal_follows()) {
                self.text.at = at;
                break;
            }
            self.text.skip_blanks();
        }
        let name = self.file.bytes[start..self.text.at].trim_ascii();
        match name {
            [] => self.file.stem(),
            _ => String::from_utf8_lossy(name).into_owned(),
        }
    }

    /// Passes over the rest of the line, unless the next solid and its facets are on it too.
    fn skip_end_name(&mut self) {
        let mut next_solid = None;
        self.text.skip_blanks();
        while !self.text.at_line_end() {
            let at = self.text.at;
            let word = self.text.word();
            if word.eq_ignore_ascii_case(b"solid") {
                next_solid = next_solid.or(Some(at));
            } else if let Some(solid) = next_solid
                && word.eq_ignore_ascii_case(b"facet")
                && self.normal_follows()
            {
                self.text.at = solid;
                return;
            }
            self.text.skip_blanks();
        }
    }

    /// Whether the next word is `normal`.
    fn normal_follows(&self) -> bool {
        let mut ahead = self.text;
        ahead.skip_white();
        ahead.word().eq_ignore_ascii_case(b"normal")
    }

    /// What follows `facet`.
    fn facet(&mut self) -> Result<[[f32; 3]; 3], SceneError> {
        self.expect("normal")?;
        // The normal itself is not used, so it may be anything.
        for _ in 0..3 {
            self.word("a normal of three numbers")?;
        }
        self.expect("outer")?;
        self.expect("loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            self.expect("vertex")?;
            for coordinate in corner {
                *coordinate = self.coordinate()?;
            }
        }
        self.expect("endloop")?;
        self.expect("endfacet")?;
        Ok(corners)
    }

    #[inline]
    fn coordinate(&mut self) -> Result<f32, SceneError> {
        self.text.skip_white();
        let at = self.text.at;
        match self.text.float() {
            Some(value) if value.is_finite() => Ok(value),
            _ => {
                self.text.at = at;
                let expected = "a finite coordinate";
                let (word, at) = self.word(expected)?;
                Err(self.unexpected(word, at, expected))
            }
        }
    }

    /// The next word and where it is.
    #[inline]
    fn word(&mut self, expected: &str) -> Result<(&'a [u8], usize), SceneError> {
        self.text.skip_white();
        let at = self.text.at;
        match self.text.word() {
            [] => Err(self.file.error(
                self.file.last_line(),
                format!("the file ends within a solid; expected {expected}"),
            )),
            word => Ok((word, at)),
        }
    }

    #[inline]
    fn expect(&mut self, keyword: &str) -> Result<(), SceneError> {
        self.text.skip_white();
        let at = self.text.at;
        let word = self.text.word();
        if word.eq_ignore_ascii_case(keyword.as_bytes()) {
            return Ok(());
        }
        self.text.at = at;
        let expected = quote(keyword);
        let (word, at) = self.word(&expected)?;
        Err(self.unexpected(word, at, &expected))
    }

    #[cold]
    fn unexpected(&self, word: &[u8], at: usize, expected: &str) -> SceneError {
        // The last word of a file that was cut off is seldom whole.
        let cut = if self.text.at_end() {
            "the file ends within a solid; "
        } else {
            ""
        };
        self.file.error(
            self.file.line_of(at),
            format!("{cut}expected {expected}, found {}", quote(word)),
        )
    }
}
