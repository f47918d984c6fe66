//! What a file's bytes are: JSON text, or a GLB container with JSON and binary data inside.
//!
//! *Source.* glTF 2.0, section 4, *GLB File Format Specification*.

use crate::error::Place;

/// The parts of a file.
#[derive(Debug)]
pub struct Parts<'a> {
    /// UTF-8 text.
    pub json: &'a [u8],
    /// The data of buffer 0, when the container brings it along.
    pub binary: Option<&'a [u8]>,
    /// Whether the text stood alone, so that its line numbers mean something to a reader.
    pub is_text: bool,
}

const MAGIC: &[u8] = b"glTF";
const JSON: [u8; 4] = *b"JSON";
const BIN: [u8; 4] = *b"BIN\0";

/// Finds the parts.
///
/// # Errors
/// Where the container's own numbers contradict the bytes, and how.
pub fn split(bytes: &[u8]) -> Result<Parts<'_>, (Place, String)> {
    if !bytes.starts_with(MAGIC) {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if json.trim_ascii().is_empty() {
            return Err((
                Place::File,
                "the file is empty; JSON or GLB expected".to_owned(),
            ));
        }
        return Ok(Parts {
            json,
            binary: None,
            is_text: true,
        });
    }
    let word = |at: usize| {
        let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(bytes))
    };
    let cut = |at: usize, what: &str| {
        let problem = format!("the file ends within {what}, after {} bytes", bytes.len());
        (Place::Byte(at as u64), problem)
    };
    match word(4) {
        None => return Err(cut(4, "the GLB header")),
        Some(2) => {}
        Some(version) => {
            let problem = format!("GLB version {version} is not known; 2 expected");
            return Err((Place::Byte(4), problem));
        }
    }
    let length = word(8).ok_or_else(|| cut(8, "the GLB header"))? as usize;
    if length > bytes.len() {
        let problem = format!(
            "the header says that the file has {length} bytes, but it ends after {}",
            bytes.len()
        );
        return Err((Place::Byte(8), problem));
    }

    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    // Bytes after the stated length, and chunks of other kinds, are to be passed over.
    while at + 8 <= length && (json.is_none() || binary.is_none()) {
        let size = word(at).ok_or_else(|| cut(at, "a chunk header"))? as usize;
        let kind = &bytes[at + 4..at + 8];
        let data = &bytes[at + 8..length];
        let Some(data) = data.get(..size) else {
            let problem = format!(
                "the chunk says that it has {size} bytes, but only {} follow",
                data.len()
            );
            return Err((Place::Byte(at as u64), problem));
        };
        match json {
            None if kind != JSON => {
                let problem = "the first chunk is not JSON, as it must be".to_owned();
                return Err((Place::Byte(at as u64 + 4), problem));
            }
            None => json = Some(data),
            Some(_) if kind == BIN => binary = Some(data),
            Some(_) => {}
        }
        // Chunks begin at multiples of four.
        at += 8 + size.next_multiple_of(4);
    }
    let json = json.ok_or_else(|| cut(12, "the header of the JSON chunk"))?;
    // Blanks pad the chunk; some writers pad with zeros.
    let end = json.iter().rposition(|&byte| byte != 0);
    Ok(Parts {
        json: &json[..end.map_or(0, |last| last + 1)],
        binary,
        is_text: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, data) in chunks {
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(*kind);
            body.extend(*data);
        }
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((body.len() as u32 + 12).to_le_bytes());
        file.extend(body);
        file
    }

    #[test]
    fn both_chunks_are_found_and_others_passed_over() {
        let file = glb(&[(b"JSON", b"{} \0"), (b"LIST", b"1234"), (b"BIN\0", b"abcd")]);
        let parts = split(&file).unwrap();
        assert_eq!(parts.json, b"{} ");
        assert_eq!(parts.binary, Some(&b"abcd"[..]));
        assert!(!parts.is_text);
    }

    #[test]
    fn text_may_begin_with_a_byte_order_mark() {
        let parts = split(b"\xef\xbb\xbf{}").unwrap();
        assert_eq!(parts.json, b"{}");
        assert!(parts.is_text);
    }

    #[test]
    fn every_cut_is_an_error_with_a_place() {
        let file = glb(&[(b"JSON", b"{}  "), (b"BIN\0", b"abcd")]);
        for length in 0..file.len() {
            let error = split(&file[..length]);
            // The first three bytes of the magic are no container yet: the JSON reader will say what it thinks.
            assert!(error.is_err() || (1..4).contains(&length), "{length}");
        }
        let first_is_binary = glb(&[(b"BIN\0", b"abcd")]);
        let (place, problem) = split(&first_is_binary).unwrap_err();
        assert_eq!(place, Place::Byte(16));
        assert!(problem.contains("not JSON"), "{problem}");
    }
}
