//! Small files, written as JSON with their data inside.

use std::fmt::Write as _;

/// A file under construction: JSON without buffers, and the one buffer that goes with it.
#[derive(Clone, Default)]
pub struct File {
    pub data: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl File {
    /// Adds a buffer view; returns its number.
    pub fn view(&mut self, bytes: &[u8], more: &str) -> usize {
        let offset = self.data.len();
        self.data.extend(bytes);
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}{more}}}"#,
            bytes.len()
        ));
        self.views.len() - 1
    }

    /// Adds an accessor; returns its number.
    pub fn accessor(&mut self, json: String) -> usize {
        self.accessors.push(json);
        self.accessors.len() - 1
    }

    /// Adds an accessor of floats.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let view = self.view(&bytes, "");
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"]
            .get(N)
            .unwrap_or(&"MAT4");
        self.accessor(format!(
            r#"{{"bufferView":{view},"componentType":5126,"count":{},"type":"{kind}"}}"#,
            values.len()
        ))
    }

    /// Adds an accessor of 16-bit indices.
    pub fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, "");
        self.accessor(format!(
            r#"{{"bufferView":{view},"componentType":5123,"count":{},"type":"SCALAR"}}"#,
            values.len()
        ))
    }

    /// The JSON, with `rest` between buffers and the end.
    pub fn json(&self, buffer: &str, rest: &str) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{{buffer}"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}],{rest}}}"#,
            self.data.len(),
            self.views.join(","),
            self.accessors.join(",")
        )
    }

    /// A text file with the data in a URI.
    pub fn text(&self, rest: &str) -> String {
        self.json(&format!(r#""uri":"{}","#, data_uri(&self.data)), rest)
    }

    /// A container with the data in a chunk.
    pub fn glb(&self, rest: &str) -> Vec<u8> {
        let mut json = self.json("", rest).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut data = self.data.clone();
        data.resize(data.len().next_multiple_of(4), 0);
        let length = 12 + 8 + json.len() + 8 + data.len();
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((length as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", json), (b"BIN\0", data)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }
}

/// One triangle, its positions in accessor 0.
pub fn triangle() -> File {
    let mut file = File::default();
    file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    file
}

/// One mesh of accessor 0 on one node; `more` is added to the JSON.
pub fn one_mesh(more: &str) -> String {
    format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]{more}"#
    )
}

pub fn data_uri(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut uri = "data:application/octet-stream;base64,".to_owned();
    for group in bytes.chunks(3) {
        let word = group.iter().enumerate();
        let word = word.fold(0_u32, |word, (i, &b)| word | u32::from(b) << (16 - 8 * i));
        for digit in 0..4 {
            if digit <= group.len() {
                uri.push(char::from(DIGITS[(word >> (18 - 6 * digit)) as usize & 63]));
            } else {
                uri.write_char('=').unwrap();
            }
        }
    }
    uri
}
