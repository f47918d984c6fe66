//! `boxwood render`: a picture of a scene.

use crate::args::RenderArgs;
use crate::cache::{Cache, CacheUse};
use crate::camera;
use crate::failure::{Failure, Outcome};
use crate::output::Destination;
use crate::progress::Progress;
use crate::scene_file;
use crate::terminal::{self, counted, seconds};
use boxwood_render::{Film, Options, Pixel, PngOptions, RenderError, Renderer, Setup, Shelf};
use boxwood_scene::Image;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Pictures whose making takes more memory are announced.
const MUCH: u64 = 4 << 30;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Png,
    Exr,
}

/// What is said at the end.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    output: String,
    width: u32,
    height: u32,
    spp: u32,
    /// How many times more light than 1 the key light and sky of a scene without lights were given.
    brightened: f32,
    depth: u32,
    view: &'static str,
    /// `null` for one that was found by itself or described on the command line.
    camera: Option<String>,
    triangles: u64,
    structure: String,
    /// Of all structures and instances, without meshes.
    structure_bytes: u64,
    /// `null` without `--cache`.
    cache: Option<CacheUse>,
    threads: usize,
    load_seconds: f64,
    /// Triangles laid out, structure built, images decoded.
    build_seconds: f64,
    render_seconds: f64,
    write_seconds: f64,
    /// Of the file.
    bytes: u64,
    warnings: Vec<String>,
}

pub fn run(args: &RenderArgs) -> Outcome {
    let output = match &args.output {
        Some(path) => path.clone(),
        None => default_output(&args.scene)?,
    };
    let destination = Destination::new(&output);
    let encoding = encoding(&destination, args)?;
    let inputs = [Some(args.scene.as_path()), args.environment.as_deref()];
    destination.check(inputs.into_iter().flatten())?;
    let environment = args.environment.as_deref().map(environment).transpose()?;
    args.tracing
        .threads
        .in_pool(|threads| picture(args, &destination, encoding, environment, threads))
}

fn picture(
    args: &RenderArgs,
    destination: &Destination,
    encoding: Encoding,
    environment: Option<Image>,
    threads: usize,
) -> Outcome {
    let file = scene_file::open(&args.scene)?;
    // Before the work of building: a wrong camera ends here.
    let (camera, camera_name) = camera::choose(&args.camera, &file, args.size.0)?;
    let mut warnings = file.scene.warnings.clone();
    if file.scene.triangle_count() == 0 {
        warnings.push(format!(
            "{}: has no triangles, so the picture shows only the surroundings",
            file.name
        ));
    }

    let cache = Cache::open(&args.tracing.cache, args.tracing.accel)?;
    let setup = Setup {
        structure: args.tracing.accel,
        environment,
        flatten: args.flatten,
        shelf: cache.clone().map(|cache| cache as Arc<dyn Shelf>),
    };
    let start = Instant::now();
    let renderer = {
        let _progress = Progress::spinner(format!("Building {}", args.tracing.accel));
        Renderer::new(&file.scene, &setup).map_err(|error| match error {
            RenderError::Mesh(_) | RenderError::Instances(_) => {
                Failure::new(format!("{}: {error}", file.name))
            }
            _ => Failure::from(error),
        })?
    };
    let build_seconds = start.elapsed().as_secs_f64();
    warnings.extend_from_slice(renderer.warnings());
    terminal::warnings(&file.name, &warnings);

    let [width, height] = args.size.0;
    // Finished tiles and the film they are put together to.
    let memory = 2 * u64::from(width) * u64::from(height) * size_of::<Pixel>() as u64;
    if memory > MUCH {
        terminal::note(format_args!(
            "a picture of {width}x{height} pixels takes about {} of memory",
            terminal::bytes(memory)
        ));
    }
    let options = Options {
        size: args.size.0,
        spp: args.spp,
        depth: args.depth,
        view: args.view,
        ..Options::default()
    };
    options.check()?;
    let start = Instant::now();
    let film = {
        let progress = Progress::bar("Rendering");
        renderer.render(&camera, &options, &|done, of| progress.at(done, of))
    };
    let render_seconds = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let bytes = encode(&film, encoding, args)?;
    destination.write(&bytes)?;
    let report = Report {
        scene: &file.name,
        output: match destination {
            Destination::Stdout => "-".to_string(),
            Destination::File(path) => path.display().to_string(),
        },
        width,
        height,
        spp: args.spp,
        depth: args.depth,
        brightened: film.brightened(),
        view: args.view.name(),
        camera: camera_name,
        triangles: file.scene.triangle_count(),
        structure: args.tracing.accel.to_string(),
        structure_bytes: renderer.layout().bytes() as u64,
        cache: Cache::use_of(cache.as_deref()),
        threads,
        load_seconds: file.seconds,
        build_seconds,
        render_seconds,
        write_seconds: start.elapsed().as_secs_f64(),
        bytes: bytes.len() as u64,
        warnings,
    };
    let channel = destination.report();
    if args.json {
        channel.say(serde_json::to_string_pretty(&report)?)
    } else {
        channel.say(report.table())
    }
}

impl Report<'_> {
    fn table(&self) -> String {
        let place = if self.output == "-" {
            "standard output"
        } else {
            &self.output
        };
        let camera = self
            .camera
            .as_ref()
            .map_or(String::new(), |name| format!(", camera {name}"));
        let help = if self.brightened > 1.0 {
            format!(", brightened {:.1} times", self.brightened)
        } else {
            String::new()
        };
        let (built, from) = CacheUse::said(self.cache.as_ref());
        format!(
            "scene   {}: {}{camera}\n\
             loaded  in {}, {built} {}{from} in {} ({})\n\
             traced  in {} with {}{help}\n\
             wrote   {place} ({}x{}, {}, {}, {})",
            self.scene,
            counted(self.triangles, "triangle"),
            seconds(self.load_seconds),
            self.structure,
            seconds(self.build_seconds),
            terminal::bytes(self.structure_bytes),
            seconds(self.render_seconds),
            counted(self.threads as u64, "thread"),
            self.width,
            self.height,
            self.view,
            counted(u64::from(self.spp), "sample"),
            terminal::bytes(self.bytes),
        )
    }
}

/// A PNG in the current folder, named after the scene; `city:20,seed=1` becomes `city-20-seed-1.png`.
fn default_output(scene: &Path) -> Outcome<PathBuf> {
    let stem = scene
        .file_stem()
        .ok_or_else(|| Failure::file(scene, "is not a file"))?;
    let mut name = match stem.to_str() {
        Some(text) => text.replace([':', ',', '='], "-").into(),
        None => stem.to_os_string(),
    };
    name.push(".png");
    Ok(name.into())
}

/// What the output's name asks for.
fn encoding(destination: &Destination, args: &RenderArgs) -> Outcome<Encoding> {
    let Destination::File(path) = destination else {
        return Ok(Encoding::Png);
    };
    let extension = path
        .extension()
        .and_then(|e| e.to_str())
        .map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("png") => Ok(Encoding::Png),
        Some("exr") if args.exposure != 0.0 => Err(Failure::file(
            path,
            "an EXR keeps light as it is; --exposure is for PNG",
        )),
        Some("exr") if args.transparent => Err(Failure::file(
            path,
            "an EXR always has an alpha channel; --transparent is for PNG",
        )),
        Some("exr") => Ok(Encoding::Exr),
        _ => Err(Failure::file(
            path,
            "a picture's name must end in .png or .exr",
        )),
    }
}

fn encode(film: &Film, encoding: Encoding, args: &RenderArgs) -> Outcome<Vec<u8>> {
    let _progress = Progress::spinner("Encoding");
    Ok(match encoding {
        Encoding::Exr => film.exr()?,
        Encoding::Png => film.png(&PngOptions {
            view: args.view,
            exposure: args.exposure,
            transparent: args.transparent,
        })?,
    })
}

/// Reads an environment image and its header; the renderer decodes its pixels.
fn environment(path: &Path) -> Outcome<Image> {
    let bytes =
        fs::read(path).map_err(|e| Failure::file(path, format_args!("cannot be read: {e}")))?;
    Ok(Image::from_bytes(path.display().to_string(), bytes)?)
}
