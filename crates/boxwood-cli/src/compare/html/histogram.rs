//! What rays cost: one row per structure, shares of rays by steps, with the predicted and the measured mean.

use super::escape::Escaped;
use super::svg::{Frame, LogAxis, count, family};
use crate::compare::report::{Measured, Structure, contenders};
use std::fmt::Write;

const WIDTH: f64 = 560.0;
/// Rows share this height as long as they are neither too flat nor too tall.
const HEIGHT: f64 = 330.0;
/// Shares below this are not worth an octave of the axis.
const RARE: f64 = 1e-3;

/// The plot, as an SVG; empty where nothing was counted. Only contenders: the exhaustive test would stand alone,
/// far to the right.
pub fn plot(structures: &[Structure]) -> String {
    let rows: Vec<(&str, &Measured)> = contenders(structures)
        .map(|(s, m)| (s.structure.as_str(), m))
        .filter(|(_, m)| m.histogram.iter().any(|&share| share > 0.0))
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let letters = rows
        .iter()
        .map(|(name, _)| name.chars().count())
        .max()
        .unwrap_or(0);
    let left = (letters as f64 * 6.9 + 14.0).clamp(60.0, 240.0);
    let tall = (HEIGHT / rows.len() as f64).clamp(30.0, 62.0);
    let height = rows.len() as f64 * tall + 70.0;
    let frame = Frame {
        left,
        right: WIDTH - 12.0,
        top: 22.0,
        bottom: height - 48.0,
    };
    let ends = rows.iter().flat_map(|(_, m)| {
        let common = |i: &usize| m.histogram[*i] > RARE;
        let last = (0..m.histogram.len()).rev().find(common).unwrap_or(0);
        [edge(last + 1), m.sah_cost, 2.0]
    });
    let x = LogAxis::around(ends, frame.left, frame.right);
    let tallest = rows
        .iter()
        .flat_map(|(_, m)| &m.histogram)
        .fold(0.0, |a: f64, &b| a.max(b));
    let mut svg = format!(
        r#"<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="Shares of rays by steps, for each structure">"#
    );
    svg += &frame.x_axis(&x, "nodes and primitives visited by a ray", count);
    let _ = write!(
        svg,
        r#"<g class="key"><line class="mean" x1="{0:.1}" x2="{0:.1}" y1="4" y2="16"/><text x="{1:.1}" y="14">measured mean</text><path class="sah" d="M{2:.1} 4l5 6-5 6-5-6z"/><text x="{3:.1}" y="14">predicted (SAH)</text></g>"#,
        left + 6.0,
        left + 13.0,
        left + 128.0,
        left + 138.0
    );
    for (i, (name, m)) in rows.into_iter().enumerate() {
        let base = frame.top + (i + 1) as f64 * tall;
        let _ = write!(
            svg,
            r#"<g class="{}"><text class="row" x="{:.1}" y="{:.1}" text-anchor="end">{}</text><path class="area" d="{}"/><line class="base" x1="{left}" x2="{}" y1="{base:.1}" y2="{base:.1}"/>"#,
            family(name),
            left - 9.0,
            base - 5.0,
            Escaped(name),
            bars(m, &x, &frame, base, (tall - 8.0) / tallest),
            frame.right
        );
        if let Some(mean) = m.steps_per_ray() {
            let at = x.at(mean.max(0.5)).clamp(frame.left, frame.right);
            let _ = write!(
                svg,
                r#"<line class="mean" x1="{at:.1}" x2="{at:.1}" y1="{:.1}" y2="{:.1}"><title>measured: {mean:.1}</title></line>"#,
                base - tall + 6.0,
                base + 2.0
            );
        }
        if m.sah_cost > 0.0 {
            let at = x.at(m.sah_cost).clamp(frame.left, frame.right);
            let _ = write!(
                svg,
                r#"<path class="sah" d="M{at:.1} {:.1}l5 6-5 6-5-6z"><title>predicted: {:.1}</title></path>"#,
                base - 12.0,
                m.sah_cost
            );
        }
        svg += "</g>";
    }
    svg + "</svg>"
}

/// The outline of a row's bars.
fn bars(m: &Measured, x: &LogAxis, frame: &Frame, base: f64, scale: f64) -> String {
    let mut path = String::new();
    for (i, share) in m.histogram.iter().enumerate() {
        if *share <= 0.0 {
            continue;
        }
        let side = |i: usize| x.at(edge(i).max(0.5)).clamp(frame.left, frame.right);
        // No number of steps lies in the second half of the first octave.
        let (from, to) = (side(i), side((i + 1).max(2)));
        let high = base - scale * share;
        let _ = write!(path, "M{from:.1} {base:.1}V{high:.1}H{to:.1}V{base:.1}z");
    }
    path
}

/// The steps at which a bin begins.
fn edge(bin: usize) -> f64 {
    (bin as f64 / 2.0).exp2() - 1.0
}
