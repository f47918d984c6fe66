//! From JSON text to the file's tables, with the place of whatever is wrong.

use super::container::Parts;
use super::schema::{Head, Root};
use crate::SceneError;
use crate::error::Place;
use serde::de::DeserializeOwned;
use serde_json::error::Category;

/// Required extensions that the loader understands.
const UNDERSTOOD: &[&str] = &[
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions without which the scene is whole, if plainer: no one need be told that they are passed over.
const ADORNMENTS: &[&str] = &[
    "KHR_animation_pointer",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_variants",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Reads the tables and turns away what this loader cannot read at all.
pub fn parse(parts: &Parts<'_>, name: &str) -> Result<Root, SceneError> {
    let head: Head = structure(parts, name)?;
    // A file may work with an older version than the one it was made for.
    let version = head.asset.min_version.unwrap_or(head.asset.version);
    let unsupported = |path: &str, what: String| SceneError::Unsupported {
        file: name.to_owned(),
        place: Place::Path(path.to_owned()),
        what,
    };
    if version != "2.0" && version.split('.').next() != Some("2") {
        let version: String = version.chars().take(20).collect();
        return Err(unsupported("asset.version", format!("glTF {version}")));
    }
    let root: Root = structure(parts, name)?;
    for (number, extension) in root.extensions_required.iter().enumerate() {
        let extension = &**extension;
        if !UNDERSTOOD.contains(&extension) && !ADORNMENTS.contains(&extension) {
            let path = format!("extensionsRequired[{number}]");
            return Err(unsupported(&path, format!("the extension {extension}")));
        }
    }
    Ok(root)
}

/// The extensions in use that nothing here knows, as far as the file declares them.
pub fn unknown_extensions(root: &Root) -> impl Iterator<Item = (usize, &str)> {
    let used = root.extensions_used.iter().map(|name| &**name).enumerate();
    used.filter(|(_, name)| !UNDERSTOOD.contains(name) && !ADORNMENTS.contains(name))
}

fn structure<T: DeserializeOwned>(parts: &Parts<'_>, name: &str) -> Result<T, SceneError> {
    let mut deserializer = serde_json::Deserializer::from_slice(parts.json);
    let malformed = |path: String, error: serde_json::Error| {
        let text = error.to_string();
        let position = format!(" at line {} column {}", error.line(), error.column());
        let what = text.strip_suffix(&position).unwrap_or(&text);
        // The parser's names for things are not those of JSON.
        let what = what
            .replace("invalid type: map", "invalid type: object")
            .replace("invalid type: sequence", "invalid type: array")
            .replace("expected a sequence", "expected an array");
        let is_syntax = error.classify() != Category::Data || path == ".";
        let (place, problem) = match (is_syntax, parts.is_text) {
            (true, true) => {
                let problem = format!("not JSON as expected: {what} (column {})", error.column());
                (Place::Line(error.line()), problem)
            }
            (true, false) => {
                let problem = format!(
                    "not JSON as expected: {what} (line {}, column {} of the JSON chunk)",
                    error.line(),
                    error.column()
                );
                (Place::File, problem)
            }
            (false, true) => {
                let problem = format!("{what} (line {}, column {})", error.line(), error.column());
                (Place::Path(path), problem)
            }
            (false, false) => (Place::Path(path), what),
        };
        SceneError::Malformed {
            file: name.to_owned(),
            place,
            problem,
        }
    };
    let value = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let path = error.path().to_string();
        malformed(path, error.into_inner())
    })?;
    deserializer
        .end()
        .map_err(|e| malformed(".".to_owned(), e))?;
    Ok(value)
}
