//! The canonical ray-triangle test: exact in sign, watertight, the same bits on every machine.
//!
//! *How it works.* Woop, Benthin & Wald 2013 move the ray's origin to zero and shear its direction onto an axis; what
//! is left is a point in a projected triangle, decided by three edge functions. Each is a difference of two products;
//! here the exact rounding errors of both products are added, so that its sign is never wrong and its value is right to
//! `3 u` (`u = 2⁻²⁴`). Triangles that share an edge see the same rounded vertices, hence no ray slips between them;
//! the weights are right, hence an accepted hit lies at a point *inside* the triangle, hence padded boxes never lose it.
//!
//! *Nothing here may be contracted, reassociated or approximated:* these operations in this order are the definition
//! of what a hit is.
//!
//! *Source.* Woop, Benthin & Wald 2013, *Watertight Ray/Triangle Intersection*; the error of a product: Dekker 1971.

use super::Meeting;
use crate::geometry::double::sub;
use crate::geometry::{Aabb, PreparedRay, Vec3};
use crate::math::power_to_one;

/// Below this |determinant| products may have left the normal floats, and the weights with them (2⁻⁸⁰).
pub(super) const TINY: f32 = 8.271_806e-25;

/// Meets a triangle within `[ray.t_min, t_max]`, edges included, from both sides; `None` for a miss.
///
/// The flag says whether the proof of the slack covers the hit; where not, it counts only if it is [`confirmed`].
#[inline(always)]
pub fn intersect([a, b, c]: [Vec3; 3], ray: &PreparedRay, t_max: f32) -> Option<(Meeting, bool)> {
    if let Some(power) = ray.scaled() {
        return intersect_scaled([a, b, c], ray, t_max, power);
    }
    let (x, y, z) = sheared([a, b, c], ray);
    decide(x, y, z, ray, t_max, 1.0)
}

/// Whether a hit that the proof of the slack does not cover counts all the same.
///
/// Inside the doors: where the ray, in double precision, is so near to the point that the weights name as if it were covered. With
/// `D` the largest |vertex − origin|, that point lies within 8 u D of the triangle, because the weights add up to 1 + 4 u
/// at most; so a bound of 16 u D puts the ray within 24 u D of a point of the triangle, whatever the place of both in the world.
/// Outside the doors: in the triangle's own padded box (see [`PreparedRay`]).
#[cold]
pub fn confirmed(corners: [Vec3; 3], ray: &PreparedRay, hit: &Meeting) -> bool {
    if !ray.is_tame() {
        return ray.is_inside(&Aabb::of(corners), hit.t);
    }
    let wide = |v: Vec3| v.to_array().map(f64::from);
    let (origin, direction) = (wide(ray.origin), wide(ray.direction));
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f64::from);
    let seen = corners.map(|corner| sub(wide(corner), origin));
    let distance = seen.iter().flatten().fold(0.0_f64, |d, x| d.max(x.abs()));
    let bound = 16.0 / (1 << 24) as f64 * distance;
    let [a, b, c] = seen;
    (0..3).all(|k| {
        let named = a[k] + (b[k] - a[k]) * u + (c[k] - a[k]) * v;
        (t * direction[k] - named).abs() <= bound
    })
}

/// The corners, seen from the ray's origin and sheared so that the ray runs along the third axis.
#[inline(always)]
fn sheared([a, b, c]: [Vec3; 3], ray: &PreparedRay) -> ([f32; 3], [f32; 3], [f32; 3]) {
    let [a, b, c] = [a - ray.origin, b - ray.origin, c - ray.origin];
    // One well predicted branch per triangle: within a ray it always goes the same way.
    let [a, b, c] = match ray.leaning.axes[2] {
        0 => [[a.y, a.z, a.x], [b.y, b.z, b.x], [c.y, c.z, c.x]],
        1 => [[a.z, a.x, a.y], [b.z, b.x, b.y], [c.z, c.x, c.y]],
        _ => [[a.x, a.y, a.z], [b.x, b.y, b.z], [c.x, c.y, c.z]],
    };
    let [sx, sy, _] = ray.leaning.shear;
    (
        [a[0] - sx * a[2], b[0] - sx * b[2], c[0] - sx * c[2]],
        [a[1] - sy * a[2], b[1] - sy * b[2], c[1] - sy * c[2]],
        [a[2], b[2], c[2]],
    )
}

/// For rays and scenes of any size: the triangle is brought to sizes near 1 by powers of two, across the ray and along it.
/// Its neighbours may be scaled otherwise, but the signs do not depend on it. Nothing is covered here.
#[cold]
fn intersect_scaled(
    corners: [Vec3; 3],
    ray: &PreparedRay,
    t_max: f32,
    power: f32,
) -> Option<(Meeting, bool)> {
    let (mut x, mut y, mut z) = sheared(corners, ray);
    let largest = |v: &[f32; 3]| v.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
    let across = power_to_one(largest(&x).max(largest(&y)));
    let along = power_to_one(largest(&z));
    for (v, by) in [(&mut x, across), (&mut y, across), (&mut z, along)] {
        *v = v.map(|x| x * by);
    }
    let t_unit = f64::from(power) / f64::from(along);
    decide(x, y, z, ray, t_max, t_unit).map(|(meeting, _)| (meeting, false))
}

/// The test of a triangle that stands across the ray's axis; the `t` that is found is multiplied by `t_unit`.
#[inline(always)]
fn decide(
    [x0, x1, x2]: [f32; 3],
    [y0, y1, y2]: [f32; 3],
    [z0, z1, z2]: [f32; 3],
    ray: &PreparedRay,
    t_max: f32,
    t_unit: f64,
) -> Option<(Meeting, bool)> {
    let iz = ray.leaning.shear[2];
    // Rounding is monotone: what the exact edge functions accept passes this. Most triangles end here.
    let (u, v, w) = (x2 * y1 - y2 * x1, x0 * y2 - y0 * x2, x1 * y0 - y1 * x0);
    // One branch instead of six that nobody can predict.
    let least = min(min(u, v), w);
    let most = max(max(u, v), w);
    if (least < 0.0) & (most > 0.0) {
        return None;
    }
    let u = difference_of_products(x2, y1, y2, x1);
    let v = difference_of_products(x0, y2, y0, x2);
    let w = difference_of_products(x1, y0, y1, x0);
    if !same_side(u, v, w) {
        return None;
    }
    let determinant = (u + v) + w;
    let r = 1.0 / determinant;
    let t = (((u * z0 + v * z1) + w * z2) * iz) * r;
    // A tame ray multiplies by one, which the compiler knows.
    let t = if t_unit == 1.0 {
        t
    } else {
        (f64::from(t) * t_unit) as f32
    };
    // NaN fails, and so does u = v = w = 0. An infinite `t_max` reads as the largest float.
    if !(t >= ray.t_min && t <= t_max && t < f32::INFINITY) {
        return None;
    }
    let covered = determinant.abs() >= TINY;
    Some((
        Meeting {
            t,
            u: v * r,
            v: w * r,
        },
        covered,
    ))
}

// As one instruction each; what becomes of NaN does not matter, because such a triangle is missed in the end.
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn same_side(u: f32, v: f32, w: f32) -> bool {
    (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)
}

/// `a b − c d`, never wrong in sign and right to `3 u`: the rounded difference plus both products' exact errors.
#[inline(always)]
fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let (p, q) = (a * b, c * d);
    (p - q) + (product_error(a, b, p) - product_error(c, d, q))
}

/// `a b − p` exactly, where `p` is `a b` rounded. Each of the three double-precision steps is exact, so the bits are
/// those of a fused multiply-add.
#[inline(always)]
fn product_error(a: f32, b: f32, p: f32) -> f32 {
    (f64::from(a) * f64::from(b) - f64::from(p)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ray;

    fn meet(vertices: [[f32; 3]; 3], ray: Ray) -> Option<Meeting> {
        let ray = PreparedRay::new(&ray, 10.0)?;
        intersect(vertices.map(Vec3::from), &ray, ray.t_max).map(|(meeting, _)| meeting)
    }

    const RIGHT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn weights_belong_to_vertices_one_and_two() {
        let hit = meet(RIGHT, Ray::new([0.25, 0.5, -2.0], [0.0, 0.0, 2.0])).expect("a hit");
        assert_eq!((hit.t, hit.u, hit.v), (1.0, 0.25, 0.5));
    }

    #[test]
    fn both_sides_edges_and_corners_count() {
        for (x, y) in [
            (0.0, 0.0),
            (1.0, 0.0),
            (0.0, 1.0),
            (0.5, 0.5),
            (0.5, 0.0),
            (0.0, 0.5),
        ] {
            for z in [-1.0, 1.0] {
                let hit = meet(RIGHT, Ray::new([x, y, z], [0.0, 0.0, -z]));
                assert_eq!(hit.map(|h| h.t), Some(1.0), "{x} {y} {z}");
            }
        }
        assert!(meet(RIGHT, Ray::new([0.5, 0.500_001, 1.0], [0.0, 0.0, -1.0])).is_none());
    }

    #[test]
    fn the_interval_is_closed() {
        let ray = Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, 1.0]);
        assert!(meet(RIGHT, ray.until(2.0)).is_some());
        assert!(meet(RIGHT, ray.from(2.0)).is_some());
        assert!(meet(RIGHT, ray.until(1.999_999)).is_none());
        assert!(meet(RIGHT, ray.from(2.000_001)).is_none());
    }

    #[test]
    fn without_area_there_is_no_hit() {
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let point = [[0.5, 0.5, 0.0]; 3];
        for x in 0..9 {
            let ray = Ray::new([x as f32 / 4.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
            assert!(meet(line, ray).is_none());
        }
        assert!(meet(point, Ray::new([0.5, 0.5, -1.0], [0.0, 0.0, 1.0])).is_none());
        // A ray in the triangle's own plane sees no area either.
        assert!(meet(RIGHT, Ray::new([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0])).is_none());
    }

    /// The same triangle in any unit is met at the same place.
    #[test]
    fn every_size_a_float_can_have() {
        for exponent in [-140, -120, -80, -40, -20, 0, 27, 30, 60, 100, 125] {
            let size = libm::scalbnf(1.0, exponent);
            let vertices = RIGHT.map(|p| p.map(|x| x * size));
            for speed in [-120, -30, 0, 30, 120] {
                let step = libm::scalbnf(1.0, speed);
                if !(-125..=125).contains(&(exponent - speed)) {
                    continue;
                }
                let origin = [0.25 * size, 0.5 * size, -2.0 * size];
                let ray = Ray::new(origin, [0.0, 0.0, step]);
                let ray = PreparedRay::new(&ray, 2.0 * size).expect("a good ray");
                let found = intersect(vertices.map(Vec3::from), &ray, ray.t_max);
                let (hit, _) = found.unwrap_or_else(|| panic!("2^{exponent} at 2^{speed}"));
                assert_eq!((hit.t, hit.u, hit.v), (2.0 * size / step, 0.25, 0.5));
                let around = Aabb::of(vertices);
                assert!(ray.is_inside(&around, hit.t), "2^{exponent} at 2^{speed}");
            }
        }
    }

    /// Of a triangle too small for the proof, in a scene of ordinary size far from the world's origin and near it.
    #[test]
    fn hits_beyond_the_proof_are_held_against_the_triangle() {
        for far in [0.0, 1.0e6] {
            let vertices = [[far, 0.0, 0.0], [far, 1.0e-13, 0.0], [far, 0.0, 1.0e-13]];
            let vertices = vertices.map(Vec3::from);
            let ray = Ray::new([far - 1.0, 2.0e-14, 3.0e-14], [1.0, 0.0, 0.0]);
            let ray = PreparedRay::new(&ray, far + 1.0).expect("a good ray");
            let (hit, covered) = intersect(vertices, &ray, f32::MAX).expect("a hit");
            assert!(!covered && confirmed(vertices, &ray, &hit));
            for factor in [0.999_99, 1.000_01] {
                let off = Meeting {
                    t: hit.t * factor,
                    ..hit
                };
                // In the padded box of a scene so large, but not on the triangle.
                assert_eq!(ray.is_inside(&Aabb::of(vertices), off.t), far > 0.0);
                assert!(!confirmed(vertices, &ray, &off));
            }
        }
    }

    #[test]
    fn signs_of_cancelling_products_are_right() {
        // Neighbouring floats: the products differ by far less than their rounding.
        let mut x = 1.0_f32;
        for _ in 0..1000 {
            let (a, b) = (x.next_up(), x.next_down());
            let exact = f64::from(a) * f64::from(b) - f64::from(x) * f64::from(x);
            let found = f64::from(difference_of_products(a, b, x, x));
            assert_eq!(found < 0.0, exact < 0.0);
            assert!((found - exact).abs() <= 3.0 * exact.abs() / (1 << 24) as f64);
            x = x.next_up();
        }
    }
}
