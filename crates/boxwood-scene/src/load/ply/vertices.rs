//! Vertices: which properties of the file mean what, and the attributes they become.

use super::header::{Element, Kind};
use super::scalar::Scalar;
use crate::SceneError;
use crate::error::Place;
use crate::load::file::File;
use std::sync::LazyLock;

/// The numbers of a vertex that Boxwood has a use for, in the order of [`Row`]: each under the names that writers
/// give it.
const NAMES: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &[
        "u",
        "s",
        "texture_u",
        "texture_s",
        "texcoord_u",
        "texcoord_s",
    ],
    &[
        "v",
        "t",
        "texture_v",
        "texture_t",
        "texcoord_v",
        "texcoord_t",
    ],
    &["red", "diffuse_red"],
    &["green", "diffuse_green"],
    &["blue", "diffuse_blue"],
    &["alpha", "diffuse_alpha"],
];

/// A vertex as the file has it: position, normal, texture coordinates, colour.
pub type Row = [f32; 12];

/// Where positions begin in a [`Row`], and so on.
const NORMAL: usize = 3;
const UV: usize = 6;
const COLOR: usize = 8;
const ALPHA: usize = 11;

/// What the properties of the vertex element mean.
#[derive(Debug)]
pub struct VertexPlan {
    /// For each number of a [`Row`], the property that holds it.
    pub properties: [Option<usize>; 12],
    /// For each property, the number of a [`Row`] that it holds.
    pub slots: Vec<Option<u8>>,
    /// How red, green, blue and alpha are written.
    scales: [Scale; 4],
}

/// How a colour is written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    /// Linear, 1 is white.
    Linear,
    /// sRGB, 255 is white.
    Bytes,
    /// sRGB, 65535 is white.
    Shorts,
}

impl VertexPlan {
    /// Finds the properties that have a meaning. A group (normal, colour ...) counts if it is complete.
    ///
    /// # Errors
    /// When vertices have no position, or the meaning is said twice.
    pub fn new(file: &File<'_>, element: &Element) -> Result<Self, SceneError> {
        let mut properties = [None; 12];
        for (found, names) in properties.iter_mut().zip(NAMES) {
            for name in names {
                let property = element.property(file, name)?;
                let is_scalar = |i: &usize| matches!(element.properties[*i].kind, Kind::Scalar(_));
                *found = found.or(property.filter(is_scalar));
            }
        }
        for (name, found) in ["x", "y", "z"].iter().zip(properties) {
            if found.is_none() && element.count > 0 {
                return Err(file.error(
                    Place::Line(element.line),
                    format!("element `vertex` has no number `{name}`; expected x, y and z"),
                ));
            }
        }
        for group in [0..NORMAL, NORMAL..UV, UV..COLOR, COLOR..ALPHA] {
            if properties[group.clone()].iter().any(Option::is_none) {
                properties[group].fill(None);
            }
        }
        if properties[COLOR].is_none() {
            properties[ALPHA] = None;
        }
        let mut slots = vec![None; element.properties.len()];
        for (slot, property) in properties.iter().enumerate() {
            if let Some(property) = property {
                slots[*property] = Some(slot as u8);
            }
        }
        let scale = |channel: usize| match properties[COLOR + channel]
            .map(|property| element.properties[property].kind)
        {
            None | Some(Kind::Scalar(Scalar::F32 | Scalar::F64)) => Scale::Linear,
            Some(Kind::Scalar(Scalar::U16)) => Scale::Shorts,
            Some(_) => Scale::Bytes,
        };
        Ok(Self {
            properties,
            slots,
            scales: [0, 1, 2, 3].map(scale),
        })
    }

    /// The row before anything is read into it.
    pub fn empty_row(&self) -> Row {
        let mut row = [0.0; 12];
        row[ALPHA] = 1.0;
        row
    }

    fn has(&self, slot: usize) -> bool {
        self.properties[slot].is_some()
    }
}

/// The attributes of all vertices, in the form of [`Mesh`](crate::Mesh).
#[derive(Debug, Default)]
pub struct Vertices {
    /// Positions.
    pub positions: Vec<[f32; 3]>,
    /// Normals as the file has them, or none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, `v` downwards, or none.
    pub uvs: Vec<[f32; 2]>,
    /// Linear colours, or none.
    pub colors: Vec<[f32; 4]>,
}

impl Vertices {
    /// Makes room for `count` vertices: the file has been found to be large enough for them.
    pub fn reserve(&mut self, plan: &VertexPlan, count: usize) {
        self.positions.reserve_exact(count);
        if plan.has(NORMAL) {
            self.normals.reserve_exact(count);
        }
        if plan.has(UV) {
            self.uvs.reserve_exact(count);
        }
        if plan.has(COLOR) {
            self.colors.reserve_exact(count);
        }
    }

    /// Adds a vertex; its position is not finite if this says `false`.
    #[inline]
    pub fn push(&mut self, plan: &VertexPlan, row: &Row) -> bool {
        let position = [row[0], row[1], row[2]];
        self.positions.push(position);
        if plan.has(NORMAL) {
            self.normals.push([row[3], row[4], row[5]]);
        }
        if plan.has(UV) {
            self.uvs.push(uv([row[6], row[7]]));
        }
        if plan.has(COLOR) {
            self.colors
                .push(color([row[8], row[9], row[10], row[11]], &plan.scales));
        }
        is_finite(position)
    }

    /// Takes all vertices attribute by attribute: `gather` gives the columns of some numbers of a [`Row`], where a
    /// column is a property or stands for the number 1.
    pub fn fill(plan: &VertexPlan, gather: &impl Gather) -> Self {
        let p = &plan.properties;
        let mut vertices = Self {
            positions: gather.columns([p[0], p[1], p[2]]),
            ..Self::default()
        };
        if plan.has(NORMAL) {
            vertices.normals = gather.columns([p[3], p[4], p[5]]);
        }
        if plan.has(UV) {
            vertices.uvs = gather.columns([p[6], p[7]]);
            vertices.uvs.iter_mut().for_each(|pair| *pair = uv(*pair));
        }
        if plan.has(COLOR) {
            vertices.colors = gather.columns([p[8], p[9], p[10], p[11]]);
            for rgba in &mut vertices.colors {
                *rgba = color(*rgba, &plan.scales);
            }
        }
        vertices
    }

    /// Makes every normal a unit vector. Where the file's is no direction at all, the faces around the vertex decide.
    pub fn repair_normals(&mut self, triangles: &[[u32; 3]]) {
        let mut lost = false;
        for normal in &mut self.normals {
            let [x, y, z] = normal.map(f64::from);
            let length_squared = x * x + y * y + z * z;
            // What a writer rounded to a unit vector stays as it is.
            let is_unit = (length_squared - 1.0).abs() <= 1e-5;
            if !is_unit {
                match unit([x, y, z]) {
                    Some(direction) => *normal = direction,
                    None => {
                        *normal = [0.0; 3];
                        lost = true;
                    }
                }
            }
        }
        if lost {
            self.replace_lost_normals(triangles);
        }
    }

    /// Gives vertices whose normal is zero the mean of their faces' normals, weighted by area.
    #[cold]
    fn replace_lost_normals(&mut self, triangles: &[[u32; 3]]) {
        let lost: Vec<bool> = self.normals.iter().map(|n| *n == [0.0; 3]).collect();
        let mut sums = vec![[0.0_f64; 3]; self.normals.len()];
        for triangle in triangles {
            let corners = triangle.map(|i| i as usize);
            if !corners.iter().any(|i| lost[*i]) {
                continue;
            }
            let [a, b, c] = corners.map(|i| self.positions[i].map(f64::from));
            let e: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
            let f: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
            let normal: [f64; 3] = std::array::from_fn(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                e[i] * f[j] - e[j] * f[i]
            });
            for corner in corners {
                let sum = sums[corner].iter_mut().zip(normal);
                sum.for_each(|(sum, component)| *sum += component);
            }
        }
        for ((normal, lost), sum) in self.normals.iter_mut().zip(lost).zip(sums) {
            if lost {
                *normal = unit(sum).unwrap_or([0.0, 0.0, 1.0]);
            }
        }
    }
}

/// Gives numbers of all rows at once.
pub trait Gather {
    /// The values of `N` properties in each row, and 1 in place of a missing one.
    fn columns<const N: usize>(&self, properties: [Option<usize>; N]) -> Vec<[f32; N]>;
}

/// What to say about a vertex that stands nowhere.
pub fn not_finite(vertex: usize, position: &[f32; 3]) -> String {
    let [x, y, z] = position;
    format!(
        "vertex {vertex} stands at ({x}, {y}, {z}) in single precision; expected finite coordinates"
    )
}

/// Whether all coordinates are finite.
#[inline]
pub fn is_finite(position: [f32; 3]) -> bool {
    position.iter().all(|c| c.is_finite())
}

fn unit(v: [f64; 3]) -> Option<[f32; 3]> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| (c / length) as f32))
}

/// From `v` upwards to `v` downwards; what is not finite becomes 0.
#[inline]
fn uv([u, v]: [f32; 2]) -> [f32; 2] {
    [u, 1.0 - v].map(|c| if c.is_finite() { c } else { 0.0 })
}

#[inline]
fn color(raw: [f32; 4], scales: &[Scale; 4]) -> [f32; 4] {
    let mut linear = [0.0; 4];
    for channel in 0..4 {
        let (value, is_alpha) = (raw[channel], channel == 3);
        linear[channel] = match scales[channel] {
            Scale::Linear if value.is_finite() => value.max(0.0),
            Scale::Linear => 0.0,
            Scale::Bytes if is_alpha => (value / 255.0).clamp(0.0, 1.0),
            Scale::Shorts if is_alpha => (value / 65535.0).clamp(0.0, 1.0),
            // The cast brings everything into 0..=255.
            Scale::Bytes => LINEAR_OF_BYTE[usize::from(value as u8)],
            Scale::Shorts => linear_of_srgb(value / 65535.0),
        };
    }
    linear
}

static LINEAR_OF_BYTE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_of_srgb(byte as f32 / 255.0)));

/// The sRGB transfer function of IEC 61966-2-1, by the portable maths library.
fn linear_of_srgb(value: f32) -> f32 {
    let value = f64::from(value.clamp(0.0, 1.0));
    if value <= 0.04045 {
        (value / 12.92) as f32
    } else {
        libm::pow((value + 0.055) / 1.055, 2.4) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_become_linear() {
        let bytes = color([0.0, 255.0, 188.0, 51.0], &[Scale::Bytes; 4]);
        assert_eq!(bytes[..2], [0.0, 1.0]);
        assert!((bytes[2] - 0.5029).abs() < 1e-4 && bytes[3] == 0.2);
        let shorts = color([0.0, 65535.0, 48316.0, 13107.0], &[Scale::Shorts; 4]);
        assert!(shorts.iter().zip(bytes).all(|(a, b)| (a - b).abs() < 1e-5));
        let floats = color([0.25, f32::NAN, -1.0, 0.5], &[Scale::Linear; 4]);
        assert_eq!(floats, [0.25, 0.0, 0.0, 0.5]);
    }

    #[test]
    fn lost_normals_come_from_the_faces() {
        let mut vertices = Vertices {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0; 3]],
            normals: vec![[0.0; 3], [f32::NAN, 0.0, 0.0], [0.0, 3.0, 4.0], [0.0; 3]],
            ..Vertices::default()
        };
        vertices.repair_normals(&[[0, 2, 1]]);
        let down = [0.0, 0.0, -1.0];
        assert_eq!(
            vertices.normals,
            [down, down, [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]]
        );
    }
}
