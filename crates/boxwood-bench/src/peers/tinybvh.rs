//! tinybvh: C++ in one header, by its Rust wrapper `tinybvh-rs`.
//!
//! *How it is asked.* The wrapper offers `BVH8_CPU`, the library's best, only to programs that are compiled for AVX2
//! (`RUSTFLAGS="-C target-feature=+avx2,+fma"`); all others get its binary tree. Both are built with spatial splits. There
//! is no any-hit question in the wrapper, so that is the nearest hit too. Rays begin at 0 and end before 1e30.

use super::ffi::TinyTree;
use super::{Built, Finished, Subject, Way};
use boxwood::{Hit, Ray};
use std::time::Instant;
use tinybvh_rs::{INFINITE, Intersection, Ray as TinyRay};

/// In C++ a ray is aligned to 64 bytes, in the wrapper to 16 only; code for AVX-512 relies on the former. That is also why
/// rays are not made with the wrapper's `Ray::new` (which would change the length of the direction, too).
#[repr(align(64))]
struct Query(TinyRay);

/// `RAY_MASK_INTERSECT_ALL`, which stands behind the origin.
const ALL: u32 = 0xffff;

impl Query {
    #[inline]
    fn new(ray: &Ray) -> Self {
        // As tinybvh's own constructor does it.
        let inverse = |x: f32| {
            if x.abs() > 1e-12 {
                1.0 / x
            } else {
                INFINITE.copysign(x)
            }
        };
        let direction = ray.direction.to_array();
        Self(TinyRay {
            origin: ray.origin.to_array(),
            padding_0: ALL,
            dir: direction,
            r_d: direction.map(inverse),
            hit: Intersection {
                t: ray.t_max.min(INFINITE),
                ..Intersection::default()
            },
            ..TinyRay::default()
        })
    }
}

impl TinyTree<'_> {
    #[inline]
    fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let mut query = Query::new(ray);
        let t_max = query.0.hit.t;
        self.intersect(&mut query.0);
        let hit = query.0.hit;
        (hit.t < t_max).then_some(Hit {
            t: hit.t,
            u: hit.u,
            v: hit.v,
            primitive: hit.prim,
            instance: 0,
        })
    }
}

impl Built for TinyTree<'_> {
    fn bytes(&self) -> Option<usize> {
        None
    }
    fn note(&self) -> Option<String> {
        Some(format!(
            "tinybvh: its layout {} with spatial splits; no any-hit question in the wrapper, so `occluded` is the nearest hit",
            TinyTree::LAYOUT
        ))
    }
    fn closest(&self, _: Way, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.nearest(ray);
        }
    }
    fn occluded(&self, _: Way, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.nearest(ray).is_some();
        }
    }
}

pub fn build(subject: &Subject) -> Result<Finished<'_>, String> {
    let corners = subject.corners();
    let start = Instant::now();
    let tree = TinyTree::build(corners).map_err(|e| e.to_string())?;
    Ok(Finished {
        seconds: start.elapsed().as_secs_f64(),
        built: Box::new(tree),
    })
}
