//! Colours for numbers whose steps look equally large: Inferno, of matplotlib (van der Walt & Smith 2015).

use crate::colour::SRGB;
use boxwood::Vec3;

/// The linear colour of a share, 0 (nearly black) to 1 (pale yellow).
pub fn inferno(share: f32) -> Vec3 {
    Vec3::from(inferno_bytes(share).map(|byte| SRGB[usize::from(byte)]))
}

/// The same in sRGB bytes.
pub fn inferno_bytes(share: f32) -> [u8; 3] {
    let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
    let c = colorous::INFERNO.eval_continuous(f64::from(share));
    [c.r, c.g, c.b]
}
