//! The crate `bvh`: Rust, a binary tree by the surface-area heuristic.
//!
//! *How it is asked.* `nearest_child_traverse_iterator` for the nearest hit, `traverse_iterator` for any. The iterators
//! cannot be told of the best hit so far, so they visit everything along the ray. Its own triangle test sees no backs
//! and wants directions of unit length; the test here, of Möller and Trumbore 1997, sees both sides.

use super::{Built, Finished, Way};
use boxwood::{Hit, Ray, TriangleMesh};
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::Bvh;
use bvh::ray::Ray as BvhRay;
use nalgebra::{Point3, Vector3};
use std::time::Instant;

struct Triangle {
    corner: Point3<f32>,
    edges: [Vector3<f32>; 2],
    primitive: u32,
    node: usize,
}

impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [e1, e2] = self.edges;
        Aabb::empty()
            .grow(&self.corner)
            .grow(&(self.corner + e1))
            .grow(&(self.corner + e2))
    }
}

impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Triangle {
    /// `t`, `u` and `v` on the ray's own direction, which need not have unit length.
    #[inline]
    fn meet(&self, origin: &Point3<f32>, direction: &Vector3<f32>) -> Option<[f32; 3]> {
        let [e1, e2] = &self.edges;
        let p = direction.cross(e2);
        let det = e1.dot(&p);
        if det == 0.0 {
            return None;
        }
        let inverse = 1.0 / det;
        let s = origin - self.corner;
        let u = s.dot(&p) * inverse;
        let q = s.cross(e1);
        let v = direction.dot(&q) * inverse;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| [e2.dot(&q) * inverse, u, v])
    }
}

struct Tree {
    bvh: Bvh<f32, 3>,
    triangles: Vec<Triangle>,
}

fn parts(ray: &Ray) -> (Point3<f32>, Vector3<f32>) {
    (
        Point3::from(ray.origin.to_array()),
        Vector3::from(ray.direction.to_array()),
    )
}

impl Built for Tree {
    fn bytes(&self) -> Option<usize> {
        Some(size_of_val(&*self.bvh.nodes) + size_of_val(&*self.triangles))
    }
    fn note(&self) -> Option<String> {
        Some(
            "bvh: its iterators visit all that lies along the ray; its bytes contain its triangles"
                .to_string(),
        )
    }
    fn closest(&self, _: Way, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let (origin, direction) = parts(ray);
            let query = BvhRay::new(origin, direction);
            let mut t_max = ray.t_max;
            *hit = None;
            for triangle in self
                .bvh
                .nearest_child_traverse_iterator(&query, &self.triangles)
            {
                if let Some([t, u, v]) = triangle.meet(&origin, &direction)
                    && t >= ray.t_min
                    && t <= t_max
                {
                    t_max = t;
                    *hit = Some(Hit {
                        t,
                        u,
                        v,
                        primitive: triangle.primitive,
                        instance: 0,
                    });
                }
            }
        }
    }
    fn occluded(&self, _: Way, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            let (origin, direction) = parts(ray);
            let query = BvhRay::new(origin, direction);
            let within = |t: f32| t >= ray.t_min && t <= ray.t_max;
            *occluded = self
                .bvh
                .traverse_iterator(&query, &self.triangles)
                .any(|triangle| {
                    triangle
                        .meet(&origin, &direction)
                        .is_some_and(|[t, ..]| within(t))
                });
        }
    }
}

pub fn build(mesh: &TriangleMesh, threads: usize) -> Finished<'static> {
    let mut triangles: Vec<Triangle> = (0..mesh.triangles().len())
        .map(|i| {
            let [a, b, c] = mesh.triangle(i).map(|p| Point3::from(p.to_array()));
            Triangle {
                corner: a,
                edges: [b - a, c - a],
                primitive: i as u32,
                node: 0,
            }
        })
        .collect();
    let start = Instant::now();
    let bvh = if threads > 1 {
        Bvh::build_par(&mut triangles)
    } else {
        Bvh::build(&mut triangles)
    };
    Finished {
        seconds: start.elapsed().as_secs_f64(),
        built: Box::new(Tree { bvh, triangles }),
    }
}
