//! The part of a primitive that lies in a cell, and on which side of a plane it is.
//!
//! *Why nothing is lost.* Let `p` be a point of a primitive, and `δ` the [pad](crate::accel::cells::Space::pad) of the scene
//! times the plane's [reach](super::node::Slanted::reach). A fragment goes to the lower side alone only where none of it lies
//! above the plane by more than `δ`; it is cut only where it reaches beyond `δ` on both sides. So by induction there is
//! a leaf that names the primitive such that `p` lies above none of the planes, whose lower side leads there, by more than
//! `δ`, and below none of the others. The rounding of corners that cuts make (2⁻⁵⁰ of the coordinates) is far less than `δ`,
//! and the walk allows for `2 δ`.

use super::node::{Plane, Slanted, halves, wide};
use super::polyhedron::{Point, clip, cross, dot, sub};
use crate::accel::cells::Space;
use crate::geometry::{Aabb, Vec3};
use crate::math;
use crate::primitive::Primitives;
use alloc::vec::Vec;

/// The part of a primitive in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fragment {
    /// Around it.
    pub bounds: Aabb,
    pub id: u32,
    /// Its corners in [`Fragments::corners`]; none where it counts as a box.
    first: u32,
    count: u32,
}

/// What lies in a cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Fragments {
    pub list: Vec<Fragment>,
    corners: Vec<Point>,
}

/// Where something lies: below and above may both be true, or both false for what lies in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    pub below: bool,
    pub above: bool,
}

/// On which sides a box lies of a plane across an axis.
#[inline(always)]
pub(super) fn side_across(b: &Aabb, axis: usize, at: f32, pad: f32) -> Side {
    Side {
        below: b.lower[axis] < at - pad,
        above: b.upper[axis] > at + pad,
    }
}

impl Fragments {
    /// Adds the part of a primitive that lies in a cell, cut to its slightly larger box.
    pub fn add<P: Primitives>(
        &mut self,
        primitives: &P,
        id: u32,
        bounds: Aabb,
        cell: &Aabb,
        space: &Space,
    ) {
        let first = self.corners.len();
        let triangle = primitives.corners(id as usize);
        if let Some(triangle) = triangle.filter(|_| space.is_exact::<P>()) {
            let around = space.padded(cell);
            let mut polygon: Vec<Point> = triangle.map(wide).into();
            for axis in 0..3 {
                let (lower, upper) = (f64::from(around.lower[axis]), f64::from(around.upper[axis]));
                for (at, sign) in [(lower, -1.0), (upper, 1.0)] {
                    let over = |p: Point| (p[axis] - at) * sign;
                    if polygon.iter().any(|&p| over(p) > 0.0) {
                        let whole = core::mem::take(&mut polygon);
                        clip(&whole, over, &mut polygon);
                    }
                }
            }
            self.corners.extend(polygon);
        }
        self.list.push(Fragment {
            bounds,
            id,
            first: first as u32,
            count: (self.corners.len() - first) as u32,
        });
    }

    pub fn corners(&self, fragment: &Fragment) -> &[Point] {
        &self.corners[fragment.first as usize..][..fragment.count as usize]
    }

    /// On which sides of a plane a fragment lies.
    #[inline(always)]
    pub fn side(&self, fragment: &Fragment, plane: &Plane, pad: f32) -> Side {
        match plane {
            Plane::Across(axis, at) => side_across(&fragment.bounds, *axis, *at, pad),
            Plane::Slanted(plane) => self.side_slanted(fragment, plane, pad),
        }
    }

    fn side_slanted(&self, fragment: &Fragment, plane: &Slanted, pad: f32) -> Side {
        let pad = f64::from(pad) * f64::from(plane.reach);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let corners = self.corners(fragment);
        for &p in corners {
            let at = plane.distance(p);
            least = if at < least { at } else { least };
            most = if at > most { at } else { most };
        }
        if corners.is_empty() {
            // A box reaches as far from its middle as its half diagonal's shadow.
            let (lower, upper) = (wide(fragment.bounds.lower), wide(fragment.bounds.upper));
            let middle = core::array::from_fn(|k| 0.5 * (lower[k] + upper[k]));
            let half: Point = core::array::from_fn(|k| 0.5 * (upper[k] - lower[k]));
            let shadow = dot(half, plane.normal.map(|x| f64::from(x.abs())));
            least = plane.distance(middle) - shadow;
            most = plane.distance(middle) + shadow;
        }
        Side {
            below: least < -pad,
            above: most > pad,
        }
    }

    /// Adds the part of another's fragment that lies below a plane (`sign` 1) or above it (−1).
    pub fn add_part(&mut self, from: &Self, fragment: &Fragment, plane: &Plane, sign: f64) {
        let first = self.corners.len();
        let mut bounds = fragment.bounds;
        clip(
            from.corners(fragment),
            |p| plane.distance(p) * sign,
            &mut self.corners,
        );
        let part = &self.corners[first..];
        if let Plane::Across(axis, at) = plane {
            bounds = halves(&bounds, *axis, *at)[usize::from(sign < 0.0)];
        }
        if !part.is_empty() {
            // A hair larger than the corners rounded to floats, which the pad makes up for.
            let around = Aabb::of(part.iter().map(|p| p.map(|x| x as f32)));
            bounds = bounds.intersection(around);
        }
        if fragment.count > 0 && part.is_empty() || bounds.is_empty() {
            // Too thin to be cut: it stays as it is.
            self.corners.truncate(first);
            return self.add_whole(from, fragment);
        }
        let count = (self.corners.len() - first) as u32;
        self.list.push(Fragment {
            bounds,
            id: fragment.id,
            first: first as u32,
            count,
        });
    }

    /// Adds another's fragment as it is.
    pub fn add_whole(&mut self, from: &Self, fragment: &Fragment) {
        let first = self.corners.len() as u32;
        self.corners.extend_from_slice(from.corners(fragment));
        self.list.push(Fragment { first, ..*fragment });
    }
}

/// The slanted planes that a triangle proposes: its own, and those through its edges at a right angle to it.
pub(super) fn proposals(triangle: [Vec3; 3]) -> [Option<Slanted>; 4] {
    let corners = triangle.map(wide);
    let edges: [Point; 3] = core::array::from_fn(|k| sub(corners[(k + 1) % 3], corners[k]));
    let Some(normal) = unit(cross(edges[0], edges[1])) else {
        return [None; 4];
    };
    let through = |k: usize| {
        let across = unit(cross(edges[k], normal))?;
        Slanted::new(across, &[corners[k], corners[(k + 1) % 3]])
    };
    [
        Slanted::new(normal, &corners),
        through(0),
        through(1),
        through(2),
    ]
}

fn unit(p: Point) -> Option<Point> {
    let length = math::sqrt_f64(dot(p, p));
    (length > 0.0 && length < f64::INFINITY).then(|| p.map(|x| x / length))
}
