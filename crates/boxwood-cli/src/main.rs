//! The `boxwood` command: render, inspect and query real scenes, compare structures.
//!
//! *How it is laid out.* `args` says what the command line may say; each verb has a file or a folder (`render`, `info`, `cast`, `query`,
//! `compare`, `inspect`, `explain`, `figure`, `shell`); `scene_file` finds the scene and `camera` its viewer, `cache` keeps trees from one run to the next, `output` writes files whole or
//! not at all, `npy`, `npz` and `table` speak NumPy, `svg` draws, `terminal` and `progress` speak to people.
//!
//! *What can be relied on.* Exit code 0 for success, 1 for bad input or a refusal of the system, with one sentence on
//! stderr, 2 for a command line that means nothing. Results go to stdout, everything else to stderr.
#![forbid(unsafe_code)]

mod args;
mod cache;
mod camera;
mod cast;
mod compare;
mod explain;
mod failure;
mod figure;
mod info;
mod inspect;
mod npy;
mod npz;
mod output;
mod progress;
mod query;
mod render;
mod scene_file;
mod shell;
mod svg;
mod table;
mod terminal;

use args::{Cli, Verb};
use clap::Parser;
use failure::Failure;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse_from(args::join_vectors(std::env::args_os()));
    let outcome = match &cli.verb {
        Verb::Render(args) => render::run(args),
        Verb::Info(args) => info::run(args),
        Verb::Cast(args) => cast::run(args),
        Verb::Query(args) => query::run(args),
        Verb::Inspect(args) => inspect::run(args),
        Verb::Explain(args) => explain::run(args),
        Verb::Compare(args) => compare::run(args),
        Verb::Figure(args) => figure::run(args),
        Verb::Completions(args) => shell::completions(args),
        Verb::Man(args) => shell::man(args),
    };
    match outcome {
        Ok(()) | Err(Failure::Unheard) => ExitCode::SUCCESS,
        Err(Failure::Said(sentence)) => {
            terminal::error(&sentence);
            ExitCode::FAILURE
        }
    }
}
