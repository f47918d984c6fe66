//! The header: which elements the file promises, how many of each, and what their rows are made of.

use super::scalar::Scalar;
use crate::SceneError;
use crate::error::Place;
use crate::load::file::File;
use crate::load::text::quote;

/// How the rows are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Words, a line per row.
    Ascii,
    /// Packed, least significant byte first.
    LittleEndian,
    /// Packed, most significant byte first.
    BigEndian,
}

/// Everything before the data.
#[derive(Debug)]
pub struct Header {
    /// How the rows are written.
    pub encoding: Encoding,
    /// In the order of the data.
    pub elements: Vec<Element>,
    /// The offset of the data.
    pub end: usize,
}

/// A table of the file: `count` rows with the same properties.
#[derive(Debug)]
pub struct Element {
    /// `vertex`, `face`, or whatever the writer liked.
    pub name: String,
    /// How many rows.
    pub count: usize,
    /// The columns.
    pub properties: Vec<Property>,
    /// The header's line that introduces it.
    pub line: usize,
}

/// A column of an element.
#[derive(Debug)]
pub struct Property {
    /// `x`, `vertex_indices`, ...
    pub name: String,
    /// What a row holds of it.
    pub kind: Kind,
    /// The header's line that introduces it.
    pub line: usize,
}

/// What a row holds of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One number.
    Scalar(Scalar),
    /// A count and as many numbers.
    List {
        /// The type of the count: an integer.
        count: Scalar,
        /// The type of the numbers.
        item: Scalar,
    },
}

impl Element {
    /// The one property of this name, if there is any.
    ///
    /// # Errors
    /// When two have the name.
    pub fn property(&self, file: &File<'_>, name: &str) -> Result<Option<usize>, SceneError> {
        let mut found = (0..self.properties.len()).filter(|i| self.properties[*i].name == name);
        let first = found.next();
        match found.next() {
            None => Ok(first),
            Some(second) => Err(file.error(
                Place::Line(self.properties[second].line),
                format!(
                    "element {} has a property {} already",
                    quote(&self.name),
                    quote(name)
                ),
            )),
        }
    }

    /// How many bytes each row takes, unless it holds lists and binary rows differ.
    pub fn stride(&self) -> Option<usize> {
        let mut stride = 0;
        for property in &self.properties {
            match property.kind {
                Kind::Scalar(scalar) => stride += scalar.size(),
                Kind::List { .. } => return None,
            }
        }
        Some(stride)
    }

    /// The fewest bytes that a row can take.
    fn smallest_row(&self, encoding: Encoding) -> usize {
        let smallest = |property: &Property| match (encoding, property.kind) {
            // A digit, and a space or the end of the line.
            (Encoding::Ascii, _) => 2,
            (_, Kind::Scalar(scalar)) => scalar.size(),
            (_, Kind::List { count, .. }) => count.size(),
        };
        self.properties.iter().map(smallest).sum()
    }
}

impl Header {
    /// Reads the header.
    ///
    /// # Errors
    /// When it breaks the rules, or promises more rows than the bytes after it can hold: nothing is allocated by a
    /// count that has not passed here.
    pub fn read(file: &File<'_>) -> Result<Self, SceneError> {
        let mut lines = Lines::new(file)?;
        let mut encoding = None;
        let mut elements = Vec::new();
        loop {
            let Some(line) = lines.next() else {
                return Err(file.error(
                    file.last_line(),
                    "the file ends within the header; expected `end_header`",
                ));
            };
            match Statement::read(line, &mut elements, lines.number)
                .map_err(|problem| file.error(Place::Line(lines.number), problem))?
            {
                Statement::Format(said) => encoding = Some(said),
                Statement::Other => {}
                Statement::End => break,
            }
        }
        let Some(encoding) = encoding else {
            return Err(file.error(
                Place::Line(lines.number),
                "the header ends without a format; expected `format ascii 1.0` or a binary one",
            ));
        };
        let header = Self {
            encoding,
            elements,
            end: lines.at,
        };
        header.check_counts(file)?;
        Ok(header)
    }

    /// The element of this name that the data holds, if any.
    ///
    /// # Errors
    /// When two have the name.
    pub fn element(&self, file: &File<'_>, name: &str) -> Result<Option<usize>, SceneError> {
        let mut found = (0..self.elements.len()).filter(|i| self.elements[*i].name == name);
        let first = found.next();
        match found.next() {
            None => Ok(first),
            Some(second) => Err(file.error(
                Place::Line(self.elements[second].line),
                format!("there is an element {} already", quote(name)),
            )),
        }
    }

    /// Refuses counts that the bytes after the header cannot hold.
    fn check_counts(&self, file: &File<'_>) -> Result<(), SceneError> {
        // The last line needs no end.
        let spare = usize::from(self.encoding == Encoding::Ascii);
        let mut left = file.bytes.len() - self.end + spare;
        for element in &self.elements {
            let smallest = element
                .count
                .saturating_mul(element.smallest_row(self.encoding));
            if smallest > left {
                return Err(file.error(
                    Place::Line(element.line),
                    format!(
                        "{} rows of {} take {smallest} bytes or more, but the file has {left} left for them",
                        element.count,
                        quote(&element.name),
                    ),
                ));
            }
            left -= smallest;
        }
        Ok(())
    }
}

/// What a line of the header says, apart from elements and their properties.
enum Statement {
    Format(Encoding),
    End,
    Other,
}

impl Statement {
    /// Reads a line; an element or a property goes into the list.
    fn read(line: &[u8], elements: &mut Vec<Element>, number: usize) -> Result<Self, String> {
        // No statement has more than five words, but a comment may have millions.
        let words: Vec<&[u8]> = words(line).take(6).collect();
        match *words.as_slice() {
            [] | [b"comment" | b"obj_info", ..] => Ok(Self::Other),
            [b"end_header"] => Ok(Self::End),
            [b"format", name, version] => Ok(Self::Format(Encoding::read(name, version)?)),
            [b"element", name, count] => {
                let parsed = str::from_utf8(count).ok().and_then(|c| c.parse().ok());
                elements.push(Element {
                    name: String::from_utf8_lossy(name).into_owned(),
                    count: parsed.ok_or_else(|| {
                        format!(
                            "element {} has {} rows; expected a whole number",
                            quote(name),
                            quote(count)
                        )
                    })?,
                    properties: Vec::new(),
                    line: number,
                });
                Ok(Self::Other)
            }
            [b"property", ref kind @ .., name] => {
                let element = elements
                    .last_mut()
                    .ok_or_else(|| format!("property {} comes before any element", quote(name)))?;
                element.properties.push(Property {
                    name: String::from_utf8_lossy(name).into_owned(),
                    kind: Kind::read(kind)?,
                    line: number,
                });
                Ok(Self::Other)
            }
            _ => Err(format!(
                "{} is no line of a PLY header; expected `format NAME 1.0`, `element NAME COUNT`, \
                 `property TYPE NAME`, `comment ...` or `end_header`",
                quote(line)
            )),
        }
    }
}

impl Encoding {
    fn read(name: &[u8], version: &[u8]) -> Result<Self, String> {
        if version != b"1.0" {
            return Err(format!("version {} of PLY; expected 1.0", quote(version)));
        }
        match name {
            b"ascii" => Ok(Self::Ascii),
            b"binary_little_endian" => Ok(Self::LittleEndian),
            b"binary_big_endian" => Ok(Self::BigEndian),
            _ => Err(format!(
                "unknown format {}; expected ascii, binary_little_endian or binary_big_endian",
                quote(name)
            )),
        }
    }
}

impl Kind {
    fn read(words: &[&[u8]]) -> Result<Self, String> {
        let scalar = |word: &[u8]| {
            Scalar::of_name(word)
                .ok_or_else(|| format!("unknown type {}; expected {}", quote(word), Scalar::NAMES))
        };
        match *words {
            [b"list", count, item] => {
                let (count_type, item) = (scalar(count)?, scalar(item)?);
                if !count_type.is_integer() {
                    return Err(format!(
                        "the count of a list has type {}; expected an integer type",
                        quote(count)
                    ));
                }
                Ok(Self::List {
                    count: count_type,
                    item,
                })
            }
            [b"list", ..] => Err(
                "a list property is incomplete; expected `property list COUNT_TYPE ITEM_TYPE NAME`"
                    .to_owned(),
            ),
            [word] => Ok(Self::Scalar(scalar(word)?)),
            _ => Err("expected `property TYPE NAME`".to_owned()),
        }
    }
}

/// The lines of the header. All end as the first one does, so that binary data may begin with any byte.
struct Lines<'a> {
    bytes: &'a [u8],
    ending: &'static [u8],
    at: usize,
    number: usize,
}

impl<'a> Lines<'a> {
    fn new(file: &File<'a>) -> Result<Self, SceneError> {
        let bytes = file.bytes;
        let mut lines = Lines {
            bytes,
            ending: match bytes.iter().position(|b| matches!(b, b'\n' | b'\r')) {
                Some(at) if bytes[at] == b'\n' => b"\n",
                Some(at) if bytes.get(at + 1) == Some(&b'\n') => b"\r\n",
                _ => b"\r",
            },
            at: 0,
            number: 0,
        };
        if bytes.is_empty() {
            return Err(file.error(Place::File, "the file is empty; expected `ply`"));
        }
        if !bytes.starts_with(b"ply") || lines.next().is_none_or(|l| l.trim_ascii() != b"ply") {
            let start = bytes.split(|b| b.is_ascii_whitespace()).next();
            return Err(file.error(
                Place::Line(1),
                format!(
                    "the file begins with {}; expected `ply`",
                    quote(start.unwrap_or_default())
                ),
            ));
        }
        Ok(lines)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    /// The next line that has an end.
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        // `end_header` may be the last thing in a file without data.
        let (length, skip) = match rest
            .windows(self.ending.len())
            .position(|w| w == self.ending)
        {
            Some(length) => (length, self.ending.len()),
            None if rest.trim_ascii() == b"end_header" => (rest.len(), 0),
            None => return None,
        };
        self.at += length + skip;
        self.number += 1;
        Some(&rest[..length])
    }
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|b| b.is_ascii_whitespace())
        .filter(|word| !word.is_empty())
}
