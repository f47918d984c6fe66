//! The report in a terminal: two tables, what structures are and what rays do, narrow enough for a hundred columns.

use super::report::{Measured, Report, Structure, Sweep};
use crate::terminal::{self, counted, grouped, seconds};
use boxwood::StructureKind;

/// Everything that is said on stdout.
pub fn tables(report: &Report) -> String {
    let mut parts = vec![heading(report)];
    if report.sweep.is_none() {
        parts.push(structures(report));
    }
    parts.push(rays(report));
    if !report.jobs.is_empty() {
        parts.push(jobs(report));
    }
    parts.extend(report.sweep.as_ref().map(sweep));
    parts.push(footnotes(report));
    parts.join("\n\n")
}

fn heading(report: &Report) -> String {
    let (s, m) = (&report.settings, &report.machine);
    let camera = s
        .camera
        .as_ref()
        .map_or(String::new(), |name| format!(", camera {name}"));
    let workloads = report.workloads.iter().map(|w| {
        let rays = grouped(w.rays as u64);
        let share = 100.0 * w.hits as f64 / w.rays.max(1) as f64;
        format!("{} {rays} ({share:.0} % hit)", w.kind)
    });
    format!(
        "scene   {}: {}{camera}\nrays    {}\nmachine {}, {}, built with {}, timed on one",
        s.scene,
        counted(s.triangles, "triangle"),
        workloads.collect::<Vec<_>>().join(", "),
        m.processor,
        m.system,
        counted(m.threads as u64, "thread"),
    )
}

fn structures(report: &Report) -> String {
    let mut table = Table::new([
        "structure",
        "build  ",
        "memory  ",
        "B/tri",
        "nodes",
        "leaves",
        "depth",
        "refs/tri",
        "SAH cost  ",
    ]);
    for structure in &report.structures {
        let Some(m) = &structure.measured else {
            table.note(structure);
            continue;
        };
        let won = |column: &str, text: String| mark(report, column, structure, text);
        table.row([
            structure.structure.clone(),
            won("build_seconds", seconds(m.build_seconds)),
            won("bytes", terminal::bytes(m.bytes as u64)),
            number(m.bytes_per_triangle, 1),
            grouped(m.nodes as u64),
            grouped(m.leaves as u64),
            m.depth.to_string(),
            number(m.references_per_triangle, 2),
            won("sah_cost", number(Some(m.sah_cost), 1)),
        ]);
    }
    table.text()
}

fn rays(report: &Report) -> String {
    // Two more places for the winners' mark.
    let kinds: Vec<String> = report
        .workloads
        .iter()
        .map(|w| format!("{}  ", w.kind))
        .collect();
    let mut head = vec!["Mrays/s"];
    head.extend(kinds.iter().map(String::as_str));
    head.extend(["mean  ", "speed-up", "nodes/ray  ", "prims/ray  "]);
    let mut table = Table::new(head);
    for structure in &report.structures {
        let Some(m) = &structure.measured else {
            if report.sweep.is_some() {
                table.note(structure);
            }
            continue;
        };
        let won = |column: &str, text: String| mark(report, column, structure, text);
        let mut row = vec![structure.structure.clone()];
        row.extend(m.rays.iter().map(|r| won(r.kind, rate(r.mrays_per_second))));
        row.push(won("mrays_per_second", rate(m.mrays_per_second)));
        row.push(number(m.speedup, 1));
        row.push(won("nodes_per_ray", number(m.nodes_per_ray, 1)));
        row.push(won("primitives_per_ray", number(m.primitives_per_ray, 1)));
        table.row(row);
    }
    table.text()
}

fn jobs(report: &Report) -> String {
    let mut table = Table::new([
        "build and rays",
        "done first",
        "after",
        "by the model",
        "expected",
        "after",
    ]);
    for row in &report.jobs {
        let chosen = row.chosen.as_ref();
        let cell = |text: Option<String>| text.unwrap_or_else(|| "-".to_string());
        table.row([
            grouped(row.rays),
            row.first.clone(),
            seconds(row.seconds),
            cell(chosen.map(|c| c.structure.clone())),
            cell(chosen.map(|c| seconds(c.expected_seconds))),
            cell(chosen.map(|c| seconds(c.seconds))),
        ]);
    }
    table.text()
}

fn sweep(sweep: &Sweep) -> String {
    let mut table = Table::new([
        sweep.setting,
        "build",
        "memory",
        "SAH cost",
        "nodes/ray",
        "prims/ray",
        "Mrays/s",
        "speed-up",
        "",
    ]);
    for curve in &sweep.curves {
        table.heading(&curve.name);
        for (i, point) in curve.points.iter().enumerate() {
            let value = round(point.value);
            let Some(m) = &point.structure.measured else {
                table.note(&point.structure);
                continue;
            };
            let mut notes = Vec::new();
            if curve.best == Some(i) {
                notes.push("<- best");
            }
            if point.value == sweep.lecture {
                notes.push("<- lecture");
            }
            table.row([
                value,
                seconds(m.build_seconds),
                terminal::bytes(m.bytes as u64),
                number(Some(m.sah_cost), 1),
                number(m.nodes_per_ray, 1),
                number(m.primitives_per_ray, 1),
                rate(m.mrays_per_second),
                number(m.speedup, 1),
                notes.join(" "),
            ]);
        }
    }
    table.text()
}

fn footnotes(report: &Report) -> String {
    let mut notes = vec![format!(
        "Single rays, one thread, median of {}; mean: geometric.{}",
        counted(u64::from(report.settings.rounds), "round"),
        asked(report)
    )];
    let marks = "* best of the column; brute, and what is 100 times slower than the fastest, takes no part. Speed-up: over brute.";
    if report.sweep.is_none() {
        notes.insert(0, marks.to_string());
    }
    let sampled = sampled(report);
    if sampled.is_empty() {
        notes.push(format!("{} gave the same bits for every ray.", all(report)));
    } else {
        notes.push(format!(
            "{} gave the same bits for every ray they were asked; slow ones were asked a sample: {}.",
            all(report),
            sampled.join(", ")
        ));
    }
    notes.join("\n")
}

/// Those that are held to each other's answers.
pub fn all(report: &Report) -> &'static str {
    let loose = |s: &Structure| {
        s.structure
            .parse()
            .is_ok_and(|kind: StructureKind| !kind.is_exact())
    };
    if !report.structures.iter().any(loose) {
        "All structures"
    } else {
        "All structures but those with precision=fast, which need not,"
    }
}

/// Which rays asked for occlusion.
fn asked(report: &Report) -> String {
    let occluded: Vec<&str> = report
        .workloads
        .iter()
        .filter(|w| w.question == "occluded")
        .map(|w| w.kind)
        .collect();
    match occluded.len() {
        0 => " All rays ask for the nearest hit.".to_string(),
        _ => format!(
            " {} rays ask for any hit, others for the nearest.",
            occluded.join(" and ")
        ),
    }
}

/// Structures that were not asked every ray, with how many: `brute 412 of 500,000 rays`.
pub fn sampled(report: &Report) -> Vec<String> {
    let all: usize = report.workloads.iter().map(|w| w.rays).sum();
    let asked = |m: &Measured| m.rays.iter().map(|r| r.rays_asked).sum::<usize>();
    report
        .structures
        .iter()
        .filter_map(|s| Some((s, asked(s.measured.as_ref()?))))
        .filter(|(_, asked)| *asked < all)
        .map(|(s, asked)| {
            let [asked, all] = [asked, all].map(|n| grouped(n as u64));
            format!("{} {asked} of {all} rays", s.structure)
        })
        .collect()
}

fn mark(report: &Report, column: &str, structure: &Structure, text: String) -> String {
    if report.wins(column, &structure.structure) {
        format!("{text} *")
    } else {
        format!("{text}  ")
    }
}

/// A number, grouped where it is long.
pub fn number(value: Option<f64>, digits: usize) -> String {
    match value {
        None => "-".to_string(),
        Some(x) if x.abs() >= 1e15 => format!("{x:.1e}"),
        Some(x) if x >= 1000.0 => grouped(x.round() as u64),
        Some(x) => format!("{x:.digits$}"),
    }
}

/// Millions of rays per second: three digits that matter.
pub fn rate(value: Option<f64>) -> String {
    match value {
        Some(x) if x >= 10.0 => number(value, 1),
        Some(x) if x >= 0.1 => format!("{x:.2}"),
        Some(x) if x > 0.0 => {
            let digits = (-x.log10()).floor().clamp(0.0, 12.0) as usize + 2;
            format!("{x:.digits$}")
        }
        _ => number(value, 1),
    }
}

/// Three digits that matter, without zeros at the end.
pub fn round(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_string();
    }
    let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

/// Columns as wide as their widest text, names on the left, numbers on the right.
struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    fn new<'a>(head: impl IntoIterator<Item = &'a str>) -> Self {
        let mut table = Self { rows: Vec::new() };
        table.row(head.into_iter().map(str::to_string));
        table
    }

    fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// A line of one text.
    fn heading(&mut self, text: &str) {
        self.row([text.to_string()]);
    }

    fn note(&mut self, structure: &Structure) {
        let failure = structure.failure.as_deref().unwrap_or_default();
        self.heading(&format!("{}: {failure}", structure.structure));
    }

    fn text(&self) -> String {
        let columns = self.rows.first().map_or(0, Vec::len);
        let width = |i: usize| {
            let cells = self
                .rows
                .iter()
                .filter(|row| row.len() > 1)
                .filter_map(|row| row.get(i));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(i, (cell, &width))| {
                    if i == 0 || row.len() == 1 {
                        format!("{cell:<width$}")
                    } else {
                        format!("{cell:>width$}")
                    }
                });
            cells.collect::<Vec<_>>().join(" ").trim_end().to_string()
        };
        self.rows.iter().map(line).collect::<Vec<_>>().join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_keep_three_digits() {
        for (x, text) in [
            (123.45, "123.5"),
            (12.34, "12.3"),
            (1.234, "1.23"),
            (0.123, "0.12"),
            (0.001_234, "0.0012"),
        ] {
            assert_eq!(rate(Some(x)), text);
        }
        assert_eq!(rate(None), "-");
        assert_eq!(number(Some(1234.6), 1), "1,235");
    }

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(["name", "a", "b"]);
        table.row(["x".into(), "1".into(), "22".into()]);
        table.heading("a long line of its own");
        assert_eq!(table.text(), "name a  b\nx    1 22\na long line of its own");
    }
}
