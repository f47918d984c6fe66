//! Rows as packed numbers, in either byte order.
//!
//! *How it works.* Vertices without lists have rows of one length: each attribute is gathered in one pass, and three
//! floats side by side are copied as they are. Faces of nothing but a byte-counted list of 32-bit indices, which is
//! what nearly every file has, take a check and three loads per triangle. Everything else goes number by number.

use super::Rows;
use super::faces::{FacePlan, Faces};
use super::header::{Element, Kind};
use super::scalar::Scalar;
use super::vertices::{Gather, VertexPlan, Vertices, is_finite, not_finite};
use crate::SceneError;
use crate::load::file::File;
use crate::load::text::quote;

/// The rows of a binary file, most significant byte first if `BIG`.
pub struct Binary<'a, const BIG: bool> {
    file: File<'a>,
    at: usize,
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    /// Begins at an offset.
    pub fn new(file: File<'a>, at: usize) -> Self {
        Self { file, at }
    }

    fn rest(&self) -> &'a [u8] {
        &self.file.bytes[self.at..]
    }

    /// Complains that the file ends too early.
    #[cold]
    fn ends_within(&self, element: &Element, row: usize) -> SceneError {
        self.file.error(
            self.file.byte(self.file.bytes.len()),
            format!(
                "the file ends within row {row} of {}; the header promises {} rows",
                quote(&element.name),
                element.count
            ),
        )
    }

    /// Takes the next `length` bytes.
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let taken = self.rest().get(..length)?;
        self.at += length;
        Some(taken)
    }

    /// Takes the count of a list and its items.
    fn list(
        &mut self,
        element: &Element,
        row: usize,
        count: Scalar,
        item: Scalar,
    ) -> Result<&'a [u8], SceneError> {
        let start = self.at;
        let number = self
            .take(count.size())
            .and_then(|bytes| count.integer::<BIG>(bytes))
            .ok_or_else(|| self.ends_within(element, row))?;
        let Ok(number) = usize::try_from(number) else {
            return Err(self.file.error(
                self.file.byte(start),
                format!(
                    "a list of {} {row} has {number} values; expected a count of 0 or more",
                    element.name
                ),
            ));
        };
        self.take(number.saturating_mul(item.size()))
            .ok_or_else(|| self.ends_within(element, row))
    }

    /// Passes a property over.
    fn pass(&mut self, element: &Element, row: usize, kind: Kind) -> Result<(), SceneError> {
        match kind {
            Kind::Scalar(scalar) => {
                let taken = self.take(scalar.size());
                taken
                    .map(|_| ())
                    .ok_or_else(|| self.ends_within(element, row))
            }
            Kind::List { count, item } => self.list(element, row, count, item).map(|_| ()),
        }
    }

    /// Takes all rows at once where they have the same length.
    fn take_rows(&mut self, element: &Element, stride: usize) -> Result<&'a [u8], SceneError> {
        let rows = self.rest().len() / stride.max(1);
        self.take(element.count.saturating_mul(stride))
            .ok_or_else(|| self.ends_within(element, rows))
    }

    /// Vertices whose rows differ in length.
    fn uneven_vertices(
        &mut self,
        element: &Element,
        plan: &VertexPlan,
    ) -> Result<Vertices, SceneError> {
        let mut vertices = Vertices::default();
        vertices.reserve(plan, element.count);
        let mut values = plan.empty_row();
        for row in 0..element.count {
            let start = self.at;
            for (property, slot) in element.properties.iter().zip(&plan.slots) {
                match (property.kind, slot) {
                    (Kind::Scalar(scalar), Some(slot)) => {
                        let value = self
                            .take(scalar.size())
                            .and_then(|b| scalar.float::<BIG>(b));
                        values[usize::from(*slot)] =
                            value.ok_or_else(|| self.ends_within(element, row))?;
                    }
                    (kind, _) => self.pass(element, row, kind)?,
                }
            }
            if !vertices.push(plan, &values) {
                let problem = not_finite(row, &vertices.positions[row]);
                return Err(self.file.error(self.file.byte(start), problem));
            }
        }
        Ok(vertices)
    }

    /// As many faces as have nothing but three 32-bit indices counted by a byte; the rest is left.
    fn triangles(&mut self, count: usize, plan: &FacePlan, faces: &mut Faces) -> usize {
        let vertices = plan.vertices as u32;
        let rows = self.rest().chunks_exact(13).take(count);
        let mut read = 0;
        for row in rows {
            let index = |at: usize| {
                let bytes = [row[at], row[at + 1], row[at + 2], row[at + 3]];
                if BIG {
                    u32::from_be_bytes(bytes)
                } else {
                    u32::from_le_bytes(bytes)
                }
            };
            let triangle @ [a, b, c] = [index(1), index(5), index(9)];
            // A negative index reads as a large one.
            if row[0] != 3 || a.max(b).max(c) >= vertices {
                break;
            }
            faces.triangles.push(triangle);
            read += 1;
        }
        self.at += read * 13;
        read
    }

    fn face(
        &mut self,
        element: &Element,
        row: usize,
        plan: &FacePlan,
        indices: &mut Vec<u32>,
    ) -> Result<(), SceneError> {
        for (number, property) in element.properties.iter().enumerate() {
            let (Kind::List { count, item }, true) = (property.kind, number == plan.property)
            else {
                self.pass(element, row, property.kind)?;
                continue;
            };
            let items = self.list(element, row, count, item)?;
            let start = self.at - items.len();
            indices.clear();
            for (i, bytes) in items.chunks_exact(item.size()).enumerate() {
                let value = item.integer::<BIG>(bytes).unwrap_or_default();
                match plan.index(value) {
                    Some(index) => indices.push(index),
                    None => {
                        return Err(self.file.error(
                            self.file.byte(start + i * item.size()),
                            plan.no_such_vertex(element, row, value),
                        ));
                    }
                }
            }
        }
        Ok(())
    }
}

impl<const BIG: bool> Rows for Binary<'_, BIG> {
    fn at(&self) -> usize {
        self.at
    }

    fn seek(&mut self, at: usize) {
        self.at = at;
    }

    fn vertices(&mut self, element: &Element, plan: &VertexPlan) -> Result<Vertices, SceneError> {
        let Some(stride) = element.stride() else {
            return self.uneven_vertices(element, plan);
        };
        let start = self.at;
        let rows = self.take_rows(element, stride)?;
        if rows.is_empty() {
            return Ok(Vertices::default());
        }
        let columns = Columns::<BIG>::new(element, rows, stride);
        let vertices = Vertices::fill(plan, &columns);
        match vertices.positions.iter().position(|p| !is_finite(*p)) {
            None => Ok(vertices),
            Some(row) => Err(self.file.error(
                self.file.byte(start + row * stride),
                not_finite(row, &vertices.positions[row]),
            )),
        }
    }

    fn faces(
        &mut self,
        element: &Element,
        plan: &FacePlan,
        positions: &[[f32; 3]],
        faces: &mut Faces,
    ) -> Result<(), SceneError> {
        let common = match element.properties.as_slice() {
            [only] => matches!(
                only.kind,
                Kind::List {
                    count: Scalar::U8,
                    item: Scalar::I32 | Scalar::U32
                }
            ),
            _ => false,
        };
        // A triangle takes four bytes or more.
        let room = element.count.min(self.rest().len() / 4);
        faces.triangles.reserve(room);
        let mut indices = Vec::new();
        let mut row = 0;
        while row < element.count {
            if common && plan.shape == super::faces::Shape::Polygon {
                row += self.triangles(element.count - row, plan, faces);
                if row == element.count {
                    break;
                }
            }
            let start = self.at;
            self.face(element, row, plan, &mut indices)?;
            faces.add(plan.shape, &indices, positions, || self.file.byte(start));
            row += 1;
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<(), SceneError> {
        if let Some(stride) = element.stride() {
            return self.take_rows(element, stride).map(|_| ());
        }
        for row in 0..element.count {
            for property in &element.properties {
                self.pass(element, row, property.kind)?;
            }
        }
        Ok(())
    }

    fn finish(self, warnings: &mut Vec<String>) {
        let surplus = self.rest().len();
        if surplus > 0 {
            let text = format!(
                "the header promises nothing from here on; the last {surplus} bytes of the file are ignored"
            );
            warnings.push(self.file.warning(self.file.byte(self.at), text));
        }
    }
}

/// Rows of one length.
struct Columns<'a, const BIG: bool> {
    rows: &'a [u8],
    stride: usize,
    /// Offset and type of each property.
    fields: Vec<(usize, Scalar)>,
}

impl<'a, const BIG: bool> Columns<'a, BIG> {
    fn new(element: &Element, rows: &'a [u8], stride: usize) -> Self {
        let mut offset = 0;
        let mut fields = Vec::with_capacity(element.properties.len());
        for property in &element.properties {
            if let Kind::Scalar(scalar) = property.kind {
                fields.push((offset, scalar));
                offset += scalar.size();
            }
        }
        Self {
            rows,
            stride,
            fields,
        }
    }
}

impl<const BIG: bool> Gather for Columns<'_, BIG> {
    fn columns<const N: usize>(&self, properties: [Option<usize>; N]) -> Vec<[f32; N]> {
        let fields = properties.map(|property| property.map(|i| self.fields[i]));
        let rows = self.rows.chunks_exact(self.stride);
        let first = fields[0].map_or(0, |(offset, _)| offset);
        let side_by_side = (0..N).all(|i| fields[i] == Some((first + 4 * i, Scalar::F32)));
        if side_by_side {
            return rows
                .map(|row| {
                    let field = &row[first..first + 4 * N];
                    std::array::from_fn(|i| {
                        Scalar::F32
                            .float::<BIG>(&field[4 * i..])
                            .unwrap_or_default()
                    })
                })
                .collect();
        }
        rows.map(|row| {
            fields.map(|field| match field {
                Some((offset, scalar)) => scalar.float::<BIG>(&row[offset..]).unwrap_or_default(),
                None => 1.0,
            })
        })
        .collect()
    }
}
