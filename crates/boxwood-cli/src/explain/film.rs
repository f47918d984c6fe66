//! The steps of a ray as a strip of pictures, one for each step.
//!
//! *How it works.* Each frame shows the scene pale, the boxes opened so far as outlines, the box or triangle of its own step
//! in colour, and the ray: dark as far as its interval still reaches, pale beyond. All frames share one window.

use super::story::{ASIDE, OPENED, Story, Told, What};
use super::text::short;
use crate::args::Axis;
use crate::svg::{
    BLUE, BODY, Element, GRAY, GREEN, INK, ORANGE, PALE, Picture, RED, View, Window, arrow,
    clipped, dot, group, label, line, path, rectangle,
};
use crate::terminal::counted;
use boxwood::{Aabb, Ray, Vec3};

/// What to draw.
pub struct Plan<'a> {
    pub title: String,
    pub ray: &'a Ray,
    pub axis: Option<Axis>,
    /// At most so many.
    pub frames: usize,
    pub scene: Outlines<'a>,
    /// Around the whole scene.
    pub bounds: Aabb,
}

/// What a scene is made of, to be drawn.
#[derive(Clone, Copy)]
pub struct Outlines<'a> {
    /// What one of them is called.
    pub name: &'static str,
    pub count: usize,
    /// The corners of one of them.
    pub of: &'a dyn Fn(usize) -> Vec<Vec3>,
}

/// The longer side of a frame's picture.
const SIDE: f64 = 250.0;
const COLUMNS: usize = 5;
const GAP: f64 = 16.0;
/// Two lines of writing below a frame.
const CAPTION: f64 = 40.0;
const HEAD: f64 = 64.0;
/// Outlines of the scene.
const MOST_OUTLINES: usize = 1500;

/// The strip as SVG.
pub fn draw(plan: &Plan<'_>, story: &Story) -> String {
    let (frames, [width, height]) = strip(plan, story, [GAP, HEAD], COLUMNS, SIDE);
    let mut picture = Picture::new([(width + 2.0 * GAP).max(640.0), HEAD + height + 2.0 * GAP]);
    picture.add(
        label([GAP, 26.0], &plan.title)
            .with("font-size", 16)
            .with("fill", INK),
    );
    let axis = axis_of(plan);
    let [right, up] = View::along(axis.0).letters();
    let mut note = format!(
        "{right} to the right, {up} {}; what seems to be met may lie before or behind the ray along {}",
        if axis.0 == 1 { "down" } else { "up" },
        axis.letter()
    );
    let shown = story.steps.len().min(plan.frames);
    if shown < story.steps.len() {
        note += &format!(
            "; the first {shown} of {} steps, --frames shows more",
            story.steps.len()
        );
    }
    picture.add(label([GAP, 46.0], note).with("fill", GRAY));
    picture.add(legend([picture.size()[0] - 330.0, 17.0]));
    picture.add(frames);
    picture.finish()
}

/// The axis that is looked along.
fn axis_of(plan: &Plan<'_>) -> Axis {
    let size = plan.ray.direction.abs();
    let least = (0..3).fold(
        2,
        |best, axis| if size[axis] < size[best] { axis } else { best },
    );
    plan.axis.unwrap_or(Axis(least))
}

/// The frames alone, from a corner on, and the size of all together. `side` is the longer side of a frame's picture.
pub fn strip(
    plan: &Plan<'_>,
    story: &Story,
    [x, y]: [f64; 2],
    columns: usize,
    side: f64,
) -> (Element, [f64; 2]) {
    let view = View::along(axis_of(plan).0);
    let end = story.steps.last().map_or(plan.ray.t_max, |told| told.t_max);
    let bounds = seen(plan, end);
    let shape = Window::new(view, &bounds, [0.0; 2], [side; 2]).rectangle(&bounds)[1];
    let shape = shape.map(|x| x.clamp(0.25 * side, side));
    let strip = Strip {
        plan,
        view,
        bounds,
        shape,
    };

    let shown = story.steps.len().min(plan.frames);
    let columns = shown.clamp(1, columns);
    let rows = shown.div_ceil(columns).max(1);
    let [wide, tall] = [side + GAP, shape[1] + CAPTION + GAP];
    let mut frames = group();
    let mut open: Vec<Aabb> = Vec::new();
    let mut boxes = story.places.clone();
    for (k, told) in story.steps.iter().take(shown).enumerate() {
        let corner = [
            x + (k % columns) as f64 * wide,
            y + (k / columns) as f64 * tall,
        ];
        if let (Some(bounds), Some(node)) = (told.what.bounds(), told.what.node()) {
            boxes.insert(node, bounds);
        }
        let current = told.what.node().and_then(|node| boxes.get(&node)).copied();
        frames.add(strip.frame(told, current, &open, corner));
        match told.what {
            What::Box {
                verdict: OPENED, ..
            }
            | What::Plane { .. }
            | What::Resumed { dropped: false, .. } => open.extend(current),
            _ => {}
        }
    }
    let size = [columns as f64 * wide - GAP, rows as f64 * tall - GAP];
    (frames, size)
}

/// The part of space that the frames show: the scene, and where the ray comes from if that is not far; or the neighbourhood
/// of a ray that ends soon in a large scene.
fn seen(plan: &Plan<'_>, end: f32) -> Aabb {
    let (b, ray) = (plan.bounds, plan.ray);
    let origin = ray.at(ray.t_min);
    let grown = |b: Aabb, margin: f32| {
        let margin = Vec3::splat(margin.max(f32::MIN_POSITIVE));
        Aabb::new(b.lower - margin, b.upper + margin)
    };
    if b.is_empty() || !(b.lower.is_finite() && b.upper.is_finite()) {
        return grown(Aabb::of([origin]), 1.0);
    }
    let way = Aabb::of([origin, ray.at(end)]);
    let (length, reach) = (way.size().max_element(), b.size().max_element());
    if 0.0 < length && length < 0.25 * reach {
        return grown(way, 0.6 * length);
    }
    let near = (origin - b.centroid()).abs().max_element() < 1.5 * reach;
    let b = if near { b.union(Aabb::of([origin])) } else { b };
    grown(b, 0.04 * reach)
}

struct Strip<'a> {
    plan: &'a Plan<'a>,
    view: View,
    bounds: Aabb,
    shape: [f64; 2],
}

impl Strip<'_> {
    fn frame(
        &self,
        told: &Told,
        current: Option<Aabb>,
        open: &[Aabb],
        [x, y]: [f64; 2],
    ) -> Element {
        let window = Window::new(self.view, &self.bounds, [x, y], self.shape);
        let mut inside = clipped([x, y], self.shape);
        inside.add(self.scene(&window));
        let mut outlines = group()
            .with("fill", "none")
            .with("stroke", BLUE)
            .with("stroke-width", 0.6);
        for b in open {
            let [corner, size] = window.rectangle(b);
            outlines.add(rectangle(corner, size));
        }
        inside.add(outlines);
        let color = color_of(told);
        if let Some(b) = current {
            let [corner, size] = window.rectangle(&b);
            let mut shape = rectangle(corner, size)
                .with("fill", color)
                .with("fill-opacity", 0.2);
            shape = shape.with("stroke", color).with("stroke-width", 1.8);
            if matches!(told.what, What::Resumed { dropped: true, .. }) {
                shape = shape.with("stroke-dasharray", "4 3");
            }
            inside.add(shape);
        }
        if let (What::Plane { normal, offset, .. }, Some(b)) = (&told.what, current)
            && let Some(axis) = (0..3).find(|&axis| normal[axis] == 1.0 && self.view.shows(axis))
        {
            let mut ends = [b.lower, b.upper];
            ends.iter_mut().for_each(|end| end[axis] = *offset);
            let [from, to] = ends.map(|end| window.place(end));
            inside.add(
                line(from, to)
                    .with("stroke", color)
                    .with("stroke-width", 2.2),
            );
        }
        if let What::Test { primitive, .. } | What::Repeated { primitive } = told.what {
            let corners = self.outline(primitive as usize, &window);
            let shape = path([&corners[..]], true)
                .with("fill", color)
                .with("fill-opacity", 0.45);
            inside.add(shape.with("stroke", color).with("stroke-width", 1.2));
        }
        inside.add(self.ray(told, &window));

        let mut frame = group();
        frame.add(inside);
        let border = rectangle([x, y], self.shape)
            .with("fill", "none")
            .with("stroke", PALE);
        frame.add(border);
        let [first, second] = caption(told, self.plan.scene.name);
        let below = y + self.shape[1];
        frame.add(label([x, below + 15.0], first).with("fill", INK));
        frame.add(label([x, below + 30.0], second).with("fill", color));
        frame
    }

    fn outline(&self, i: usize, window: &Window) -> Vec<[f64; 2]> {
        let corners = (self.plan.scene.of)(i);
        corners.into_iter().map(|p| window.place(p)).collect()
    }

    /// Outlines of some of what there is.
    fn scene(&self, window: &Window) -> Element {
        let count = self.plan.scene.count;
        let step = count.div_ceil(MOST_OUTLINES).max(1);
        let some: Vec<Vec<[f64; 2]>> = (0..count)
            .step_by(step)
            .map(|i| self.outline(i, window))
            .collect();
        path(some.iter().map(|corners| &corners[..]), true)
            .with("fill", BODY)
            .with("fill-opacity", 0.5)
            .with("stroke", PALE)
            .with("stroke-width", 0.4)
    }

    /// The ray: its interval, where it went on before it was shortened, and the best hit.
    fn ray(&self, told: &Told, window: &Window) -> Element {
        let ray = self.plan.ray;
        let length = ray.direction.length();
        // Well beyond the frame.
        let reach =
            4.0 * (self.bounds.size().length() + (ray.origin - self.bounds.centroid()).length());
        let far = if length > 0.0 { reach / length } else { 0.0 };
        let end = told.t_max.min(far);
        let [from, to, beyond] = [ray.t_min, end, far].map(|t| window.place(ray.at(t)));
        let mut drawn = group().with("fill", INK).with("stroke", INK);
        drawn.add(
            line(to, beyond)
                .with("stroke", PALE)
                .with("stroke-dasharray", "3 3"),
        );
        let shaft = if told.t_max < far {
            arrow(from, to)
        } else {
            line(from, to)
        };
        drawn.add(shaft.with("stroke-width", 1.3));
        drawn.add(dot(from, 2.2).with("stroke", "none"));
        if told.t_max < ray.end() {
            drawn.add(dot(to, 3.2).with("stroke", "none").with("fill", GREEN));
        }
        drawn
    }
}

fn color_of(told: &Told) -> &'static str {
    match &told.what {
        What::Box {
            verdict: OPENED, ..
        }
        | What::Resumed { dropped: false, .. }
        | What::Leaf { .. } => BLUE,
        What::Box { verdict: ASIDE, .. } => ORANGE,
        What::Test { hits, .. } if !hits.is_empty() => GREEN,
        What::Plane { .. } => BLUE,
        _ => RED,
    }
}

/// Two short lines.
fn caption(told: &Told, name: &str) -> [String; 2] {
    let (what, said) = match &told.what {
        What::Box {
            node,
            enter,
            leave,
            verdict,
            ..
        } => (
            format!("box {node}: [{}, {}]", short(*enter), short(*leave)),
            (*verdict).to_string(),
        ),
        What::Plane {
            node, t, near, far, ..
        } => (
            format!("node {node}: plane at t = {}", short(*t)),
            match (near, far) {
                (true, true) => "near side, then far side",
                (true, false) => "near side only",
                (false, true) => "far side only",
                (false, false) => "neither side",
            }
            .to_string(),
        ),
        What::Resumed {
            node,
            enter,
            dropped,
        } => (
            format!("box {node}: from {}", short(*enter)),
            if *dropped {
                "dropped"
            } else {
                "taken up again"
            }
            .to_string(),
        ),
        What::Leaf { node, primitives } => (
            format!("leaf {node}"),
            format!("names {}", counted(u64::from(*primitives), name)),
        ),
        What::Test { primitive, hits } => (
            format!("{name} {primitive}"),
            match hits.iter().rfind(|hit| hit.best).or(hits.last()) {
                None => "no hit".to_string(),
                Some(hit) => format!("hit at t = {}", short(hit.t)),
            },
        ),
        What::Repeated { primitive } => {
            (format!("{name} {primitive}"), "already tested".to_string())
        }
        What::Other => (String::new(), "another step".to_string()),
    };
    [format!("{}. {what}", told.step), said]
}

/// What the colours mean, in a line 330 wide.
pub fn legend([x, y]: [f64; 2]) -> Element {
    let mut legend = group().with("fill", INK);
    let words = [
        (BLUE, "opened"),
        (ORANGE, "put aside"),
        (RED, "rejected"),
        (GREEN, "hit"),
    ];
    for (k, (color, word)) in words.into_iter().enumerate() {
        let x = x + 82.0 * k as f64;
        legend.add(rectangle([x, y], [11.0, 11.0]).with("fill", color));
        legend.add(label([x + 16.0, y + 10.0], word));
    }
    legend
}
