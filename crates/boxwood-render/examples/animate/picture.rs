//! Rays from an eye, and one from each point they meet to the lamp.

use super::stage::Stage;
use boxwood::{Hit, Intersect, Ray, Surface, Surfaces, Vec3};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Pixels are traced in tiles of so many along each side: their rays run together.
const TILE: usize = 8;

/// A square picture.
pub struct Picture {
    size: usize,
    /// Pixels tile by tile.
    order: Vec<[usize; 2]>,
}

impl Picture {
    /// Of so many pixels along each side.
    pub fn new(size: usize) -> Self {
        let tiles = size.div_ceil(TILE);
        let tile = |t: usize| [t % tiles * TILE, t / tiles * TILE];
        let order = (0..tiles * tiles)
            .flat_map(|t| (0..TILE * TILE).map(move |i| (tile(t), i)))
            .map(|([x, y], i)| [x + i % TILE, y + i / TILE])
            .filter(|&[x, y]| x < size && y < size)
            .collect();
        Self { size, order }
    }

    /// How many pixels.
    pub fn pixels(&self) -> usize {
        self.order.len()
    }

    /// One colour for each pixel, in the order of tiles.
    pub fn trace(&self, stage: &Stage) -> Vec<Vec3> {
        let mut rays: Vec<Ray> = self.order.iter().map(|&p| self.ray(p)).collect();
        let column = stage.column().bvh();
        let mut near = vec![None; rays.len()];
        column.closest_hits(&rays, &mut near);
        // Objects are only asked about what lies before the column.
        for (ray, hit) in rays.iter_mut().zip(&near) {
            ray.t_max = hit.map_or(f32::INFINITY, |hit: Hit| hit.t);
        }
        let mut nearer = vec![None; rays.len()];
        stage.objects().closest_hits(&rays, &mut nearer);

        let seen: Vec<Option<(Surface, Vec3)>> = (rays.iter().zip(near.iter().zip(&nearer)))
            .map(|(ray, hits)| see(stage, ray, hits))
            .collect();
        let lamp = Vec3::new(3.0, 6.0, 4.0);
        let nothing = Ray::new([0.0; 3], [0.0; 3]);
        let to_lamp = |seen: &Option<(Surface, Vec3)>| {
            seen.map_or(nothing, |(surface, _)| {
                let from = surface.offset_origin(lamp - surface.position);
                Ray::new(from, lamp - from).until(1.0)
            })
        };
        let shadows: Vec<Ray> = seen.iter().map(to_lamp).collect();
        let (mut dark, mut darker) = (vec![false; rays.len()], vec![false; rays.len()]);
        column.occluded_each(&shadows, &mut dark);
        stage.objects().occluded_each(&shadows, &mut darker);
        (seen.iter().zip(&shadows).zip(dark.iter().zip(&darker)))
            .map(|((seen, shadow), (&a, &b))| shade(seen.as_ref(), shadow, a || b))
            .collect()
    }

    fn ray(&self, [x, y]: [usize; 2]) -> Ray {
        let (eye, towards) = (Vec3::new(0.0, 2.6, 6.2), Vec3::new(0.0, 1.35, 0.0));
        let forward = (towards - eye).normalized();
        let right = forward.cross(Vec3::new(0.0, 1.0, 0.0)).normalized();
        let up = right.cross(forward);
        let at = |i: usize| (2.0 * (i as f32 + 0.5) / self.size as f32 - 1.0) * 0.42;
        Ray::new(eye, forward + right * at(x) - up * at(y))
    }

    /// Writes the picture.
    pub fn save(&self, pixels: &[Vec3], path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let mut bytes = vec![0; 3 * self.size * self.size];
        for (&[x, y], colour) in self.order.iter().zip(pixels) {
            let encoded = colour.to_array().map(|c| {
                let c = libm::powf(c.clamp(0.0, 1.0), 1.0 / 2.2);
                (c * 255.0 + 0.5) as u8
            });
            let at = 3 * (y * self.size + x);
            bytes[at..at + 3].copy_from_slice(&encoded);
        }
        let side = self.size as u32;
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), side, side);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header()?.write_image_data(&bytes)?;
        Ok(())
    }
}

/// What a ray met, if anything, and its colour.
fn see(
    stage: &Stage,
    ray: &Ray,
    (column, object): (&Option<Hit>, &Option<Hit>),
) -> Option<(Surface, Vec3)> {
    if let Some(hit) = object {
        let (surface, floor) = stage.surface(ray, hit);
        let step = |x: f32| libm::floorf(x) as i32;
        let odd = (step(surface.position.x) + step(surface.position.z)) % 2 != 0;
        let colour = match (floor, odd) {
            (true, true) => Vec3::splat(0.5),
            (true, false) => Vec3::splat(0.35),
            (false, _) => {
                let hue = (hit.instance as f32 * 0.618_034).fract();
                Vec3::new(0.9 - 0.6 * hue, 0.35 + 0.4 * hue, 0.25 + 0.6 * hue)
            }
        };
        return Some((surface, colour));
    }
    let hit = (*column)?;
    let surface = stage.column().bvh().primitives().surface(ray, &hit);
    Some((surface, Vec3::new(0.8, 0.72, 0.6)))
}

fn shade(seen: Option<&(Surface, Vec3)>, to_lamp: &Ray, dark: bool) -> Vec3 {
    let Some((surface, colour)) = seen else {
        return Vec3::new(0.55, 0.65, 0.8);
    };
    let normal = surface.facing();
    let light = normal.dot(to_lamp.direction.normalized()).max(0.0);
    let sky = 0.25 + 0.15 * normal.y;
    *colour * (sky + if dark { 0.0 } else { 0.8 * light })
}
