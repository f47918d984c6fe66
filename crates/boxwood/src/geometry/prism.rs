//! Figures of the plane as tall prisms: how a scene in two dimensions is made of shapes in three.
//!
//! *How it works.* A figure in the plane z = 0 is drawn out along z, the same way up and down. Rays in that plane meet the
//! prism where they meet the figure, and nobody else has to know about dimensions. Circles are cylinders, rectangles boxes,
//! triangles three half-planes (Cyrus & Beck 1978); a segment is met where its ends lie on both sides of the line. *Cost:*
//! 32 bytes; a division for each edge.

use super::double::{Chord, Line, normalized, outward};
use super::shape::{Place, Root, Shape, ShapeFlaw, all_finite, length_is_good};
use super::{Aabb, Cuboid, Cylinder};
use core::ops::ControlFlow::{self, Continue};

/// A figure of the plane. All but segments are solid: a line meets them where it enters and where it leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Figure {
    /// A straight line between two points, its ends included. A ray that runs along it meets both ends.
    Segment {
        /// One end.
        from: [f32; 2],
        /// The other.
        to: [f32; 2],
    },
    /// All points within a radius.
    Circle {
        /// The middle.
        centre: [f32; 2],
        /// Zero or more; with zero it is never hit.
        radius: f32,
    },
    /// Three corners, in either direction.
    Triangle {
        /// The corners.
        corners: [[f32; 2]; 3],
    },
    /// A box along the axes.
    Rectangle {
        /// Smallest coordinates.
        lower: [f32; 2],
        /// Largest coordinates.
        upper: [f32; 2],
    },
}

impl Figure {
    /// Around the figure, in the plane: smallest and largest coordinates.
    pub fn bounds(&self) -> [[f32; 2]; 2] {
        let around = |points: &[[f32; 2]]| {
            let fold = |pick: fn(f32, f32) -> f32| {
                let start = points.first().copied().unwrap_or_default();
                points
                    .iter()
                    .fold(start, |b, p| [pick(b[0], p[0]), pick(b[1], p[1])])
            };
            [fold(f32::min), fold(f32::max)]
        };
        match *self {
            Self::Segment { from, to } => around(&[from, to]),
            Self::Triangle { corners } => around(&corners),
            Self::Rectangle { lower, upper } => [lower, upper],
            Self::Circle { centre, radius } => {
                [centre.map(|x| x - radius), centre.map(|x| x + radius)]
            }
        }
    }
}

/// A [`Figure`] drawn out along z, from `-half_height` to `half_height`.
///
/// On a side, `u` runs from 0 to 1 along the figure's edge (around a circle) and `v` from the foot to the top, so that it
/// is ½ for every ray in the plane. A rectangle has the `u` and `v` of [`Cuboid`]. The normal points outside; a segment's
/// points to the left of the way from its first end to its second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// What it looks like from above.
    pub figure: Figure,
    /// How far it reaches up and down; more than zero.
    pub half_height: f32,
}

type Double2 = [f64; 2];

fn cross(a: Double2, b: Double2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
fn dot(a: Double2, b: Double2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
fn sub(a: Double2, b: Double2) -> Double2 {
    [a[0] - b[0], a[1] - b[1]]
}
fn flat([x, y, _]: [f64; 3]) -> Double2 {
    [x, y]
}

/// A side of the prism's top and bottom: those that follow the three edges of a triangle.
const BOTTOM: u8 = 4;

impl Prism {
    fn cylinder(&self, [x, y]: [f32; 2], radius: f32) -> Cylinder {
        Cylinder::new([x, y, -self.half_height], [x, y, self.half_height], radius)
    }
    fn cuboid(&self, [x0, y0]: [f32; 2], [x1, y1]: [f32; 2]) -> Cuboid {
        Cuboid::new([x0, y0, -self.half_height], [x1, y1, self.half_height])
    }
    fn height(&self) -> f64 {
        f64::from(self.half_height)
    }

    /// Where a line crosses the wall over a segment.
    fn meet_wall(
        &self,
        ends: [[f32; 2]; 2],
        line: &Line,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let (o, d) = (flat(line.origin), flat(line.direction));
        let [a, b] = ends.map(|end| sub(end.map(f64::from), o));
        let (side_a, side_b) = (cross(d, a), cross(d, b));
        let square = dot(d, d);
        if square == 0.0 || side_a * side_b > 0.0 {
            return Continue(());
        }
        let (along_a, along_b) = (dot(a, d) / square, dot(b, d) / square);
        let mut show = |t: f64| {
            let z = line.origin[2] + t * line.direction[2];
            if z.abs() <= self.height() {
                visit(Root { t, part: 0 })?;
            }
            Continue(())
        };
        if side_a == side_b {
            // Both are zero: the line runs along the segment.
            show(along_a.min(along_b))?;
            return show(along_a.max(along_b));
        }
        // The crossing divides the segment as the distances of its ends from the line do.
        let share = side_a / (side_a - side_b);
        show(along_a + (along_b - along_a) * share)
    }

    /// The part of a line in the prism over a triangle.
    fn chord(&self, corners: [[f32; 2]; 3], line: &Line) -> Option<Chord> {
        let height = self.height();
        let (z, dz) = (line.origin[2], line.direction[2]);
        let mut chord = Chord::ALL.within_slab(-height, height, z, dz, BOTTOM / 2)?;
        let (o, d) = (flat(line.origin), flat(line.direction));
        for (k, [from, outwards]) in edges(corners).into_iter().enumerate() {
            // Inside where `beyond + t · away` is zero or less.
            let (beyond, away) = (dot(outwards, sub(o, from)), dot(outwards, d));
            let t = -beyond / away;
            if away == 0.0 {
                if beyond > 0.0 {
                    return None;
                }
            } else if away < 0.0 && t > chord.enter {
                (chord.enter, chord.sides[0]) = (t, k as u8);
            } else if away > 0.0 && t < chord.leave {
                (chord.leave, chord.sides[1]) = (t, k as u8);
            }
        }
        (chord.enter <= chord.leave).then_some(chord)
    }

    /// The nearest point of the wall from `from` to `to`.
    fn on_wall(&self, near: [f64; 3], [from, to]: [Double2; 2], outwards: Double2) -> Place {
        let edge = sub(to, from);
        let share = (dot(sub(flat(near), from), edge) / dot(edge, edge)).clamp(0.0, 1.0);
        let [x, y] = [0, 1].map(|k| from[k] + edge[k] * share);
        let [nx, ny] = outwards;
        Place {
            position: [x, y, near[2]],
            normal: normalized([nx, ny, 0.0]),
            uv: [share as f32, self.up(near[2])],
        }
    }

    /// How far up a height lies, from 0 to 1.
    fn up(&self, z: f64) -> f32 {
        (0.5 + 0.5 * (z / self.height())).clamp(0.0, 1.0) as f32
    }
}

/// For each edge of a triangle where it begins and its normal to the outside, of any length.
fn edges(corners: [[f32; 2]; 3]) -> [[Double2; 2]; 3] {
    let p = corners.map(|corner| corner.map(f64::from));
    let area = cross(sub(p[1], p[0]), sub(p[2], p[0]));
    [0, 1, 2].map(|k| {
        let [x, y] = sub(p[(k + 1) % 3], p[k]);
        [p[k], if area > 0.0 { [y, -x] } else { [-y, x] }]
    })
}

impl Shape for Prism {
    const NAME: &'static str = "figure";

    fn check(&self) -> Result<(), ShapeFlaw> {
        length_is_good("half height", self.half_height)?;
        if self.half_height == 0.0 {
            return Err(ShapeFlaw::Zero("half height"));
        }
        let solid = |[x, y]: [f32; 2]| [x, y, 0.0];
        match self.figure {
            Figure::Circle { centre, radius } => {
                all_finite([("centre", solid(centre))])?;
                self.cylinder(centre, radius).check()
            }
            Figure::Rectangle { lower, upper } => self.cuboid(lower, upper).check(),
            Figure::Segment { from, to } => {
                all_finite([("one end", solid(from)), ("other end", solid(to))])?;
                if from == to {
                    return Err(ShapeFlaw::Zero("length"));
                }
                Ok(())
            }
            Figure::Triangle { corners } => {
                let [a, b, c] = corners.map(solid);
                all_finite([
                    ("first corner", a),
                    ("second corner", b),
                    ("third corner", c),
                ])?;
                let [p, q, r] = corners.map(|corner| corner.map(f64::from));
                if cross(sub(q, p), sub(r, p)) == 0.0 {
                    return Err(ShapeFlaw::Zero("area"));
                }
                Ok(())
            }
        }
    }

    fn bounds(&self) -> Aabb {
        let [lower, upper] = match self.figure {
            Figure::Circle { centre, radius } => return self.cylinder(centre, radius).bounds(),
            figure => figure.bounds(),
        };
        let corner = |[x, y]: [f32; 2], z: f32| [x, y, z].map(f64::from);
        match self.figure {
            Figure::Rectangle { .. } => self.cuboid(lower, upper).bounds(),
            // Corners are floats, so that nothing is rounded here; but the crossing with an edge is.
            _ => outward(
                corner(lower, -self.half_height),
                corner(upper, self.half_height),
            ),
        }
    }

    #[inline]
    fn meet(
        &self,
        line: &Line,
        t_max: f64,
        visit: &mut impl FnMut(Root) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        match self.figure {
            Figure::Segment { from, to } => self.meet_wall([from, to], line, visit),
            Figure::Circle { centre, radius } => {
                self.cylinder(centre, radius).meet(line, t_max, visit)
            }
            Figure::Rectangle { lower, upper } => {
                self.cuboid(lower, upper).meet(line, t_max, visit)
            }
            Figure::Triangle { corners } => match self.chord(corners, line) {
                Some(chord) => chord.visit_ends(visit),
                None => Continue(()),
            },
        }
    }

    fn place(&self, near: [f64; 3], part: u8) -> Place {
        match self.figure {
            Figure::Segment { from, to } => {
                let ends = [from, to].map(|end| end.map(f64::from));
                let [x, y] = sub(ends[1], ends[0]);
                self.on_wall(near, ends, [-y, x])
            }
            Figure::Circle { centre, radius } => self.cylinder(centre, radius).place(near, part),
            Figure::Rectangle { lower, upper } => self.cuboid(lower, upper).place(near, part),
            Figure::Triangle { corners } if part < BOTTOM => {
                let edges = edges(corners);
                let k = usize::from(part).min(2);
                let ends = [edges[k][0], edges[(k + 1) % 3][0]];
                self.on_wall(near, ends, edges[k][1])
            }
            Figure::Triangle { .. } => {
                let up = if part == BOTTOM { -1.0 } else { 1.0 };
                Place {
                    position: [near[0], near[1], self.height() * up],
                    normal: [0.0, 0.0, up],
                    uv: [0.0, self.up(self.height() * up)],
                }
            }
        }
    }
}
