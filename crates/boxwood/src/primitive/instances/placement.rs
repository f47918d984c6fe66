//! One placement: the way of a ray into an object's space, and the object's box in the world.
//!
//! *The way in.* A point `x` becomes `L (x − c)`, a direction `L d`: `c` is where the object's origin stands, `L` the inverse of
//! the transform's linear part with each number rounded to a float. Both are computed in double precision and rounded once, in
//! one order, so that everybody has the same ray. The direction keeps its length, so that `t` means the same in every space.
//!
//! *The box.* An object's hit lies within the slack `32 u (S' + R')` of the object's boxes, by the numbers `S'`, `R'` of its own space,
//! and the ray has been rounded, which adds 3 of these units at most. Taken into the world by the rows `M` of the transform, each
//! of which adds up to `r = Σ |M|`, that is `35 u r (S' + R')`, and `|M L − 1|` times the way from `c` for the rounding of `L`.
//! What of it is more than the slack that every ray has in the world (28 u (S + R), and 4 for the slab test) is added to
//! the box, for all rays whose origin is at most `4 S` away (`R ≤ 4 S`). So among these no hit is ever lost to the rule that a
//! hit must lie in its primitive's own padded box. Rays from farther away, and transforms that stretch one direction a hundred times as
//! much as another, lose none in practice, but have no proof: boxes grow by `S / 1024` at most.

use super::Instance;
use super::object::Object;
use crate::geometry::ray::round_down;
use crate::geometry::{Aabb, Affine, PreparedRay, Ray, Surface, Vec3};
use crate::math;
use crate::primitive::PARTS_SLACK;

/// What a ray reads of a placement; 88 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    /// `L`, by rows.
    linear: [[f32; 3]; 3],
    /// `c`.
    origin: [f32; 3],
    /// In the world.
    pub bounds: Aabb,
    /// The largest |coordinate| of the box before it is padded.
    pub reach: f32,
    pub object: u32,
    pub mask: u32,
    /// The number of the first placement that it stands for.
    pub first: u32,
}

/// `u`, the bound of one rounding.
const UNIT: f64 = 1.0 / (1 << 24) as f64;
/// The largest number of `M L − 1` of a transform that can be told from a flat one.
const MOST_RESIDUAL: f64 = 1.0 / 256.0;
/// By what share of the world's scale boxes grow at most.
const MOST_PAD: f64 = 1.0 / 1024.0;
/// Boxes end here, so that padded ones still are far from the end of the floats.
const FARTHEST: f64 = f32::MAX as f64 / 4.0;
/// How far away the origins are that boxes are made for, in units of the world's scale.
const REACH: f64 = 4.0;

/// Why a transform cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flaw {
    NotFinite,
    Singular,
    TooLarge,
}

type Matrix = [[f64; 3]; 3];

impl Placement {
    /// Of an instance whose transform and whose place are good. The box is not made yet.
    pub fn new(instance: &Instance, object: &Object) -> Result<Self, Flaw> {
        let placement = Self::of(instance)?;
        let hull = hull(&instance.transform, object.outline());
        let reach = hull.map_or(0.0, |hull| {
            let ends = hull.iter().flatten();
            ends.fold(0.0, |m, x| if x.abs() <= m { m } else { x.abs() })
        });
        if !(reach <= FARTHEST) {
            return Err(Flaw::TooLarge);
        }
        Ok(Self {
            reach: reach as f32,
            ..placement
        })
    }

    /// The same without an object.
    pub fn of(instance: &Instance) -> Result<Self, Flaw> {
        let transform = &instance.transform;
        if !transform.rows.iter().flatten().all(|x| x.is_finite()) {
            return Err(Flaw::NotFinite);
        }
        let inverse = transform.inverse_linear().ok_or(Flaw::Singular)?;
        let placement = Self {
            linear: inverse.map(|row| row.map(|x| x as f32)),
            origin: transform.rows.map(|row| row[3]),
            bounds: Aabb::EMPTY,
            reach: 0.0,
            object: instance.object,
            mask: instance.mask,
            first: 0,
        };
        let residual = residual(&linear(transform), &placement.inverse());
        // A comparison that fails for NaN, which comes of numbers beyond the floats.
        if !residual.iter().flatten().all(|x| *x <= MOST_RESIDUAL) {
            return Err(Flaw::Singular);
        }
        Ok(placement)
    }

    /// The ray in the object's space.
    #[inline]
    pub fn ray(&self, ray: &Ray, t_max: f32) -> Ray {
        let [x, y, z] = self.linear;
        let row = |r: [f32; 3], v: [f64; 3]| {
            let [a, b, c] = r.map(f64::from);
            (a * v[0] + b * v[1] + c * v[2]) as f32
        };
        let all = |v: [f64; 3]| Vec3::new(row(x, v), row(y, v), row(z, v));
        let [o, d] = [ray.origin, ray.direction].map(|v| v.to_array().map(f64::from));
        let [a, b, c] = self.origin.map(f64::from);
        Ray {
            origin: all([o[0] - a, o[1] - b, o[2] - c]),
            t_min: ray.t_min,
            direction: all(d),
            t_max,
        }
    }

    /// Makes the box, for a world whose largest |coordinate| is between half of `scale` and `scale`.
    pub fn set_bounds(&mut self, transform: &Affine, object: &Object, scale: f64) {
        let Some(hull) = hull(transform, object.outline()) else {
            return;
        };
        let lacking = self.lacking(transform, object, &hull, scale, 1.0);
        // Both are straight lines over the distance: one end or the other is the worst.
        let [none, far] = [0.0, REACH * scale].map(lacking);
        let pad = [0, 1, 2].map(|axis| none[axis].max(far[axis]).clamp(0.0, MOST_PAD * scale));
        self.bounds = padded(&hull, pad);
    }

    /// A box in the world around some boxes of the object's, within that of the whole object, for rays from anywhere that meet it with [`PARTS_SLACK`]
    /// times their slack; `None` where the transform is too uneven for a proof.
    pub fn part_bounds(
        &self,
        transform: &Affine,
        object: &Object,
        boxes: &[Aabb],
        scale: f64,
    ) -> Option<Aabb> {
        let Some(hull) = hull(transform, boxes) else {
            return Some(Aabb::EMPTY);
        };
        // A part of the slack is lost to rounding where rays are given it.
        let lacking = self.lacking(
            transform,
            object,
            &hull,
            scale,
            0.875 * f64::from(PARTS_SLACK),
        );
        let [none, far, farther] = [0.0, scale, 1.0e12 * scale].map(lacking);
        // A sum of straight lines and their largest: if it falls at the end, it falls everywhere.
        let proven = (0..3).all(|k| farther[k] <= far[k] && none[k] <= MOST_PAD * scale);
        let pad = none.map(|pad| pad.max(0.0));
        let padded = padded(&hull, pad);
        // Not the common part of both: where they only touch, that could be empty, and is flat so.
        let within = |p: Vec3| {
            let along = |k: usize| p[k].max(self.bounds.lower[k]).min(self.bounds.upper[k]);
            [along(0), along(1), along(2)]
        };
        proven.then(|| Aabb::new(within(padded.lower), within(padded.upper)))
    }

    /// By how much hits may lie farther from the hull along each axis than so many times the slack of a ray in the world, whose
    /// origin is so far away.
    fn lacking(
        &self,
        transform: &Affine,
        object: &Object,
        [lower, upper]: &[[f64; 3]; 2],
        scale: f64,
        slack: f64,
    ) -> impl Fn(f64) -> [f64; 3] {
        let (forth, back) = (linear(transform), self.inverse());
        let residual = residual(&forth, &back);
        let own = f64::from(object.bounds().scale());
        let origin = self.origin.map(f64::from);
        // R', for origins of the world whose coordinates are up to `far`.
        let distance = move |far: f64| {
            let row = |r: [f64; 3]| -> f64 {
                let along = |k: usize| r[k].abs() * (origin[k].abs() + far);
                (0..3).map(along).sum()
            };
            back.map(row).into_iter().fold(0.0, f64::max)
        };
        let least = 0.5 * scale;
        let of_axis = [0, 1, 2].map(|axis: usize| {
            let stretch: f64 = forth[axis].iter().map(|x| x.abs()).sum();
            let displaced: f64 = (0..3)
                .map(|k| {
                    let c = origin[k];
                    residual[axis][k] * (c - lower[k]).abs().max((upper[k] - c).abs())
                })
                .sum();
            (stretch, displaced)
        });
        move |far| {
            of_axis.map(|(stretch, displaced)| {
                let off = 35.0 * UNIT * stretch * (own + distance(far)) + displaced;
                off - slack * 28.0 * UNIT * (least + far)
            })
        }
    }

    /// A surface of the object's in the world, with error bounds that hold there: those of the object's space, and what
    /// the way there and back adds.
    pub fn surface(&self, transform: &Affine, inner: &Surface) -> Surface {
        let p = inner.position.to_array().map(f64::from);
        let position = transform.rows.map(|row| {
            let [a, b, c, d] = row.map(f64::from);
            a * p[0] + b * p[1] + c * p[2] + d
        });
        // Normals go by the transposed way back; so does the thickness of whatever lies along them.
        let back = self.inverse();
        let n = inner.normal.to_array().map(f64::from);
        let along = |k: usize| (0..3).map(|row| back[row][k] * n[row]).sum();
        let normal: [f64; 3] = [along(0), along(1), along(2)];
        let length = math::sqrt_f64(normal.iter().map(|x| x * x).sum());
        let largest = |v: &[f64; 3]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let lost: f64 = residual(&back, &linear(transform))
            .iter()
            .map(|row| (0..3).map(|k| row[k] * p[k].abs()).sum::<f64>())
            .fold(0.0, f64::max);
        let object = f64::from(inner.error) + 1.75 * (lost + 2.0 * UNIT * largest(&p));
        let world = 1.75 * 4.0 * UNIT * largest(&position);
        let error = if length > 0.0 { object / length } else { 0.0 } + world;
        Surface {
            position: Vec3::from(position.map(|x| x as f32)),
            normal: if length > 0.0 {
                Vec3::from(normal.map(|x| (x / length) as f32)).normalized()
            } else {
                Vec3::ZERO
            },
            error: (error as f32).min(f32::MAX),
            ..*inner
        }
    }

    fn inverse(&self) -> Matrix {
        self.linear.map(|row| row.map(f64::from))
    }
}

/// Around some boxes of an object's in the world, in double precision and without any slack: `[lower, upper]`; `None` for none.
fn hull(transform: &Affine, boxes: &[Aabb]) -> Option<[[f64; 3]; 2]> {
    let mut hull = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for part in boxes {
        for (axis, row) in transform.rows.iter().enumerate() {
            let row = row.map(f64::from);
            let (mut lower, mut upper, mut size) = (row[3], row[3], row[3].abs());
            for k in 0..3 {
                let [a, b] = [part.lower, part.upper].map(|p| row[k] * f64::from(p[k]));
                lower += a.min(b);
                upper += a.max(b);
                size += a.abs().max(b.abs());
            }
            // What the sums themselves may be off by.
            let off = size * 4.0 * f64::EPSILON;
            hull[0][axis] = hull[0][axis].min(lower - off);
            hull[1][axis] = hull[1][axis].max(upper + off);
        }
    }
    (!boxes.is_empty()).then_some(hull)
}

/// A hull that is larger by so much along each axis.
fn padded([lower, upper]: &[[f64; 3]; 2], pad: [f64; 3]) -> Aabb {
    let down = |axis: usize| round_down(lower[axis] - pad[axis]);
    let up = |axis: usize| -round_down(-(upper[axis] + pad[axis]));
    Aabb::new([down(0), down(1), down(2)], [up(0), up(1), up(2)])
}

fn linear(transform: &Affine) -> Matrix {
    transform.rows.map(|[a, b, c, _]| [a, b, c].map(f64::from))
}

/// `|A B − 1|`.
fn residual(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|row| {
        core::array::from_fn(|column| {
            let product: f64 = (0..3).map(|k| a[row][k] * b[k][column]).sum();
            (product - f64::from(u8::from(row == column))).abs()
        })
    })
}

const _: () = assert!(PreparedRay::SLACK as f64 == 32.0 * UNIT);
