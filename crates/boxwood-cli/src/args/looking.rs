//! What may be said to the verbs that look into a structure: `inspect` and `explain`.

use super::values::{Axis, Levels, Pixel, Size, Slice, SpelledRay};
use super::{CameraArgs, TracingArgs};
use boxwood::StructureKind;
use clap::Args;
use std::path::PathBuf;

/// Look at the nodes and cells of a structure
#[derive(Args, Debug)]
#[command(after_help = "\
A drawing shows the boxes of all nodes (or the cells) as seen along an axis, or with --slice those
that a plane cuts, with what the plane cuts of the scene. The colour of a box is its level: the
root is 0, and so are the cells of a grid.

Examples:
  boxwood inspect bunny.ply
  boxwood inspect bunny.ply --accel bvh:binned --accel bvh:median --svg bunny.svg --slice z=50%
  boxwood inspect city:200 --svg city.svg --axis y --levels 0..8
  boxwood inspect bunny.ply --accel bvh:binned,leaf=8 --json | jq .structures[0].leaf_sizes
  boxwood inspect teapot-in-stadium --glb boxes.glb --levels 4..6")]
pub struct InspectArgs {
    /// A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene
    #[arg(value_name = "SCENE", long_help = super::scene_help())]
    pub scene: PathBuf,

    /// A structure to look at, with its settings; may be repeated
    #[arg(long, value_name = "KIND", default_values_t = [StructureKind::default()], help = super::accel_help())]
    pub accel: Vec<StructureKind>,

    /// Draw the boxes of the nodes into an SVG file, or to standard output for `-`
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,

    /// Draw what a plane cuts: an axis and a place on it, in the scene's units or percent (z=0.5, y=50%)
    #[arg(
        long,
        value_name = "AXIS=PLACE",
        requires = "svg",
        conflicts_with = "axis",
        allow_hyphen_values = true
    )]
    pub slice: Option<Slice>,

    /// Draw everything as seen along this axis
    #[arg(long, value_name = "AXIS", requires = "svg", default_value = "z")]
    pub axis: Axis,

    /// Only draw these levels, both ends included (2..5, 3, ..4, 6..)
    #[arg(long, value_name = "A..B")]
    pub levels: Option<Levels>,

    /// Write the boxes as lines into an OBJ file, an object for each level
    #[arg(long, value_name = "FILE")]
    pub obj: Option<PathBuf>,

    /// Write the boxes as lines into a GLB file, a node and a colour for each level
    #[arg(long, value_name = "FILE")]
    pub glb: Option<PathBuf>,

    /// Report as JSON
    ///
    /// `leaf_depths` and `leaf_sizes` are lists of pairs: a depth (or a number of primitives), and how many leaves (or
    /// cells) have it. `sah_cost` counts primitive tests.
    #[arg(long)]
    pub json: bool,
}

/// Say what one ray does in a structure, step by step
#[derive(Args, Debug)]
#[command(after_help = "\
Every box that the ray is held against is listed with the interval [enter, leave] in which the ray
lies in it, and with what becomes of it:
  opened     the ray enters it within its own interval
  put aside  so does it this one, but its sibling comes first
  missed     the ray's line passes it: the interval is empty
  behind     it ends before the ray's interval begins
  beyond     it begins behind the end of the ray's interval, which hits have shortened

Examples:
  boxwood explain teapot-in-stadium --pixel 640,360
  boxwood explain bunny.ply --pixel 320,240 --size 640x480 --accel bvh:median
  boxwood explain bunny.ply --ray 0,0.1,1,0,0,-1 --json | jq .summary
  boxwood explain soup:40 --ray -2,0.1,0.1,1,0,0 --accel bvh:binned,leaf=1,axes=xy --svg film.svg")]
pub struct ExplainArgs {
    /// A scene file (.obj, .ply, .stl, .gltf, .glb), or the name of a built-in scene
    #[arg(value_name = "SCENE", long_help = super::scene_help())]
    pub scene: PathBuf,

    /// The ray through the middle of a pixel of the picture that `boxwood render` makes, from 0,0 at the top left
    #[arg(
        long,
        value_name = "X,Y",
        required_unless_present = "ray",
        conflicts_with = "ray"
    )]
    pub pixel: Option<Pixel>,

    /// A ray from an origin along a direction, which need not have length 1: t counts in it
    #[arg(long, value_name = "OX,OY,OZ,DX,DY,DZ", allow_hyphen_values = true)]
    pub ray: Option<SpelledRay>,

    /// Width and height of the picture that the pixel belongs to
    #[arg(
        long,
        value_name = "WxH",
        default_value = "1280x720",
        conflicts_with = "ray"
    )]
    pub size: Size,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub tracing: TracingArgs,

    /// Draw the steps as a film strip into an SVG file, or to standard output for `-`
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,

    /// Draw the film as seen along this axis; by default the one along which the ray goes least
    #[arg(long, value_name = "AXIS", requires = "svg")]
    pub axis: Option<Axis>,

    /// Draw at most so many steps
    #[arg(long, value_name = "N", requires = "svg", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=2000))]
    pub frames: u32,

    /// Report as JSON
    ///
    /// Numbers that are infinite or NaN are null.
    #[arg(long)]
    pub json: bool,
}
