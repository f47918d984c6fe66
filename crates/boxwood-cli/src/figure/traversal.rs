//! What a ray does in a tree, step by step: the film of `boxwood explain`, of a scene in the plane.

use super::flat::Flat;
use super::levels::{BVH, KD};
use super::sheet::{INNER, MARGIN, Sheet};
use crate::args::Axis;
use crate::explain::film::{self, Outlines, Plan};
use crate::explain::story::Story;
use crate::failure::Outcome;
use crate::terminal::counted;
use boxwood::{Aabb, Vec3};

const COLUMNS: usize = 4;
/// Frames stand 16 apart.
const SIDE: f64 = (INNER - 16.0 * (COLUMNS - 1) as f64) / COLUMNS as f64;

pub fn kd() -> Outcome<String> {
    draw(
        KD,
        "A ray in a kd-tree",
        "The near side of each plane comes first, the far side waits. Cells are met in order, so the first hit in its \
        own cell ends the walk",
    )
}

pub fn bvh() -> Outcome<String> {
    draw(
        BVH,
        "A ray in a bounding volume hierarchy",
        "Of two boxes the nearer is opened first, the other waits. A hit shortens the ray, and boxes that wait \
        beyond its end are dropped",
    )
}

fn draw(kind: &str, title: &'static str, sentence: &str) -> Outcome<String> {
    let flat = Flat::yard()?;
    let tree = flat.build(kind)?;
    let ray = Flat::yard_ray();
    let story = Story::of(&*tree, &ray);
    let sum = story.summary();
    let mut sheet = Sheet::new(
        title,
        format!(
            "{sentence}: {}, {} of {} objects.",
            counted(story.steps.len() as u64, "step"),
            counted(sum.tests as u64, "test"),
            flat.scene.figures().len(),
        ),
    );
    let world = tree.bounds();
    let plan = Plan {
        title: String::new(),
        ray: &ray,
        axis: Some(Axis(2)),
        frames: story.steps.len(),
        scene: Outlines {
            name: "object",
            count: flat.scene.figures().len(),
            of: &|i| flat.outline(i),
        },
        // The prisms are far taller than the plane is wide.
        bounds: Aabb::new(
            Vec3::new(world.lower.x, world.lower.y, 0.0),
            Vec3::new(world.upper.x, world.upper.y, 0.0),
        ),
    };
    sheet.add(film::legend([MARGIN, sheet.below - 6.0]));
    let (frames, [_, tall]) =
        film::strip(&plan, &story, [MARGIN, sheet.below + 18.0], COLUMNS, SIDE);
    sheet.add(frames);
    sheet.below += 18.0 + tall;
    Ok(sheet.finish())
}
