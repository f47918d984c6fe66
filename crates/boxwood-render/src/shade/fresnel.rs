//! How much light a smooth boundary reflects, and where the rest goes.
//!
//! *Source.* Fresnel's equations for unpolarised light between dielectrics, exact; Schlick 1994 for metals, of which only
//! a colour is known.

use crate::colour::WHITE;
use boxwood::Vec3;

/// The reflected share at a dielectric for the cosine of the angle of incidence (0 to 1) and the ratio of the indices of
/// refraction, outside over inside as the ray sees them (`eta = n_from / n_to`). 1 is total reflection.
pub fn dielectric(cos_in: f32, eta: f32) -> f32 {
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in).max(0.0);
    if sin2_out >= 1.0 {
        return 1.0;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    let parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    let across = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    let share = 0.5 * (parallel * parallel + across * across);
    // 0 / 0 where both cosines vanish: a grazing ray is reflected.
    if share <= 1.0 { share } else { 1.0 }
}

/// Schlick's approximation for a metal whose reflectance at normal incidence is a colour.
pub fn metal(cos_in: f32, colour: Vec3) -> Vec3 {
    let away = (1.0 - cos_in).clamp(0.0, 1.0);
    let squared = away * away;
    colour + (WHITE - colour) * (squared * squared * away)
}

/// The direction of a refracted ray by Snell's law, of unit length; `None` where all is reflected. `normal` is on the side
/// that `direction` comes from; `eta = n_from / n_to`.
pub fn refract(direction: Vec3, normal: Vec3, eta: f32) -> Option<Vec3> {
    let cos_in = -direction.dot(normal);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in).max(0.0);
    if sin2_out >= 1.0 {
        return None;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    Some((direction * eta + normal * (eta * cos_in - cos_out)).normalized())
}

/// The direction of a mirrored ray.
pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: Vec3 = Vec3::new(0.0, 1.0, 0.0);

    fn down(degrees: f32) -> Vec3 {
        let angle = degrees.to_radians();
        Vec3::new(angle.sin(), -angle.cos(), 0.0)
    }

    #[test]
    fn normal_incidence_on_glass_is_four_percent() {
        assert!((dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1.0e-6);
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1.0e-6);
        assert_eq!(dielectric(0.0, 1.0 / 1.5), 1.0);
        assert!(dielectric(0.3, 1.0) < 1.0e-6);
    }

    /// At Brewster's angle light polarised in the plane is not reflected: half of what the other half reflects remains.
    #[test]
    fn brewster() {
        let angle = 1.5_f32.atan();
        let (cos_in, eta) = (angle.cos(), 1.0 / 1.5);
        let cos_out = (1.0 - eta * eta * (1.0 - cos_in * cos_in)).sqrt();
        let across = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
        assert!((dielectric(cos_in, eta) - 0.5 * across * across).abs() < 1.0e-6);
    }

    #[test]
    fn snell() {
        for degrees in [0.0, 20.0, 45.0, 80.0] {
            let bent = refract(down(degrees), N, 1.0 / 1.5).expect("into glass");
            assert!((bent.x * 1.5 - degrees.to_radians().sin()).abs() < 1.0e-6);
            assert!((bent.length() - 1.0).abs() < 1.0e-6 && bent.y < 0.0);
        }
        // From glass, 41.8 degrees is the last angle that leaves.
        assert!(refract(down(41.5), N, 1.5).is_some());
        assert!(refract(down(42.0), N, 1.5).is_none());
        assert_eq!(dielectric(42_f32.to_radians().cos(), 1.5), 1.0);
    }

    /// What enters at an angle leaves at that angle: the share is the same both ways.
    #[test]
    fn light_paths_can_be_reversed() {
        for degrees in [5.0, 30.0, 60.0, 85.0] {
            let bent = refract(down(degrees), N, 1.0 / 1.33).expect("into water");
            let there = dielectric(degrees.to_radians().cos(), 1.0 / 1.33);
            let back = dielectric(-bent.y, 1.33);
            assert!((there - back).abs() < 1.0e-5, "{degrees}: {there} {back}");
        }
    }

    #[test]
    fn metals_whiten_at_grazing_angles() {
        let gold = Vec3::new(1.0, 0.7, 0.3);
        assert_eq!(metal(1.0, gold), gold);
        assert_eq!(metal(0.0, gold), WHITE);
    }
}
