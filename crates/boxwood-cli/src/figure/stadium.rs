//! The teapot in the stadium, in the plane: a detailed small thing in a large place.

use super::flat::{Flat, asked, each, fan};
use super::resolution::lines;
use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use crate::failure::Outcome;
use crate::svg::{BLUE, GREEN, INK, ORANGE, RED, path, rectangle, rectangles};
use crate::terminal::grouped;
use boxwood::{Aabb, Intersect, plane};
use std::f32::consts::TAU;

const GAP: f64 = 20.0;
const SIDE: f64 = 0.5 * (INNER - GAP);
const TALL: f64 = 190.0;
/// Pieces of the teapot's outline.
const PIECES: usize = 320;
const MIDDLE: [f32; 2] = [52.0, 1.1];

pub fn draw() -> Outcome<String> {
    let flat = Flat::new(scene())?;
    let rays = fan([38.0, 4.0], [-0.056, -0.012], 200);
    let mut sheet = Sheet::new(
        "The teapot in the stadium",
        format!(
            "A uniform grid has one size of cell for all: the teapot's {PIECES} pieces fall into a handful of cells. Two-level \
             grids and trees have small cells where there is much, and stay well."
        ),
    );
    let top = sheet.below;
    for (k, (name, kind, color)) in [
        ("Uniform grid", "grid:c=9,axes=xy", RED),
        ("Two-level grid", "grid2:axes=xy", GREEN),
        ("kd-tree", "kd:sah,axes=xy", GREEN),
        ("Bounding volume hierarchy", "bvh:binned,axes=xy", GREEN),
    ]
    .into_iter()
    .enumerate()
    {
        let structure = flat.build(kind)?;
        let x = MARGIN + (k % 2) as f64 * (SIDE + GAP);
        let y = top + (k / 2) as f64 * (TALL + 72.0);
        let stats = asked(&*structure, &rays);
        sheet.add(
            words([x, y + 14.0], name)
                .with("font-weight", "bold")
                .with("font-size", 14),
        );
        let whole = Panel::new(
            [[-2.0, -3.0], [102.0, 42.0]],
            [x, y + 22.0],
            [SIDE - TALL - 8.0, TALL],
        );
        let close = [[MIDDLE[0] - 3.0, -0.4], [MIDDLE[0] + 3.0, 5.6]];
        let near = Panel::new(close, [x + SIDE - TALL, y + 22.0], [TALL, TALL]);
        for (panel, zoomed) in [(whole, false), (near, true)] {
            sheet.add(view(&flat, &*structure, panel, [zoomed, k == 0], close));
        }
        let numbers = structure.statistics();
        sheet.add(
            words(
                [x, y + TALL + 40.0],
                format!(
                    "per ray: {} nodes or cells, {} tests of {}",
                    each(stats.nodes, &rays),
                    each(stats.primitives, &rays),
                    grouped(numbers.primitives as u64)
                ),
            )
            .with("font-weight", "bold")
            .with("fill", color),
        );
    }
    sheet.below = top + 2.0 * (TALL + 72.0);
    sheet.note(
        [MARGIN, sheet.below - 4.0],
        format!("Left the whole stadium, right the teapot in it. Means over {} rays from the stands to the teapot.", rays.len()),
    );
    Ok(sheet.finish())
}

/// The cells that hold something, and the scene.
fn view(
    flat: &Flat,
    structure: &dyn Intersect,
    mut panel: Panel,
    [zoomed, uniform]: [bool; 2],
    close: [[f32; 2]; 2],
) -> crate::svg::Element {
    let [[l, b], [r, t]] = close;
    let shown =
        |c: &Aabb| !zoomed || c.lower.x <= r && c.upper.x >= l && c.lower.y <= t && c.upper.y >= b;
    let mut filled: Vec<[[f64; 2]; 2]> = Vec::new();
    let mut empty: Vec<[[f64; 2]; 2]> = Vec::new();
    let mut corners: Vec<[[f64; 2]; 3]> = Vec::new();
    structure.cells(&mut |cell| {
        if !shown(&cell.bounds) {
            return;
        }
        let [corner, size] = panel.window.rectangle(&cell.bounds);
        let [[x, y], [w, h]] = [corner, size];
        corners.push([[x + w, y], [x, y], [x, y + h]]);
        // Nobody sees less.
        if size[0].max(size[1]) < 2.0 {
            return;
        }
        match cell.primitives {
            Some(1..) => filled.push([corner, size]),
            _ => empty.push([corner, size]),
        }
    });
    // Cells that lie in rows and columns are drawn as such.
    if uniform {
        let grid = lines(&corners);
        let grid = path(grid.iter().map(|run| &run[..]), false).with("fill", "none");
        panel.add(grid.with("stroke", BLUE).with("stroke-width", 0.35));
        empty.clear();
    }
    for (cells, color, opacity) in [(empty, BLUE, 0.0), (filled, ORANGE, 0.25)] {
        let shape = rectangles(&cells);
        let shape = shape.with("fill", color).with("fill-opacity", opacity);
        panel.add(shape.with("stroke", BLUE).with("stroke-width", 0.35));
    }
    let count = flat.scene.figures().len();
    // From afar some of the teapot's pieces will do.
    let step = if zoomed { 1 } else { 12 };
    let pieces = (count - PIECES..count).step_by(step);
    let lines = flat.draw(&panel, (0..count - PIECES).chain(pieces));
    panel.add(lines.with("fill", "none").with("stroke", INK));
    if !zoomed {
        let [p, q] = [close[0], close[1]].map(|p| panel.place(p));
        let frame = rectangle([p[0], q[1]], [q[0] - p[0], p[1] - q[1]]);
        panel.add(
            frame
                .with("fill", "none")
                .with("stroke", RED)
                .with("stroke-width", 1.2),
        );
    }
    panel.finish()
}

/// Walls, a floor, rows of seats on both sides, and the outline of a teapot in many pieces.
fn scene() -> plane::Scene {
    let mut scene = plane::Scene::new()
        .segment([0.0, 0.0], [100.0, 0.0])
        .segment([0.0, 0.0], [0.0, 40.0])
        .segment([100.0, 0.0], [100.0, 40.0])
        .segment([0.0, 40.0], [30.0, 38.0])
        .segment([100.0, 40.0], [70.0, 38.0]);
    for row in 0..12 {
        let (x, y) = (30.0 - 2.4 * row as f32, 1.0 + 2.0 * row as f32);
        scene = scene
            .rectangle([x - 2.0, y - 0.8], [x, y])
            .rectangle([100.0 - x, y - 0.8], [102.0 - x, y]);
    }
    let corners: Vec<[f32; 2]> = (0..PIECES)
        .map(|k| outline(k as f32 / PIECES as f32))
        .collect();
    for k in 0..PIECES {
        scene = scene.segment(corners[k], corners[(k + 1) % PIECES]);
    }
    scene
}

/// The outline of a teapot: a body, a spout to the right, a handle to the left, and a knob.
fn outline(share: f32) -> [f32; 2] {
    let angle = TAU * share;
    let bump = |at: f32, wide: f32, high: f32| {
        let mut off = (angle - at).abs();
        off = off.min(TAU - off);
        high * (-(off / wide) * (off / wide)).exp()
    };
    let r =
        1.0 + bump(0.45, 0.14, 0.9) + bump(TAU * 0.25, 0.12, 0.35) + bump(TAU * 0.46, 0.28, 0.55);
    let squeeze = if angle.sin() < 0.0 { 0.85 } else { 0.95 };
    [
        MIDDLE[0] + 1.15 * r * angle.cos(),
        MIDDLE[1] + squeeze * r * angle.sin(),
    ]
}
