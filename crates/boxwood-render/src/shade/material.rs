//! Materials made ready: maps bound to decoded textures, and what a ray needs to know before it looks closer.

use crate::shade::texture::{Encoding, Lookup, Texture};
use boxwood::Vec3;
use boxwood_scene::{Alpha, ImageData, Scene, TextureMap};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A map with the number of its texture.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    texture: usize,
    /// Which texture coordinates.
    pub uv_set: usize,
    transform: [[f32; 3]; 2],
    /// How lengths in texture coordinates grow by the transform.
    growth: f32,
    lookup: Lookup,
}

/// A material of the scene with its maps.
pub struct Prepared {
    /// As the scene says; its maps are not used.
    pub plain: boxwood_scene::Material,
    /// See [`boxwood_scene::Material`].
    pub base_color_map: Option<Bound>,
    /// See [`boxwood_scene::Material`].
    pub alpha_map: Option<Bound>,
    /// See [`boxwood_scene::Material`].
    pub metallic_roughness_map: Option<Bound>,
    /// See [`boxwood_scene::Material`].
    pub transmission_map: Option<Bound>,
    /// See [`boxwood_scene::Material`].
    pub emissive_map: Option<Bound>,
    /// See [`boxwood_scene::Material`].
    pub normal_map: Option<Bound>,
    /// Negative logarithm of what is left after one unit of length inside.
    pub absorption: Vec3,
}

impl Prepared {
    /// Whether alpha can take anything of the surface away, given whether the mesh has colours with alpha of their own.
    pub fn has_holes(&self, colour_alpha: bool, textures: &Textures) -> bool {
        let cutoff = match self.plain.alpha {
            Alpha::Opaque => return false,
            Alpha::Mask { cutoff } => cutoff,
            Alpha::Blend => 1.0,
        };
        let in_colour_map = |map: Bound| textures.all[map.texture].has_alpha();
        !(self.plain.base_color[3] >= cutoff)
            || colour_alpha
            || self.alpha_map.is_some()
            || self.base_color_map.is_some_and(in_colour_map)
    }

    /// Whether any light goes through the solid parts.
    pub fn transmits(&self) -> bool {
        self.plain.transmission > 0.0
    }

    /// Whether any map is laid over it.
    pub fn has_maps(&self) -> bool {
        self.base_color_map.is_some()
            || self.alpha_map.is_some()
            || self.metallic_roughness_map.is_some()
            || self.transmission_map.is_some()
            || self.emissive_map.is_some()
            || self.normal_map.is_some()
    }

    /// Whether it shines: emission at its brightest, before any map.
    pub fn shines(&self) -> bool {
        !self.plain.unlit && self.plain.emissive.iter().any(|&e| e > 0.0)
    }
}

/// All decoded textures of a scene.
#[derive(Default)]
pub struct Textures {
    all: Vec<Texture>,
}

impl Textures {
    /// A map's value. `texture_width` is the footprint of the ray in texture coordinates; 0 asks for the finest level.
    pub fn sample(&self, map: &Bound, uv: [f32; 2], texture_width: f32) -> [f32; 4] {
        let texture = &self.all[map.texture];
        let [[a, b, c], [d, e, f]] = map.transform;
        let uv = [a * uv[0] + b * uv[1] + c, d * uv[0] + e * uv[1] + f];
        let [w, h] = texture.size();
        let texels = texture_width * map.growth * ((w as f32) * (h as f32)).sqrt();
        let level = if texels > 1.0 {
            libm::log2f(texels)
        } else {
            0.0
        };
        texture.sample(uv, level, map.lookup)
    }

    /// Coverage from an image of its own: its alpha where it has one, else its brightness.
    pub fn coverage(&self, map: &Bound, uv: [f32; 2], texture_width: f32) -> f32 {
        let [r, g, b, a] = self.sample(map, uv, texture_width);
        if self.all[map.texture].has_alpha() {
            a
        } else {
            (r + g + b) * (1.0 / 3.0)
        }
    }

    /// The mean of a map.
    pub fn mean(&self, map: &Bound) -> [f32; 4] {
        self.all[map.texture].mean()
    }
}

/// Decodes what the materials name, in parallel, and binds it. An image that cannot be decoded leaves its maps out, with
/// one warning. One plain material follows the scene's own.
pub fn prepare(scene: &Scene, warnings: &mut Vec<String>) -> (Vec<Prepared>, Textures) {
    let mut wanted = BTreeMap::new();
    for material in &scene.materials {
        for (map, encoding) in maps(material) {
            wanted.entry((map.image, encoding)).or_insert(0_usize);
        }
    }
    let keys: Vec<_> = wanted.keys().copied().collect();
    let decoded: Vec<Result<Texture, String>> = keys
        .par_iter()
        .map(|&(image, encoding)| {
            let image = scene
                .images
                .get(image as usize)
                .ok_or("a material names an image that does not exist")?;
            let data = image.decode().map_err(|error| error.to_string())?;
            let (ImageData::Bytes { size, .. } | ImageData::Floats { size, .. }) = &data;
            if size.contains(&0) {
                return Err(format!("{}: the image has no pixels", image.name));
            }
            Ok(Texture::new(data, encoding))
        })
        .collect();
    let mut textures = Textures::default();
    for (key, texture) in keys.into_iter().zip(decoded) {
        match texture {
            Ok(texture) => {
                wanted.insert(key, textures.all.len());
                textures.all.push(texture);
            }
            Err(problem) => {
                wanted.remove(&key);
                let warning = format!("{problem}; its surfaces are shown without it");
                if !warnings.contains(&warning) {
                    warnings.push(warning);
                }
            }
        }
    }
    let bind = |map: &Option<TextureMap>, encoding| {
        let map = map.as_ref()?;
        let texture = *wanted.get(&(map.image, encoding))?;
        let [[a, b, _], [d, e, _]] = map.transform;
        Some(Bound {
            texture,
            uv_set: usize::from(map.uv_set.min(1)),
            transform: map.transform,
            growth: (a * e - b * d).abs().sqrt(),
            lookup: Lookup {
                wrap: map.wrap,
                smooth: map.smooth,
            },
        })
    };
    let prepared = scene
        .materials
        .iter()
        .chain(std::iter::once(&boxwood_scene::Material::default()))
        .map(|m| Prepared {
            base_color_map: bind(&m.base_color_map, Encoding::Srgb),
            alpha_map: bind(&m.alpha_map, Encoding::Linear),
            metallic_roughness_map: bind(&m.metallic_roughness_map, Encoding::Linear),
            transmission_map: bind(&m.transmission_map, Encoding::Linear),
            emissive_map: bind(&m.emissive_map, Encoding::Srgb),
            normal_map: bind(&m.normal_map, Encoding::Linear),
            absorption: absorption(m),
            plain: m.clone(),
        })
        .collect();
    (prepared, textures)
}

fn maps(m: &boxwood_scene::Material) -> impl Iterator<Item = (&TextureMap, Encoding)> {
    [
        (&m.base_color_map, Encoding::Srgb),
        (&m.alpha_map, Encoding::Linear),
        (&m.metallic_roughness_map, Encoding::Linear),
        (&m.transmission_map, Encoding::Linear),
        (&m.emissive_map, Encoding::Srgb),
        (&m.normal_map, Encoding::Linear),
    ]
    .into_iter()
    .filter_map(|(map, encoding)| map.as_ref().map(|map| (map, encoding)))
}

/// Beer's law: `colour = exp(−absorption · distance)`.
fn absorption(m: &boxwood_scene::Material) -> Vec3 {
    if !(m.attenuation_distance > 0.0 && m.attenuation_distance.is_finite()) {
        return Vec3::ZERO;
    }
    // Black would absorb infinitely much: 1e-6 is black enough.
    let per_unit = |c: f32| -libm::logf(c.clamp(1.0e-6, 1.0)) / m.attenuation_distance;
    Vec3::from(m.attenuation_color.map(per_unit))
}

/// What is left after a way through an absorbing body.
pub fn attenuate(absorption: Vec3, distance: f32) -> Vec3 {
    if absorption == Vec3::ZERO {
        return crate::colour::WHITE;
    }
    let left = |a: f32| libm::expf(-(a * distance).max(0.0));
    Vec3::new(left(absorption.x), left(absorption.y), left(absorption.z))
}
