//! Rows as text: a line each, numbers between blanks.
//!
//! Nothing is copied: numbers are read where they stand, and lines are counted only for a message.

use super::Rows;
use super::faces::{FacePlan, Faces};
use super::header::{Element, Kind};
use super::vertices::{VertexPlan, Vertices, not_finite};
use crate::SceneError;
use crate::error::Place;
use crate::load::file::File;
use crate::load::text::{Text, quote};

/// The rows of an ascii file.
pub struct Ascii<'a> {
    file: File<'a>,
    text: Text<'a>,
    /// Where the first line with too many values has the first of them, and how many lines have.
    surplus: Option<(usize, usize)>,
}

/// What should stand where something else does.
#[derive(Clone, Copy)]
enum Wanted {
    /// The value of a scalar.
    Number,
    /// The count of a list.
    Count,
    /// An index in a list.
    Index,
    /// Anything in a list.
    Item,
}

impl<'a> Ascii<'a> {
    /// Begins at an offset.
    pub fn new(file: File<'a>, at: usize) -> Self {
        let bytes = file.bytes;
        Self {
            file,
            text: Text { bytes, at },
            surplus: None,
        }
    }

    fn here(&self) -> Place {
        self.file.line_of(self.text.at)
    }

    /// Goes to the start of a row.
    #[inline]
    fn begin(&mut self, element: &Element, row: usize) -> Result<(), SceneError> {
        self.text.skip_white();
        if self.text.at_end() {
            return Err(self.file.error(
                self.file.last_line(),
                format!(
                    "the file ends after {row} of the {} rows of {} that line {} promises",
                    element.count,
                    quote(&element.name),
                    element.line
                ),
            ));
        }
        Ok(())
    }

    /// Goes past the end of a row.
    #[inline]
    fn end(&mut self) {
        self.text.skip_blanks();
        if !self.text.at_line_end() {
            let (_, rows) = self.surplus.get_or_insert((self.text.at, 0));
            *rows += 1;
            self.text.skip_line();
        }
    }

    /// Complains about the value that should stand here.
    #[cold]
    fn bad_value(
        &self,
        element: &Element,
        row: usize,
        property: usize,
        wanted: Wanted,
    ) -> SceneError {
        let property = &element.properties[property];
        let mut text = self.text;
        let word = text.word();
        let (element, name) = (&element.name, quote(&property.name));
        let problem = if word.is_empty() {
            let where_it_ends = match wanted {
                Wanted::Number | Wanted::Count => "before",
                Wanted::Index | Wanted::Item => "within",
            };
            format!(
                "the line of {element} {row} ends {where_it_ends} {name}, which line {} of the header promises",
                property.line
            )
        } else {
            let expected = match wanted {
                Wanted::Number | Wanted::Item => "a number for",
                Wanted::Count => "a whole number, the count of",
                Wanted::Index => "a whole number, an index in",
            };
            format!(
                "expected {expected} {name} of {element} {row}, found {}",
                quote(word)
            )
        };
        self.file.error(self.here(), problem)
    }

    /// Passes a property over; its values need be no numbers, but they must be there.
    #[inline]
    fn pass(&mut self, element: &Element, row: usize, property: usize) -> Result<(), SceneError> {
        let values = match element.properties[property].kind {
            Kind::Scalar(_) => 1,
            Kind::List { .. } => self.count(element, row, property)?,
        };
        for _ in 0..values {
            self.text.skip_blanks();
            if self.text.word().is_empty() {
                return Err(self.bad_value(element, row, property, Wanted::Item));
            }
        }
        Ok(())
    }

    /// The number of values of a list.
    #[inline]
    fn count(&mut self, element: &Element, row: usize, property: usize) -> Result<i64, SceneError> {
        self.text.skip_blanks();
        let start = self.text.at;
        match self.text.integer() {
            Some(count @ 0..) => Ok(count),
            _ => {
                self.text.at = start;
                Err(self.bad_value(element, row, property, Wanted::Count))
            }
        }
    }
}

impl Rows for Ascii<'_> {
    fn at(&self) -> usize {
        self.text.at
    }

    fn seek(&mut self, at: usize) {
        self.text.at = at;
    }

    fn vertices(&mut self, element: &Element, plan: &VertexPlan) -> Result<Vertices, SceneError> {
        let mut vertices = Vertices::default();
        vertices.reserve(plan, element.count);
        let mut values = plan.empty_row();
        for row in 0..element.count {
            self.begin(element, row)?;
            let start = self.text.at;
            for (property, slot) in plan.slots.iter().enumerate() {
                let Some(slot) = slot else {
                    self.pass(element, row, property)?;
                    continue;
                };
                self.text.skip_blanks();
                match self.text.float() {
                    Some(value) => values[usize::from(*slot)] = value,
                    None => return Err(self.bad_value(element, row, property, Wanted::Number)),
                }
            }
            self.end();
            if !vertices.push(plan, &values) {
                let position = vertices.positions[row];
                return Err(self
                    .file
                    .error(self.file.line_of(start), not_finite(row, &position)));
            }
        }
        Ok(vertices)
    }

    fn faces(
        &mut self,
        element: &Element,
        plan: &FacePlan,
        positions: &[[f32; 3]],
        faces: &mut Faces,
    ) -> Result<(), SceneError> {
        let left = self.file.bytes.len() - self.text.at;
        // A triangle takes eight bytes or more.
        faces.triangles.reserve(element.count.min(left / 8 + 1));
        let mut indices = Vec::new();
        for row in 0..element.count {
            self.begin(element, row)?;
            let start = self.text.at;
            for property in 0..element.properties.len() {
                if property != plan.property {
                    self.pass(element, row, property)?;
                    continue;
                }
                indices.clear();
                for _ in 0..self.count(element, row, property)? {
                    self.text.skip_blanks();
                    let at = self.text.at;
                    let Some(value) = self.text.integer() else {
                        return Err(self.bad_value(element, row, property, Wanted::Index));
                    };
                    match plan.index(value) {
                        Some(index) => indices.push(index),
                        None => {
                            let problem = plan.no_such_vertex(element, row, value);
                            return Err(self.file.error(self.file.line_of(at), problem));
                        }
                    }
                }
            }
            self.end();
            faces.add(plan.shape, &indices, positions, || self.file.line_of(start));
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<(), SceneError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for row in 0..element.count {
            self.begin(element, row)?;
            self.text.skip_line();
        }
        Ok(())
    }

    fn finish(mut self, warnings: &mut Vec<String>) {
        if let Some((at, rows)) = self.surplus {
            let text = match rows {
                1 => "values that the header does not promise end the line and are ignored"
                    .to_owned(),
                _ => format!(
                    "the first of {rows} lines that end with values that the header does not promise; these are \
                     ignored"
                ),
            };
            warnings.push(self.file.warning(self.file.line_of(at), text));
        }
        self.text.skip_white();
        if !self.text.at_end() {
            let text =
                "the header promises nothing from here to the end of the file, which is ignored";
            warnings.push(self.file.warning(self.here(), text));
        }
    }
}
