//! One scene of walls, divided by an octree (in the plane a quadtree), a kd-tree and a BSP tree.

use super::flat::{Wall, asked, each, fan, tall};
use super::resolution::inverse;
use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use crate::failure::Outcome;
use crate::svg::{INK, color, path, section};
use boxwood::{Intersect, Limits};
use boxwood_render::build_structure;
use std::f32::consts::TAU;

const GAP: f64 = 18.0;
const SIDE: f64 = (INNER - 2.0 * GAP) / 3.0;

pub fn draw() -> Outcome<String> {
    let walls = walls();
    let mesh = tall(&walls)?;
    let mut sheet = Sheet::new(
        "Octree, kd-tree and BSP tree side by side",
        format!(
            "The same {} walls: a quadtree (an octree in the plane) halves both axes, a kd-tree cuts across one axis anywhere, a \
             BSP tree cuts in any direction where that pays.",
            walls.len()
        ),
    );
    let rays: Vec<_> = [[0.1, 0.1], [9.9, 0.2], [0.2, 9.8], [9.8, 9.9]]
        .into_iter()
        .zip([[0.0, 0.25], [0.25, 0.5], [0.75, 1.0], [0.5, 0.75]])
        .flat_map(|(origin, turns)| fan(origin, turns, 100))
        .collect();
    let top = sheet.below;
    for (k, (name, kind)) in [
        ("Octree (quadtree)", "octree:leaf=1,axes=xy"),
        ("kd-tree", "kd:sah,leaf=1,axes=xy"),
        ("BSP tree", "bsp:leaf=1,axes=xy"),
    ]
    .into_iter()
    .enumerate()
    {
        let tree = build_structure(kind.parse()?, &mesh, &Limits::NONE)?;
        let x = MARGIN + k as f64 * (SIDE + GAP);
        sheet.add(
            words([x, top + 14.0], name)
                .with("font-weight", "bold")
                .with("font-size", 14),
        );
        let mut panel = Panel::new([[-0.1; 2], [10.1; 2]], [x, top + 24.0], [SIDE, SIDE]);
        draw_cells(&*tree, &mut panel);
        let lines: Vec<[[f64; 2]; 2]> = walls
            .iter()
            .map(|wall| wall.map(|p| panel.place(p)))
            .collect();
        let drawn = path(lines.iter().map(|wall| &wall[..]), false);
        panel.add(
            drawn
                .with("fill", "none")
                .with("stroke", INK)
                .with("stroke-width", 2.4)
                .with("stroke-linecap", "round"),
        );
        sheet.add(panel.finish());
        let numbers = tree.statistics();
        let stats = asked(&*tree, &rays);
        let lines = [
            format!(
                "{} nodes, {} leaves, depth {}",
                numbers.nodes, numbers.leaves, numbers.depth
            ),
            format!("{} references", numbers.references),
            format!("nodes per ray  {}", each(stats.nodes, &rays)),
            format!("tests per ray  {}", each(stats.primitives, &rays)),
        ];
        for (row, text) in lines.into_iter().enumerate() {
            sheet.say([x, top + SIDE + 48.0 + 20.0 * row as f64], text);
        }
    }
    sheet.below = top + SIDE + 136.0;
    sheet.note(
        [MARGIN, sheet.below],
        format!("Means over {} rays from the four corners. The colour of a cell is its level; a node of a BSP tree costs more than one of a kd-tree.", rays.len()),
    );
    Ok(sheet.finish())
}

/// Leaves, each in the colour of its level.
fn draw_cells(tree: &dyn Intersect, panel: &mut Panel) {
    let deepest = tree.statistics().depth.max(1) as f64;
    tree.cells(&mut |cell| {
        let Some(count) = cell.primitives else { return };
        let color = color(f64::from(cell.depth) / deepest);
        let shape = if cell.sides.is_empty() {
            panel.rectangle(&cell.bounds)
        } else {
            let cuts = cell.sides.iter().filter_map(|side| section(side, (2, 0.0)));
            let middle: Vec<[f64; 2]> = cuts.flatten().map(|p| panel.window.place(p)).collect();
            path([&around(middle)[..]], true)
        };
        let opacity = if count > 0 { 0.22 } else { 0.05 };
        panel.add(
            shape
                .with("fill", &color)
                .with("fill-opacity", opacity)
                .with("stroke", &color)
                .with("stroke-width", 0.9),
        );
    });
}

/// Corners of a convex polygon, in order around it.
fn around(mut corners: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let count = corners.len().max(1) as f64;
    let middle = [0, 1].map(|k| corners.iter().map(|p| p[k]).sum::<f64>() / count);
    let angle = |p: &[f64; 2]| (p[1] - middle[1]).atan2(p[0] - middle[0]);
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    corners.dedup_by(|a, b| (a[0] - b[0]).abs() < 0.01 && (a[1] - b[1]).abs() < 0.01);
    corners
}

/// Two slanted houses and some short walls.
fn walls() -> Vec<Wall> {
    let mut walls = Vec::new();
    for (middle, size, turn) in [
        ([3.0, 6.8], [1.9, 1.2], 0.07_f32),
        ([6.9, 3.2], [2.2, 1.1], -0.08),
    ] {
        let (sin, cos) = (TAU * turn).sin_cos();
        let corner = |sx: f32, sy: f32| {
            let (x, y) = (sx * size[0], sy * size[1]);
            [middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y]
        };
        let ring = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        walls.extend((0..4).map(|k| [ring[k], ring[(k + 1) % 4]]));
    }
    for k in 1..=8_u32 {
        let (a, turn) = (inverse(k, 2), inverse(k, 3));
        let (sin, cos) = (TAU * turn).sin_cos();
        let edge = if k % 2 == 0 { 0.9 } else { 8.6 };
        let [x, y] = [0.8 + 8.4 * a, edge + 0.5 * turn];
        walls.push([
            [x - 0.5 * cos, y - 0.5 * sin],
            [x + 0.5 * cos, y + 0.5 * sin],
        ]);
    }
    walls
}
