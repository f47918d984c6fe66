//! The JSON of a glTF file as plain structures: what Boxwood reads of it, and nothing else.
//!
//! *How it works.* `serde` fills the structures and checks types; unknown keys (`extras`, foreign extensions) are
//! passed over. Indices are not checked here but where they are followed, so that the error can say who named what.
//! [`Rows`] keeps hostile files small: an object that says nothing takes eight bytes instead of its structure.
//!
//! *Source.* glTF 2.0 specification (ISO/IEC 12113:2022) and the registry's `KHR_*` extensions.

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// A whole number; JSON may write it as `3` or as `3.0`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole<T>(pub T);

/// The number of an entry in one of the file's tables.
pub type Index = Whole<u32>;

impl<'de, T: TryFrom<u64>> Deserialize<'de> for Whole<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WholeVisitor<T>(PhantomData<T>);
        impl<T: TryFrom<u64>> Visitor<'_> for WholeVisitor<T> {
            type Value = Whole<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number that is not negative")
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<Whole<T>, E> {
                T::try_from(value)
                    .map(Whole)
                    .map_err(|_| E::custom(format_args!("{value} is too large")))
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Whole<T>, E> {
                // 2^53: beyond it, not every whole number is a float.
                if value.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&value) {
                    self.visit_u64(value as u64)
                } else {
                    Err(E::invalid_value(serde::de::Unexpected::Float(value), &self))
                }
            }
        }
        deserializer.deserialize_u64(WholeVisitor(PhantomData))
    }
}

/// A table of objects, many of which may be empty.
#[derive(Debug)]
pub struct Rows<T> {
    rows: Vec<Option<Box<T>>>,
    empty: T,
}

impl<T: Default> Default for Rows<T> {
    fn default() -> Self {
        Self {
            rows: Vec::new(),
            empty: T::default(),
        }
    }
}

impl<T> Rows<T> {
    pub fn len(&self) -> usize {
        self.rows.len()
    }
    pub fn get(&self, index: usize) -> Option<&T> {
        Some(self.rows.get(index)?.as_deref().unwrap_or(&self.empty))
    }
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.rows
            .iter()
            .map(|row| row.as_deref().unwrap_or(&self.empty))
    }
}

impl<'de, T: Deserialize<'de> + Default + PartialEq> Deserialize<'de> for Rows<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct RowsVisitor<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + Default + PartialEq> Visitor<'de> for RowsVisitor<T> {
            type Value = Rows<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an array of objects")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Rows<T>, A::Error> {
                let mut table = Rows::default();
                while let Some(row) = seq.next_element::<T>()? {
                    let says_nothing = row == table.empty;
                    table.rows.push((!says_nothing).then(|| Box::new(row)));
                }
                Ok(table)
            }
        }
        deserializer.deserialize_seq(RowsVisitor(PhantomData))
    }
}

/// Writes the structures: all share the derives and the camel case, and differ in whether keys may be absent.
macro_rules! objects {
    ($($(#[$meta:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident: $kind:ty,)* })*) => {$(
        #[derive(Debug, PartialEq, serde::Deserialize)]
        $(#[$meta])*
        #[serde(rename_all = "camelCase", expecting = "an object")]
        pub struct $name { $($(#[$field_meta])* pub $field: $kind,)* }
    )*};
}

/// The part that is read before the rest: glTF 1.0 has other types everywhere.
#[derive(Debug, serde::Deserialize)]
#[serde(expecting = "an object with `asset`")]
pub struct Head {
    pub asset: Asset,
}

#[derive(Debug, serde::Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object with `version`")]
pub struct Asset {
    pub version: String,
    pub min_version: Option<String>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(rename_all = "camelCase", default, expecting = "an object")]
pub struct Root {
    pub scene: Option<Index>,
    pub scenes: Rows<Scene>,
    pub nodes: Rows<Node>,
    pub meshes: Vec<Mesh>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub materials: Rows<Material>,
    pub textures: Rows<Texture>,
    pub samplers: Rows<Sampler>,
    pub images: Rows<Image>,
    pub cameras: Vec<Camera>,
    pub skins: Vec<Skin>,
    pub extensions: RootExtensions,
    pub extensions_used: Vec<Box<str>>,
    pub extensions_required: Vec<Box<str>>,
}

objects! {
    #[derive(Default)] #[serde(default)]
    RootExtensions {
        #[serde(rename = "KHR_lights_punctual")]
        lights: Option<Lights>,
    }
    Lights { lights: Vec<Light>, }
    #[derive(Default)] #[serde(default)]
    Scene {
        name: Box<str>,
        nodes: Box<[Index]>,
    }
    #[derive(Default)] #[serde(default)]
    Node {
        name: Box<str>,
        children: Box<[Index]>,
        mesh: Option<Index>,
        camera: Option<Index>,
        skin: Option<Index>,
        matrix: Option<Box<[f64; 16]>>,
        translation: Option<Box<[f64; 3]>>,
        rotation: Option<Box<[f64; 4]>>,
        scale: Option<Box<[f64; 3]>>,
        weights: Box<[f64]>,
        extensions: Option<Box<NodeExtensions>>,
    }
    #[derive(Default)] #[serde(default)]
    NodeExtensions {
        #[serde(rename = "KHR_lights_punctual")]
        light: Option<NodeLight>,
    }
    NodeLight { light: Index, }
    Mesh {
        #[serde(default)]
        name: Box<str>,
        primitives: Box<[Primitive]>,
        #[serde(default)]
        weights: Box<[f64]>,
    }
    Primitive {
        attributes: Attributes,
        indices: Option<Index>,
        material: Option<Index>,
        mode: Option<Index>,
        #[serde(default)]
        targets: Box<[Target]>,
    }
    #[derive(Default)] #[serde(default)]
    Attributes {
        #[serde(rename = "POSITION")]
        position: Option<Index>,
        #[serde(rename = "NORMAL")]
        normal: Option<Index>,
        #[serde(rename = "TANGENT")]
        tangent: Option<Index>,
        #[serde(rename = "TEXCOORD_0")]
        texcoord_0: Option<Index>,
        #[serde(rename = "TEXCOORD_1")]
        texcoord_1: Option<Index>,
        #[serde(rename = "COLOR_0")]
        color_0: Option<Index>,
        #[serde(rename = "JOINTS_0")]
        joints_0: Option<Index>,
        #[serde(rename = "WEIGHTS_0")]
        weights_0: Option<Index>,
        #[serde(rename = "JOINTS_1")]
        joints_1: Option<Index>,
        #[serde(rename = "WEIGHTS_1")]
        weights_1: Option<Index>,
    }
    #[derive(Default)] #[serde(default)]
    Target {
        #[serde(rename = "POSITION")]
        position: Option<Index>,
        #[serde(rename = "NORMAL")]
        normal: Option<Index>,
    }
    Accessor {
        buffer_view: Option<Index>,
        byte_offset: Option<Whole<u64>>,
        component_type: Index,
        #[serde(default)]
        normalized: bool,
        count: Whole<u64>,
        #[serde(rename = "type")]
        kind: ElementKind,
        sparse: Option<Box<Sparse>>,
    }
    Sparse {
        count: Whole<u64>,
        indices: SparseIndices,
        values: SparseValues,
    }
    SparseIndices {
        buffer_view: Index,
        byte_offset: Option<Whole<u64>>,
        component_type: Index,
    }
    SparseValues {
        buffer_view: Index,
        byte_offset: Option<Whole<u64>>,
    }
    BufferView {
        buffer: Index,
        byte_offset: Option<Whole<u64>>,
        byte_length: Whole<u64>,
        byte_stride: Option<Whole<u32>>,
    }
    Buffer {
        uri: Option<Box<str>>,
        byte_length: Whole<u64>,
    }
    #[derive(Default)] #[serde(default)]
    Image {
        name: Box<str>,
        uri: Option<Box<str>>,
        buffer_view: Option<Index>,
    }
    #[derive(Default)] #[serde(default)]
    Texture {
        source: Option<Index>,
        sampler: Option<Index>,
        extensions: Option<Box<TextureExtensions>>,
    }
    #[derive(Default)] #[serde(default)]
    TextureExtensions {
        #[serde(rename = "EXT_texture_webp")]
        webp: Option<TextureSource>,
    }
    TextureSource { source: Option<Index>, }
    #[derive(Default)] #[serde(default)]
    Sampler {
        mag_filter: Option<Index>,
        wrap_s: Option<Index>,
        wrap_t: Option<Index>,
    }
    TextureInfo {
        index: Index,
        tex_coord: Option<Index>,
        /// Only of normal textures.
        scale: Option<f64>,
        extensions: Option<Box<TextureInfoExtensions>>,
    }
    #[derive(Default)] #[serde(default)]
    TextureInfoExtensions {
        #[serde(rename = "KHR_texture_transform")]
        transform: Option<TextureTransform>,
    }
    #[derive(Default)] #[serde(default)]
    TextureTransform {
        offset: Option<[f64; 2]>,
        rotation: Option<f64>,
        scale: Option<[f64; 2]>,
        tex_coord: Option<Index>,
    }
    #[derive(Default)] #[serde(default)]
    Material {
        name: Box<str>,
        #[serde(rename = "pbrMetallicRoughness")]
        metallic_roughness: Option<Box<MetallicRoughness>>,
        normal_texture: Option<Box<TextureInfo>>,
        emissive_texture: Option<Box<TextureInfo>>,
        emissive_factor: Option<Box<[f64; 3]>>,
        alpha_mode: AlphaMode,
        alpha_cutoff: Option<f64>,
        double_sided: bool,
        extensions: Option<Box<MaterialExtensions>>,
    }
    #[derive(Default)] #[serde(default)]
    MetallicRoughness {
        base_color_factor: Option<[f64; 4]>,
        base_color_texture: Option<TextureInfo>,
        metallic_factor: Option<f64>,
        roughness_factor: Option<f64>,
        metallic_roughness_texture: Option<TextureInfo>,
    }
    #[derive(Default)] #[serde(default)]
    MaterialExtensions {
        #[serde(rename = "KHR_materials_unlit")]
        unlit: Option<Unlit>,
        #[serde(rename = "KHR_materials_transmission")]
        transmission: Option<Transmission>,
        #[serde(rename = "KHR_materials_ior")]
        ior: Option<Ior>,
        #[serde(rename = "KHR_materials_emissive_strength")]
        emissive_strength: Option<EmissiveStrength>,
        #[serde(rename = "KHR_materials_volume")]
        volume: Option<Volume>,
        #[serde(rename = "KHR_materials_specular")]
        specular: Option<Specular>,
        #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
        specular_glossiness: Option<Box<SpecularGlossiness>>,
    }
    #[derive(Default)] #[serde(default)]
    Unlit {}
    #[derive(Default)] #[serde(default)]
    Transmission {
        transmission_factor: f64,
        transmission_texture: Option<TextureInfo>,
    }
    #[derive(Default)] #[serde(default)]
    Ior { ior: Option<f64>, }
    #[derive(Default)] #[serde(default)]
    EmissiveStrength { emissive_strength: Option<f64>, }
    #[derive(Default)] #[serde(default)]
    Volume {
        thickness_factor: f64,
        attenuation_distance: Option<f64>,
        attenuation_color: Option<[f64; 3]>,
    }
    #[derive(Default)] #[serde(default)]
    Specular {
        specular_factor: Option<f64>,
        specular_color_factor: Option<[f64; 3]>,
        specular_texture: Option<TextureInfo>,
        specular_color_texture: Option<TextureInfo>,
    }
    #[derive(Default)] #[serde(default)]
    SpecularGlossiness {
        diffuse_factor: Option<[f64; 4]>,
        diffuse_texture: Option<TextureInfo>,
        glossiness_factor: Option<f64>,
    }
    Camera {
        #[serde(default)]
        name: Box<str>,
        #[serde(rename = "type")]
        kind: CameraKind,
        perspective: Option<Perspective>,
        orthographic: Option<Orthographic>,
    }
    Perspective { yfov: f64, }
    Orthographic { ymag: f64, }
    Light {
        #[serde(default)]
        name: Box<str>,
        #[serde(rename = "type")]
        kind: LightKind,
        color: Option<[f64; 3]>,
        intensity: Option<f64>,
        range: Option<f64>,
        spot: Option<Spot>,
    }
    #[derive(Default)] #[serde(default)]
    Spot {
        inner_cone_angle: Option<f64>,
        outer_cone_angle: Option<f64>,
    }
    Skin {
        inverse_bind_matrices: Option<Index>,
        joints: Box<[Index]>,
    }
}

/// How many numbers an accessor's element has, and how they are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum ElementKind {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl ElementKind {
    /// How many numbers.
    pub fn lanes(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 | Self::Mat2 => 4,
            Self::Mat3 => 9,
            Self::Mat4 => 16,
        }
    }
    /// As the file writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "SCALAR",
            Self::Vec2 => "VEC2",
            Self::Vec3 => "VEC3",
            Self::Vec4 => "VEC4",
            Self::Mat2 => "MAT2",
            Self::Mat3 => "MAT3",
            Self::Mat4 => "MAT4",
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum AlphaMode {
    #[default]
    Opaque,
    Mask,
    Blend,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraKind {
    Perspective,
    Orthographic,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightKind {
    Point,
    Spot,
    Directional,
}
