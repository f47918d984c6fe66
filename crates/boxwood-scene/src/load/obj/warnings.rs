//! Gathers what was passed over, so that a million equal flaws become one sentence.

use super::Line;
use std::fmt::Display;

/// Sentences about one file.
pub(super) struct Warnings {
    file: String,
    entries: Vec<Entry>,
    /// How many were left out because there are too many already.
    left_out: usize,
}

struct Entry {
    kind: Option<&'static str>,
    sentence: String,
    more: usize,
}

/// So many sentences are enough for anybody.
const MOST: usize = 100;

impl Warnings {
    pub(super) fn new(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            entries: Vec::new(),
            left_out: 0,
        }
    }

    /// One more flaw of this kind; only the first of a kind is written down, the others are counted.
    #[cold]
    pub(super) fn of_kind<S: Display>(
        &mut self,
        kind: &'static str,
        line: Line,
        sentence: impl FnOnce() -> S,
    ) {
        match self.entries.iter_mut().find(|e| e.kind == Some(kind)) {
            Some(entry) => entry.more += 1,
            None => self.push(Some(kind), line, sentence()),
        }
    }

    /// A flaw that is told each time.
    #[cold]
    pub(super) fn each(&mut self, line: Line, sentence: impl Display) {
        if self.entries.len() < MOST {
            self.push(None, line, sentence);
        } else {
            self.left_out += 1;
        }
    }

    fn push(&mut self, kind: Option<&'static str>, line: Line, sentence: impl Display) {
        self.entries.push(Entry {
            kind,
            sentence: format!("{}, line {}: {sentence}", self.file, line.0),
            more: 0,
        });
    }

    /// The sentences, the counts behind them.
    pub(super) fn finish(self) -> impl Iterator<Item = String> {
        let last = (self.left_out > 0).then(|| {
            format!(
                "{}: {} more warnings are left out",
                self.file, self.left_out
            )
        });
        let entries = self.entries.into_iter().map(|entry| match entry.more {
            0 => entry.sentence,
            more => format!("{} (and {more} more like this)", entry.sentence),
        });
        entries.chain(last)
    }
}
