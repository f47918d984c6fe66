//! The report as tables, in plain text and as one HTML page.

use crate::judge::Disagreements;
use crate::report::{Class, Column, Report, Series, Summary, median};
use std::fmt::Write;

/// A table of words and numbers; the first column is words.
pub struct Table {
    pub title: String,
    /// What it takes to read it; may be empty.
    pub caption: String,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn new(title: impl Into<String>, caption: impl Into<String>, header: Vec<String>) -> Self {
        Self {
            title: title.into(),
            caption: caption.into(),
            header,
            rows: Vec::new(),
        }
    }

    /// Aligned columns under a title.
    pub fn text(&self) -> String {
        let all = || std::iter::once(&self.header).chain(&self.rows);
        let width = |i: usize| {
            let cells = all().filter_map(|row| row.get(i));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.header.len()).map(width).collect();
        let mut text = format!("\n{}\n", self.title);
        if !self.caption.is_empty() {
            let _ = writeln!(text, "{}", self.caption);
        }
        // Of an empty table the caption says enough.
        for row in all().take(if self.rows.is_empty() { 0 } else { usize::MAX }) {
            let mut line = String::new();
            for (i, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let _ = match i {
                    0 => write!(line, "  {cell:<width$}"),
                    _ => write!(line, "  {cell:>width$}"),
                };
            }
            let _ = writeln!(text, "{}", line.trim_end());
        }
        text
    }

    fn html(&self) -> String {
        let cells = |row: &[String], tag: &str| {
            let cells = row
                .iter()
                .map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)));
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        };
        let mut html = format!("<h3>{}</h3>\n", escaped(&self.title));
        if !self.caption.is_empty() {
            let _ = writeln!(html, "<p>{}</p>", escaped(&self.caption));
        }
        if self.rows.is_empty() {
            return html;
        }
        let _ = write!(
            html,
            "<div class=\"wide\"><table>\n<thead>{}</thead>\n<tbody>",
            cells(&self.header, "th")
        );
        self.rows.iter().for_each(|row| html += &cells(row, "td"));
        html + "</tbody></table></div>\n"
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

const NOTHING: &str = "–";

/// Stands behind the figures of who is wrong more often than [`OFTEN`].
fn mark(wrong: f64) -> &'static str {
    if wrong > OFTEN { " !" } else { "" }
}

const OFTEN: f64 = 1.0e-4;

/// Boxwood's own columns of some series, in order.
fn own_columns(series: &[Series]) -> Vec<Column> {
    distinct(series.iter().flat_map(|s| &s.ratios).map(|r| &r.boxwood))
}

fn distinct<'a>(columns: impl Iterator<Item = &'a Column>) -> Vec<Column> {
    let mut found: Vec<Column> = Vec::new();
    for column in columns {
        if !found.contains(column) {
            found.push(column.clone());
        }
    }
    found
}

fn titles(first: &str, columns: &[Column]) -> Vec<String> {
    let titles = columns.iter().map(Column::title);
    std::iter::once(first.to_string()).chain(titles).collect()
}

/// The classes against every peer, a table for each of Boxwood's own.
pub fn summary(all: &[Summary]) -> Vec<Table> {
    let of_own = |own: &Column| {
        let of = || all.iter().filter(|s| s.boxwood == *own);
        let classes = Class::ALL
            .into_iter()
            .filter(|&c| of().any(|s| s.class == c));
        let classes: Vec<Class> = classes.collect();
        let names = classes.iter().map(|class| class.name().to_string());
        let mut table = Table::new(
            format!("Summary: {}, {}", own.name, own.way),
            "The peer's time over Boxwood's (above 1 Boxwood is faster): geometric mean over the views, and the worst view. \
             With ! the peer is wrong about more than one ray in 10,000 of some kind, which may save it time.",
            std::iter::once("peer".to_string()).chain(names).collect(),
        );
        for peer in distinct(of().map(|s| &s.peer)) {
            let cell = |&class: &Class| {
                let found = of().find(|s| s.class == class && s.peer == peer);
                found.map_or(NOTHING.to_string(), |s| {
                    format!(
                        "{:.2} ({:.2} {}){}",
                        s.mean,
                        s.worst,
                        s.worst_view,
                        mark(s.wrong)
                    )
                })
            };
            let cells = classes.iter().map(cell);
            table
                .rows
                .push(std::iter::once(peer.title()).chain(cells).collect());
        }
        table
    };
    distinct(all.iter().map(|s| &s.boxwood))
        .iter()
        .map(of_own)
        .collect()
}

/// The tables of one view.
pub fn view(series: &[Series]) -> Vec<Table> {
    let Some(first) = series.first() else {
        return Vec::new();
    };
    let place = first.place();
    let label = |s: &Series| format!("{} {}", s.rays, s.question);
    let mut tables = Vec::new();
    for own in own_columns(series) {
        let ratios = series.iter().flat_map(|s| &s.ratios);
        let peers = distinct(ratios.filter(|r| r.boxwood == own).map(|r| &r.peer));
        let mut table = Table::new(
            format!("{place}: {}, {}", own.name, own.way),
            "The peer's time over Boxwood's: median of the rounds [quartiles]; with ! the peer is wrong about more than one \
             ray in 10,000.",
            titles("rays", &peers),
        );
        for s in series {
            let cell = |peer: &Column| {
                let found = s
                    .ratios
                    .iter()
                    .find(|r| r.boxwood == own && r.peer == *peer);
                found.map_or(NOTHING.to_string(), |r| {
                    format!(
                        "{:.2} [{:.2} {:.2}]{}",
                        r.median,
                        r.lower_quartile,
                        r.upper_quartile,
                        mark(r.wrong)
                    )
                })
            };
            let cells = peers.iter().map(cell);
            table
                .rows
                .push(std::iter::once(label(s)).chain(cells).collect());
        }
        tables.push(table);
    }
    tables.push(rates(&place, series, label));
    tables.push(steps(&place, series, label));
    tables
}

fn rates(place: &str, series: &[Series], label: impl Fn(&Series) -> String) -> Table {
    let columns = series.iter().flat_map(|s| &s.turns).map(Column::of);
    let columns: Vec<Column> = columns.collect();
    let columns = distinct(columns.iter());
    let mut header = titles("rays", &columns);
    let more = ["count", "hits", "clock", "waited"];
    header.splice(1..1, more.map(String::from));
    let mut table = Table::new(
        format!("{place}: million rays per second"),
        "Medians; for information only, as they move with the core's clock (how much it did between rounds, and how long \
         the thread waited for others, stands beside them).",
        header,
    );
    for s in series {
        let cell = |column: &Column| {
            let found = s.turns.iter().find(|t| Column::of(t) == *column);
            found.map_or(NOTHING.to_string(), |t| {
                format!("{:.2}", 1e3 / median(&t.nanoseconds))
            })
        };
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let mut row = vec![
            label(s),
            s.count.to_string(),
            percent(s.hits as f64 / s.count.max(1) as f64),
            percent(s.noise.clock_drift),
            s.noise.waited.map_or(NOTHING.to_string(), percent),
        ];
        row.extend(columns.iter().map(cell));
        table.rows.push(row);
    }
    table
}

fn steps(place: &str, series: &[Series], label: impl Fn(&Series) -> String) -> Table {
    let header = ["rays", "structure", "nodes", "leaves", "primitives"];
    let mut table = Table::new(
        format!("{place}: steps per ray"),
        "",
        header.map(String::from).to_vec(),
    );
    for s in series {
        for t in &s.turns {
            if let (Some(nodes), Some(leaves), Some(primitives)) =
                (t.nodes_per_ray, t.leaves_per_ray, t.primitives_per_ray)
            {
                let numbers = [nodes, leaves, primitives].map(|x| format!("{x:.2}"));
                let words = [label(s), t.contestant.clone()];
                table.rows.push(words.into_iter().chain(numbers).collect());
            }
        }
    }
    table
}

/// What building took.
pub fn builds(report: &Report) -> Table {
    let header = [
        "structure",
        "scene",
        "triangles",
        "1 thread, s",
        "2 threads, s",
        "MB",
        "bytes per triangle",
    ];
    let mut table = Table::new(
        "Builds",
        "The library's own calls, the best of up to three; bytes as far as the library says.",
        header.map(String::from).to_vec(),
    );
    for b in &report.builds {
        let seconds = |i: usize| {
            b.seconds
                .get(i)
                .map_or(NOTHING.into(), |s| format!("{s:.3}"))
        };
        let bytes = |f: &dyn Fn(f64) -> f64, digits: usize| {
            b.bytes
                .map_or(NOTHING.into(), |n| format!("{:.digits$}", f(n as f64)))
        };
        table.rows.push(vec![
            b.contestant.clone(),
            b.scene.clone(),
            b.triangles.to_string(),
            seconds(0),
            seconds(1),
            bytes(&|n| n / 1e6, 1),
            bytes(&|n| n / b.triangles.max(1) as f64, 0),
        ]);
    }
    table
}

/// Whose answers differ, and who is wrong.
pub fn disagreements(report: &Report) -> Table {
    let header = [
        "view",
        "peer",
        "answers",
        "missed",
        "invented",
        "inexact",
        "ties",
        "Boxwood's",
        "unjudged",
    ];
    let mut table = Table::new(
        "Disagreements with Boxwood",
        "Answers that differ by more than 1e-5, by whose fault: the peer missed what the ray certainly meets, invented \
         what it certainly misses, or gave a distance that rounding does not explain. In ties rounding decides, and both \
         are right.",
        header.map(String::from).to_vec(),
    );
    let mut asked = 0;
    for view in report.series.chunk_by(same_view) {
        let turns = || view.iter().flat_map(|s| &s.turns);
        let columns: Vec<Column> = turns().map(Column::of).collect();
        for column in distinct(columns.iter()) {
            let (mut sum, mut answers) = (Disagreements::default(), 0);
            for t in turns().filter(|t| Column::of(t) == column) {
                sum.add(&t.disagreements);
                answers += t.rays_asked;
            }
            asked += answers;
            if sum.total() > 0 {
                let numbers = [
                    sum.missed,
                    sum.invented,
                    sum.inexact,
                    sum.ties,
                    sum.ours,
                    sum.unjudged,
                ];
                let words = [view[0].place(), column.title(), answers.to_string()];
                let numbers = numbers.map(|n| n.to_string());
                table.rows.push(words.into_iter().chain(numbers).collect());
            }
        }
    }
    if table.rows.is_empty() {
        table.caption = format!("None in {asked} answers.");
    }
    table
}

fn same_view(a: &Series, b: &Series) -> bool {
    a.place() == b.place()
}

/// What was asked for and is not there; `None` where everything is.
pub fn absent(report: &Report) -> Option<Table> {
    let header = ["absent", "why"];
    let mut table = Table::new("Absent, not beaten", "", header.map(String::from).to_vec());
    let row = |a: &crate::report::Absent| vec![a.name.clone(), a.reason.clone()];
    table.rows = report.absent.iter().map(row).collect();
    (!table.rows.is_empty()).then_some(table)
}

/// The whole report in the order of interest: the summary, what is missing, the views, the rest.
fn tables(report: &Report) -> Vec<Table> {
    let mut tables = summary(&report.summary);
    tables.extend(absent(report));
    tables.extend(report.series.chunk_by(same_view).flat_map(view));
    tables.push(builds(report));
    tables.push(disagreements(report));
    tables
}

const STYLE: &str = "\
:root{color-scheme:light dark}\
body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:90rem;padding:0 1rem}\
h3{margin:2rem 0 .3rem}p{margin:.2rem 0;color:GrayText}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:13px}\
th,td{padding:.2rem .7rem;text-align:right;white-space:nowrap;border-bottom:1px solid color-mix(in srgb,currentColor 15%,transparent)}\
th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:Canvas}";

/// One page that needs no other file, no script and no network.
pub fn page(report: &Report) -> String {
    let machine = &report.machine;
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>Boxwood and its peers</title><style>{STYLE}</style></head>\n<body>\n<h1>Boxwood and its peers</h1>\n"
    );
    let _ = writeln!(
        html,
        "<p>{}, {} cores, {}; Rust code compiled for {}; {} rounds, {} tracing. <code>{}</code></p>",
        escaped(&machine.processor),
        machine.cores,
        machine.system,
        machine.compiled_for,
        report.rounds,
        threads(report.threads),
        escaped(&report.command)
    );
    tables(report)
        .iter()
        .for_each(|table| html += &table.html());
    if !report.notes.is_empty() {
        html += "<h3>Notes</h3>\n<ul>\n";
        for note in &report.notes {
            let _ = writeln!(html, "<li>{}</li>", escaped(note));
        }
        html += "</ul>\n";
    }
    html + "</body>\n</html>\n"
}

fn threads(count: usize) -> String {
    match count {
        1 => "one pinned thread".to_string(),
        n => format!("{n} pinned threads"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_words_escaped() {
        let mut table = Table::new("a < b", "", vec!["x".into(), "long".into()]);
        table.rows.push(vec!["name".into(), "1".into()]);
        assert_eq!(table.text(), "\na < b\n  x     long\n  name     1\n");
        let html = table.html();
        assert!(
            html.contains("<h3>a &lt; b</h3>") && html.contains("<td>1</td>"),
            "{html}"
        );
    }
}
