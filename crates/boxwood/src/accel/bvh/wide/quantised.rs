//! Boxes as bytes on a grid that each node has for itself.
//!
//! *How it works.* Across each axis a node has a grid whose steps are a power of two, the least one for which 255 of them span its
//! children, and which begins at a multiple of the step. A lower plane is the last grid line at or below a box, an upper one the
//! first at or above it: so the box on the grid holds the box.
//!
//! *Why no slack is lost.* Every line is a multiple of the step by a number of less than 24 bits, hence a float: the step is no less than the distance of
//! floats where the farthest of the children's planes lies. So `origin + byte · step` is exact, fused or not, and what is met is an ordinary
//! box of floats around the one that was built, with the error bounds of all others (`geometry/frame.rs`). Such a plane is at most one
//! step beyond the scene, a 63rd of its reach: that makes 3 `S` of the sum there into less than 3.05, and there is room for 2.
//!
//! *What does not fit.* Sides beyond 2⁹⁶ and infinite ones make the whole axis of the node unbounded, which only rays outside the doors come to see.
//! A box that nothing can hit, because it is empty or has a side that is no number, is empty on the grid too.
//!
//! *Source.* Mahovsky & Wyvill 2006, *Memory-Conserving Bounding Volume Hierarchies with Coherent Raytracing*; Ylitie, Karras & Laine 2017 (steps that
//! are powers of two); Benthin et al. 2018, *Compressed-Leaf Bounding Volume Hierarchies*.

use super::boxes::Boxes;
use crate::geometry::{Aabb, Vec3};
use crate::simd::{ByteRows, F, Floats, Lanes, Row, plain};

/// Boxes on a grid: 64 bytes for 8 children.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(4))]
pub struct Quantised<const N: usize> {
    /// Lower x, upper x, lower y, upper y, lower z, upper z, in steps.
    lines: ByteRows<N, 6>,
    /// Where the grid begins: a multiple of the step.
    origin: [f32; 3],
    /// ```text
    /// 31 ...... 24  23 ...... 16  15 ....... 8  7 ........ 0
    /// children      step of z     step of y     step of x      as exponents of floats; 255: unbounded
    /// ```
    steps: u32,
}
plain!(Quantised<N> { lines: ByteRows<N, 6>, origin: [f32; 3], steps: u32 });

/// The step of an axis without a grid.
const UNBOUNDED: u32 = 255;
/// A grid spans planes below this: 2⁹⁶.
const FAR: f32 = (1_u128 << 96) as f32;
/// The most steps.
const SPAN: f64 = 255.0;

/// By the number of children: how far a ray may go in each lane.
struct Ends<const N: usize>;

impl<const N: usize> Ends<N> {
    /// More rows than children, so that a mask finds one.
    const TABLE: &'static [[f32; N]; 32] = &{
        let mut table = [[-1.0; N]; 32];
        let mut children = 0;
        while children < 32 {
            let mut lane = 0;
            while lane < N && lane < children {
                table[children][lane] = f32::INFINITY;
                lane += 1;
            }
            children += 1;
        }
        table
    };
}

impl<const N: usize> Quantised<N> {
    /// The exponent of an axis' step, as a float has it.
    #[inline(always)]
    fn exponent(&self, axis: usize) -> u32 {
        self.steps >> (8 * axis) & 255
    }

    /// The step of an axis; infinite where there is no grid.
    #[inline(always)]
    fn step(&self, axis: usize) -> f32 {
        f32::from_bits(self.exponent(axis) << 23)
    }

    /// Lays the grid of an axis around planes, and the planes onto it; leaves the axis unbounded where that cannot be.
    fn lay(&mut self, axis: usize, boxes: &[Aabb]) {
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for b in boxes.iter().filter(|b| !b.is_empty()) {
            let (lower, upper) = (b.lower[axis], b.upper[axis]);
            if !(lower.abs() < FAR && upper.abs() < FAR) {
                self.steps |= UNBOUNDED << (8 * axis);
                return;
            }
            (least, most) = (least.min(lower), most.max(upper));
        }
        if least > most {
            // Nothing is there.
            (least, most) = (0.0, 0.0);
        }
        let (exponent, first) = grid(least, most);
        let step = f64::from(f32::from_bits(exponent << 23));
        self.steps |= exponent << (8 * axis);
        self.origin[axis] = (first * step) as f32;
        for (lane, b) in boxes.iter().enumerate().filter(|(_, b)| !b.is_empty()) {
            // Division by a power of two is exact, and both lines lie on the grid.
            let lower = floor(f64::from(b.lower[axis]) / step) - first;
            let upper = -floor(-f64::from(b.upper[axis]) / step) - first;
            self.lines.0[2 * axis][lane] = lower as u8;
            self.lines.0[2 * axis + 1][lane] = upper as u8;
        }
    }
}

/// The least exponent of a step, as a float has it, by which a grid of [`SPAN`] steps covers an interval, and how many steps from zero
/// it begins.
fn grid(least: f32, most: f32) -> (u32, f64) {
    let exponent = |x: f32| x.to_bits() >> 23 & 255;
    // Floats as far away as the ends are multiples of this, and of no less; the least normal float is the finest step.
    let finest = exponent(least.abs().max(most.abs()))
        .saturating_sub(23)
        .max(1);
    // With this one there are 128 to 256 steps between the ends.
    let spanned = exponent(most - least).saturating_sub(7);
    let mut exponent = finest.max(spanned);
    loop {
        let step = f64::from(f32::from_bits(exponent << 23));
        let first = floor(f64::from(least) / step);
        if -floor(-f64::from(most) / step) - first <= SPAN {
            return (exponent, first);
        }
        exponent += 1;
    }
}

/// The greatest whole number that is not above a number of at most 25 bits before the point.
fn floor(x: f64) -> f64 {
    let whole = x as i64 as f64;
    if whole > x { whole - 1.0 } else { whole }
}

impl<const N: usize> Boxes<N> for Quantised<N> {
    const ROUNDED: bool = true;

    fn new(boxes: &[Aabb]) -> Self {
        // An empty box ends before it begins.
        let (first, last) = ([0; N], [255; N]);
        let mut new = Self {
            lines: ByteRows([last, first, last, first, last, first]),
            origin: [0.0; 3],
            steps: (boxes.len() as u32) << 24,
        };
        for axis in 0..3 {
            new.lay(axis, boxes);
        }
        new
    }

    #[inline(always)]
    fn bounds(&self, lane: usize) -> Aabb {
        let side = |axis: usize, k: usize| {
            let line = f32::from(self.lines.0[2 * axis + k][lane]);
            line * self.step(axis) + self.origin[axis]
        };
        let (mut lower, mut upper) = (Vec3::ZERO, Vec3::ZERO);
        for axis in 0..3 {
            (lower[axis], upper[axis]) = if self.exponent(axis) == UNBOUNDED {
                (f32::NEG_INFINITY, f32::INFINITY)
            } else {
                (side(axis, 0), side(axis, 1))
            };
        }
        Aabb { lower, upper }
    }

    #[inline(always)]
    fn planes<S: Lanes<N>>(&self, s: S, axis: usize, near: Row<N, 6>) -> [F<S, N>; 2] {
        let step = F::<S, N>::splat(s, self.step(axis));
        let origin = F::<S, N>::splat(s, self.origin[axis]);
        let near_lines = F::<S, N>::from_bytes(s, self.lines.at(near));
        let far_lines = F::<S, N>::from_bytes(s, self.lines.at(near.neighbour()));
        [
            near_lines.times_more(step, origin),
            far_lines.times_more(step, origin),
        ]
    }

    #[inline(always)]
    fn ends<S: Lanes<N>>(&self, s: S, t_max: F<S, N>) -> F<S, N> {
        // On a fine grid, planes at the wrong ends may still lie within the slack.
        let children = (self.steps >> 24) as usize & 31;
        F::<S, N>::load(s, &Ends::<N>::TABLE[children]).min(t_max)
    }

    fn middles(&self) -> [[f32; N]; 3] {
        let mut middles = [[0.0; N]; 3];
        for lane in 0..N {
            let Aabb { lower, upper } = self.bounds(lane);
            for axis in 0..3 {
                middles[axis][lane] = lower[axis] + upper[axis];
            }
        }
        middles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::bvh::wide::node::Node;
    use crate::simd::{Kernel, Level, Simd, Vectorize};
    use alloc::vec::Vec;

    /// The planes of all axes as lanes see them, and how far rays go.
    struct Seen<'a>(&'a Quantised<8>);

    impl Kernel<8> for Seen<'_> {
        type Output = [[f32; 8]; 7];
        #[inline(always)]
        fn run<S: Simd + Lanes<8>>(self, s: S) -> Self::Output {
            let mut seen = [[0.0; 8]; 7];
            for axis in 0..3 {
                let [lower, upper] = self.0.planes(s, axis, Row::new(2 * axis));
                (seen[2 * axis], seen[2 * axis + 1]) = (lower.to_array(), upper.to_array());
            }
            let t_max = F::<S, 8>::splat(s, 9.0);
            seen[6] = self.0.ends(s, t_max).to_array();
            seen
        }
    }

    /// Boxes around a place, of sizes up to a size.
    fn boxes(count: usize, at: f32, size: f32, next: &mut impl FnMut() -> f32) -> Vec<Aabb> {
        let side = |next: &mut dyn FnMut() -> f32| at + size * next();
        (0..count)
            .map(|_| {
                let mut ends = [(); 6].map(|()| side(next));
                for axis in 0..3 {
                    if ends[axis] > ends[axis + 3] {
                        ends.swap(axis, axis + 3);
                    }
                }
                let [a, b, c, d, e, f] = ends;
                Aabb::new([a, b, c], [d, e, f])
            })
            .collect()
    }

    #[test]
    fn boxes_on_the_grid_hold_their_boxes_at_every_level() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        for at in [0.0, 1.0, -3.0e6, 0.1, 1.0e-30, 7.0e27, -1.0e-44] {
            for size in [1.0, 0.0, 1.0e-7, 1.0e3, 1.0e-42, 1.0e28, 1.7e-20] {
                for count in 0..=8 {
                    let boxes = boxes(count, at, size, &mut next);
                    let grid = Quantised::<8>::new(&boxes);
                    let all = boxes.iter().fold(Aabb::EMPTY, |a, &b| a.union(b));
                    for (lane, b) in boxes.iter().enumerate() {
                        let around = grid.bounds(lane);
                        assert!(around.contains(b), "{around:?} of {b:?}");
                        // No more than a step larger, and a step is no more than a 63rd of all, or the distance of floats.
                        for axis in 0..3 {
                            let whole = f64::from(all.upper[axis]) - f64::from(all.lower[axis]);
                            let far = all.upper[axis].abs().max(all.lower[axis].abs());
                            let apart = f64::from(far.next_up()) - f64::from(far);
                            let step = (whole / 63.0).max(apart).max(f64::from(f32::MIN_POSITIVE));
                            let below = f64::from(b.lower[axis]) - f64::from(around.lower[axis]);
                            let above = f64::from(around.upper[axis]) - f64::from(b.upper[axis]);
                            assert!(below.max(above) <= step, "{around:?} of {b:?}");
                        }
                    }
                    for level in Level::available() {
                        let seen = level.vectorize(Seen(&grid));
                        for lane in 0..8 {
                            let end = if lane < count { 9.0 } else { -1.0 };
                            assert_eq!(seen[6][lane], end, "{}", level.name());
                        }
                        for (lane, _) in boxes.iter().enumerate() {
                            let Aabb { lower, upper } = grid.bounds(lane);
                            for axis in 0..3 {
                                assert_eq!(seen[2 * axis][lane], lower[axis], "{}", level.name());
                                assert_eq!(seen[2 * axis + 1][lane], upper[axis]);
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_unbounded_or_empty() {
        let far = Aabb::new([-1.0, f32::MIN, 2.0], [1.0, f32::MAX, f32::INFINITY]);
        let nan = Aabb::new([f32::NAN; 3], [1.0; 3]);
        let near = Aabb::new([-4.0, 0.0, 0.0], [0.5, 1.0, 1.0]);
        let grid = Quantised::<8>::new(&[far, Aabb::EMPTY, near, nan]);
        let (infinity, none) = (f32::INFINITY, f32::NEG_INFINITY);
        assert_eq!(
            grid.bounds(0),
            Aabb::new([-1.0, none, none], [1.0, infinity, infinity])
        );
        assert_eq!(
            grid.bounds(2),
            Aabb::new([-4.0, none, none], [0.5, infinity, infinity])
        );
        assert!(grid.bounds(1).is_empty() && grid.bounds(3).is_empty());
        let nothing = Quantised::<8>::new(&[Aabb::EMPTY]);
        assert!(nothing.bounds(0).is_empty());
    }

    #[test]
    fn two_lines_of_the_cache() {
        assert_eq!(size_of::<Node<8, Quantised<8>>>(), 128);
    }
}
