//! Whether a triangle holds a point, meets another triangle, or is crossed above a point: never wrong.
//!
//! *How it works.* Everything is asked of the signs of [`predicates`], which are exact; no coordinate is computed. What lies
//! in one plane is decided by its three shadows along the axes: two closed sets in a common plane share a point exactly if
//! they do in the shadow that keeps them apart, and that is one of the three. Triangles without area, which are segments or
//! points, need no special case for it.
//!
//! *Source.* Guigue & Devillers 2003, *Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates*;
//! Edelsbrunner & Mücke 1990, *Simulation of Simplicity*, for points exactly above an edge.
//!
//! [`predicates`]: crate::geometry::predicates

use crate::geometry::predicates::{orient2d, orient3d};
use crate::geometry::{Aabb, Vec3};

type Triangle = [Vec3; 3];

/// The two axes of the shadow along an axis, in the order that makes a right-handed frame with it.
const SHADOWS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

fn shadow(v: Vec3, [j, k]: [usize; 2]) -> [f32; 2] {
    [v[j], v[k]]
}

/// Whether a closed triangle holds a point, exactly.
pub fn holds(t: Triangle, p: Vec3) -> bool {
    Aabb::of(t).contains(&Aabb::new(p, p)) && orient3d(t, p) == 0 && holds_in_plane(t, p)
}

/// The same for a point in the triangle's box and plane.
fn holds_in_plane(t: Triangle, p: Vec3) -> bool {
    SHADOWS.iter().all(|&axes| {
        let [a, b, c] = t.map(|v| shadow(v, axes));
        let p = shadow(p, axes);
        let sides = [orient2d(a, b, p), orient2d(b, c, p), orient2d(c, a, p)];
        !(sides.contains(&1) && sides.contains(&-1))
    })
}

/// How a vertical line through a point crosses a triangle at or above it: 1 where it leaves through the front (the side
/// from which the corners run counter-clockwise), −1 where it enters, 0 where it does not cross. The sum over a closed mesh
/// is how often its surface winds around the point.
///
/// Exact, for a point that is moved by an infinitely small `(ε, ε², ε³)`: so it is never above an edge or in a surface, and
/// of two triangles that share an edge exactly one is crossed.
#[inline]
pub fn crossing_above(t: Triangle, p: Vec3) -> i32 {
    let [a, b, c] = t.map(|v| shadow(v, SHADOWS[2]));
    let q = shadow(p, SHADOWS[2]);
    // How often the shadow's border winds around that of the point: the edges that a line towards +x crosses.
    let turns = upward(a, b, q) + upward(b, c, q) + upward(c, a, q);
    if turns == 0 {
        return 0;
    }
    let mut side = orient3d(t, p);
    // In the plane: the small movement decides, against the normal along the first axis where there is one.
    for axes in SHADOWS {
        if side == 0 {
            let [a, b, c] = t.map(|v| shadow(v, axes));
            side = -orient2d(a, b, c);
        }
    }
    if side == turns { turns } else { 0 }
}

/// 1 where the edge from `a` to `b` passes to the right of `q` on its way up, −1 on its way down, else 0.
#[inline(always)]
fn upward(a: [f32; 2], b: [f32; 2], q: [f32; 2]) -> i32 {
    if a[1] <= q[1] && q[1] < b[1] {
        i32::from(orient2d(a, b, q) > 0)
    } else if b[1] <= q[1] && q[1] < a[1] {
        -i32::from(orient2d(b, a, q) > 0)
    } else {
        0
    }
}

/// Whether two closed triangles share a point, exactly.
pub fn meet(s: Triangle, t: Triangle) -> bool {
    if Aabb::of(s).intersection(Aabb::of(t)).is_empty() {
        return false;
    }
    // Where all corners of one lie on one side of the other, nothing else needs to be asked.
    let of_s = s.map(|p| orient3d(t, p));
    if of_s == [1; 3] || of_s == [-1; 3] {
        return false;
    }
    let of_t = t.map(|p| orient3d(s, p));
    if of_t == [1; 3] || of_t == [-1; 3] {
        return false;
    }
    // If they share a point, then an edge of one meets the other.
    let reaches = |s: Triangle, sides: [i32; 3], t: Triangle| {
        (0..3).any(|i| {
            let k = (i + 1) % 3;
            edge_meets([s[i], s[k]], [sides[i], sides[k]], t)
        })
    };
    reaches(s, of_s, t) || reaches(t, of_t, s)
}

/// Whether a segment whose ends lie on these sides of a triangle's plane shares a point with the triangle.
fn edge_meets([p, q]: [Vec3; 2], [of_p, of_q]: [i32; 2], t @ [a, b, c]: Triangle) -> bool {
    if of_p * of_q > 0 {
        return false;
    }
    if (of_p, of_q) != (0, 0) {
        // One point in the plane. Which side of each edge the segment passes, all from one end.
        let sides = [[a, b], [b, c], [c, a]].map(|[a, b]| orient3d([a, b, q], p));
        return !(sides.contains(&1) && sides.contains(&-1));
    }
    let in_box = |p: Vec3| Aabb::of(t).contains(&Aabb::new(p, p));
    (in_box(p) && holds_in_plane(t, p))
        || (in_box(q) && holds_in_plane(t, q))
        || segments_meet([p, q], [a, b])
        || segments_meet([p, q], [b, c])
        || segments_meet([p, q], [c, a])
}

/// Whether two closed segments share a point, exactly.
fn segments_meet([p, q]: [Vec3; 2], [a, b]: [Vec3; 2]) -> bool {
    let apart = Aabb::of([p, q]).intersection(Aabb::of([a, b])).is_empty();
    !apart
        && orient3d([p, q, a], b) == 0
        && SHADOWS.iter().all(|&axes| {
            let [p, q, a, b] = [p, q, a, b].map(|v| shadow(v, axes));
            // Along a line their boxes, which do meet, decide.
            orient2d(a, b, p) * orient2d(a, b, q) <= 0 && orient2d(p, q, a) * orient2d(p, q, b) <= 0
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f32; 3]; 3]) -> Triangle {
        corners.map(Vec3::from)
    }
    fn point(p: [f32; 3]) -> Vec3 {
        Vec3::from(p)
    }

    #[test]
    fn points_on_triangles() {
        let t = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 4.0], [0.0, 4.0, 4.0]]);
        for p in [
            [1.0, 1.0, 2.0],
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 2.0],
            [2.0, 2.0, 4.0],
        ] {
            assert!(holds(t, point(p)), "{p:?}");
        }
        for p in [
            [1.0, 1.0, 2.0_f32.next_up()],
            [3.0, 3.0, 6.0],
            [-1.0, 1.0, 0.0],
            [2.5, 2.5, 4.0],
        ] {
            assert!(!holds(t, point(p)), "{p:?}");
        }
        let segment = triangle([[0.0; 3], [3.0; 3], [1.0; 3]]);
        assert!(holds(segment, point([2.0; 3])) && !holds(segment, point([2.0, 2.0, 2.5])));
        assert!(!holds(segment, point([4.0; 3])));
        let dot = triangle([[1.0; 3]; 3]);
        assert!(holds(dot, point([1.0; 3])) && !holds(dot, point([1.0, 1.0, 0.0])));
    }

    /// Above any point of a square lies exactly one of its two halves, on the diagonal and at the rim too.
    #[test]
    fn one_of_two_neighbours_is_crossed() {
        let z = |x: f32, y: f32| 1.0 + x * 0.5 + y * 0.25;
        let at = |x: f32, y: f32| Vec3::new(x, y, z(x, y));
        let [a, b, c, d] = [at(0.0, 0.0), at(4.0, 0.0), at(4.0, 4.0), at(0.0, 4.0)];
        for i in 0..=8 {
            for k in 0..=8 {
                let (x, y) = (i as f32 * 0.5, k as f32 * 0.5);
                for (z, below) in [(z(x, y) - 0.5, true), (z(x, y) + 0.5, false)] {
                    let p = Vec3::new(x, y, z);
                    let up = crossing_above([a, b, c], p) + crossing_above([a, c, d], p);
                    let down = crossing_above([a, c, b], p) + crossing_above([a, d, c], p);
                    // The closed lower rim counts, the upper one belongs to the next square.
                    let over = below && i < 8 && k < 8;
                    assert_eq!((up, down), (i32::from(over), -i32::from(over)), "{p:?}");
                }
            }
        }
    }

    #[test]
    fn triangles_that_meet() {
        let t = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        for (s, expected) in [
            // Through it, with a corner on it, on its edge, above it.
            ([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], true),
            ([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], true),
            ([[2.0, 2.0, 0.0], [5.0, 5.0, 1.0], [5.0, 5.0, -1.0]], true),
            (
                [[1.0, 1.0, 1.0e-30], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]],
                false,
            ),
            ([[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [4.0, 4.0, 0.0]], false),
            // In its plane: inside, around, across, touching, apart.
            ([[0.5, 0.5, 0.0], [1.0, 0.5, 0.0], [0.5, 1.0, 0.0]], true),
            (
                [[-9.0, -9.0, 0.0], [30.0, -9.0, 0.0], [-9.0, 30.0, 0.0]],
                true,
            ),
            ([[-1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [9.0, 2.0, 0.0]], true),
            ([[2.0, 2.0, 0.0], [4.0, 4.0, 0.0], [4.0, 5.0, 0.0]], true),
            ([[3.0, 3.0, 0.0], [4.0, 4.0, 0.0], [3.0, 4.0, 0.0]], false),
            // Segments and points.
            ([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.5]], true),
            ([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]], true),
            ([[-1.0, 2.0, 0.0], [1.0, 2.0, 0.0], [0.0, 2.0, 0.0]], true),
            ([[1.0, 1.0, 0.5], [1.0, 1.0, 0.5], [1.0, 1.0, 0.5]], false),
        ] {
            let s = triangle(s);
            for turn in 0..6 {
                let (mut s, mut t) = (s, t);
                s.rotate_left(turn % 3);
                if turn >= 3 {
                    t.swap(0, 2);
                }
                assert_eq!((meet(s, t), meet(t, s)), (expected, expected), "{s:?}");
            }
        }
        let [along, across] = [
            triangle([[0.0; 3], [3.0; 3], [1.0; 3]]),
            triangle([[2.0, 2.0, 0.0], [2.0, 2.0, 4.0], [2.0, 2.0, 1.0]]),
        ];
        assert!(meet(along, across) && meet(along, along));
        let beside = across.map(|p| p + Vec3::new(0.0, 0.125, 0.0));
        assert!(!meet(along, beside));
    }
}
