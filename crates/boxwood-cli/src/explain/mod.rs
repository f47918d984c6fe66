//! `boxwood explain`: what one ray does in a structure, step by step.

pub mod film;
pub mod story;
mod text;

use crate::args::ExplainArgs;
use crate::cache::Cache;
use crate::camera;
use crate::failure::{Failure, Outcome};
use crate::output::Destination;
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use crate::terminal::{self, Channel};
use boxwood::{BruteForce, Hit, Intersect, Ray};
use boxwood_render::camera::pixel_ray;
use boxwood_render::{Shelf, kept_structure};
use boxwood_scene::FlatScene;
use serde::Serialize;
use story::{Story, Summary, Told};

/// Everything that is said.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    triangles: usize,
    structure: String,
    /// Null for a ray that was written out.
    pixel: Option<[u32; 2]>,
    ray: RayNumbers,
    steps: &'a [Told],
    summary: Summary,
    /// Null for a miss.
    hit: Option<Found>,
    /// Whether testing every triangle gives the same bits.
    judge_agrees: bool,
}

#[derive(Serialize)]
struct RayNumbers {
    origin: [f32; 3],
    direction: [f32; 3],
    t_min: f32,
    t_max: f32,
}

/// The answer.
#[derive(Serialize)]
struct Found {
    t: f32,
    u: f32,
    v: f32,
    /// Number in the structure: every placement of a mesh has numbers of its own.
    primitive: u32,
    point: [f32; 3],
    mesh: String,
    /// Number in its mesh.
    triangle: u32,
    placement: u32,
}

pub fn run(args: &ExplainArgs) -> Outcome {
    let output = args.svg.as_deref().map(Destination::new);
    if let Some(output) = &output {
        output.check([args.scene.as_path()])?;
    }
    let channel = output.as_ref().map_or(Channel::Stdout, Destination::report);
    args.tracing.threads.in_pool(|_| {
        let file = scene_file::open(&args.scene)?;
        terminal::warnings(&file.name, &file.scene.warnings);
        let ray = ray(args, &file)?;
        let flat = file.flatten()?;
        let kind = args.tracing.accel;
        let cache = Cache::open(&args.tracing.cache, kind)?;
        let structure = {
            let _progress = Progress::spinner(format!("Building {kind}"));
            let shelf = cache.as_deref().map(|cache| cache as &dyn Shelf);
            kept_structure(kind, &flat.mesh, shelf)
        };
        let story = Story::of(&*structure, &ray);
        let hit = structure.closest_hit(&ray);
        let judged = BruteForce::new(&flat.mesh).closest_hit(&ray);
        let report = Report {
            scene: &file.name,
            triangles: flat.mesh.triangles().len(),
            structure: kind.to_string(),
            pixel: args.pixel.map(|pixel| pixel.0),
            ray: RayNumbers {
                origin: ray.origin.to_array(),
                direction: ray.direction.to_array(),
                t_min: ray.t_min,
                t_max: ray.t_max,
            },
            steps: &story.steps,
            summary: story.summary(),
            hit: hit.map(|hit| Found::of(hit, &ray, &flat, &file)),
            judge_agrees: same(hit, judged),
        };
        if let Some(output) = &output {
            let plan = film::Plan {
                title: format!("{kind} over {}", file.name),
                ray: &ray,
                axis: args.axis,
                frames: args.frames as usize,
                scene: film::Outlines {
                    name: "triangle",
                    count: flat.mesh.triangles().len(),
                    of: &|i| flat.mesh.triangle(i).to_vec(),
                },
                bounds: structure.bounds(),
            };
            output.write(film::draw(&plan, &story).as_bytes())?;
        }
        if args.json {
            return channel.say(serde_json::to_string_pretty(&report)?);
        }
        let mut text = text::tell(&report);
        if let Some(Destination::File(path)) = &output {
            text += &format!("\nwrote      {}", path.display());
        }
        channel.say(text)
    })
}

/// The ray that is asked for.
fn ray(args: &ExplainArgs, file: &SceneFile) -> Outcome<Ray> {
    if let Some(spelled) = &args.ray {
        return Ok(Ray::new(spelled.origin, spelled.direction));
    }
    let size = args.size.0;
    let Some(pixel) = args.pixel.map(|pixel| pixel.0) else {
        return Err(Failure::new("neither a pixel nor a ray is given"));
    };
    if pixel[0] >= size[0] || pixel[1] >= size[1] {
        return Err(Failure::new(format!(
            "pixel {},{} lies outside the picture of {}x{}; --size says how large it is",
            pixel[0], pixel[1], size[0], size[1]
        )));
    }
    let (camera, _) = camera::choose(&args.camera, file, size)?;
    Ok(pixel_ray(&camera, size, pixel))
}

fn same(a: Option<Hit>, b: Option<Hit>) -> bool {
    let bits = |hit: Hit| {
        let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
        [t, u, v, hit.primitive, hit.instance]
    };
    a.map(bits) == b.map(bits)
}

impl Found {
    fn of(hit: Hit, ray: &Ray, flat: &FlatScene, file: &SceneFile) -> Self {
        let located = flat.locate(hit.primitive);
        Self {
            t: hit.t,
            u: hit.u,
            v: hit.v,
            primitive: hit.primitive,
            point: ray.at(hit.t).to_array(),
            mesh: file.scene.meshes[located.mesh as usize].name.clone(),
            triangle: located.triangle,
            placement: located.instance,
        }
    }
}
