//! Sorting objects into two boxes against cutting space in two, and the trees that come of it.

use super::flat::{Flat, Wall, asked, each, fan, tall};
use super::resolution::inverse;
use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use crate::failure::Outcome;
use crate::svg::{BLUE, GREEN, ORANGE, RED};
use boxwood::{Aabb, Axes, BinaryTree, Bvh, Ray, SpatialSplit, SweepSah, plane};

const GAP: f64 = 20.0;
const SIDE: f64 = 0.5 * (INNER - GAP);
const TALL: f64 = SIDE * 0.62;

pub fn draw() -> Outcome<String> {
    let sticks = sticks();
    let mesh = tall(&sticks)?;
    let drawn = |scene: plane::Scene, [from, to]: &Wall| scene.segment(*from, *to);
    let flat = Flat::new(sticks.iter().fold(plane::Scene::new(), drawn))?;
    let objects = SweepSah {
        axes: Axes::XY,
        max_leaf: 2,
        ..SweepSah::default()
    }
    .build(&mesh);
    let spatial = SpatialSplit {
        axes: Axes::XY,
        max_leaf: 2,
        budget: 2.0,
        ..SpatialSplit::default()
    }
    .build(&mesh);
    let mut sheet = Sheet::new(
        "Spatial splits against object partition",
        "Long slanted objects have large boxes. Sorting them into two groups leaves boxes that overlap; cutting space, and the \
         objects with it, keeps boxes apart at the price of naming some objects twice.",
    );
    let rays: Vec<Ray> = [[-0.5, 0.0], [16.5, 0.2], [-0.4, 9.6]]
        .into_iter()
        .zip([[0.0, 0.2], [0.3, 0.5], [0.8, 1.0]])
        .flat_map(|(origin, turns)| fan(origin, turns, 100))
        .collect();
    let top = sheet.below;
    for (k, (name, tree)) in [
        ("Object partition (SAH sweep)", &objects),
        ("With spatial splits (SBVH)", &spatial),
    ]
    .into_iter()
    .enumerate()
    {
        let x = MARGIN + k as f64 * (SIDE + GAP);
        sheet.add(
            words([x, top + 14.0], name)
                .with("font-weight", "bold")
                .with("font-size", 14),
        );
        let first = siblings(tree).next();
        for (row, all) in [(0, false), (1, true)] {
            let y = top + 24.0 + row as f64 * (TALL + 32.0);
            let mut panel = Panel::new([[-1.0, -0.4], [17.0, 10.4]], [x, y], [SIDE, TALL]);
            panel.add(flat.draw_all(&panel).with("stroke-width", 1.6));
            for pair in siblings(tree).take(if all { usize::MAX } else { 1 }) {
                for (b, color) in pair.iter().zip([BLUE, ORANGE]) {
                    let shape = panel.rectangle(b).with("fill", color);
                    let shape = shape.with("fill-opacity", if all { 0.0 } else { 0.12 });
                    panel.add(
                        shape
                            .with("stroke", color)
                            .with("stroke-width", if all { 0.7 } else { 2.0 }),
                    );
                }
                let both = pair[0].intersection(pair[1]);
                if !both.is_empty() {
                    panel.add(
                        panel
                            .rectangle(&both)
                            .with("fill", RED)
                            .with("fill-opacity", if all { 0.14 } else { 0.3 }),
                    );
                }
            }
            sheet.add(panel.finish());
            let text = match (all, first) {
                (false, Some(pair)) => format!(
                    "first division: the two boxes share {:.1} of {:.1}",
                    flat_area(&pair[0].intersection(pair[1])),
                    flat_area(&tree.nodes[0].bounds)
                ),
                _ => {
                    let shared: f32 = siblings(tree)
                        .map(|pair| flat_area(&pair[0].intersection(pair[1])))
                        .sum();
                    format!("all divisions: siblings share {shared:.1} in all")
                }
            };
            sheet.add(words([x, y + TALL + 18.0], text).with("fill", RED));
        }
        let bvh = Bvh::new(&mesh, tree.clone());
        let stats = asked(&bvh, &rays);
        let text = format!(
            "{} references to {} objects; per ray {} nodes, {} tests",
            tree.order.len(),
            flat.scene.figures().len(),
            each(stats.nodes, &rays),
            each(stats.primitives, &rays)
        );
        sheet.add(
            words([x, top + 24.0 + 2.0 * (TALL + 32.0) + 12.0], text)
                .with("font-weight", "bold")
                .with("fill", if k == 0 { RED } else { GREEN }),
        );
    }
    sheet.below = top + 24.0 + 2.0 * (TALL + 32.0) + 38.0;
    sheet.note([MARGIN, sheet.below], format!("Red: where two boxes with the same parent overlap. Areas in the scene's units; means over {} rays.", rays.len()));
    Ok(sheet.finish())
}

/// The boxes of each pair of children, the root's first.
fn siblings(tree: &BinaryTree) -> impl Iterator<Item = [Aabb; 2]> {
    let inner = tree.nodes.iter().filter(|node| !node.is_leaf());
    inner.map(|node| node.children().map(|child| tree.nodes[child].bounds))
}

fn flat_area(b: &Aabb) -> f32 {
    let size = b.size();
    size.x * size.y
}

/// Many short sticks, and a few that cross everything.
fn sticks() -> Vec<Wall> {
    let mut sticks = vec![
        [[0.2, 0.6], [15.6, 9.2]],
        [[0.6, 9.4], [15.0, 1.4]],
        [[1.0, 4.4], [15.8, 6.6]],
    ];
    sticks.extend((1..=24_u32).map(|k| {
        let (x, y, c) = (
            0.8 + 14.4 * inverse(k, 2),
            0.8 + 8.4 * inverse(k, 3),
            inverse(k, 5),
        );
        let (dx, dy) = (0.3 + 0.3 * c, if k % 2 == 0 { -0.4 } else { 0.5 });
        [[x - dx, y - dy], [x + dx, y + dy]]
    }));
    sticks
}
