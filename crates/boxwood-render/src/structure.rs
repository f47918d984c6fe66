//! All structures over meshes and over instances, compiled once for everything that is built on this crate.

use boxwood::{BuildError, Instances, Intersect, Limits, StructureKind, TriangleMesh};
use std::sync::Arc;

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

/// The same, of a structure that keeps its mesh.
pub(crate) fn over_mesh(kind: StructureKind, mesh: &Arc<TriangleMesh>) -> Arc<dyn Intersect> {
    Arc::from(kind.build(mesh.clone()))
}

/// The same, of a structure over instances.
pub(crate) fn over_instances(
    kind: StructureKind,
    instances: &Arc<Instances>,
) -> Arc<dyn Intersect> {
    Arc::from(kind.build(instances.clone()))
}
