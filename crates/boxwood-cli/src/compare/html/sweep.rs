//! A setting from one end to the other: time and steps per ray, the lecture's choice and the measured best.

use super::escape::Escaped;
use super::svg::{Frame, LogAxis, count, duration, nanoseconds, round};
use crate::compare::report::{Curve, Measured, Point, Sweep};
use std::fmt::Write;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 340.0;
/// Different curves' colours, again from the start when there are more.
const COLOURS: usize = 6;

/// One line of a panel.
struct Line<'a> {
    curve: &'a Curve,
    colour: usize,
    /// A class besides the colour, and what the line is called.
    class: &'static str,
    name: String,
    value: fn(&Measured) -> Option<f64>,
}

/// Three panels: what a ray takes, what it visits, what building takes.
pub fn panels(sweep: &Sweep) -> String {
    let lines = |name: &dyn Fn(&Curve) -> String, class, value: fn(&Measured) -> Option<f64>| {
        let line = |(colour, curve)| Line {
            curve,
            colour: colour % COLOURS,
            class,
            name: name(curve),
            value,
        };
        sweep
            .curves
            .iter()
            .enumerate()
            .map(line)
            .collect::<Vec<_>>()
    };
    let own = |curve: &Curve| curve.name.clone();
    let time = lines(&own, "", Measured::nanoseconds);
    // One structure's steps can be told apart; more would be a tangle.
    let visited = if sweep.curves.len() == 1 {
        let mut visited = lines(&|_| "primitives".to_string(), "", |m| m.primitives_per_ray);
        visited.extend(lines(&|_| "nodes".to_string(), "dashed", |m| {
            m.nodes_per_ray
        }));
        visited
    } else {
        lines(&own, "", Measured::steps_per_ray)
    };
    let build = lines(&own, "", |m| Some(m.build_seconds.max(1e-7)));
    let memory = lines(&own, "", |m| (m.bytes > 0).then_some(m.bytes as f64));
    [
        (
            "What a ray takes",
            "time per ray",
            time,
            nanoseconds as fn(f64) -> String,
        ),
        ("What a ray visits", "visited per ray", visited, count),
        ("What building takes", "time to build", build, duration),
        ("What it keeps", "bytes", memory, bytes),
    ]
    .map(|(title, label, lines, text)| {
        format!(
            "<figure class=\"plot\"><figcaption>{title}</figcaption>{}</figure>",
            panel(sweep, &lines, label, text)
        )
    })
    .concat()
}

fn bytes(n: f64) -> String {
    match n {
        n if n >= 1e9 => format!("{} GB", round(n / 1e9)),
        n if n >= 1e6 => format!("{} MB", round(n / 1e6)),
        n if n >= 1e3 => format!("{} kB", round(n / 1e3)),
        n => format!("{} B", round(n)),
    }
}

fn panel(sweep: &Sweep, lines: &[Line<'_>], label: &str, text: fn(f64) -> String) -> String {
    let frame = Frame {
        left: 76.0,
        right: WIDTH - 14.0,
        top: 34.0,
        bottom: HEIGHT - 48.0,
    };
    let values = |line: &Line<'_>| -> Vec<(f64, f64)> {
        let value = |point: &Point| {
            let value = (line.value)(point.structure.measured.as_ref()?)?;
            (value > 0.0).then_some((point.value, value))
        };
        line.curve.points.iter().filter_map(value).collect()
    };
    let all = lines.iter().flat_map(values);
    let x = LogAxis::around(
        all.clone().map(|p| p.0).chain([sweep.lecture]),
        frame.left,
        frame.right,
    );
    let y = LogAxis::around(all.map(|p| p.1), frame.bottom, frame.top);
    let mut svg = format!(
        r#"<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{label} by {}">"#,
        sweep.setting
    );
    svg += &frame.draw(&x, &y, [sweep.setting, label], [count, text]);
    let lecture = x.at(sweep.lecture);
    let _ = write!(
        svg,
        r#"<line class="lecture" x1="{lecture:.1}" x2="{lecture:.1}" y1="{}" y2="{}"/><text class="note" x="{lecture:.1}" y="{:.1}" text-anchor="middle">lecture: {}</text>"#,
        frame.top,
        frame.bottom,
        frame.top - 6.0,
        round(sweep.lecture)
    );
    let mut key = 0.0;
    for line in lines {
        let points: Vec<String> = values(line)
            .iter()
            .map(|(value, found)| format!("{:.1},{:.1}", x.at(*value), y.at(*found)))
            .collect();
        let class = format!("c{} {}", line.colour, line.class);
        let _ = write!(
            svg,
            r#"<polyline class="curve {class}" points="{}"/>"#,
            points.join(" ")
        );
        let best = line.curve.best.and_then(|i| line.curve.points.get(i));
        if let Some(best) = best
            && let Some(found) = best.structure.measured.as_ref().and_then(line.value)
            && found > 0.0
        {
            let _ = write!(
                svg,
                r#"<circle class="best {class}" cx="{:.1}" cy="{:.1}" r="5.5"><title>{}: best at {}</title></circle>"#,
                x.at(best.value),
                y.at(found),
                Escaped(&best.structure.structure),
                round(best.value)
            );
        }
        let _ = write!(
            svg,
            r#"<line class="curve {class}" x1="{:.1}" x2="{:.1}" y1="9" y2="9"/><text class="label" x="{:.1}" y="13">{}</text>"#,
            frame.left + key,
            frame.left + key + 18.0,
            frame.left + key + 23.0,
            Escaped(&line.name)
        );
        key += 36.0 + 7.0 * line.name.chars().count() as f64;
    }
    svg + "</svg>"
}

/// Where the best lies and how far the lecture's choice is from it, one sentence per curve.
pub fn verdicts(sweep: &Sweep) -> String {
    let verdict = |curve: &Curve| {
        let best = curve.points.get(curve.best?)?;
        let rate = |p: &Point| p.structure.measured.as_ref()?.mrays_per_second;
        let lecture = curve.points.iter().find(|p| p.value == sweep.lecture);
        let share = lecture.and_then(|p| Some(rate(p)? / rate(best)?));
        let tail = match share {
            Some(share) if share >= 0.995 => "; the lecture's choice is as good".to_string(),
            Some(share) => format!(
                "; the lecture’s {} reaches {:.0} % of it",
                round(sweep.lecture),
                100.0 * share
            ),
            None => String::new(),
        };
        Some(format!(
            "<li><b>{}</b>: best at {} {}, {} million rays per second{tail}.</li>",
            Escaped(&curve.name),
            round(best.value),
            sweep.setting,
            round(rate(best)?)
        ))
    };
    let verdicts: String = sweep.curves.iter().filter_map(verdict).collect();
    format!("<ul class=\"verdicts\">{verdicts}</ul>")
}
