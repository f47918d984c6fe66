//! `boxwood query`: batches of points from NumPy files against a scene.

use crate::args::{QueryArgs, Question};
use crate::cache::{Cache, CacheUse};
use crate::cast::add_located;
use crate::failure::Outcome;
use crate::npz::Archive;
use crate::output::Destination;
use crate::progress::Progress;
use crate::scene_file;
use crate::table::{self, Table};
use crate::terminal::{self, Channel, counted, seconds};
use boxwood::proximity::{ClosestPoint, Winding};
use boxwood::{Proximity, StructureKind, WideSah};
use boxwood_render::kept_wide8;
use boxwood_scene::FlatScene;
use serde::Serialize;
use std::io;
use std::time::Instant;

/// What is said at the end.
#[derive(Serialize)]
struct Report {
    points: u64,
    /// Triangles found, or points inside.
    found: u64,
    build_seconds: f64,
    query_seconds: f64,
    threads: usize,
    /// `null` without `--cache`.
    cache: Option<CacheUse>,
}

pub fn run(args: &QueryArgs) -> Outcome {
    let output = args.output.as_deref().map(Destination::new);
    if let Some(output) = &output {
        output.check([args.scene.as_path(), &args.points])?;
    }
    let channel = output.as_ref().map_or(Channel::Stdout, Destination::report);
    let points = table::read(&args.points, decode)?;
    args.threads.in_pool(|threads| {
        let file = scene_file::open(&args.scene)?;
        terminal::warnings(&file.name, &file.scene.warnings);
        let flat = file.flatten()?;
        let cache = Cache::open(&args.cache, StructureKind::Wide8(WideSah::default()))?;
        let start = Instant::now();
        let tree = {
            let _progress = Progress::spinner("Building a tree");
            let builder = WideSah::<8>::default();
            match &cache {
                Some(cache) => kept_wide8(&builder, &flat.mesh, &**cache),
                None => builder.build(&flat.mesh),
            }
        };
        let build_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let answers = {
            let _progress = Progress::spinner(format!("Asking about {}", of_points(points.len())));
            Answers::ask(args.question, &tree, &points)
        };
        let report = Report {
            points: points.len() as u64,
            found: answers.found(),
            build_seconds,
            query_seconds: start.elapsed().as_secs_f64(),
            threads,
            cache: Cache::use_of(cache.as_deref()),
        };
        if let Some(output) = &output {
            let _progress = Progress::spinner("Writing");
            output.write(&answers.archive(&flat)?)?;
        }
        if args.json {
            channel.say(serde_json::to_string_pretty(&report)?)
        } else {
            channel.say(report.table(args.question, output.as_ref()))
        }
    })
}

fn decode(bytes: &[u8]) -> Result<Vec<[f32; 3]>, String> {
    const EXPECTED: &str = "(n, 3) `x y z` of float32 or float64";
    let table = Table::decode(bytes, &[3], "point", EXPECTED)?;
    Ok((0..table.rows()).map(|i| table.vector(i, 0)).collect())
}

fn of_points(count: usize) -> String {
    counted(count as u64, "point")
}

/// The answers, one for each point.
enum Answers {
    Closest(Vec<Option<ClosestPoint>>),
    Lists(Vec<Vec<ClosestPoint>>),
    Inside(Vec<Winding>),
}

impl Answers {
    /// In the caller's rayon pool.
    fn ask(question: Question, tree: &(impl Proximity + Sync), points: &[[f32; 3]]) -> Self {
        match question {
            Question::Closest => {
                let mut found = vec![None; points.len()];
                tree.closest_points(points, &mut found);
                Self::Closest(found)
            }
            Question::Nearest { k } => {
                let mut found = vec![Vec::new(); points.len()];
                tree.nearest_each(points, k as usize, &mut found);
                Self::Lists(found)
            }
            Question::Within { r } => {
                let mut found = vec![Vec::new(); points.len()];
                tree.within_each(points, r, &mut found);
                Self::Lists(found)
            }
            Question::Inside => {
                let mut found = vec![Winding::default(); points.len()];
                tree.windings(points, &mut found);
                Self::Inside(found)
            }
        }
    }

    fn found(&self) -> u64 {
        match self {
            Self::Closest(found) => found.iter().flatten().count() as u64,
            Self::Lists(lists) => lists.iter().map(|list| list.len() as u64).sum(),
            Self::Inside(found) => found.iter().filter(|w| w.is_inside()).count() as u64,
        }
    }

    /// The answers as a NumPy archive.
    fn archive(&self, flat: &FlatScene) -> io::Result<Vec<u8>> {
        let mut archive = Archive::new();
        match self {
            Self::Closest(found) => add_points(&mut archive, flat, found.iter().copied())?,
            Self::Lists(lists) => {
                let mut end = 0_u64;
                let ends = lists.iter().map(|list| {
                    end += list.len() as u64;
                    end
                });
                archive.add("offsets", std::iter::once(0).chain(ends))?;
                add_points(
                    &mut archive,
                    flat,
                    lists.iter().flatten().copied().map(Some),
                )?;
            }
            Self::Inside(found) => {
                archive.add("inside", found.iter().map(Winding::is_inside))?;
                archive.add("winding", found.iter().map(|w| w.number))?;
                archive.add("on_surface", found.iter().map(|w| w.on_surface))?;
            }
        }
        archive.finish()
    }
}

/// Adds one row for each point of the surface, or none.
fn add_points(
    archive: &mut Archive,
    flat: &FlatScene,
    found: impl Iterator<Item = Option<ClosestPoint>> + Clone,
) -> io::Result<()> {
    let each = || found.clone();
    archive.add(
        "distance",
        each().map(|p| p.map_or(f32::INFINITY, |p| p.distance)),
    )?;
    archive.add_vectors(
        "point",
        each().map(|p| p.map_or([0.0; 3], |p| p.point.to_array())),
    )?;
    archive.add("u", each().map(|p| p.map_or(0.0, |p| p.u)))?;
    archive.add("v", each().map(|p| p.map_or(0.0, |p| p.v)))?;
    let located: Vec<_> = each()
        .map(|p| p.map(|p| flat.locate(p.primitive)))
        .collect();
    add_located(archive, &located)
}

impl Report {
    fn table(&self, question: Question, output: Option<&Destination>) -> String {
        let found = match question {
            Question::Inside => format!("{} inside", terminal::grouped(self.found)),
            _ => format!("{} found", counted(self.found, "triangle")),
        };
        let mut text = format!("{}, {found}\n", counted(self.points, "point"));
        let (built, from) = CacheUse::said(self.cache.as_ref());
        text += &format!(
            "{built:<8}a tree{from} in {}\n",
            seconds(self.build_seconds)
        );
        text += &format!(
            "asked   in {} with {}",
            seconds(self.query_seconds),
            counted(self.threads as u64, "thread")
        );
        if let Some(Destination::File(path)) = output {
            text += &format!("\nwrote   {}", path.display());
        }
        text
    }
}
