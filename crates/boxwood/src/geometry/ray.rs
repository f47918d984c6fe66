//! Rays, and rays made ready to meet boxes and triangles.

use super::frame::Frame;
use super::{Aabb, Vec3};
use crate::math;
use crate::simd::{F, Floats, Lanes, Mask, Portable, U, Words};
use core::ops::Deref;

/// A half line with a closed interval `[t_min, t_max]`; 32 bytes. The direction may have any length; `t` counts in it.
///
/// A negative `t_min` reads as 0 and an infinite `t_max` as the largest float. A ray with a NaN anywhere, with a zero
/// or infinite direction, an infinite origin or `t_min > t_max` misses everything.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Where `t = 0`.
    pub origin: Vec3,
    /// Smallest `t` that counts.
    pub t_min: f32,
    /// From `t = 0` to `t = 1`.
    pub direction: Vec3,
    /// Largest `t` that counts.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end: `[0, ∞]`.
    #[inline(always)]
    pub fn new(origin: impl Into<[f32; 3]>, direction: impl Into<[f32; 3]>) -> Self {
        Self {
            origin: origin.into().into(),
            direction: direction.into().into(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }
    /// From one point to another, which are `t = 0` and `t = 1`, both included.
    #[inline(always)]
    pub fn between(from: impl Into<[f32; 3]>, to: impl Into<[f32; 3]>) -> Self {
        let from = Vec3::from(from.into());
        Self::new(from, Vec3::from(to.into()) - from).until(1.0)
    }
    /// The same ray, starting at `t_min`.
    #[inline(always)]
    pub fn from(self, t_min: f32) -> Self {
        Self { t_min, ..self }
    }
    /// The same ray, ending at `t_max`.
    #[inline(always)]
    pub fn until(self, t_max: f32) -> Self {
        Self { t_max, ..self }
    }
    /// `t_max` as queries read it: an infinite one is the largest float, so that nothing is ever hit at infinity.
    #[inline(always)]
    pub fn end(&self) -> f32 {
        if self.t_max > f32::MAX {
            f32::MAX
        } else {
            self.t_max
        }
    }
    /// The point at `t`.
    #[inline(always)]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// `u`: half the distance from 1 to the next float, the bound of one rounding.
const UNIT: f32 = 1.0 / (1 << 24) as f32;
/// 2⁻²⁰ and 2²⁸: between them no operation of the triangle test leaves the normal floats.
const TINY_SCENE: f32 = 1.0 / (1_u64 << 20) as f32;
const HUGE: f32 = (1_u64 << 28) as f32;

/// For each axis the two after it, in a circle, and itself. The fourth is for a mask that names none.
static ROUND: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];
/// The same for lanes.
const ROUND_LANES: [[u32; 4]; 4] = [[1, 2, 0, 3], [2, 0, 1, 3], [0, 1, 2, 3], [0, 1, 2, 3]];

/// Of the first three lanes, in each of them.
#[inline(always)]
fn largest<S: Lanes<4>>(s: S, v: F<S, 4>) -> F<S, 4> {
    let [next, last] = [
        U::<S, 4>::from_nibbles(s, 0x3021),
        U::<S, 4>::from_nibbles(s, 0x3102),
    ];
    v.max(v.permute(next)).max(v.permute(last))
}

/// A ray with all that box and triangle tests need. Read the ray's own fields through it; `t_min` and `t_max` are
/// already in order there.
///
/// *Boxes are conservative.* A triangle hit that the canonical test accepts lies, with its computed `t`, within
/// `28 u (S + R)` of the triangle's box, where `S` is the largest |coordinate| of the scene and `R` that of the origin
/// (4 u more for the rounding of the slab test itself). So every box is met as if it were `32 u (S + R)` larger on each
/// side, and no structure can lose a hit that the judge finds. Coordinates of the direction that are nearly zero are
/// raised to `u` times the largest, which keeps the reciprocals finite and moves the ray by less than the slack.
/// The sum is drawn up in `geometry/frame.rs`, also for scenes far away whose boxes are seen from their middle.
///
/// *Doors.* That proof holds for scenes of size 2⁻²⁰ to 2²⁸ and directions of length 2⁻²⁸ to 2²⁸. Outside, the ray is
/// not [`tame`](PreparedRay::is_tame): direction and triangles are scaled by powers of two to sizes near 1, boxes are met
/// in double precision, and a hit must then lie in its own padded box. A tame ray's hit whose products were too small for the
/// proof must lie near its triangle in double precision.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    ray: Ray,
    /// `1 / direction`, raised as above. Of these four the last number means nothing: they are what lanes leave.
    inverse: [f32; 4],
    /// What is added to `plane · inverse` to get where the ray enters a slab, and where it leaves.
    enter: [f32; 4],
    leave: [f32; 4],
    pub(crate) leaning: Leaning,
    slack: f64,
    /// The power of two in the scaled direction; 0 when the ray is tame.
    scaled: f32,
}

/// What the triangle test needs of a ray. It is read from memory, number by number, at each leaf: a choice among registers
/// by the ray's axes would be branches that rays in any order mispredict.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaning {
    /// The axis of the largest |direction|, after the two that follow it in a circle.
    pub axes: &'static [usize; 3],
    /// The origin in the order of `axes`. The fourth number means nothing.
    pub origin: [f32; 4],
    /// `d[kx] / d[kz]`, `d[ky] / d[kz]` and `1 / d[kz]`, for a ray that is not tame those of the scaled direction.
    pub shear: [f32; 3],
    /// The start of its interval.
    pub t_min: f32,
}

/// What slab tests need of a ray, in lanes: who walks on with it at once has it in registers.
pub(crate) struct Facing<S: Lanes<4>> {
    inverse: F<S, 4>,
    enter: F<S, 4>,
    leave: F<S, 4>,
}

impl<S: Lanes<4>> Facing<S> {
    /// Coordinates of the direction are raised to `floor` at least.
    #[inline(always)]
    fn new(s: S, origin: F<S, 4>, direction: F<S, 4>, floor: F<S, 4>, slack: f32) -> Self {
        // Not the sign's bit: `crossing` counts a zero of either sign as going up, and adding zero makes them one.
        let towards = direction + F::<S, 4>::splat(s, 0.0);
        let inverse = F::<S, 4>::splat(s, 1.0) / direction.abs().max(floor).signed_as(towards);
        let pad = inverse.abs() * F::<S, 4>::splat(s, slack);
        let zero = F::<S, 4>::splat(s, 0.0);
        let back = (zero - origin) * inverse;
        Self {
            inverse,
            enter: back - pad,
            leave: back + pad,
        }
    }

    /// As [`PreparedRay::slab_terms`].
    #[inline(always)]
    pub fn slab_terms(&self) -> [[f32; 4]; 3] {
        [
            self.inverse.to_array(),
            self.enter.to_array(),
            self.leave.to_array(),
        ]
    }

    /// The same with `times` the slack, or a little less where that is lost to rounding.
    #[inline(always)]
    pub fn slackened(self, s: S, times: f32) -> Self {
        let [enter, leave] = slackened(s, [self.enter, self.leave], times);
        Self {
            enter,
            leave,
            ..self
        }
    }

    /// Which axes the ray runs down, a bit each.
    #[inline(always)]
    pub fn down(&self, s: S) -> u32 {
        self.inverse.lt(F::<S, 4>::splat(s, 0.0)).bits() & 7
    }
}

/// Where slabs are entered and left with `times` the slack: half of what lies between both is the slack.
#[inline(always)]
fn slackened<S: Lanes<4>>(s: S, [enter, leave]: [F<S, 4>; 2], times: f32) -> [F<S, 4>; 2] {
    let more = (leave - enter) * F::<S, 4>::splat(s, 0.5 * (times - 1.0));
    [enter - more, leave + more]
}

impl PreparedRay {
    /// What the longest coordinate of a tame ray's direction is above, and what all coordinates are less than (packets, which may
    /// refuse more, ask it of their sums).
    pub(crate) const DOORS: [f32; 2] = [HUGE.recip(), HUGE];
    /// Whether rays can be tame in a scene whose largest |coordinate| is `scale`.
    #[inline(always)]
    pub(crate) fn is_tame_scene(scale: f32) -> bool {
        (TINY_SCENE < scale) & (scale < HUGE)
    }
    /// How many units of the largest |coordinates| of scene and origin the slack is.
    pub(crate) const SLACK: f32 = 32.0 * UNIT;
    /// To how many units of the longest coordinate of a direction the others are raised.
    pub(crate) const FLOOR: f32 = UNIT;

    /// No ray: what a place holds before there is one.
    pub(crate) const IDLE: Self = Self {
        ray: Ray {
            origin: Vec3::ZERO,
            t_min: 0.0,
            direction: Vec3::ZERO,
            t_max: 0.0,
        },
        inverse: [0.0; 4],
        enter: [0.0; 4],
        leave: [0.0; 4],
        leaning: Leaning {
            axes: &[0, 1, 2],
            origin: [0.0; 4],
            shear: [0.0; 3],
            t_min: 0.0,
        },
        slack: 0.0,
        scaled: 0.0,
    };

    /// Makes a ray ready for a scene whose largest |coordinate| is `scale`; `None` when it can hit nothing.
    #[inline]
    pub fn new(ray: &Ray, scale: f32) -> Option<Self> {
        match Self::tame(Portable, ray, &Frame::world(scale), Self::SLACK) {
            None => Self::wild(ray, scale),
            Some((ready, _)) => Some(ready),
        }
    }

    /// The same for a ray inside the doors; `None` for any other. Without a branch but that one, all axes at once. The
    /// slack is `slack` units large, by right [`Self::SLACK`]. Boxes must be those that the frame [sees](Frame::seen).
    #[inline(always)]
    pub(crate) fn tame<S: Lanes<4>>(
        s: S,
        ray: &Ray,
        frame: &Frame,
        slack: f32,
    ) -> Option<(Self, Facing<S>)> {
        let (o, d) = (&ray.origin, &ray.direction);
        // A comparison that fails for NaN, not `max`, which would lose it.
        let t_min = if ray.t_min < 0.0 { 0.0 } else { ray.t_min };
        let t_max = ray.end();
        // As they lie in memory. The fourth lane goes with the others and reaches none of them; but it must not be `t_max`, whose
        // reciprocal may be subnormal, which takes the processor a hundred cycles in each of three operations.
        let origin = F::<S, 4>::load(s, &[o.x, o.y, o.z, ray.t_min]);
        let direction = F::<S, 4>::load(s, &[d.x, d.y, d.z, ray.t_max]);
        let direction = direction.permute(U::<S, 4>::from_nibbles(s, 0x2210));
        let seen = origin - F::<S, 4>::load(s, &frame.centre);
        let (size, distance) = (direction.abs(), origin.abs());
        let [largest, reach] = [largest(s, size), largest(s, seen.abs())];
        let huge = F::<S, 4>::splat(s, HUGE);
        // Comparisons that fail for NaN and infinity.
        let inside =
            distance.lt(huge) & size.lt(huge) & F::<S, 4>::splat(s, HUGE.recip()).lt(largest);
        if !((inside.bits() & 7 == 7) & (t_min <= t_max) & Self::is_tame_scene(frame.scale)) {
            return None;
        }
        // The lowest axis wins a tie.
        let kz = largest.le(size).bits().trailing_zeros() as usize % 4;
        let round = U::<S, 4>::load(s, &ROUND_LANES[kz]);
        let across = direction.permute(round);
        let shear = (across / across.permute(U::<S, 4>::from_nibbles(s, 0x2222))).to_array();
        let [reach, ..] = reach.to_array();
        let slack = slack * (frame.reach + reach);
        let floor = largest * F::<S, 4>::splat(s, Self::FLOOR);
        let facing = Facing::new(s, seen, direction, floor, slack);
        let first = |v: F<S, 4>| {
            let [x, y, z, _] = v.to_array();
            Vec3::new(x, y, z)
        };
        let ready = Self {
            // Out of the lanes: copied from memory, it would be read in larger pieces than it was written in, which waits.
            ray: Ray {
                origin: first(origin),
                t_min,
                direction: first(direction),
                t_max,
            },
            leaning: Leaning {
                axes: &ROUND[kz],
                origin: origin.permute(round).to_array(),
                shear: [shear[0], shear[1], facing.inverse.to_array()[kz]],
                t_min,
            },
            slack: f64::from(slack),
            ..Self::IDLE
        };
        Some((ready.facing(&facing), facing))
    }

    /// For any other ray.
    #[cold]
    fn wild(ray: &Ray, scale: f32) -> Option<Self> {
        let (o, d) = (ray.origin, ray.direction);
        let t_min = if ray.t_min < 0.0 { 0.0 } else { ray.t_min };
        let t_max = ray.end();
        let kz = d.abs().max_axis();
        let largest = d.abs()[kz];
        if !(t_min <= t_max && o.is_finite() && d.is_finite() && largest > 0.0) {
            return None;
        }
        let axes @ &[kx, ky, _] = &ROUND[kz];
        let reach = o.abs().max_element();
        let slack = 32.0 * f64::from(UNIT) * (f64::from(scale) + f64::from(reach));
        let power = math::power_to_one(largest);
        let d = d * power;
        let ready = Self {
            ray: Ray {
                t_min,
                t_max,
                ..*ray
            },
            leaning: Leaning {
                axes,
                origin: [o[kx], o[ky], o[kz], 0.0],
                shear: [d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]],
                t_min,
            },
            slack,
            scaled: power,
            ..Self::IDLE
        };
        let lanes = |v: Vec3| F::<Portable, 4>::load(Portable, &[v.x, v.y, v.z, 0.0]);
        let floor = F::<Portable, 4>::splat(Portable, Self::FLOOR * d[kz].abs());
        Some(ready.facing(&Facing::new(
            Portable,
            lanes(o),
            lanes(d),
            floor,
            slack as f32,
        )))
    }

    #[inline(always)]
    fn facing<S: Lanes<4>>(self, facing: &Facing<S>) -> Self {
        let [inverse, enter, leave] = facing.slab_terms();
        Self {
            inverse,
            enter,
            leave,
            ..self
        }
    }

    /// Whether the proof of the slack holds for this ray and scene without further checks.
    #[inline(always)]
    pub fn is_tame(&self) -> bool {
        self.scaled == 0.0
    }

    /// The power of two that the direction behind [`Self::shear`] was multiplied with; `None` when the ray is tame.
    #[inline(always)]
    pub(crate) fn scaled(&self) -> Option<f32> {
        (!self.is_tame()).then_some(self.scaled)
    }

    /// `1 / direction`, and what is added to `plane · inverse` to get where the ray enters and leaves a slab.
    #[inline(always)]
    pub(crate) fn slab_terms(&self) -> [[f32; 4]; 3] {
        [self.inverse, self.enter, self.leave]
    }

    /// The same with `times` the slack, or a little less.
    #[inline(always)]
    pub(crate) fn slackened_terms<S: Lanes<4>>(&self, s: S, times: f32) -> [[f32; 4]; 3] {
        let terms = [&self.enter, &self.leave].map(|term| F::<S, 4>::load(s, term));
        let [enter, leave] = slackened(s, terms, times);
        [self.inverse, enter.to_array(), leave.to_array()]
    }

    /// `1 / direction`, where coordinates that are nearly zero are raised: finite for a tame ray, and right to 1 u.
    #[inline(always)]
    pub(crate) fn inverse(&self) -> Vec3 {
        let [x, y, z, _] = self.inverse;
        Vec3::new(x, y, z)
    }

    /// Where the ray enters and leaves a box, both erring to the outside by the slack; it is entered where
    /// `enter <= leave`. Neither number knows of the ray's interval.
    ///
    /// Only rounded operations that are monotone in the planes: a larger box is entered no later and left no earlier.
    /// Nothing is promised of an empty box, which a ray may seem to enter.
    #[inline(always)]
    pub fn slabs(&self, b: &Aabb) -> (f32, f32) {
        if !self.is_tame() {
            return self.slabs_f64(b);
        }
        let (mut enter, mut leave) = (f32::NEG_INFINITY, f32::INFINITY);
        for axis in 0..3 {
            let l = b.lower[axis] * self.inverse[axis];
            let u = b.upper[axis] * self.inverse[axis];
            // Written out: each is one instruction, while `f32::min` is five for the sake of NaN.
            let near = (if l < u { l } else { u }) + self.enter[axis];
            let far = (if l > u { l } else { u }) + self.leave[axis];
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        (enter, leave)
    }

    /// The same in double precision, for rays and scenes outside the doors: nothing overflows, and a direction of zero
    /// is asked where it lies.
    #[cold]
    fn slabs_f64(&self, b: &Aabb) -> (f32, f32) {
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let o = f64::from(self.ray.origin[axis]);
            let d = f64::from(self.ray.direction[axis]);
            let lower = f64::from(b.lower[axis]) - self.slack;
            let upper = f64::from(b.upper[axis]) + self.slack;
            if !(lower <= upper) || d == 0.0 && !(lower <= o && o <= upper) {
                return (f32::INFINITY, f32::NEG_INFINITY);
            }
            if d == 0.0 {
                continue;
            }
            let (first, last) = if d < 0.0 {
                (upper, lower)
            } else {
                (lower, upper)
            };
            enter = enter.max((first - o) / d);
            leave = leave.min((last - o) / d);
        }
        (round_down(enter), -round_down(-leave))
    }

    /// Where the ray crosses a plane across an axis, `(early, late)`, erring by the slack to either side.
    ///
    /// What lies before the plane along the ray's way (below it when `direction[axis] >= 0`, else above) and is met at
    /// `t`, has `t <= late`; what lies behind it has `t >= early`. Monotone in the plane, as [`Self::slabs`].
    #[inline(always)]
    pub fn crossing(&self, axis: usize, plane: f32) -> (f32, f32) {
        if !self.is_tame() {
            return self.crossing_f64(axis, plane);
        }
        let at = plane * self.inverse[axis];
        (at + self.enter[axis], at + self.leave[axis])
    }

    /// What [`Self::crossing`] computes with for a tame ray, by axis: `plane · [0] − [1]` and `plane · [0] − [2]`.
    #[inline(always)]
    pub(crate) fn crossings(&self) -> [[f32; 3]; 3] {
        [0, 1, 2].map(|axis| [self.inverse[axis], self.enter[axis], self.leave[axis]])
    }

    #[cold]
    fn crossing_f64(&self, axis: usize, plane: f32) -> (f32, f32) {
        let o = f64::from(self.ray.origin[axis]);
        let d = f64::from(self.ray.direction[axis]);
        let (lower, upper) = (f64::from(plane) - self.slack, f64::from(plane) + self.slack);
        if d == 0.0 {
            // Never crossed: all of the ray lies on one side, or so near that it counts for both.
            let early = if o < lower {
                f32::INFINITY
            } else {
                f32::NEG_INFINITY
            };
            let late = if o > upper {
                f32::NEG_INFINITY
            } else {
                f32::INFINITY
            };
            return (early, late);
        }
        let (first, last) = if d < 0.0 {
            (upper, lower)
        } else {
            (lower, upper)
        };
        (round_down((first - o) / d), -round_down(-((last - o) / d)))
    }

    /// How far a hit's point on the ray may be from the point of the surface that it stands for, on each axis, in world
    /// units: `32 u (S + R)`, of whatever frame the ray is made for.
    #[inline]
    pub fn slack(&self) -> f64 {
        self.slack
    }

    /// Where the ray enters a box within `[t_min, t_max]`; `None` when it does not. Conservative, as [`Self::slabs`].
    #[inline(always)]
    pub fn enters(&self, b: &Aabb, t_max: f32) -> Option<f32> {
        let (enter, leave) = self.slabs(b);
        (enter <= leave && enter <= t_max && self.ray.t_min <= leave).then_some(enter)
    }

    /// Whether the point at `t` lies in a box. Conservative, as [`Self::slabs`].
    #[inline]
    pub fn is_inside(&self, b: &Aabb, t: f32) -> bool {
        let (enter, leave) = self.slabs(b);
        enter <= t && t <= leave
    }
}

/// The largest float not above `x`.
pub(crate) fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x {
        nearest.next_down()
    } else {
        nearest
    }
}

impl Deref for PreparedRay {
    type Target = Ray;
    #[inline(always)]
    fn deref(&self) -> &Ray {
        &self.ray
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_two_bytes() {
        assert_eq!(size_of::<Ray>(), 32);
    }

    #[test]
    fn hopeless_rays_stop_at_the_door() {
        let good = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
        assert!(PreparedRay::new(&good, 1.0).is_some());
        assert!(PreparedRay::new(&good.from(-1.0).until(0.0), 1.0).is_some());
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        for bad in [
            good.from(2.0).until(1.0),
            good.until(-1.0),
            good.until(nan),
            good.from(nan),
            Ray::new([0.0; 3], [0.0, -0.0, 0.0]),
            Ray::new([0.0; 3], [0.0, inf, 1.0]),
            Ray::new([0.0; 3], [0.0, nan, 1.0]),
            Ray::new([nan, 0.0, 0.0], [0.0, 0.0, 1.0]),
            Ray::new([0.0, inf, 0.0], [0.0, 0.0, 1.0]),
        ] {
            assert!(PreparedRay::new(&bad, 1.0).is_none(), "{bad:?}");
        }
    }

    #[test]
    fn ends_are_put_in_order() {
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]).from(-3.0);
        let ray = PreparedRay::new(&ray, 1.0).expect("a good ray");
        assert_eq!((ray.t_min, ray.t_max), (0.0, f32::MAX));
    }

    /// The slab test of structures never misses a box that the plain one enters, whatever the scale.
    #[test]
    fn conservative_at_every_scale() {
        let values = [0.0, -0.0, 1.0e-30, 1.0, -1.0, 0.3, 1.0e9, -1.0e30];
        let mut entered = 0;
        for scale in [1.0e-30, 1.0e-3, 1.0, 1.0e6, 1.0e30_f32] {
            let b = Aabb::new([-scale, 0.0, scale], [scale, 0.5 * scale, 2.0 * scale]);
            for code in 0..8_usize.pow(3) {
                let d = [values[code % 8], values[code / 8 % 8], values[code / 64]];
                for o in [[0.0; 3], [0.0, 0.0, scale], [-2.0 * scale; 3]] {
                    let ray = Ray::new(o, d);
                    let Some((enter, _)) = b.intersect(&ray) else {
                        continue;
                    };
                    let Some(prepared) = PreparedRay::new(&ray, b.scale()) else {
                        continue;
                    };
                    entered += 1;
                    let found = prepared.enters(&b, f32::MAX).expect("entered");
                    assert!(found <= enter, "{ray:?}: {found} > {enter}");
                }
            }
        }
        assert!(entered > 500, "{entered}");
    }
}
