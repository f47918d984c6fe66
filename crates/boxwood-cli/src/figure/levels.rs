//! How trees grow: their nodes level by level.

use super::flat::Flat;
use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use crate::failure::Outcome;
use crate::svg::{BLUE, GREEN, PALE};
use crate::terminal::counted;
use boxwood::{Aabb, Intersect};

/// A node: its level, its box, what it names if it is a leaf.
type Node = (u32, Aabb, Option<u32>);

const GAP: f64 = 18.0;
const COLUMNS: usize = 3;
const SIDE: f64 = (INNER - 2.0 * GAP) / COLUMNS as f64;
const TALL: f64 = SIDE * 8.8 / 16.0;

/// The kd-tree that figures show.
pub const KD: &str = "kd:sah,leaf=2,axes=xy";
/// The hierarchy that figures show.
pub const BVH: &str = "bvh:sweep,leaf=2,axes=xy";

pub fn kd() -> Outcome<String> {
    let flat = Flat::yard()?;
    let tree = flat.build(KD)?;
    let numbers = tree.statistics();
    let sheet = Sheet::new(
        "Building a kd-tree",
        format!(
            "Each cell is cut where the surface-area heuristic is cheapest, with a bonus for cutting off empty space, until it no longer pays: \
             the {} tile the scene and name its {} objects {} times.",
            counted(numbers.leaves as u64, "leaf"),
            numbers.primitives,
            numbers.references,
        ),
    );
    let tell =
        |inner: u64, leaves: u64| format!("{}, {}", counted(inner, "cut"), counted(leaves, "cell"));
    Ok(frames(sheet, &flat, &*tree, false, &tell))
}

pub fn bvh() -> Outcome<String> {
    let flat = Flat::yard()?;
    let tree = flat.build(BVH)?;
    let numbers = tree.statistics();
    let sheet = Sheet::new(
        "Building a bounding volume hierarchy",
        format!(
            "The objects of a box are sorted and divided in two where the surface-area heuristic is cheapest: {}, and each of \
             the {} objects is named once. Boxes may overlap, and leave empty space out.",
            counted(numbers.leaves as u64, "leaf"),
            numbers.references,
        ),
    );
    let tell = |inner: u64, boxes: u64| {
        format!("{}, {}", counted(inner, "division"), counted(boxes, "box"))
    };
    Ok(frames(sheet, &flat, &*tree, true, &tell))
}

/// One frame for each level: its nodes, and the leaves above it. With `parents`, the outlines of all that lies above, too.
fn frames(
    mut sheet: Sheet,
    flat: &Flat,
    tree: &dyn Intersect,
    parents: bool,
    tell: &dyn Fn(u64, u64) -> String,
) -> String {
    let mut nodes: Vec<Node> = Vec::new();
    tree.cells(&mut |cell| nodes.push((cell.depth, cell.bounds, cell.primitives)));
    let deepest = nodes.iter().map(|node| node.0).max().unwrap_or(0);
    let top = sheet.below;
    for level in 0..=deepest {
        let k = level as usize;
        let x = MARGIN + (k % COLUMNS) as f64 * (SIDE + GAP);
        let y = top + (k / COLUMNS) as f64 * (TALL + 42.0);
        let mut panel = Panel::new(Flat::YARD, [x, y], [SIDE, TALL]);
        panel.add(flat.draw_all(&panel));
        let (mut inner, mut leaves) = (0, 0);
        for (depth, b, names) in &nodes {
            let shape = panel.rectangle(b);
            if *depth < level && names.is_none() {
                inner += 1;
                if parents {
                    panel.add(shape.with("fill", "none").with("stroke", PALE));
                }
                continue;
            }
            if *depth > level {
                continue;
            }
            leaves += 1;
            let (color, opacity) = match names {
                None => (BLUE, 0.1),
                Some(0) => (PALE, 0.25),
                Some(_) => (GREEN, 0.16),
            };
            let shape = shape.with("fill", color).with("fill-opacity", opacity);
            panel.add(
                shape
                    .with("stroke", if *names == Some(0) { BLUE } else { color })
                    .with("stroke-width", 1.4),
            );
        }
        sheet.add(panel.finish());
        sheet.add(words(
            [x, y + TALL + 18.0],
            format!("{level}. {}", tell(inner, leaves)),
        ));
    }
    let rows = (deepest as usize + 1).div_ceil(COLUMNS);
    sheet.below = top + rows as f64 * (TALL + 42.0) + 6.0;
    let mut note = "Blue: still to be divided. Green: a leaf.".to_string();
    if nodes.iter().any(|node| node.2 == Some(0)) {
        note += " Gray: a leaf that is empty.";
    }
    sheet.note([MARGIN, sheet.below], note);
    sheet.finish()
}
