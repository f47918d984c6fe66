//! How many cells a grid should have: too few, about right, too many, with what rays pay for them.

use super::flat::{Flat, asked, each, fan};
use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use crate::failure::Outcome;
use crate::svg::{BLUE, GREEN, INK, RED, path};
use crate::terminal::grouped;
use boxwood::{Ray, plane};

const GAP: f64 = 18.0;
const SIDE: f64 = (INNER - 2.0 * GAP) / 3.0;
/// Places along each side of the scene, less one.
const THINGS: u32 = 12;

pub fn draw() -> Outcome<String> {
    let flat = Flat::new(confetti())?;
    let count = flat.scene.figures().len();
    let mut sheet = Sheet::new(
        "How many cells?",
        format!(
            "C = cells per object: too few cells hold too much, too many are too many steps; in space C = 27 = 3³ (3 cells per \
             object and axis) is a good start, in the plane its like is C = 3² = 9 (here {count} objects)."
        ),
    );
    let rays: Vec<Ray> = [[0.2, 0.3], [11.8, 0.4], [0.3, 11.7]]
        .into_iter()
        .zip([[0.01, 0.24], [0.26, 0.49], [0.76, 0.99]])
        .flat_map(|(origin, turns)| fan(origin, turns, 100))
        .collect();
    let top = sheet.below;
    for (k, (c, name, color)) in [
        ("0.06", "Too coarse", RED),
        ("9", "About right", GREEN),
        ("900", "Too fine", RED),
    ]
    .into_iter()
    .enumerate()
    {
        let grid = flat.build(&format!("grid:c={c},axes=xy"))?;
        let x = MARGIN + k as f64 * (SIDE + GAP);
        let mut panel = Panel::new([[-0.2; 2], [12.2; 2]], [x, top + 24.0], [SIDE, SIDE]);
        let mut cells = 0;
        let mut outlines = Vec::new();
        grid.cells(&mut |cell| {
            cells += 1;
            let [[x, y], [w, h]] = panel.window.rectangle(&cell.bounds);
            outlines.push([[x + w, y], [x, y], [x, y + h]]);
        });
        panel.add(flat.draw_all(&panel));
        let lines = path(lines(&outlines).iter().map(|run| &run[..]), false);
        panel.add(
            lines
                .with("fill", "none")
                .with("stroke", BLUE)
                .with("stroke-width", if cells > 2000 { 0.25 } else { 0.8 }),
        );
        sheet.add(
            words(
                [x, top + 14.0],
                format!("{name}: C = {c}, {} cells", grouped(cells)),
            )
            .with("font-weight", "bold")
            .with("fill", color),
        );
        sheet.add(panel.finish());
        let stats = asked(&*grid, &rays);
        let y = top + SIDE + 46.0;
        let total = stats.nodes + stats.primitives;
        sheet.say(
            [x, y],
            format!("steps per ray  {}", each(stats.nodes, &rays)),
        );
        sheet.say(
            [x, y + 19.0],
            format!("tests per ray  {}", each(stats.primitives, &rays)),
        );
        sheet.add(
            words([x, y + 38.0], format!("together  {}", each(total, &rays)))
                .with("font-weight", "bold")
                .with("fill", INK),
        );
    }
    sheet.below = top + SIDE + 116.0;
    sheet.note(
        [MARGIN, sheet.below - 4.0],
        format!("Means over {} rays. A step is a cell, or a brick of 4 × 4 cells: an empty brick is passed in one.", rays.len()),
    );
    Ok(sheet.finish())
}

/// The distinct lines of a grid, each once, from the corners of its cells.
pub fn lines(cells: &[[[f64; 2]; 3]]) -> Vec<[[f64; 2]; 2]> {
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for [a, b, c] in cells {
        xs.extend([a[0], b[0]]);
        ys.extend([b[1], c[1]]);
    }
    for (k, list) in [&mut xs, &mut ys].into_iter().enumerate() {
        list.sort_by(f64::total_cmp);
        list.dedup_by(|a, b| (*a - *b).abs() < 0.02);
        low[k] = list.first().copied().unwrap_or(0.0);
        high[k] = list.last().copied().unwrap_or(0.0);
    }
    let down = xs.into_iter().map(|x| [[x, low[1]], [x, high[1]]]);
    let across = ys.into_iter().map(|y| [[low[0], y], [high[0], y]]);
    down.chain(across).collect()
}

/// Small things all over the place, the same every time.
fn confetti() -> plane::Scene {
    let mut scene = plane::Scene::new();
    for k in 0..THINGS * THINGS {
        let [a, b, c] = [2, 3, 5].map(|base| inverse(k + 1, base));
        let (x, y, r) = (0.3 + 11.4 * a, 0.3 + 11.4 * b, 0.04 + 0.1 * c);
        scene = match k / 5 % 3 {
            0 => scene.circle([x, y], r),
            1 => scene.triangle([[x - r, y - r], [x + 1.2 * r, y - 0.6 * r], [x, y + r]]),
            _ => scene.segment([x - 2.0 * r, y - r], [x + 2.0 * r, y + r]),
        };
    }
    scene
}

/// The digits of a number backwards behind the point (Halton 1960): evenly scattered, and never the same place twice.
pub fn inverse(mut k: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0, 1.0 / base as f32);
    while k > 0 {
        value += digit * (k % base) as f32;
        k /= base;
        digit /= base as f32;
    }
    value
}
