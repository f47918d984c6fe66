//! The tables, winners marked.

use super::escape::Escaped;
use super::svg::family;
use crate::compare::report::{Measured, Report, Structure, Sweep};
use crate::compare::text::{number, rate};
use crate::terminal::{bytes, grouped, seconds};
use std::fmt::Write;

/// What rays do: millions per second, and what they visit.
pub fn rays(report: &Report) -> String {
    let kinds = &report.workloads;
    let mut html = format!(
        "<div class=\"wide\"><table><thead><tr><th></th><th colspan=\"{}\">million rays per second</th><th></th><th colspan=\"2\">visited per ray</th></tr><tr><th>structure</th>",
        kinds.len() + 1
    );
    for workload in kinds {
        let _ = write!(html, "<th>{}</th>", workload.kind);
    }
    html += "<th>mean</th><th>× brute</th><th>nodes</th><th>primitives</th></tr></thead><tbody>";
    let fastest = report
        .structures
        .iter()
        .filter_map(|s| s.measured.as_ref()?.mrays_per_second)
        .fold(0.0, f64::max);
    for structure in &report.structures {
        let Some(m) = &structure.measured else {
            if report.sweep.is_some() {
                html += &failed(structure, kinds.len() + 5);
            }
            continue;
        };
        html += &row_head(structure);
        let won = |column: &str, text: String| cell(report, column, structure, &text);
        for r in &m.rays {
            html += &won(r.kind, rate(r.mrays_per_second));
        }
        let share = 100.0 * m.mrays_per_second.unwrap_or(0.0) / fastest.max(1e-300);
        let mean = won("mrays_per_second", rate(m.mrays_per_second));
        html += &mean.replacen(
            "<td",
            &format!("<td style=\"--share:{share:.1}%\" data-bar"),
            1,
        );
        let _ = write!(html, "<td>{}</td>", number(m.speedup, 1));
        html += &won("nodes_per_ray", number(m.nodes_per_ray, 1));
        html += &won("primitives_per_ray", number(m.primitives_per_ray, 1));
        html += "</tr>";
    }
    html + "</tbody></table></div>"
}

/// What structures are.
pub fn structures(report: &Report) -> String {
    let mut html = "<div class=\"wide\"><table><thead><tr><th>structure</th><th>build</th><th>memory</th>\
        <th>bytes per triangle</th><th>nodes</th><th>leaves</th><th>depth</th><th>references per triangle</th>\
        <th>SAH cost (predicted)</th><th>steps per ray (measured)</th></tr></thead><tbody>"
        .to_string();
    for structure in &report.structures {
        let Some(m) = &structure.measured else {
            html += &failed(structure, 9);
            continue;
        };
        html += &row_head(structure);
        html += &built(m, |column, text| cell(report, column, structure, &text));
        html += "</tr>";
    }
    html + "</tbody></table></div>"
}

fn built(m: &Measured, cell: impl Fn(&str, String) -> String) -> String {
    [
        cell("build_seconds", seconds(m.build_seconds)),
        cell("bytes", bytes(m.bytes as u64)),
        cell("", number(m.bytes_per_triangle, 1)),
        cell("", grouped(m.nodes as u64)),
        cell("", grouped(m.leaves as u64)),
        cell("", m.depth.to_string()),
        cell("", number(m.references_per_triangle, 2)),
        cell("sah_cost", number(Some(m.sah_cost), 1)),
        cell("", number(m.steps_per_ray(), 1)),
    ]
    .concat()
}

/// All points of a sweep.
pub fn sweep(sweep: &Sweep) -> String {
    let mut html = format!(
        "<div class=\"wide\"><table><thead><tr><th>structure</th><th>{}</th><th>build</th><th>memory</th>\
        <th>SAH cost</th><th>nodes per ray</th><th>primitives per ray</th><th>million rays per second</th></tr></thead><tbody>",
        sweep.setting
    );
    for curve in &sweep.curves {
        for (i, point) in curve.points.iter().enumerate() {
            let Some(m) = &point.structure.measured else {
                html += &failed(&point.structure, 7);
                continue;
            };
            html += &row_head(&point.structure);
            let best = if curve.best == Some(i) {
                " class=\"won\""
            } else {
                ""
            };
            let _ = write!(
                html,
                "<td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td{best}>{}</td></tr>",
                super::svg::round(point.value),
                seconds(m.build_seconds),
                bytes(m.bytes as u64),
                number(Some(m.sah_cost), 1),
                number(m.nodes_per_ray, 1),
                number(m.primitives_per_ray, 1),
                rate(m.mrays_per_second)
            );
        }
    }
    html + "</tbody></table></div>"
}

fn row_head(structure: &Structure) -> String {
    let judge = if structure.is_judge() {
        " class=\"judge\""
    } else {
        ""
    };
    let name = Escaped(&structure.structure);
    let family = family(&structure.structure);
    format!("<tr{judge}><th scope=\"row\"><i class=\"dot {family}\"></i>{name}</th>")
}

fn failed(structure: &Structure, columns: usize) -> String {
    format!(
        "{}<td class=\"failed\" colspan=\"{columns}\">{}</td></tr>",
        row_head(structure),
        Escaped(structure.failure.as_deref().unwrap_or_default())
    )
}

fn cell(report: &Report, column: &str, structure: &Structure, text: &str) -> String {
    if report.wins(column, &structure.structure) {
        format!("<td class=\"won\">{text}</td>")
    } else {
        format!("<td>{text}</td>")
    }
}
