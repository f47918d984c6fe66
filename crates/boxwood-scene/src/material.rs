//! One small material model for every format.

/// What a surface looks like: metallic-roughness with clear dielectrics, which holds what OBJ and glTF can say.
///
/// A map multiplies the factor beside it. Colours are linear RGB; colour maps are stored in sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The file's name for it; may be empty.
    pub name: String,
    /// Diffuse colour of a dielectric, reflectance of a metal; alpha last.
    pub base_color: [f32; 4],
    /// sRGB colour with alpha.
    pub base_color_map: Option<TextureMap>,
    /// What alpha means.
    pub alpha: Alpha,
    /// Coverage from an image of its own (OBJ `map_d`): its alpha where it has one, else its brightness.
    pub alpha_map: Option<TextureMap>,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness: 0 is a mirror, 1 is matt.
    pub roughness: f32,
    /// Linear: green is roughness, blue is metallic.
    pub metallic_roughness_map: Option<TextureMap>,
    /// Multiplies the Fresnel reflectance at normal incidence of a dielectric; 0 takes all gloss away.
    pub specular: [f32; 3],
    /// Index of refraction of a dielectric.
    pub ior: f32,
    /// The share of light that enters a dielectric and goes through instead of scattering back.
    pub transmission: f32,
    /// Linear: red is transmission.
    pub transmission_map: Option<TextureMap>,
    /// The colour that white light has after `attenuation_distance` inside (Beer's law).
    pub attenuation_color: [f32; 3],
    /// In world units; infinite means that nothing is absorbed.
    pub attenuation_distance: f32,
    /// Whether the surface is a sheet without inside: what passes through is not bent (glTF without volume).
    pub thin: bool,
    /// Emitted radiance, strength included.
    pub emissive: [f32; 3],
    /// sRGB colour.
    pub emissive_map: Option<TextureMap>,
    /// Linear: tangent-space normal, x right, y up (as in glTF).
    pub normal_map: Option<TextureMap>,
    /// Multiplies x and y of the normal map.
    pub normal_scale: f32,
    /// Whether the back is shaded like the front; single-sided surfaces are not seen from behind by glTF's rules,
    /// but renderers may show them.
    pub double_sided: bool,
    /// Show the base colour as it is, without any light.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [0.8, 0.8, 0.8, 1.0],
            base_color_map: None,
            alpha: Alpha::Opaque,
            alpha_map: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_map: None,
            specular: [1.0; 3],
            ior: 1.5,
            transmission: 0.0,
            transmission_map: None,
            attenuation_color: [1.0; 3],
            attenuation_distance: f32::INFINITY,
            thin: false,
            emissive: [0.0; 3],
            emissive_map: None,
            normal_map: None,
            normal_scale: 1.0,
            double_sided: true,
            unlit: false,
        }
    }
}

/// What a material's alpha means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Nothing: the surface is solid.
    #[default]
    Opaque,
    /// Where alpha is below the cutoff there is no surface.
    Mask {
        /// Usually 0.5.
        cutoff: f32,
    },
    /// Alpha is coverage: the rest of the ray goes on.
    Blend,
}

/// An image laid over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMap {
    /// Index in [`Scene::images`](crate::Scene::images).
    pub image: u32,
    /// Which texture coordinates: 0 or 1.
    pub uv_set: u8,
    /// Applied to `(u, v, 1)` before the look-up, rows of a 2 × 3 matrix.
    pub transform: [[f32; 3]; 2],
    /// What lies beyond 0 and 1 along u and v.
    pub wrap: [Wrap; 2],
    /// Whether texels blend into each other; `false` shows them as squares.
    pub smooth: bool,
}

impl TextureMap {
    /// The whole image once over the unit square of the first coordinates, repeated.
    pub fn new(image: u32) -> Self {
        Self {
            image,
            uv_set: 0,
            transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            wrap: [Wrap::Repeat; 2],
            smooth: true,
        }
    }
}

/// What lies beyond the edge of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored.
    Mirror,
    /// Its last texel.
    Clamp,
}
