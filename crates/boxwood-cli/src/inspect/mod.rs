//! `boxwood inspect`: what a structure is made of, as numbers, drawings and lines in space.

mod drawing;
mod histogram;
mod lines;

use crate::args::{InspectArgs, Levels};
use crate::failure::{Failure, Outcome};
use crate::output::Destination;
use crate::progress::Progress;
use crate::scene_file;
use crate::terminal::{self, Channel, counted, grouped, seconds};
use boxwood::{Intersect, Limits, StructureKind};
use boxwood_render::build_structure;
use histogram::Histogram;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// What is said at the end.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    triangles: usize,
    structures: Vec<Numbers>,
}

/// A structure in numbers.
#[derive(Serialize)]
struct Numbers {
    structure: String,
    build_seconds: f64,
    primitives: usize,
    nodes: usize,
    leaves: usize,
    depth: usize,
    /// Primitives named by leaves.
    references: usize,
    references_per_primitive: f64,
    largest_leaf: usize,
    bytes: usize,
    bytes_per_primitive: f64,
    sah_cost: f32,
    /// How many leaves lie at each depth.
    leaf_depths: Histogram,
    /// How many leaves hold each number of primitives.
    leaf_sizes: Histogram,
    /// How many nodes and leaves there are on each level.
    #[serde(skip)]
    levels: Histogram,
}

/// A structure that was built and looked at.
struct Inspected<'a> {
    kind: StructureKind,
    structure: Box<dyn Intersect + 'a>,
    numbers: Numbers,
}

pub fn run(args: &InspectArgs) -> Outcome {
    let outputs =
        [&args.svg, &args.obj, &args.glb].map(|path| path.as_deref().map(Destination::new));
    let [svg, obj, glb] = &outputs;
    let mut channel = Channel::Stdout;
    for output in outputs.iter().flatten() {
        output.check([args.scene.as_path()])?;
        if output.report() == Channel::Stderr {
            if channel == Channel::Stderr {
                return Err(Failure::new("only one file can go to standard output"));
            }
            channel = Channel::Stderr;
        }
    }
    if (obj.is_some() || glb.is_some()) && args.accel.len() > 1 {
        return Err(Failure::new(
            "a file of lines shows one structure, but several were named with --accel",
        ));
    }
    let file = scene_file::open(&args.scene)?;
    terminal::warnings(&file.name, &file.scene.warnings);
    let flat = file.flatten()?;
    let inspected: Vec<Inspected<'_>> = args
        .accel
        .iter()
        .map(|&kind| Inspected::of(kind, &flat.mesh))
        .collect::<Outcome<_>>()?;
    let levels = args.levels.unwrap_or(Levels::ALL);

    let mut wrote = Vec::new();
    if let Some(output) = svg {
        let plan = drawing::Plan {
            scene: &file.name,
            mesh: &flat.mesh,
            slice: args.slice,
            axis: args.axis,
            levels,
        };
        output.write(drawing::draw(&plan, &inspected)?.as_bytes())?;
        wrote.push(output);
    }
    if let (Some(only), true) = (inspected.first(), obj.is_some() || glb.is_some()) {
        let boxes = lines::Boxes::of(&*only.structure, levels)?;
        if let Some(output) = obj {
            output.write(boxes.obj(&file.name, &only.kind).as_bytes())?;
            wrote.push(output);
        }
        if let Some(output) = glb {
            output.write(&boxes.glb()?)?;
            wrote.push(output);
        }
    }
    let report = Report {
        scene: &file.name,
        triangles: flat.mesh.triangles().len(),
        structures: inspected.into_iter().map(|i| i.numbers).collect(),
    };
    if args.json {
        return channel.say(serde_json::to_string_pretty(&report)?);
    }
    let mut text = format!(
        "scene         {}: {}\n",
        report.scene,
        counted(report.triangles as u64, "triangle")
    );
    for numbers in &report.structures {
        text += &numbers.table();
    }
    for output in wrote {
        if let Destination::File(path) = output {
            text += &format!("\nwrote         {}", path.display());
        }
    }
    channel.say(text.trim_end())
}

impl<'a> Inspected<'a> {
    fn of(kind: StructureKind, mesh: &'a boxwood::TriangleMesh) -> Outcome<Self> {
        let start = Instant::now();
        let structure = {
            let _progress = Progress::spinner(format!("Building {kind}"));
            build_structure(kind, mesh, &Limits::NONE)?
        };
        let build_seconds = start.elapsed().as_secs_f64();
        let s = structure.statistics();
        let [mut leaf_depths, mut leaf_sizes, mut levels] = [(); 3].map(|()| Histogram::default());
        structure.cells(&mut |cell| {
            levels.count(cell.depth);
            if let Some(primitives) = cell.primitives {
                leaf_depths.count(cell.depth);
                leaf_sizes.count(primitives);
            }
        });
        let each = |n: usize| n as f64 / s.primitives.max(1) as f64;
        let numbers = Numbers {
            structure: kind.to_string(),
            build_seconds,
            primitives: s.primitives,
            nodes: s.nodes,
            leaves: s.leaves,
            depth: s.depth,
            references: s.references,
            references_per_primitive: each(s.references),
            largest_leaf: s.largest_leaf,
            bytes: s.bytes,
            bytes_per_primitive: each(s.bytes),
            sah_cost: s.sah_cost,
            leaf_depths,
            leaf_sizes,
            levels,
        };
        Ok(Self {
            kind,
            structure,
            numbers,
        })
    }
}

impl Numbers {
    fn table(&self) -> String {
        let count = |n: usize| grouped(n as u64);
        let lines = [
            ("structure", self.structure.clone()),
            ("built in", seconds(self.build_seconds)),
            ("primitives", count(self.primitives)),
            ("inner nodes", count(self.nodes)),
            ("leaves", count(self.leaves)),
            ("depth", count(self.depth)),
            (
                "references",
                format!(
                    "{} ({:.2} per primitive)",
                    count(self.references),
                    self.references_per_primitive
                ),
            ),
            ("largest leaf", count(self.largest_leaf)),
            (
                "memory",
                format!(
                    "{} ({:.1} bytes per primitive)",
                    terminal::bytes(self.bytes as u64),
                    self.bytes_per_primitive
                ),
            ),
            ("SAH cost", format!("{:.2} primitive tests", self.sah_cost)),
        ];
        let mut text = String::new();
        for (name, value) in lines {
            text += &format!("\n{name:<13} {value}");
        }
        text.push('\n');
        if self.levels.is_empty() {
            text += "\nThis structure has no nodes or cells to show.\n";
            return text;
        }
        text += &format!("\nleaves by depth\n{}", self.leaf_depths.bars());
        text += &format!("\nleaves by size\n{}", self.leaf_sizes.bars());
        text
    }
}

/// How a scene is called in a drawing: without the folders it lies in.
fn short_name(scene: &str) -> String {
    let name = Path::new(scene).file_name();
    name.map_or(scene.into(), |name| name.to_string_lossy().into_owned())
}
