//! Build and rays together, from few rays to many: curves as measured, dotted ones as the model of costs expects them.

use super::escape::Escaped;
use super::svg::{Frame, LogAxis, count, duration};
use crate::compare::frontier::{Place, break_even, frontier};
use crate::compare::jobs::expected;
use crate::compare::report::Report;
use std::fmt::Write;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 400.0;
/// Different curves' colours, again from the start when there are more.
const COLOURS: usize = 6;
/// Points of a curve for each power of ten.
const POINTS: i32 = 4;

/// The plot with a table of choices; nothing where nobody competes.
pub fn figure(report: &Report, places: &[Place]) -> String {
    let (Some(first), Some(last)) = (report.jobs.first(), report.jobs.last()) else {
        return String::new();
    };
    let expected = expected(&report.structures, places);
    let mut drawn = frontier(places);
    for (place, _) in &expected {
        if !drawn.contains(place) {
            drawn.push(place);
        }
    }
    let exponents = [first.rays, last.rays].map(|rays| rays.ilog10() as i32 * POINTS);
    let rays: Vec<f64> = (exponents[0]..=exponents[1])
        .map(|i| 10_f64.powf(f64::from(i) / f64::from(POINTS)))
        .collect();
    let frame = Frame {
        left: 76.0,
        right: WIDTH - 12.0,
        top: 18.0 + 16.0 * drawn.len().div_ceil(2) as f64,
        bottom: HEIGHT - 48.0,
    };
    let ends = [rays[0], rays[rays.len() - 1]];
    let totals = drawn.iter().flat_map(|p| ends.map(|n| p.total(n)));
    let all = totals.chain(expected.iter().flat_map(|(_, f)| ends.map(|n| f.total(n))));
    let x = LogAxis::around(ends, frame.left, frame.right);
    let y = LogAxis::around(all, frame.bottom, frame.top);
    let mut svg = format!(
        r#"<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="Time for building and rays together">"#
    );
    svg += &frame.draw(&x, &y, ["rays", "build and rays"], [count, duration]);
    let curve = |svg: &mut String, class: &str, total: &dyn Fn(f64) -> f64| {
        let points: Vec<String> = rays
            .iter()
            .map(|&n| format!("{:.1},{:.1}", x.at(n), y.at(total(n))))
            .collect();
        let points = points.join(" ");
        let _ = write!(
            svg,
            r#"<polyline class="curve {class}" points="{points}"/>"#
        );
    };
    for (i, place) in drawn.iter().enumerate() {
        let colour = i % COLOURS;
        curve(&mut svg, &format!("c{colour}"), &|n| place.total(n));
        if let Some((_, forecast)) = expected.iter().find(|(of, _)| of == place) {
            curve(&mut svg, &format!("c{colour} dashed"), &|n| {
                forecast.total(n)
            });
        }
        let left = frame.left + (i % 2) as f64 * 236.0;
        let at = 10.0 + 16.0 * (i / 2) as f64;
        let _ = write!(
            svg,
            r#"<line class="curve c{colour}" x1="{left:.1}" x2="{:.1}" y1="{at:.1}" y2="{at:.1}"/><text class="label" x="{:.1}" y="{:.1}">{}</text>"#,
            left + 18.0,
            left + 23.0,
            at + 4.0,
            Escaped(&place.name)
        );
    }
    for pair in frontier(places).windows(2) {
        let crossing = break_even(pair[0], pair[1]);
        if (ends[0]..=ends[1]).contains(&crossing) {
            let _ = write!(
                svg,
                r#"<circle class="on" cx="{:.1}" cy="{:.1}" r="4"><title>{}: from {} rays on</title></circle>"#,
                x.at(crossing),
                y.at(pair[0].total(crossing)),
                Escaped(&pair[1].name),
                count(crossing)
            );
        }
    }
    svg += "</svg>";
    let note = if expected.is_empty() {
        ""
    } else {
        " Dotted: what the library’s model of costs expects before it builds, in nominal time; its choices are below."
    };
    format!(
        "<figure class=\"plot\"><figcaption>Build and rays together</figcaption>{svg}<p class=\"small\">One thread traces. \
        Circles: where a curve is overtaken.{note}</p>{}</figure>",
        choices(report)
    )
}

/// Whom the model takes for how many rays, and what that costs beside the best.
fn choices(report: &Report) -> String {
    let chosen = report
        .jobs
        .iter()
        .filter_map(|row| Some((row, row.chosen.as_ref()?)));
    let rows: String = chosen
        .map(|(row, chosen)| {
            format!(
                "<li>{} rays: <b>{}</b>, {} expected, {} taken; the fastest, {}, takes {}</li>",
                count(row.rays as f64),
                Escaped(&chosen.structure),
                duration(chosen.expected_seconds),
                duration(chosen.seconds),
                Escaped(&row.first),
                duration(row.seconds)
            )
        })
        .collect();
    if rows.is_empty() {
        rows
    } else {
        format!("<ol class=\"frontier\">{rows}</ol>")
    }
}
