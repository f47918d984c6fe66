//! `boxwood figure`: the figures that explain the structures, drawn by the structures themselves.
//!
//! *How it works.* A figure is a function that builds scenes in the plane, asks the library what it makes of them, and draws
//! the answers: cells as a structure shows them, steps as it tells them, numbers as it counts them. Nothing is drawn that was
//! not computed on the way, and the same bytes come out every time.

mod axis_aligned;
mod flat;
mod grid;
mod levels;
mod ray_box;
mod resolution;
mod sheet;
mod side_by_side;
mod slabs;
mod spatial_split;
mod stadium;
mod traversal;

use crate::args::FigureArgs;
use crate::failure::{Failure, Outcome};
use crate::output::Destination;
use crate::terminal::{Channel, counted};
use std::fs;

/// A figure, with the question that it answers.
struct Figure {
    name: &'static str,
    question: &'static str,
    draw: fn() -> Outcome<String>,
}

/// All of them, in the order of a lecture.
const FIGURES: [Figure; 13] = [
    Figure {
        name: "slabs",
        question: "When does a ray enter a box?",
        draw: slabs::draw,
    },
    Figure {
        name: "ray-box",
        question: "Which cases are there, and why does a touch count?",
        draw: ray_box::draw,
    },
    Figure {
        name: "axis-aligned",
        question: "Why do boxes follow the axes?",
        draw: axis_aligned::draw,
    },
    Figure {
        name: "grid-build",
        question: "Which cells does an object belong to?",
        draw: grid::build,
    },
    Figure {
        name: "grid-walk",
        question: "Which cells does a ray visit, and where does it stop?",
        draw: grid::walk,
    },
    Figure {
        name: "grid-resolution",
        question: "How many cells should a grid have?",
        draw: resolution::draw,
    },
    Figure {
        name: "teapot-in-stadium",
        question: "Where does a uniform grid fail?",
        draw: stadium::draw,
    },
    Figure {
        name: "side-by-side",
        question: "How do octree, kd-tree and BSP tree divide the same scene?",
        draw: side_by_side::draw,
    },
    Figure {
        name: "kd-build",
        question: "How does a kd-tree grow?",
        draw: levels::kd,
    },
    Figure {
        name: "kd-traversal",
        question: "What does a ray do in a kd-tree?",
        draw: traversal::kd,
    },
    Figure {
        name: "bvh-build",
        question: "How does a bounding volume hierarchy grow?",
        draw: levels::bvh,
    },
    Figure {
        name: "bvh-traversal",
        question: "What does a ray do in a bounding volume hierarchy?",
        draw: traversal::bvh,
    },
    Figure {
        name: "spatial-split",
        question: "When is it better to cut objects than to sort them?",
        draw: spatial_split::draw,
    },
];

/// What the figures are called.
pub fn names() -> [&'static str; FIGURES.len()] {
    FIGURES.each_ref().map(|figure| figure.name)
}

pub fn run(args: &FigureArgs) -> Outcome {
    if args.list {
        let lines = FIGURES
            .each_ref()
            .map(|f| format!("{:<18} {}", f.name, f.question));
        return Channel::Stdout.say(lines.join("\n"));
    }
    if let Some(folder) = &args.dir {
        fs::create_dir_all(folder)
            .map_err(|e| Failure::file(folder, format_args!("cannot be made: {e}")))?;
        for figure in &FIGURES {
            let place = folder.join(format!("{}.svg", figure.name));
            Destination::File(place).write((figure.draw)()?.as_bytes())?;
        }
        return Channel::Stdout.say(format_args!(
            "wrote {} to {}",
            counted(FIGURES.len() as u64, "figure"),
            folder.display()
        ));
    }
    let wanted = |figure: &&Figure| Some(figure.name) == args.name.as_deref();
    let Some(figure) = FIGURES.iter().find(wanted) else {
        return Err(Failure::new("no figure is named"));
    };
    let place = args.output.clone();
    let place = place.unwrap_or_else(|| format!("{}.svg", figure.name).into());
    let output = Destination::new(&place);
    output.check([])?;
    output.write((figure.draw)()?.as_bytes())?;
    match output {
        Destination::Stdout => Ok(()),
        Destination::File(path) => Channel::Stdout.say(format_args!("wrote {}", path.display())),
    }
}
