//! Directions around an axis from points of the unit square.

use boxwood::Vec3;
use std::f32::consts::TAU;

/// A direction in the cone around `axis` whose cosine at the edge is `1 − gap`.
pub(crate) fn in_cone(axis: Vec3, gap: f32, [u, v]: [f32; 2]) -> Vec3 {
    let below = u * gap;
    let cos = 1.0 - below;
    let sin = (below * (2.0 - below)).max(0.0).sqrt();
    let (x, y) = across(axis);
    let around = TAU * v;
    (x * (sin * libm::cosf(around)) + y * (sin * libm::sinf(around)) + axis * cos).normalized()
}

/// A direction around a normal, as often as its cosine is large.
pub(crate) fn around_normal(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let (x, y) = across(normal);
    let (r, around) = (u.sqrt(), TAU * v);
    (x * (r * libm::cosf(around))
        + y * (r * libm::sinf(around))
        + normal * (1.0 - u).max(0.0).sqrt())
    .normalized()
}

/// Two unit vectors at right angles to a unit vector and to each other (Duff et al. 2017).
fn across(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_around_a_normal_follow_the_cosine() {
        let normal = Vec3::new(0.36, -0.48, 0.8);
        let n = 32;
        let mean = (0..n * n)
            .map(|i| [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32))
            .map(|sample| around_normal(normal, sample).dot(normal))
            .sum::<f32>()
            / (n * n) as f32;
        assert!((mean - 2.0 / 3.0).abs() < 0.01, "{mean}");
    }
}
