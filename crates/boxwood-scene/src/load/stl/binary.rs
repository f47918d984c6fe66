//! Binary STL: 80 bytes of anything, a count, and records of 50 bytes.
//!
//! ```text
//! 0        80      84      84 + 50 n
//! │ header │ count │ normal, three vertices (12 floats), 2 bytes │ ...
//! ```

use super::mesh_of;
use super::weld::{Weld, check_count};
use crate::error::Place;
use crate::load::file::File;
use crate::{Mesh, SceneError};

const COUNT: usize = 80;
const RECORDS: usize = 84;
const RECORD: usize = 50;
/// Where the vertices begin in a record.
const VERTICES: usize = 12;

/// Whether the file is exactly as long as its count asks for.
pub fn has_exact_length(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|count| RECORDS as u64 + RECORD as u64 * count == bytes.len() as u64)
}

/// The count in the header, if the file is long enough to have one.
fn count(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(COUNT..RECORDS)?.first_chunk()?;
    Some(u32::from_le_bytes(*count).into())
}

/// Reads all triangles.
pub fn read(file: File<'_>, warnings: &mut Vec<String>) -> Result<Mesh, SceneError> {
    let Some(promised) = count(file.bytes) else {
        return Err(file.error(
            Place::File,
            format!(
                "neither ascii nor binary STL; expected `solid` at the start or at least {RECORDS} bytes, found {}",
                file.bytes.len()
            ),
        ));
    };
    let bytes = &file.bytes[RECORDS..];
    let room = bytes.len() / RECORD;
    let count = match usize::try_from(promised) {
        Ok(count) if count <= room => count,
        _ => {
            return Err(file.error(
                file.byte(COUNT),
                format!(
                    "the count promises {promised} triangles, but the file has room for {room}"
                ),
            ));
        }
    };
    check_count(&file, || file.byte(COUNT), count)?;
    let (records, surplus) = bytes.split_at(count * RECORD);
    if !surplus.is_empty() {
        warnings.push(file.warning(
            file.byte(RECORDS + records.len()),
            format!(
                "the count promises {count} triangles; the {} bytes after them are ignored",
                surplus.len()
            ),
        ));
    }
    let mut weld = Weld::for_triangles(count);
    let mut triangles = Vec::with_capacity(count);
    for (number, record) in records.chunks_exact(RECORD).enumerate() {
        let corners = vertices(record);
        if let Some(bad) = corners.as_flattened().iter().position(|c| !c.is_finite()) {
            return Err(file.error(
                file.byte(RECORDS + number * RECORD + VERTICES + 4 * bad),
                format!(
                    "vertex {} of triangle {number} has a coordinate {}; expected a finite number",
                    bad / 3,
                    corners.as_flattened()[bad]
                ),
            ));
        }
        triangles.push(corners.map(|corner| weld.vertex(corner)));
    }
    Ok(mesh_of(file.stem(), weld.positions, triangles))
}

/// The vertices of a record.
#[inline]
fn vertices(record: &[u8]) -> [[f32; 3]; 3] {
    let record: &[u8; RECORD] = record.first_chunk().unwrap_or(&[0; RECORD]);
    let float = |at: usize| {
        f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
    };
    [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| float(VERTICES + 12 * corner + 4 * axis)))
}
