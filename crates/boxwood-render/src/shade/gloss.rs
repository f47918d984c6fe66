//! The highlight of a rough surface: GGX microfacets.
//!
//! *Source.* Walter et al. 2007, *Microfacet Models for Refraction through Rough Surfaces*; Heitz 2014 for the masking that
//! goes with it; Karis 2014, *Physically Based Shading on Mobile*, for the reflectance towards even light.

use boxwood::Vec3;

/// Perceptual roughness below which a lamp's highlight shrinks no further: a point lamp in a perfect mirror would be
/// invisible.
pub const SMOOTHEST: f32 = 0.07;

/// The microfacet lobe without its Fresnel factor, times the cosine at the light: `D · V · cos`.
/// All vectors have unit length and point away from the surface.
pub fn lobe(normal: Vec3, to_eye: Vec3, to_light: Vec3, half: Vec3, roughness: f32) -> f32 {
    let alpha = roughness.max(SMOOTHEST) * roughness.max(SMOOTHEST);
    let a2 = alpha * alpha;
    let n_h = normal.dot(half).clamp(0.0, 1.0);
    let n_l = normal.dot(to_light).clamp(0.0, 1.0);
    let n_v = normal.dot(to_eye).clamp(1.0e-4, 1.0);
    let spread = n_h * n_h * (a2 - 1.0) + 1.0;
    let facets = a2 / (std::f32::consts::PI * spread * spread);
    let shadowed = n_v * (n_l * n_l * (1.0 - a2) + a2).sqrt();
    let masked = n_l * (n_v * n_v * (1.0 - a2) + a2).sqrt();
    facets * n_l * 0.5 / (shadowed + masked).max(1.0e-6)
}

/// The share of even light that a rough surface reflects, for its reflectance at normal incidence.
pub fn towards_even_light(at_normal: Vec3, roughness: f32, n_v: f32) -> Vec3 {
    let r = [
        1.0 - roughness,
        0.0425 - 0.0275 * roughness,
        1.04 - 0.572 * roughness,
        -0.04 + 0.022 * roughness,
    ];
    // 2^(−9.28 n·v)
    let grazing = libm::expf(-9.28 * std::f32::consts::LN_2 * n_v.clamp(0.0, 1.0));
    let a004 = (r[0] * r[0]).min(grazing) * r[0] + r[1];
    let (scale, bias) = (-1.04 * a004 + r[2], 1.04 * a004 + r[3]);
    (at_normal * scale + Vec3::splat(bias)).max(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lossless rough mirror reflects no more than it gets. What a rough one loses are the reflections between its facets,
    /// which the model leaves out.
    #[test]
    fn the_lobe_neither_loses_nor_makes_light() {
        let normal = Vec3::new(0.0, 1.0, 0.0);
        let to_eye = Vec3::new(0.6, 0.8, 0.0);
        for (roughness, least) in [(0.3, 0.95), (0.6, 0.78), (1.0, 0.33)] {
            let (rows, columns) = (400, 400);
            let mut sum = 0.0;
            for row in 0..rows {
                for column in 0..columns {
                    let y = (row as f32 + 0.5) / rows as f32;
                    let around = column as f32 / columns as f32 * std::f32::consts::TAU;
                    let r = (1.0 - y * y).sqrt();
                    let to_light = Vec3::new(r * around.cos(), y, r * around.sin());
                    let half = (to_eye + to_light).normalized();
                    sum += lobe(normal, to_eye, to_light, half, roughness);
                }
            }
            let share = sum * std::f32::consts::TAU / (rows * columns) as f32;
            assert!(share < 1.02 && share > least, "{roughness}: {share}");
        }
    }

    #[test]
    fn even_light_is_not_made_brighter() {
        for roughness in [0.0, 0.3, 0.7, 1.0] {
            for n_v in [0.0, 0.2, 0.6, 1.0] {
                for f0 in [0.0, 0.04, 1.0] {
                    let share = towards_even_light(Vec3::splat(f0), roughness, n_v).x;
                    assert!(
                        (0.0..=1.06).contains(&share),
                        "{roughness} {n_v} {f0}: {share}"
                    );
                }
            }
        }
    }
}
