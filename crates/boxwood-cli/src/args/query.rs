//! What `boxwood query` may be told.

use super::{CacheArgs, ThreadArgs, scene_help, values};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Ask about points: what is near, what is inside
#[derive(Args, Debug)]
#[command(
    subcommand_value_name = "QUESTION",
    subcommand_help_heading = "Questions",
    disable_help_subcommand = true,
    after_help = "\
Points are an array of float32 or float64 (which is rounded to float32), of shape (n, 3). A point
with a NaN or an infinite coordinate is near nothing and inside nothing.

`closest`, `nearest` and `within` answer in arrays, a row for each triangle found:
  distance   float32  world units; inf where nothing is near
  point      float32  of shape (n, 3): the closest point of the triangle, world space
  u, v       float32  weights of the triangle's second and third corner
  primitive  uint32   the triangle's number among all unique triangles, in file order
  geometry   uint32   the mesh's number
  instance   uint32   which placement of the mesh, depth first; 0 for a mesh placed once
Row i of `closest` is point i's; all three are 4294967295 where there are no triangles. For
`nearest` and `within`, point i's are those from offsets[i] to offsets[i + 1], nearest first.
Of triangles at one distance the lowest number counts.

`inside` answers in arrays of length n:
  inside      bool   in the solid that the surface bounds, or on the surface
  winding     int64  how often the surface winds around the point
  on_surface  bool   exactly on a triangle

Examples:
  boxwood query bunny.ply --points points.npy -o near.npz closest
  boxwood query bunny.ply --points points.npy -o near.npz nearest -k 10
  boxwood query bunny.ply --points points.npy -o near.npz within -r 0.01
  boxwood query teapot-in-stadium --points points.npy --json inside"
)]
pub struct QueryArgs {
    /// A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene
    #[arg(value_name = "SCENE", long_help = scene_help())]
    pub scene: PathBuf,

    /// The points: a NumPy .npy file, or `-` for standard input
    #[arg(long, value_name = "FILE")]
    pub points: PathBuf,

    /// Where the answers go: a NumPy .npz file, or `-` for standard output; without it they are only counted
    #[arg(short, long, value_name = "FILE", global = true)]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub cache: CacheArgs,

    #[command(flatten)]
    pub threads: ThreadArgs,

    /// Report as JSON
    #[arg(long, global = true)]
    pub json: bool,

    #[command(subcommand)]
    pub question: Question,
}

/// What is asked of each point.
#[derive(Subcommand, Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// The closest point of the surface
    Closest,
    /// The closest triangles
    Nearest {
        /// How many
        #[arg(short, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
        k: u32,
    },
    /// All triangles within a radius
    Within {
        /// The radius, world units
        #[arg(short, value_name = "RADIUS", allow_hyphen_values = true, value_parser = values::radius)]
        r: f32,
    },
    /// Whether the point is inside a closed surface; exact
    Inside,
}
