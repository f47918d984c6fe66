//! Walks through the bytes of an OBJ or MTL file, word by word and line by line.
//!
//! *How it works.* One position and one line number move forward, nothing is copied. A back-slash at the end of a line
//! reads as a blank, so that a statement may span several lines; `\n`, `\r\n` and a lone `\r` end a line; the end of
//! the file reads as the end of a line. *Cost.* One look at every byte.

use super::number;

/// A position in a text.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

/// The end of a line, and of the file.
const END: u8 = b'\n';

impl<'a> Cursor<'a> {
    /// At the start of `bytes`, behind a byte-order mark of UTF-8.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        Self {
            bytes,
            at: 0,
            line: 1,
        }
    }

    /// The number of the present line, counted from 1.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// Whether everything is read.
    pub(super) fn is_done(&self) -> bool {
        self.at >= self.bytes.len()
    }

    #[inline]
    fn peek(&self) -> u8 {
        self.peek_after(0)
    }

    #[inline]
    fn peek_after(&self, offset: usize) -> u8 {
        self.bytes.get(self.at + offset).copied().unwrap_or(END)
    }

    /// How many bytes a continuation at `at` has: the back-slash and the end of its line; 0 when there is none.
    fn continuation(&self, at: usize) -> usize {
        match self.bytes.get(at..) {
            Some([b'\\', b'\r', b'\n', ..]) => 3,
            Some([b'\\', b'\r' | b'\n', ..]) => 2,
            _ => 0,
        }
    }

    /// Passes over blanks; `true` when a word follows on this line.
    #[inline]
    pub(super) fn skip_blanks(&mut self) -> bool {
        loop {
            match self.peek() {
                b' ' | b'\t' | b'\x0B' | b'\x0C' => self.at += 1,
                b'\\' => match self.continuation(self.at) {
                    0 => return true,
                    length => {
                        self.at += length;
                        self.line += 1;
                    }
                },
                b'\n' | b'\r' | b'#' => return false,
                _ => return true,
            }
        }
    }

    /// Whether the byte at `at` ends a word.
    #[inline]
    fn ends_word(&self, at: usize) -> bool {
        match self.bytes.get(at) {
            None => true,
            Some(b' ' | b'\t' | b'\n' | b'\r' | b'\x0B' | b'\x0C') => true,
            Some(b'\\') => self.continuation(at) > 0,
            Some(_) => false,
        }
    }

    /// The next word of the line, passed over; empty when there is none.
    #[inline]
    pub(super) fn word(&mut self) -> &'a [u8] {
        if !self.skip_blanks() {
            return &[];
        }
        let start = self.at;
        while !self.ends_word(self.at) {
            self.at += 1;
        }
        &self.bytes[start..self.at]
    }

    /// The next word without moving.
    pub(super) fn peek_word(&mut self) -> &'a [u8] {
        let word = self.word();
        self.at -= word.len();
        word
    }

    /// The next word as a number, perhaps not a finite one. `None`: no number stands here, and the word is still ahead.
    #[inline]
    pub(super) fn number(&mut self) -> Option<f32> {
        if !self.skip_blanks() {
            return None;
        }
        if let Some((value, length)) = number::quick(&self.bytes[self.at..])
            && self.ends_word(self.at + length)
        {
            self.at += length;
            return Some(value);
        }
        let word = self.peek_word();
        let value = number::exact(word)?;
        self.at += word.len();
        Some(value)
    }

    /// A whole number with sign, up to anything but a digit. `None`: there is no digit; too large ones saturate.
    #[inline]
    pub(super) fn integer(&mut self) -> Option<i64> {
        let negative = self.peek() == b'-';
        let start = self.at + usize::from(negative || self.peek() == b'+');
        let mut at = start;
        let mut value = 0_i64;
        while let Some(&byte) = self.bytes.get(at) {
            let digit = byte.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            value = value.saturating_mul(10).saturating_add(i64::from(digit));
            at += 1;
        }
        if at == start {
            return None;
        }
        self.at = at;
        Some(if negative { -value } else { value })
    }

    /// Passes over `byte` if it comes next.
    #[inline]
    pub(super) fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == byte && !self.is_done();
        self.at += usize::from(found);
        found
    }

    /// Whether the present word ends here.
    #[inline]
    pub(super) fn word_ends(&self) -> bool {
        self.ends_word(self.at)
    }

    /// What is left of the line, without blanks around it, bytes that are not UTF-8 replaced. A `#` belongs to it.
    pub(super) fn rest(&mut self) -> String {
        let mut text = Vec::new();
        loop {
            match self.peek() {
                b'\n' | b'\r' => break,
                b'\\' if self.continuation(self.at) > 0 => {
                    self.at += self.continuation(self.at);
                    self.line += 1;
                    text.push(b' ');
                }
                byte => {
                    text.push(byte);
                    self.at += 1;
                }
            }
        }
        String::from_utf8_lossy(text.trim_ascii()).into_owned()
    }

    /// What is left of the line as a name, cut where it is absurdly long: it may come to stand in a great many places.
    pub(super) fn name(&mut self) -> String {
        const LONGEST: usize = 200;
        self.rest().chars().take(LONGEST).collect()
    }

    /// Passes over the rest of the line with its end. Comments are not continued.
    #[inline]
    pub(super) fn next_line(&mut self) {
        let mut comment = false;
        loop {
            match self.peek() {
                b'\n' => break self.at += 1,
                b'\r' => break self.at += 1 + usize::from(self.peek_after(1) == b'\n'),
                b'\\' if !comment && self.continuation(self.at) > 0 => {
                    self.at += self.continuation(self.at);
                    self.line += 1;
                }
                b'#' => {
                    comment = true;
                    self.at += 1;
                }
                _ => self.at += 1,
            }
        }
        self.line += 1;
    }
}

/// A word for a message: short, printable, in quotes.
pub(super) fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(4 * LONGEST)]);
    let mut short: String = text
        .chars()
        .take(LONGEST)
        .map(|c| if c.is_control() { '\u{FFFD}' } else { c })
        .collect();
    if word.len() > short.len() {
        short.push('…');
    }
    format!("\"{short}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_span_continued_lines_and_end_with_theirs() {
        let mut cursor = Cursor::new(b"f 1 \\\r\n  2\\\n3 # 4\\\n5\rx");
        assert_eq!(cursor.word(), b"f");
        assert_eq!(cursor.number(), Some(1.0));
        assert_eq!(cursor.number(), Some(2.0));
        assert_eq!(cursor.number(), Some(3.0));
        assert_eq!((cursor.number(), cursor.line()), (None, 3));
        cursor.next_line();
        assert_eq!((cursor.word(), cursor.line()), (&b"5"[..], 4));
        cursor.next_line();
        assert_eq!((cursor.word(), cursor.line()), (&b"x"[..], 5));
        cursor.next_line();
        assert!(cursor.is_done());
    }

    #[test]
    fn the_rest_of_a_line_keeps_blanks_back_slashes_and_hashes() {
        let mut cursor = Cursor::new(b"map_Kd  .\\my wood #2.png \t\r\nnext");
        assert_eq!(cursor.word(), b"map_Kd");
        assert_eq!(cursor.rest(), ".\\my wood #2.png");
        cursor.next_line();
        assert_eq!(cursor.word(), b"next");
    }

    #[test]
    fn quoted_words_are_short_and_printable() {
        assert_eq!(quoted(b"3.1+e2"), "\"3.1+e2\"");
        assert_eq!(quoted(b"a\0b"), "\"a\u{FFFD}b\"");
        assert!(quoted(&[b'x'; 5000]).chars().count() < 50);
    }
}
