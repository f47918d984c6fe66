//! One setting from one end to the other: where is the best, and how flat is the valley?
//!
//! *How it works.* A family knows what to change and by which texts of [`StructureKind`]; texts that a structure does not
//! understand (a builder without leaves, a number beyond its range) make no point. Each point is built, checked, timed and
//! dropped before the next, so that only one takes memory.

use super::report::{Curve, Measured, Point, Structure, Sweep};
use super::text::round;
use super::{Candidate, Job, Workload, build, compare_with};
use crate::failure::{Failure, Outcome};
use boxwood::StructureKind;
use std::collections::BTreeSet;
use std::str::FromStr;

/// Structures that share a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Grid,
    Kd,
    Bvh,
}

/// The most memory of a point, unless the user says otherwise.
pub const MEMORY: usize = 2 << 30;
/// Cells beyond which a grid is finer than anybody wants.
const MOST_CELLS: f64 = (1 << 27) as f64;
/// And cells per triangle.
const FINEST: f64 = 1e4;
/// The lecture's cells per triangle, and its triangles in a leaf.
const LECTURE_CELLS: f64 = 27.0;
const LECTURE_LEAF: f64 = 5.0;
const LEAVES: [usize; 13] = [1, 2, 3, 4, 5, 6, 8, 12, 16, 24, 32, 48, 64];

impl Family {
    /// Those of which there are structures.
    pub fn there() -> impl Iterator<Item = Self> {
        [Self::Grid, Self::Kd, Self::Bvh]
            .into_iter()
            .filter(|family| family.members().next().is_some())
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Kd => "kd",
            Self::Bvh => "bvh",
        }
    }

    /// Its structures.
    fn members(self) -> impl Iterator<Item = StructureKind> {
        StructureKind::all().filter(move |kind| self.holds(kind))
    }

    fn holds(self, kind: &StructureKind) -> bool {
        match self {
            Self::Grid => kind.name() == "grid",
            Self::Kd => kind.name().starts_with("kd:"),
            Self::Bvh => kind.name().starts_with("bvh:"),
        }
    }

    /// What is swept: all of it, or what `--accel` names.
    ///
    /// # Errors
    /// A sentence when a named structure belongs elsewhere.
    pub fn chosen(self, named: &[StructureKind]) -> Outcome<Vec<StructureKind>> {
        match named.iter().find(|kind| !self.holds(kind)) {
            Some(other) => Err(Failure::new(format!(
                "{other} is not of the family {}, which is swept",
                self.name()
            ))),
            None if named.is_empty() => Ok(self.members().collect()),
            None => Ok(named.to_vec()),
        }
    }

    /// What is made of a member with its other settings: values and structures.
    fn points(self, member: StructureKind, triangles: usize) -> Vec<(f64, StructureKind)> {
        let member = member.to_string();
        let mark = if member.contains(':') { ',' } else { ':' };
        let settings: Vec<(f64, String)> = match self {
            Self::Grid => cells_per_triangle(triangles),
            Self::Kd | Self::Bvh => LEAVES
                .iter()
                .map(|&leaf| (leaf as f64, format!("leaf={leaf}")))
                .collect(),
        };
        let parse = |(value, setting): (f64, String)| {
            let kind = format!("{member}{mark}{setting}").parse().ok()?;
            Some((value, kind))
        };
        settings.into_iter().filter_map(parse).collect()
    }
}

impl FromStr for Family {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::there().find(|family| family.name() == text);
        found.ok_or_else(|| format!("no family is called `{text}`"))
    }
}

/// From one cell to far too many, the lecture's choice among them.
fn cells_per_triangle(triangles: usize) -> Vec<(f64, String)> {
    let n = triangles.max(1) as f64;
    let most = (MOST_CELLS / n).clamp(2.0 * LECTURE_CELLS, FINEST);
    let mut points = vec![(1.0 / n, "resolution=1x1x1".to_string())];
    // Powers of two times the lecture's number, which is one of them, in three digits.
    for k in -20..=20 {
        let text = round(LECTURE_CELLS * f64::from(k).exp2());
        let Ok(c) = text.parse::<f64>() else { continue };
        if c > 4.0 / n && c <= most {
            points.push((c, format!("c={text}")));
        }
    }
    points
}

impl Job<'_> {
    /// Measures a family's structures along their setting.
    pub(super) fn sweep(
        &self,
        family: Family,
        workloads: &[Workload],
        judge: Option<&Measured>,
    ) -> Outcome<Sweep> {
        let mut curves = Vec::new();
        for member in family.chosen(&self.args.accel)? {
            let mut points: Vec<Point> = Vec::new();
            let mut seen = BTreeSet::new();
            for (value, kind) in family.points(member, self.mesh.triangles().len()) {
                if !seen.insert(kind.to_string()) {
                    continue;
                }
                let candidate = Candidate(kind, build::build(kind, self.mesh, self.memory())?);
                let mut found = self.measure(&[candidate], workloads)?;
                for structure in &mut found {
                    if let (Some(m), Some(judge)) = (&mut structure.measured, judge) {
                        compare_with(m, judge);
                    }
                }
                points.extend(
                    found
                        .into_iter()
                        .map(|structure| Point { value, structure }),
                );
            }
            if !points.is_empty() {
                let best = best(&points);
                let name = member.to_string();
                curves.push(Curve { name, best, points });
            }
        }
        let (setting, lecture) = match family {
            Family::Grid => ("cells per triangle", LECTURE_CELLS),
            Family::Kd | Family::Bvh => ("most triangles in a leaf", LECTURE_LEAF),
        };
        Ok(Sweep {
            family: family.name(),
            setting,
            lecture,
            curves,
        })
    }
}

/// The point with the most rays per second.
fn best(points: &[Point]) -> Option<usize> {
    let rate = |s: &Structure| s.measured.as_ref()?.mrays_per_second;
    let rates = points.iter().enumerate();
    let rates = rates.filter_map(|(i, point)| Some((i, rate(&point.structure)?)));
    rates.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_swept_from_one_cell_to_too_many() {
        let points = cells_per_triangle(1000);
        assert_eq!(points[0], (0.001, "resolution=1x1x1".to_string()));
        assert!(points.contains(&(27.0, "c=27".to_string())));
        assert!(points.last().is_some_and(|p| p.0 > 27.0 * 200.0));
        assert!(points.is_sorted_by(|a, b| a.0 < b.0));
        // A large scene has no room for so many.
        assert!(cells_per_triangle(1_000_000).iter().all(|p| p.0 <= 135.0));
    }

    #[test]
    fn leaves_are_those_that_a_builder_takes() {
        let points = Family::Bvh.points("bvh:median,axes=xy".parse().expect("a structure"), 10);
        let values: Vec<f64> = points.iter().map(|p| p.0).collect();
        assert_eq!(values, LEAVES.map(|leaf| leaf as f64));
        assert_eq!(points[0].1.to_string(), "bvh:median,leaf=1,axes=xy");
        // A structure without leaves makes no points.
        let judge = "brute".parse().expect("a structure");
        assert!(Family::Bvh.points(judge, 10).is_empty());
        assert!("cube".parse::<Family>().is_err());
    }
}
