//! All structures over meshes, compiled once for everything that is built on this crate.

use boxwood::{BuildError, Intersect, Limits, StructureKind, TriangleMesh};

/// [`StructureKind::build_within`] over a mesh.
///
/// That function is generic: each crate that calls it compiles all the structures again, for minutes. This one is not.
///
/// # Errors
/// When the limits end the build.
pub fn build_structure<'a>(
    kind: StructureKind,
    mesh: &'a TriangleMesh,
    limits: &Limits<'_>,
) -> Result<Box<dyn Intersect + 'a>, BuildError> {
    kind.build_within(mesh, limits)
}
