//! The arguments of `boxwood compare`.

use super::values::{self, Size};
use super::{CameraArgs, ThreadArgs};
use boxwood::StructureKind;
use boxwood_render::workload::RayKind;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::path::PathBuf;

use crate::compare::Family;

/// What every help text of the verb ends with.
macro_rules! examples {
    () => {
        "\
Examples:
  boxwood compare bunny.ply
  boxwood compare sponza.obj --accel bvh:median --accel bvh:binned,leaf=2 --rays primary,diffuse
  boxwood compare sponza.obj --presets --accel bvh:binned --html presets.html
  boxwood compare sponza.obj --views --html sponza.html --csv sponza.csv
  boxwood compare bunny.ply --sweep bvh --accel bvh:binned --rays primary --html leaves.html
  boxwood compare bunny.ply --json | jq .winners.mrays_per_second"
    };
}

const LONG_HELP: &str = concat!(
    examples!(),
    "

What is done, in this order:
  1. Rays are recorded once from the camera: primary rays through the middles of pixels, and
     from what they meet shadow rays to the lights, ambient occlusion (ao, a tenth of the
     scene's diagonal long), a diffuse bounce; random segments within the scene's box beside.
  2. Every structure is built with all threads; the time is the median of up to three builds.
  3. Answers are checked: every ray's nearest hit must have the same bits for every structure,
     and the judge (`brute`, which tests every triangle) must agree on a sample. A structure so
     slow that it would keep the others waiting is asked a sample too; the report says how many
     rays. A wrong answer ends the command with exit code 1.
  4. The same rays are timed on one thread, one after the other, structures taking turns in
     every round; what counts is the median of the rounds. Shadow and ao rays ask whether
     anything is in the way, as renderers do, all others for the nearest hit; with --closest
     all do.

`brute` is always there, as the factor to be faster by. It wins no column, nor does a structure
a hundred times slower than the fastest.

The JSON has these keys; each number is null where there is nothing to measure:
  format_version  1; keys may be added without a new number
  settings        command, scene, triangles, camera, image (of the primary rays), rounds,
                  memory_bytes (the cap), and what else is needed to repeat it
  machine         processor, cores, threads (for building), system, architecture, boxwood
  workloads       for each kind of ray: rays, hits, question (`closest` or `occluded`)
  structures      for each: structure, failure (a sentence, or null) and measured:
                  build_seconds, bytes, bytes_per_triangle, nodes, leaves, depth,
                  references_per_triangle, sah_cost (predicted), nodes_per_ray, leaves_per_ray
                  and primitives_per_ray (counted, over all rays), mrays_per_second (geometric
                  mean over the kinds), speedup (over brute), histogram (share of rays of
                  2^(i/2) <= 1 + nodes + primitives < 2^((i+1)/2)), and for each kind: kind,
                  mrays_per_second, speedup, nodes_per_ray, leaves_per_ray, primitives_per_ray,
                  rays_asked (of the workload: checked and timed); and forecast, for wide trees:
                  build_seconds, nanoseconds_per_ray, peak_bytes and bytes as the library's model
                  of costs expects them, in nominal time, before anything is built
  winners         the best structures of each column; none in a sweep
  jobs            for 10^3 to 10^9 rays: rays, first (who is done first, building included),
                  seconds, and chosen: whom the model would take (structure), what it expects
                  (expected_seconds) and what that one takes (seconds)
  sweep           null, or with --sweep what was changed and every curve's points"
);

/// Compare acceleration structures on a scene
#[derive(Args, Debug)]
#[command(after_help = examples!(), after_long_help = LONG_HELP)]
pub struct CompareArgs {
    /// A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,

    /// A structure to compare; repeat it for each one. By default all of them
    #[arg(long, value_name = "KIND", help = accel_help())]
    pub accel: Vec<StructureKind>,

    /// Instead of comparing kinds, change one setting of a family from one end to the other
    ///
    /// `grid`: its resolution, from one cell to far too many; `kd` and `bvh`: the size of leaves, for every builder of the
    /// family or those that --accel names. The lecture's choice and the measured best are marked.
    #[arg(long, value_name = "FAMILY", value_parser = family_parser())]
    pub sweep: Option<Family>,

    /// Compare the qualities of wide trees: fast, balanced, high and ultra
    ///
    /// Of those that --accel names, beside whatever else it names; of wide8 where it names none.
    #[arg(long, conflicts_with = "sweep")]
    pub presets: bool,

    /// Kinds of rays, divided by commas
    #[arg(long, value_name = "KIND", value_delimiter = ',', default_value = "primary,shadow,ao,diffuse,random", value_parser = ray_parser())]
    pub rays: Vec<RayKind>,

    /// How many rays of each kind; kinds that begin on surfaces have as many as primary rays hit
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub count: u32,

    /// How often each structure takes its turn
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,

    /// Ask for the nearest hit of shadow and ao rays too
    #[arg(long)]
    pub closest: bool,

    /// The most memory that one structure may take, such as 512M or 2G
    ///
    /// One that would need more is reported as such. By default there is no limit, in a sweep 2G.
    #[arg(long, value_name = "BYTES", value_parser = values::memory)]
    pub memory: Option<usize>,

    #[command(flatten)]
    pub camera: CameraArgs,

    /// Width and height of the pictures; their shape is that of the recorded view
    #[arg(long, value_name = "WxH", default_value = "480x270")]
    pub size: Size,

    #[command(flatten)]
    pub threads: ThreadArgs,

    /// Add pictures to the HTML report: the view, where each structure spends its work, where any two differ
    #[arg(long, requires = "html")]
    pub views: bool,

    /// Write a report that needs no other file and no network; `-` is standard output
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub html: Option<PathBuf>,

    /// Write the numbers as comma-separated values, one line per structure and kind of ray; `-` is standard output
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub csv: Option<PathBuf>,

    /// Report as JSON
    #[arg(long, help_heading = "Output")]
    pub json: bool,
}

fn accel_help() -> String {
    let names = StructureKind::all().map(|kind| kind.name());
    format!(
        "A structure to compare, repeated for each one (its settings follow after commas); by default all: {}",
        names.collect::<Vec<_>>().join(", ")
    )
}

fn ray_parser() -> impl TypedValueParser<Value = RayKind> {
    PossibleValuesParser::new(RayKind::ALL.map(RayKind::name))
        .try_map(|name| name.parse::<RayKind>())
}

fn family_parser() -> impl TypedValueParser<Value = Family> {
    PossibleValuesParser::new(Family::there().map(Family::name))
        .try_map(|name| name.parse::<Family>())
}
