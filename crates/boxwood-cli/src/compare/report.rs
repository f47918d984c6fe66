//! What a comparison found: plain data, between those who measure and those who write.
//!
//! The field names are those of the JSON, whose meaning `boxwood compare --help` tells. Ratios and rates are `None` where
//! there was nothing to measure.

use serde::Serialize;
use std::collections::BTreeMap;

/// The version of the JSON's keys.
pub const FORMAT_VERSION: u32 = 1;

/// Everything that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub format_version: u32,
    pub settings: Settings,
    pub machine: Machine,
    pub workloads: Vec<Workload>,
    /// In the order they were asked for; the exhaustive test first.
    pub structures: Vec<Structure>,
    /// Column to the names of the best in it.
    pub winners: BTreeMap<String, Vec<String>>,
    /// From few rays to many; none in a sweep.
    pub jobs: Vec<JobRow>,
    pub sweep: Option<Sweep>,
}

/// What it takes to do the same again.
#[derive(Clone, Debug, Serialize)]
pub struct Settings {
    /// As it was typed.
    pub command: String,
    pub scene: String,
    pub format: &'static str,
    pub triangles: u64,
    /// `null` for one that was found by itself or described on the command line.
    pub camera: Option<String>,
    pub eye: [f32; 3],
    pub forward: [f32; 3],
    /// Of the primary rays.
    pub image: [u32; 2],
    pub rounds: u32,
    /// Whether all rays asked for the nearest hit.
    pub closest: bool,
    pub memory_bytes: Option<usize>,
}

/// Where it was done.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    pub processor: String,
    pub cores: usize,
    /// For building; rays are timed on one.
    pub threads: usize,
    pub system: String,
    pub architecture: &'static str,
    pub boxwood: &'static str,
}

/// Rays of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct Workload {
    pub kind: &'static str,
    pub question: &'static str,
    pub rays: usize,
    pub hits: usize,
}

/// A structure, and what was found of it.
#[derive(Clone, Debug, Serialize)]
pub struct Structure {
    pub structure: String,
    /// Why there is no such structure.
    pub failure: Option<String>,
    pub measured: Option<Measured>,
    /// What was to be expected; of presets of wide trees only.
    pub forecast: Option<Forecast>,
}

/// What the library's model of costs says of a structure before it is built.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    pub build_seconds: f64,
    pub nanoseconds_per_ray: f64,
    pub peak_bytes: usize,
    pub bytes: usize,
}

/// Who is done first with so many rays, building included; rays on one thread.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JobRow {
    pub rays: u64,
    pub first: String,
    pub seconds: f64,
    /// Whom the model of costs would take, what it expects and what that one takes; `null` where no structure has a forecast.
    pub chosen: Option<Chosen>,
}

/// A choice made before anything was built.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Chosen {
    pub structure: String,
    pub expected_seconds: f64,
    pub seconds: f64,
}

/// What was found of a structure.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    pub build_seconds: f64,
    pub bytes: usize,
    pub bytes_per_triangle: Option<f64>,
    pub nodes: usize,
    pub leaves: usize,
    pub depth: usize,
    pub references_per_triangle: Option<f64>,
    /// Predicted steps of a ray.
    pub sah_cost: f64,
    pub nodes_per_ray: Option<f64>,
    pub leaves_per_ray: Option<f64>,
    pub primitives_per_ray: Option<f64>,
    /// Geometric mean over the kinds of rays.
    pub mrays_per_second: Option<f64>,
    pub speedup: Option<f64>,
    /// Shares of rays by steps, see [`bin_of`].
    pub histogram: Vec<f64>,
    pub rays: Vec<Traced>,
}

/// One kind of rays through one structure.
#[derive(Clone, Debug, Serialize)]
pub struct Traced {
    pub kind: &'static str,
    pub mrays_per_second: Option<f64>,
    pub speedup: Option<f64>,
    pub nodes_per_ray: Option<f64>,
    pub leaves_per_ray: Option<f64>,
    pub primitives_per_ray: Option<f64>,
    /// How many of the workload's rays were asked, checked and timed.
    pub rays_asked: usize,
}

/// One setting from one end to the other.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    pub family: &'static str,
    /// What changes, in words: the plots' x-axis.
    pub setting: &'static str,
    /// The lecture's choice on that axis.
    pub lecture: f64,
    pub curves: Vec<Curve>,
}

/// What one builder makes of the setting.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    pub name: String,
    /// The point with the most rays per second.
    pub best: Option<usize>,
    pub points: Vec<Point>,
}

/// One value of the setting.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    pub value: f64,
    #[serde(flatten)]
    pub structure: Structure,
}

impl Structure {
    /// Whether it is the exhaustive test, which is measured and never wins.
    pub fn is_judge(&self) -> bool {
        self.structure == super::JUDGE
    }
}

impl Measured {
    /// Inner nodes (or cells) and primitives visited: what the surface-area heuristic predicts.
    pub fn steps_per_ray(&self) -> Option<f64> {
        Some(self.nodes_per_ray? + self.primitives_per_ray?)
    }

    /// Nanoseconds that a ray takes, by the geometric mean.
    pub fn nanoseconds(&self) -> Option<f64> {
        self.mrays_per_second.map(|rate| 1e3 / rate)
    }
}

/// The place of a number of steps in a histogram: bin `i` holds `2^(i/2) ≤ 1 + steps < 2^((i+1)/2)`.
pub fn bin_of(steps: u64) -> usize {
    let n = u128::from(steps.saturating_add(1));
    let octave = n.ilog2() as usize;
    // Beyond √2 times the octave's beginning, without rounding.
    2 * octave + usize::from(n * n >= 1 << (2 * octave + 1))
}

/// What a column shows of a structure.
type Value = Box<dyn Fn(&Measured) -> Option<f64>>;

/// A column of the tables in which somebody wins.
pub struct Column {
    /// The key in [`Report::winners`].
    pub key: String,
    value: Value,
    more_is_better: bool,
}

/// All columns in which somebody wins.
pub fn columns(workloads: &[Workload]) -> Vec<Column> {
    let column = |key: &str, more_is_better, value: Value| Column {
        key: key.to_string(),
        value,
        more_is_better,
    };
    let mut all = vec![
        column("build_seconds", false, Box::new(|m| Some(m.build_seconds))),
        column("bytes", false, Box::new(|m| Some(m.bytes as f64))),
        column("sah_cost", false, Box::new(|m| Some(m.sah_cost))),
        column("nodes_per_ray", false, Box::new(|m| m.nodes_per_ray)),
        column(
            "primitives_per_ray",
            false,
            Box::new(|m| m.primitives_per_ray),
        ),
        column("mrays_per_second", true, Box::new(|m| m.mrays_per_second)),
    ];
    all.extend(workloads.iter().enumerate().map(|(i, workload)| {
        let rate = move |m: &Measured| m.rays.get(i)?.mrays_per_second;
        column(workload.kind, true, Box::new(rate))
    }));
    all
}

/// Structures slower than this share of the fastest are as good as exhaustive.
const IN_VAIN: f64 = 0.01;

/// Those who compete: all that were measured without the exhaustive test and what is no better, a hundred times slower
/// than the fastest. Such structures build in no time, take no memory, and would stretch every plot.
pub fn contenders(
    structures: &[Structure],
) -> impl Iterator<Item = (&Structure, &Measured)> + Clone {
    let measured = structures
        .iter()
        .filter(|s| !s.is_judge())
        .filter_map(|s| Some((s, s.measured.as_ref()?)));
    let rate = |m: &Measured| m.mrays_per_second.unwrap_or(0.0);
    let fastest = measured.clone().map(|(_, m)| rate(m)).fold(0.0, f64::max);
    measured.filter(move |(_, m)| rate(m) >= IN_VAIN * fastest)
}

/// Who of the contenders is best in each column; several where they are equal.
pub fn winners(structures: &[Structure], workloads: &[Workload]) -> BTreeMap<String, Vec<String>> {
    columns(workloads)
        .into_iter()
        .map(|column| {
            let sign = if column.more_is_better { -1.0 } else { 1.0 };
            let entered = contenders(structures)
                .filter_map(|(s, m)| Some((&s.structure, sign * (column.value)(m)?)));
            let best = entered
                .clone()
                .map(|(_, value)| value)
                .min_by(f64::total_cmp);
            let first = entered.filter(|(_, value)| Some(*value) == best);
            (
                column.key.clone(),
                first.map(|(name, _)| name.clone()).collect(),
            )
        })
        .collect()
}

impl Report {
    /// Whether a structure is the best in a column.
    pub fn wins(&self, column: &str, structure: &str) -> bool {
        let names = self.winners.get(column);
        names.is_some_and(|names| names.iter().any(|name| name == structure))
    }
}

/// The geometric mean of what there is; `None` of nothing.
pub fn geometric_mean(values: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    let logs: Vec<f64> = values.into_iter().flatten().map(f64::ln).collect();
    (!logs.is_empty()).then(|| (logs.iter().sum::<f64>() / logs.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_half_octaves() {
        let bins = [0, 1, 2, 3, 4, 5, 7, 10, 11, 15].map(bin_of);
        assert_eq!(bins, [0, 2, 3, 4, 4, 5, 6, 6, 7, 8]);
        assert_eq!(bin_of(u64::MAX), 127);
    }

    #[test]
    fn means_pass_over_what_is_not_there() {
        let mean = geometric_mean([Some(2.0), None, Some(8.0)]).expect("a mean");
        assert!((mean - 4.0).abs() < 1e-12);
        assert_eq!(geometric_mean([None]), None);
    }
}
