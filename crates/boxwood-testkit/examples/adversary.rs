//! A billion adversarial answers of wide trees, each compared with the judge's to the bit.
//!
//! `cargo run --release -p boxwood-testkit --example adversary -- [--rays 1e9] [--seed 1] [--from 0] [--only ROUND]`
//!
//! `--help` says what the options mean. Exit code 1 when an answer differs or a structure panics, 2 when an argument makes no
//! sense.

use boxwood::Isa;
use boxwood_testkit::adversary::{EDITION, Found, round};
use rayon::prelude::*;
use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Rounds between two looks at the clock.
const STRETCH: u64 = 256;
/// Between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(10);
/// So many differences are printed.
const PRINTED: usize = 20;

/// What is to be done.
struct Task {
    answers: u64,
    seed: u64,
    from: u64,
    only: Option<u64>,
}

const HELP: &str = "\
Asks wide trees about adversarial rays, by every way of asking and on every instruction set of the machine,
and compares each answer with that of the exhaustive test, to the bit.

Usage: just adversary [--rays N] [--seed N] [--from ROUND] [--only ROUND]

  --rays N      how many answers to compare at least: rays by ways of asking by trees and
                instruction sets; `1e9`, the default, takes hours
  --seed N      what all meshes and rays follow from; 1 by default
  --from ROUND  goes on with this round, as the last line of a run that was ended says; 0 by default
  --only ROUND  repeats this round alone, as the line of a difference names it

Runs on all cores; RAYON_NUM_THREADS=1 keeps it to one. The exit code is 1 when an answer differs or a
structure panics, and 2 when an argument makes no sense.

Example: a run of a few minutes with meshes of its own, and one of its rounds again
  just adversary --rays 2e7 --seed 7
  just adversary --seed 7 --only 12
";

fn main() -> ExitCode {
    if std::env::args().any(|argument| ["--help", "-h"].contains(&&*argument)) {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    let task = match Task::read(std::env::args().skip(1)) {
        Ok(task) => task,
        Err(message) => {
            eprintln!("{message}");
            return ExitCode::from(2);
        }
    };
    let sets: Vec<&str> = Isa::available().into_iter().map(Isa::name).collect();
    let sets = sets.join(", ");
    println!(
        "seed {} of edition {EDITION}, wide8 and wide16 on {sets}",
        task.seed
    );
    let (start, mut told) = (Instant::now(), Instant::now());
    let mut all = Found::default();
    let mut differing = 0;
    let mut next = task.only.unwrap_or(task.from);
    loop {
        let rounds = next..next.saturating_add(if task.only.is_some() { 1 } else { STRETCH });
        next = rounds.end;
        let found: Vec<Found> = rounds.into_par_iter().map(|n| run(task.seed, n)).collect();
        for found in found {
            all.rays += found.rays;
            all.hits += found.hits;
            all.answers += found.answers;
            for difference in found.differences {
                if differing < PRINTED {
                    println!("{difference}");
                }
                differing += 1;
            }
        }
        if task.only.is_some() || all.answers >= task.answers || next == u64::MAX {
            break;
        }
        if told.elapsed() > PROGRESS {
            told = Instant::now();
            println!(
                "{} answers, {differing} differences; goes on with --seed {} --from {next}",
                all.answers, task.seed
            );
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{} rays ({} hit), {} answers by 5 ways of asking 2 widths on {sets}, {:.1} million a second: {differing} \
         differences (next: --seed {} --from {next})",
        all.rays,
        all.hits,
        all.answers,
        all.answers as f64 / seconds / 1.0e6,
        task.seed
    );
    ExitCode::from(u8::from(differing > 0))
}

/// A round; a panic in it is a difference.
fn run(seed: u64, number: u64) -> Found {
    catch_unwind(|| round(seed, number)).unwrap_or_else(|_| Found {
        differences: vec![format!("round {number} of seed {seed} panics")],
        ..Found::default()
    })
}

impl Task {
    fn read(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut task = Self {
            answers: 1_000_000_000,
            seed: 1,
            from: 0,
            only: None,
        };
        while let Some(name) = arguments.next() {
            if !["--rays", "--seed", "--from", "--only"].contains(&&*name) {
                return Err(format!(
                    "`{name}` is none of --rays, --seed, --from, --only, --help"
                ));
            }
            let text = arguments
                .next()
                .ok_or(format!("`{name}` needs a number; see --help"))?;
            // `1e9` reads as well as `1000000000`.
            let real = text.parse::<f64>().ok();
            let real = real.filter(|x| x.fract() == 0.0 && (0.0..1.0e18).contains(x));
            let number = text.parse().ok().or(real.map(|x| x as u64));
            let number = number.ok_or(format!("`{text}` is not a whole number"))?;
            match name.as_str() {
                "--rays" => task.answers = number,
                "--seed" => task.seed = number,
                "--from" => task.from = number,
                _ => task.only = Some(number),
            }
        }
        Ok(task)
    }
}
