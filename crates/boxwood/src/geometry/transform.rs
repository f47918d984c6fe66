//! Affine maps: where a mesh stands in the world.

use super::{Aabb, Vec3};

/// An affine map of space: `p ↦ M p + c`, stored as the rows of the 3 × 4 matrix `[M | c]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Affine {
    /// The rows; the last column is the translation.
    pub rows: [[f32; 4]; 3],
}

impl Affine {
    /// Moves nothing.
    pub const IDENTITY: Self = Self {
        rows: [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ],
    };

    /// Moves by a vector.
    pub fn translation(by: impl Into<[f32; 3]>) -> Self {
        let by = by.into();
        let mut map = Self::IDENTITY;
        for (row, by) in map.rows.iter_mut().zip(by) {
            row[3] = by;
        }
        map
    }
    /// Scales along the axes.
    pub fn scale(by: impl Into<[f32; 3]>) -> Self {
        let by = by.into();
        let mut map = Self::IDENTITY;
        for (axis, by) in by.into_iter().enumerate() {
            map.rows[axis][axis] = by;
        }
        map
    }
    /// The image of a point.
    #[inline]
    pub fn point(&self, p: impl Into<[f32; 3]>) -> Vec3 {
        let p = p.into();
        let row = |r: &[f32; 4]| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3];
        Vec3::new(row(&self.rows[0]), row(&self.rows[1]), row(&self.rows[2]))
    }
    /// The image of a direction: the translation does not count.
    #[inline]
    pub fn vector(&self, v: impl Into<[f32; 3]>) -> Vec3 {
        let v = v.into();
        let row = |r: &[f32; 4]| r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
        Vec3::new(row(&self.rows[0]), row(&self.rows[1]), row(&self.rows[2]))
    }
    /// The image of a surface normal, of unit length; it stays on the surface's front when the map mirrors.
    ///
    /// The cofactor matrix is used, so a map that flattens space still has normals.
    pub fn normal(&self, n: impl Into<[f32; 3]>) -> Vec3 {
        let n = Vec3::from(n.into());
        let [x, y, z] = self.columns();
        let cofactor = y.cross(z) * n.x + z.cross(x) * n.y + x.cross(y) * n.z;
        (cofactor * if self.mirrors() { -1.0 } else { 1.0 }).normalized()
    }
    /// First this map, then `next`.
    pub fn then(&self, next: &Self) -> Self {
        let [x, y, z] = self.columns();
        let columns = [next.vector(x), next.vector(y), next.vector(z)];
        let c = next.point([self.rows[0][3], self.rows[1][3], self.rows[2][3]]);
        let row = |k: usize| [columns[0][k], columns[1][k], columns[2][k], c[k]];
        Self {
            rows: [row(0), row(1), row(2)],
        }
    }
    /// The volume of the image of the unit cube; negative when the map mirrors.
    pub fn determinant(&self) -> f32 {
        let [x, y, z] = self.columns();
        x.dot(y.cross(z))
    }
    /// Whether left becomes right: triangles then change their orientation.
    pub fn mirrors(&self) -> bool {
        self.determinant() < 0.0
    }
    /// The map back, each of its numbers rounded once; `None` where space is flattened so much that there is none, or where a
    /// number is beyond the floats.
    pub fn inverse(&self) -> Option<Self> {
        let linear = self.inverse_linear()?;
        let row = |r: [f64; 3]| {
            let by: f64 = (0..3).map(|k| r[k] * f64::from(self.rows[k][3])).sum();
            [r[0] as f32, r[1] as f32, r[2] as f32, -by as f32]
        };
        let rows = linear.map(row);
        let finite = rows.iter().flatten().all(|x| x.is_finite());
        finite.then_some(Self { rows })
    }
    /// The inverse of `M` in double precision, by cofactors: products of two floats are exact there.
    pub(crate) fn inverse_linear(&self) -> Option<[[f64; 3]; 3]> {
        let m = |row: usize, column: usize| f64::from(self.rows[row % 3][column % 3]);
        // Of the transposed place: indices that run on in a circle bring the signs with them.
        let cofactor = |row: usize, column: usize| {
            m(column + 1, row + 1) * m(column + 2, row + 2)
                - m(column + 1, row + 2) * m(column + 2, row + 1)
        };
        let determinant: f64 = (0..3).map(|k| m(0, k) * cofactor(k, 0)).sum();
        let inverse: [[f64; 3]; 3] = core::array::from_fn(|row| {
            core::array::from_fn(|column| cofactor(row, column) / determinant)
        });
        let finite = inverse.iter().flatten().all(|x| x.is_finite());
        (determinant != 0.0 && finite).then_some(inverse)
    }
    /// The box of the image of a box (Arvo 1990).
    pub fn bounds(&self, of: &Aabb) -> Aabb {
        if of.is_empty() {
            return Aabb::EMPTY;
        }
        let mut lower = [0.0; 3];
        let mut upper = [0.0; 3];
        for (axis, row) in self.rows.iter().enumerate() {
            (lower[axis], upper[axis]) = (row[3], row[3]);
            for (k, factor) in row[..3].iter().enumerate() {
                let (a, b) = (factor * of.lower[k], factor * of.upper[k]);
                lower[axis] += a.min(b);
                upper[axis] += a.max(b);
            }
        }
        Aabb::new(lower, upper)
    }

    fn columns(&self) -> [Vec3; 3] {
        let r = &self.rows;
        let column = |k: usize| Vec3::new(r[0][k], r[1][k], r[2][k]);
        [column(0), column(1), column(2)]
    }
}

impl Default for Affine {
    fn default() -> Self {
        Self::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn about z, twice the size along x afterwards, then a step.
    fn map() -> Affine {
        let turn = Affine {
            rows: [
                [0.0, -1.0, 0.0, 0.0],
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
            ],
        };
        turn.then(&Affine::scale([2.0, 1.0, 1.0]))
            .then(&Affine::translation([1.0, 2.0, 3.0]))
    }

    #[test]
    fn maps_follow_each_other_in_reading_order() {
        assert_eq!(map().point([1.0, 0.0, 0.0]), Vec3::new(1.0, 3.0, 3.0));
        assert_eq!(map().point([0.0, 1.0, 0.0]), Vec3::new(-1.0, 2.0, 3.0));
        assert_eq!(map().vector([0.0, 1.0, 0.0]), Vec3::new(-2.0, 0.0, 0.0));
        assert_eq!(map().determinant(), 2.0);
    }

    #[test]
    fn the_way_back() {
        let there_and_back = map().then(&map().inverse().expect("not flat"));
        assert_eq!(there_and_back, Affine::IDENTITY);
        assert_eq!(Affine::scale([1.0, 0.0, 1.0]).inverse(), None);
        assert_eq!(Affine::scale([1.0, f32::NAN, 1.0]).inverse(), None);
        assert_eq!(Affine::scale([1.0, 1.0e-39, 1.0]).inverse(), None);
        let small = Affine::scale([1.0e-30, 1.0e30, 1.0]);
        assert_eq!(
            small.inverse(),
            Some(Affine::scale([1.0 / 1.0e-30_f32, 1.0 / 1.0e30_f32, 1.0]))
        );
    }

    #[test]
    fn normals_stay_at_right_angles_and_in_front() {
        let mirror = Affine::scale([-1.0, 1.0, 3.0]);
        assert_eq!(mirror.normal([1.0, 0.0, 0.0]), Vec3::new(-1.0, 0.0, 0.0));
        assert_eq!(mirror.normal([0.0, 1.0, 0.0]), Vec3::new(0.0, 1.0, 0.0));
        let shear = Affine {
            rows: [
                [1.0, 1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
            ],
        };
        let n = shear.normal([1.0, 0.0, 0.0]);
        assert!(n.dot(shear.vector([0.0, 1.0, 0.0])).abs() < 1.0e-6 && n.x > 0.0);
    }

    #[test]
    fn bounds_hold_every_corner() {
        let of = Aabb::new([-1.0, 0.0, 2.0], [4.0, 5.0, 6.0]);
        let around = map().bounds(&of);
        assert_eq!(around, Aabb::new([-9.0, 1.0, 5.0], [1.0, 6.0, 9.0]));
        assert!(map().bounds(&Aabb::EMPTY).is_empty());
    }
}
