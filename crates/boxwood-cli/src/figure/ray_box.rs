//! The cases of a ray against a box, each with what the code answers.

use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use super::slabs::{BARS, bars};
use crate::failure::Outcome;
use crate::svg::{BLUE, GREEN, RED};
use boxwood::{Aabb, Ray, plane};

const GAP: f64 = 18.0;
const SIDE: f64 = (INNER - 2.0 * GAP) / 3.0;
const TALL: f64 = 190.0;

pub fn draw() -> Outcome<String> {
    let mut sheet = Sheet::new(
        "A ray against a box",
        "A box counts as entered where t_enter ≤ t_leave, also where both are equal: boxes are closed, and a vertex in the corner \
         or a wall in a flat box can be hit at exactly that t.",
    );
    let b = Aabb::new([2.0, 1.0, -1.0], [4.0, 3.0, 1.0]);
    let flat = Aabb::new([3.0, 0.5, -1.0], [3.0, 3.5, 1.0]);
    let cases: [(&str, Aabb, Ray, f32); 6] = [
        ("From outside", b, plane::ray([0.3, 1.2], [1.0, 0.3]), 5.0),
        (
            "From inside: t begins at 0",
            b,
            plane::ray([2.8, 1.6], [1.0, 0.3]),
            2.6,
        ),
        (
            "Behind: the box ends before t = 0",
            b,
            plane::ray([4.6, 2.2], [1.0, 0.2]),
            1.1,
        ),
        (
            "Passed: no common t",
            b,
            plane::ray([0.4, 2.2], [1.0, 0.7]),
            2.3,
        ),
        (
            "A corner touched",
            b,
            plane::ray([1.0, 2.0], [1.0, -1.0]),
            1.8,
        ),
        (
            "A flat box: a wall along an axis",
            flat,
            plane::ray([0.5, 1.2], [1.0, 0.4]),
            5.0,
        ),
    ];
    let top = sheet.below;
    for (k, (name, b, ray, end)) in cases.into_iter().enumerate() {
        let x = MARGIN + (k % 3) as f64 * (SIDE + GAP);
        let y = top + (k / 3) as f64 * (TALL + BARS + 76.0);
        sheet.add(words([x, y + 12.0], name).with("font-weight", "bold"));
        let met = b.intersect(&ray);
        let color = if met.is_some() { GREEN } else { RED };
        let answer = match met {
            Some((enter, leave)) if enter == leave => {
                format!("entered: t_enter = t_leave = {enter:.2}")
            }
            Some((enter, leave)) => format!("entered: t from {enter:.2} to {leave:.2}"),
            None => "not entered".into(),
        };
        let mut panel = Panel::new([[0.0, 0.0], [6.0, 4.0]], [x, y + 20.0], [SIDE, TALL]);
        let shape = panel
            .rectangle(&b)
            .with("fill", BLUE)
            .with("fill-opacity", 0.15);
        // A flat one is a line.
        let [from, to] = [[b.lower.x, b.lower.y], [b.lower.x, b.upper.y]].map(|p| panel.place(p));
        panel.add(shape.with("stroke", BLUE).with("stroke-width", 2));
        panel.add(
            crate::svg::line(from, to)
                .with("stroke", BLUE)
                .with("stroke-width", 2),
        );
        panel.ray(&ray, end);
        if let Some((enter, leave)) = met {
            for t in [enter, leave] {
                let place = panel.window.place(ray.at(t));
                panel.add(crate::svg::dot(place, 4.5).with("fill", GREEN));
            }
        }
        sheet.add(panel.finish());
        sheet.add(words([x, y + TALL + 38.0], answer).with("fill", color));
        sheet.add(bars(&b, &ray, [x, y + TALL + 46.0], SIDE, 4.0));
    }
    sheet.below = top + 2.0 * (TALL + BARS + 76.0) - 20.0;
    Ok(sheet.finish())
}
