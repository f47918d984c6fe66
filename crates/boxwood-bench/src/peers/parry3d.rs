//! parry3d: Rust, collision detection; its `TriMesh` casts rays through a binary tree.
//!
//! *How it is asked.* `cast_local_ray`, which names the triangle; it has no question for any hit, so that is the nearest
//! one too. Rays begin at 0: one whose interval begins later is asked as if it did not.

use super::{Built, Finished, Way};
use boxwood::{Hit, Ray, TriangleMesh, Vec3};
use parry3d::math::Vector;
use parry3d::query::Ray as ParryRay;
use parry3d::shape::{CompositeShapeRef, TriMesh};
use std::time::Instant;

struct Shape(TriMesh);

fn vector(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

impl Shape {
    #[inline]
    fn cast(&self, ray: &Ray) -> Option<(u32, f32)> {
        let query = ParryRay::new(vector(ray.origin), vector(ray.direction));
        CompositeShapeRef(&self.0).cast_local_ray(&query, ray.end(), false)
    }
}

impl Built for Shape {
    fn bytes(&self) -> Option<usize> {
        None
    }
    fn note(&self) -> Option<String> {
        Some("parry3d: has no any-hit question, so `occluded` is its nearest hit".to_string())
    }
    fn closest(&self, _: Way, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.cast(ray).map(|(primitive, t)| Hit {
                t,
                u: 0.0,
                v: 0.0,
                primitive,
                instance: 0,
            });
        }
    }
    fn occluded(&self, _: Way, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.cast(ray).is_some();
        }
    }
}

pub fn build(mesh: &TriangleMesh) -> Result<Finished<'static>, String> {
    let positions = mesh.positions().iter().map(|&p| vector(p)).collect();
    let triangles = mesh.triangles().to_vec();
    let start = Instant::now();
    let shape = TriMesh::new(positions, triangles).map_err(|e| e.to_string())?;
    Ok(Finished {
        seconds: start.elapsed().as_secs_f64(),
        built: Box::new(Shape(shape)),
    })
}
