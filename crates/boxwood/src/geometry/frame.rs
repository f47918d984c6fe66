//! Boxes seen from the middle of their scene, so that scenes far from the world's origin need no more slack than others.
//!
//! *Why.* The slack of a box test pays for two kinds of errors. Those of the triangle test depend on differences alone, vertex − origin:
//! shear, edges, weights and `t` know nothing of the place where both lie. Those of `plane · inverse − origin · inverse` depend on
//! the coordinates themselves, and a mesh of a metre that stands a thousand kilometres away would pay for the thousand. Seen from a
//! centre among the planes, these too are made of differences.
//!
//! *How it works.* On each axis where the scene lies on one side of zero and its farthest coordinate is at most twice its nearest, the
//! centre is the middle of the scene; on others it is zero. For floats that differ by a factor of two at most, a difference is exact
//! (Sterbenz 1974): so planes are moved to the frame without any rounding, and back to the very same floats. Where a scene reaches from
//! near zero to far away, a centre would gain less than a factor of four. If the largest |coordinate| does not at least halve, all of the
//! centre is zero, and nothing differs from the world's own frame.
//!
//! *The slack.* Let `c` be the centre, `S` the largest |plane − c|, `R` the largest |o − c| on any axis, `u = 2⁻²⁴`. So for
//! each vertex `|V − o| ≤ D`, where `D ≤ S + R`, and on each axis, in units of `u D`, to first order:
//!
//! - Each vertex is sheared to within 6 of its true distance from the ray: 1 for `V − o`, 3 for the product with the slope (its own division,
//!   `z`, the product), 2 for their difference, which is up to `2 D`.
//! - The weights are right to `3 u` each, so the point `P` of the triangle that they name lies within 6 + 3 · 2 = 12 of the ray, along the
//!   third axis.
//! - `t · d` along that axis is within 10 of `P`: 4 for the numerator (`z`, a product, two sums), 2 for `1 / d` and its product, 4 for `r` (two sums,
//!   a division) and its product. With the slopes at most 1, the ray at `t` is within 22 of `P`.
//! - A coordinate of the direction that is raised to `u` times the longest one moves the ray at `t` by 1: 23.
//! - A hit that this does not cover, because products may have left the normal floats, is accepted only within 24 of a point of the triangle
//!   (`triangle::watertight`), hence 25 with the raised direction.
//! - The box test is off by at most `3 S + 4 R` (`1 / d`: 1 each; `plane · inverse` 1; `o · inverse` 1; adding the slack 1; their sum 1
//!   each), whether products are fused or not, and the same by intervals of origins.
//! - The origin's own way into the frame, `o − c` rounded: 1 of `R`.
//!
//! Together 25 + 4 + 1 = 30, and 32 are taken. In the world's frame the last one is exact. `S` is taken as at least 2⁻¹⁶ of the
//! largest |coordinate| in the world, so that what is left over also covers parts of triangles that were cut with errors of 2⁻⁴⁸ of that.
//!
//! *What it is for.* Triangles only. A shape that obeys the rule of its own padded box is held against the world's slack, which must then be
//! that of every box on the way.

use super::ray::round_down;
use super::{Aabb, Vec3};

/// The centre that boxes are seen from, and how far the scene reaches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// The fourth number is zero, for lanes.
    pub centre: [f32; 4],
    /// The largest |coordinate| of the scene in the world: what the doors go by.
    pub scale: f32,
    /// The same seen from the centre: what the slack goes by.
    pub reach: f32,
}

/// By which share of the scale a scene reaches at least from its centre.
const LEAST: f32 = 1.0 / (1 << 16) as f32;

impl Frame {
    /// That of the world itself.
    #[inline(always)]
    pub const fn world(scale: f32) -> Self {
        Self {
            centre: [0.0; 4],
            scale,
            reach: scale,
        }
    }

    /// The one for triangles within these bounds.
    pub fn of(bounds: &Aabb) -> Self {
        let world = Self::world(bounds.scale());
        if bounds.is_empty() {
            return world;
        }
        let middle = |k: usize| middle(bounds.lower[k], bounds.upper[k]);
        let moved = Self {
            centre: [middle(0), middle(1), middle(2), 0.0],
            ..world
        };
        let reach = moved.seen(bounds).scale().max(LEAST * world.scale);
        if reach <= 0.5 * world.scale {
            Self { reach, ..moved }
        } else {
            world
        }
    }

    /// A box within the bounds, seen from the centre; exact.
    #[inline(always)]
    pub fn seen(&self, b: &Aabb) -> Aabb {
        let centre = self.centre();
        Aabb {
            lower: b.lower - centre,
            upper: b.upper - centre,
        }
    }

    /// A box that is seen from the centre, in the world; exact.
    #[inline(always)]
    pub fn in_world(&self, b: &Aabb) -> Aabb {
        let centre = self.centre();
        Aabb {
            lower: b.lower + centre,
            upper: b.upper + centre,
        }
    }

    /// The same for any box, rounded outwards: it holds all that lies in the box.
    #[inline(always)]
    pub fn around_in_world(&self, b: &Aabb) -> Aabb {
        let mut around = *b;
        for k in 0..3 {
            let centre = f64::from(self.centre[k]);
            around.lower[k] = round_down(f64::from(b.lower[k]) + centre);
            around.upper[k] = -round_down(-(f64::from(b.upper[k]) + centre));
        }
        around
    }

    #[inline(always)]
    fn centre(&self) -> Vec3 {
        let [x, y, z, _] = self.centre;
        Vec3::new(x, y, z)
    }
}

/// A float from which all floats of an interval have exact distances: zero or the interval's middle.
fn middle(lower: f32, upper: f32) -> f32 {
    let near = |least: f32, most: f32| least > 0.0 && most <= 2.0 * least;
    if near(lower, upper) || near(-upper, -lower) {
        lower + (upper - lower) * 0.5
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(lower: [f32; 3], upper: [f32; 3]) -> Frame {
        Frame::of(&Aabb::new(lower, upper))
    }

    #[test]
    fn scenes_around_the_origin_stay_where_they_are() {
        for (lower, upper) in [
            ([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
            ([0.0, 0.0, 0.0], [1.0, 2.0, 3.0]),
            // Far on one axis, but farther across another.
            ([100.0, -1.0e3, 0.0], [101.0, 1.0, 1.0]),
            // Far, but not to the point: nine tenths of the way there.
            ([10.0, 10.0, 10.0], [100.0, 100.0, 100.0]),
        ] {
            let frame = frame(lower, upper);
            assert_eq!(frame.centre, [0.0; 4], "{lower:?}");
            assert_eq!(frame.reach, frame.scale, "{lower:?}");
        }
        let none = Frame::of(&Aabb::EMPTY);
        assert_eq!((none.centre, none.scale, none.reach), ([0.0; 4], 0.0, 0.0));
    }

    #[test]
    fn each_axis_has_its_own_centre() {
        let frame = frame([4.99e5, -4.001e6, -3.0], [5.01e5, -3.999e6, 300.0]);
        assert_eq!(frame.centre, [5.0e5, -4.0e6, 0.0, 0.0]);
        assert_eq!((frame.scale, frame.reach), (4.001e6, 1.0e3));
        // A scene without extent reaches a little.
        let point = self::frame([1024.0; 3], [1024.0; 3]);
        assert_eq!((point.scale, point.reach), (1024.0, 1.0 / 64.0));
    }

    /// There and back, every float is the same, and the way there is not rounded.
    #[test]
    fn moving_is_exact() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            state >> 9
        };
        for exponent in [0, 1, 2, 60, 127, 160, 250, 254] {
            for _ in 0..10_000 {
                let mut ends = [(); 4].map(|()| {
                    let x = f32::from_bits(exponent << 23 | next());
                    if x > 0.0 { x } else { 1.0 }
                });
                ends.sort_by(f32::total_cmp);
                let [lower, a, b, mut upper] = ends;
                if upper > 2.0 * lower {
                    upper = lower;
                }
                let (a, b) = (a.clamp(lower, upper), b.clamp(lower, upper));
                let bounds = Aabb::new([lower, -upper, lower], [upper, -lower, upper]);
                let frame = Frame::of(&bounds);
                assert_ne!(frame.centre[0], 0.0, "{bounds:?}");
                let part = Aabb::new([a.min(b), -b.max(a), lower], [a.max(b), -a.min(b), upper]);
                let seen = frame.seen(&part);
                assert_eq!(frame.in_world(&seen), part);
                assert_eq!(frame.around_in_world(&seen), part);
                // A little more on each side, which need not be a float in the world.
                let mut larger = seen;
                for k in 0..3 {
                    larger.lower[k] = seen.lower[k].next_down();
                    larger.upper[k] = seen.upper[k].next_up();
                }
                assert!(frame.around_in_world(&larger).contains(&part));
                for k in 0..3 {
                    let around = frame.around_in_world(&larger);
                    let exact = |x: f32| f64::from(x) + f64::from(frame.centre[k]);
                    assert!(f64::from(around.lower[k]) <= exact(larger.lower[k]));
                    assert!(f64::from(around.upper[k]) >= exact(larger.upper[k]));
                }
                for k in 0..3 {
                    let exact = f64::from(part.lower[k]) - f64::from(frame.centre[k]);
                    assert_eq!(f64::from(seen.lower[k]), exact);
                    assert!(seen.upper[k].abs() <= frame.reach);
                }
            }
        }
    }
}
