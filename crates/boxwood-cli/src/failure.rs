//! Why a verb ended early, ready to be said in one sentence.

use std::fmt::Display;
use std::io;

/// The end of a verb that did not go well.
#[derive(Debug)]
pub enum Failure {
    /// Bad input, or something the system refused: said on stderr as `error: …`, exit code 1.
    Said(String),
    /// Nobody reads our output any more (`boxwood info … | head`): ends quietly, as a success.
    Unheard,
}

/// What verbs return.
pub type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// A failure in the given words.
    pub fn new(sentence: impl Into<String>) -> Self {
        Self::Said(sentence.into())
    }

    /// What happened to a file.
    pub fn file(path: &std::path::Path, what: impl Display) -> Self {
        Self::Said(format!("{}: {what}", path.display()))
    }

    /// A failure to write to stdout.
    pub fn stdout(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::Unheard,
            _ => Self::Said(format!("standard output: cannot be written: {error}")),
        }
    }
}

// The libraries' errors are whole sentences that already contain their causes, so their sources are not walked.
impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Said(error.to_string())
    }
}
