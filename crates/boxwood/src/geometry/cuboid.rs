//! Boxes as things to be seen: along the axes, and turned.
//!
//! *How it works.* Three pairs of slabs (Kay & Kajiya 1986), in double precision; the slab that is entered last and the one
//! that is left first name the faces. *Cost:* 24 bytes along the axes, 144 turned; six divisions.

use super::double::{Chord, Line, along, cross, dot, normalized, outward, sub};
use super::shape::{Place, Root, Shape, ShapeFlaw, all_finite};
use super::{Aabb, Vec3};
use core::ops::ControlFlow::{self, Continue};

/// A solid box along the axes, met from outside and from inside; it may be flat. A ray that runs in a face hits it where
/// it crosses the edges.
///
/// `u` and `v` run from 0 to 1 over the face, along the two axes that follow the face's own (x → y z, y → z x, z → x y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Smallest coordinates, world units.
    pub lower: Vec3,
    /// Largest coordinates, world units.
    pub upper: Vec3,
}

impl Cuboid {
    /// A box from its smallest and largest coordinates.
    pub fn new(lower: impl Into<[f32; 3]>, upper: impl Into<[f32; 3]>) -> Self {
        Self {
            lower: lower.into().into(),
            upper: upper.into().into(),
        }
    }
}

/// How far along `[lower, upper]`; 0 where both are equal.
fn fraction(x: f64, lower: f64, upper: f64) -> f32 {
    if lower < upper {
        ((x - lower) / (upper - lower)).clamp(0.0, 1.0) as f32
    } else {
        0.0
    }
}

impl Shape for Cuboid {
    const NAME: &'static str = "cuboid";

    fn check(&self) -> Result<(), ShapeFlaw> {
        all_finite([
            ("lower corner", self.lower.to_array()),
            ("upper corner", self.upper.to_array()),
        ])?;
        if self.bounds().is_empty() {
            return Err(ShapeFlaw::Order {
                smaller: "lower corner",
                than: "at most",
                larger: "upper corner",
            });
        }
        Ok(())
    }

    fn bounds(&self) -> Aabb {
        Aabb::new(self.lower, self.upper)
    }

    #[inline]
    fn meet(
        &self,
        line: &Line,
        _: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let lower = self.lower.to_array().map(f64::from);
        let upper = self.upper.to_array().map(f64::from);
        match line.slabs(lower, upper) {
            Some(chord) => chord.visit_ends(visit),
            None => Continue(()),
        }
    }

    fn place(&self, near: [f64; 3], part: u8) -> Place {
        let lower = self.lower.to_array().map(f64::from);
        let upper = self.upper.to_array().map(f64::from);
        let (axis, high) = (usize::from(part / 2).min(2), part % 2 == 1);
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut position = near;
        position[axis] = if high { upper[axis] } else { lower[axis] };
        let mut normal = [0.0; 3];
        normal[axis] = if high { 1.0 } else { -1.0 };
        let f = |k: usize| fraction(near[k], lower[k], upper[k]);
        Place {
            position,
            normal,
            uv: [f(a), f(b)],
        }
    }
}

/// A solid box in any position, given by its centre and three half edges. They need not be at right angles: a skewed box
/// is as good.
///
/// `u` and `v` as for [`Cuboid`], along the edges in place of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedCuboid {
    centre: Vec3,
    half_edges: [Vec3; 3],
    /// Unit normals of the faces that the half edges point to, and how far those faces are from the centre.
    normals: [[f64; 3]; 3],
    heights: [f64; 3],
}

impl OrientedCuboid {
    /// A box whose faces lie at `centre ± half_edges[k]`, world units.
    pub fn new<V: Into<[f32; 3]>>(centre: impl Into<[f32; 3]>, half_edges: [V; 3]) -> Self {
        let half_edges = half_edges.map(|e| Vec3::from(e.into()));
        let edges = half_edges.map(|e| e.to_array().map(f64::from));
        let mut normals = [[0.0; 3]; 3];
        let mut heights = [0.0; 3];
        for k in 0..3 {
            let normal = normalized(cross(edges[(k + 1) % 3], edges[(k + 2) % 3]));
            let height = dot(normal, edges[k]);
            let sign = 1.0_f64.copysign(height);
            normals[k] = normal.map(|x| x * sign);
            heights[k] = height.abs();
        }
        Self {
            centre: centre.into().into(),
            half_edges,
            normals,
            heights,
        }
    }
    /// The centre, world units.
    pub fn centre(&self) -> Vec3 {
        self.centre
    }
    /// From the centre to the middles of three faces.
    pub fn half_edges(&self) -> [Vec3; 3] {
        self.half_edges
    }
}

impl Shape for OrientedCuboid {
    const NAME: &'static str = "oriented cuboid";

    fn check(&self) -> Result<(), ShapeFlaw> {
        let [a, b, c] = self.half_edges.map(Vec3::to_array);
        all_finite([
            ("centre", self.centre.to_array()),
            ("first half edge", a),
            ("second half edge", b),
            ("third half edge", c),
        ])?;
        if self.heights.iter().all(|&h| h > 0.0) {
            Ok(())
        } else {
            Err(ShapeFlaw::Zero("volume"))
        }
    }

    fn bounds(&self) -> Aabb {
        let centre = self.centre.to_array().map(f64::from);
        let mut half = [0.0; 3];
        for edge in self.half_edges {
            half = along(half, edge.abs().to_array().map(f64::from), 1.0);
        }
        outward(sub(centre, half), along(centre, half, 1.0))
    }

    #[inline]
    fn meet(
        &self,
        line: &Line,
        _: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let l = sub(line.origin, self.centre.to_array().map(f64::from));
        let mut chord = Chord::ALL;
        for (axis, (n, h)) in self.normals.iter().zip(self.heights).enumerate() {
            let (o, d) = (dot(l, *n), dot(line.direction, *n));
            match chord.within_slab(-h, h, o, d, axis as u8) {
                Some(rest) => chord = rest,
                None => return Continue(()),
            }
        }
        chord.visit_ends(visit)
    }

    fn place(&self, near: [f64; 3], part: u8) -> Place {
        let (axis, high) = (usize::from(part / 2).min(2), part % 2 == 1);
        let l = sub(near, self.centre.to_array().map(f64::from));
        let at = |k: usize| dot(l, self.normals[k]);
        let outward = if high { 1.0 } else { -1.0 };
        let normal = self.normals[axis].map(|x| x * outward);
        let height = self.heights[axis];
        let f = |k: usize| fraction(at(k), -self.heights[k], self.heights[k]);
        Place {
            position: along(near, normal, height - dot(l, normal)),
            normal,
            uv: [f((axis + 1) % 3), f((axis + 2) % 3)],
        }
    }
}
