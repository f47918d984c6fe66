//! `boxwood cast`: batches of rays from NumPy files against a scene.

mod answers;
mod rays;

use crate::args::CastArgs;
use crate::cache::{Cache, CacheUse};
use crate::failure::{Failure, Outcome};
use crate::output::Destination;
use crate::progress::Progress;
use crate::scene_file;
use crate::terminal::{self, Channel, counted, seconds};
use answers::Question;
pub use answers::add_located;
use boxwood_render::{Layout, Shelf};
use serde::Serialize;
use std::time::Instant;

/// What is said at the end.
#[derive(Serialize)]
struct Report {
    rays: u64,
    hits: u64,
    build_seconds: f64,
    /// Median of the repeats.
    trace_seconds: f64,
    mrays_per_second: f64,
    structure: String,
    threads: usize,
    /// Of the structure, without the triangles.
    bytes: u64,
    /// `null` without `--cache`.
    cache: Option<CacheUse>,
}

pub fn run(args: &CastArgs) -> Outcome {
    let output = args.output.as_deref().map(Destination::new);
    if let Some(output) = &output {
        output.check([args.scene.as_path(), &args.rays])?;
    }
    let channel = output.as_ref().map_or(Channel::Stdout, Destination::report);
    let rays = rays::read(&args.rays)?;
    args.tracing.threads.in_pool(|threads| {
        let file = scene_file::open(&args.scene)?;
        terminal::warnings(&file.name, &file.scene.warnings);
        let kind = args.tracing.accel;
        let cache = Cache::open(&args.tracing.cache, kind)?;
        let shelf = cache.as_deref().map(|cache| cache as &dyn Shelf);
        let start = Instant::now();
        let layout = {
            let _progress = Progress::spinner(format!("Building {kind}"));
            Layout::kept(&file.scene, kind, args.flatten, shelf)
                .map_err(|error| Failure::new(format!("{}: {error}", file.name)))?
        };
        let build_seconds = start.elapsed().as_secs_f64();

        let question = match (args.any, args.all) {
            (true, _) => Question::Any,
            (_, true) => Question::All,
            _ => Question::Closest,
        };
        let mut answers = question.answers(rays.len());
        let mut times = Vec::new();
        {
            let repeats = args.repeat as usize;
            let progress = Progress::bar(format!("Casting {}", counted(rays.len() as u64, "ray")));
            for done in 0..repeats {
                progress.at(done, repeats);
                let start = Instant::now();
                answers.ask(layout.structure(), &rays);
                times.push(start.elapsed().as_secs_f64());
            }
        }
        let trace_seconds = median(&mut times);
        let report = Report {
            rays: rays.len() as u64,
            hits: answers.hits(),
            build_seconds,
            trace_seconds,
            mrays_per_second: if rays.is_empty() {
                0.0
            } else {
                // The clock may be too coarse for a few rays.
                rays.len() as f64 / trace_seconds.max(1e-9) / 1e6
            },
            structure: kind.to_string(),
            threads,
            bytes: layout.bytes() as u64,
            cache: Cache::use_of(cache.as_deref()),
        };
        if let Some(output) = &output {
            let _progress = Progress::spinner("Writing");
            output.write(&answers.archive(&layout, &rays, args.normals)?)?;
        }
        if args.json {
            channel.say(serde_json::to_string_pretty(&report)?)
        } else {
            channel.say(report.table(question, output.as_ref(), args.repeat))
        }
    })
}

impl Report {
    fn table(&self, question: Question, output: Option<&Destination>, repeats: u32) -> String {
        let found = match question {
            Question::Any => format!("{} occluded", terminal::grouped(self.hits)),
            _ => counted(self.hits, "hit"),
        };
        let mut text = format!("{}, {found}\n", counted(self.rays, "ray"));
        let (built, from) = CacheUse::said(self.cache.as_ref());
        text += &format!(
            "{built:<8}{}{from} in {} ({})\n",
            self.structure,
            seconds(self.build_seconds),
            terminal::bytes(self.bytes)
        );
        text += &format!(
            "traced  in {} with {}: {:.2} million rays per second",
            seconds(self.trace_seconds),
            counted(self.threads as u64, "thread"),
            self.mrays_per_second
        );
        if repeats > 1 {
            text += &format!(" (median of {repeats} runs)");
        }
        if let Some(Destination::File(path)) = output {
            text += &format!("\nwrote   {}", path.display());
        }
        text
    }
}

/// The middle value; of an even number, the mean of the middle two.
pub fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    match times {
        [] => 0.0,
        _ => {
            let upper = times[times.len() / 2];
            let lower = times[(times.len() - 1) / 2];
            f64::midpoint(lower, upper)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&mut [5.0]), 5.0);
    }
}
