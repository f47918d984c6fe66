//! The test everybody knows, as a named alternative: short, but rays slip through shared edges.
//!
//! *Source.* Möller & Trumbore 1997, *Fast, Minimum Storage Ray/Triangle Intersection*, in plain unfused operations.

use super::Meeting;
use crate::geometry::{PreparedRay, Vec3};

/// Meets a triangle within `[ray.t_min, t_max]`, edges included, from both sides; `None` for a miss.
#[inline(always)]
pub fn intersect([a, b, c]: [Vec3; 3], ray: &PreparedRay, t_max: f32) -> Option<Meeting> {
    let (e1, e2) = (b - a, c - a);
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = ray.origin - a;
    let u = s.dot(p) * inverse;
    let q = s.cross(e1);
    let v = ray.direction.dot(q) * inverse;
    let t = e2.dot(q) * inverse;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    let counts = t >= ray.t_min && t <= t_max && t < f32::INFINITY;
    (inside && counts).then_some(Meeting { t, u, v })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ray;

    #[test]
    fn agrees_with_the_canonical_test_where_nothing_is_rounded() {
        let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from);
        for x in -2..6 {
            for y in -2..6 {
                let o = [x as f32 / 4.0, y as f32 / 4.0, -2.0];
                let ray = PreparedRay::new(&Ray::new(o, [0.0, 0.0, 2.0]), 2.0).expect("good");
                let canonical = super::super::watertight::intersect(vertices, &ray, f32::MAX);
                assert_eq!(
                    intersect(vertices, &ray, f32::MAX),
                    canonical.map(|(meeting, _)| meeting)
                );
            }
        }
    }
}
