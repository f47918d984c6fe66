//! Stanford PLY: tables of vertices and faces after a header that says how they are written.
//!
//! *How it works.* [`header`] reads what the file promises and refuses what its bytes cannot hold. The rows are words
//! ([`ascii`]) or packed numbers ([`binary`]); both fill [`vertices`] and [`faces`] and pass over whatever else the
//! file holds. An ascii row is a line: a line that is too short is an error, since the values after it would all mean
//! something else; surplus values at its end are ignored with a warning.
//!
//! Texture coordinates have `v` upwards and are turned; colours of 8 or 16 bits are sRGB and become linear, colours in
//! floats are linear already. Normals are made unit vectors.
//!
//! *Cost.* Linear in the bytes; memory within a small multiple of them.
//!
//! *Source.* Turk 1994, "The PLY Polygon File Format"; names of properties as common writers have them.

mod ascii;
mod binary;
mod faces;
mod header;
mod scalar;
mod vertices;

use super::Source;
use super::file::{File, scene_of};
use crate::error::Place;
use crate::{Mesh, Scene, SceneError};
use ascii::Ascii;
use binary::Binary;
use faces::{FacePlan, Faces, RESTART, Shape};
use header::{Element, Encoding, Header};
use vertices::{VertexPlan, Vertices};

/// Reads a scene: one mesh, or none where the file has no faces.
pub fn read(bytes: &[u8], source: Source<'_>) -> Result<Scene, SceneError> {
    let file = File::new(bytes, source);
    let header = Header::read(&file)?;
    match header.encoding {
        Encoding::Ascii => read_body(file, &header, Ascii::new(file, header.end)),
        Encoding::LittleEndian => read_body(file, &header, Binary::<false>::new(file, header.end)),
        Encoding::BigEndian => read_body(file, &header, Binary::<true>::new(file, header.end)),
    }
}

/// The rows after the header, however they are written. Every method begins where the last one stopped.
trait Rows {
    /// How far the file has been read.
    fn at(&self) -> usize;
    /// Goes back to where [`Rows::at`] has been.
    fn seek(&mut self, at: usize);
    /// Reads the rows of the vertex element.
    fn vertices(&mut self, element: &Element, plan: &VertexPlan) -> Result<Vertices, SceneError>;
    /// Reads the rows of an element of faces.
    fn faces(
        &mut self,
        element: &Element,
        plan: &FacePlan,
        positions: &[[f32; 3]],
        faces: &mut Faces,
    ) -> Result<(), SceneError>;
    /// Passes an element over.
    fn skip(&mut self, element: &Element) -> Result<(), SceneError>;
    /// Complains about what has been ignored and what is left.
    fn finish(self, warnings: &mut Vec<String>);
}

fn read_body(file: File<'_>, header: &Header, mut rows: impl Rows) -> Result<Scene, SceneError> {
    let vertex = header.element(&file, "vertex")?;
    let vertex_count = vertex.map_or(0, |i| header.elements[i].count);
    if vertex_count >= RESTART as usize {
        let line = vertex.map_or(0, |i| header.elements[i].line);
        return Err(SceneError::Unsupported {
            file: file.name.to_owned(),
            place: Place::Line(line),
            what: format!(
                "a mesh of {vertex_count} vertices (more than {})",
                RESTART - 1
            ),
        });
    }
    let plan = |index: Option<usize>, shape: Shape| match index {
        Some(i) => FacePlan::new(&file, &header.elements[i], shape, vertex_count)
            .map(|plan| plan.map(|plan| (i, plan))),
        None => Ok(None),
    };
    let plans = [
        plan(header.element(&file, "face")?, Shape::Polygon)?,
        plan(header.element(&file, "tristrips")?, Shape::Strips)?,
    ];

    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    // Faces wait for the vertices where they come first in the file: polygons are cut by their shape.
    let mut waiting = Vec::new();
    let mut vertices_wait = vertex.is_some();
    for (index, element) in header.elements.iter().enumerate() {
        let face_plan = plans.iter().flatten().find(|(i, _)| *i == index);
        if vertex == Some(index) {
            let plan = VertexPlan::new(&file, element)?;
            vertices = rows.vertices(element, &plan)?;
            vertices_wait = false;
        } else if let Some((_, plan)) = face_plan {
            if vertices_wait {
                waiting.push((rows.at(), element, plan));
                rows.skip(element)?;
            } else {
                rows.faces(element, plan, &vertices.positions, &mut faces)?;
            }
        } else {
            rows.skip(element)?;
        }
    }
    let end = rows.at();
    for (at, element, plan) in waiting {
        rows.seek(at);
        rows.faces(element, plan, &vertices.positions, &mut faces)?;
    }
    rows.seek(end);

    let mut warnings = Vec::new();
    rows.finish(&mut warnings);
    warnings.extend(faces.warning(&file));
    if faces.triangles.is_empty() && faces.skipped.is_none() {
        warnings.push(file.warning(
            Place::File,
            match vertex_count {
                0 => "the file has neither vertices nor faces: nothing to show".to_owned(),
                n => format!("a point cloud: {n} vertices without a face, nothing to show"),
            },
        ));
    }
    vertices.repair_normals(&faces.triangles);
    let mesh = Mesh {
        name: file.stem(),
        positions: vertices.positions,
        triangles: faces.triangles,
        normals: vertices.normals,
        uvs: vertices.uvs,
        colors: vertices.colors,
        smooth: true,
        ..Mesh::default()
    };
    let meshes = Some(mesh).filter(|mesh| !mesh.triangles.is_empty());
    Ok(scene_of(meshes.into_iter().collect(), warnings))
}
