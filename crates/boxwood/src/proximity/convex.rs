//! Convex regions: what lies behind each of some planes, such as the frustum of a camera.
//!
//! *How it works.* A box lies outside where even its corner farthest behind lies before a plane. Of a triangle that is
//! neither inside nor outside for certain, each plane in turn cuts off what lies before it; it reaches into the region where
//! something is left. So corners of a frustum are sharp: nothing is found that only seems near because no single plane
//! separates it.
//!
//! *Source.* Sutherland & Hodgman 1974, *Reentrant Polygon Clipping*; Gribb & Hartmann 2001, *Fast Extraction of Viewing
//! Frustum Planes from the World-View-Projection Matrix*.

use super::hierarchy::Extent;
use super::overlap::Region;
use crate::geometry::Vec3;
use crate::simd::exactly;
use alloc::vec::Vec;

/// All points `p` with `normal · p ≤ offset`. None where a number is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Points out of it; any length.
    pub normal: Vec3,
    /// In lengths of the normal times world units.
    pub offset: f32,
}

impl HalfSpace {
    /// A half-space from its outward normal and offset.
    pub fn new(normal: impl Into<[f32; 3]>, offset: f32) -> Self {
        Self {
            normal: normal.into().into(),
            offset,
        }
    }
    /// What lies behind a plane through a point.
    pub fn behind(point: impl Into<[f32; 3]>, normal: impl Into<[f32; 3]>) -> Self {
        let (point, normal) = (Vec3::from(point.into()), Vec3::from(normal.into()));
        Self {
            normal,
            offset: exactly(|| normal.dot(point)),
        }
    }
}

/// The common part of some half-spaces, closed; all of space where there are none.
///
/// ```
/// use boxwood::proximity::{ConvexRegion, HalfSpace, Proximity};
/// use boxwood::{BruteForce, TriangleMesh};
/// let mesh = TriangleMesh::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0_u32, 1, 2]])?;
/// let tree = BruteForce::new(&mesh);
/// let before = |x| ConvexRegion::new([HalfSpace::new([1.0, 1.0, 0.0], x)]);
/// assert_eq!(tree.overlapping(&before(0.0)), [0]);
/// assert!(!tree.overlaps(&before(-0.1)));
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexRegion {
    /// Outward normals and offsets.
    planes: Vec<([f64; 3], f64)>,
}

impl ConvexRegion {
    /// The common part of some half-spaces.
    pub fn new(half_spaces: impl IntoIterator<Item = HalfSpace>) -> Self {
        let plane = |h: HalfSpace| (h.normal.to_array().map(f64::from), f64::from(h.offset));
        Self {
            planes: half_spaces.into_iter().map(plane).collect(),
        }
    }

    /// What a camera sees: all points that a matrix, given by its rows, takes to clip coordinates `(x, y, z, w)` with
    /// `|x| ≤ w`, `|y| ≤ w` and `nearest · w ≤ z ≤ w`. `nearest` is 0 for Direct3D, Metal, Vulkan and WebGPU, and −1 for OpenGL.
    pub fn frustum(view_projection: [[f32; 4]; 4], nearest: f32) -> Self {
        let [x, y, z, w] = view_projection.map(|row| row.map(f64::from));
        // a · row + b · w ≥ 0 for the points inside.
        let plane = |a: f64, row: [f64; 4], b: f64| {
            let [i, j, k, l] = core::array::from_fn(|n| -(a * row[n] + b * w[n]));
            ([i, j, k], -l)
        };
        let planes = || {
            Vec::from([
                plane(1.0, x, 1.0),
                plane(-1.0, x, 1.0),
                plane(1.0, y, 1.0),
                plane(-1.0, y, 1.0),
                plane(1.0, z, -f64::from(nearest)),
                plane(-1.0, z, 1.0),
            ])
        };
        Self {
            planes: exactly(planes),
        }
    }
}

/// Right up to rounding errors of 2⁻⁴⁸ of the largest coordinates.
impl Region for ConvexRegion {
    fn excludes(&self, around: &Extent) -> bool {
        self.planes.iter().any(|(normal, offset)| {
            // Monotone in the box, whatever the rounding: so a box around a triangle's is excluded only with it.
            let deepest: [f64; 3] = core::array::from_fn(|k| {
                let plane = if normal[k] < 0.0 {
                    around.upper[k]
                } else {
                    around.lower[k]
                };
                // An axis that does not matter, of a box that may be infinite.
                if normal[k] == 0.0 {
                    0.0
                } else {
                    normal[k] * plane
                }
            });
            !(deepest[0] + deepest[1] + deepest[2] <= *offset)
        })
    }

    fn meets(&self, corners: [Vec3; 3]) -> bool {
        let corners = corners.map(|v| v.to_array().map(f64::from));
        let beyond = |(n, offset): &([f64; 3], f64), p: [f64; 3]| {
            n[0] * p[0] + n[1] * p[1] + n[2] * p[2] - offset
        };
        let mut polygon = Vec::new();
        let mut cut = Vec::new();
        for plane in &self.planes {
            let before = corners.map(|p| beyond(plane, p) <= 0.0);
            if before == [false; 3] {
                return false;
            }
            if before == [true; 3] {
                continue;
            }
            if polygon.is_empty() {
                polygon.extend(corners);
            }
            cut.clear();
            for (i, p) in polygon.iter().enumerate() {
                let q = &polygon[(i + 1) % polygon.len()];
                let (at_p, at_q) = (beyond(plane, *p), beyond(plane, *q));
                if at_p <= 0.0 {
                    cut.push(*p);
                }
                if (at_p < 0.0 && at_q > 0.0) || (at_p > 0.0 && at_q < 0.0) {
                    let share = at_p / (at_p - at_q);
                    cut.push(core::array::from_fn(|k| p[k] + (q[k] - p[k]) * share));
                }
            }
            core::mem::swap(&mut polygon, &mut cut);
            if polygon.is_empty() {
                return false;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meets(region: &ConvexRegion, corners: [[f32; 3]; 3]) -> bool {
        let t = corners.map(Vec3::from);
        !region.excludes(&Extent::of(t)) && region.meets(t)
    }

    /// Looks down −z with a right angle, from 1 to 10.
    fn camera() -> ConvexRegion {
        let (near, far) = (1.0, 10.0);
        let depth = far / (near - far);
        ConvexRegion::frustum(
            [
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, depth, near * depth],
                [0.0, 0.0, -1.0, 0.0],
            ],
            0.0,
        )
    }

    #[test]
    fn a_frustum_has_sharp_corners() {
        let camera = camera();
        let speck = |x: f32, y: f32, z: f32| [[x, y, z], [x + 0.01, y, z], [x, y + 0.01, z]];
        for (at, seen) in [
            ([0.0, 0.0, -5.0], true),
            ([4.9, 4.9, -5.0], true),
            ([5.1, 0.0, -5.0], false),
            ([0.0, -5.2, -5.0], false),
            ([0.0, 0.0, -0.9], false),
            ([0.0, 0.0, -1.1], true),
            ([0.0, 0.0, -10.1], false),
            ([0.0, 0.0, 5.0], false),
        ] {
            assert_eq!(meets(&camera, speck(at[0], at[1], at[2])), seen, "{at:?}");
        }
        // Around the camera, through it, and past a corner that no single plane separates it from.
        assert!(meets(
            &camera,
            [[-99.0, -99.0, -5.0], [99.0, -99.0, -5.0], [0.0, 99.0, -5.0]]
        ));
        assert!(meets(
            &camera,
            [[0.0, 0.0, 50.0], [0.0, 0.0, -50.0], [0.0, 1.0, 50.0]]
        ));
        let past = [[25.0, 5.0, -9.0], [5.0, 25.0, -9.0], [25.0, 25.0, -9.0]];
        assert!(!meets(&camera, past) && !camera.excludes(&Extent::of(past.map(Vec3::from))));
    }

    #[test]
    fn strange_planes() {
        let t = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let of = |normal: [f32; 3], offset| ConvexRegion::new([HalfSpace::new(normal, offset)]);
        assert!(meets(&ConvexRegion::new([]), t));
        assert!(meets(&of([0.0; 3], 0.0), t) && !meets(&of([0.0; 3], -1.0), t));
        assert!(meets(&of([1.0; 3], f32::INFINITY), t));
        for bad in [f32::NAN, f32::INFINITY] {
            assert!(!meets(&of([bad, 0.0, 0.0], 1.0), t), "{bad}");
        }
        assert!(!meets(&of([1.0, 0.0, 0.0], f32::NAN), t));
        assert!(meets(
            &ConvexRegion::new([HalfSpace::behind([0.0, 1.0, 0.0], [0.0, -2.0, 0.0])]),
            t
        ));
        // Touching with a corner, and a wedge whose edge lies in the triangle.
        assert!(meets(&of([1.0, 0.0, 0.0], 0.0), t));
        let wedge = |z: f32| {
            ConvexRegion::new([
                HalfSpace::new([1.0, 0.0, -1.0], -z),
                HalfSpace::new([-1.0, 0.0, -1.0], -z),
            ])
        };
        assert!(meets(&wedge(0.0), t) && !meets(&wedge(0.01), t));
    }
}
