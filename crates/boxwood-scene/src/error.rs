//! What can go wrong on the way in, in one clear sentence: which file, where in it, what was expected.

use std::fmt;
use std::path::PathBuf;

/// Where in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A byte offset, counted from 0.
    Byte(u64),
    /// A path inside a structured file, such as `accessors[3].count`.
    Path(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ", line {line}"),
            Self::Byte(offset) => write!(f, ", byte {offset}"),
            Self::Path(path) => write!(f, ", {path}"),
        }
    }
}

/// Why a scene could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The operating system could not give the bytes.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The bytes do not follow the format.
    #[error("{file}{place}: {problem}")]
    Malformed {
        /// The file's name as the caller gave it.
        file: String,
        /// Where.
        place: Place,
        /// What is there and what was expected.
        problem: String,
    },
    /// The bytes may be right, but ask for what Boxwood does not have.
    #[error("{file}{place}: {what} is not supported")]
    Unsupported {
        /// The file's name as the caller gave it.
        file: String,
        /// Where.
        place: Place,
        /// What is asked for.
        what: String,
    },
    /// The name's extension belongs to no format that Boxwood reads.
    #[error("{}: unknown kind of file; Boxwood reads .obj, .ply, .stl, .gltf and .glb", file.display())]
    UnknownFormat {
        /// The file.
        file: PathBuf,
    },
}
