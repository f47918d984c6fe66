//! Which octants of a cell a primitive lies in.
//!
//! *How it works.* Boxes settle most of it: a primitive whose box lies in one octant lies in that octant, and one whose box
//! lies in the cell and across one plane lies on both sides. A triangle across more is held against all eight octants at
//! once by the theorem of the separating axis. Along each of its lines the shadow of an octant is the sum of the shadows
//! of three intervals, and there are two of those on each axis; so eight tests cost little more than one.
//!
//! *Source.* Akenine-Möller 2001, *Fast 3D Triangle-Box Overlap Testing*.

use crate::accel::Axes;
use crate::accel::cells::Space;
use crate::geometry::double::{cross, dot, sub};
use crate::geometry::{Aabb, Vec3};
use crate::math::{least, most};
use crate::primitive::Primitives;

/// The least and the greatest value.
type Span = [f64; 2];

/// The octants in the lower half of each axis.
const LOW: [u8; 3] = [0b0101_0101, 0b0011_0011, 0b0000_1111];

/// A cell's part on one side of each plane. Along an axis that is not divided the middle is the upper end.
pub(super) fn octant_bounds(cell: &Aabb, middle: Vec3, octant: usize) -> Aabb {
    let mut bounds = *cell;
    for axis in 0..3 {
        if octant >> axis & 1 == 1 {
            bounds.lower[axis] = middle[axis];
        } else {
            bounds.upper[axis] = middle[axis];
        }
    }
    bounds
}

/// A cell that is cut into octants.
pub(super) struct Octants<'a, P> {
    primitives: &'a P,
    space: &'a Space,
    exact: bool,
    bounds: Aabb,
    middle: Vec3,
    /// How many axes are divided, and where their padded halves end and begin. The others have only a lower half.
    divided: [bool; 3],
    low_until: Vec3,
    high_from: Vec3,
    /// By axis, from where to where the padded halves reach, seen from the middle.
    halves: [[Span; 2]; 3],
}

impl<'a, P: Primitives> Octants<'a, P> {
    pub fn of(
        primitives: &'a P,
        space: &'a Space,
        bounds: &Aabb,
        middle: Vec3,
        axes: Axes,
    ) -> Self {
        let [low, high] = [0, 7].map(|octant| space.padded(&octant_bounds(bounds, middle, octant)));
        let seen = |x: f32, axis: usize| f64::from(x) - f64::from(middle[axis]);
        let halves = core::array::from_fn(|k| {
            [low, high].map(|half| [seen(half.lower[k], k), seen(half.upper[k], k)])
        });
        Self {
            primitives,
            space,
            exact: space.is_exact::<P>(),
            bounds: *bounds,
            middle,
            divided: core::array::from_fn(|k| axes.has(k)),
            low_until: low.upper,
            high_from: high.lower,
            halves,
        }
    }

    /// The octants that primitive `i` of the cell, whose box is `around`, overlaps: never none.
    #[inline]
    pub fn overlapped(&self, i: usize, around: &Aabb) -> u8 {
        let mut octants = 0xff_u8;
        let (mut astride, mut one_side) = (0, 0);
        for (axis, &below) in LOW.iter().enumerate() {
            let divided = self.divided[axis];
            let low = !divided || around.lower[axis] <= self.low_until[axis];
            let high = divided && around.upper[axis] >= self.high_from[axis];
            octants &= match (low, high) {
                (true, true) => 0xff,
                (true, false) => below,
                (false, _) => !below,
            };
            if low && high {
                astride += 1;
            } else {
                one_side = axis;
            }
        }
        if astride == 0 || !self.exact {
            return octants;
        }
        let inside = self.bounds.contains(around);
        if inside && astride == 1 {
            return octants;
        }
        let Some(corners) = self.primitives.corners(i) else {
            return self.held(i, octants);
        };
        let mut seen = [[0.0; 3]; 3];
        for (seen, corner) in seen.iter_mut().zip(corners) {
            for (axis, x) in seen.iter_mut().enumerate() {
                *x = f64::from(corner[axis]) - f64::from(self.middle[axis]);
            }
        }
        if inside && astride == 2 {
            // Seen along the third axis, quadrants without an outer end are held against a triangle.
            return self.along(one_side, &seen, octants);
        }
        let mut left = self.above_and_below(&seen, octants);
        for axis in 0..3 {
            if left.is_power_of_two() {
                return left;
            }
            left = self.along(axis, &seen, left);
        }
        left
    }

    /// What is asked of shapes that are no triangles, octant by octant.
    #[cold]
    fn held(&self, i: usize, octants: u8) -> u8 {
        let mut held = 0;
        for octant in 0..8 {
            if octants >> octant & 1 == 1 {
                let bounds = octant_bounds(&self.bounds, self.middle, octant);
                let holds = self.space.holds(self.primitives, i, &bounds);
                held |= u8::from(holds) << octant;
            }
        }
        // Rounding may leave none of them; then all may hold it.
        if held == 0 { octants } else { held }
    }

    /// Those of the octants that the triangle's plane passes through.
    #[inline]
    fn above_and_below(&self, corners: &[[f64; 3]; 3], octants: u8) -> u8 {
        let [p, q, r] = *corners;
        let normal = cross(sub(q, p), sub(r, p));
        // But for rounding the same for all three; by their shadow, the line is a true one whatever its direction.
        let (u, v, w) = (dot(normal, p), dot(normal, q), dot(normal, r));
        let (from, to) = (least(least(u, v), w), most(most(u, v), w));
        let x = shadows(normal[0], &self.halves[0]);
        let y = shadows(normal[1], &self.halves[1]);
        let z = shadows(normal[2], &self.halves[2]);
        let mut missed = 0;
        for (i, z) in z.iter().enumerate() {
            for (j, y) in y.iter().enumerate() {
                for (k, x) in x.iter().enumerate() {
                    let apart = x[0] + y[0] + z[0] > to || x[1] + y[1] + z[1] < from;
                    missed |= u8::from(apart) << (4 * i + 2 * j + k);
                }
            }
        }
        left(octants, missed)
    }

    /// Those of the octants that the triangle does not pass by, seen along an axis.
    #[inline]
    fn along(&self, axis: usize, corners: &[[f64; 3]; 3], octants: u8) -> u8 {
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let (halves_j, halves_k) = (&self.halves[j], &self.halves[k]);
        let mut missed = 0_u8;
        for (p, q, other) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let (p, q, other) = (&corners[p], &corners[q], &corners[other]);
            // Across the edge, so that both of its ends have the same shadow.
            let (line_j, line_k) = (p[k] - q[k], q[j] - p[j]);
            let on = line_j * p[j] + line_k * p[k];
            let off = line_j * other[j] + line_k * other[k];
            let (from, to) = (least(on, off), most(on, off));
            let [low_j, high_j] = shadows(line_j, halves_j);
            let [low_k, high_k] = shadows(line_k, halves_k);
            for (quadrant, (a, b)) in [
                (low_j, low_k),
                (high_j, low_k),
                (low_j, high_k),
                (high_j, high_k),
            ]
            .into_iter()
            .enumerate()
            {
                let apart = a[0] + b[0] > to || a[1] + b[1] < from;
                missed |= u8::from(apart) << quadrant;
            }
        }
        left(octants, QUADRANTS[axis][missed as usize])
    }
}

/// The octants of quadrants seen along each axis: bit 0 of a quadrant is the next axis, bit 1 the one after.
static QUADRANTS: [[u8; 16]; 3] = {
    let mut table = [[0; 16]; 3];
    let mut axis = 0;
    while axis < 3 {
        let mut octant = 0;
        while octant < 8 {
            let quadrant = (octant >> ((axis + 1) % 3) & 1) | (octant >> ((axis + 2) % 3) & 1) << 1;
            let mut set = 0;
            while set < 16 {
                table[axis][set] |= ((set >> quadrant & 1) << octant) as u8;
                set += 1;
            }
            octant += 1;
        }
        axis += 1;
    }
    table
};

/// The octants less those that are missed; all of them where rounding would leave none.
#[inline(always)]
fn left(octants: u8, missed: u8) -> u8 {
    let left = octants & !missed;
    if left == 0 { octants } else { left }
}

/// The shadows of both halves of an axis on a line that has this component on it.
#[inline(always)]
fn shadows(line: f64, halves: &[Span; 2]) -> [Span; 2] {
    let [[a, b], [c, d]] = *halves;
    if line < 0.0 {
        [[line * b, line * a], [line * d, line * c]]
    } else {
        [[line * a, line * b], [line * c, line * d]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriangleMesh;
    use alloc::vec::Vec;

    /// All eight at once against one after the other.
    #[test]
    fn octants_are_those_that_hold_the_triangle() {
        let mut state = 5_u64;
        let mut coordinate = move |size: f32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 33) as f32 / (1_u64 << 31) as f32 - 0.5) * size
        };
        let mut positions: Vec<[f32; 3]> = Vec::new();
        for size in [0.3, 1.0, 8.0] {
            positions.extend((0..1200).map(|_| [(); 3].map(|()| coordinate(size))));
        }
        let triangles = (0..1200_u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let mesh = TriangleMesh::new(positions, triangles).expect("a good mesh");
        let space = Space::of(&mesh);
        let (mut asked, mut by_number) = (0, [0; 9]);
        for axes in [Axes::XYZ, Axes::XY] {
            let bounds = Aabb::new([-0.5; 3], [0.5; 3]);
            let middle = match axes.has(2) {
                true => Vec3::ZERO,
                false => Vec3::new(0.0, 0.0, 0.5),
            };
            let octants = Octants::of(&mesh, &space, &bounds, middle, axes);
            for i in (0..mesh.len()).filter(|&i| space.holds(&mesh, i, &bounds)) {
                let found = octants.overlapped(i, &mesh.bounds(i));
                let mut held = 0;
                for octant in (0..8).filter(|octant| axes.has(2) || octant >> 2 == 0) {
                    let octant_bounds = octant_bounds(&bounds, middle, octant);
                    held |= u8::from(space.holds(&mesh, i, &octant_bounds)) << octant;
                }
                assert_eq!(found, held, "triangle {i}");
                asked += 1;
                by_number[found.count_ones() as usize] += 1;
            }
        }
        assert!(
            asked > 1500 && by_number[1..8].iter().all(|&n| n > 20),
            "{by_number:?}"
        );
    }

    #[test]
    fn quadrants_are_pairs_of_octants() {
        assert_eq!(QUADRANTS[0][0b0001], 0b0000_0011);
        assert_eq!(QUADRANTS[1][0b0010], 0b0101_0000);
        assert_eq!(QUADRANTS[2][0b1000], 0b1000_1000);
        assert!((0..3).all(|axis| QUADRANTS[axis][15] == 0xff));
    }
}
