//! Materials and the textures they show.
//!
//! *Source.* glTF 2.0, sections 3.8 and 3.9; `KHR_materials_{unlit, transmission, ior, volume, specular,
//! emissive_strength, pbrSpecularGlossiness}`, `KHR_texture_transform`, `EXT_texture_webp`.

use super::file::File;
use super::images::Images;
use super::schema::{self, AlphaMode, Index, TextureInfo};
use crate::{Alpha, Material, SceneError, TextureMap, Wrap};

/// The material of primitives that name none: all of the specification's defaults, so white, metallic and matt.
pub fn default() -> Material {
    Material {
        base_color: [1.0; 4],
        metallic: 1.0,
        roughness: 1.0,
        double_sided: false,
        thin: true,
        ..Material::default()
    }
}

/// Reads all materials, in the order of the file.
pub fn read(file: &File<'_>, images: &mut Images) -> Result<Vec<Material>, SceneError> {
    let materials = &file.root.materials;
    let bytes = (materials.len() * size_of::<Material>()) as u64;
    file.spend(bytes, || "materials".to_owned())?;
    let mut done = Vec::with_capacity(materials.len());
    for (number, said) in materials.iter().enumerate() {
        let reader = Reader { file, number };
        done.push(reader.material(said, images)?);
    }
    Ok(done)
}

struct Reader<'r, 'a> {
    file: &'r File<'a>,
    number: usize,
}

impl Reader<'_, '_> {
    fn path(&self, key: &str) -> String {
        format!("materials[{}]{key}", self.number)
    }

    fn material(
        &self,
        said: &schema::Material,
        images: &mut Images,
    ) -> Result<Material, SceneError> {
        let mut material = Material {
            name: said.name.to_string(),
            double_sided: said.double_sided,
            alpha: match said.alpha_mode {
                AlphaMode::Opaque => Alpha::Opaque,
                AlphaMode::Mask => Alpha::Mask {
                    cutoff: said.alpha_cutoff.unwrap_or(0.5).clamp(0.0, 2.0) as f32,
                },
                AlphaMode::Blend => Alpha::Blend,
            },
            ..default()
        };
        if let Some(pbr) = &said.metallic_roughness {
            material.base_color = pbr.base_color_factor.map_or([1.0; 4], |c| c.map(share));
            material.metallic = pbr.metallic_factor.map_or(1.0, share);
            material.roughness = pbr.roughness_factor.map_or(1.0, share);
            let prefix = ".pbrMetallicRoughness";
            let key = format!("{prefix}.baseColorTexture");
            material.base_color_map = self.map(pbr.base_color_texture.as_ref(), &key, images)?;
            let key = format!("{prefix}.metallicRoughnessTexture");
            let texture = pbr.metallic_roughness_texture.as_ref();
            material.metallic_roughness_map = self.map(texture, &key, images)?;
        }
        let texture = said.normal_texture.as_deref();
        material.normal_map = self.map(texture, ".normalTexture", images)?;
        if let Some(scale) = texture.and_then(|texture| texture.scale) {
            material.normal_scale = scale.clamp(-LARGE, LARGE) as f32;
        }
        let texture = said.emissive_texture.as_deref();
        material.emissive_map = self.map(texture, ".emissiveTexture", images)?;
        let emissive = said.emissive_factor.as_deref().copied();
        let mut emissive = emissive.unwrap_or([0.0; 3]);

        if let Some(extensions) = &said.extensions {
            if let Some(said) = &extensions.emissive_strength {
                let strength = said.emissive_strength.unwrap_or(1.0);
                emissive = emissive.map(|e| e * strength);
            }
            self.extend(&mut material, said, extensions, images)?;
        }
        material.emissive = emissive.map(|e| e.clamp(0.0, LARGE) as f32);
        Ok(material)
    }

    fn extend(
        &self,
        material: &mut Material,
        said: &schema::Material,
        extensions: &schema::MaterialExtensions,
        images: &mut Images,
    ) -> Result<(), SceneError> {
        material.unlit = extensions.unlit.is_some();
        if let Some(said) = &extensions.transmission {
            material.transmission = share(said.transmission_factor);
            let key = ".extensions.KHR_materials_transmission.transmissionTexture";
            let texture = said.transmission_texture.as_ref();
            material.transmission_map = self.map(texture, key, images)?;
        }
        if let Some(ior) = extensions.ior.as_ref().and_then(|said| said.ior) {
            // 0 stands for "infinite" in old files; nothing but a mirror would come of it.
            material.ior = if ior >= 1.0 {
                ior.min(LARGE) as f32
            } else {
                1.5
            };
        }
        if let Some(said) = &extensions.volume {
            material.thin = said.thickness_factor <= 0.0;
            let color = said.attenuation_color.unwrap_or([1.0; 3]);
            material.attenuation_color = color.map(share);
            material.attenuation_distance = match said.attenuation_distance {
                Some(distance) if distance > 0.0 => distance as f32,
                _ => f32::INFINITY,
            };
        }
        if let Some(said) = &extensions.specular {
            let factor = said.specular_factor.unwrap_or(1.0);
            let color = said.specular_color_factor.unwrap_or([1.0; 3]);
            material.specular = color.map(|c| (c * factor).clamp(0.0, LARGE) as f32);
            if said.specular_texture.is_some() || said.specular_color_texture.is_some() {
                let path = self.path(".extensions.KHR_materials_specular");
                self.file.warn(path, "specular textures are left out");
            }
        }
        if let (Some(old), None) = (&extensions.specular_glossiness, &said.metallic_roughness) {
            let prefix = ".extensions.KHR_materials_pbrSpecularGlossiness";
            self.file.warn(
                self.path(prefix),
                "a specular-glossiness material is shown as a plain dielectric of the same colour and gloss",
            );
            material.metallic = 0.0;
            material.roughness = 1.0 - old.glossiness_factor.map_or(1.0, share);
            material.base_color = old.diffuse_factor.map_or([1.0; 4], |c| c.map(share));
            let key = format!("{prefix}.diffuseTexture");
            material.base_color_map = self.map(old.diffuse_texture.as_ref(), &key, images)?;
        }
        Ok(())
    }

    /// How a texture lies on the surface; `None` when there is none, or, with a warning, none that can be shown.
    fn map(
        &self,
        info: Option<&TextureInfo>,
        key: &str,
        images: &mut Images,
    ) -> Result<Option<TextureMap>, SceneError> {
        let Some(info) = info else { return Ok(None) };
        let (file, root) = (self.file, &self.file.root);
        let path = || self.path(&format!("{key}.index"));
        let texture = file.at(&root.textures, info.index, "texture", path)?;
        let number = info.index.0;
        let webp = texture.extensions.as_ref().and_then(|e| e.webp.as_ref());
        let Some(source) = webp.and_then(|webp| webp.source).or(texture.source) else {
            let what = "a texture without a source is left out";
            file.warn(format!("textures[{number}]"), what);
            return Ok(None);
        };
        let path = || format!("textures[{number}].source");
        let Some(image) = images.find(file, source, path)? else {
            return Ok(None);
        };
        let transform = info.extensions.as_ref().and_then(|e| e.transform.as_ref());
        let set = transform.and_then(|t| t.tex_coord).or(info.tex_coord);
        let set = set.map_or(0, |set| set.0);
        if set > 1 {
            let what = "textures on TEXCOORD_2 and beyond are left out";
            file.warn(self.path(&format!("{key}.texCoord")), what);
            return Ok(None);
        }
        let mut map = TextureMap {
            uv_set: set as u8,
            ..TextureMap::new(image)
        };
        if let Some(transform) = transform {
            map.transform = uv_transform(transform);
        }
        if let Some(index) = texture.sampler {
            let path = || format!("textures[{number}].sampler");
            let sampler = file.at(&root.samplers, index, "sampler", path)?;
            // 9728 is NEAREST. The filter for minification is the renderer's affair.
            map.smooth = sampler.mag_filter.is_none_or(|filter| filter.0 != 9728);
            map.wrap = [sampler.wrap_s, sampler.wrap_t].map(wrap);
        }
        Ok(Some(map))
    }
}

fn wrap(code: Option<Index>) -> Wrap {
    match code.map(|code| code.0) {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

/// First scale, then turn, then move. A positive angle turns counter-clockwise as one looks at the image, where `v`
/// points down: so do the extension's words, its test model and every renderer, against the signs of its GLSL text.
fn uv_transform(said: &schema::TextureTransform) -> [[f32; 3]; 2] {
    let [x, y] = said.offset.unwrap_or([0.0; 2]);
    let [width, height] = said.scale.unwrap_or([1.0; 2]);
    let (sin, cos) = libm::sincos(said.rotation.unwrap_or(0.0));
    [
        [cos * width, sin * height, x],
        [-sin * width, cos * height, y],
    ]
    .map(|row| row.map(|number| number.clamp(-LARGE, LARGE) as f32))
}

/// Beyond any sense, and within single precision.
const LARGE: f64 = 1e30;

fn share(x: f64) -> f32 {
    x.clamp(0.0, 1.0) as f32
}
