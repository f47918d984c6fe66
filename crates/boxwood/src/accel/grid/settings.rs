//! The settings of grids as text.

use crate::accel::settings::Value;
use alloc::format;
use alloc::string::{String, ToString};

/// How many cells a grid has for each primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// So many; the textbook's number is 27, a cube of three by three by three.
    PerPrimitive(f32),
    /// So many as trace fastest, by measurement on scanned models and buildings: 64 while the bits of all cells fit into a
    /// second-level cache (2²⁴ cells, 2 MB), and never fewer than 27.
    Auto,
}

/// More cells for each primitive make no sense, whatever is asked for.
const MOST: f32 = 1.0e6;

impl Density {
    /// How many cells there are for some primitives.
    pub(super) fn cells(self, primitives: usize) -> f64 {
        let n = primitives as f64;
        match self {
            Self::PerPrimitive(density) if density >= 0.0 => f64::from(density.min(MOST)) * n,
            // NaN as well.
            Self::PerPrimitive(_) => 0.0,
            Self::Auto => (64.0 * n).min((27.0 * n).max(f64::from(1 << 24))),
        }
    }
}

impl Value for &mut Density {
    fn read(&mut self, text: &str) -> bool {
        let read = match text {
            "auto" => Some(Density::Auto),
            _ => text
                .parse()
                .ok()
                .filter(|density| (0.0..=MOST).contains(density))
                .map(Density::PerPrimitive),
        };
        read.map(|density| **self = density).is_some()
    }
    fn write(&self) -> String {
        match self {
            Density::PerPrimitive(density) => density.to_string(),
            Density::Auto => "auto".into(),
        }
    }
    fn expected(&self) -> String {
        format!("auto or 0…{MOST}")
    }
}

/// How many cells there are on each axis, up to a largest number: `64x64x16`, or `any` where the density decides.
pub(super) struct CutIn<'a>(pub &'a mut Option<[u32; 3]>, pub u32);

impl Value for CutIn<'_> {
    fn read(&mut self, text: &str) -> bool {
        if text == "any" {
            *self.0 = None;
            return true;
        }
        let mut parts = [0; 3];
        let mut texts = text.split('x');
        for part in &mut parts {
            match texts.next().and_then(|text| text.parse().ok()) {
                Some(n) if (1..=self.1).contains(&n) => *part = n,
                _ => return false,
            }
        }
        *self.0 = Some(parts);
        texts.next().is_none()
    }
    fn write(&self) -> String {
        match &*self.0 {
            &Some([x, y, z]) => format!("{x}x{y}x{z}"),
            None => "any".into(),
        }
    }
    fn expected(&self) -> String {
        "any or XxYxZ".into()
    }
}

#[cfg(test)]
mod tests {
    use crate::StructureKind;

    #[test]
    fn settings_go_both_ways() {
        for text in [
            "grid",
            "grid:c=auto",
            "grid:c=2.5",
            "grid:resolution=1x20x300,axes=xy",
        ] {
            let kind: StructureKind = text.parse().expect("a good name");
            assert_eq!(kind.to_string(), text);
        }
        assert_eq!(
            "grid:c=27,resolution=any".parse::<StructureKind>(),
            "grid".parse()
        );
        for text in [
            "c=-1",
            "c=NaN",
            "c=",
            "resolution=1x1",
            "resolution=0x1x1",
            "resolution=1x1x1x1",
        ] {
            assert!(
                format!("grid:{text}").parse::<StructureKind>().is_err(),
                "{text}"
            );
        }
    }
}
