//! Tables of numbers from NumPy files: a row for each ray or point.

use crate::failure::{Failure, Outcome};
use crate::npy::{Header, Shape};
use std::io::Read;
use std::path::Path;

/// Rows of float32, as they lie in the file.
pub struct Table<'a> {
    data: &'a [u8],
    number: fn(&[u8]) -> f32,
    width: usize,
    rows: usize,
    columns: usize,
    /// How many numbers apart the rows, and the columns, are.
    strides: [usize; 2],
}

/// What `decode` makes of a file, or of stdin for `-`.
///
/// # Errors
/// One sentence that names the file and ends with what `decode` says.
pub fn read<T>(path: &Path, decode: impl FnOnce(&[u8]) -> Result<T, String>) -> Outcome<T> {
    let (name, bytes) = if path == Path::new("-") {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().read_to_end(&mut bytes);
        ("standard input".to_string(), read.map(|_| bytes))
    } else {
        (path.display().to_string(), std::fs::read(path))
    };
    let bytes = bytes.map_err(|e| Failure::new(format!("{name}: cannot be read: {e}")))?;
    decode(&bytes).map_err(|problem| Failure::new(format!("{name}: {problem}")))
}

impl<'a> Table<'a> {
    /// Reads a header; `columns` are the widths that a row may have. Float64 is rounded to float32.
    ///
    /// # Errors
    /// What is wrong with it, as the end of a sentence that begins with the file's name.
    pub fn decode(
        bytes: &'a [u8],
        columns: &[u64],
        row: &str,
        expected: &str,
    ) -> Result<Self, String> {
        let (header, data) = Header::read(bytes)?;
        let number: fn(&[u8]) -> f32 = match header.descr.as_str() {
            "<f4" => |b| f32::from_le_bytes(fixed(b)),
            ">f4" => |b| f32::from_be_bytes(fixed(b)),
            "<f8" => |b| f64::from_le_bytes(fixed(b)) as f32,
            ">f8" => |b| f64::from_be_bytes(fixed(b)) as f32,
            other => {
                return Err(format!(
                    "holds numbers of type {other}; expected {expected}"
                ));
            }
        };
        let width: u64 = if header.descr.ends_with('4') { 4 } else { 8 };
        let (n, columns) = match header.shape[..] {
            [n, width] if columns.contains(&width) => (n, width),
            _ => {
                return Err(format!(
                    "has the shape {}; expected {expected}",
                    Shape(&header.shape)
                ));
            }
        };
        if n.checked_mul(columns * width) != Some(data.len() as u64) {
            return Err(format!(
                "promises {n} {row}s of {} bytes, but {} bytes follow its header",
                columns * width,
                data.len()
            ));
        }
        // The multiplication above has shown that these fit.
        let (rows, columns, width) = (n as usize, columns as usize, width as usize);
        Ok(Self {
            data,
            number,
            width,
            rows,
            columns,
            strides: if header.fortran_order {
                [1, rows]
            } else {
                [columns, 1]
            },
        })
    }

    pub fn rows(&self) -> usize {
        self.rows
    }
    pub fn columns(&self) -> usize {
        self.columns
    }
    /// One number.
    pub fn at(&self, row: usize, column: usize) -> f32 {
        let first = (row * self.strides[0] + column * self.strides[1]) * self.width;
        (self.number)(&self.data[first..first + self.width])
    }
    /// Three numbers of a row.
    pub fn vector(&self, row: usize, first: usize) -> [f32; 3] {
        [first, first + 1, first + 2].map(|column| self.at(row, column))
    }
}

/// Exactly `N` bytes, as all callers pass.
fn fixed<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut fixed = [0; N];
    fixed.copy_from_slice(bytes);
    fixed
}
