//! The rays: recorded once from a camera, asked of everybody.
//!
//! *How it works.* The renderer's own recorder makes primary rays, shadow rays and random segments. Rays that bounce begin
//! where the camera's rays meet something; where too few do, several leave from each place, so that all kinds have about as
//! many rays. All of it is hashed numbers: the same rays on every machine.

use boxwood::{Hit, Intersect, Ray, Surface, Surfaces, TriangleMesh, Vec3};
use boxwood_render::workload::{RayKind, Recorder, bounce, view};
use boxwood_scene::{Camera, Light, LightKind, Scene};
use rayon::prelude::*;
use std::fmt;
use std::str::FromStr;

/// What rays are cast for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// From the camera through the middles of pixels, in tiles of 8 by 8.
    Tile,
    /// The same rays row by row.
    Scanline,
    /// From what the camera sees to one point.
    ShadowPoint,
    /// From what the camera sees to points of a ball.
    ShadowArea,
    /// From what the camera sees around the normal, a tenth of the scene's diagonal long.
    Ao,
    /// The same directions without end.
    Diffuse1,
    /// The third diffuse bounce.
    Diffuse3,
    /// Segments between random points of the scene's box.
    Random,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Tile,
        Self::Scanline,
        Self::ShadowPoint,
        Self::ShadowArea,
        Self::Ao,
        Self::Diffuse1,
        Self::Diffuse3,
        Self::Random,
    ];

    /// As a user writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tile => "tile",
            Self::Scanline => "scanline",
            Self::ShadowPoint => "shadow-point",
            Self::ShadowArea => "shadow-area",
            Self::Ao => "ao",
            Self::Diffuse1 => "diffuse-1",
            Self::Diffuse3 => "diffuse-3",
            Self::Random => "random",
        }
    }

    /// Whether neighbours go the same way.
    pub fn is_coherent(self) -> bool {
        matches!(
            self,
            Self::Tile | Self::Scanline | Self::ShadowPoint | Self::ShadowArea
        )
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Kind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == text);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("no rays are called `{text}`; there are {names}")
        })
    }
}

/// Width by height of the images.
const ASPECT: f32 = 1.5;
/// The side of a tile, in pixels.
const TILE: u32 = 8;
/// Of ambient occlusion, in diagonals of the scene.
const REACH: f32 = 0.1;
/// The most paths that leave from one place; in an open scene one of fifty has a third bounce.
const PASSES: u32 = 256;

/// Makes the rays of one view.
pub struct Source<'a> {
    mesh: &'a TriangleMesh,
    structure: &'a dyn Intersect,
    camera: &'a Camera,
    up: [f32; 3],
    count: u32,
    size: [u32; 2],
    /// What the camera sees.
    seen: Vec<Surface>,
}

impl<'a> Source<'a> {
    /// About `count` rays of each kind.
    pub fn new(
        mesh: &'a TriangleMesh,
        structure: &'a dyn Intersect,
        camera: &'a Camera,
        up: [f32; 3],
        count: u32,
    ) -> Self {
        let tiles = |pixels: f32| ((pixels / TILE as f32).round() as u32).max(1) * TILE;
        let width = tiles((count as f32 * ASPECT).sqrt());
        let size = [width, tiles(count as f32 / width as f32)];
        let primary = view(camera, size);
        let seen = surfaces(mesh, structure, &primary);
        Self {
            mesh,
            structure,
            camera,
            up,
            count,
            size,
            seen,
        }
    }

    /// The rays of one kind.
    pub fn record(&self, kind: Kind) -> Vec<Ray> {
        let bounds = self.structure.bounds();
        let diagonal = bounds.size().length();
        match kind {
            Kind::Scanline => view(self.camera, self.size),
            Kind::Tile => tiled(&view(self.camera, self.size), self.size[0]),
            Kind::ShadowPoint => self.shadows(|position, _| LightKind::Point {
                position,
                intensity: [1.0; 3],
                range: f32::INFINITY,
            }),
            Kind::ShadowArea => self.shadows(|center, radius| LightKind::Sphere {
                center,
                radius,
                radiance: [1.0; 3],
            }),
            Kind::Ao => {
                let mut rays = self.bounced(1);
                for ray in &mut rays {
                    *ray = ray.until(REACH * diagonal);
                }
                rays
            }
            Kind::Diffuse1 => self.bounced(1),
            Kind::Diffuse3 => self.bounced(3),
            Kind::Random => {
                let nothing = Scene::default();
                self.recorder(&nothing, self.count).record(RayKind::Random)
            }
        }
    }

    /// The renderer's recorder with the lights of a scene.
    fn recorder<'b>(&'b self, lights: &'b Scene, count: u32) -> Recorder<'b> {
        Recorder::new(
            lights,
            self.mesh,
            self.structure,
            self.camera,
            ASPECT,
            count,
        )
    }

    /// Shadow rays to a light where a photographer puts one: up and to the right of the camera, and not in another room.
    fn shadows(&self, light: impl Fn([f32; 3], f32) -> LightKind) -> Vec<Ray> {
        let reach = 0.25 * self.structure.bounds().size().length();
        let moved = |from: Vec3, way: Vec3| {
            let free = self
                .structure
                .closest_hit(&Ray::new(from, way).until(2.0 * reach));
            let far = free.map_or(reach, |hit: Hit| 0.5 * hit.t);
            (from + way * far, far)
        };
        let (forward, up) = (Vec3::from(self.camera.forward), Vec3::from(self.camera.up));
        let (above, rise) = moved(self.camera.eye.into(), up);
        let (place, aside) = moved(above, forward.cross(up).normalized());
        let scene = Scene {
            lights: vec![Light {
                name: String::new(),
                kind: light(place.to_array(), 0.2 * rise.min(aside)),
            }],
            up: self.up,
            ..Scene::default()
        };
        // As many pixels as leave about as many hits.
        let share = self.seen.len() as f32 / (self.size[0] * self.size[1]) as f32;
        let pixels = self.count as f32 / share.max(0.125);
        self.recorder(&scene, pixels as u32).record(RayKind::Shadow)
    }

    /// The rays of the `depth`-th diffuse bounce.
    fn bounced(&self, depth: u32) -> Vec<Ray> {
        let mut all = Vec::new();
        for pass in 0..PASSES {
            let first = pass * self.seen.len() as u32;
            let begin = |(i, at): (u32, &Surface)| (i, bounce(i, 1, at));
            let numbers = first..first + self.seen.len() as u32;
            let mut paths: Vec<(u32, Ray)> = numbers.zip(&self.seen).map(begin).collect();
            for d in 2..=depth {
                let next = |&(i, ray): &(u32, Ray)| {
                    let hit = self.structure.closest_hit(&ray)?;
                    Some((i, bounce(i, d, &self.mesh.surface(&ray, &hit))))
                };
                paths = paths.par_iter().filter_map(next).collect();
            }
            all.extend(paths.into_iter().map(|(_, ray)| ray));
            if all.len() >= self.count as usize {
                break;
            }
        }
        all.truncate(self.count as usize);
        all
    }
}

/// What rays meet.
fn surfaces(mesh: &TriangleMesh, structure: &dyn Intersect, rays: &[Ray]) -> Vec<Surface> {
    let meet = |ray: &Ray| Some(mesh.surface(ray, &structure.closest_hit(ray)?));
    rays.par_iter().filter_map(meet).collect()
}

/// The pixels of an image, tile by tile; both sides of it are multiples of the tile's. In each tile they come in quarters, so
/// that packets of 16 rays are as square as packets of a whole tile.
fn tiled(rows: &[Ray], width: u32) -> Vec<Ray> {
    let (width, tile, half) = (width as usize, TILE as usize, TILE as usize / 2);
    let mut tiles = Vec::with_capacity(rows.len());
    for band in rows.chunks(width * tile) {
        for x in (0..width).step_by(tile) {
            for quarters in band.chunks(width * half) {
                for x in [x, x + half] {
                    for row in quarters.chunks(width) {
                        tiles.extend_from_slice(&row[x..x + half]);
                    }
                }
            }
        }
    }
    tiles
}

/// The rays as a NumPy array of shape `(n, 8)`, float32: origin, `t_min`, direction, `t_max`.
pub fn npy(rays: &[Ray]) -> Vec<u8> {
    let mut header = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, 8), }}",
        rays.len()
    );
    // The numbers begin at a multiple of 64; ten bytes come before the text.
    let end = (header.len() + 11).next_multiple_of(64);
    header.extend(std::iter::repeat_n(' ', end - 11 - header.len()));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for ray in rays {
        let numbers = [ray.origin.to_array(), ray.direction.to_array()];
        for (v, t) in numbers.into_iter().zip([ray.t_min, ray.t_max]) {
            bytes.extend(v.into_iter().chain([t]).flat_map(f32::to_le_bytes));
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use boxwood::StructureKind;
    use boxwood_scene::builtin;

    #[test]
    fn every_kind_has_its_rays() {
        let scene = builtin::teapot_in_stadium();
        let mesh = scene.flatten().expect("a good scene").mesh;
        let structure = StructureKind::default().build(&mesh);
        let source = Source::new(&mesh, &*structure, &scene.cameras[0], scene.up, 4000);
        for kind in Kind::ALL {
            let rays = source.record(kind);
            assert!((1500..5000).contains(&rays.len()), "{kind}: {}", rays.len());
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        // The same rays, and neighbours in a tile are neighbours in the image.
        let (rows, tiles) = (source.record(Kind::Scanline), source.record(Kind::Tile));
        assert_eq!(rows.len(), tiles.len());
        assert_eq!(tiles[..8], rows[..8]);
        let width = source.size[0] as usize;
        assert_eq!(tiles[8..16], rows[width..width + 8]);
        assert_eq!(tiles[64..72], rows[8..16]);
    }

    #[test]
    fn arrays_are_numpy() {
        let bytes = npy(&[Ray::new([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]).until(7.0)]);
        assert_eq!(bytes.len(), 128 + 32);
        let numbers: Vec<f32> = bytes[128..]
            .chunks(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        assert_eq!(numbers, [1.0, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 7.0]);
    }
}
