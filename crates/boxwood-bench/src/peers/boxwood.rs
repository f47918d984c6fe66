//! Boxwood's own structures, as users of [`StructureKind`] ask them: behind a [`Box<dyn Intersect>`](Intersect), which
//! costs a dynamic call for each single ray, and by the calls that take many rays.

use super::{Built, Finished, Way};
use boxwood::{Hit, Intersect, Limits, Ray, StructureKind, TriangleMesh};
use boxwood_render::build_structure;
use std::time::Instant;

struct Own<'a>(Box<dyn Intersect + 'a>, StructureKind);

impl Built for Own<'_> {
    fn ways(&self) -> &'static [Way] {
        &[Way::Single, Way::Batch]
    }
    fn bytes(&self) -> Option<usize> {
        Some(self.0.statistics().bytes)
    }
    fn closest(&self, way: Way, rays: &[Ray], hits: &mut [Option<Hit>]) {
        if way == Way::Batch {
            return self.0.closest_hits(rays, hits);
        }
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.0.closest_hit(ray);
        }
    }
    fn occluded(&self, way: Way, rays: &[Ray], occluded: &mut [bool]) {
        if way == Way::Batch {
            return self.0.occluded_each(rays, occluded);
        }
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.0.occluded(ray);
        }
    }
    fn own(&self) -> Option<&dyn Intersect> {
        Some(&*self.0)
    }
    fn is_exact(&self) -> bool {
        self.1.is_exact()
    }
}

pub fn build(kind: StructureKind, mesh: &TriangleMesh) -> Result<Finished<'_>, String> {
    let start = Instant::now();
    let structure = build_structure(kind, mesh, &Limits::NONE).map_err(|e| e.to_string())?;
    Ok(Finished {
        seconds: start.elapsed().as_secs_f64(),
        built: Box::new(Own(structure, kind)),
    })
}
