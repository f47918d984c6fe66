//! The steps of a ray as a table to be read from above, indented by depth.

use super::Report;
use super::story::{ASIDE, BEHIND, BEYOND, MISSED, Met, OPENED, Summary, Told, What};
use crate::terminal::counted;

/// Deeper steps are indented no further.
const DEEPEST: u32 = 24;

/// The whole text.
pub fn tell(report: &Report<'_>) -> String {
    let mut text = format!(
        "scene      {}: {}\nstructure  {}\nray        from {} along {}, t from {} to {}{}\n",
        report.scene,
        counted(report.triangles as u64, "triangle"),
        report.structure,
        vector(report.ray.origin),
        vector(report.ray.direction),
        report.ray.t_min,
        end(report.ray.t_max),
        match report.pixel {
            Some([x, y]) => format!(" (pixel {x},{y})"),
            None => String::new(),
        },
    );
    let rows: Vec<[String; 4]> = report.steps.iter().map(row).collect();
    let heads = [
        "step",
        "node or primitive",
        "[enter, leave]",
        "what happens",
    ];
    let wide = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([heads[column].len()]).max().unwrap_or(0)
    };
    let widths = [wide(0), wide(1), wide(2)];
    let mut line = |[step, what, interval, said]: [&str; 4]| {
        let [a, b, c] = widths;
        let line = format!("{step:>a$}  {what:<b$}  {interval:>c$}  {said}");
        text += line.trim_end();
        text.push('\n');
    };
    line(["", "", "", ""]);
    line(heads);
    for row in &rows {
        line(row.each_ref().map(String::as_str));
    }
    text += &format!("\n{}\n", sum(&report.summary));
    text += &match &report.hit {
        None => "answer     the ray misses everything".to_string(),
        Some(hit) => format!(
            "answer     t = {} at {}: triangle {}{}, u = {}, v = {}",
            hit.t,
            vector(hit.point),
            hit.primitive,
            if hit.mesh.is_empty() {
                String::new()
            } else {
                format!(
                    " ({}, its triangle {}, placement {})",
                    one_line(&hit.mesh),
                    hit.triangle,
                    hit.placement
                )
            },
            hit.u,
            hit.v
        ),
    };
    text += if report.judge_agrees {
        "\njudge      testing every triangle gives the same bits"
    } else {
        "\njudge      DISAGREES: testing every triangle gives another answer; please report this"
    };
    text
}

/// Number, name, interval and what became of it.
fn row(told: &Told) -> [String; 4] {
    let indent = "  ".repeat(told.depth.min(DEEPEST) as usize);
    let (name, interval, said) = match &told.what {
        What::Box {
            node,
            enter,
            leave,
            verdict,
            ..
        } => (
            format!("box {node}"),
            format!("[{}, {}]", short(*enter), short(*leave)),
            match *verdict {
                OPENED => "opened".to_string(),
                ASIDE => "put aside: its sibling comes first".to_string(),
                MISSED => "missed: the ray's line passes it".to_string(),
                BEHIND => "behind: it ends before the ray begins".to_string(),
                BEYOND => format!(
                    "beyond: it begins after t = {}, where the ray now ends",
                    short(told.t_max)
                ),
                other => other.to_string(),
            },
        ),
        What::Plane {
            node,
            normal,
            offset,
            t,
            near,
            far,
        } => (
            format!("node {node}"),
            if t.is_finite() {
                format!("t = {}", short(*t))
            } else {
                "never crossed".into()
            },
            format!(
                "divided by {}: {}",
                plane(*normal, *offset),
                match (near, far) {
                    (true, true) => "both sides are visited, the near one first",
                    (true, false) => "only the near side is visited",
                    (false, true) => "only the far side is visited",
                    (false, false) => "neither side is visited",
                }
            ),
        ),
        What::Resumed {
            node,
            enter,
            dropped,
        } => (
            format!("box {node}"),
            format!("[{}, …]", short(*enter)),
            if *dropped {
                format!(
                    "dropped: it begins after t = {}, where the ray now ends",
                    short(told.t_max)
                )
            } else {
                "taken up again".to_string()
            },
        ),
        What::Leaf { node, primitives } => (
            format!("leaf {node}"),
            String::new(),
            format!("names {}", counted(u64::from(*primitives), "primitive")),
        ),
        What::Test { primitive, hits } => (
            format!("triangle {primitive}"),
            String::new(),
            if hits.is_empty() {
                "tested: no hit within the ray's interval".to_string()
            } else {
                hits.iter().map(hit).collect::<Vec<_>>().join("; ")
            },
        ),
        What::Repeated { primitive } => (
            format!("triangle {primitive}"),
            String::new(),
            "passed over: already tested in an earlier cell".to_string(),
        ),
        What::Other => (String::new(), String::new(), "another step".to_string()),
    };
    [told.step.to_string(), indent + &name, interval, said]
}

fn hit(hit: &Met) -> String {
    if hit.best {
        format!("HIT at t = {}: the ray now ends here", hit.t)
    } else {
        format!(
            "hit at t = {}, as near as the best so far: the lower number counts",
            hit.t
        )
    }
}

fn plane([x, y, z]: [f32; 3], offset: f32) -> String {
    match [x, y, z] {
        [1.0, 0.0, 0.0] => format!("x = {offset}"),
        [0.0, 1.0, 0.0] => format!("y = {offset}"),
        [0.0, 0.0, 1.0] => format!("z = {offset}"),
        _ => format!("{x} x + {y} y + {z} z = {offset}"),
    }
}

fn sum(s: &Summary) -> String {
    let mut parts = Vec::new();
    if s.boxes > 0 {
        parts.push(format!(
            "{} tested: {} opened, {} put aside, {} missed, {} behind, {} beyond",
            counted(s.boxes as u64, "box"),
            s.opened,
            s.put_aside,
            s.missed,
            s.behind,
            s.beyond
        ));
    }
    if s.planes > 0 {
        parts.push(format!(
            "{} crossed or passed",
            counted(s.planes as u64, "plane")
        ));
    }
    if s.resumed + s.dropped > 0 {
        parts.push(format!(
            "{} taken up again, {} dropped",
            s.resumed, s.dropped
        ));
    }
    if s.leaves > 0 {
        parts.push(counted(s.leaves as u64, "leaf"));
    }
    let mut tests = format!("{} tested", counted(s.tests as u64, "triangle"));
    if s.repeated > 0 {
        tests += &format!(", {} passed over", s.repeated);
    }
    parts.push(tests);
    parts.push(format!(
        "{}, of which {} shortened the ray",
        counted(s.hits as u64, "hit"),
        s.shortened
    ));
    format!("summary    {}", parts.join("\n           "))
}

fn vector(v: [f32; 3]) -> String {
    let [x, y, z] = v;
    format!("({x}, {y}, {z})")
}

fn end(t: f32) -> String {
    if t < f32::MAX {
        t.to_string()
    } else {
        "infinity".into()
    }
}

/// With the digits that fit a table.
pub fn short(t: f32) -> String {
    if t.abs() >= f32::MAX {
        return if t > 0.0 { "inf".into() } else { "-inf".into() };
    }
    let size = t.abs();
    if size != 0.0 && !(1.0e-3..1.0e6).contains(&size) {
        format!("{t:.3e}")
    } else {
        format!("{t:.4}")
    }
}

fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}
