//! What the command says, and where: results on stdout, everything else on stderr.
//!
//! *How it works.* `println!` panics when the reader of a pipe has gone; these return [`Failure::Unheard`] instead, or,
//! for stderr, go on without having been heard. Colour appears only on a terminal that wants it (`NO_COLOR` is obeyed).

use crate::failure::{Failure, Outcome};
use clap::builder::styling::{AnsiColor, Style};
use std::fmt::Display;
use std::io::{Write, stdout};

const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// At most so many warnings are said in full; `boxwood info` shows the others.
const WARNINGS: usize = 10;

/// Where a verb's report goes: stdout, unless stdout carries the verb's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    Stdout,
    Stderr,
}

impl Channel {
    /// Says `text` and ends the line.
    pub fn say(self, text: impl Display) -> Outcome {
        match self {
            Self::Stdout => writeln!(stdout().lock(), "{text}").map_err(|e| Failure::stdout(&e)),
            Self::Stderr => {
                let _ = writeln!(anstream::stderr().lock(), "{text}");
                Ok(())
            }
        }
    }
}

/// Writes a whole file's bytes to stdout.
pub fn pour(bytes: &[u8]) -> Outcome {
    let mut stdout = stdout().lock();
    stdout
        .write_all(bytes)
        .and_then(|()| stdout.flush())
        .map_err(|e| Failure::stdout(&e))
}

/// Says why the command fails.
pub fn error(sentence: &str) {
    let _ = writeln!(
        anstream::stderr().lock(),
        "{ERROR}error:{ERROR:#} {sentence}"
    );
}

/// Says something that is good to know.
pub fn note(text: impl Display) {
    let _ = writeln!(anstream::stderr().lock(), "note: {text}");
}

/// Says what was passed over in a scene, the first few in full.
pub fn warnings(scene: &str, all: &[String]) {
    let mut stderr = anstream::stderr().lock();
    for warning in all.iter().take(WARNINGS) {
        let _ = writeln!(stderr, "{WARNING}warning:{WARNING:#} {warning}");
    }
    if let Some(more) = all.len().checked_sub(WARNINGS + 1) {
        let _ = writeln!(
            stderr,
            "{WARNING}warning:{WARNING:#} and {} more; see `boxwood info {scene}`",
            more + 1
        );
    }
}

/// `12345678` as `12,345,678`.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 triangle`, `2 triangles`, `3 boxes`, `4 leaves`.
pub fn counted(n: u64, one: &str) -> String {
    let plural = if one.ends_with("sh") || one.ends_with('x') {
        format!("{one}es")
    } else if let Some(stem) = one.strip_suffix("af") {
        format!("{stem}aves")
    } else {
        format!("{one}s")
    };
    format!("{} {}", grouped(n), if n == 1 { one } else { &plural })
}

/// Bytes in the unit that suits them.
pub fn bytes(n: u64) -> String {
    const UNITS: [&str; 4] = ["KiB", "MiB", "GiB", "TiB"];
    if n < 1024 {
        return counted(n, "byte");
    }
    let mut value = n as f64 / 1024.0;
    let mut unit = 0;
    while value >= 1023.95 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    format!("{value:.1} {}", UNITS[unit])
}

/// Seconds with the digits that matter.
pub fn seconds(s: f64) -> String {
    if s < 1.0 {
        format!("{:.1} ms", s * 1e3)
    } else if s < 60.0 {
        format!("{s:.2} s")
    } else {
        let whole = s.round() as u64;
        format!("{} min {:02} s", whole / 60, whole % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped() {
        for (n, text) in [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (1_234_567, "1,234,567"),
        ] {
            assert_eq!(grouped(n), text);
        }
    }

    #[test]
    fn one_is_not_many() {
        assert_eq!(counted(1, "ray"), "1 ray");
        assert_eq!(counted(0, "ray"), "0 rays");
        assert_eq!(counted(2, "mesh"), "2 meshes");
        assert_eq!(counted(3, "box"), "3 boxes");
        assert_eq!(counted(4, "leaf"), "4 leaves");
    }

    #[test]
    fn units_suit_their_numbers() {
        assert_eq!(bytes(1), "1 byte");
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(bytes(1024 * 1024 - 1), "1.0 MiB");
        assert_eq!(bytes(u64::MAX), "16777216.0 TiB");
        assert_eq!(seconds(0.0123), "12.3 ms");
        assert_eq!(seconds(1.5), "1.50 s");
        assert_eq!(seconds(119.7), "2 min 00 s");
    }
}
