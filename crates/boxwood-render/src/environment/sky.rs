//! The sky over scenes that bring none: a clear gradient, a bright horizon, pale ground.

use crate::colour::{mix, smoothstep};
use boxwood::Vec3;

const HORIZON: Vec3 = Vec3::new(0.80, 0.88, 0.97);
const ZENITH: Vec3 = Vec3::new(0.27, 0.43, 0.74);
const GROUND_FAR: Vec3 = Vec3::new(0.56, 0.54, 0.51);
const GROUND_NEAR: Vec3 = Vec3::new(0.24, 0.225, 0.21);

/// A sky by height alone.
#[derive(Clone, Copy, Debug)]
pub struct Sky {
    /// Multiplies everything.
    pub brightness: f32,
}

impl Sky {
    /// What is seen in a direction whose part along up is `height` (−1 to 1), the horizon softened by a roughness.
    pub fn radiance(&self, height: f32, roughness: f32) -> Vec3 {
        let above = 1.0 - height.max(0.0);
        let sky = mix(ZENITH, HORIZON, above * above * above);
        let below = 1.0 - (-height).max(0.0);
        let ground = mix(GROUND_NEAR, GROUND_FAR, below * below * below);
        let haze = 0.02 + 0.9 * roughness;
        mix(ground, sky, smoothstep(-haze, haze, height)) * self.brightness
    }
}
