//! The renderer: a scene made ready once, and pictures of it.

use crate::camera::Lens;
use crate::colour::luminance;
use crate::film::{Film, Pixel};
use crate::layout::Layout;
use crate::sample::{Samples, tent};
use crate::shade::light::Lamp;
use crate::shade::whitted::{Branch, Seen, Sent, Tracer, WAVE};
use crate::world::World;
use crate::{RenderError, Shelf, View};
use boxwood::inspect::Statistics;
use boxwood::{Ray, StructureKind, TraversalStats, Vec3};
use boxwood_scene::{Camera, Image, Scene};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How a scene is made ready.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Over which structure rays are traced. The picture does not depend on it, only its cost.
    pub structure: StructureKind,
    /// A latitude-longitude image around the scene, in place of the scene's own: row 0 is straight up, the centre column
    /// lies towards −z of a y-up world.
    pub environment: Option<Image>,
    /// Whether every placement is laid out in the world. By default meshes that are placed more than once are instances, which
    /// takes far less memory; the rays that they meet are then computed in each mesh's own space, so that the last bits of
    /// pictures differ.
    pub flatten: bool,
    /// Where wide trees are kept from one run to the next.
    pub shelf: Option<Arc<dyn Shelf>>,
}

/// What a picture should be.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel; 0 counts as 1. Powers of two are spread best.
    pub spp: u32,
    /// How many mirrored or refracted rays may follow each other; 0 shows direct light only.
    pub depth: u32,
    /// What the picture shows.
    pub view: View,
    /// Rays per pixel that each lamp's soft shadow and the ambient occlusion get at least, spread over the samples; 0
    /// makes shadows hard and leaves the occlusion out.
    pub soft_rays: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            size: [1280, 720],
            spp: 16,
            depth: 8,
            view: View::Shaded,
            soft_rays: 16,
        }
    }
}

impl Options {
    /// Whether [`Renderer::render`] will do this as it stands.
    ///
    /// # Errors
    /// [`RenderError::Size`] when there are no pixels, or more than memory should be asked for.
    pub fn check(&self) -> Result<(), RenderError> {
        let [width, height] = self.size;
        if self.size == self.sound_size() {
            Ok(())
        } else {
            Err(RenderError::Size { width, height })
        }
    }

    fn sound_size(&self) -> [u32; 2] {
        let [width, height] = self.size.map(|side| side.clamp(1, MOST_SIDE));
        [width, height.min(MOST_PIXELS / width)]
    }

    /// No deeper than the machine's stack allows.
    fn sound_depth(&self) -> u32 {
        self.depth.min(MOST_DEPTH)
    }
}

const MOST_SIDE: u32 = 1 << 15;
const MOST_PIXELS: u32 = 1 << 28;
const MOST_DEPTH: u32 = 64;
/// Pixels along the side of a tile.
const TILE: u32 = 16;

/// A scene ready to be rendered.
pub struct Renderer {
    world: World,
    warnings: Vec<String>,
}

impl Renderer {
    /// Lays the scene out, builds the structure and decodes the images, in the caller's rayon pool.
    ///
    /// # Errors
    /// When the triangles cannot be laid out, or `setup.environment` cannot be decoded.
    pub fn new(scene: &Scene, setup: &Setup) -> Result<Self, RenderError> {
        let mut warnings = Vec::new();
        let world = World::new(scene, setup, &mut warnings)?;
        Ok(Self { world, warnings })
    }

    /// One clear sentence for each thing that is shown otherwise than the scene says, such as an image that could not be
    /// decoded.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What the structure is made of that rays ask; where there are instances, the one over them.
    pub fn statistics(&self) -> Statistics {
        self.world.layout.structure().statistics()
    }

    /// The scene's triangles under their structures.
    pub fn layout(&self) -> &Layout {
        &self.world.layout
    }

    /// Renders a picture in the caller's rayon pool; the film has the same bits for any number of threads. `progress` is
    /// told after each tile how many are done, of how many. Sizes that [`Options::check`] refuses are cut to what it
    /// allows.
    pub fn render(
        &self,
        camera: &Camera,
        options: &Options,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Film {
        let size = options.sound_size();
        let lens = Lens::new(camera, size);
        let mut shot = Shot {
            world: &self.world,
            tracer: self.tracer(&lens, options),
            lens,
            spp: options.spp.max(1),
            view: options.view,
        };
        let mut brightened = 1.0;
        if self.world.key_light.is_some() && options.view == View::Shaded {
            brightened = shot.brightening(size);
            shot.tracer.exposure *= brightened;
        }
        let [columns, rows] = size.map(|n| n.div_ceil(TILE));
        let count = (columns * rows) as usize;
        let done = AtomicUsize::new(0);
        let tiles: Vec<Vec<Pixel>> = (0..columns * rows)
            .into_par_iter()
            .map(|tile| {
                let places = within(tile % columns * TILE, tile / columns * TILE, size);
                let pixels = shot.pixels(&places.collect::<Vec<_>>());
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, count);
                pixels
            })
            .collect();
        let mut film = Film {
            size,
            view: options.view,
            brightened,
            pixels: vec![NOTHING; size[0] as usize * size[1] as usize],
        };
        for (tile, pixels) in (0..).zip(tiles) {
            let places = within(tile % columns * TILE, tile / columns * TILE, size);
            for ([x, y], pixel) in places.zip(pixels) {
                film.pixels[y as usize * size[0] as usize + x as usize] = pixel;
            }
        }
        film
    }

    fn tracer(&self, lens: &Lens, options: &Options) -> Tracer<'_> {
        let key = self.world.key_light.map(|irradiance| {
            Lamp::sun(
                lens.over_the_shoulder(self.world.up, &self.world.layout.structure().bounds()),
                irradiance,
                0.05,
            )
        });
        Tracer {
            world: &self.world,
            key,
            exposure: self.world.exposure,
            depth: options.sound_depth(),
            soft: options.soft_rays.min(4096).div_ceil(options.spp.max(1)),
            visible_lamps: self
                .world
                .lamps
                .iter()
                .any(|lamp| matches!(lamp, Lamp::Sphere { .. } | Lamp::Rectangle { .. })),
        }
    }
}

/// The pixels of the tile whose upper left corner is given, along Morton's curve: what is near in the list is near in the
/// picture, so that rays of neighbours travel together.
fn within(left: u32, top: u32, [width, height]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    (0..TILE * TILE)
        .map(move |i| [left + every_second_bit(i), top + every_second_bit(i >> 1)])
        .filter(move |&[x, y]| x < width && y < height)
}

/// Bits 0, 2, 4 and 6, closed up.
fn every_second_bit(i: u32) -> u32 {
    i & 1 | i >> 1 & 2 | i >> 2 & 4 | i >> 3 & 8
}

const NOTHING: Pixel = Pixel {
    radiance: [0.0; 3],
    background: [0.0; 3],
    coverage: 0.0,
    unlit: 0.0,
    albedo: [0.0; 3],
    normal: [0.0; 3],
    depth: f32::INFINITY,
    primitive: u32::MAX,
    material: u32::MAX,
    nodes: 0,
    primitives: 0,
};

/// One picture on its way.
struct Shot<'a> {
    world: &'a World,
    tracer: Tracer<'a>,
    lens: Lens,
    spp: u32,
    view: View,
}

/// The brightness that a picture without lights of its own should have at least, and how far it is helped to it.
const DIM: f32 = 0.2;
const MOST_HELP: f32 = 4.0;
/// Rays along the sides of the grid that brightness is measured with.
const METER: [u32; 2] = [32, 18];

impl Shot<'_> {
    /// How much brighter a picture must be made that the sky and the key light leave dark, as they do indoors: a grid of
    /// rays measures the mean brightness of surfaces before the first tile. At least 1.
    fn brightening(&self, [width, height]: [u32; 2]) -> f32 {
        let mut bright = 0.0;
        let mut count = 0.0;
        let rays = (0..METER[0] * METER[1]).map(|i| {
            let [x, y] = [i % METER[0], i / METER[0]];
            let place = |n: u32, of: u32, side: u32| (n as f32 + 0.5) / of as f32 * side as f32;
            let ray = self
                .lens
                .ray(place(x, METER[0], width), place(y, METER[1], height));
            self.sent(ray, Samples::new([x, y], 0))
        });
        for seen in self.tracer.trace(&rays.collect::<Vec<_>>()) {
            let light = luminance(seen.radiance - seen.background);
            if light.is_finite() && seen.unlit == 0.0 {
                bright += light.min(1.0);
                count += seen.coverage;
            }
        }
        if bright > 0.0 {
            (DIM * count / bright).clamp(1.0, MOST_HELP)
        } else {
            1.0
        }
    }

    /// The rays of all samples of the pixels travel together, as many as a wave may hold.
    fn pixels(&self, places: &[[u32; 2]]) -> Vec<Pixel> {
        let mut pixels: Vec<Pixel> = places.iter().map(|&at| self.middle(at)).collect();
        let follow = match self.view {
            View::Shaded => Tracer::trace,
            View::Albedo | View::Normals => Tracer::look,
            _ => return pixels,
        };
        let mut sums = vec![Seen::default(); places.len()];
        let spp = u64::from(self.spp);
        // Sample by sample of the first pixel, then of the next one.
        let place = |n: u64| (n / spp) as usize;
        let count = places.len() as u64 * spp;
        for start in (0..count).step_by(WAVE) {
            let wave = start..count.min(start + WAVE as u64);
            let sent = |n: u64| self.sample(places[place(n)], (n % spp) as u32);
            let sent: Vec<Sent> = wave.clone().map(sent).collect();
            for (n, seen) in wave.zip(follow(&self.tracer, &sent)) {
                sums[place(n)].add(&seen);
            }
        }
        let share = 1.0 / self.spp as f32;
        let light = self.tracer.exposure * share;
        for (pixel, sum) in pixels.iter_mut().zip(sums) {
            pixel.radiance = (sum.radiance * light).to_array();
            pixel.background = (sum.background * light).to_array();
            pixel.albedo = (sum.albedo * share).to_array();
            pixel.normal = (sum.normal * share).to_array();
            pixel.coverage = sum.coverage * share;
            pixel.unlit = sum.unlit * share;
        }
        pixels
    }

    /// The ray of one sample of a pixel.
    fn sample(&self, at: [u32; 2], index: u32) -> Sent {
        let samples = Samples::new(at, index);
        let [u, v] = samples.pair(0, 1, 0);
        let x = at[0] as f32 + 0.5 + tent(u);
        let y = at[1] as f32 + 0.5 + tent(v);
        self.sent(self.lens.ray(x, y), samples)
    }

    fn sent(&self, ray: Ray, samples: Samples) -> Sent {
        Sent {
            ray,
            branch: Branch::root(self.lens.footprint()),
            samples,
        }
    }

    /// What the ray through the middle of the pixel meets, and what that costs.
    fn middle(&self, [x, y]: [u32; 2]) -> Pixel {
        let ray = self.lens.ray(x as f32 + 0.5, y as f32 + 0.5);
        let mut steps = TraversalStats::default();
        let nearest = self
            .world
            .layout
            .structure()
            .closest_hit_counted(&ray, &mut steps);
        let hit = self.world.closest(&ray, nearest);
        let few = |n: u64| u32::try_from(n).unwrap_or(u32::MAX);
        let mut pixel = Pixel {
            nodes: few(steps.nodes + steps.leaves),
            primitives: few(steps.primitives),
            ..NOTHING
        };
        if let Some(hit) = hit {
            let located = self.world.layout.locate(&hit);
            pixel.depth = self.lens.depth(ray.at(hit.t));
            pixel.primitive = located.primitive;
            pixel.material = self.world.meshes[located.mesh as usize].material as u32;
            pixel.coverage = 1.0;
        }
        pixel
    }
}

impl Seen {
    /// Adds another sample; one that is not finite counts as black.
    fn add(&mut self, other: &Self) {
        let sound = |v: Vec3| if v.is_finite() { v } else { Vec3::ZERO };
        self.radiance += sound(other.radiance);
        self.background += sound(other.background);
        self.albedo += sound(other.albedo);
        self.normal += sound(other.normal);
        self.coverage += other.coverage;
        self.unlit += other.unlit;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_walked_in_blocks_and_cover_every_pixel_once() {
        let size = [TILE + 5, TILE + 3];
        let mut times = vec![0; (size[0] * size[1]) as usize];
        for corner in [[0, 0], [TILE, 0], [0, TILE], [TILE, TILE]] {
            for [x, y] in within(corner[0], corner[1], size) {
                times[(y * size[0] + x) as usize] += 1;
            }
        }
        assert!(times.iter().all(|&n| n == 1));
        let tile: Vec<_> = within(0, 0, size).collect();
        for block in tile.chunks(64) {
            for axis in 0..2 {
                let places = || block.iter().map(|at| at[axis]);
                let (first, last) = (places().min(), places().max());
                assert_eq!(last.zip(first).map(|(last, first)| last - first), Some(7));
            }
        }
    }
}
