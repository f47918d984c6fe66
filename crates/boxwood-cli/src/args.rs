//! What the command line may say.
//!
//! Values are checked here, so that a wrong one is a usage error (exit code 2) before anything is read.

mod compare;
mod figure;
mod looking;
mod query;
mod values;

use crate::failure::{Failure, Outcome};
use boxwood::StructureKind;
use boxwood_render::View;
use clap::builder::styling::AnsiColor;
use clap::builder::{PossibleValuesParser, Styles, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;
use values::{Size, Vector, fov};

pub use compare::CompareArgs;
pub use figure::FigureArgs;
pub use looking::{ExplainArgs, InspectArgs};
pub use query::{QueryArgs, Question};
pub use values::{Axis, Levels, Place, Slice, join_vectors};

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Render, inspect and query real scenes.
///
/// Reads OBJ, PLY, STL and glTF files. Every acceleration structure gives the same bits, for any number of threads.
#[derive(Parser, Debug)]
#[command(
    name = "boxwood",
    version,
    styles = STYLES,
    arg_required_else_help = true,
    max_term_width = 100,
    after_help = "\
Examples:
  boxwood render                               Make the built-in picture, teapot-in-stadium.png
  boxwood render bunny.ply -o bunny.png        Render a file; the camera finds its own place
  boxwood info sponza.obj                      Say what is in a file
  boxwood cast bunny.ply --rays rays.npy -o hits.npz
  boxwood query bunny.ply --points points.npy -o near.npz closest
  boxwood inspect bunny.ply --svg boxes.svg    Look into a structure
  boxwood explain bunny.ply --pixel 640,360    Follow one ray, step by step
  boxwood compare bunny.ply --views --html bunny.html
  boxwood figure kd-traversal                  Draw how it works

`boxwood help COMMAND` says more about each."
)]
pub struct Cli {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand, Debug)]
pub enum Verb {
    Render(Box<RenderArgs>),
    Info(InfoArgs),
    Cast(CastArgs),
    Query(QueryArgs),
    Inspect(InspectArgs),
    Explain(Box<ExplainArgs>),
    Compare(Box<CompareArgs>),
    Figure(FigureArgs),
    Completions(CompletionsArgs),
    Man(ManArgs),
}

/// Render a picture of a scene
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  boxwood render
  boxwood render sponza.obj --eye -120,15,-4 --look-at 0,32,-4 --fov 60 --size 1280x720
  boxwood render helmet.gltf -o helmet.exr --spp 64
  boxwood render bunny.ply --view cost --accel bvh:median -o cost.png
  boxwood render teapot-in-stadium --camera overview --size 640x360 -o - | display
  boxwood render city:2000,seed=3 -o city.png
  boxwood render terrain:5M --cache            quicker to begin the second time
  boxwood render sponge:6 --camera inside      768 million triangles, by instances")]
pub struct RenderArgs {
    /// A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene
    #[arg(default_value = crate::scene_file::DEFAULT, value_name = "SCENE", long_help = scene_help())]
    pub scene: PathBuf,

    /// Where the picture goes: a .png or .exr file, or `-` for a PNG on standard output
    ///
    /// By default a .png in the current folder, named after the scene. EXR keeps linear light and layers for albedo,
    /// normals, depth, primitives, materials and cost. The file is written beside its place and then renamed.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: Size,

    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub spp: u32,

    /// What the picture shows
    ///
    /// An EXR holds layers for all of them; with a view other than shaded, its R G B are black.
    #[arg(long, value_name = "VIEW", default_value_t, value_parser = view_parser())]
    pub view: View,

    #[command(flatten)]
    pub camera: CameraArgs,

    /// Light and background from a latitude-longitude image (.hdr, .exr, .png, .jpg)
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,

    /// How often light may be reflected or refracted on its way
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=64))]
    pub depth: u32,

    /// Brighten (or darken) a PNG by so many stops: each doubles (or halves) the light
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_hyphen_values = true, value_parser = values::stops)]
    pub exposure: f32,

    /// Leave the background of a PNG transparent
    #[arg(long)]
    pub transparent: bool,

    /// Lay every placement of a mesh out in the world, as one large mesh
    ///
    /// By default meshes that are placed more than once are kept once, and rays are taken into their space: far less memory, but
    /// slower where many small meshes lie close together. The last bits of answers differ between the two.
    #[arg(long)]
    pub flatten: bool,

    #[command(flatten)]
    pub tracing: TracingArgs,

    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// The heading of [`CameraArgs`].
const CAMERA: &str = "Camera (by default the scene's first one, or one that shows everything)";

/// Where a picture is taken from.
#[derive(Args, Debug)]
pub struct CameraArgs {
    /// One of the scene's own cameras, by name; `boxwood info` lists them
    #[arg(long, help_heading = CAMERA, value_name = "NAME", conflicts_with_all = ["eye", "look_at", "up"])]
    pub camera: Option<String>,

    /// Where the camera stands (three values after a space will do as well)
    #[arg(long, help_heading = CAMERA, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub eye: Option<Vector>,

    /// The point in the middle of the picture; by default the middle of the scene
    #[arg(
        long,
        help_heading = CAMERA,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        requires = "eye"
    )]
    pub look_at: Option<Vector>,

    /// The direction that points up in the picture; by default the file format's
    #[arg(long, help_heading = CAMERA, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub up: Option<Vector>,

    /// Vertical field of view
    #[arg(long, help_heading = CAMERA, value_name = "DEGREES", allow_hyphen_values = true, value_parser = fov)]
    pub fov: Option<f32>,
}

/// Say what is in a scene
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  boxwood info sponza.obj
  boxwood info --json helmet.gltf | jq .triangles")]
pub struct InfoArgs {
    /// A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene
    #[arg(value_name = "SCENE", long_help = scene_help())]
    pub scene: PathBuf,

    /// Report as JSON
    ///
    /// `triangles` and `degenerate` count every placement of a mesh, `unique_triangles` each mesh once. `bounds` is
    /// null when there is nothing.
    #[arg(long)]
    pub json: bool,
}

/// Cast many rays from a NumPy file
#[derive(Args, Debug)]
#[command(after_help = "\
Rays are an array of float32 or float64 (which is rounded to float32), of shape
  (n, 6)  ox oy oz dx dy dz              from the origin without end
  (n, 8)  ox oy oz t_min dx dy dz t_max  hits with t_min <= t <= t_max
Directions need no unit length: t counts in lengths of the direction. A ray with a NaN or an
infinite origin or direction misses.

Hits are arrays of length n, the same bytes for every structure and any number of threads:
  t          float32  where the ray hits; inf for a miss
  u, v       float32  weights of the triangle's second and third corner; 0 for a miss
  primitive  uint32   the triangle's number among all unique triangles, in file order
  geometry   uint32   the mesh's number
  instance   uint32   which placement of the mesh, depth first; 0 for a mesh placed once
All three are 4294967295 for a miss. Of equally near hits one of a mesh placed once counts, and then
the lowest (instance, primitive).

Examples:
  boxwood cast bunny.ply --rays rays.npy -o hits.npz
  boxwood cast bunny.ply --rays rays.npy --any --threads 1 --repeat 5 --json
  boxwood cast bunny.ply --rays rays.npy --all --normals -o hits.npz")]
pub struct CastArgs {
    /// A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene
    #[arg(value_name = "SCENE", long_help = scene_help())]
    pub scene: PathBuf,

    /// The rays: a NumPy .npy file, or `-` for standard input
    #[arg(long, value_name = "FILE")]
    pub rays: PathBuf,

    /// Where the hits go: a NumPy .npz file, or `-` for standard output; without it they are only counted
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Ask only whether anything is hit: one array, `occluded` (bool)
    #[arg(long, conflicts_with_all = ["all", "normals"])]
    pub any: bool,

    /// Ask for all hits, nearest first: ray i's are those from offsets[i] to offsets[i + 1]
    #[arg(long)]
    pub all: bool,

    /// Add an array `normal` of shape (n, 3), float32
    ///
    /// Unit normals of the triangles themselves, not smoothed, on the side from which the corners of the placed
    /// triangle run counter-clockwise, whichever side the ray comes from; 0 for a miss.
    #[arg(long)]
    pub normals: bool,

    /// Lay every placement of a mesh out in the world, as one large mesh
    ///
    /// By default meshes that are placed more than once are kept once, and rays are taken into their space: far less memory, but
    /// slower where many small meshes lie close together. The last bits of answers differ between the two.
    #[arg(long)]
    pub flatten: bool,

    #[command(flatten)]
    pub tracing: TracingArgs,

    /// Trace so many times, for the clock's sake
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub repeat: u32,

    /// Report as JSON
    ///
    /// `trace_seconds` and `mrays_per_second` (millions) are the median of the repeats, `bytes` the memory of the
    /// structure without the triangles.
    #[arg(long)]
    pub json: bool,
}

/// What rays are traced with.
#[derive(Args, Debug)]
pub struct TracingArgs {
    /// The acceleration structure; the answers are the same for all
    #[arg(long, value_name = "KIND", default_value = FASTEST, help = accel_help())]
    pub accel: StructureKind,

    #[command(flatten)]
    pub cache: CacheArgs,

    #[command(flatten)]
    pub threads: ThreadArgs,
}

/// Where trees are kept from one run to the next.
#[derive(Args, Debug)]
pub struct CacheArgs {
    /// Keep wide trees from one run to the next, by default in the user's folder for caches
    ///
    /// That is $XDG_CACHE_HOME/boxwood, or ~/.cache/boxwood (on macOS ~/Library/Caches/boxwood, on Windows
    /// %LOCALAPPDATA%\boxwood). A tree is found again by the contents of its mesh and its settings, and looked at from end to
    /// end before it is used: the answers are the same bits with and without. Small trees are not kept. The folder may be
    /// emptied at any time.
    #[arg(
        long,
        value_name = "DIR",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "",
        value_parser = values::folder
    )]
    pub cache: Option<PathBuf>,
}

/// What traces fastest on most machines.
const FASTEST: &str = "wide8";

/// How much of the machine is used.
#[derive(Args, Debug)]
pub struct ThreadArgs {
    /// How many threads to use; by default one for each core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
}

/// Views by name, listed in the help and completed by shells.
fn view_parser() -> impl TypedValueParser<Value = View> {
    PossibleValuesParser::new(View::ALL.map(View::name)).try_map(|name| name.parse::<View>())
}

/// What a scene may be, with the names of those that Boxwood makes itself.
fn scene_help() -> String {
    format!(
        "A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene: {}. N is how many (20k, 10M), and \
         has a default; `,seed=S` makes another one of the kind",
        boxwood_scene::builtin::list()
    )
}

fn accel_help() -> String {
    let names = StructureKind::all()
        .map(|kind| kind.name())
        .collect::<Vec<_>>()
        .join(", ");
    format!("The acceleration structure: {names}; settings follow after commas (bvh:median,leaf=2)")
}

impl ThreadArgs {
    /// Does `work` in a pool of as many threads as asked for, and tells it how many these are.
    pub fn in_pool<T: Send>(&self, work: impl FnOnce(usize) -> Outcome<T> + Send) -> Outcome<T> {
        let threads = match self.threads {
            Some(n) => n as usize,
            None => std::thread::available_parallelism().map_or(1, usize::from),
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Failure::new(format!("{threads} threads cannot be started: {e}")))?;
        pool.install(|| work(threads))
    }
}

/// Print a completion script for a shell
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  boxwood completions bash > ~/.local/share/bash-completion/completions/boxwood
  boxwood completions zsh > ~/.zfunc/_boxwood
  boxwood completions fish > ~/.config/fish/completions/boxwood.fish")]
pub struct CompletionsArgs {
    /// The shell
    pub shell: Shell,
}

/// Print the manual page
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  boxwood man | man -l -
  boxwood man --dir ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Write the pages of the command and of each verb into this folder instead
    #[arg(long, value_name = "FOLDER")]
    pub dir: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_grammar_is_sound() {
        Cli::command().debug_assert();
    }
}
