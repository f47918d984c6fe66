//! How much of the sky a triangle covers.
//!
//! *Cost.* Three square roots and an arctangent, in double precision.
//!
//! *Source.* Van Oosterom & Strackee 1983, *The Solid Angle of a Plane Triangle*.

use crate::geometry::Vec3;
use crate::geometry::double::{Double3, cross, dot, length, sub};
use core::f64::consts::FRAC_1_PI;

/// The solid angle as seen from `p`, as a share of the whole sphere: from −1/2 to 1/2, positive where the triangle's back is
/// seen (as from inside a closed mesh). 0 in the triangle's plane outside of it and at its corners; half a sphere of either
/// sign on the triangle.
#[inline]
pub fn solid_angle(triangle: [Vec3; 3], p: Double3) -> f64 {
    let [a, b, c] = triangle.map(|v| sub(v.to_array().map(f64::from), p));
    let [la, lb, lc] = [length(a), length(b), length(c)];
    let volume = dot(a, cross(b, c));
    let cosines = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    // tan(Ω / 2) = volume / cosines, and 4 π are the whole sphere.
    libm::atan2(volume, cosines) * (0.5 * FRAC_1_PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octant_is_an_eighth() {
        let t = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
        assert!((solid_angle(t, [0.0; 3]) - 0.125).abs() < 1.0e-15);
        let [a, b, c] = t;
        assert!((solid_angle([a, c, b], [0.0; 3]) + 0.125).abs() < 1.0e-15);
        assert!((solid_angle(t, [1.0 / 3.0 - 1.0e-9; 3]) - 0.5).abs() < 1.0e-6);
        assert_eq!(solid_angle(t, [1.0, 0.0, 0.0]), 0.0);
        assert_eq!(solid_angle([a, a, b], [0.0; 3]), 0.0);
    }
}
