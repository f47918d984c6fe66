//! Values of flags that are more than a word or a number.

use std::convert::Infallible;
use std::ffi::OsString;
use std::path::PathBuf;
use std::str::FromStr;

/// The longest side of a picture that is accepted at all.
const LONGEST_SIDE: u32 = 32_768;
/// And the most pixels.
const MOST_PIXELS: u64 = 1 << 28;

/// Width and height in pixels, as `1280x720`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |side: &str| side.trim().parse::<u64>().ok();
        let Some((Some(width), Some(height))) = text
            .split_once(['x', 'X', '×'])
            .map(|(w, h)| (side(w), side(h)))
        else {
            return Err("expected a width and a height, such as 1280x720".to_string());
        };
        if width == 0 || height == 0 {
            return Err("a picture without pixels cannot be made".to_string());
        }
        let longest = u64::from(LONGEST_SIDE);
        if width > longest || height > longest || width * height > MOST_PIXELS {
            return Err(format!(
                "too large: a side may have {LONGEST_SIDE} pixels, the whole picture {MOST_PIXELS}"
            ));
        }
        Ok(Self([width as u32, height as u32]))
    }
}

/// A point or a direction, as `X,Y,Z` or `"X Y Z"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector(pub [f32; 3]);

impl FromStr for Vector {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected three numbers, such as 1,-2.5,3".to_string();
        let numbers: Vec<&str> = if text.contains(',') {
            text.split(',').map(str::trim).collect()
        } else {
            text.split_whitespace().collect()
        };
        let [x, y, z] = numbers[..] else {
            return Err(expected());
        };
        let number = |text: &str| text.parse::<f32>().map_err(|_| expected());
        let vector = [number(x)?, number(y)?, number(z)?];
        if vector.iter().all(|x| x.is_finite()) {
            Ok(Self(vector))
        } else {
            Err("its numbers must be finite".to_string())
        }
    }
}

/// An axis by its letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis(pub usize);

impl Axis {
    /// x, y or z.
    pub fn letter(self) -> &'static str {
        ["x", "y", "z"][self.0]
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = ["x", "y", "z"].iter().position(|axis| *axis == text);
        found
            .map(Self)
            .ok_or_else(|| "expected x, y or z".to_string())
    }
}

/// A plane across an axis, as `z=0.5` or `z=50%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    pub axis: Axis,
    pub place: Place,
}

/// Where on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// In the scene's units.
    At(f32),
    /// From 0 at the scene's lower end to 1 at its upper.
    Share(f32),
}

impl FromStr for Slice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected an axis and a place, such as z=0.5 or y=50%".to_string();
        let (axis, place) = text.split_once('=').ok_or_else(expected)?;
        let number = |text: &str| text.parse().ok().filter(|x: &f32| x.is_finite());
        let place = match place.strip_suffix('%') {
            Some(percent) => number(percent).map(|x| Place::Share(x / 100.0)),
            None => number(place).map(Place::At),
        };
        Ok(Self {
            axis: axis.parse().map_err(|_| expected())?,
            place: place.ok_or_else(expected)?,
        })
    }
}

/// Levels of a tree, both ends included: `2..5`, `3`, `..4`, `6..`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    pub first: u32,
    pub last: u32,
}

impl Levels {
    pub const ALL: Self = Self {
        first: 0,
        last: u32::MAX,
    };

    pub fn contain(self, level: u32) -> bool {
        (self.first..=self.last).contains(&level)
    }
}

impl FromStr for Levels {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected levels, such as 2..5, 3, ..4 or 6..".to_string();
        let number = |text: &str, otherwise: u32| match text {
            "" => Ok(otherwise),
            text => text.parse().map_err(|_| expected()),
        };
        let (first, last) = match text.split_once("..") {
            Some((first, last)) => (number(first, 0)?, number(last, u32::MAX)?),
            None => {
                let level = text.parse().map_err(|_| expected())?;
                (level, level)
            }
        };
        if first <= last {
            Ok(Self { first, last })
        } else {
            Err(expected())
        }
    }
}

/// A pixel, as `X,Y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixel(pub [u32; 2]);

impl FromStr for Pixel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected a column and a row, such as 640,360".to_string();
        let (x, y) = text.split_once(',').ok_or_else(expected)?;
        let number = |text: &str| text.trim().parse().map_err(|_| expected());
        Ok(Self([number(x)?, number(y)?]))
    }
}

/// A ray as six numbers: origin and direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpelledRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
}

impl FromStr for SpelledRay {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected an origin and a direction, such as 0,0,5,0,0,-1".to_string();
        let numbers: Result<Vec<f32>, _> = text.split(',').map(|x| x.trim().parse()).collect();
        let numbers = numbers.map_err(|_| expected())?;
        let [ox, oy, oz, dx, dy, dz] = numbers[..] else {
            return Err(expected());
        };
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err("its numbers must be finite".to_string());
        }
        if [dx, dy, dz] == [0.0; 3] {
            return Err("a ray needs a direction, and 0,0,0 is none".to_string());
        }
        Ok(Self {
            origin: [ox, oy, oz],
            direction: [dx, dy, dz],
        })
    }
}

/// An angle between 0 and 180 degrees.
pub fn fov(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err("expected an angle between 0 and 180 degrees".to_string()),
    }
}

/// An amount of memory in bytes: `65536`, `512M`, `1.5GiB`. K, M and G are powers of 1024.
pub fn memory(text: &str) -> Result<usize, String> {
    const EXPECTED: &str = "expected an amount of memory, such as 512M or 2G";
    let digits = text
        .find(|c: char| !(c.is_ascii_digit() || c == '.'))
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let shift = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 0,
        "k" | "kb" | "kib" => 10,
        "m" | "mb" | "mib" => 20,
        "g" | "gb" | "gib" => 30,
        _ => return Err(EXPECTED.to_string()),
    };
    match number.parse::<f64>() {
        Ok(n) if n > 0.0 => Ok((n * f64::from(1_u32 << shift)) as usize),
        _ => Err(EXPECTED.to_string()),
    }
}

/// An exposure.
pub fn stops(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(stops) if stops.abs() <= 64.0 => Ok(stops),
        _ => Err("expected a number of stops from -64 to 64".to_string()),
    }
}

/// A radius.
pub fn radius(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(radius) if radius >= 0.0 => Ok(radius),
        _ => Err("expected a length that is not negative".to_string()),
    }
}

/// A folder; the empty one stands for the usual one.
pub fn folder(text: &str) -> Result<PathBuf, Infallible> {
    Ok(PathBuf::from(text))
}

/// Joins `--eye 1 2 3` to `--eye 1,2,3`: three numbers after a flag that wants a vector are its value. Anything else stays
/// as it is.
pub fn join_vectors(args: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut rest: Vec<OsString> = args.into_iter().collect();
    let mut joined = Vec::with_capacity(rest.len());
    while !rest.is_empty() {
        let is_flag = ["--eye", "--look-at", "--up"]
            .iter()
            .any(|flag| rest[0] == *flag);
        let numbers: Vec<&str> = rest[1..]
            .iter()
            .take(3)
            .filter_map(|arg| arg.to_str().filter(|text| text.parse::<f32>().is_ok()))
            .collect();
        let value = (is_flag && numbers.len() == 3).then(|| numbers.join(","));
        if rest[0] == "--" {
            joined.append(&mut rest);
        } else if let Some(value) = value {
            joined.extend(rest.drain(..4).take(1));
            joined.push(value.into());
        } else {
            joined.push(rest.remove(0));
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        for text in ["1280x720", "1280X720", "1280×720", "1280 x 720"] {
            assert_eq!(text.parse(), Ok(Size([1280, 720])));
        }
        for text in ["", "x", "1280", "1280x", "-1x5", "1.5x2", "1x2x3"] {
            let error = text.parse::<Size>().expect_err(text);
            assert_eq!(error, "expected a width and a height, such as 1280x720");
        }
        assert!(
            "0x5"
                .parse::<Size>()
                .expect_err("zero")
                .contains("without pixels")
        );
        for text in ["32769x1", "1x99999999999", "32768x32768"] {
            assert!(
                text.parse::<Size>()
                    .expect_err(text)
                    .starts_with("too large")
            );
        }
        assert_eq!("32768x8192".parse(), Ok(Size([32_768, 8192])));
    }

    #[test]
    fn vectors() {
        for text in ["1,-2.5,3e1", "1, -2.5, 3e1", "1 -2.5 3e1"] {
            assert_eq!(text.parse(), Ok(Vector([1.0, -2.5, 30.0])));
        }
        for text in ["", "1", "1,2", "1,2,3,4", "a,b,c", "1,,3"] {
            assert!(
                text.parse::<Vector>()
                    .expect_err(text)
                    .contains("three numbers")
            );
        }
        for text in ["1,2,inf", "nan,0,0", "1e99,0,0"] {
            assert!(text.parse::<Vector>().expect_err(text).contains("finite"));
        }
    }

    #[test]
    fn angles_and_stops() {
        assert_eq!(fov("45"), Ok(45.0));
        for text in ["0", "180", "-1", "nan", "wide"] {
            assert!(fov(text).is_err());
        }
        assert_eq!(stops("-1.5"), Ok(-1.5));
        for text in ["nan", "inf", "bright", "65"] {
            assert!(stops(text).is_err());
        }
    }

    #[test]
    fn planes_levels_pixels_and_rays() {
        let (x, z) = (Axis(0), Axis(2));
        for (text, axis, place) in [
            ("z=0.5", z, Place::At(0.5)),
            ("x=-2", x, Place::At(-2.0)),
            ("z=25%", z, Place::Share(0.25)),
        ] {
            assert_eq!(text.parse(), Ok(Slice { axis, place }));
        }
        for text in ["", "z", "w=1", "z=", "z=%", "z=inf", "z=1=2"] {
            assert!(text.parse::<Slice>().is_err(), "{text}");
        }
        for (text, first, last) in [
            ("2..5", 2, 5),
            ("3", 3, 3),
            ("..4", 0, 4),
            ("6..", 6, u32::MAX),
        ] {
            assert_eq!(text.parse(), Ok(Levels { first, last }));
        }
        for text in ["", "5..2", "a", "1..b", "-1"] {
            assert!(text.parse::<Levels>().is_err(), "{text}");
        }
        assert_eq!("3, 4".parse(), Ok(Pixel([3, 4])));
        for text in ["", "3", "3,4,5", "-1,2", "1.5,2"] {
            assert!(text.parse::<Pixel>().is_err(), "{text}");
        }
        assert!("0,0,5, 0,0,-1".parse::<SpelledRay>().is_ok());
        for text in ["", "1,2,3", "0,0,0,0,0,0", "0,0,nan,1,0,0", "1,2,3,4,5,6,7"] {
            assert!(text.parse::<SpelledRay>().is_err(), "{text}");
        }
    }

    #[test]
    fn amounts_of_memory() {
        for (text, bytes) in [
            ("65536", 65_536),
            ("1k", 1024),
            ("1.5MiB", 1_572_864),
            ("2 GB", 2 << 30),
        ] {
            assert_eq!(memory(text), Ok(bytes));
        }
        for text in ["", "0", "-1", "much", "1T", "1.2.3M"] {
            assert!(memory(text).is_err(), "{text}");
        }
    }

    #[test]
    fn three_numbers_become_a_vector() {
        let join = |line: &str| {
            let joined = join_vectors(line.split(' ').map(OsString::from));
            let words: Vec<_> = joined.iter().map(|w| w.to_str().expect("ascii")).collect();
            words.join(" ")
        };
        for (line, joined) in [
            ("b render --eye 1 -2 3 s.obj", "b render --eye 1,-2,3 s.obj"),
            (
                "b --eye 1,2,3 --look-at 4 5 6",
                "b --eye 1,2,3 --look-at 4,5,6",
            ),
            ("b --eye 1,2,3 4 5 6", "b --eye 1,2,3 4 5 6"),
            ("b --eye 1 2 s.obj", "b --eye 1 2 s.obj"),
            ("b --eye", "b --eye"),
            ("b --fov 1 2 3", "b --fov 1 2 3"),
            ("b -- --eye 1 2 3", "b -- --eye 1 2 3"),
        ] {
            assert_eq!(join(line), joined);
        }
    }
}
