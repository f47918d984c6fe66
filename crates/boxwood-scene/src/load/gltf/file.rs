//! The file being read: its tables, the bytes behind them, and what there is to say about it.
//!
//! *How it works.* Everything that follows an index or takes memory asks here, so that no index is followed
//! unchecked and a few bytes cannot ask for much memory: thousands of primitives may share one accessor, and an
//! accessor without a buffer view promises any number of zeros. The budget grows with what has really been read.

use super::container::Parts;
use super::schema::{BufferView, Index, Root, Rows};
use super::uri::{self, Target};
use crate::SceneError;
use crate::error::Place;
use crate::load::Source;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::io;
use std::rc::Rc;

/// The scene may take this many bytes for each byte read, …
const BYTES_PER_BYTE: u64 = 64;
/// … and this many besides.
const BYTES_BESIDES: u64 = 64 << 20;

/// A glTF file.
pub struct File<'a> {
    pub root: Root,
    source: Source<'a>,
    buffers: Vec<Option<Bytes<'a>>>,
    budget: Cell<u64>,
    warnings: RefCell<Vec<Warning>>,
}

/// The bytes of a buffer.
#[derive(Clone)]
enum Bytes<'a> {
    Chunk(&'a [u8]),
    Read(Rc<[u8]>),
}

impl Bytes<'_> {
    fn get(&self) -> &[u8] {
        match self {
            Self::Chunk(bytes) => bytes,
            Self::Read(bytes) => bytes,
        }
    }
}

/// Something that was passed over, and how often.
struct Warning {
    path: String,
    what: String,
    repeats: usize,
}

impl<'a> File<'a> {
    /// Reads the JSON.
    ///
    /// # Errors
    /// Where it is not JSON, not glTF 2.0, or has a value of a wrong type.
    pub fn parse(parts: &Parts<'a>, source: Source<'a>) -> Result<Self, SceneError> {
        let root = super::json::parse(parts, source.name)?;
        let file = Self {
            root,
            source,
            buffers: Vec::new(),
            budget: Cell::new(BYTES_BESIDES),
            warnings: RefCell::default(),
        };
        file.grow_budget(parts.json.len() + parts.binary.map_or(0, <[u8]>::len));
        Ok(file)
    }

    /// The error that something at `path` is not as it must be.
    pub fn malformed(&self, path: impl Into<String>, problem: impl Into<String>) -> SceneError {
        SceneError::Malformed {
            file: self.source.name.to_owned(),
            place: Place::Path(path.into()),
            problem: problem.into(),
        }
    }

    /// Remembers that something was passed over. The same thing in other places is only counted.
    pub fn warn(&self, path: impl Into<String>, what: impl Into<String>) {
        let what = what.into();
        let mut warnings = self.warnings.borrow_mut();
        if let Some(known) = warnings.iter_mut().find(|warning| warning.what == what) {
            known.repeats += 1;
        } else if warnings.len() < MOST_WARNINGS {
            warnings.push(Warning {
                path: path.into(),
                what,
                repeats: 0,
            });
        }
    }

    /// All warnings as sentences.
    pub fn into_warnings(self) -> Vec<String> {
        let sentence = |warning: Warning| {
            let Warning { path, what, .. } = warning;
            let again = match warning.repeats {
                0 => String::new(),
                1 => " (and in one other place)".to_owned(),
                n => format!(" (and in {n} other places)"),
            };
            format!("{}, {path}: {what}{again}", self.source.name)
        };
        let warnings = self.warnings.into_inner();
        warnings.into_iter().map(sentence).collect()
    }

    /// Follows an index into one of the tables.
    ///
    /// # Errors
    /// When the table, called `what` in the singular, is shorter.
    pub fn at<'t, T: ?Sized>(
        &self,
        table: &'t (impl Table<T> + ?Sized),
        index: Index,
        what: &str,
        path: impl FnOnce() -> String,
    ) -> Result<&'t T, SceneError> {
        table.entry(index.0 as usize).ok_or_else(|| {
            let there_are = match table.length() {
                0 => "there are none".to_owned(),
                1 => "there is only one".to_owned(),
                n => format!("there are {n}"),
            };
            let problem = format!("names {what} {}, but {there_are} (counted from 0)", index.0);
            self.malformed(path(), problem)
        })
    }

    /// Takes memory from the budget, before it is asked from the system.
    ///
    /// # Errors
    /// When the scene would grow out of all proportion to the file.
    pub fn spend(&self, bytes: u64, path: impl FnOnce() -> String) -> Result<(), SceneError> {
        let left = self.budget.get().checked_sub(bytes).ok_or_else(|| {
            self.malformed(
                path(),
                format!(
                    "the scene would take more than {BYTES_PER_BYTE} times the memory of the files it was read from"
                ),
            )
        })?;
        self.budget.set(left);
        Ok(())
    }

    fn grow_budget(&self, bytes_read: usize) {
        let more = BYTES_PER_BYTE.saturating_mul(bytes_read as u64);
        self.budget.set(self.budget.get().saturating_add(more));
    }

    /// The bytes of a file beside the scene.
    ///
    /// # Errors
    /// What the system says.
    pub fn read_beside(&self, name: &str) -> io::Result<Vec<u8>> {
        let bytes = self.source.files.read(name)?;
        self.grow_budget(bytes.len());
        Ok(bytes)
    }

    /// Reads every buffer that a view needs.
    ///
    /// # Errors
    /// When a buffer is absent or too short.
    pub fn read_buffers(&mut self, binary: Option<&'a [u8]>) -> Result<(), SceneError> {
        let mut needed = vec![false; self.root.buffers.len()];
        for view in &self.root.buffer_views {
            if let Some(needed) = needed.get_mut(view.buffer.0 as usize) {
                *needed = true;
            }
        }
        let mut files = HashMap::new();
        let mut buffers = vec![None; needed.len()];
        for number in (0..needed.len()).filter(|&number| needed[number]) {
            let buffer = &self.root.buffers[number];
            let bytes = match &buffer.uri {
                Some(uri) => self.read_buffer(uri, number, &mut files)?,
                None => match binary {
                    Some(chunk) if number == 0 => Bytes::Chunk(chunk),
                    // The fallback of a compression extension has no bytes; who looks into it will be told.
                    _ => continue,
                },
            };
            let length = bytes.get().len() as u64;
            let promised = buffer.byte_length.0;
            if length < promised {
                let problem =
                    format!("{promised} bytes were promised, but there are only {length}");
                return Err(self.malformed(format!("buffers[{number}].byteLength"), problem));
            }
            buffers[number] = Some(bytes);
        }
        self.buffers = buffers;
        Ok(())
    }

    fn read_buffer(
        &self,
        uri: &str,
        number: usize,
        files: &mut HashMap<String, Rc<[u8]>>,
    ) -> Result<Bytes<'a>, SceneError> {
        let path = || format!("buffers[{number}].uri");
        match uri::resolve(uri).map_err(|problem| self.malformed(path(), problem))? {
            Target::Data(bytes) => Ok(Bytes::Read(bytes.into())),
            Target::File(name) => {
                if let Some(bytes) = files.get(&name) {
                    return Ok(Bytes::Read(bytes.clone()));
                }
                let bytes: Rc<[u8]> = self
                    .read_beside(&name)
                    .map_err(|e| self.malformed(path(), format!("{name} cannot be read: {e}")))?
                    .into();
                files.insert(name, bytes.clone());
                Ok(Bytes::Read(bytes))
            }
        }
    }

    /// A buffer view and its bytes.
    ///
    /// # Errors
    /// When there is no such view, or it leaves its buffer. `path` is who asks.
    pub fn view(
        &self,
        index: Index,
        path: impl FnOnce() -> String,
    ) -> Result<(&BufferView, &[u8]), SceneError> {
        let number = index.0;
        let view = self.at(&self.root.buffer_views, index, "buffer view", path)?;
        let names_buffer = || format!("bufferViews[{number}].buffer");
        let buffer = self.at(&self.root.buffers, view.buffer, "buffer", names_buffer)?;
        let Some(bytes) = &self.buffers[view.buffer.0 as usize] else {
            let problem = format!("buffers[{}] has neither a uri nor data", view.buffer.0);
            return Err(self.malformed(names_buffer(), problem));
        };
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let end = start.saturating_add(view.byte_length.0);
        let length = buffer.byte_length.0;
        if end > length {
            let problem = format!(
                "the view ends at byte {end}, but buffers[{}] has {length} bytes",
                view.buffer.0
            );
            return Err(self.malformed(format!("bufferViews[{number}].byteLength"), problem));
        }
        // Within the buffer, whose bytes are in memory: the casts keep the value.
        Ok((view, &bytes.get()[start as usize..end as usize]))
    }
}

/// More kinds of warnings help nobody, and looking them through takes time.
const MOST_WARNINGS: usize = 100;

/// A table whose entries are named by number.
pub trait Table<T: ?Sized> {
    fn entry(&self, index: usize) -> Option<&T>;
    fn length(&self) -> usize;
}

impl<T> Table<T> for [T] {
    fn entry(&self, index: usize) -> Option<&T> {
        self.get(index)
    }
    fn length(&self) -> usize {
        self.len()
    }
}

impl<T> Table<T> for Vec<T> {
    fn entry(&self, index: usize) -> Option<&T> {
        self.get(index)
    }
    fn length(&self) -> usize {
        self.len()
    }
}

impl<T> Table<T> for Rows<T> {
    fn entry(&self, index: usize) -> Option<&T> {
        self.get(index)
    }
    fn length(&self) -> usize {
        self.len()
    }
}
