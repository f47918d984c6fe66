//! The boxes of a structure on paper: a cross-section or a projection, coloured by level.
//!
//! *How it works.* One panel for each structure, all in the same frame and the same colours. Boxes are drawn from the root
//! down, so that small ones lie on top; leaves are filled a little. Behind them lies the scene: what the plane cuts of its
//! triangles, or their outlines.

use super::{Inspected, short_name};
use crate::args::{Axis, Levels, Place, Slice};
use crate::failure::Outcome;
use crate::svg::{
    self, Element, INK, PALE, Picture, View, Window, color, group, label, path, section,
};
use crate::terminal::{self, counted, grouped};
use boxwood::inspect::Cell;
use boxwood::{Aabb, TriangleMesh, Vec3};

/// What to draw.
pub struct Plan<'a> {
    pub scene: &'a str,
    pub mesh: &'a TriangleMesh,
    pub slice: Option<Slice>,
    pub axis: Axis,
    pub levels: Levels,
}

/// The sides of a panel, and what lies between and around them.
const PANEL: f64 = 620.0;
const GAP: f64 = 24.0;
/// For the title and the scale.
const HEAD: f64 = 54.0;
const FOOT: f64 = 58.0;
/// A drawing with more boxes is slow to open and shows nothing but ink.
const MOST_BOXES: u64 = 40_000;
/// Lines of the scene in the background.
const MOST_LINES: usize = 20_000;

/// What is drawn of space.
struct Cut<'a> {
    plan: &'a Plan<'a>,
    view: View,
    bounds: Aabb,
    /// The axis and place of a cross-section.
    plane: Option<(usize, f32)>,
}

/// The drawing as SVG.
pub fn draw(plan: &Plan<'_>, inspected: &[Inspected<'_>]) -> Outcome<String> {
    let bounds = inspected
        .iter()
        .fold(Aabb::EMPTY, |around, i| around.union(i.structure.bounds()));
    let finite = bounds.lower.is_finite() && bounds.upper.is_finite();
    let bounds = if bounds.is_empty() || !finite {
        Aabb::new([0.0; 3], [1.0; 3])
    } else {
        bounds
    };
    let axis = plan.slice.map_or(plan.axis.0, |slice| slice.axis.0);
    let plane = plan.slice.map(|slice| {
        let place = match slice.place {
            Place::At(place) => place,
            Place::Share(share) => bounds.lower[axis] + bounds.size()[axis] * share,
        };
        (axis, place)
    });
    let cut = Cut {
        plan,
        view: View::along(axis),
        bounds,
        plane,
    };
    let outside =
        |(axis, place): (usize, f32)| !(bounds.lower[axis] <= place && place <= bounds.upper[axis]);
    if plane.is_some_and(outside) {
        terminal::note(format_args!(
            "the plane passes the scene, which lies between {} and {}",
            bounds.lower[axis], bounds.upper[axis]
        ));
    }

    let columns = inspected.len().clamp(1, 3);
    let rows = inspected.len().div_ceil(columns);
    let [width, height] = cut.panel_size();
    let mut picture = Picture::new([
        GAP + columns as f64 * (width + GAP),
        rows as f64 * (HEAD + height) + FOOT + GAP,
    ]);
    let shown: Vec<Levels> = inspected.iter().map(|i| cut.affordable(i)).collect();
    let deepest = inspected.iter().zip(&shown).filter_map(|(i, levels)| {
        let last = i.numbers.levels.last()?;
        Some(last.min(levels.last))
    });
    let deepest = deepest.max().unwrap_or(0);
    for (k, (one, levels)) in inspected.iter().zip(shown).enumerate() {
        let corner = [
            GAP + (k % columns) as f64 * (width + GAP),
            (k / columns) as f64 * (HEAD + height) + HEAD,
        ];
        picture.add(cut.panel(one, levels, deepest, corner));
    }
    let foot = rows as f64 * (HEAD + height) + GAP;
    picture.add(scale([GAP, foot], plan.levels.first, deepest));
    Ok(picture.finish())
}

impl Cut<'_> {
    /// As wide or as tall as a panel may be, in the proportions of the scene.
    fn panel_size(&self) -> [f64; 2] {
        let window = Window::new(self.view, &self.bounds, [0.0; 2], [PANEL; 2]);
        let [_, size] = window.rectangle(&self.bounds);
        size.map(|x| x.clamp(0.2 * PANEL, PANEL))
    }

    /// As many of the wanted levels as can be drawn: those nearest to the root.
    fn affordable(&self, one: &Inspected<'_>) -> Levels {
        let (wanted, all) = (self.plan.levels, &one.numbers.levels);
        let last = wanted.last.min(all.last().unwrap_or(0));
        // A plane cuts some of the boxes only; how many, is counted.
        let mut by_level = vec![0_u64; last as usize + 1];
        one.structure.cells(&mut |cell| {
            if wanted.contain(cell.depth)
                && self.shows(cell)
                && let Some(count) = by_level.get_mut(cell.depth as usize)
            {
                *count += 1;
            }
        });
        let mut total = 0;
        let fits = |count: &&u64| {
            total += **count;
            total <= MOST_BOXES
        };
        let fitting = by_level.iter().take_while(fits).count() as u32;
        let levels = Levels {
            last: last.min(fitting.saturating_sub(1).max(wanted.first)),
            ..wanted
        };
        if levels.last < last {
            terminal::note(format_args!(
                "{}: levels {} to {last} have too many boxes to draw and are left out; --levels chooses",
                one.kind,
                levels.last + 1
            ));
        }
        levels
    }

    fn shows(&self, cell: &Cell<'_>) -> bool {
        let b = cell.bounds;
        let finite = b.lower.is_finite() && b.upper.is_finite() && !b.is_empty();
        let cut = self
            .plane
            .is_none_or(|(axis, place)| b.lower[axis] <= place && place <= b.upper[axis]);
        finite && cut
    }

    fn panel(
        &self,
        one: &Inspected<'_>,
        levels: Levels,
        deepest: u32,
        [x, y]: [f64; 2],
    ) -> Element {
        let size = self.panel_size();
        let window = Window::new(self.view, &self.bounds, [x, y], size);
        let mut panel = group();
        let title = format!("{} over {}", one.kind, short_name(self.plan.scene));
        panel.add(
            label([x, y - 30.0], title)
                .with("font-size", 16)
                .with("fill", INK),
        );
        panel.add(self.background(&window));

        // By level, so that what lies below is drawn later.
        let mut boxes: Vec<(u32, Element)> = Vec::new();
        one.structure.cells(&mut |cell| {
            if levels.contain(cell.depth) && self.shows(cell) && (boxes.len() as u64) < MOST_BOXES {
                boxes.push((cell.depth, self.cell(cell, &window, deepest)));
            }
        });
        boxes.sort_by_key(|(depth, _)| *depth);
        let what = match self.plane {
            Some((axis, place)) => format!("cut at {} = {place:.4}", Axis(axis).letter()),
            None => format!("seen along {}", self.plan.axis.letter()),
        };
        let [right, up] = self.view.letters();
        let note = format!(
            "{what} ({right} to the right, {up} {}) · {}",
            if up == "z" && right == "x" {
                "down"
            } else {
                "up"
            },
            counted(boxes.len() as u64, "box"),
        );
        panel.add(label([x, y - 12.0], note).with("fill", "#5a6270"));
        let mut drawn = group().with("fill-opacity", 0.09);
        boxes
            .into_iter()
            .for_each(|(_, element)| drawn.add(element));
        panel.add(drawn);
        panel
    }

    /// A box, or the part of a cell of slanted planes that is seen.
    fn cell(&self, cell: &Cell<'_>, window: &Window, deepest: u32) -> Element {
        let share = f64::from(cell.depth) / f64::from(deepest.max(1));
        let stroke = color(share);
        let mut shape = if cell.sides.is_empty() {
            let [corner, size] = window.rectangle(&cell.bounds);
            svg::rectangle(corner, size)
        } else {
            let loops: Vec<Vec<[f64; 2]>> = match self.plane {
                None => cell
                    .sides
                    .iter()
                    .map(|side| side.iter().map(|&p| window.place(p)).collect())
                    .collect(),
                Some(plane) => {
                    let crossings = cell.sides.iter().filter_map(|side| section(side, plane));
                    crossings
                        .map(|ends| ends.map(|p| window.place(p)).to_vec())
                        .collect()
                }
            };
            path(loops.iter().map(Vec::as_slice), self.plane.is_none())
        };
        shape = shape
            .with(
                "fill",
                if cell.primitives.is_some() {
                    &stroke
                } else {
                    "none"
                },
            )
            .with("stroke", &stroke)
            .at("stroke-width", 0.5 + 1.6 * (1.0 - share) * (1.0 - share));
        shape.add(Element::new("title").text(tooltip(cell)));
        shape
    }

    /// The scene itself, pale.
    fn background(&self, window: &Window) -> Element {
        let mesh = self.plan.mesh;
        let count = mesh.triangles().len();
        let corners = |i: usize| mesh.triangle(i);
        let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
        match self.plane {
            Some(plane) => {
                let cut: Vec<[Vec3; 2]> = (0..count)
                    .filter_map(|i| section(&corners(i), plane))
                    .collect();
                let step = cut.len().div_ceil(MOST_LINES).max(1);
                runs.extend(
                    cut.iter()
                        .step_by(step)
                        .map(|ends| ends.map(|p| window.place(p)).to_vec()),
                );
            }
            None => {
                let step = count.div_ceil(MOST_LINES / 4).max(1);
                let some = (0..count).step_by(step);
                runs.extend(some.map(|i| corners(i).map(|p| window.place(p)).to_vec()));
            }
        }
        path(runs.iter().map(Vec::as_slice), self.plane.is_none())
            .with("fill", "none")
            .with("stroke", if self.plane.is_some() { INK } else { PALE })
            .with("stroke-width", if self.plane.is_some() { 0.8 } else { 0.3 })
            .with("stroke-linecap", "round")
    }
}

fn tooltip(cell: &Cell<'_>) -> String {
    let what = match cell.primitives {
        None => "inner node".to_string(),
        Some(n) => counted(u64::from(n), "primitive"),
    };
    format!(
        "{}, level {}: {what}",
        grouped(u64::from(cell.node)),
        cell.depth
    )
}

/// The colours of the levels.
fn scale([x, y]: [f64; 2], first: u32, deepest: u32) -> Element {
    let mut legend = group().with("fill", INK);
    legend.add(label([x, y + 12.0], "level"));
    let steps = (deepest.saturating_sub(first) + 1).min(40);
    let wide = 18.0;
    for step in 0..steps {
        let last = f64::from(steps - 1).max(1.0);
        let level =
            f64::from(first) + f64::from(step) / last * f64::from(deepest - first.min(deepest));
        let corner = [x + 40.0 + wide * f64::from(step), y];
        let share = level / f64::from(deepest.max(1));
        legend.add(svg::rectangle(corner, [wide, 15.0]).with("fill", color(share)));
        if step % 5 == 0 && step + 3 <= steps || step + 1 == steps {
            let number = label([corner[0] + 0.5 * wide, y + 30.0], level.round());
            legend.add(number.with("text-anchor", "middle"));
        }
    }
    legend
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_cut_polygons_in_two_points() {
        let square = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 2.0], [0.0, 2.0, 2.0]].map(Vec3::from);
        let cut = section(&square, (2, 0.5)).expect("it is cut");
        assert_eq!(cut.map(Vec3::to_array), [[2.0, 0.5, 0.5], [0.0, 0.5, 0.5]]);
        assert_eq!(section(&square, (2, 3.0)), None);
        // A plane through an edge cuts there, and one in which all of it lies nowhere.
        assert!(section(&square, (0, 2.0)).is_some());
        assert_eq!(
            section(&square.map(|p| Vec3::new(p.x, p.y, 1.0)), (2, 1.0)),
            None
        );
        assert_eq!(section(&[], (2, 1.0)), None);
    }
}
