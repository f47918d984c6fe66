//! A texture statement of MTL: options, then a file name that may hold blanks.

use super::cursor::{Cursor, quoted};
use crate::{TextureMap, Wrap};

/// What stands behind `map_Kd` and the like.
#[derive(Debug, PartialEq)]
pub(super) struct MapStatement {
    /// The image as the file names it.
    pub(super) name: String,
    /// `-s` and `-o`: texture coordinates (with `v` up) times `scale` plus `offset`.
    scale: [f32; 2],
    offset: [f32; 2],
    is_clamped: bool,
    /// `-bm`: the strength of a bump or normal map.
    pub(super) strength: f32,
}

impl MapStatement {
    /// Reads the rest of a line; a sentence when there is no file name or an option is not as it should be.
    pub(super) fn read(cursor: &mut Cursor) -> Result<Self, String> {
        let mut map = Self {
            name: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            is_clamped: false,
            strength: 1.0,
        };
        while cursor.peek_word().first() == Some(&b'-') {
            let option = cursor.peek_word();
            match option {
                b"-s" | b"-o" | b"-t" => {
                    cursor.word();
                    let mut values = match option {
                        b"-s" => map.scale,
                        _ => map.offset,
                    };
                    *values.first_mut().unwrap_or(&mut 0.0) = number(cursor, option)?;
                    // The second and the third may be left out; the third is for solid textures.
                    if let Some(v) = optional_number(cursor) {
                        values[1] = v;
                        optional_number(cursor);
                    }
                    match option {
                        b"-s" => map.scale = values,
                        b"-o" => map.offset = values,
                        // Turbulence.
                        _ => {}
                    }
                }
                b"-bm" => {
                    cursor.word();
                    map.strength = number(cursor, option)?;
                }
                b"-mm" => {
                    cursor.word();
                    number(cursor, option)?;
                    optional_number(cursor);
                }
                b"-boost" | b"-texres" => {
                    cursor.word();
                    number(cursor, option)?;
                }
                b"-clamp" => {
                    cursor.word();
                    map.is_clamped = cursor.word() == b"on";
                }
                b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan" | b"-type" | b"-colorspace" => {
                    cursor.word();
                    cursor.word();
                }
                // A name may begin with a dash.
                _ => break,
            }
        }
        map.name = cursor.rest();
        if map.name.is_empty() {
            return Err("the name of an image was expected".to_owned());
        }
        Ok(map)
    }

    /// The image with these options. Texture coordinates of a scene have `v` down, hence the signs.
    pub(super) fn texture(&self, image: u32) -> TextureMap {
        let ([su, sv], [ou, ov]) = (self.scale, self.offset);
        TextureMap {
            transform: [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]],
            wrap: [if self.is_clamped {
                Wrap::Clamp
            } else {
                Wrap::Repeat
            }; 2],
            ..TextureMap::new(image)
        }
    }
}

fn number(cursor: &mut Cursor, option: &[u8]) -> Result<f32, String> {
    optional_number(cursor).ok_or_else(|| {
        let option = String::from_utf8_lossy(option);
        let word = quoted(cursor.peek_word());
        format!("a finite number was expected behind {option}, but {word} stands there")
    })
}

fn optional_number(cursor: &mut Cursor) -> Option<f32> {
    cursor.number().filter(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<MapStatement, String> {
        MapStatement::read(&mut Cursor::new(line.as_bytes()))
    }

    #[test]
    fn options_stand_before_a_name_with_blanks() {
        let map = read("-s 2 3 1 -o .25 -clamp on -bm 0.5 -imfchan r my 2 maps.png ").unwrap();
        assert_eq!(map.name, "my 2 maps.png");
        assert_eq!((map.scale, map.offset), ([2.0, 3.0], [0.25, 0.0]));
        assert_eq!((map.strength, map.is_clamped), (0.5, true));
        let texture = map.texture(7);
        assert_eq!((texture.image, texture.wrap), (7, [Wrap::Clamp; 2]));
    }

    #[test]
    fn scale_and_offset_count_upwards() {
        // The lowest point of the square (v up 0, v down 1) scaled by 2 and moved by 0.25 is v up 0.25, v down 0.75.
        let [_, [_, scale, offset]] = read("-s 1 2 -o 0 0.25 a.png").unwrap().texture(0).transform;
        assert_eq!(scale * 1.0 + offset, 0.75);
    }

    #[test]
    fn what_is_missing_is_named() {
        assert!(read("").unwrap_err().contains("name of an image"));
        assert!(read("-bm wood.png").unwrap_err().contains("\"wood.png\""));
        assert_eq!(read("-odd.png").unwrap().name, "-odd.png");
    }
}
