//! Writes tables of numbers as PLY in any of its encodings and types.

/// A property's header line without its name, such as `float` or `list uchar int`, and its name.
pub type Property<'a> = (&'a str, &'a str);

/// An element: name, properties, and for each row the values of each property.
pub struct Element<'a> {
    pub name: &'a str,
    pub properties: Vec<Property<'a>>,
    pub rows: Vec<Vec<Vec<f64>>>,
}

pub const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// The file.
pub fn encode(encoding: &str, line_end: &str, elements: &[Element<'_>]) -> Vec<u8> {
    let mut header = vec![
        "ply".to_owned(),
        format!("format {encoding} 1.0"),
        "comment end_header is not here".to_owned(),
        "obj_info num_cols 512".to_owned(),
    ];
    for element in elements {
        header.push(format!("element {} {}", element.name, element.rows.len()));
        for (kind, name) in &element.properties {
            header.push(format!("property {kind} {name}"));
        }
    }
    header.push("end_header".to_owned());
    let mut out = Vec::new();
    for line in header {
        out.extend_from_slice(line.as_bytes());
        out.extend_from_slice(line_end.as_bytes());
    }
    for element in elements {
        for row in &element.rows {
            assert_eq!(row.len(), element.properties.len());
            for ((kind, _), values) in element.properties.iter().zip(row) {
                let words: Vec<&str> = kind.split(' ').collect();
                if let ["list", count, _] = words[..] {
                    number(&mut out, encoding, count, values.len() as f64);
                }
                for value in values {
                    number(&mut out, encoding, words[words.len() - 1], *value);
                }
            }
            if encoding == "ascii" {
                out.extend_from_slice(line_end.as_bytes());
            }
        }
    }
    out
}

fn number(out: &mut Vec<u8>, encoding: &str, kind: &str, value: f64) {
    if encoding == "ascii" {
        out.extend_from_slice(format!("{value} ").as_bytes());
        return;
    }
    let mut bytes = match kind {
        "char" | "int8" => (value as i8).to_le_bytes().to_vec(),
        "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
        "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
        "ushort" | "uint16" => (value as u16).to_le_bytes().to_vec(),
        "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
        "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
        "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
        "double" | "float64" => value.to_le_bytes().to_vec(),
        _ => panic!("no type of PLY: {kind}"),
    };
    if encoding == "binary_big_endian" {
        bytes.reverse();
    }
    out.extend(bytes);
}
