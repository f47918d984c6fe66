//! A scene laid out for rendering: structure, attributes, materials, lights.

use crate::RenderError;
use crate::environment::Environment;
use crate::layout::Layout;
use crate::render::Setup;
use crate::shade::emitters::Emitters;
use crate::shade::light::Lamp;
use crate::shade::material::{self, Prepared, Textures};
use crate::shade::texture::{Encoding, Texture};
use boxwood::{Aabb, Affine, Hit, Vec3};
use boxwood_scene::{Image, ImageData, Light, LightKind, Mesh, Scene};
use rayon::prelude::*;

/// Everything that shading reads. Nothing in it changes while rays fly.
pub(crate) struct World {
    /// All triangles under a structure.
    pub layout: Layout,
    pub meshes: Vec<Attributes>,
    pub materials: Vec<Prepared>,
    pub textures: Textures,
    /// Triangles that a ray may pass through, wholly or in part.
    pub open: Open,
    pub lamps: Vec<Lamp>,
    pub emitters: Emitters,
    pub environment: Environment,
    /// Irradiance of the light over the viewer's shoulder, for scenes that bring no light.
    pub key_light: Option<Vec3>,
    /// How far ambient light looks for what stands in its way.
    pub ambient_reach: f32,
    /// What brings the scene's own lights to the brightness of a screen.
    pub exposure: f32,
    pub up: Vec3,
}

/// A mesh without its positions.
pub(crate) struct Attributes {
    pub triangles: Vec<[u32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// Normals of each triangle's corners, made where the file has none and the surface may be smooth.
    pub corner_normals: Vec<[[f32; 3]; 3]>,
    pub tangents: Vec<[f32; 4]>,
    pub uvs: [Vec<[f32; 2]>; 2],
    pub colors: Vec<[f32; 4]>,
    pub material: usize,
}

/// Where a mesh stands.
pub(crate) struct Placement {
    pub transform: Affine,
    pub plain: bool,
    pub mirrors: bool,
    /// Whether triangles turn over where the transform mirrors: those that are laid out do, those of instances do not.
    pub turns_over: bool,
}

/// A triangle's (instance, primitive).
pub(crate) type Triangle = (u32, u32);

/// Which triangles have holes or let light through: a bit for each mesh, and for each triangle that is laid out, so that
/// nobody needs to search for its mesh. No bits where none does.
#[derive(Default)]
pub(crate) struct Open {
    holes: Bits,
    through: Bits,
}

#[derive(Default)]
struct Bits {
    meshes: Vec<u64>,
    laid_out: Vec<u64>,
}

impl World {
    /// Whether alpha may take this one away.
    pub fn has_holes(&self, triangle: Triangle) -> bool {
        self.is_set(&self.open.holes, triangle)
    }
    /// Whether light may go through this one, by alpha or transmission.
    pub fn lets_through(&self, triangle: Triangle) -> bool {
        self.is_set(&self.open.through, triangle)
    }
    fn is_set(&self, bits: &Bits, (instance, primitive): Triangle) -> bool {
        if bits.meshes.is_empty() {
            false
        } else if instance == 0 && !bits.laid_out.is_empty() {
            bit(&bits.laid_out, primitive)
        } else {
            bit(&bits.meshes, self.layout.mesh_of((instance, primitive)))
        }
    }
}

fn bit(bits: &[u64], i: u32) -> bool {
    bits.get(i as usize / 64)
        .is_some_and(|word| word >> (i % 64) & 1 == 1)
}

impl World {
    pub fn new(
        scene: &Scene,
        setup: &Setup,
        warnings: &mut Vec<String>,
    ) -> Result<Self, RenderError> {
        let up = if Vec3::from(scene.up).normalized() == Vec3::ZERO {
            Vec3::new(0.0, 1.0, 0.0)
        } else {
            Vec3::from(scene.up).normalized()
        };
        let layout = Layout::kept(
            scene,
            setup.structure,
            setup.flatten,
            setup.shelf.as_deref(),
        )?;
        let (materials, textures) = material::prepare(scene, warnings);
        let bounds = layout.structure().bounds();

        let mut world = Self {
            ambient_reach: 0.12 * bounds.size().length(),
            layout,
            meshes: scene
                .meshes
                .par_iter()
                .map(|mesh| Attributes::of(mesh, scene.materials.len()))
                .collect(),
            materials,
            textures,
            open: Open::default(),
            lamps: scene
                .lights
                .iter()
                .filter_map(|light| Lamp::new(&light.kind))
                .collect(),
            emitters: Emitters::default(),
            environment: Environment::sky(up, 1.0),
            key_light: None,
            exposure: exposure(&scene.lights, &bounds),
            up,
        };
        world.open = world.find_open();
        world.emitters = Emitters::find(&world);
        world.light_up(scene, setup, warnings)?;
        Ok(world)
    }

    /// Chooses the surroundings: what the caller gives, else what the scene names, else a sky: full day where nothing
    /// else shines or a sun does, dusk where other lights should be seen.
    fn light_up(
        &mut self,
        scene: &Scene,
        setup: &Setup,
        warnings: &mut Vec<String>,
    ) -> Result<(), RenderError> {
        let mut image = None;
        if let Some(given) = &setup.environment {
            image = Some((decode(given).map_err(RenderError::Environment)?, 1.0));
        } else if let Some(named) = &scene.environment
            && let Some(file) = scene.images.get(named.image as usize)
        {
            match decode(file) {
                Ok(texture) => image = Some((texture, named.intensity)),
                Err(error) => warnings.push(format!("{error}; a plain sky takes its place")),
            }
        }
        if let Some((texture, intensity)) = image {
            self.environment = Environment::image(self.up, texture, intensity);
            if let Some(sun) = &self.environment.sun {
                self.lamps
                    .push(Lamp::sun(sun.direction, sun.irradiance, sun.radius));
            }
        } else if self.lamps.is_empty() && self.emitters.is_empty() {
            self.environment = Environment::sky(self.up, DAY);
            self.key_light = Some(KEY);
        } else {
            // A light from infinitely far away is a sun, and a sun stands in a sky. Lights are balanced against the
            // exposure; the sky must not be.
            let outdoors = self
                .lamps
                .iter()
                .any(|lamp| matches!(lamp, Lamp::Far { .. }));
            let brightness = if outdoors { SUNNY } else { DUSK };
            self.environment = Environment::sky(self.up, brightness / self.exposure);
        }
        Ok(())
    }

    /// The material of a triangle.
    pub fn material_of(&self, triangle: Triangle) -> &Prepared {
        let mesh = self.layout.mesh_of(triangle);
        &self.materials[self.meshes[mesh as usize].material]
    }

    fn find_open(&self) -> Open {
        let kinds: Vec<_> = self
            .meshes
            .iter()
            .map(|mesh| {
                let Some(material) = self.materials.get(mesh.material) else {
                    return (false, false);
                };
                let colour_alpha = mesh.colors.iter().any(|c| c[3] < 1.0);
                let holes = material.has_holes(colour_alpha, &self.textures);
                (holes, holes || material.transmits())
            })
            .collect();
        let count = self.layout.laid_out_triangles();
        // No bits where no mesh has any.
        let bits = |has: &dyn Fn(usize) -> bool| {
            if !(0..kinds.len()).any(has) {
                return Bits::default();
            }
            Bits {
                meshes: packed(kinds.len() as u32, |mesh| has(mesh as usize)),
                laid_out: packed(count, |i| has(self.layout.mesh_of((0, i)) as usize)),
            }
        };
        Open {
            holes: bits(&|mesh| kinds[mesh].0),
            through: bits(&|mesh| kinds[mesh].1),
        }
    }
}

/// A bit for each number below `count`.
fn packed(count: u32, is_set: impl Fn(u32) -> bool) -> Vec<u64> {
    let mut bits = vec![0; count.div_ceil(64) as usize];
    for i in (0..count).filter(|&i| is_set(i)) {
        bits[i as usize / 64] |= 1 << (i % 64);
    }
    bits
}

/// Edges sharper than this (40 degrees) stay edges where smooth normals are made.
const CREASE: f32 = 0.698;
/// Brightness of the sky with the key light, around a sun of the scene, and beside other lights.
const DAY: f32 = 0.6;
const SUNNY: f32 = 0.65;
const DUSK: f32 = 0.22;
/// Irradiance of the key light: a low, warm sun.
const KEY: Vec3 = Vec3::new(2.2, 2.02, 1.8);

/// Files speak of lights in units of their own: candela, lux, watts, or nothing at all. Where the scene's point, spot and
/// directional lights together would shine on the middle of the scene with an irradiance outside 0.8 to 12 (a white
/// surface shows full white at π), they and all else are exposed to the nearer of these bounds. Area lights and
/// environments are taken as they are.
fn exposure(lights: &[Light], bounds: &Aabb) -> f32 {
    let centre = if bounds.is_empty() {
        Vec3::ZERO
    } else {
        bounds.centroid()
    };
    let near = 0.5 * bounds.size().length();
    let at = |position: [f32; 3]| {
        let distance = (Vec3::from(position) - centre).length().max(0.5 * near);
        distance * distance
    };
    let irradiance: f32 = lights
        .iter()
        .map(|light| match light.kind {
            LightKind::Point {
                position,
                intensity,
                ..
            }
            | LightKind::Spot {
                position,
                intensity,
                ..
            } => crate::colour::luminance(intensity.into()) / at(position),
            LightKind::Directional { irradiance, .. } => {
                crate::colour::luminance(irradiance.into())
            }
            LightKind::Sphere { .. } | LightKind::Rectangle { .. } => 0.0,
        })
        .sum();
    if irradiance > 0.0 && irradiance.is_finite() {
        irradiance.clamp(0.8, 12.0) / irradiance
    } else {
        1.0
    }
}

fn decode(image: &Image) -> Result<Texture, boxwood_scene::SceneError> {
    let data = image.decode()?;
    let (ImageData::Bytes { size, .. } | ImageData::Floats { size, .. }) = &data;
    if size.contains(&0) {
        return Err(boxwood_scene::SceneError::Malformed {
            file: image.name.clone(),
            place: boxwood_scene::Place::File,
            problem: "the image has no pixels".to_string(),
        });
    }
    Ok(Texture::new(data, Encoding::Srgb))
}

impl Attributes {
    /// A list that is not as long as the positions is left out; a material that does not exist is the plain one, which
    /// [`material::prepare`] puts after the last.
    fn of(mesh: &Mesh, materials: usize) -> Self {
        fn whole<T: Clone>(list: &[T], mesh: &Mesh) -> Vec<T> {
            if list.len() == mesh.positions.len() {
                list.to_vec()
            } else {
                Vec::new()
            }
        }
        Self {
            triangles: mesh.triangles.clone(),
            corner_normals: if mesh.normals.is_empty() && mesh.smooth {
                mesh.corner_normals(CREASE)
            } else {
                Vec::new()
            },
            normals: whole(&mesh.normals, mesh),
            tangents: whole(&mesh.tangents, mesh),
            uvs: [whole(&mesh.uvs, mesh), whole(&mesh.uvs1, mesh)],
            colors: whole(&mesh.colors, mesh),
            material: (mesh.material as usize).min(materials),
        }
    }
}

impl World {
    /// Where a hit's mesh stands.
    pub fn placement(&self, hit: &Hit) -> Placement {
        let (transform, is_instance) = self.layout.transform(hit);
        let mirrors = transform.mirrors();
        Placement {
            plain: transform == Affine::IDENTITY,
            mirrors,
            turns_over: mirrors && !is_instance,
            transform,
        }
    }
}
