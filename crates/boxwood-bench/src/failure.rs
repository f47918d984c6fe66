//! Why the command ends early, in one sentence.

use std::error::Error;

/// What can fail.
pub type Outcome<T = ()> = Result<T, Box<dyn Error + Send + Sync>>;

/// A failure in the given words.
pub fn failed(sentence: impl Into<String>) -> Box<dyn Error + Send + Sync> {
    sentence.into().into()
}
