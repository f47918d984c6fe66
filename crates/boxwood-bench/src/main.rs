//! Boxwood and its peers side by side: one process, the same rays, the same triangles, in turns.
//!
//! *How it is laid out.* `scenes` and `rays` say what is traced, `peers` by whom. `measure` checks every answer (`judge`
//! says who is right where they differ) and lets all take turns on the `machine`; `report` makes figures of the times and
//! `tables` shows them.
//!
//! *What can be relied on.* Nothing is timed whose answers were not checked. Exit code 0 for success, 1 with one sentence
//! on stderr, also when one of Boxwood's structures is wrong; 2 for a command line that means nothing.
#![deny(unsafe_code)]

mod args;
mod failure;
mod files;
mod judge;
mod machine;
mod measure;
mod peers;
mod rays;
mod report;
mod run;
mod scenes;
mod tables;

use args::{Cli, Verb};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Cli {
        verb: Verb::Peers(args),
    } = Cli::parse();
    match run::run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
