//! Structures built under limits, with their time.

use super::report;
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use boxwood::{BuildError, Intersect, Limits, StructureKind, TriangleMesh};
use boxwood_render::build_structure;
use std::ops::ControlFlow::Continue;
use std::time::Instant;

/// A structure and what it took.
pub struct Built<'a> {
    pub kind: StructureKind,
    pub seconds: f64,
    pub structure: Box<dyn Intersect + 'a>,
}

/// Short builds are repeated so often, for the clock's sake, unless that takes longer than [`PATIENCE`].
const BUILDS: usize = 3;
const PATIENCE: f64 = 1.0;
/// Of the progress bar.
const STEPS: usize = 1000;

/// Builds a structure; `Err` is a sentence when it needs more memory than allowed.
pub fn build<'a>(
    kind: StructureKind,
    mesh: &'a TriangleMesh,
    memory: Option<usize>,
) -> Outcome<Result<Built<'a>, String>> {
    let progress = Progress::bar(format!("Building {kind}"));
    let watch = |share: f32| {
        progress.at((share * STEPS as f32) as usize, STEPS);
        Continue(())
    };
    let limits = Limits {
        memory,
        watch: Some(&watch),
    };
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let structure = match build_structure(kind, mesh, &limits) {
            Ok(structure) => structure,
            Err(error @ BuildError::Memory { .. }) => return Ok(Err(error.to_string())),
            Err(error) => return Err(Failure::new(format!("{kind}: {error}"))),
        };
        times.push(start.elapsed().as_secs_f64());
        if times.len() == BUILDS || times.iter().sum::<f64>() > PATIENCE {
            return Ok(Ok(Built {
                kind,
                seconds: crate::cast::median(&mut times),
                structure,
            }));
        }
    }
}

impl Built<'_> {
    /// What can be said before any ray.
    pub fn describe(&self) -> report::Measured {
        let found = self.structure.statistics();
        let per_triangle =
            |n: usize| (found.primitives > 0).then(|| n as f64 / found.primitives as f64);
        report::Measured {
            build_seconds: self.seconds,
            bytes: found.bytes,
            bytes_per_triangle: per_triangle(found.bytes),
            nodes: found.nodes,
            leaves: found.leaves,
            depth: found.depth,
            references_per_triangle: per_triangle(found.references),
            sah_cost: f64::from(found.sah_cost),
            nodes_per_ray: None,
            leaves_per_ray: None,
            primitives_per_ray: None,
            mrays_per_second: None,
            speedup: None,
            histogram: Vec::new(),
            rays: Vec::new(),
        }
    }
}
