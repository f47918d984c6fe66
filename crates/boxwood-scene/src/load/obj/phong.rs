//! Phong materials of MTL, and what they are in terms of metallic-roughness.
//!
//! *How it works.* Colours are taken as linear. `illum` says which law holds: 0 and 1 are matt, 2 has a highlight,
//! 3, 5 and 8 mirror, 4, 6, 7 and 9 are glass; the `Pr` and `Pm` of newer exporters have the last word. A highlight of exponent
//! `Ns` is as wide as a microfacet lobe of roughness `α² = 2 / (Ns + 2)`, whose perceptual roughness is `√α`.
//! *Source.* Wavefront, MTL specification; Walter et al. 2007, *Microfacet Models for Refraction* (Phong exponents).

use super::Line;
use super::cursor::{Cursor, quoted};
use super::map::MapStatement;
use super::warnings::Warnings;
use crate::{Alpha, Material, TextureMap};

/// The statements of one material, unset ones `None`.
#[derive(Default)]
pub(super) struct Phong {
    name: String,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    emissive: Option<[f32; 3]>,
    filter: Option<[f32; 3]>,
    exponent: Option<f32>,
    ior: Option<f32>,
    opacity: Option<f32>,
    transparency: Option<f32>,
    illum: Option<f32>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    diffuse_map: Option<TextureMap>,
    emissive_map: Option<TextureMap>,
    alpha_map: Option<TextureMap>,
    normal_map: Option<TextureMap>,
    normal_scale: f32,
}

/// Reflectance at normal incidence of a dielectric with index of refraction 1.5.
const GLOSS: f32 = 0.04;

impl Phong {
    pub(super) fn new(name: String) -> Self {
        Self {
            name,
            normal_scale: 1.0,
            ..Self::default()
        }
    }

    /// Takes the statement that begins with `word`; `map` finds images.
    pub(super) fn statement(
        &mut self,
        word: &[u8],
        cursor: &mut Cursor,
        line: Line,
        warnings: &mut Warnings,
        mut map: impl FnMut(&MapStatement, &mut Warnings) -> Option<TextureMap>,
    ) {
        let mut texture = |cursor: &mut Cursor, warnings: &mut Warnings| {
            let statement = MapStatement::read(cursor)?;
            Ok(map(&statement, warnings).map(|texture| (texture, statement.strength)))
        };
        let result = match word {
            b"Kd" => color(cursor).map(|kd| self.diffuse = Some(kd)),
            b"Ks" => color(cursor).map(|ks| self.specular = Some(ks)),
            b"Ke" => color(cursor).map(|ke| self.emissive = Some(ke)),
            b"Tf" => color(cursor).map(|tf| self.filter = Some(tf)),
            b"Ns" => number(cursor).map(|ns| self.exponent = Some(ns)),
            b"Ni" => number(cursor).map(|ni| self.ior = Some(ni)),
            b"d" => {
                if cursor.peek_word() == b"-halo" {
                    cursor.word();
                }
                number(cursor).map(|d| self.opacity = Some(d))
            }
            b"Tr" => number(cursor).map(|tr| self.transparency = Some(tr)),
            b"illum" => number(cursor).map(|illum| self.illum = Some(illum)),
            b"Pr" => number(cursor).map(|pr| self.roughness = Some(pr)),
            b"Pm" => number(cursor).map(|pm| self.metallic = Some(pm)),
            b"map_Kd" | b"map_kd" => {
                texture(cursor, warnings).map(|t| set(&mut self.diffuse_map, t))
            }
            b"map_Ke" | b"map_ke" => {
                texture(cursor, warnings).map(|t| set(&mut self.emissive_map, t))
            }
            b"map_d" | b"map_D" => texture(cursor, warnings).map(|t| set(&mut self.alpha_map, t)),
            b"norm" | b"map_Kn" => texture(cursor, warnings).map(|t| {
                self.normal_scale = t.map_or(1.0, |(_, strength)| strength);
                set(&mut self.normal_map, t);
            }),
            b"bump" | b"map_bump" | b"map_Bump" | b"disp" => {
                warnings.of_kind(
                    "bump",
                    line,
                    || "bump maps are not supported; the surface stays smooth",
                );
                Ok(())
            }
            b"map_Ks" | b"map_Ns" | b"map_Pr" | b"map_Pm" | b"refl" => {
                warnings.of_kind("other map", line, || {
                    format!("{} is not supported; passed over", quoted(word))
                });
                Ok(())
            }
            _ => Ok(()),
        };
        if let Err(problem) = result {
            warnings.of_kind("value", line, || {
                format!("{}: {problem}; the line is passed over", quoted(word))
            });
        }
    }

    /// The same surface in the model of all formats.
    pub(super) fn into_material(self) -> Material {
        let opacity = match (self.opacity, self.transparency) {
            (Some(d), _) => d,
            (None, Some(tr)) => 1.0 - tr,
            (None, None) => 1.0,
        };
        let [r, g, b] = factor(self.diffuse, &self.diffuse_map, [0.8; 3]).map(saturate);
        let mut material = Material {
            name: self.name,
            base_color: [r, g, b, saturate(opacity)],
            base_color_map: self.diffuse_map,
            alpha_map: self.alpha_map,
            specular: [0.0; 3],
            emissive: factor(self.emissive, &self.emissive_map, [0.0; 3]).map(|e| e.max(0.0)),
            emissive_map: self.emissive_map,
            normal_map: self.normal_map,
            normal_scale: self.normal_scale,
            ..Material::default()
        };
        let specular = self.specular.unwrap_or([0.0; 3]).map(saturate);
        let brightest = specular[0].max(specular[1]).max(specular[2]);
        let has_gloss = brightest > 0.0;
        let is_glass = matches!(self.illum, Some(4.0 | 6.0 | 7.0 | 9.0));
        let is_mirror = matches!(self.illum, Some(3.0 | 5.0 | 8.0)) && has_gloss;
        let is_matt = matches!(self.illum, Some(0.0 | 1.0));
        if is_glass {
            let [r, g, b] = self.filter.unwrap_or([1.0; 3]).map(saturate);
            material.base_color = [r, g, b, 1.0];
            material.specular = [1.0; 3];
            material.ior = self.ior.unwrap_or(1.5).clamp(1.0, 10.0);
            material.roughness = 0.0;
            material.transmission = 1.0;
        } else if is_mirror && self.metallic.is_none() {
            let [r, g, b] = specular;
            material.base_color = [r, g, b, material.base_color[3]];
            material.metallic = 1.0;
            material.roughness = 0.0;
        } else if has_gloss && !is_matt {
            // Phong's Ks is often far above what a dielectric reflects head-on: its hue counts, and less than full gloss.
            let scale = 1.0 / brightest.max(GLOSS);
            material.specular = specular.map(|ks| saturate(ks * scale));
            let exponent = self.exponent.unwrap_or(0.0).max(0.0);
            material.roughness = (2.0 / (exponent + 2.0)).sqrt().sqrt();
        }
        if self.alpha_map.is_some() {
            material.alpha = Alpha::Mask { cutoff: 0.5 };
        } else if material.base_color[3] < 1.0 {
            material.alpha = Alpha::Blend;
        }
        if let Some(roughness) = self.roughness {
            material.roughness = saturate(roughness);
        }
        if let Some(metallic) = self.metallic {
            material.metallic = saturate(metallic);
        }
        material
    }
}

/// The colour beside a map. Exporters write black, or nothing, where only the map is meant.
fn factor(color: Option<[f32; 3]>, map: &Option<TextureMap>, default: [f32; 3]) -> [f32; 3] {
    match (color, map) {
        (None | Some([0.0, 0.0, 0.0]), Some(_)) => [1.0; 3],
        (color, _) => color.unwrap_or(default),
    }
}

fn set(slot: &mut Option<TextureMap>, texture: Option<(TextureMap, f32)>) {
    *slot = texture.map(|(texture, _)| texture);
}

fn saturate(value: f32) -> f32 {
    value.clamp(0.0, 1.0)
}

fn number(cursor: &mut Cursor) -> Result<f32, String> {
    match cursor.number() {
        Some(value) if value.is_finite() => Ok(value),
        _ => Err(match cursor.peek_word() {
            [] => "a finite number was expected".to_owned(),
            word => format!("a finite number was expected, but {} follows", quoted(word)),
        }),
    }
}

/// `r g b`, or `r` for all three.
fn color(cursor: &mut Cursor) -> Result<[f32; 3], String> {
    if matches!(cursor.peek_word(), b"spectral" | b"xyz") {
        let kind = quoted(cursor.word());
        return Err(format!("{kind} colours are not supported"));
    }
    let red = number(cursor)?;
    if !cursor.skip_blanks() {
        return Ok([red; 3]);
    }
    Ok([red, number(cursor)?, number(cursor)?])
}

#[cfg(test)]
mod tests;
