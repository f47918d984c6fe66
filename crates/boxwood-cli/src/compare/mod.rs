//! `boxwood compare`: every structure on the same rays, in the open.
//!
//! *How it is laid out.* `build` and `measure` find out, `views` draws what rays cost; `sweep` does so along one setting; `frontier`
//! and `jobs` weigh building against tracing.
//! All of it ends in a `report`, which `text`, `csv` and `html` (and serde) write.

mod build;
mod csv;
mod frontier;
mod html;
mod jobs;
mod machine;
mod measure;
mod report;
mod sweep;
mod text;
mod views;

pub use sweep::Family;

use crate::args::CompareArgs;
use crate::camera;
use crate::failure::{Failure, Outcome};
use crate::output::Destination;
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use crate::terminal::{self, Channel};
use boxwood::{Limits, Quality, StructureKind, Survey, TriangleMesh, WideSah};
use boxwood_render::build_structure;
use boxwood_render::workload::Recorder;
use boxwood_scene::Camera;
use build::Built;
use measure::Workload;
use report::{Measured, Report, Settings, Structure, geometric_mean};
use std::collections::BTreeMap;

/// The name of the exhaustive test.
pub const JUDGE: &str = "brute";

pub fn run(args: &CompareArgs) -> Outcome {
    let destination = |path: &Option<_>| path.as_deref().map(Destination::new);
    let (html, csv) = (destination(&args.html), destination(&args.csv));
    let files: Vec<&Destination> = html.iter().chain(&csv).collect();
    if files
        .iter()
        .filter(|&&file| *file == Destination::Stdout)
        .count()
        > 1
    {
        return Err(Failure::new(
            "only one of --html and --csv can go to standard output",
        ));
    }
    if let Some(family) = args.sweep {
        family.chosen(&args.accel)?;
    }
    for file in &files {
        file.check([args.scene.as_path()])?;
    }
    // Results go to stdout unless a file does.
    let taken = files.contains(&&Destination::Stdout);
    let channel = if taken {
        Channel::Stderr
    } else {
        Channel::Stdout
    };

    args.threads.in_pool(|threads| {
        let file = scene_file::open(&args.scene)?;
        terminal::warnings(&file.name, &file.scene.warnings);
        let (camera, camera_name) = camera::choose(&args.camera, &file, args.size.0)?;
        let mesh = file.flatten()?.mesh;
        let job = Job {
            args,
            file: &file,
            camera,
            mesh: &mesh,
            survey: Survey::of(&mesh),
            threads,
        };
        let (mut report, pictures) = job.report(camera_name)?;
        if report.sweep.is_none() {
            report.winners = report::winners(&report.structures, &report.workloads);
            report.jobs = jobs::rows(&report.structures);
        }
        if let Some(html) = &html {
            html.write(html::page(&report, pictures.as_ref()).as_bytes())?;
        }
        if let Some(csv) = &csv {
            csv.write(csv::lines(&report).as_bytes())?;
        }
        if args.json {
            return channel.say(serde_json::to_string_pretty(&report)?);
        }
        channel.say(text::tables(&report))?;
        for file in files {
            if let Destination::File(path) = file {
                channel.say(format_args!("wrote   {}", path.display()))?;
            }
        }
        Ok(())
    })
}

/// One run of the command.
struct Job<'a> {
    args: &'a CompareArgs,
    file: &'a SceneFile,
    camera: Camera,
    mesh: &'a TriangleMesh,
    /// What forecasts go by.
    survey: Survey,
    /// For building.
    threads: usize,
}

/// Structures that were built, and those that were not.
struct Candidate<'a>(StructureKind, Result<Built<'a>, String>);

impl Job<'_> {
    fn report(&self, camera_name: Option<String>) -> Outcome<(Report, Option<views::Pictures>)> {
        let (workloads, image) = self.record()?;
        let mut report = Report {
            format_version: report::FORMAT_VERSION,
            settings: Settings {
                command: machine::command_line(),
                scene: self.file.name.clone(),
                format: self.file.format,
                triangles: self.mesh.triangles().len() as u64,
                camera: camera_name,
                eye: self.camera.eye,
                forward: self.camera.forward,
                image,
                rounds: self.args.rounds,
                closest: self.args.closest,
                memory_bytes: self.memory(),
            },
            machine: machine::describe(self.threads),
            workloads: workloads.iter().map(describe).collect(),
            structures: Vec::new(),
            winners: BTreeMap::new(),
            jobs: Vec::new(),
            sweep: None,
        };
        let mut candidates = Vec::new();
        for kind in self.kinds() {
            let built = build::build(kind, self.mesh, self.memory())?;
            candidates.push(Candidate(kind, built));
        }
        report.structures = self.measure(&candidates, &workloads)?;
        let pictures = if self.args.views {
            Some(self.pictures(&candidates, &report.structures)?)
        } else {
            None
        };
        if let Some(family) = self.args.sweep {
            let judge = report.structures.first().and_then(|s| s.measured.clone());
            drop(candidates);
            report.sweep = Some(self.sweep(family, &workloads, judge.as_ref())?);
        }
        Ok((report, pictures))
    }

    /// The most that a structure may take. A sweep has a limit of its own: its far end is far.
    fn memory(&self) -> Option<usize> {
        let sweep = self.args.sweep.map(|_| sweep::MEMORY);
        self.args.memory.or(sweep)
    }

    /// What is compared: the judge, then what was asked for, each once. In a sweep, only what it is held against.
    fn kinds(&self) -> Vec<StructureKind> {
        let mut kinds: Vec<_> = StructureKind::all()
            .filter(|kind| kind.name() == JUDGE)
            .collect();
        let mut add = |kind: StructureKind| {
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        };
        if self.args.sweep.is_some() {
            add(StructureKind::default());
        } else if self.args.presets {
            let wide = StructureKind::Wide8(WideSah::default());
            let named = self.args.accel.iter().copied();
            let mut named: Vec<StructureKind> = named.collect();
            if !named.iter().any(|kind| presets(*kind).next().is_some()) {
                named.push(wide);
            }
            for kind in named {
                add(kind);
                presets(kind).for_each(&mut add);
            }
        } else if self.args.accel.is_empty() {
            StructureKind::all().for_each(add);
        } else {
            self.args.accel.iter().copied().for_each(add);
        }
        kinds
    }

    /// The rays, with answers from the default structure, and the size of the image that the primary ones make.
    fn record(&self) -> Outcome<(Vec<Workload>, [u32; 2])> {
        let _progress = Progress::spinner("Recording rays");
        let reference = build_structure(StructureKind::default(), self.mesh, &Limits::NONE)?;
        let [width, height] = self.args.size.0.map(|side| side as f32);
        let recorder = Recorder::new(
            &self.file.scene,
            self.mesh,
            &*reference,
            &self.camera,
            width / height,
            self.args.count,
        );
        let mut kinds = self.args.rays.clone();
        // In the order of their names in help texts, each once.
        kinds.sort_by_key(|kind| *kind as usize);
        kinds.dedup();
        let workloads = kinds.into_iter().map(|kind| {
            let occlusion = kind.asks_occlusion() && !self.args.closest;
            Workload::new(kind, occlusion, recorder.record(kind), &*reference)
        });
        Ok((workloads.collect(), recorder.size()))
    }

    /// Checks and times all that was built, in turns.
    fn measure(
        &self,
        candidates: &[Candidate<'_>],
        workloads: &[Workload],
    ) -> Outcome<Vec<Structure>> {
        let built: Vec<&Built<'_>> = candidates
            .iter()
            .filter_map(|c| c.1.as_ref().ok())
            .collect();
        let mut found: Vec<Measured> = built.iter().map(|b| b.describe()).collect();
        let rounds = self.args.rounds;
        let progress = Progress::bar("Checking and tracing");
        let of = workloads.len() * rounds as usize;
        for (i, workload) in workloads.iter().enumerate() {
            let place = (i * rounds as usize, of);
            let round = measure::measure(&built, workload, rounds, &progress, place)?;
            for ((found, traced), histogram) in
                found.iter_mut().zip(round.traced).zip(round.histograms)
            {
                found.rays.push(traced);
                add_shares(&mut found.histogram, &histogram);
            }
        }
        found.iter_mut().for_each(summarize);
        let judge = built.iter().position(|b| b.kind.name() == JUDGE);
        if let Some(judge) = judge.map(|i| found[i].clone()) {
            found.iter_mut().for_each(|m| compare_with(m, &judge));
        }
        let mut found = found.into_iter();
        Ok(candidates
            .iter()
            .map(|Candidate(kind, outcome)| Structure {
                forecast: self.forecast(*kind),
                structure: kind.to_string(),
                failure: outcome.as_ref().err().cloned(),
                measured: outcome.as_ref().ok().and_then(|_| found.next()),
            })
            .collect())
    }
}

impl Job<'_> {
    /// What the library expects of a structure.
    fn forecast(&self, kind: StructureKind) -> Option<report::Forecast> {
        let forecast = kind.forecast(&self.survey, self.threads)?;
        Some(report::Forecast {
            build_seconds: forecast.build_seconds,
            nanoseconds_per_ray: forecast.ray_seconds * 1e9,
            peak_bytes: forecast.peak_bytes,
            bytes: forecast.resident_bytes,
        })
    }
}

/// A wide tree in every quality; nothing of any other structure.
fn presets(kind: StructureKind) -> impl Iterator<Item = StructureKind> {
    Quality::ALL
        .into_iter()
        .filter_map(move |quality| match kind {
            StructureKind::Wide8(wide) => Some(StructureKind::Wide8(WideSah { quality, ..wide })),
            StructureKind::Wide16(wide) => Some(StructureKind::Wide16(WideSah { quality, ..wide })),
            _ => None,
        })
}

fn describe(workload: &Workload) -> report::Workload {
    report::Workload {
        kind: workload.kind.name(),
        question: workload.question(),
        rays: workload.rays.len(),
        hits: workload.hits(),
    }
}

/// Adds one kind's histogram: each kind counts as much as another, however many rays it has.
fn add_shares(sum: &mut Vec<f64>, rays: &[u64]) {
    let total: u64 = rays.iter().sum();
    if sum.len() < rays.len() {
        sum.resize(rays.len(), 0.0);
    }
    for (sum, &rays) in sum.iter_mut().zip(rays) {
        *sum += rays as f64 / total.max(1) as f64;
    }
}

/// Means over the kinds of rays.
fn summarize(m: &mut Measured) {
    let total: f64 = m.histogram.iter().sum();
    if total > 0.0 {
        m.histogram.iter_mut().for_each(|share| *share /= total);
    }
    m.mrays_per_second = geometric_mean(m.rays.iter().map(|r| r.mrays_per_second));
    let mean = |value: fn(&report::Traced) -> Option<f64>| {
        let values: Vec<f64> = m.rays.iter().filter_map(value).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let means = (
        mean(|r| r.nodes_per_ray),
        mean(|r| r.leaves_per_ray),
        mean(|r| r.primitives_per_ray),
    );
    (m.nodes_per_ray, m.leaves_per_ray, m.primitives_per_ray) = means;
}

/// How many times as many rays per second as the exhaustive test.
fn compare_with(m: &mut Measured, judge: &Measured) {
    let factor = |mine: Option<f64>, theirs: Option<f64>| Some(mine? / theirs?);
    m.speedup = factor(m.mrays_per_second, judge.mrays_per_second);
    for (mine, theirs) in m.rays.iter_mut().zip(&judge.rays) {
        mine.speedup = factor(mine.mrays_per_second, theirs.mrays_per_second);
    }
}
