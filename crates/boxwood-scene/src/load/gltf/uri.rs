//! Where a URI leads: to data that it carries itself, or to a file beside the scene.
//!
//! *Source.* RFC 3986 (percent-encoding), RFC 2397 (data URIs).

use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

/// What a URI says.
#[derive(Debug, PartialEq)]
pub enum Target {
    /// The bytes themselves.
    Data(Vec<u8>),
    /// A file, by its path relative to the scene.
    File(String),
}

/// Writers disagree on whether the last group is filled up with `=`.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Reads a URI.
///
/// # Errors
/// Why it leads nowhere.
pub fn resolve(uri: &str) -> Result<Target, String> {
    if starts_with_ignoring_case(uri, "data:") {
        let (kind, data) = uri
            .split_once(',')
            .ok_or("the data URI has no comma before its data")?;
        return if ends_with_ignoring_case(kind, ";base64") {
            let bytes = BASE64
                .decode(data)
                .map_err(|e| format!("the data URI is not base64: {e}"))?;
            Ok(Target::Data(bytes))
        } else {
            Ok(Target::Data(percent_decode_str(data).collect()))
        };
    }
    // One letter before a colon is a drive, not a scheme, and no more welcome.
    if uri.contains("://") || uri.starts_with(['/', '\\']) || uri.get(1..2) == Some(":") {
        return Err(format!(
            "{} is not a path relative to the scene, and nothing else is read",
            shortened(uri)
        ));
    }
    if uri.is_empty() {
        return Err("the URI is empty".to_owned());
    }
    let path = percent_decode_str(uri).decode_utf8_lossy();
    Ok(Target::File(path.replace('\\', "/")))
}

/// A URI short enough for a message.
fn shortened(uri: &str) -> String {
    let mut text: String = uri.chars().take(80).collect();
    if text.len() < uri.len() {
        text.push('…');
    }
    text
}

fn starts_with_ignoring_case(text: &str, start: &str) -> bool {
    text.get(..start.len())
        .is_some_and(|head| head.eq_ignore_ascii_case(start))
}

fn ends_with_ignoring_case(text: &str, end: &str) -> bool {
    text.len()
        .checked_sub(end.len())
        .and_then(|at| text.get(at..))
        .is_some_and(|tail| tail.eq_ignore_ascii_case(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_is_decoded_with_and_without_padding() {
        let hello = Target::Data(b"hello".to_vec());
        let uri = "data:application/octet-stream;base64,aGVsbG8=";
        assert_eq!(resolve(uri), Ok(hello));
        assert_eq!(
            resolve("DATA:;BASE64,aGVsbG8"),
            Ok(Target::Data(b"hello".to_vec()))
        );
        assert_eq!(
            resolve("data:text/plain,a%20b"),
            Ok(Target::Data(b"a b".to_vec()))
        );
        assert!(resolve("data:;base64,@").unwrap_err().contains("base64"));
        assert!(resolve("data:nothing").unwrap_err().contains("comma"));
    }

    #[test]
    fn paths_are_percent_decoded_and_stay_relative() {
        assert_eq!(
            resolve("my%20textures/ä.png"),
            Ok(Target::File("my textures/ä.png".to_owned()))
        );
        assert_eq!(
            resolve(r"..\a.bin"),
            Ok(Target::File("../a.bin".to_owned()))
        );
        for uri in ["https://a.b/c.bin", "/dev/zero", "C:/a.bin", ""] {
            assert!(resolve(uri).is_err(), "{uri}");
        }
    }
}
