//! A hash of what structures see of primitives, to know them by.

use super::Primitives;
use crate::digest;
use crate::geometry::Vec3;
use crate::pieces;
use alloc::vec::Vec;

/// Primitives in a piece of work.
const PIECE: usize = 1 << 14;

/// A hash of everything that a tree depends on: the corners of triangles, the boxes of anything else, in order. The same on every
/// machine; computed in the caller's rayon pool.
///
/// It tells meshes apart, such as for the name of a file in a cache. Nobody has tried to make it safe from forgers.
///
/// ```
/// use boxwood::{TriangleMesh, primitive::fingerprint};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
/// let turned = TriangleMesh::new(corners, [[1_u32, 2, 0]])?;
/// assert_ne!(fingerprint(&mesh), fingerprint(&turned));
/// # Ok::<(), boxwood::MeshError>(())
/// ```
pub fn fingerprint(primitives: &(impl Primitives + Sync)) -> u128 {
    let count = primitives.len();
    let piece = |piece: usize| {
        let all = piece * PIECE..count.min((piece + 1) * PIECE);
        let mut words = Vec::with_capacity(9 * all.len());
        for i in all {
            let mut add = |p: Vec3| words.extend(p.to_array().map(f32::to_bits));
            match primitives.corners(i) {
                Some(corners) => corners.into_iter().for_each(add),
                None => {
                    let bounds = primitives.bounds(i);
                    add(bounds.lower);
                    add(bounds.upper);
                }
            }
        }
        digest::of_piece(&words)
    };
    digest::together(pieces::each(count.div_ceil(PIECE), piece))
}
