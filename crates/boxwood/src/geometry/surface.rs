//! A point on a surface, with what a renderer asks of it.

use super::Vec3;

/// Where a ray met a surface. Structures return the slim [`Hit`](super::Hit); this is made from it on request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The point in world units, as near to the surface as floats allow.
    pub position: Vec3,
    /// Unit normal of the true surface, to its front: the side from which a triangle runs counter-clockwise, the outside
    /// of a solid.
    pub normal: Vec3,
    /// Whether the ray came from the front.
    pub front: bool,
    /// Coordinates on the surface: the hit's own `u` and `v`.
    pub uv: [f32; 2],
    /// How far the position and the tests of later rays may be off together, in world units.
    pub error: f32,
}

impl Surface {
    /// The normal on the side that the ray came from.
    #[inline]
    pub fn facing(&self) -> Vec3 {
        if self.front {
            self.normal
        } else {
            -self.normal
        }
    }

    /// Where a ray that leaves in `direction` should start, with `t_min = 0`, so that it does not meet the surface that
    /// it leaves: the position moved along the normal to the side of the direction.
    ///
    /// *How far* follows from the error bound of the position and of the intersection test, not from a constant, so
    /// that it is right in millimetres and in kilometres. The idea of stepping in units of the position's own rounding
    /// is that of Wächter & Binder 2019, *A Fast and Robust Method for Avoiding Self-Intersection*, whose constants
    /// hold near size 1.
    #[inline]
    pub fn offset_origin(&self, direction: impl Into<[f32; 3]>) -> Vec3 {
        let away = self.normal.dot(Vec3::from(direction.into())) < 0.0;
        let step = if away { -self.error } else { self.error };
        self.position + self.normal * step
    }
}
