//! What the command line may say.

use crate::peers::{self, Contestant};
use crate::rays::Kind;
use boxwood::StructureKind;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Boxwood and its peers, side by side on the same rays
#[derive(Parser, Debug)]
#[command(name = "boxwood-bench", version)]
pub struct Cli {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand, Debug)]
pub enum Verb {
    Peers(PeersArgs),
}

/// Time Boxwood's structures and other libraries in turns, on the same triangles and rays
///
/// All answers are checked before anything is timed. Embree is fetched with pip when it is asked for and not there yet.
#[derive(Args, Debug)]
pub struct PeersArgs {
    /// A scene of the list below, a built-in scene (terrain:1M), or a file; repeat it for each one
    ///
    /// bunny, sponza (two views), dragon, kitchen, stadium, terrain:5M and plants:8k by default. Those that are files are
    /// looked for in the folder that the environment variable BOXWOOD_SCENES names.
    #[arg(long, value_name = "NAME|FILE")]
    pub scene: Vec<String>,

    /// A kind of rays, repeated for each one; by default all: tile, scanline, shadow-point, shadow-area, ao, diffuse-1,
    /// diffuse-3, random
    #[arg(long, value_name = "KIND")]
    pub rays: Vec<Kind>,

    /// A peer with its settings, repeated for each one
    #[arg(long, value_name = "NAME", help = peer_help())]
    pub peer: Vec<Contestant>,

    /// One of Boxwood's structures with its settings, repeated for each one
    #[arg(long, value_name = "KIND", default_values_t = own())]
    pub boxwood: Vec<StructureKind>,

    /// About how many rays of each kind
    #[arg(long, value_name = "N", default_value_t = 500_000, value_parser = clap::value_parser!(u32).range(64..=16_777_216))]
    pub count: u32,

    /// How often each one takes its turn
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,

    /// How many threads trace, each on a core of its own
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,

    /// Write everything that was measured as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write a report that needs no other file and no network
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,

    /// Write the rays as NumPy arrays, (n, 8) float32: origin, t_min, direction, t_max
    #[arg(long, value_name = "DIR")]
    pub save_rays: Option<PathBuf>,
}

/// The wide trees, and the default structure, which is two-way.
fn own() -> Vec<StructureKind> {
    let known = |name: &str| name.parse().expect("a structure");
    vec![known("wide16"), known("wide8"), StructureKind::default()]
}

fn peer_help() -> String {
    let defaults: Vec<String> = Contestant::defaults()
        .iter()
        .map(ToString::to_string)
        .collect();
    format!(
        "A peer, repeated for each one: {}; by default {}",
        peers::PEERS,
        defaults.join(", ")
    )
}
