//! NumPy files, written and read with another library than the command uses.

use npyz::{Deserialize, NpyFile, Order, WriterBuilder};
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use zip::{DateTime, ZipArchive};

/// An array with so many columns.
pub fn npy<T: npyz::AutoSerialize>(columns: u64, values: &[T], order: Order) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[values.len() as u64 / columns, columns])
        .order(order)
        .writer(&mut bytes)
        .begin_nd()
        .expect("a header");
    writer.extend(values).expect("numbers");
    writer.finish().expect("an array");
    bytes
}

/// The arrays of an archive.
pub struct Arrays(BTreeMap<String, Vec<u8>>);

impl Arrays {
    pub fn read(bytes: Vec<u8>) -> Self {
        let mut zip = ZipArchive::new(Cursor::new(bytes)).expect("an archive");
        let mut arrays = BTreeMap::new();
        for i in 0..zip.len() {
            let mut entry = zip.by_index(i).expect("an entry");
            assert_eq!(entry.last_modified(), Some(DateTime::default()));
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).expect("bytes");
            let name = entry
                .name()
                .expect("a name")
                .strip_suffix(".npy")
                .expect("an array")
                .to_string();
            arrays.insert(name, bytes);
        }
        Self(arrays)
    }

    pub fn names(&self) -> Vec<&str> {
        self.0.keys().map(String::as_str).collect()
    }

    pub fn get<T: Deserialize>(&self, name: &str, shape: &[u64]) -> Vec<T> {
        let file = NpyFile::new(&self.0[name][..]).expect("an array");
        assert_eq!(file.shape(), shape, "{name}");
        assert_eq!(file.order(), Order::C);
        file.into_vec().expect("the right type")
    }
}
