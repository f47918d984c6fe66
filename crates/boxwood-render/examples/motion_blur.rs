//! What does a camera see while its shutter is open? A teapot turns and falls onto a table that rests.
//!
//! `cargo run --release -p boxwood-render --example motion_blur -- [--size N] [--samples N] [--turn DEGREES] [--keys N] [--out FILE]`
//!
//! All samples of a pixel are cast at times of their own, one in each of as many equal parts of the shutter's time, in an order that is shuffled
//! from pixel to pixel; shadows at the time of the ray that met what is lit.

use boxwood::{Hit, MotionBvh, MovingMesh, Ray, Surfaces, Timed, TriangleMesh, Vec3, WideSah};
use boxwood_scene::builtin;
use std::fs::File;
use std::io::BufWriter;
use std::process::ExitCode;
use std::time::Instant;

const HELP: &str = "\
Renders a teapot that turns and falls while the shutter is open.

  --size N        pixels along each side (512)
  --samples N     rays a pixel, each at a time of its own (64)
  --turn DEGREES  how far it turns (60)
  --keys N        at how many moments its vertices are given, 2 or more (5)
  --out FILE      the picture (motion_blur.png)
  --help          this text";

struct Wishes {
    size: usize,
    samples: usize,
    turn: f32,
    keys: usize,
    out: String,
}

/// `None` when help was asked for.
fn read(mut arguments: impl Iterator<Item = String>) -> Result<Option<Wishes>, String> {
    let mut wishes = Wishes {
        size: 512,
        samples: 64,
        turn: 60.0,
        keys: 5,
        out: "motion_blur.png".into(),
    };
    while let Some(name) = arguments.next() {
        if name == "--help" || name == "-h" {
            return Ok(None);
        }
        let value = arguments.next().ok_or(format!("`{name}` wants a value"))?;
        let number = |least: usize, most: usize| match value.parse() {
            Ok(number) if (least..=most).contains(&number) => Ok(number),
            _ => Err(format!(
                "`{name}` wants a number from {least} to {most}, not `{value}`"
            )),
        };
        match &*name {
            "--size" => wishes.size = number(1, 8192)?,
            "--samples" => wishes.samples = number(1, 65536)?,
            "--turn" => wishes.turn = number(0, 3600)? as f32,
            "--keys" => wishes.keys = number(2, 1000)?,
            "--out" => wishes.out = value,
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
    match expose(&wishes) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn expose(wishes: &Wishes) -> Result<(), Box<dyn std::error::Error>> {
    let at = Instant::now();
    let scene = Scene::new(wishes.turn.to_radians(), wishes.keys)?;
    println!(
        "{} triangles at {} keys in {:.0} ms",
        scene.mesh().triangles().len(),
        scene.mesh().keys(),
        at.elapsed().as_secs_f64() * 1.0e3
    );
    let at = Instant::now();
    let (size, samples) = (wishes.size, wishes.samples);
    let mut bytes = Vec::with_capacity(3 * size * size);
    for y in 0..size {
        for colour in row(&scene, size, samples, y) {
            let encoded = colour.to_array().map(|c| {
                let c = libm::powf(c.clamp(0.0, 1.0), 1.0 / 2.2);
                (c * 255.0 + 0.5) as u8
            });
            bytes.extend(encoded);
        }
    }
    println!("{:.2} s for all rays", at.elapsed().as_secs_f64());
    let file = BufWriter::new(File::create(&wishes.out)?);
    let mut encoder = png::Encoder::new(file, size as u32, size as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(())
}

/// The teapot and its table: one mesh, of which a part moves.
struct Scene {
    bvh: MotionBvh<MovingMesh, 8>,
    /// So many triangles are the teapot's.
    teapot: u32,
}

impl Scene {
    fn new(turn: f32, keys: usize) -> Result<Self, Box<dyn std::error::Error>> {
        let teapot = builtin::teapot(24);
        let table = [
            [-9.0, 0.0, -9.0],
            [9.0, 0.0, -9.0],
            [9.0, 0.0, 9.0],
            [-9.0, 0.0, 9.0],
        ];
        let key = |key: usize| -> Vec<Vec3> {
            let time = key as f32 / (keys - 1) as f32;
            let (s, c) = (libm::sinf(turn * time), libm::cosf(turn * time));
            let fall = 0.8 * (1.0 - time) * (1.0 + time);
            let place = |&[x, y, z]: &[f32; 3]| Vec3::new(c * x + s * z, y + fall, c * z - s * x);
            let placed = teapot.positions.iter().map(place);
            placed.chain(table.map(Vec3::from)).collect()
        };
        let first = teapot.positions.len() as u32;
        let floor = [[0, 2, 1], [0, 3, 2]].map(|t: [u32; 3]| t.map(|v| v + first));
        let triangles = teapot.triangles.iter().copied().chain(floor);
        let mesh = MovingMesh::new(TriangleMesh::new(key(0), triangles)?, (1..keys).map(key))?;
        Ok(Self {
            teapot: teapot.triangles.len() as u32,
            bvh: WideSah::default().build_moving(mesh),
        })
    }

    fn mesh(&self) -> &MovingMesh {
        self.bvh.mesh()
    }

    /// The colour of what a ray met at a time, without light.
    fn colour(&self, hit: &Hit, at: Vec3) -> Vec3 {
        let odd = (libm::floorf(at.x) + libm::floorf(at.z)) % 2.0 != 0.0;
        match (hit.primitive < self.teapot, odd) {
            (true, _) => Vec3::new(0.75, 0.32, 0.16),
            (false, true) => Vec3::splat(0.55),
            (false, false) => Vec3::splat(0.3),
        }
    }
}

/// One row of pixels.
fn row(scene: &Scene, size: usize, samples: usize, y: usize) -> Vec<Vec3> {
    let pixels = (0..size).flat_map(|x| (0..samples).map(move |i| (x, i)));
    let asked = pixels.map(|(x, i)| sample(size, samples, [x, y], i));
    let (rays, times): (Vec<Ray>, Vec<f32>) = asked.unzip();
    let mut hits = vec![None; rays.len()];
    scene.bvh.closest_hits_at(&rays, &times, &mut hits);

    let lamp = Vec3::new(4.0, 9.0, 5.0);
    // A ray without a direction meets nothing.
    let nothing = Ray::new([0.0; 3], [0.0; 3]);
    let met = |((ray, &time), hit): ((&Ray, &f32), &Option<Hit>)| {
        let surface = scene.mesh().at(time).surface(ray, &(*hit)?);
        let from = surface.offset_origin(lamp - surface.position);
        Some((surface, Ray::between(from, lamp)))
    };
    let met: Vec<_> = rays.iter().zip(&times).zip(&hits).map(met).collect();
    let shadows = met
        .iter()
        .map(|met| met.map_or(nothing, |(_, shadow)| shadow));
    let shadows: Vec<Ray> = shadows.collect();
    let mut dark = vec![false; rays.len()];
    scene.bvh.occluded_each_at(&shadows, &times, &mut dark);

    let shade = |i: usize| {
        let (Some(hit), Some((surface, shadow))) = (&hits[i], &met[i]) else {
            return Vec3::new(0.55, 0.65, 0.8);
        };
        let normal = surface.facing();
        let light = normal.dot(shadow.direction.normalized()).max(0.0);
        let lit = if dark[i] { 0.0 } else { 0.85 * light };
        scene.colour(hit, surface.position) * (0.2 + 0.12 * normal.y + lit)
    };
    let pixel = |x: usize| {
        let sum = (x * samples..(x + 1) * samples).fold(Vec3::ZERO, |sum, i| sum + shade(i));
        sum * (1.0 / samples as f32)
    };
    (0..size).map(pixel).collect()
}

/// A ray through a pixel, and its time.
fn sample(size: usize, samples: usize, [x, y]: [usize; 2], i: usize) -> (Ray, f32) {
    let pixel = hash((y * size + x) as u32);
    let unit = |purpose: u32| {
        let bits = hash(pixel ^ hash(i as u32 ^ purpose << 28));
        (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
    };
    // Each part of the time once, wherever the order begins.
    let part = (i + pixel as usize % samples) % samples;
    let time = (part as f32 + unit(1)) / samples as f32;
    let (eye, towards) = (Vec3::new(0.0, 4.2, 9.5), Vec3::new(0.0, 1.5, 0.0));
    let forward = (towards - eye).normalized();
    let right = forward.cross(Vec3::new(0.0, 1.0, 0.0)).normalized();
    let up = right.cross(forward);
    let at = |k: usize, inside: f32| (2.0 * (k as f32 + inside) / size as f32 - 1.0) * 0.45;
    let direction = forward + right * at(x, unit(2)) - up * at(y, unit(3));
    (Ray::new(eye, direction), time)
}

/// Every bit of the input stirs every bit of the output (Wellons' `lowbias32`).
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}
