//! What a single shape says of itself, so that numbered sets of it can be made.
//!
//! *How it works.* A shape computes in double precision on the exact line of the ray, and each root is rounded once to
//! the float `t` of a hit. What a root is never depends on the ray's interval: that only chooses among the roots, so a
//! query that has already found something sees the same bits as one that has not.
//! [`Shapes`](crate::Shapes) turns any `Shape` into [`Primitives`](crate::Primitives) and [`Surfaces`](crate::Surfaces).

use super::Aabb;
use super::double::Line;
use core::ops::ControlFlow::{self, Continue};

/// A shape that a line meets in points.
pub trait Shape {
    /// The shape's name in messages: `sphere`, `torus`.
    const NAME: &'static str;

    /// Whether its numbers make sense. [`Shapes::new`](crate::Shapes::new) asks once; every other method may rely on it.
    ///
    /// # Errors
    /// What is wrong with it.
    fn check(&self) -> Result<(), ShapeFlaw>;

    /// The tightest float box that holds all of it, rounded outward; empty when nothing can hit it.
    fn bounds(&self) -> Aabb;

    /// Around the part of it that lies in a box.
    fn clipped_bounds(&self, within: &Aabb) -> Aabb {
        self.bounds().intersection(*within)
    }

    /// Shows the points where the line meets the shape to `visit`, in order of `t`, each once; a line that touches the
    /// shape meets it once. Points with `t < 0` may be shown or left out.
    ///
    /// Nothing beyond `t_max` counts; `visit` answers with the new end, or breaks. A shape need not look at either.
    fn meet(
        &self,
        line: &Line,
        t_max: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()>;

    /// The shape near a point that is off it by rounding errors only.
    fn place(&self, near: [f64; 3], part: u8) -> Place;

    /// The root that was rounded to a hit's `t`. By default the line is met again.
    fn root(&self, line: &Line, t: f32) -> Root {
        let t = f64::from(t);
        let mut best = Root { t, part: 0 };
        let mut distance = f64::INFINITY;
        // The visitor never breaks, so there is nothing to learn from the flow.
        let _ = self.meet(line, f64::INFINITY, &mut |root| {
            if (root.t - t).abs() < distance {
                (best, distance) = (root, (root.t - t).abs());
            }
            Continue(f64::INFINITY)
        });
        best
    }

    /// How far [`Shape::meet`] may put the surface from where [`Shape::place`] puts it, in world units.
    fn error(&self) -> f64 {
        f64::from(self.bounds().scale()) * (1.0 / (1_u64 << 40) as f64)
    }
}

/// A point where a line meets a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Distance in lengths of the line's direction.
    pub t: f64,
    /// Which part of the shape, where it has several.
    pub part: u8,
}

/// A point of a surface in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The point, world units.
    pub position: [f64; 3],
    /// Unit normal to the outside, or to the front of what has no inside; zero where there is none.
    pub normal: [f64; 3],
    /// The `u` and `v` of hits.
    pub uv: [f32; 2],
}

/// What is wrong with a shape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeFlaw {
    /// A number is infinite or NaN.
    #[error("its {0} is not finite")]
    NotFinite(&'static str),
    /// A length must not be negative.
    #[error("its {what} must not be negative, but is {value}")]
    Negative {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f32,
    },
    /// A direction has no length, or edges span no volume.
    #[error("its {0} is zero")]
    Zero(&'static str),
    /// Two numbers are in the wrong order.
    #[error("its {smaller} must be {than} its {larger}")]
    Order {
        /// What should be smaller.
        smaller: &'static str,
        /// `less than` or `at most`.
        than: &'static str,
        /// What should be larger.
        larger: &'static str,
    },
    /// Its box does not fit into floats.
    #[error("it reaches beyond the floats")]
    TooLarge,
}

/// The first of the numbers that is not finite is named.
pub(crate) fn all_finite<const N: usize>(
    numbers: [(&'static str, [f32; 3]); N],
) -> Result<(), ShapeFlaw> {
    for (what, value) in numbers {
        if !value.iter().all(|x| x.is_finite()) {
            return Err(ShapeFlaw::NotFinite(what));
        }
    }
    Ok(())
}

/// A length that is zero or more.
pub(crate) fn length_is_good(what: &'static str, value: f32) -> Result<(), ShapeFlaw> {
    all_finite([(what, [value; 3])])?;
    if value < 0.0 {
        return Err(ShapeFlaw::Negative { what, value });
    }
    Ok(())
}

/// A direction that is not zero.
pub(crate) fn direction_is_good(what: &'static str, value: [f32; 3]) -> Result<(), ShapeFlaw> {
    all_finite([(what, value)])?;
    if value == [0.0; 3] {
        return Err(ShapeFlaw::Zero(what));
    }
    Ok(())
}

/// Why a set of shapes was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// A shape does not make sense.
    #[error("{name} {index}: {flaw}")]
    Flaw {
        /// What kind of shape.
        name: &'static str,
        /// Which one.
        index: usize,
        /// What is wrong with it.
        flaw: ShapeFlaw,
    },
    /// Primitives are numbered with 32 bits, of which the last number means "none".
    #[error("there are {0} primitives, but at most 4294967294 can be numbered")]
    TooMany(usize),
}
