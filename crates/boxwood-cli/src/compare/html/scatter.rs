//! Build time against trace time, with the frontier and where its members overtake each other.

use super::escape::Escaped;
use super::svg::{Frame, LogAxis, count, duration, family, nanoseconds};
use crate::compare::frontier::{Place, break_even, frontier};
use std::fmt::Write;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 400.0;
/// Of a label's letter.
const LETTER: f64 = 6.7;

/// The plot, as an SVG.
pub fn plot(places: &[Place]) -> String {
    let frame = Frame {
        left: 76.0,
        right: WIDTH - 12.0,
        top: 10.0,
        bottom: HEIGHT - 48.0,
    };
    let x = LogAxis::around(places.iter().map(|p| p.build), frame.left, frame.right);
    let y = LogAxis::around(places.iter().map(|p| p.trace), frame.bottom, frame.top);
    let mut svg = format!(
        r#"<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="Build time against time per ray"><g>"#
    );
    svg += &frame.draw(
        &x,
        &y,
        ["time to build", "time per ray"],
        [duration, nanoseconds],
    );
    let best = frontier(places);
    let at = |p: &Place| [x.at(p.build), y.at(p.trace)];
    let points: Vec<String> = best
        .iter()
        .map(|p| format!("{:.1},{:.1}", at(p)[0], at(p)[1]))
        .collect();
    let _ = write!(
        svg,
        r#"<polyline class="frontier" points="{}"/>"#,
        points.join(" ")
    );
    let mut taken: Vec<Area> = places.iter().map(|p| Area::around(at(p), 7.0)).collect();
    for place in places {
        let on = best.contains(&place);
        let [cx, cy] = at(place);
        let _ = write!(
            svg,
            r#"<circle class="{} {}" cx="{cx:.1}" cy="{cy:.1}" r="{}"><title>{}: built in {}, {} per ray</title></circle>"#,
            family(&place.name),
            if on { "on" } else { "off" },
            if on { 6.5 } else { 5.0 },
            Escaped(&place.name),
            duration(place.build),
            nanoseconds(place.trace)
        );
        let (area, anchor) = label_place([cx, cy], place.name.chars().count(), &frame, &taken);
        let text_x = match anchor {
            "start" => area.left,
            "end" => area.right,
            _ => (area.left + area.right) / 2.0,
        };
        let _ = write!(
            svg,
            r#"<text class="label{}" x="{text_x:.1}" y="{:.1}" text-anchor="{anchor}">{}</text>"#,
            if on { " strong" } else { "" },
            area.bottom - 3.0,
            Escaped(&place.name)
        );
        taken.push(area);
    }
    svg += "</g></svg>";
    svg
}

/// From where on which structure is the one to take, in words.
pub fn advice(places: &[Place]) -> String {
    let best = frontier(places);
    let Some(first) = best.first() else {
        return String::new();
    };
    if best.len() == 1 {
        return format!(
            "<p><b>{}</b> is the fastest to build and the fastest to trace.</p>",
            Escaped(&first.name)
        );
    }
    let mut html = format!(
        "<ol class=\"frontier\"><li>Few rays: <b>{}</b></li>",
        Escaped(&first.name)
    );
    // A later one may overtake before the one between does.
    let mut now = 0;
    while now + 1 < best.len() {
        let next = (now + 1..best.len()).min_by(|&a, &b| {
            break_even(best[now], best[a]).total_cmp(&break_even(best[now], best[b]))
        });
        let Some(next) = next else { break };
        let _ = write!(
            html,
            "<li>from {} rays on: <b>{}</b></li>",
            count(break_even(best[now], best[next]).ceil()),
            Escaped(&best[next].name)
        );
        now = next;
    }
    html + "</ol>"
}

/// A rectangle of the drawing.
#[derive(Clone, Copy)]
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Area {
    fn around([x, y]: [f64; 2], r: f64) -> Self {
        Self {
            left: x - r,
            right: x + r,
            top: y - r,
            bottom: y + r,
        }
    }
    fn overlap(&self, other: &Self) -> f64 {
        let wide = self.right.min(other.right) - self.left.max(other.left);
        let high = self.bottom.min(other.bottom) - self.top.max(other.top);
        wide.max(0.0) * high.max(0.0)
    }
}

/// Where a label disturbs least: beside its point, above or below it.
fn label_place(
    [x, y]: [f64; 2],
    letters: usize,
    frame: &Frame,
    taken: &[Area],
) -> (Area, &'static str) {
    let wide = letters as f64 * LETTER;
    let area = |left: f64, middle: f64| Area {
        left,
        right: left + wide,
        top: middle - 8.0,
        bottom: middle + 8.0,
    };
    let mut choices = Vec::new();
    for away in [0.0, 14.0, 26.0] {
        choices.push((area(x + 11.0, y - away), "start"));
        choices.push((area(x - 11.0 - wide, y - away), "end"));
        choices.push((area(x - wide / 2.0, y - 16.0 - away), "middle"));
        choices.push((area(x - wide / 2.0, y + 16.0 + away), "middle"));
        choices.push((area(x + 11.0, y + away), "start"));
        choices.push((area(x - 11.0 - wide, y + away), "end"));
    }
    let disturbance = |area: &Area| {
        let outside = (frame.left - area.left).max(0.0)
            + (area.right - frame.right).max(0.0)
            + (frame.top - area.top).max(0.0)
            + (area.bottom - frame.bottom).max(0.0);
        16.0 * outside + taken.iter().map(|other| area.overlap(other)).sum::<f64>()
    };
    choices
        .into_iter()
        .min_by(|a, b| disturbance(&a.0).total_cmp(&disturbance(&b.0)))
        .unwrap_or((area(x, y), "start"))
}
