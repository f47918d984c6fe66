//! Vertices that move evenly from key to key, and where they are at a moment.
//!
//! *How it works.* A motion has one or more keys, evenly spread over the shutter, from time 0 to time 1. At a moment a vertex lies on
//! the line from the nearer key's place to the farther one's:
//!
//! ```text
//! near − (near − far) · weight        three rounded operations; weight is at most one half
//! ```
//!
//! That is the definition of where it is, as the triangle test is of what a hit is: every structure, and each lane of every instruction
//! set, computes it so. It depends on the vertex and the moment alone, so triangles that share an edge share it at all times, and no
//! ray slips between them. Beginning at the *nearer* key has three merits, each proved below:
//!
//! - At a key, a vertex has the key's own bits, a zero's sign included. There `far` is `near`, and `x − (x − x) · 0` is `x`.
//! - A vertex that rests between two keys has the same bits all the while, for the same reason.
//! - It is never outside of its keys: a box around the places at both keys holds it at any moment between them, rounding included. Let
//!   `near ≥ far` and `d` the rounded difference, at most `(near − far)(1 + u)`. As `weight ≤ ½`, the rounded product is at most `d / 2`, and
//!   `near − d / 2 ≥ far + (near − far)(1 − u) / 2 ≥ far`; rounding the last difference leaves it between two floats that it lies between. (Where
//!   `d / 2` is no float, `d` is subnormal and exact, and the product at most `d`.)
//!
//! *How far rounding takes it.* From the exact place on the exact line, by at most `u |near − far|` (a half of it each for the difference and the
//! product) and `u |place|` for the last operation. `u = 2⁻²⁴`.

use super::Vec3;
use super::frame::Frame;

/// Between which keys a moment lies, and how far from the nearer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    /// The nearer key.
    pub near: usize,
    /// The one on the other side of the moment; the nearer one itself where the moment is there.
    pub far: usize,
    /// How much of the way to the other one is gone: 0 to ½.
    pub weight: f32,
}

impl Moment {
    /// A time of a motion with so many keys. Before the shutter opens it is 0, after it has closed 1, and NaN is 0.
    #[inline(always)]
    pub fn new(time: f32, keys: usize) -> Self {
        let time = if time > 0.0 { time } else { 0.0 };
        let time = if time < 1.0 { time } else { 1.0 };
        let steps = keys.saturating_sub(1);
        let at = time * steps as f32;
        let before = (at as usize).min(steps.saturating_sub(1));
        // Exact, and so is one minus what is at least one half.
        let part = at - before as f32;
        let (near, far, weight) = if part <= 0.5 {
            (before, before + 1, part)
        } else {
            (before + 1, before, 1.0 - part)
        };
        Self {
            near,
            far: if weight > 0.0 { far } else { near },
            weight,
        }
    }

    /// Where a point is that is at these places at the two keys.
    #[inline(always)]
    pub fn place(&self, near: Vec3, far: Vec3) -> Vec3 {
        near - (near - far) * self.weight
    }
}

impl Frame {
    /// The same for boxes that move as the vertices in them do: each plane from its place at one key to that at the next.
    ///
    /// A plane that lies outside of a vertex at both keys does so at every moment between them, but for rounding. With `S` the largest
    /// |plane − centre| and `W` the largest |coordinate| in the world, neither is farther than `2 S` from its place at the other key, and
    /// so, in units of `u`, the vertex is within `2 S + W` of its exact place and the plane, of which only differences from the centre
    /// are known, within `2 S + S`. (Planes may be fused: that is one rounding less.) Together `5 S + W`; the slack, 32 of these units for
    /// each of the reach, is raised by `6 S + 2 W`.
    pub fn in_motion(self) -> Self {
        Self {
            reach: self.reach + self.reach * (6.0 / 32.0) + self.scale * (2.0 / 32.0),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn next(state: &mut u32) -> u32 {
        *state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        *state ^ *state >> 15
    }

    #[test]
    fn keys_are_met_exactly() {
        for keys in 1..40_usize {
            for key in 0..keys {
                let time = key as f32 / (keys - 1).max(1) as f32;
                let moment = Moment::new(time, keys);
                let away = (moment.near as f32 + moment.weight) - key as f32;
                assert!(away.abs() < 1.0e-5, "{key} of {keys}: {moment:?}");
            }
            for (time, key) in [(0.0, 0), (1.0, keys - 1)] {
                let moment = Moment::new(time, keys);
                assert_eq!((moment.near, moment.far, moment.weight), (key, key, 0.0));
            }
        }
    }

    #[test]
    fn outside_of_the_shutter_the_ends_count() {
        for time in [f32::NAN, -1.0, -0.0, f32::NEG_INFINITY, f32::MIN] {
            assert_eq!(Moment::new(time, 3), Moment::new(0.0, 3), "{time}");
        }
        for time in [1.5, f32::INFINITY, f32::MAX] {
            assert_eq!(Moment::new(time, 3), Moment::new(1.0, 3), "{time}");
        }
    }

    #[test]
    fn all_keys_exist_and_no_weight_is_over_a_half() {
        let mut state = 1;
        for _ in 0..100_000 {
            let time = f32::from_bits(next(&mut state));
            let keys = 1 + next(&mut state) as usize % 5;
            let moment = Moment::new(time, keys);
            assert!(moment.near < keys && moment.far < keys, "{time} of {keys}");
            assert!((0.0..=0.5).contains(&moment.weight), "{time} of {keys}");
            assert!(moment.near.abs_diff(moment.far) <= 1);
        }
    }

    /// Of any floats whose difference is one, the place is between them, and it is a key's own at that key.
    #[test]
    fn a_place_lies_between_its_keys() {
        let mut state = 2;
        let mut moved = 0;
        for _ in 0..1_000_000 {
            let (a, b) = (next(&mut state), next(&mut state));
            let x = f32::from_bits(a);
            // Often a neighbour, or of the same size.
            let y = match b % 4 {
                0 => f32::from_bits(a ^ b >> 20),
                1 => f32::from_bits(a ^ b >> 12),
                _ => f32::from_bits(b),
            };
            if !(x - y).is_finite() {
                continue;
            }
            let time = (next(&mut state) >> 8) as f32 / (1 << 24) as f32;
            let moment = Moment::new(time, 2);
            let keys = [Vec3::splat(x), Vec3::splat(y)];
            let place = moment.place(keys[moment.near], keys[moment.far]).x;
            assert!(x.min(y) <= place && place <= x.max(y), "{x:e} {y:e} {time}");
            for (time, key) in [(0.0, x), (1.0, y)] {
                let moment = Moment::new(time, 2);
                let place = moment.place(keys[moment.near], keys[moment.far]).x;
                assert_eq!(place.to_bits(), key.to_bits());
            }
            let still = moment.place(keys[0], keys[0]).x;
            assert_eq!(still.to_bits(), x.to_bits());
            moved += usize::from(place != x && place != y);
        }
        assert!(moved > 300_000, "{moved}");
    }
}
