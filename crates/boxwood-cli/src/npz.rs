//! Arrays to a NumPy archive (`.npz`): a ZIP file of `.npy` arrays, stored as they are.
//!
//! The bytes depend only on the arrays: the dates inside are those of 1 January 1980, the order is the caller's, nothing
//! is compressed, and the entries name the same system everywhere.

use crate::npy::Header;
use std::io::{self, Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

/// An entry of a ZIP file from this size on must be marked as large.
const LARGE: usize = u32::MAX as usize;

/// An archive in the making.
pub struct Archive(ZipWriter<Cursor<Vec<u8>>>);

/// A number that arrays hold.
pub trait Element: Copy {
    /// NumPy's name for it.
    const DESCR: &str;
    /// Appends its bytes.
    fn put(self, to: &mut Vec<u8>);
}

macro_rules! element {
    ($($type:ty = $descr:literal),*) => {$(
        impl Element for $type {
            const DESCR: &str = $descr;
            fn put(self, to: &mut Vec<u8>) {
                to.extend(self.to_le_bytes());
            }
        }
    )*};
}
element!(f32 = "<f4", u32 = "<u4", u64 = "<u8", i64 = "<i8");

impl Element for bool {
    const DESCR: &str = "|b1";
    fn put(self, to: &mut Vec<u8>) {
        to.push(u8::from(self));
    }
}

impl Archive {
    /// An archive of nothing.
    pub fn new() -> Self {
        Self(ZipWriter::new(Cursor::new(Vec::new())))
    }

    /// Adds an array of numbers.
    pub fn add<T: Element>(
        &mut self,
        name: &str,
        values: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        self.rows(name, &[], values)
    }

    /// Adds an array of rows of three numbers.
    pub fn add_vectors<T: Element>(
        &mut self,
        name: &str,
        values: impl IntoIterator<Item = [T; 3]>,
    ) -> io::Result<()> {
        self.rows(name, &[3], values.into_iter().flatten())
    }

    fn rows<T: Element>(
        &mut self,
        name: &str,
        row: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        let mut data = Vec::new();
        let mut count = 0_u64;
        for value in values {
            value.put(&mut data);
            count += 1;
        }
        let mut shape = vec![count / row.iter().product::<u64>()];
        shape.extend(row);
        let header = Header {
            descr: T::DESCR.to_string(),
            fortran_order: false,
            shape,
        }
        .to_bytes();
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .system(System::Unix)
            .unix_permissions(0o644)
            .large_file(header.len() + data.len() >= LARGE);
        self.0.start_file(format!("{name}.npy"), options)?;
        self.0.write_all(&header)?;
        self.0.write_all(&data)
    }

    /// The finished file.
    pub fn finish(self) -> io::Result<Vec<u8>> {
        Ok(self.0.finish()?.into_inner())
    }
}
