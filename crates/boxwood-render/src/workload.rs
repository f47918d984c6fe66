//! Rays as renderers cast them, recorded once: what structures are compared on.
//!
//! *How it works.* The camera's rays through the middles of pixels come first, row by row. Where they meet a surface, the
//! others begin: towards the light, around the normal, on to the next surface. Which direction each takes is a hash of its
//! number, so that a workload is the same on every machine. Rays leave a surface by
//! [`Surface::offset_origin`](boxwood::Surface::offset_origin).
//!
//! *Cost.* 32 bytes per ray, and one closest-hit query per pixel, asked as a batch.
//!
//! *Source.* The kinds are those of Aila & Laine 2009, *Understanding the Efficiency of Ray Traversal on GPUs* (primary,
//! ambient occlusion, diffuse), with the shadow rays of Whitted 1980 and segments between random points beside them.

use crate::camera::Lens;
use crate::sample::Samples;
use crate::shade::direction::around_normal;
use boxwood::{Intersect, Ray, Surface, Surfaces, TriangleMesh, Vec3};
use boxwood_scene::{Camera, LightKind, Scene};
use rayon::prelude::*;
use std::fmt;
use std::str::FromStr;

/// What rays are cast for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// From the camera through the middles of pixels, row by row: neighbours go the same way.
    Primary,
    /// From what the camera sees to the light, where the surface faces it. The scene's lights take turns; a scene without
    /// lights has the one over the viewer's shoulder that the renderer gives it.
    Shadow,
    /// Ambient occlusion: from what the camera sees around the normal, as often as its cosine is large, and no further
    /// than a tenth of the scene's diagonal.
    Ao,
    /// The first diffuse bounce: the same directions without end.
    Diffuse,
    /// Segments between random points of the scene's box: no order at all.
    Random,
}

impl RayKind {
    /// All kinds, the most orderly first.
    pub const ALL: [Self; 5] = [
        Self::Primary,
        Self::Shadow,
        Self::Ao,
        Self::Diffuse,
        Self::Random,
    ];

    /// As a user writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Ao => "ao",
            Self::Diffuse => "diffuse",
            Self::Random => "random",
        }
    }

    /// Whether renderers ask of such a ray only if anything is in its way.
    pub fn asks_occlusion(self) -> bool {
        matches!(self, Self::Shadow | Self::Ao)
    }
}

impl fmt::Display for RayKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// No kind of ray has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no rays are called `{0}`; there are primary, shadow, ao, diffuse and random")]
pub struct UnknownRayKind(String);

impl FromStr for RayKind {
    type Err = UnknownRayKind;

    fn from_str(text: &str) -> Result<Self, UnknownRayKind> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == text);
        found.ok_or_else(|| UnknownRayKind(text.to_string()))
    }
}

/// How far ambient occlusion looks, in diagonals of the scene's box.
const REACH: f32 = 0.1;

/// The rays through the middles of all pixels of an image, row by row from its upper left corner.
pub fn view(camera: &Camera, size: [u32; 2]) -> Vec<Ray> {
    let lens = Lens::new(camera, size);
    let [width, height] = size;
    let ray = |x: u32, y: u32| lens.ray(x as f32 + 0.5, y as f32 + 0.5);
    (0..height)
        .flat_map(|y| (0..width).map(move |x| ray(x, y)))
        .collect()
}

/// Where rays are recorded.
#[derive(Clone, Copy)]
pub struct Recorder<'a> {
    scene: &'a Scene,
    mesh: &'a TriangleMesh,
    structure: &'a dyn Intersect,
    camera: &'a Camera,
    size: [u32; 2],
    count: u32,
}

impl<'a> Recorder<'a> {
    /// A recorder for a scene, its triangles in world space, a structure over these, and what a camera sees in an image of
    /// the shape `aspect` (width by height). There will be about `count` primary rays and at most `count` of each other
    /// kind: those that begin on surfaces are as many as primary rays that hit (shadow rays fewer: some face away).
    pub fn new(
        scene: &'a Scene,
        mesh: &'a TriangleMesh,
        structure: &'a dyn Intersect,
        camera: &'a Camera,
        aspect: f32,
        count: u32,
    ) -> Self {
        let aspect = if aspect > 0.0 && aspect.is_finite() {
            aspect
        } else {
            1.0
        };
        let count = count.max(1);
        let width = (count as f32 * aspect).sqrt().round() as u32;
        let width = width.clamp(1, count);
        Self {
            scene,
            mesh,
            structure,
            camera,
            size: [width, (count / width).max(1)],
            count,
        }
    }

    /// Width and height of the image that the primary rays make.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The rays of one kind, in the caller's rayon pool; the same for any number of threads and every structure.
    pub fn record(&self, kind: RayKind) -> Vec<Ray> {
        let bounds = self.structure.bounds();
        match kind {
            RayKind::Primary => view(self.camera, self.size),
            RayKind::Random if bounds.is_empty() => Vec::new(),
            RayKind::Random => (0..self.count)
                .into_par_iter()
                .map(|i| {
                    let point = |purpose: u32| {
                        let samples = Samples::new([i, 0], 0);
                        let [x, y] = samples.pair(purpose, 1, 0);
                        let [z, _] = samples.pair(purpose + 1, 1, 0);
                        let s = Vec3::new(x, y, z);
                        bounds.lower * (Vec3::splat(1.0) - s) + bounds.upper * s
                    };
                    Ray::between(point(SEGMENT), point(SEGMENT + 2))
                })
                .collect(),
            RayKind::Shadow => self.shadows(),
            RayKind::Ao => {
                let reach = REACH * bounds.size().length();
                self.on_surfaces(|i, at| Some(bounce(i, 1, at).until(reach)))
            }
            RayKind::Diffuse => self.on_surfaces(|i, at| Some(bounce(i, 1, at))),
        }
    }

    /// One ray, or none, from each place that a primary ray meets.
    fn on_surfaces(&self, ray: impl Fn(u32, &Surface) -> Option<Ray> + Sync) -> Vec<Ray> {
        let view = view(self.camera, self.size);
        let mut hits = vec![None; view.len()];
        self.structure.closest_hits(&view, &mut hits);
        (view.par_iter().zip(hits).enumerate())
            .filter_map(|(i, (primary, hit))| ray(i as u32, &self.mesh.surface(primary, &hit?)))
            .collect()
    }

    fn shadows(&self) -> Vec<Ray> {
        let lens = Lens::new(self.camera, self.size);
        let shoulder = lens.over_the_shoulder(self.scene.up.into(), &self.structure.bounds());
        let lights = &self.scene.lights;
        self.on_surfaces(|i, at| {
            let samples = Samples::new([i, 1], 0).pair(LIGHT, 1, 0);
            let (way, end) = match lights.len() {
                0 => (shoulder, f32::INFINITY),
                n => to_light(&lights[i as usize % n].kind, samples, at.position),
            };
            // A renderer asks no light that shines on the other side.
            let lit = at.facing().dot(way) > 0.0;
            lit.then(|| Ray::new(at.offset_origin(way), way).until(end))
        })
    }
}

/// What the numbers of a ray are hashed for.
const LIGHT: u32 = 1;
const AROUND: u32 = 2;
const SEGMENT: u32 = 3;

/// From a point to a light: the way, and at which `t` the light stands.
fn to_light(light: &LightKind, [u, v]: [f32; 2], from: Vec3) -> (Vec3, f32) {
    let target = match light {
        LightKind::Directional { direction, .. } => {
            return (-Vec3::from(*direction), f32::INFINITY);
        }
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
            Vec3::from(*position)
        }
        LightKind::Sphere { center, radius, .. } => {
            // A point of the half that shines here.
            let center = Vec3::from(*center);
            let towards = (from - center).normalized();
            center + around_normal(towards, [u, v]) * *radius
        }
        LightKind::Rectangle {
            corner,
            edge_u,
            edge_v,
            ..
        } => Vec3::from(*corner) + Vec3::from(*edge_u) * u + Vec3::from(*edge_v) * v,
    };
    (target - from, 1.0)
}

/// The diffuse bounce of path `i` off its `depth`-th surface (from 1): around the normal, as often as its cosine is large.
pub fn bounce(i: u32, depth: u32, at: &Surface) -> Ray {
    let sample = Samples::new([i, depth.wrapping_add(1)], 0).pair(AROUND, 1, 0);
    let direction = around_normal(at.facing(), sample);
    Ray::new(at.offset_origin(direction), direction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use boxwood::StructureKind;
    use boxwood_scene::builtin;

    #[test]
    fn names_go_both_ways() {
        for kind in RayKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        assert!("reflection".parse::<RayKind>().is_err());
    }

    #[test]
    fn workloads_are_those_of_any_structure_and_begin_on_surfaces() {
        let scene = builtin::teapot_in_stadium();
        let flat = scene.flatten().expect("a good scene");
        let fine = StructureKind::default().build(&flat.mesh);
        let plain = "bvh:median".parse::<StructureKind>().expect("it exists");
        let plain = plain.build(&flat.mesh);
        let camera = &scene.cameras[0];
        let recorder = |structure| Recorder::new(&scene, &flat.mesh, structure, camera, 1.5, 2400);
        let [a, b] = [recorder(&*fine), recorder(&*plain)];
        assert_eq!(a.size(), [60, 40]);
        for kind in RayKind::ALL {
            let rays = a.record(kind);
            assert!(rays == b.record(kind), "{kind}");
            assert!(
                rays.len() <= 2400 && rays.len() > 500,
                "{kind}: {}",
                rays.len()
            );
            // No ray meets the surface that it leaves.
            if matches!(kind, RayKind::Ao | RayKind::Diffuse | RayKind::Shadow) {
                let near = |r: &&Ray| fine.closest_hit(r).is_some_and(|hit| hit.t < 1.0e-6);
                let own = rays.iter().filter(near).count();
                assert!(own * 100 < rays.len(), "{kind}: {own} of {}", rays.len());
            }
        }
    }

    #[test]
    fn a_scene_of_nothing_has_primary_rays_only() {
        let scene = Scene::default();
        let flat = scene.flatten().expect("legal");
        let structure = StructureKind::default().build(&flat.mesh);
        let camera = crate::camera::frame(&structure.bounds(), scene.up, 0.7, 1.0);
        let recorder = Recorder::new(&scene, &flat.mesh, &*structure, &camera, 1.0, 16);
        let counts = RayKind::ALL.map(|kind| recorder.record(kind).len());
        assert_eq!(counts, [16, 0, 0, 0, 0]);
    }
}
