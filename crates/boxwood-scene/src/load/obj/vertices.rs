//! The vertex data of a whole OBJ file: positions with colours, texture coordinates, normals.

use super::Line;
use super::cursor::{Cursor, quoted};
use super::warnings::Warnings;

/// What `v`, `vt` and `vn` have said so far.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<[f32; 3]>,
    /// `v` pointing down.
    pub(super) uvs: Vec<[f32; 2]>,
    /// Unit length, or zero where the file has no direction.
    pub(super) normals: Vec<[f32; 3]>,
    /// Linear; empty, or as long as `positions`.
    pub(super) colors: Vec<[f32; 4]>,
}

/// A problem with the present line, to be made an error with its place.
type Checked = Result<(), String>;

impl Vertices {
    pub(super) fn is_empty(&self) -> bool {
        self.positions.is_empty() && self.uvs.is_empty() && self.normals.is_empty()
    }

    /// `v x y z`, with a weight or a colour behind it.
    #[inline]
    pub(super) fn position(&mut self, cursor: &mut Cursor, warnings: &mut Warnings) -> Checked {
        let mut position = [0.0; 3];
        for (axis, value) in position.iter_mut().enumerate() {
            *value = match cursor.number() {
                Some(number) if number.is_finite() => number,
                Some(_) => return Err(not_finite(axis)),
                None => return Err(missing(cursor, "3 coordinates", axis)),
            };
        }
        self.positions.push(position);
        if cursor.skip_blanks() {
            return self.color(cursor, warnings);
        }
        if !self.colors.is_empty() {
            self.colors.push([1.0; 4]);
        }
        Ok(())
    }

    /// What stands behind the coordinates: nothing but a weight, or red, green and blue in sRGB.
    fn color(&mut self, cursor: &mut Cursor, warnings: &mut Warnings) -> Checked {
        let mut values = [1.0; 3];
        let mut count = 0;
        while count < 3 && cursor.skip_blanks() {
            values[count] = cursor
                .number()
                .ok_or_else(|| missing(cursor, "a weight or a colour", count))?;
            count += 1;
        }
        if count < 3 {
            if !self.colors.is_empty() {
                self.colors.push([1.0; 4]);
            }
            return Ok(());
        }
        if values.iter().any(|value| !value.is_finite()) {
            warnings.of_kind(
                "color",
                Line(cursor.line()),
                || "a vertex colour that is not finite; white takes its place",
            );
            values = [1.0; 3];
        }
        let [r, g, b] = values.map(|value| srgb_to_linear(value.clamp(0.0, 1.0)));
        self.colors.resize(self.positions.len() - 1, [1.0; 4]);
        self.colors.push([r, g, b, 1.0]);
        Ok(())
    }

    /// `vt u`, `vt u v` or `vt u v w`.
    #[inline]
    pub(super) fn uv(&mut self, cursor: &mut Cursor, warnings: &mut Warnings) -> Checked {
        let Some(u) = cursor.number() else {
            return Err(missing(cursor, "1 to 3 texture coordinates", 0));
        };
        let v = match cursor.number() {
            Some(v) => v,
            None if cursor.skip_blanks() => {
                return Err(missing(cursor, "1 to 3 texture coordinates", 1));
            }
            None => 0.0,
        };
        let mut uv = [u, 1.0 - v];
        if !(uv[0].is_finite() && uv[1].is_finite()) {
            warnings.of_kind(
                "uv",
                Line(cursor.line()),
                || "a texture coordinate that is not finite; 0 takes its place",
            );
            uv = [0.0, 1.0];
        }
        self.uvs.push(uv);
        Ok(())
    }

    /// `vn x y z`.
    #[inline]
    pub(super) fn normal(&mut self, cursor: &mut Cursor, warnings: &mut Warnings) -> Checked {
        let mut normal = [0.0_f64; 3];
        for (axis, value) in normal.iter_mut().enumerate() {
            match cursor.number() {
                Some(number) => *value = f64::from(number),
                None => return Err(missing(cursor, "3 components of a normal", axis)),
            }
        }
        let unit = crate::normals::unit(normal).unwrap_or_else(|| {
            warnings.of_kind(
                "normal without direction",
                Line(cursor.line()),
                || "a normal without direction; that of the faces takes its place",
            );
            [0.0; 3]
        });
        self.normals.push(unit);
        Ok(())
    }
}

#[cold]
fn not_finite(axis: usize) -> String {
    let axis = ["x", "y", "z"][axis];
    format!("coordinate {axis} is not a finite number that fits in 32 bits")
}

/// A number was expected as number `index` (from 0) of `what`.
#[cold]
fn missing(cursor: &mut Cursor, what: &str, index: usize) -> String {
    match cursor.peek_word() {
        [] => format!("the line ends after {index} numbers, but {what} were expected"),
        word => format!("{} is not a number, but {what} were expected", quoted(word)),
    }
}

/// Colours of vertices are stored as they look on a screen.
fn srgb_to_linear(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        libm::powf((value + 0.055) / 1.055, 2.4)
    }
}
