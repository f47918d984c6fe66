//! One run: scene by scene, view by view, with the reports written anew after each.

use crate::args::PeersArgs;
use crate::failure::{Outcome, failed};
use crate::files;
use crate::machine::{Machine, pinned_pool};
use crate::measure::{Answers, Question, Ready, Workload, measure};
use crate::peers::{Contestant, Subject};
use crate::rays::{Kind, Source, npy};
use crate::report::{Absent, Build, FORMAT_VERSION, Report, Series, summarize};
use crate::scenes::{self, Loaded, View};
use crate::tables;
use boxwood::{Intersect, StructureKind};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::fs;
use std::io::{IsTerminal, Write, stderr, stdout};

/// Builds are repeated so often, for the clock's sake, unless that takes longer than [`PATIENCE`] seconds.
const BUILDS: usize = 3;
const PATIENCE: f64 = 0.5;
/// How many threads builds are timed with.
const BUILDERS: [usize; 2] = [1, 2];

pub fn run(args: &PeersArgs) -> Outcome {
    let report = Report {
        format_version: FORMAT_VERSION,
        command: std::env::args().collect::<Vec<_>>().join(" "),
        machine: Machine::this(),
        rounds: args.rounds,
        threads: args.threads.into(),
        absent: Vec::new(),
        builds: Vec::new(),
        series: Vec::new(),
        summary: Vec::new(),
        notes: Vec::new(),
    };
    let own = args.boxwood.iter().copied().map(Contestant::Boxwood);
    let peers = match &*args.peer {
        [] => Contestant::defaults(),
        named => named.to_vec(),
    };
    let mut contestants: Vec<Contestant> = Vec::new();
    for contestant in own.chain(peers) {
        if !contestants.contains(&contestant) {
            contestants.push(contestant);
        }
    }
    let builder = |threads: usize| ThreadPoolBuilder::new().num_threads(threads).build();
    let mut run = Run {
        args,
        contestants,
        builders: BUILDERS
            .map(builder)
            .into_iter()
            .collect::<Result<_, _>>()?,
        tracer: pinned_pool(args.threads.into())?,
        report,
    };
    // What cannot be written had better be known before an hour has passed.
    run.write()?;
    let defaults = scenes::DEFAULTS.map(String::from);
    let names = match &*args.scene {
        [] => &defaults[..],
        named => named,
    };
    for name in names {
        progress(&format!("{name}: reading"));
        match scenes::open(name) {
            Ok(loaded) => run.scene(loaded)?,
            // Of a scene that somebody has named the absence is an error.
            Err(error) if !args.scene.is_empty() => return Err(failed(format!("{name}: {error}"))),
            Err(error) => run.absent(name, &error.to_string()),
        }
    }
    progress("");
    run.close()
}

struct Run<'a> {
    args: &'a PeersArgs,
    contestants: Vec<Contestant>,
    builders: Vec<ThreadPool>,
    /// Whose threads are pinned.
    tracer: ThreadPool,
    report: Report,
}

impl Run<'_> {
    fn scene(&mut self, loaded: Loaded) -> Outcome {
        let Loaded {
            name,
            mesh,
            views,
            up,
        } = loaded;
        let subject = Subject::new(mesh);
        let ready = self.build(&name, &subject);
        // Records the rays and knows the answers; nobody times it.
        let reference = StructureKind::default().build(&subject.mesh);
        for (i, view) in views.iter().enumerate() {
            let source = Source::new(
                &subject.mesh,
                &*reference,
                &view.camera,
                up,
                self.args.count,
            );
            // Random segments know no camera.
            let kinds = self.kinds(i == 0);
            self.view(&name, view, &kinds, &source, &subject, &*reference, &ready)?;
        }
        Ok(())
    }

    fn kinds(&self, random: bool) -> Vec<Kind> {
        let wanted = |kind: &Kind| {
            (self.args.rays.is_empty() || self.args.rays.contains(kind))
                && (random || *kind != Kind::Random)
        };
        Kind::ALL.into_iter().filter(wanted).collect()
    }

    /// Builds everybody, and reports who is absent.
    fn build<'s>(&mut self, scene: &str, subject: &'s Subject) -> Vec<Ready<'s>> {
        let mut ready = Vec::new();
        for contestant in self.contestants.clone() {
            progress(&format!("{scene}: building {contestant}"));
            match self.built(&contestant, scene, subject) {
                Ok(found) => ready.push(found),
                Err(reason) => self.absent(&contestant.to_string(), &reason),
            }
        }
        ready
    }

    fn built<'s>(
        &mut self,
        contestant: &Contestant,
        scene: &str,
        subject: &'s Subject,
    ) -> Result<Ready<'s>, String> {
        let best = |pool: &ThreadPool| {
            let threads = pool.current_num_threads();
            let (mut least, mut spent) = (f64::INFINITY, 0.0);
            for _ in 1..BUILDS {
                let seconds = pool.install(|| contestant.build(subject, threads))?.seconds;
                least = least.min(seconds);
                spent += seconds;
                if spent > PATIENCE {
                    break;
                }
            }
            Ok::<f64, String>(least)
        };
        let alone = &self.builders[0];
        let finished = alone.install(|| contestant.build(subject, 1))?;
        let again = if finished.seconds > PATIENCE {
            f64::INFINITY
        } else {
            best(alone)?
        };
        let mut seconds = vec![finished.seconds.min(again)];
        if contestant.builds_in_parallel() {
            for pool in &self.builders[1..] {
                seconds.push(best(pool)?);
            }
        }
        self.report.builds.push(Build {
            scene: scene.to_string(),
            triangles: subject.mesh.triangles().len(),
            contestant: contestant.to_string(),
            seconds,
            bytes: finished.built.bytes(),
        });
        if let Some(note) = finished.built.note()
            && !self.report.notes.contains(&note)
        {
            self.report.notes.push(note);
        }
        Ok(Ready {
            name: contestant.to_string(),
            built: finished.built,
        })
    }

    #[expect(clippy::too_many_arguments, reason = "all of it is the view")]
    fn view(
        &mut self,
        scene: &str,
        view: &View,
        kinds: &[Kind],
        source: &Source<'_>,
        subject: &Subject,
        reference: &dyn Intersect,
        ready: &[Ready<'_>],
    ) -> Outcome {
        let first = self.report.series.len();
        let mut answers = Answers::default();
        for &kind in kinds {
            progress(&format!("{scene}, {}: recording {kind}", view.name));
            let rays = source.record(kind);
            if let Some(folder) = &self.args.save_rays {
                fs::create_dir_all(folder)
                    .map_err(|e| failed(format!("{}: {e}", folder.display())))?;
                let file: String =
                    format!("{scene}-{}-{kind}.npy", view.name).replace([':', '/'], "-");
                files::write(&folder.join(file), &npy(&rays))?;
            }
            let workload = Workload::new(kind, rays, &subject.mesh, reference)?;
            for question in Question::ALL {
                progress(&format!("{scene}, {}: {kind} {question}", view.name));
                let rounds = self.args.rounds;
                let (turns, noise) = self.tracer.install(|| {
                    measure(
                        &subject.mesh,
                        ready,
                        &workload,
                        question,
                        rounds,
                        &mut answers,
                    )
                })?;
                self.report.series.push(Series {
                    scene: scene.to_string(),
                    view: view.name.clone(),
                    rays: kind.name(),
                    coherent: kind.is_coherent(),
                    question,
                    count: workload.rays.len(),
                    hits: workload.hits(),
                    noise,
                    ratios: Series::ratios(&turns),
                    turns,
                });
            }
        }
        progress("");
        for table in tables::view(&self.report.series[first..]) {
            say(&table.text())?;
        }
        self.report.summary = summarize(&self.report.series);
        self.write()
    }

    fn absent(&mut self, name: &str, reason: &str) {
        let absent = Absent {
            name: name.to_string(),
            reason: reason.to_string(),
        };
        if !self.report.absent.contains(&absent) {
            progress("");
            eprintln!("absent: {name}: {reason}");
            self.report.absent.push(absent);
        }
    }

    fn write(&self) -> Outcome {
        if let Some(path) = &self.args.json {
            files::write(path, serde_json::to_string_pretty(&self.report)?.as_bytes())?;
        }
        if let Some(path) = &self.args.html {
            files::write(path, tables::page(&self.report).as_bytes())?;
        }
        Ok(())
    }

    fn close(&self) -> Outcome {
        let report = &self.report;
        say(&tables::builds(report).text())?;
        say(&tables::disagreements(report).text())?;
        for table in tables::absent(report)
            .iter()
            .chain(&tables::summary(&report.summary))
        {
            say(&table.text())?;
        }
        for note in &report.notes {
            say(&format!("note: {note}\n"))?;
        }
        self.write()
    }
}

fn say(text: &str) -> Outcome {
    Ok(stdout().lock().write_all(text.as_bytes())?)
}

/// What is being done, on one line of a terminal; nothing wipes it.
fn progress(what: &str) {
    let mut stderr = stderr().lock();
    if stderr.is_terminal() {
        let _ = write!(stderr, "\r\x1b[K{what}");
        let _ = stderr.flush();
    } else if !what.is_empty() {
        let _ = writeln!(stderr, "{what}");
    }
}
