//! NumPy's `.npy` files: a line of text that says what the numbers are, then the numbers.
//!
//! *How it works.* The header is a Python dictionary of three entries, `descr`, `fortran_order` and `shape`. Only plain
//! arrays of numbers are read, so a parser of three kinds of value is enough, and it can promise what a general one
//! does not: no header makes it recurse, overflow, or allocate more than the header's own size.
//!
//! *Source.* NumPy Enhancement Proposal 1, *A Simple File Format for NumPy Arrays*.

use std::fmt;

/// The first bytes of every file.
const MAGIC: &[u8] = b"\x93NUMPY";
/// NumPy itself refuses to read longer headers from strangers.
const LONGEST_HEADER: usize = 10_000;

/// What the bytes after the header are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// NumPy's name for the type of a number, such as `<f4`.
    pub descr: String,
    /// Whether the first index runs fastest.
    pub fortran_order: bool,
    /// The length along each axis.
    pub shape: Vec<u64>,
}

impl Header {
    /// Reads a header; returns it with the bytes after it.
    ///
    /// # Errors
    /// What is wrong with it, as the end of a sentence that begins with the file's name.
    pub fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        if bytes.starts_with(b"PK") {
            return Err(
                "is an .npz archive, but a single .npy array was expected (numpy.save writes one)"
                    .to_string(),
            );
        }
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err("is not a NumPy .npy file: it does not begin with \\x93NUMPY".to_string());
        };
        let cut = || "is a NumPy file that ends within its header".to_string();
        let (length, rest) = match *rest {
            [1, 0, a, b, ref rest @ ..] => (usize::from(u16::from_le_bytes([a, b])), rest),
            [2 | 3, 0, a, b, c, d, ref rest @ ..] => {
                (u32::from_le_bytes([a, b, c, d]) as usize, rest)
            }
            [major, minor, ..] if !matches!((major, minor), (1..=3, 0)) => {
                return Err(format!(
                    "is a NumPy file of version {major}.{minor}, but 1.0 to 3.0 were expected"
                ));
            }
            _ => return Err(cut()),
        };
        if length > LONGEST_HEADER {
            return Err(format!(
                "has a NumPy header of {length} bytes; an array of plain numbers needs far less than {LONGEST_HEADER}"
            ));
        }
        let (text, data) = rest.split_at_checked(length).ok_or_else(cut)?;
        let header = std::str::from_utf8(text)
            .ok()
            .and_then(|text| Scanner(text).dictionary())
            .ok_or(
                "has a NumPy header that does not say descr, fortran_order and shape of a plain array of numbers",
            )?;
        Ok((header, data))
    }

    /// The bytes of a header in version 1.0, padded so that the numbers begin at a multiple of 64.
    pub fn to_bytes(&self) -> Vec<u8> {
        let fortran_order = if self.fortran_order { "True" } else { "False" };
        let mut text = format!(
            "{{'descr': '{}', 'fortran_order': {fortran_order}, 'shape': {}, }}",
            self.descr,
            Shape(&self.shape)
        );
        let before = MAGIC.len() + 4;
        let end = (before + text.len() + 1).next_multiple_of(64);
        text.extend(std::iter::repeat_n(' ', end - 1 - before - text.len()));
        text.push('\n');
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes
    }
}

/// A shape as Python writes it.
pub struct Shape<'a>(pub &'a [u64]);

impl fmt::Display for Shape<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            [one] => write!(f, "({one},)"),
            all => {
                f.write_str("(")?;
                for (i, n) in all.iter().enumerate() {
                    write!(f, "{}{n}", if i > 0 { ", " } else { "" })?;
                }
                f.write_str(")")
            }
        }
    }
}

/// The rest of a header's text.
struct Scanner<'a>(&'a str);

impl<'a> Scanner<'a> {
    fn dictionary(mut self) -> Option<Header> {
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        self.mark('{')?;
        while self.mark('}').is_none() {
            let key = self.string()?;
            self.mark(':')?;
            match key {
                "descr" => descr = Some(self.string()?.to_string()),
                "fortran_order" => fortran_order = Some(self.boolean()?),
                "shape" => shape = Some(self.tuple()?),
                _ => return None,
            }
            if self.mark(',').is_none() {
                self.mark('}')?;
                break;
            }
        }
        self.0.trim_ascii().is_empty().then_some(())?;
        Some(Header {
            descr: descr?,
            fortran_order: fortran_order?,
            shape: shape?,
        })
    }

    fn mark(&mut self, mark: char) -> Option<()> {
        self.0 = self.0.trim_ascii_start().strip_prefix(mark)?;
        Some(())
    }

    fn string(&mut self) -> Option<&'a str> {
        let quote = if self.mark('\'').is_some() {
            '\''
        } else {
            self.mark('"').map(|()| '"')?
        };
        let (string, rest) = self.0.split_once(quote)?;
        self.0 = rest;
        Some(string)
    }

    fn boolean(&mut self) -> Option<bool> {
        self.0 = self.0.trim_ascii_start();
        for (word, value) in [("True", true), ("False", false)] {
            if let Some(rest) = self.0.strip_prefix(word) {
                self.0 = rest;
                return Some(value);
            }
        }
        None
    }

    fn tuple(&mut self) -> Option<Vec<u64>> {
        let mut numbers = Vec::new();
        self.mark('(')?;
        while self.mark(')').is_none() {
            numbers.push(self.number()?);
            if self.mark(',').is_none() {
                self.mark(')')?;
                break;
            }
        }
        Some(numbers)
    }

    fn number(&mut self) -> Option<u64> {
        let text = self.0.trim_ascii_start();
        let end = text
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(text.len());
        // Python 2 wrote long integers with an L.
        self.0 = text[end..].strip_prefix('L').unwrap_or(&text[end..]);
        text[..end].parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(text: &str) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes
    }

    #[test]
    fn what_is_written_is_read() {
        for shape in [vec![], vec![0], vec![7], vec![3, 6], vec![u64::MAX, 2, 9]] {
            let header = Header {
                descr: "<f4".to_string(),
                fortran_order: shape.len() == 2,
                shape,
            };
            let mut bytes = header.to_bytes();
            assert!(bytes.len().is_multiple_of(64));
            bytes.extend([1, 2]);
            assert_eq!(Header::read(&bytes), Ok((header, &[1, 2][..])));
        }
    }

    #[test]
    fn other_hands_are_read() {
        for text in [
            "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 6), }\n",
            "{\"shape\":(2L,6L),\"fortran_order\":False,\"descr\":\"<f8\"}",
        ] {
            let bytes = header(text);
            let (read, rest) = Header::read(&bytes).expect("a good header");
            assert_eq!((read.descr.as_str(), read.shape), ("<f8", vec![2, 6]));
            assert!(rest.is_empty());
        }
    }

    #[test]
    fn nonsense_is_refused_in_a_sentence() {
        let refused = |bytes: &[u8]| Header::read(bytes).expect_err("nonsense");
        assert_eq!(
            refused(b""),
            "is not a NumPy .npy file: it does not begin with \\x93NUMPY"
        );
        assert!(refused(b"PK\x03\x04").starts_with("is an .npz archive"));
        assert!(refused(b"\x93NUMPY\x09\x01ab").contains("version 9.1"));
        assert!(refused(b"\x93NUMPY\x01\x00").contains("ends within its header"));
        assert!(refused(b"\x93NUMPY\x01\x00\x76\x00{'de").contains("ends within its header"));
        assert!(
            refused(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{").contains("header of 4294967295 bytes")
        );
        for text in [
            "",
            "{",
            "{}",
            "{'descr': '<f4', 'fortran_order': False}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 6)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999, 6)}",
            "{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (1, 6)}",
            "{'descr': '<f4', 'fortran_order': 0, 'shape': (1, 6)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 6)} + 1",
            &"(".repeat(9_999),
        ] {
            assert!(
                refused(&header(text)).contains("descr, fortran_order and shape"),
                "{text}"
            );
        }
    }
}
