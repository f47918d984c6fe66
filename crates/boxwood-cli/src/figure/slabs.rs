//! A box as the overlap of slabs: what lies in all of them, lies in the box.

use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use crate::failure::Outcome;
use crate::svg::{BLUE, Element, GREEN, INK, ORANGE, RED, dot, group, line, rectangle};
use boxwood::{Aabb, PreparedRay, Ray, plane};

const GAP: f64 = 20.0;
const SIDE: f64 = 0.5 * (INNER - GAP);

pub fn draw() -> Outcome<String> {
    let mut sheet = Sheet::new(
        "Slabs and their intervals",
        "Two parallel planes are a slab. A ray is in each slab for an interval of t; it is in the box while it is in both slabs, so the box \
         is entered at the last entry and left at the first exit.",
    );
    let b = Aabb::new([3.0, 2.0, -1.0], [6.0, 4.0, 1.0]);
    let top = sheet.below;
    for (k, (ray, word)) in [
        (plane::ray([0.5, 1.0], [1.0, 0.45]), "The intervals overlap"),
        (plane::ray([0.5, 2.4], [1.0, 0.75]), "They do not"),
    ]
    .into_iter()
    .enumerate()
    {
        let x = MARGIN + k as f64 * (SIDE + GAP);
        let met = b.intersect(&ray);
        sheet.say(
            [x, top + 12.0],
            match met {
                Some((enter, leave)) => {
                    format!("{word}: the ray is in the box from t = {enter:.2} to {leave:.2}")
                }
                None => format!("{word}: the ray misses the box"),
            },
        );
        sheet.add(scene(&b, &ray, [x, top + 22.0]));
        sheet.add(bars(&b, &ray, [x, top + 350.0], SIDE, 8.0));
    }
    sheet.below = top + 350.0 + BARS;
    Ok(sheet.finish())
}

fn scene(b: &Aabb, ray: &Ray, corner: [f64; 2]) -> Element {
    let seen = [[0.0, 0.0], [8.2, 6.2]];
    let mut panel = Panel::new(seen, corner, [SIDE, SIDE * 6.2 / 8.2]);
    for (axis, color) in [(0, BLUE), (1, ORANGE)] {
        let slab = slab(b, axis, 20.0);
        panel.add(
            panel
                .rectangle(&slab)
                .with("fill", color)
                .with("fill-opacity", 0.14)
                .with("stroke", color),
        );
    }
    panel.add(
        panel
            .rectangle(b)
            .with("fill", "none")
            .with("stroke", INK)
            .with("stroke-width", 2),
    );
    let met = b.intersect(ray);
    panel.ray(ray, 7.2);
    for (axis, color) in [(0, BLUE), (1, ORANGE)] {
        let Some((enter, leave)) = interval(b, ray, axis) else {
            continue;
        };
        for t in [enter, leave] {
            panel.add(dot(panel.window.place(ray.at(t)), 4.0).with("fill", color));
        }
    }
    if let Some((enter, leave)) = met {
        let [from, to] = [enter, leave].map(|t| panel.window.place(ray.at(t)));
        panel.add(
            line(from, to)
                .with("stroke", GREEN)
                .with("stroke-width", 4)
                .with("stroke-opacity", 0.6),
        );
    }
    let [x, y] = panel.place([4.5, 5.9]);
    panel.add(
        words([x, y], "x slab")
            .with("fill", BLUE)
            .with("text-anchor", "middle"),
    );
    let [x, y] = panel.place([7.2, 2.15]);
    panel.add(
        words([x, y], "y slab")
            .with("fill", ORANGE)
            .with("text-anchor", "middle"),
    );
    panel.finish()
}

/// The box that a slab alone is, so long that it seems to have no end.
pub fn slab(b: &Aabb, axis: usize, long: f32) -> Aabb {
    let mut slab = Aabb::new([-long; 3], [long; 3]);
    slab.lower[axis] = b.lower[axis];
    slab.upper[axis] = b.upper[axis];
    slab
}

/// Where a ray's whole line is in a slab; the trees' own slab test says it.
pub fn interval(b: &Aabb, ray: &Ray, axis: usize) -> Option<(f32, f32)> {
    let prepared = PreparedRay::new(ray, b.scale())?;
    Some(prepared.slabs(&slab(b, axis, f32::INFINITY)))
}

/// How tall [`bars`] are.
pub const BARS: f64 = 96.0;

/// Three intervals above an axis of t: that in the x slab, that in the y slab, and what they have in common.
pub fn bars(b: &Aabb, ray: &Ray, [x, y]: [f64; 2], width: f64, most: f64) -> Element {
    let mut drawn = group();
    let (left, least) = (x + 52.0, -1.0_f64);
    let scale = (width - 62.0) / (most - least);
    let at = |t: f32| left + (f64::from(t).clamp(least, most) - least) * scale;
    let mut bar = |row: usize, name: &str, color: &str, ends: Option<(f32, f32)>| {
        let y = y + 20.0 * row as f64;
        drawn.add(words([x, y + 12.0], name).with("fill", color));
        match ends {
            Some((enter, leave)) => {
                let wide = (at(leave) - at(enter)).max(3.0);
                drawn.add(rectangle([at(enter), y + 2.0], [wide, 11.0]).with("fill", color));
            }
            None => drawn.add(words([at(0.0) + 6.0, y + 12.0], "empty").with("fill", color)),
        }
    };
    bar(0, "in x", BLUE, interval(b, ray, 0));
    bar(1, "in y", ORANGE, interval(b, ray, 1));
    let met = b.intersect(ray);
    bar(2, "in both", if met.is_some() { GREEN } else { RED }, met);
    let base = y + 66.0;
    drawn.add(line([left, base], [left + (most - least) * scale, base]).with("stroke", INK));
    for t in 0..=most as i32 {
        let x = at(t as f32);
        drawn.add(line([x, base], [x, base + 4.0]).with("stroke", INK));
        drawn.add(
            words([x, base + 17.0], t)
                .with("text-anchor", "middle")
                .with("font-size", 12),
        );
    }
    drawn.add(words([x, base + 17.0], "t ="));
    // Where the ray begins.
    drawn.add(
        line([at(0.0), y], [at(0.0), base])
            .with("stroke", INK)
            .with("stroke-dasharray", "2 3"),
    );
    drawn
}
