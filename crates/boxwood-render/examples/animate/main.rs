//! What does a scene cost that moves? A column twists and untwists while balls circle around it, come and go.
//!
//! `cargo run --release -p boxwood-render --example animate -- [--frames N] [--triangles N] [--objects N] [--size W] [--save FOLDER]`
//!
//! Prints a line for each frame: what was done to the column's tree and to that of the objects, how long it took, how long all rays took,
//! and what a ray is expected to pay. `--save` writes the frames as PNG.

mod picture;
mod stage;

use boxwood::{Committed, Decision, Updated};
use picture::Picture;
use stage::Stage;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

const HELP: &str = "\
Animates a twisting column among moving balls, and prints what each frame costs.

  --frames N      frames (24)
  --triangles N   triangles of the column (100000)
  --objects N     balls (64)
  --size N        pixels along each side (256)
  --save FOLDER   write the frames there as PNG
  --help          this text";

struct Wishes {
    frames: usize,
    triangles: usize,
    objects: usize,
    size: usize,
    save: Option<PathBuf>,
}

/// `None` when help was asked for.
fn read(mut arguments: impl Iterator<Item = String>) -> Result<Option<Wishes>, String> {
    let mut wishes = Wishes {
        frames: 24,
        triangles: 100_000,
        objects: 64,
        size: 256,
        save: None,
    };
    while let Some(name) = arguments.next() {
        if name == "--help" || name == "-h" {
            return Ok(None);
        }
        let value = arguments.next().ok_or(format!("`{name}` wants a value"))?;
        let number = |most: usize| match value.parse() {
            Ok(number) if (1..=most).contains(&number) => Ok(number),
            _ => Err(format!(
                "`{name}` wants a number from 1 to {most}, not `{value}`"
            )),
        };
        match &*name {
            "--frames" => wishes.frames = number(100_000)?,
            "--triangles" => wishes.triangles = number(100_000_000)?,
            "--objects" => wishes.objects = number(10_000_000)?,
            "--size" => wishes.size = number(8192)?,
            "--save" => wishes.save = Some(value.into()),
            _ => return Err(format!("there is no `{name}`; try --help")),
        }
    }
    Ok(Some(wishes))
}

fn main() -> ExitCode {
    let wishes = match read(std::env::args().skip(1)) {
        Ok(Some(wishes)) => wishes,
        Ok(None) => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        Err(said) => {
            eprintln!("{said}");
            return ExitCode::from(2);
        }
    };
    match play(&wishes) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn play(wishes: &Wishes) -> Result<(), Box<dyn std::error::Error>> {
    if let Some(folder) = &wishes.save {
        std::fs::create_dir_all(folder)?;
    }
    let picture = Picture::new(wishes.size);
    let at = Instant::now();
    // Two rays a pixel: one looks, one asks for the lamp.
    let mut stage = Stage::new(
        wishes.triangles,
        wishes.objects,
        2.0 * picture.pixels() as f64,
    )?;
    println!(
        "{} triangles and {} objects, put up in {:.1} ms",
        stage.column().bvh().primitives().triangles().len(),
        stage.objects().len(),
        milliseconds(at)
    );
    println!(
        "frame  column                     ms  objects        ms  trace ms  cost (was built at)"
    );
    let mut sums = [0.0; 3];
    for frame in 1..=wishes.frames {
        // One way and back in as many frames as there are.
        let moment = frame as f32 / wishes.frames as f32;
        stage.bend(moment);
        let at = Instant::now();
        let updated = stage.update()?;
        let followed = milliseconds(at);
        stage.rearrange(frame, moment)?;
        let at = Instant::now();
        let committed = stage.commit();
        let objects = milliseconds(at);
        let at = Instant::now();
        let pixels = picture.trace(&stage);
        let traced = milliseconds(at);
        println!(
            "{frame:5}  {:22} {followed:6.2}  {:10} {objects:6.2}  {traced:8.2}  {:.1} ({:.1})",
            column(&updated),
            top(&committed),
            updated.cost,
            updated.built,
        );
        for (sum, part) in sums.iter_mut().zip([followed, objects, traced]) {
            *sum += part / wishes.frames as f64;
        }
        if let Some(folder) = &wishes.save {
            picture.save(&pixels, &folder.join(format!("{frame:04}.png")))?;
        }
    }
    let [column, objects, trace] = sums;
    println!(
        "on average {column:.2} ms for the column, {objects:.2} ms for objects, {trace:.2} ms for rays: {:.1} frames a second",
        1.0e3 / (column + objects + trace)
    );
    Ok(())
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1.0e3
}

fn column(updated: &Updated) -> String {
    match updated.decision {
        Decision::Refit => "fitted".into(),
        Decision::Parts { parts, primitives } => format!("{parts} parts, {primitives}"),
        Decision::Rebuild => "built anew".into(),
    }
}

fn top(committed: &Committed) -> &'static str {
    match committed {
        Committed::Nothing => "nothing",
        Committed::Renewed => "built anew",
        Committed::Moved(updated) => match updated.decision {
            Decision::Refit => "fitted",
            Decision::Parts { .. } => "parts",
            Decision::Rebuild => "rebuilt",
        },
    }
}
