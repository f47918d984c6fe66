//! Affine maps in double precision, so that a deep hierarchy is rounded once, at its end.

use super::schema::Node;
use boxwood::Affine;

/// The rows of `[M | c]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix(pub [[f64; 4]; 3]);

impl Matrix {
    pub const IDENTITY: Self = Self([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]);

    /// From sixteen numbers, column by column; the last row is taken to be `0 0 0 1`.
    pub fn from_columns(columns: &[f64; 16]) -> Self {
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|column| columns[4 * column + row])
        }))
    }

    /// Where a node stands in its parent's space.
    pub fn of_node(node: &Node) -> Self {
        if let Some(columns) = &node.matrix {
            return Self::from_columns(columns);
        }
        let [x, y, z] = node.translation.as_deref().copied().unwrap_or([0.0; 3]);
        let scale = node.scale.as_deref().copied().unwrap_or([1.0; 3]);
        let rotation = node.rotation.as_deref().copied();
        let r = rotation_rows(rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let row = |r: [f64; 3], c: f64| [r[0] * scale[0], r[1] * scale[1], r[2] * scale[2], c];
        Self([row(r[0], x), row(r[1], y), row(r[2], z)])
    }

    /// First `other`, then this map.
    pub fn after(&self, other: &Self) -> Self {
        Self(self.0.map(|row| {
            std::array::from_fn(|column| {
                let carried = if column == 3 { row[3] } else { 0.0 };
                row[0] * other.0[0][column]
                    + row[1] * other.0[1][column]
                    + row[2] * other.0[2][column]
                    + carried
            })
        }))
    }

    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        self.0
            .map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
    }

    pub fn vector(&self, v: [f64; 3]) -> [f64; 3] {
        self.0
            .map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// A surface normal's image, of any length: the cofactor matrix times `n`, on the same side of the surface.
    pub fn normal(&self, n: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.0.map(|row| [row[0], row[1], row[2]]);
        let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
        let side = if dot(a, cofactors[0]) < 0.0 {
            -1.0
        } else {
            1.0
        };
        cofactors.map(|row| side * dot(row, n))
    }

    pub fn column(&self, column: usize) -> [f64; 3] {
        self.0.map(|row| row[column])
    }

    /// Rounded to single precision; `None` when a number has no place there.
    pub fn rounded(&self) -> Option<Affine> {
        let rows = self.0.map(|row| row.map(|x| x as f32));
        let is_finite = rows.iter().flatten().all(|x| x.is_finite());
        is_finite.then_some(Affine { rows })
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// A vector of length one; `None` when it has no direction.
pub fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    // The largest part first: squares of very small or large numbers leave the range of floats.
    let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite() && v.iter().all(|x| x.is_finite())) {
        return None;
    }
    let v = v.map(|x| x / largest);
    let length = dot(v, v).sqrt();
    Some(v.map(|x| x / length))
}

/// The part of `v` that is at right angles to the unit vector `axis`, of length one.
pub fn unit_across(v: [f64; 3], axis: [f64; 3]) -> Option<[f64; 3]> {
    let v = unit(v)?;
    let along = dot(v, axis);
    let across: [f64; 3] = std::array::from_fn(|k| v[k] - along * axis[k]);
    (dot(across, across) > 1e-12).then_some(())?;
    unit(across)
}

/// The rotation of a quaternion `x y z w`, whose length does not count; of a zero quaternion, no rotation.
fn rotation_rows(quaternion: [f64; 4]) -> [[f64; 3]; 3] {
    let largest = quaternion.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let [x, y, z, w] = quaternion.map(|q| q / largest);
    let s = 2.0 / (x * x + y * y + z * z + w * w);
    [
        [
            1.0 - s * (y * y + z * z),
            s * (x * y - z * w),
            s * (x * z + y * w),
        ],
        [
            s * (x * y + z * w),
            1.0 - s * (x * x + z * z),
            s * (y * z - x * w),
        ],
        [
            s * (x * z - y * w),
            s * (y * z + x * w),
            1.0 - s * (x * x + y * y),
        ],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn translation_rotation_and_scale_apply_from_the_right() {
        let half = 0.5_f64.sqrt();
        let node = Node {
            translation: Some(Box::new([10.0, 0.0, 0.0])),
            // A quarter turn about z, given with length 2.
            rotation: Some(Box::new([0.0, 0.0, 2.0 * half, 2.0 * half])),
            scale: Some(Box::new([2.0, 3.0, 4.0])),
            ..Node::default()
        };
        let [x, y, z] = Matrix::of_node(&node).point([1.0, 1.0, 1.0]);
        assert!((x - 7.0).abs() < 1e-12 && (y - 2.0).abs() < 1e-12 && (z - 4.0).abs() < 1e-12);
    }

    #[test]
    fn maps_compose_and_columns_are_read_as_columns() {
        let moved = Matrix::from_columns(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 2.0, 3.0, 1.0,
        ]);
        let doubled = Matrix([
            [2.0, 0.0, 0.0, 0.0],
            [0.0, 2.0, 0.0, 0.0],
            [0.0, 0.0, 2.0, 0.0],
        ]);
        assert_eq!(moved.after(&doubled).point([1.0; 3]), [3.0, 4.0, 5.0]);
        assert_eq!(doubled.after(&moved).point([1.0; 3]), [4.0, 6.0, 8.0]);
    }

    #[test]
    fn normals_keep_their_side_when_the_map_mirrors() {
        let mirror = Matrix([
            [-1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 2.0, 0.0],
        ]);
        assert_eq!(unit(mirror.normal([0.0, 0.0, 1.0])), Some([0.0, 0.0, 1.0]));
        assert_eq!(unit(mirror.normal([1.0, 0.0, 0.0])), Some([-1.0, 0.0, 0.0]));
        assert_eq!(unit([0.0; 3]), None);
        assert_eq!(unit([1e-200, 0.0, 0.0]), Some([1.0, 0.0, 0.0]));
    }
}
