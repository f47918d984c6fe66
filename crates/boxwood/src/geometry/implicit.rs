//! Implicit surfaces: where a function of space is zero.
//!
//! *How it works.* The part of the ray in the surface's box is halved again and again, near half first. A piece is given
//! up only when it is *proven* to hold no root: the user's bound of the function over it ([`Implicit::enclose`]) does not
//! contain zero. Where the bound of the slope does not contain zero either, the function is monotone, its signs at the ends
//! say whether there is one root, and that one is searched directly. A piece of `2⁻²⁴` of the way that is still undecided
//! holds a root when the sign changes in it, and a touching (double) root when the function comes as near to zero there as
//! `2⁻⁴⁰` of its largest value in the box; touching pieces with such roots are one root.
//!
//! So no root is skipped, but for pairs nearer to each other than one piece; they count as one.
//!
//! *Cost.* A simple root takes some thirty pieces. Roots of higher order take a few per halving where the slope is
//! known, and thousands with a Lipschitz constant alone. After [`MAX_PIECES`] pieces the rest of the ray is decided by the signs at the
//! ends of what is left: a function that is zero along the ray, or NaN, ends too.
//!
//! *Source:* Kalra & Barr 1989, *Guaranteed Ray Intersections with Implicit Surfaces* (Lipschitz); Mitchell 1990, *Robust Ray
//! Intersection with Interval Arithmetic*; the centred form is Moore's.

use super::double::{Line, along, dot, length, sub};
use super::interval::Interval;
use super::real::{Dual, Real};
use super::shape::{Place, Root, Shape, ShapeFlaw};
use super::{Aabb, roots};
use core::ops::ControlFlow::{self, Continue};

/// At most so many pieces of a ray are looked at, each with one value and one enclosure.
pub const MAX_PIECES: u32 = 1 << 16;
/// The smallest piece is `2⁻²⁴` of the way through the box.
const DEEPEST: u8 = 24;

/// A function of space whose zeros are a surface, and a bound that can prove where it is not zero.
///
/// Where a formula is all there is, implement [`Formula`] instead: it knows its bounds by itself. A wrong bound loses roots, as
/// does a wrong box; neither panics nor hangs.
///
/// ```
/// use boxwood::{Aabb, BruteForce, Enclosure, Implicit, ImplicitSurface, Intersect, Ray, Segment, Shapes};
///
/// /// A ball by its distance, which changes by at most one unit per unit: the Lipschitz constant is 1.
/// struct Ball;
/// impl Implicit for Ball {
///     fn bounds(&self) -> Aabb {
///         Aabb::new([-1.0; 3], [1.0; 3])
///     }
///     fn value(&self, [x, y, z]: [f64; 3]) -> f64 {
///         (x * x + y * y + z * z).sqrt() - 1.0
///     }
///     fn enclose(&self, part: &Segment) -> Enclosure {
///         part.lipschitz(self.value(part.middle()), 1.0)
///     }
/// }
/// let ball = BruteForce::new(Shapes::new([ImplicitSurface(Ball)])?);
/// let hits = ball.all_hits(&Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]));
/// assert_eq!(hits.iter().map(|h| h.t).collect::<Vec<_>>(), [2.0, 4.0]);
/// # Ok::<(), boxwood::ShapeError>(())
/// ```
pub trait Implicit {
    /// A box around all of the surface that is to be seen; what lies outside does not exist.
    fn bounds(&self) -> Aabb;
    /// The function; negative inside by convention, as normals point to where it grows.
    fn value(&self, p: [f64; 3]) -> f64;
    /// Its derivatives by x, y and z. By default central differences, right to about six digits.
    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        let step = (f64::from(self.bounds().scale())) * (1.0 / (1 << 18) as f64);
        let mut gradient = [0.0; 3];
        for (axis, slope) in gradient.iter_mut().enumerate() {
            let (mut a, mut b) = (p, p);
            a[axis] -= step;
            b[axis] += step;
            *slope = (self.value(b) - self.value(a)) / (b[axis] - a[axis]);
        }
        gradient
    }
    /// What the function and its slope can be on a part of a ray: from a Lipschitz constant
    /// ([`Segment::lipschitz`], [`Segment::smooth`]) or in interval arithmetic over [`Segment::points`].
    fn enclose(&self, part: &Segment) -> Enclosure;
    /// The `u` and `v` of hits at a point of the surface; 0 by default.
    fn uv(&self, _p: [f64; 3]) -> [f32; 2] {
        [0.0; 2]
    }
}

/// A function written once for all kinds of numbers: its values, bounds and derivatives follow, and so does [`Implicit`].
///
/// ```
/// use boxwood::{Aabb, BruteForce, Formula, ImplicitSurface, Intersect, Ray, Real, Shapes};
///
/// struct Gyroid;
/// impl Formula for Gyroid {
///     fn bounds(&self) -> Aabb {
///         Aabb::new([-4.0; 3], [4.0; 3])
///     }
///     fn at<T: Real>(&self, [x, y, z]: [T; 3]) -> T {
///         x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
///     }
/// }
/// let gyroid = BruteForce::new(Shapes::new([ImplicitSurface(Gyroid)])?);
/// let ray = Ray::new([-4.0, 0.1, 0.2], [1.0, 0.05, 0.1]);
/// assert!(gyroid.closest_hit(&ray).is_some());
/// # Ok::<(), boxwood::ShapeError>(())
/// ```
pub trait Formula {
    /// A box around all of the surface that is to be seen.
    fn bounds(&self) -> Aabb;
    /// The function; negative inside by convention.
    fn at<T: Real>(&self, p: [T; 3]) -> T;
    /// The `u` and `v` of hits at a point of the surface; 0 by default.
    fn uv(&self, _p: [f64; 3]) -> [f32; 2] {
        [0.0; 2]
    }
}

impl<F: Formula> Implicit for F {
    fn bounds(&self) -> Aabb {
        Formula::bounds(self)
    }
    fn value(&self, p: [f64; 3]) -> f64 {
        self.at(p)
    }
    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let mut p = p.map(Dual::<f64>::from);
            p[axis].slope = 1.0;
            self.at(p).slope
        })
    }
    fn enclose(&self, part: &Segment) -> Enclosure {
        let mut p = part.points().map(|value| Dual {
            value,
            slope: Interval::from(0.0),
        });
        for (p, d) in p.iter_mut().zip(part.line.direction) {
            p.slope = Interval::from(d);
        }
        let all = self.at(p);
        Enclosure {
            values: all.value,
            slopes: all.slope,
        }
    }
    fn uv(&self, p: [f64; 3]) -> [f32; 2] {
        Formula::uv(self, p)
    }
}

/// What a function can be on a part of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosure {
    /// Holds every value of the function there.
    pub values: Interval,
    /// Holds every derivative of the function by the ray's `t` there; [`Interval::ALL`] when nothing is known.
    pub slopes: Interval,
}

/// A part of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    line: Line,
    from: f64,
    to: f64,
}

impl Segment {
    fn middle_t(&self) -> f64 {
        0.5 * self.from + 0.5 * self.to
    }
    /// The point half way.
    pub fn middle(&self) -> [f64; 3] {
        self.line.at(self.middle_t())
    }
    /// Half its length in world units.
    pub fn reach(&self) -> f64 {
        // A few roundings more, so that no point lies beyond.
        0.5 * (self.to - self.from) * length(self.line.direction) * (1.0 + f64::EPSILON * 8.0)
    }
    /// The coordinates of its points.
    pub fn points(&self) -> [Interval; 3] {
        let t = Interval::new(self.from, self.to);
        let Line { origin, direction } = self.line;
        [0, 1, 2].map(|k| Interval::from(origin[k]) + t * Interval::from(direction[k]))
    }
    /// The enclosure of a function that changes by at most `constant` per unit of length, from its value in the
    /// [`Segment::middle`].
    pub fn lipschitz(&self, value: f64, constant: f64) -> Enclosure {
        let change = constant.abs() * self.reach();
        let slope = constant.abs() * length(self.line.direction);
        Enclosure {
            values: Interval::new(value - change, value + change),
            slopes: Interval::new(-slope, slope),
        }
    }
    /// The same of a function whose *gradient* changes by at most `constant` per unit of length, from its value and gradient
    /// in the middle. Far narrower than [`Segment::lipschitz`] where the ray nearly touches the surface.
    pub fn smooth(&self, value: f64, gradient: [f64; 3], constant: f64) -> Enclosure {
        let (reach, speed) = (self.reach(), length(self.line.direction));
        let slope = dot(gradient, self.line.direction);
        let bend = constant.abs() * reach;
        // The slope where it is largest, over half the way, would be too much by a half.
        let change = slope.abs() * 0.5 * (self.to - self.from) * (1.0 + f64::EPSILON * 8.0)
            + 0.5 * bend * reach;
        Enclosure {
            values: Interval::new(value - change, value + change),
            slopes: Interval::new(slope - bend * speed, slope + bend * speed),
        }
    }
}

/// An implicit surface as a shape: `Shapes::new([ImplicitSurface(f)])`.
///
/// A hit's `u` and `v` are what [`Implicit::uv`] says. The normal is the gradient's direction; where that is zero (a point
/// of a cone, a function that touches zero without crossing it) there may be none, and it reads as zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitSurface<F>(
    /// The function.
    pub F,
);

/// A piece of a ray that may hold roots.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    from: (f64, f64),
    to: (f64, f64),
    depth: u8,
}

/// Undecided pieces that touch each other.
struct Run {
    end: f64,
    /// The least |value| and where it is.
    least: (f64, f64),
    /// Whether roots in it were shown already, because the sign changes there.
    crosses: bool,
}

/// The search along one ray.
struct Search<'a, F, V> {
    function: &'a F,
    line: Line,
    /// Values this small are zero.
    tolerance: f64,
    run: Option<Run>,
    /// The root that was shown last.
    shown: f64,
    t_max: f64,
    visit: V,
}

impl<F: Implicit, V: FnMut(Root) -> ControlFlow<(), f64>> Search<'_, F, V> {
    fn value(&self, t: f64) -> f64 {
        self.function.value(self.line.at(t))
    }

    fn show(&mut self, t: f64) -> ControlFlow<()> {
        // A root on the border of two pieces is found from both sides.
        if t <= self.shown + self.shown.abs() * (1.0 / (1_u64 << 46) as f64) {
            return Continue(());
        }
        self.shown = t;
        (self.visit)(Root { t, part: 0 }).map_continue(|t_max| self.t_max = t_max)
    }

    /// The touching root of a run of pieces that ends before `from`.
    fn close_run(&mut self, from: f64) -> ControlFlow<()> {
        match self.run.take_if(|run| run.end < from) {
            Some(run) if !run.crosses => self.show(run.least.0),
            _ => Continue(()),
        }
    }

    /// A sign change is one root.
    fn cross(&mut self, a: (f64, f64), b: (f64, f64)) -> ControlFlow<()> {
        if !changes_sign(a.1, b.1) {
            return Continue(());
        }
        let (function, line) = (self.function, self.line);
        let root = roots::crossing(&mut |t| function.value(line.at(t)), a, b);
        self.show(root)
    }

    /// Roots of a piece that is as small as pieces get, or was proven to be as good as zero.
    fn decide(&mut self, piece: &Piece, middle: (f64, f64)) -> ControlFlow<()> {
        let crosses = changes_sign(piece.from.1, middle.1) || changes_sign(middle.1, piece.to.1);
        let mut least = piece.from;
        for sample in [middle, piece.to] {
            if sample.1.abs() < least.1.abs() || least.1.is_nan() {
                least = sample;
            }
        }
        if !crosses && !(least.1.abs() <= self.tolerance) {
            return Continue(());
        }
        let before = self.run.take();
        let touches = before.filter(|run| run.end >= piece.from.0);
        let mut run = Run {
            end: piece.to.0,
            least,
            crosses,
        };
        if let Some(before) = touches {
            run.crosses |= before.crosses;
            if before.least.1.abs() <= least.1.abs() {
                run.least = before.least;
            }
        }
        self.run = Some(run);
        self.cross(piece.from, middle)?;
        self.cross(middle, piece.to)
    }

    fn run(&mut self, from: f64, to: f64) -> ControlFlow<()> {
        let mut stack = [Piece::default(); DEEPEST as usize + 2];
        stack[0] = Piece {
            from: (from, self.value(from)),
            to: (to, self.value(to)),
            depth: 0,
        };
        let mut waiting = 1;
        let mut pieces = 0;
        while waiting > 0 {
            waiting -= 1;
            let piece = stack[waiting];
            let (a, b) = (piece.from.0, piece.to.0);
            self.close_run(a)?;
            if self.run.is_none() && a > self.t_max {
                return Continue(());
            }
            if pieces == MAX_PIECES {
                // No more proofs: what is left is decided by its ends alone.
                let ends = (b, piece.to.1);
                self.decide(&piece, ends)?;
                continue;
            }
            pieces += 1;
            let part = Segment {
                line: self.line,
                from: a,
                to: b,
            };
            let Enclosure { values, slopes } = self.function.enclose(&part);
            if !values.contains(0.0) {
                continue;
            }
            if slopes.lower() > 0.0 || slopes.upper() < 0.0 {
                self.cross(piece.from, piece.to)?;
                continue;
            }
            let m = part.middle_t();
            let middle = (m, self.value(m));
            // Moore's centred form: f(m) + f'(T) (T − m).
            let half = Interval::new(a - m, b - m);
            let noise = Interval::new(-self.tolerance, self.tolerance);
            let centred = Interval::from(middle.1) + slopes * half + noise;
            if !centred.contains(0.0) {
                continue;
            }
            let flat = values.magnitude() <= self.tolerance;
            if piece.depth == DEEPEST || flat || !(a < m && m < b) {
                self.decide(&piece, middle)?;
                continue;
            }
            let depth = piece.depth + 1;
            stack[waiting] = Piece {
                from: middle,
                to: piece.to,
                depth,
            };
            stack[waiting + 1] = Piece {
                from: piece.from,
                to: middle,
                depth,
            };
            waiting += 2;
        }
        self.close_run(f64::INFINITY)
    }
}

fn changes_sign(a: f64, b: f64) -> bool {
    (a < 0.0 && b >= 0.0) || (a >= 0.0 && b < 0.0)
}

impl<F: Implicit> ImplicitSurface<F> {
    /// Where a line runs through a box that is a little larger, so that roots on its sides are inside.
    fn part(&self, line: &Line) -> Option<(f64, f64)> {
        let bounds = self.0.bounds();
        let margin = f64::from(bounds.scale()) * (1.0 / (1 << 22) as f64);
        let lower = bounds.lower.to_array().map(|x| f64::from(x) - margin);
        let upper = bounds.upper.to_array().map(|x| f64::from(x) + margin);
        let chord = line.slabs(lower, upper)?;
        let from = chord.enter.max(0.0);
        (from <= chord.leave && chord.leave < f64::INFINITY).then_some((from, chord.leave))
    }

    /// The largest |value| that is known to be possible on the way, or one that occurs.
    fn largest(&self, line: &Line, from: f64, to: f64) -> f64 {
        let part = Segment {
            line: *line,
            from,
            to,
        };
        let bound = self.0.enclose(&part).values.magnitude();
        if bound < f64::INFINITY {
            return bound;
        }
        [from, part.middle_t(), to]
            .into_iter()
            .map(|t| self.0.value(line.at(t)).abs())
            .filter(|value| value.is_finite())
            .fold(0.0, f64::max)
    }
}

impl<F: Implicit> Shape for ImplicitSurface<F> {
    const NAME: &'static str = "implicit surface";

    fn check(&self) -> Result<(), ShapeFlaw> {
        Ok(())
    }

    fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    fn meet(
        &self,
        line: &Line,
        t_max: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let Some((from, to)) = self.part(line) else {
            return Continue(());
        };
        if from > t_max {
            return Continue(());
        }
        Search {
            function: &self.0,
            line: *line,
            tolerance: self.largest(line, from, to) * (1.0 / (1_u64 << 40) as f64),
            run: None,
            shown: f64::NEG_INFINITY,
            t_max,
            visit,
        }
        .run(from, to)
    }

    /// The surface nearby: a hit's `t` is right to a rounding, so there is no need to search the whole ray again.
    fn root(&self, _: &Line, t: f32) -> Root {
        Root {
            t: f64::from(t),
            part: 0,
        }
    }

    fn place(&self, near: [f64; 3], _: u8) -> Place {
        let mut p = near;
        let value = |p| self.0.value(p);
        // Newton's steps down the gradient, while they help.
        let mut best = value(p).abs();
        for _ in 0..4 {
            let gradient = self.0.gradient(p);
            let step = -value(p) / dot(gradient, gradient);
            let next = along(p, gradient, step);
            let size = value(next).abs();
            if !(size < best) {
                break;
            }
            (p, best) = (next, size);
        }
        // A step is as long as the rounding of the hit; anything longer led to another part of the surface.
        let moved = sub(p, near);
        let far = f64::from(self.0.bounds().scale()) + length(near);
        if !(length(moved) <= far * (1.0 / (1 << 16) as f64)) {
            p = near;
        }
        Place {
            position: p,
            normal: super::double::normalized(self.0.gradient(p)),
            uv: self.0.uv(p),
        }
    }

    fn error(&self) -> f64 {
        f64::from(self.0.bounds().scale()) * (1.0 / (1_u64 << 32) as f64)
    }
}
