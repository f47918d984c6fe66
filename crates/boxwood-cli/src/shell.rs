//! `boxwood completions` and `boxwood man`: what the command knows about itself.

use crate::args::{Cli, CompletionsArgs, ManArgs};
use crate::failure::{Failure, Outcome};
use crate::output::Destination;
use crate::terminal::{self, Channel, counted};
use clap::CommandFactory;
use clap_mangen::Man;
use std::fs;

/// Prints a completion script.
pub fn completions(args: &CompletionsArgs) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "boxwood", &mut script);
    terminal::pour(&script)
}

/// Prints the manual page, or writes those of all verbs into a folder.
pub fn man(args: &ManArgs) -> Outcome {
    let mut command = Cli::command();
    command.build();
    let Some(folder) = &args.dir else {
        return terminal::pour(page(command)?.as_bytes());
    };
    fs::create_dir_all(folder)
        .map_err(|e| Failure::file(folder, format_args!("cannot be made: {e}")))?;
    let verbs: Vec<clap::Command> = command
        .get_subcommands()
        .filter(|verb| verb.get_name() != "help")
        .cloned()
        .collect();
    let mut pages = 0;
    for command in std::iter::once(command).chain(verbs) {
        let name = command
            .get_display_name()
            .unwrap_or(command.get_name())
            .to_string();
        Destination::File(folder.join(format!("{name}.1"))).write(page(command)?.as_bytes())?;
        pages += 1;
    }
    Channel::Stdout.say(format_args!(
        "wrote {} to {}",
        counted(pages, "page"),
        folder.display()
    ))
}

fn page(command: clap::Command) -> Outcome<String> {
    let mut page = Vec::new();
    Man::new(command).render(&mut page)?;
    let page = String::from_utf8(page)?;
    // The tables and examples under the help keep their lines.
    Ok(match page.split_once(".SH EXTRA\n") {
        None => page,
        Some((before, extra)) => {
            let (extra, after) = extra.split_at(extra.find(".SH ").unwrap_or(extra.len()));
            format!("{before}.SH NOTES\n.nf\n{extra}.fi\n{after}")
        }
    })
}
