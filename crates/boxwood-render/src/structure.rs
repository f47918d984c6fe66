//! All structures over meshes and over instances, compiled once for everything that is built on this crate.

use crate::shelf::{Shelf, kept_wide8, kept_wide16};
use boxwood::{BuildError, Instances, Intersect, Limits, Primitives, StructureKind, TriangleMesh};
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

/// The same without limits; wide trees come from the shelf, where there is one.
pub fn kept_structure<'a>(
    kind: StructureKind,
    mesh: &'a TriangleMesh,
    shelf: Option<&dyn Shelf>,
) -> Box<dyn Intersect + 'a> {
    built(kind, mesh, shelf)
}

/// The same, of a structure that keeps its mesh.
pub(crate) fn over_mesh(
    kind: StructureKind,
    mesh: &Arc<TriangleMesh>,
    shelf: Option<&dyn Shelf>,
) -> Arc<dyn Intersect> {
    Arc::from(built(kind, mesh.clone(), shelf))
}

/// The same, of a structure over instances.
pub(crate) fn over_instances(
    kind: StructureKind,
    instances: &Arc<Instances>,
    shelf: Option<&dyn Shelf>,
) -> Arc<dyn Intersect> {
    Arc::from(built(kind, instances.clone(), shelf))
}

fn built<'a, P: Primitives + Clone + Send + Sync + 'a>(
    kind: StructureKind,
    primitives: P,
    shelf: Option<&dyn Shelf>,
) -> Box<dyn Intersect + 'a> {
    match (kind, shelf) {
        (StructureKind::Wide8(builder), Some(shelf)) => {
            Box::new(kept_wide8(&builder, primitives, shelf))
        }
        (StructureKind::Wide16(builder), Some(shelf)) => {
            Box::new(kept_wide16(&builder, primitives, shelf))
        }
        _ => kind.build(primitives),
    }
}
