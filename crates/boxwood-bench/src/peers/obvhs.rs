//! obvhs: Rust, trees by agglomerative clustering and reinsertion, compressed to eight children a node.
//!
//! *How it is asked.* As its examples do: `RtTriangle`s in the order of the tree's leaves, `ray_traverse` for the nearest
//! hit and `ray_traverse_miss` for any.

use super::{Built, Finished, Way};
use boxwood::{Hit, Ray, TriangleMesh, Vec3};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use std::time::{Duration, Instant};

struct Tree {
    bvh: CwBvh,
    /// In the order of the leaves.
    triangles: Vec<RtTriangle>,
}

fn vector(v: Vec3) -> Vec3A {
    Vec3A::new(v.x, v.y, v.z)
}

fn ray(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(
        vector(ray.origin),
        vector(ray.direction),
        ray.t_min,
        ray.t_max,
    )
}

impl Built for Tree {
    fn bytes(&self) -> Option<usize> {
        let bvh = size_of_val(&*self.bvh.nodes) + size_of_val(&*self.bvh.primitive_indices);
        Some(bvh + size_of_val(&*self.triangles))
    }
    fn note(&self) -> Option<String> {
        Some("obvhs: CwBvh; its bytes contain its triangles of 64 bytes".to_string())
    }
    fn closest(&self, _: Way, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (r, hit) in rays.iter().zip(hits) {
            let mut found = RayHit::none();
            let met = self.bvh.ray_traverse(ray(r), &mut found, |ray, id| {
                self.triangles[id].intersect(ray)
            });
            *hit = met.then(|| Hit {
                t: found.t,
                u: 0.0,
                v: 0.0,
                primitive: self.bvh.primitive_indices[found.primitive_id as usize],
                instance: 0,
            });
        }
    }
    fn occluded(&self, _: Way, rays: &[Ray], occluded: &mut [bool]) {
        for (r, occluded) in rays.iter().zip(occluded) {
            let test = |ray: &ObvhsRay, id: usize| self.triangles[id].intersect(ray);
            *occluded = !self.bvh.ray_traverse_miss(ray(r), test);
        }
    }
}

pub fn build(slow: bool, mesh: &TriangleMesh) -> Finished<'static> {
    let triangles: Vec<Triangle> = (0..mesh.triangles().len())
        .map(|i| {
            let [v0, v1, v2] = mesh.triangle(i).map(vector);
            Triangle { v0, v1, v2 }
        })
        .collect();
    let start = Instant::now();
    let settings = if slow {
        BvhBuildParams::very_slow_build()
    } else {
        BvhBuildParams::medium_build()
    };
    let bvh = build_cwbvh_from_tris(&triangles, settings, &mut Duration::default());
    let triangles = bvh
        .primitive_indices
        .iter()
        .map(|&i| RtTriangle::from(&triangles[i as usize]))
        .collect();
    Finished {
        seconds: start.elapsed().as_secs_f64(),
        built: Box::new(Tree { bvh, triangles }),
    }
}
