//! Reads the statements of an OBJ file in one pass.
//!
//! *How it works.* `v`, `vt`, `vn` append to lists. A face is resolved at once (its indices may only name what stands
//! above it), made of vertices of the mesh at hand, and triangulated. Points, lines and statements that do not concern
//! triangles are passed over.

use super::Line;
use super::cursor::{Cursor, quoted};
use super::mesh_builder::{Corner, MeshBuilder, NONE};
use super::vertices::Vertices;
use super::warnings::Warnings;
use crate::error::Place;
use crate::triangulate::Triangulator;
use crate::{Mesh, SceneError};
use std::collections::HashMap;

/// What the file said, its materials still names.
pub(super) struct Document {
    /// `material` is an index of `usages`.
    pub(super) meshes: Vec<Mesh>,
    /// Every name that faces use as material, in order of first use.
    pub(super) usages: Vec<Usage>,
    /// The words behind each `mtllib`.
    pub(super) libraries: Vec<(Line, String)>,
    pub(super) warnings: Warnings,
}

/// A material's name and where it is asked for first.
pub(super) struct Usage {
    pub(super) name: String,
    pub(super) line: Line,
}

/// Reads a text.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<Document, SceneError> {
    let mut reader = Reader {
        cursor: Cursor::new(bytes),
        file,
        vertices: Vertices::default(),
        face: Face::default(),
        builder: MeshBuilder::default(),
        state: State::default(),
        open: State::default(),
        open_usage: 0,
        state_changed: false,
        material_line: Line(1),
        flat: false,
        all_flat: true,
        usage_of: HashMap::new(),
        unknown: None,
        knows_any: false,
        document: Document {
            meshes: Vec::new(),
            usages: Vec::new(),
            libraries: Vec::new(),
            warnings: Warnings::new(file),
        },
    };
    while !reader.cursor.is_done() {
        if reader.cursor.skip_blanks() {
            reader.statement()?;
        }
        reader.cursor.next_line();
    }
    reader.finish()
}

/// What a face belongs to; faces in a row with equal states share a mesh.
#[derive(Clone, Default, PartialEq)]
struct State {
    object: String,
    group: String,
    material: String,
}

/// The face at hand, kept for its memory.
#[derive(Default)]
struct Face {
    corners: Vec<Corner>,
    vertices: Vec<u32>,
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    triangulator: Triangulator,
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    file: &'a str,
    vertices: Vertices,
    face: Face,
    builder: MeshBuilder,
    /// What the next face belongs to, and what the faces in `builder` belong to.
    state: State,
    open: State,
    open_usage: u32,
    state_changed: bool,
    /// Where `state.material` was named.
    material_line: Line,
    /// Whether `s off` holds, and whether it held for every face in `builder`.
    flat: bool,
    all_flat: bool,
    /// Index in `document.usages` by name.
    usage_of: HashMap<String, u32>,
    /// The first statement that OBJ does not have, and whether there was any that it has.
    unknown: Option<(Line, String)>,
    knows_any: bool,
    document: Document,
}

impl Reader<'_> {
    #[inline]
    fn statement(&mut self) -> Result<(), SceneError> {
        let word = self.cursor.word();
        match word {
            b"v" => self
                .vertices
                .position(&mut self.cursor, &mut self.document.warnings),
            b"vt" => self
                .vertices
                .uv(&mut self.cursor, &mut self.document.warnings),
            b"vn" => self
                .vertices
                .normal(&mut self.cursor, &mut self.document.warnings),
            b"f" | b"fo" => return self.read_face(),
            _ => {
                self.rare_statement(word);
                return Ok(());
            }
        }
        .map_err(|problem| self.malformed(problem))
    }

    #[cold]
    fn rare_statement(&mut self, word: &[u8]) {
        let line = Line(self.cursor.line());
        let known = match word {
            b"o" => {
                self.state.object = self.cursor.name();
                self.state_changed = true;
                true
            }
            b"g" => {
                self.state.group = self.cursor.name();
                self.state_changed = true;
                true
            }
            b"usemtl" => {
                self.state.material = self.cursor.name();
                self.material_line = line;
                self.state_changed = true;
                true
            }
            b"s" => {
                self.flat = matches!(self.cursor.word(), b"off" | b"0");
                true
            }
            b"mtllib" => {
                let names = self.cursor.rest();
                self.document.libraries.push((line, names));
                true
            }
            b"curv" | b"curv2" | b"surf" | b"call" | b"csh" => {
                self.document.warnings.of_kind("free form", line, || {
                    format!("{} statements are not supported; passed over", quoted(word))
                });
                true
            }
            _ => is_harmless(word),
        };
        self.knows_any |= known;
        if !known && self.unknown.is_none() {
            self.unknown = Some((line, quoted(word)));
        }
    }

    #[inline]
    fn read_face(&mut self) -> Result<(), SceneError> {
        self.face.corners.clear();
        while self.cursor.skip_blanks() {
            let corner = self.corner()?;
            self.face.corners.push(corner);
        }
        let count = self.face.corners.len();
        if count < 3 {
            let line = Line(self.cursor.line());
            self.document.warnings.of_kind("corners", line, || {
                let s = if count == 1 { "" } else { "s" };
                format!("a face with {count} corner{s}, but 3 or more were expected; passed over")
            });
            return Ok(());
        }
        if self.state_changed {
            self.state_changed = false;
            if self.state != self.open {
                self.close_mesh();
                self.open = self.state.clone();
            }
        }
        if self.builder.is_empty() {
            self.open_usage = self.usage();
        }
        self.all_flat &= self.flat;

        let face = &mut self.face;
        face.vertices.clear();
        for &corner in &face.corners {
            let vertex = self.builder.vertex(corner, &self.vertices);
            face.vertices.push(vertex);
        }
        if let [a, b, c] = face.vertices[..] {
            self.builder.push_triangle([a, b, c]);
            return Ok(());
        }
        let positions = &self.vertices.positions;
        face.points.clear();
        face.points
            .extend((face.corners.iter()).map(|c| positions[c.position as usize]));
        face.triangles.clear();
        face.triangulator
            .triangulate(&face.points, &mut face.triangles);
        for triangle in &face.triangles {
            self.builder
                .push_triangle(triangle.map(|corner| face.vertices[corner as usize]));
        }
        Ok(())
    }

    /// One corner of a face: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[inline]
    fn corner(&mut self) -> Result<Corner, SceneError> {
        let mut corner = Corner {
            position: NONE,
            uv: NONE,
            normal: NONE,
        };
        let Some(index) = self.cursor.integer() else {
            return Err(self.bad_corner());
        };
        let count = self.vertices.positions.len();
        match resolve(index, count) {
            Some(position) => corner.position = position,
            None => return Err(self.malformed(bad_index("vertex", index, count))),
        }
        if self.cursor.take(b'/') {
            if let Some(index) = self.cursor.integer() {
                corner.uv = self.attribute("texture coordinate", index, self.vertices.uvs.len());
            }
            if self.cursor.take(b'/')
                && let Some(index) = self.cursor.integer()
            {
                corner.normal = self.attribute("normal", index, self.vertices.normals.len());
            }
        }
        if !self.cursor.word_ends() {
            return Err(self.bad_corner());
        }
        Ok(corner)
    }

    /// The index of a texture coordinate or a normal; without it the face is still a face.
    #[inline]
    fn attribute(&mut self, what: &'static str, index: i64, count: usize) -> u32 {
        resolve(index, count).unwrap_or_else(|| {
            let line = Line(self.cursor.line());
            (self.document.warnings).of_kind(what, line, || {
                format!("{}; the corner goes without", bad_index(what, index, count))
            });
            NONE
        })
    }

    #[cold]
    fn bad_corner(&mut self) -> SceneError {
        let rest = quoted(self.cursor.word());
        self.malformed(format!(
            "a face corner has {rest}, but v, v/vt, v//vn or v/vt/vn with whole numbers was expected"
        ))
    }

    #[cold]
    fn malformed(&self, problem: String) -> SceneError {
        SceneError::Malformed {
            file: self.file.to_owned(),
            place: Place::Line(self.cursor.line()),
            problem,
        }
    }

    /// The number of the material's name in `document.usages`.
    fn usage(&mut self) -> u32 {
        let name = &self.state.material;
        if let Some(&usage) = self.usage_of.get(name) {
            return usage;
        }
        let usage = self.document.usages.len() as u32;
        self.usage_of.insert(name.clone(), usage);
        self.document.usages.push(Usage {
            name: name.clone(),
            line: self.material_line,
        });
        usage
    }

    /// Ends the mesh at hand, if it has faces.
    fn close_mesh(&mut self) {
        if self.builder.is_empty() {
            return;
        }
        let State { object, group, .. } = &self.open;
        let name = if object.is_empty() { group } else { object };
        self.document.meshes.push(Mesh {
            name: name.clone(),
            material: self.open_usage,
            smooth: !self.all_flat,
            ..self.builder.finish()
        });
        self.all_flat = true;
    }

    fn finish(mut self) -> Result<Document, SceneError> {
        self.close_mesh();
        if let Some((line, word)) = self.unknown {
            let is_obj = self.knows_any || !self.vertices.is_empty();
            if !is_obj {
                return Err(SceneError::Malformed {
                    file: self.file.to_owned(),
                    place: Place::Line(line.0),
                    problem: format!(
                        "{word} is no OBJ statement, and there is none in the whole file"
                    ),
                });
            }
            (self.document.warnings).each(line, format!("{word} is no OBJ statement; passed over"));
        }
        Ok(self.document)
    }
}

/// A 1-based or negative index as a 0-based one.
#[inline]
fn resolve(index: i64, count: usize) -> Option<u32> {
    let index = if index < 0 {
        index + count as i64
    } else {
        index - 1
    };
    (0..count as i64).contains(&index).then_some(index as u32)
}

#[cold]
fn bad_index(what: &str, index: i64, count: usize) -> String {
    let expected = match count {
        0 => "there is none yet".to_owned(),
        _ if index < 0 => format!("-{count} to -1 were expected"),
        _ => format!("1 to {count} were expected"),
    };
    format!("a face names {what} {index}, but {expected}")
}

/// Statements of OBJ that say nothing about triangles.
fn is_harmless(word: &[u8]) -> bool {
    const HARMLESS: [&[u8]; 30] = [
        b"p",
        b"l",
        b"vp",
        b"deg",
        b"bmat",
        b"step",
        b"cstype",
        b"parm",
        b"trim",
        b"hole",
        b"scrv",
        b"sp",
        b"end",
        b"con",
        b"mg",
        b"bevel",
        b"c_interp",
        b"d_interp",
        b"lod",
        b"usemap",
        b"maplib",
        b"shadow_obj",
        b"trace_obj",
        b"ctech",
        b"stech",
        b"bsp",
        b"bzp",
        b"cdc",
        b"cdp",
        b"res",
    ];
    HARMLESS.contains(&word)
}
