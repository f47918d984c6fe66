//! The irradiance of distant light as spherical harmonics of the first three bands.
//!
//! *How it works.* A surface sees distant light through a cosine, which keeps little but its first nine harmonics: the error
//! is a few percent for any surroundings. *Cost.* Nine colours; an evaluation is some forty operations. *Source.*
//! Ramamoorthi & Hanrahan 2001, *An Efficient Representation for Irradiance Environment Maps*.

use boxwood::Vec3;

/// Coefficients in the order 00, 1−1, 10, 11, 2−2, 2−1, 20, 21, 22, already convolved with the cosine.
#[derive(Clone, Copy, Debug)]
pub struct Harmonics([Vec3; 9]);

fn basis(d: Vec3) -> [f32; 9] {
    let Vec3 { x, y, z } = d;
    [
        0.282_095,
        0.488_603 * y,
        0.488_603 * z,
        0.488_603 * x,
        1.092_548 * x * y,
        1.092_548 * y * z,
        0.315_392 * (3.0 * z * z - 1.0),
        1.092_548 * x * z,
        0.546_274 * (x * x - y * y),
    ]
}

impl Harmonics {
    /// Sums `radiance` over a latitude-longitude grid of directions; y is up, row 0 is up.
    pub fn project(columns: u32, rows: u32, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let mut sums = [[0.0_f64; 3]; 9];
        for row in 0..rows {
            for column in 0..columns {
                let (direction, solid_angle) = cell(columns, rows, column, row);
                let light = radiance(direction) * solid_angle;
                for (sum, weight) in sums.iter_mut().zip(basis(direction)) {
                    for axis in 0..3 {
                        sum[axis] += f64::from(light[axis] * weight);
                    }
                }
            }
        }
        let pi = std::f64::consts::PI;
        let bands = [pi, 2.0 * pi / 3.0, 2.0 * pi / 3.0, 2.0 * pi / 3.0];
        Self(std::array::from_fn(|i| {
            let cosine = bands.get(i).copied().unwrap_or(0.25 * pi);
            Vec3::from(sums[i].map(|s| (s * cosine) as f32))
        }))
    }

    /// The light that falls on a surface with this unit normal; never negative.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        let sum = self
            .0
            .iter()
            .zip(basis(normal))
            .fold(Vec3::ZERO, |sum, (&c, weight)| sum + c * weight);
        sum.max(Vec3::ZERO)
    }
}

/// The middle direction of a grid cell, and its solid angle.
pub fn cell(columns: u32, rows: u32, column: u32, row: u32) -> (Vec3, f32) {
    use std::f32::consts::PI;
    let polar = (row as f32 + 0.5) / rows as f32 * PI;
    let around = ((column as f32 + 0.5) / columns as f32 - 0.5) * 2.0 * PI;
    let (sin, cos) = (libm::sinf(polar), libm::cosf(polar));
    let direction = Vec3::new(sin * libm::sinf(around), cos, -sin * libm::cosf(around));
    (
        direction,
        sin * (PI / rows as f32) * (2.0 * PI / columns as f32),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn even_light_gives_pi() {
        let even = Harmonics::project(64, 32, |_| Vec3::new(1.0, 2.0, 0.0));
        for d in [Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.6, 0.0, -0.8)] {
            let e = even.irradiance(d);
            assert!((e - Vec3::new(PI, 2.0 * PI, 0.0)).length() < 0.01, "{e:?}");
        }
    }

    /// A cosine lobe lies in the first two bands: `∫ max(0, …)` has a closed form for light `1 + y`.
    #[test]
    fn a_gradient_is_exact() {
        let gradient = Harmonics::project(128, 64, |d| Vec3::splat(1.0 + d.y));
        let at = |y: f32| {
            gradient
                .irradiance(Vec3::new((1.0 - y * y).sqrt(), y, 0.0))
                .x
        };
        for y in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            let exact = PI + 2.0 / 3.0 * PI * y;
            assert!((at(y) - exact).abs() < 0.01, "{y}: {} {exact}", at(y));
        }
    }
}
