//! What may be said to `boxwood figure`.

use crate::figure;
use clap::Args;
use clap::builder::PossibleValuesParser;
use std::path::PathBuf;

/// Draw the figures that explain the structures
#[derive(Args, Debug)]
#[command(after_help = "\
Every figure is made by the structures themselves: cells, steps and numbers are those of the code.

Examples:
  boxwood figure --list
  boxwood figure grid-walk
  boxwood figure kd-traversal -o - | display
  boxwood figure --all --dir gallery/figures")]
pub struct FigureArgs {
    /// Which figure
    #[arg(
        value_name = "NAME",
        required_unless_present_any = ["all", "list"],
        conflicts_with_all = ["all", "list"],
        value_parser = PossibleValuesParser::new(figure::names())
    )]
    pub name: Option<String>,

    /// Where it goes: an SVG file, or `-` for standard output; by default NAME.svg in the current folder
    #[arg(short, long, value_name = "FILE", requires = "name")]
    pub output: Option<PathBuf>,

    /// Draw all of them
    #[arg(long, requires = "dir", conflicts_with = "list")]
    pub all: bool,

    /// The folder for all of them, made where there is none
    #[arg(long, value_name = "FOLDER", requires = "all")]
    pub dir: Option<PathBuf>,

    /// List them, each with the question that it answers
    #[arg(long)]
    pub list: bool,
}
