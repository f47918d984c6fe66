//! Mesh primitives: triangles with their attributes.
//!
//! *How it works.* Corners become triangles, vertices that no triangle names fall away, and only then are the
//! attributes of the others read: primitives that share one long list of vertices cost what they use.
//!
//! *Source.* glTF 2.0, section 3.7, *Geometry*.

use super::accessors::{Accessor, Component};
use super::deform::Deformation;
use super::file::File;
use super::matrix::unit;
use super::normals;
use super::schema::{ElementKind, Index, Primitive};
use super::topology::{Mode, compact};
use crate::{Mesh, SceneError};

/// A primitive, and where it stands in the file.
#[derive(Clone, Copy)]
pub struct Place<'f> {
    pub mesh: usize,
    pub number: usize,
    pub primitive: &'f Primitive,
}

impl Place<'_> {
    pub fn path(&self, key: &str) -> String {
        format!("meshes[{}].primitives[{}]{key}", self.mesh, self.number)
    }
}

/// Reads a primitive; `None` when it has no triangles. The material is left at 0.
pub fn read(
    file: &File<'_>,
    place: Place<'_>,
    deformation: &Deformation<'_>,
) -> Result<Option<Mesh>, SceneError> {
    let said = place.primitive;
    let mode = match said.mode.map_or(4, |mode| mode.0) {
        0..=3 => {
            file.warn(place.path(""), "points and lines are left out");
            return Ok(None);
        }
        4 => Mode::Triangles,
        5 => Mode::Strip,
        6 => Mode::Fan,
        other => {
            let problem = format!("mode {other} is not known; 0 to 6 expected");
            return Err(file.malformed(place.path(".mode"), problem));
        }
    };
    let Some(position) = said.attributes.position else {
        file.warn(
            place.path(".attributes"),
            "a primitive without POSITION is left out",
        );
        return Ok(None);
    };
    let kinds = [ElementKind::Vec3];
    let positions = file.accessor(position, &kinds, || place.path(".attributes.POSITION"))?;

    let mut triangles = triangles(file, place, mode, positions.count)?;
    if triangles.is_empty() {
        file.warn(place.path(""), "a primitive without triangles is left out");
        return Ok(None);
    }
    let vertices = compact(&mut triangles, positions.count);
    let attributes = Attributes {
        file,
        place,
        count: positions.count,
        vertices: &vertices,
    };
    let mut mesh = Mesh {
        positions: attributes.gather(&positions, |v| positions.floats(v))?,
        triangles,
        ..Mesh::default()
    };
    if let Some(flaw) = mesh.positions.iter().position(|p| !is_finite(p)) {
        return Err(not_finite(
            file,
            &positions,
            vertices[flaw],
            mesh.positions[flaw],
        ));
    }
    attributes.read_into(&mut mesh)?;
    deformation.apply(&attributes, &mut mesh)?;
    if let Some(flaw) = mesh.positions.iter().position(|p| !is_finite(p)) {
        let problem = format!(
            "vertex {} leaves the range of numbers when it is deformed",
            vertices[flaw]
        );
        return Err(file.malformed(place.path(""), problem));
    }
    if normals::repair(&mut mesh) {
        file.warn(
            place.path(".attributes.NORMAL"),
            "normals without direction are replaced by those of the triangles",
        );
    }
    Ok(Some(mesh))
}

fn triangles(
    file: &File<'_>,
    place: Place<'_>,
    mode: Mode,
    vertex_count: usize,
) -> Result<Vec<[u32; 3]>, SceneError> {
    let indices = match place.primitive.indices {
        None => None,
        Some(index) => Some(file.whole_accessor(
            index,
            ElementKind::Scalar,
            &[Component::U8, Component::U16, Component::U32],
            || place.path(".indices"),
        )?),
    };
    let corners = indices
        .as_ref()
        .map_or(vertex_count, |indices| indices.count);
    let used = mode.used_corners(corners);
    let count = mode.triangle_count(corners);
    let bytes = (4 * used + size_of::<[u32; 3]>() * count) as u64;
    file.spend(bytes, || place.path(".indices"))?;
    let Some(indices) = indices else {
        return Ok((0..count).map(|i| mode.triangle(i, |c| c as u32)).collect());
    };
    let corners: Vec<u32> = (0..used).map(|c| indices.indices::<1>(c)[0]).collect();
    if let Some(flaw) = corners.iter().position(|&v| v as usize >= vertex_count) {
        let problem = format!(
            "entry {flaw} names vertex {}, but there are only {vertex_count} (counted from 0)",
            corners[flaw]
        );
        return Err(file.malformed(place.path(".indices"), problem));
    }
    Ok((0..count)
        .map(|i| mode.triangle(i, |c| corners[c]))
        .collect())
}

/// The vertices of a primitive, and how to read what belongs to them.
pub struct Attributes<'r, 'a> {
    pub file: &'r File<'a>,
    pub place: Place<'r>,
    /// How many vertices the file has, …
    pub count: usize,
    /// … and which of them are wanted.
    pub vertices: &'r [u32],
}

impl<'r> Attributes<'r, '_> {
    /// An attribute's accessor, as long as the positions.
    pub fn accessor(
        &self,
        index: Option<Index>,
        kinds: &[ElementKind],
        key: &str,
    ) -> Result<Option<Accessor<'r>>, SceneError> {
        let Some(index) = index else {
            return Ok(None);
        };
        let accessor = self.file.accessor(index, kinds, || self.place.path(key))?;
        if accessor.count < self.count {
            let problem = format!(
                "has {} elements, but POSITION has {}",
                accessor.count, self.count
            );
            return Err(self.file.malformed(self.place.path(key), problem));
        }
        Ok(Some(accessor))
    }

    /// One value for each wanted vertex.
    pub fn gather<T>(
        &self,
        accessor: &Accessor<'_>,
        value: impl Fn(usize) -> T,
    ) -> Result<Vec<T>, SceneError> {
        let bytes = (self.vertices.len() * size_of::<T>()) as u64;
        let path = || format!("accessors[{}].count", accessor.number);
        self.file.spend(bytes, path)?;
        Ok(self.vertices.iter().map(|&v| value(v as usize)).collect())
    }

    fn read_into(&self, mesh: &mut Mesh) -> Result<(), SceneError> {
        use ElementKind::{Vec2, Vec3, Vec4};
        let said = &self.place.primitive.attributes;
        if let Some(normals) = self.accessor(said.normal, &[Vec3], ".attributes.NORMAL")? {
            // What has no direction becomes NaN here, and is repaired when the mesh is complete.
            let value = |v| direction(normals.numbers(v)).unwrap_or([f32::NAN; 3]);
            mesh.normals = self.gather(&normals, value)?;
        }
        if let Some(tangents) = self.accessor(said.tangent, &[Vec4], ".attributes.TANGENT")? {
            let value = |v| {
                let [x, y, z, w] = tangents.numbers(v);
                let [x, y, z] = direction([x, y, z]).unwrap_or([f32::NAN; 3]);
                [x, y, z, if w < 0.0 { -1.0 } else { 1.0 }]
            };
            mesh.tangents = self.gather(&tangents, value)?;
            if mesh.tangents.iter().any(|t| t[0].is_nan()) {
                let path = self.place.path(".attributes.TANGENT");
                self.file
                    .warn(path, "tangents without direction are left out");
                mesh.tangents = Vec::new();
            }
        }
        let sets = [
            (said.texcoord_0, ".attributes.TEXCOORD_0", &mut mesh.uvs),
            (said.texcoord_1, ".attributes.TEXCOORD_1", &mut mesh.uvs1),
        ];
        for (index, key, uvs) in sets {
            if let Some(accessor) = self.accessor(index, &[Vec2], key)? {
                *uvs = self.gather(&accessor, |v| accessor.floats(v).map(finite_or_zero))?;
            }
        }
        if let Some(mut colors) =
            self.accessor(said.color_0, &[Vec3, Vec4], ".attributes.COLOR_0")?
        {
            // Whole numbers must be normalised here; some writers forget to say so.
            colors.normalized = colors.component != Component::F32;
            let value = |v| {
                let mut color = colors.floats(v).map(finite_or_zero);
                if colors.kind == Vec3 {
                    color[3] = 1.0;
                }
                color
            };
            mesh.colors = self.gather(&colors, value)?;
        }
        Ok(())
    }
}

fn not_finite(file: &File<'_>, positions: &Accessor<'_>, vertex: u32, p: [f32; 3]) -> SceneError {
    let problem = format!(
        "position {vertex} is {} {} {}; finite numbers expected",
        p[0], p[1], p[2]
    );
    file.malformed(format!("accessors[{}]", positions.number), problem)
}

fn is_finite(p: &[f32; 3]) -> bool {
    p.iter().all(|x| x.is_finite())
}

fn finite_or_zero(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}

fn direction(v: [f64; 3]) -> Option<[f32; 3]> {
    Some(unit(v)?.map(|x| x as f32))
}
