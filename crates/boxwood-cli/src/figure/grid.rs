//! The uniform grid: what lies in its cells, and which of them a ray visits.

use super::flat::Flat;
use super::sheet::{INNER, MARGIN, Panel, Sheet, centred};
use crate::failure::Outcome;
use crate::svg::{BLUE, GREEN, INK, ORANGE, PALE, dot};
use crate::terminal::counted;
use boxwood::inspect::Event;
use boxwood::{Aabb, Limits, Step};
use boxwood_render::build_structure;
use std::collections::HashMap;

/// Nine cells for each thing: what 27 are in space.
pub const KIND: &str = "grid:c=9,axes=xy";

pub fn build() -> Outcome<String> {
    let (flat, mesh) = Flat::triangles()?;
    let grid = build_structure(KIND.parse()?, &mesh, &Limits::NONE)?;
    // Prisms are listed by their bounding boxes.
    let by_boxes = flat.build(KIND)?.statistics().references;
    let mut cells = 0_u64;
    grid.cells(&mut |_| cells += 1);
    let numbers = grid.statistics();
    let mut sheet = Sheet::new(
        "Building a uniform grid",
        format!(
            "{} in {cells} equal cells: each is listed in the cells that it really overlaps, {} entries in {} cells; by their \
             bounding boxes there would be {by_boxes}.",
            counted(numbers.primitives as u64, "triangle"),
            numbers.references,
            numbers.leaves,
        ),
    );
    let mut panel = yard_panel(&sheet);
    grid.cells(&mut |cell| {
        let count = cell.primitives.unwrap_or(0);
        let shape = panel.rectangle(&cell.bounds).with("stroke", PALE);
        panel.add(match count {
            0 => shape.with("fill", "none"),
            n => shape
                .with("fill", BLUE)
                .with("fill-opacity", 0.1 + 0.14 * f64::from(n)),
        });
    });
    panel.add(flat.draw_all(&panel).with("fill-opacity", 0.55));
    grid.cells(&mut |cell| {
        if let Some(count @ 1..) = cell.primitives {
            panel.add(corner_word(&panel, &cell.bounds, count));
        }
    });
    sheet.below += TALL + 20.0;
    sheet.add(panel.finish());
    sheet.note(
        [MARGIN, sheet.below],
        "The number in a cell is the length of its list; cells without a number are empty.",
    );
    Ok(sheet.finish())
}

/// A picture of the yard is so tall.
pub const TALL: f64 = INNER * 8.8 / 16.0;

fn yard_panel(sheet: &Sheet) -> Panel {
    Panel::new(Flat::YARD, [MARGIN, sheet.below], [INNER, TALL])
}

fn corner_word(panel: &Panel, b: &Aabb, word: impl std::fmt::Display) -> crate::svg::Element {
    let [[x, y], _] = panel.window.rectangle(b);
    centred([x + 10.0, y + 14.0], word).with("fill", INK)
}

pub fn walk() -> Outcome<String> {
    let flat = Flat::yard()?;
    let grid = flat.build(KIND)?;
    let ray = Flat::yard_ray();
    let mut bounds = HashMap::new();
    grid.cells(&mut |cell| {
        bounds.insert(cell.node, (cell.bounds, cell.primitives.unwrap_or(0)));
    });
    // Cells in the order of the visit; of bricks only those that were passed with one look.
    let (mut visited, mut bricks, mut last) = (Vec::new(), Vec::<Aabb>::new(), None);
    let (mut tests, mut repeated, mut hit) = (0_u64, 0_u64, None);
    for event in grid.explain(&ray) {
        match event {
            Event::Step(Step::Box {
                node, bounds: b, ..
            }) => match bounds.get(&node) {
                Some(&cell) => {
                    last = None;
                    visited.push(cell);
                }
                None => bricks.extend(last.replace(b)),
            },
            Event::Step(Step::Primitive { .. }) => tests += 1,
            Event::Step(Step::Repeated { .. }) => repeated += 1,
            Event::Hit { t_max, .. } => hit = Some(t_max),
            _ => {}
        }
    }
    bricks.extend(last);
    let end = hit.unwrap_or(20.0);
    let mut sheet = Sheet::new(
        "Walking a uniform grid",
        format!(
            "The ray goes from cell to cell by adding and comparing, tests what they list ({}, {repeated} passed over as tested \
             before) and stops in cell {}, the first that holds a hit, at t = {end:.2}.",
            counted(tests, "test"),
            visited.len(),
        ),
    );
    let mut panel = yard_panel(&sheet);
    grid.cells(&mut |cell| {
        let shape = panel.rectangle(&cell.bounds).with("fill", "none");
        panel.add(shape.with("stroke", PALE).with("stroke-width", 0.6));
    });
    for b in &bricks {
        let shape = panel
            .rectangle(b)
            .with("fill", ORANGE)
            .with("fill-opacity", 0.12);
        panel.add(shape.with("stroke", ORANGE).with("stroke-dasharray", "6 4"));
    }
    for (k, (b, count)) in visited.iter().enumerate() {
        let color = if k + 1 == visited.len() && hit.is_some() {
            GREEN
        } else {
            BLUE
        };
        let opacity = if *count > 0 { 0.4 } else { 0.12 };
        let shape = panel
            .rectangle(b)
            .with("fill", color)
            .with("fill-opacity", opacity);
        panel.add(shape.with("stroke", color));
    }
    panel.add(flat.draw_all(&panel).with("fill-opacity", 0.55));
    panel.ray(&ray, end);
    panel.add(dot(panel.window.place(ray.at(end)), 5.0).with("fill", GREEN));
    for (k, (b, _)) in visited.iter().enumerate() {
        panel.add(corner_word(&panel, b, k + 1));
    }
    sheet.below += TALL + 20.0;
    sheet.add(panel.finish());
    let mut note = "Numbers: the order of the visit. Dark: cells that list objects, by their bounding boxes. Green: the hit.".to_string();
    if !bricks.is_empty() {
        note += &format!(
            " Dashed: {} of 4 × 4 empty cells, passed with one look.",
            counted(bricks.len() as u64, "brick")
        );
    }
    sheet.note([MARGIN, sheet.below], note);
    Ok(sheet.finish())
}
