//! A place in a text made of words and lines, for formats that are read word by word.
//!
//! Nothing is copied and no line is counted on the way: whoever has to complain asks [`File::line_of`](super::file::File::line_of).

use super::decimal;

/// A text and how far it has been read.
#[derive(Clone, Copy)]
pub struct Text<'a> {
    /// All of it.
    pub bytes: &'a [u8],
    /// The next byte.
    pub at: usize,
}

impl<'a> Text<'a> {
    /// Goes on to the next word or to the end of the line.
    #[inline]
    pub fn skip_blanks(&mut self) {
        while self.bytes.get(self.at).is_some_and(|b| is_blank(*b)) {
            self.at += 1;
        }
    }

    /// Goes on to the next word, on whatever line, or to the end of the text.
    #[inline]
    pub fn skip_white(&mut self) {
        while self.bytes.get(self.at).is_some_and(|b| is_white(*b)) {
            self.at += 1;
        }
    }

    /// Goes on to the end of the line.
    pub fn skip_line(&mut self) {
        while self.bytes.get(self.at).is_some_and(|b| !is_break(*b)) {
            self.at += 1;
        }
    }

    /// Whether the whole text has been read.
    #[inline]
    pub fn at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// Whether no byte of the line is left.
    #[inline]
    pub fn at_line_end(&self) -> bool {
        self.bytes.get(self.at).is_none_or(|b| is_break(*b))
    }

    /// Reads up to the next white space: a word if one begins here, else nothing.
    #[inline]
    pub fn word(&mut self) -> &'a [u8] {
        let start = self.at;
        while self.bytes.get(self.at).is_some_and(|b| !is_white(*b)) {
            self.at += 1;
        }
        &self.bytes[start..self.at]
    }

    /// Reads the word that begins here as a number, or stays where it is.
    #[inline]
    pub fn float(&mut self) -> Option<f32> {
        let (value, length) = decimal::float(&self.bytes[self.at..])?;
        self.accept(length).then_some(value)
    }

    /// Reads the word that begins here as a whole number, or stays where it is.
    #[inline]
    pub fn integer(&mut self) -> Option<i64> {
        let (value, length) = decimal::integer(&self.bytes[self.at..])?;
        self.accept(length).then_some(value)
    }

    /// Moves on if the word ends after `length` bytes.
    #[inline]
    fn accept(&mut self, length: usize) -> bool {
        let ends = self
            .bytes
            .get(self.at + length)
            .is_none_or(|b| is_white(*b));
        if ends {
            self.at += length;
        }
        ends
    }
}

#[inline]
fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}

#[inline]
fn is_break(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

#[inline]
fn is_white(byte: u8) -> bool {
    is_blank(byte) || is_break(byte)
}

/// A word of the file for a message: in back-ticks, without control characters, of bounded length.
pub fn quote(word: impl AsRef<[u8]>) -> String {
    const LONGEST: usize = 40;
    let word = word.as_ref();
    let shown = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]);
    let dots = if word.len() > LONGEST { "…" } else { "" };
    let clean: String = shown
        .chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    format!("`{clean}{dots}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_lines() {
        let mut text = Text {
            bytes: b"  ab\t1.5\r\n7x",
            at: 0,
        };
        text.skip_blanks();
        assert_eq!(text.word(), b"ab");
        assert!(!text.at_line_end());
        text.skip_blanks();
        assert_eq!(text.float(), Some(1.5));
        assert!(text.at_line_end());
        text.skip_white();
        assert_eq!(text.integer(), None);
        assert_eq!(text.float(), None);
        assert_eq!(text.word(), b"7x");
        assert!(text.at_end());
    }

    #[test]
    fn quotes_are_short_and_printable() {
        assert_eq!(quote("x"), "`x`");
        assert_eq!(quote(b"a\x00\xff"), "`a\u{fffd}\u{fffd}`");
        assert!(quote([b'a'; 1000]).len() < 60);
    }
}
