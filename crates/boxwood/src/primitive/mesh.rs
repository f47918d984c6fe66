//! Triangle meshes: checked once, trusted afterwards.

use super::{Foresight, Primitives, Surfaces, Triangles};
use crate::geometry::triangle::{self, Meeting, moller_trumbore, overlap, watertight};
use crate::geometry::{Aabb, Hit, PreparedRay, Ray, Surface, Vec3};
use crate::query::{Counters, Query};
use crate::simd::{address, exactly, prefetch};
use alloc::vec::Vec;
use core::mem;
use core::ops::ControlFlow::{self, Continue};

/// Vertices, and three of them per triangle. Every index names a vertex and every vertex that a triangle names is finite.
///
/// A triangle without area is kept, so that numbers never shift, and is never hit. The test is the canonical one of
/// [`watertight`]; [`MollerTrumbore`] is the alternative. 12 bytes a vertex and 12 a triangle.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// Where the objects end that the triangles belong to, ascending; what comes after the last end is one more.
    object_ends: Vec<u32>,
}

/// Why a mesh was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// An index beyond the vertices.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices}")]
    NoSuchVertex {
        /// The triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A coordinate is infinite or NaN.
    #[error("triangle {triangle} names vertex {vertex}, which is not finite")]
    NotFinite {
        /// The triangle.
        triangle: usize,
        /// The vertex.
        vertex: u32,
    },
    /// A flat list does not divide into threes.
    #[error("the list of {what} has {length} numbers, which is not a multiple of three")]
    NotThrees {
        /// `positions` or `indices`.
        what: &'static str,
        /// How many numbers.
        length: usize,
    },
    /// There is not enough memory to lay all placements out.
    #[error("there is not enough memory for {triangles} triangles")]
    NoMemory {
        /// How many.
        triangles: usize,
    },
    /// The nodes of a tree over them are numbered with 32 bits, and there are twice as many.
    #[error("there are {triangles} triangles, but at most 2147483648 can be numbered")]
    TooMany {
        /// How many.
        triangles: usize,
    },
}

/// So many that a tree's `2 n − 1` nodes have numbers of 32 bits.
const MAX_TRIANGLES: usize = 1 << 31;

impl TriangleMesh {
    /// Checks and keeps a mesh. Positions are anything that turns into `[f32; 3]`; indices are `u32`, `u16` or `u8`.
    ///
    /// # Errors
    /// When an index names no vertex, or a triangle a vertex that is not finite.
    pub fn new<V: Into<[f32; 3]>, I: Into<u32>>(
        positions: impl IntoIterator<Item = V>,
        triangles: impl IntoIterator<Item = [I; 3]>,
    ) -> Result<Self, MeshError> {
        let positions = positions.into_iter().map(|p| p.into().into()).collect();
        let triangles = triangles.into_iter().map(|t| t.map(Into::into)).collect();
        Self::check(positions, triangles)
    }

    /// The same from double-precision positions, each rounded to the nearest float.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`]; a coordinate beyond the floats is not finite.
    pub fn from_f64<I: Into<u32>>(
        positions: impl IntoIterator<Item = [f64; 3]>,
        triangles: impl IntoIterator<Item = [I; 3]>,
    ) -> Result<Self, MeshError> {
        exactly(|| {
            Self::new(
                positions.into_iter().map(|p| p.map(|x| x as f32)),
                triangles,
            )
        })
    }

    /// The same from flat lists: `x y z x y z …` and `a b c a b c …`.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`], and when a list does not divide into threes.
    pub fn from_flat<I: Into<u32> + Copy>(
        positions: &[f32],
        indices: &[I],
    ) -> Result<Self, MeshError> {
        let (points, []) = positions.as_chunks::<3>() else {
            return Err(MeshError::NotThrees {
                what: "positions",
                length: positions.len(),
            });
        };
        let (triangles, []) = indices.as_chunks::<3>() else {
            return Err(MeshError::NotThrees {
                what: "indices",
                length: indices.len(),
            });
        };
        Self::new(points.iter().copied(), triangles.iter().copied())
    }

    fn check(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.len() > MAX_TRIANGLES {
            return Err(MeshError::TooMany {
                triangles: triangles.len(),
            });
        }
        check_corners(&positions, &triangles)?;
        Ok(Self {
            positions,
            triangles,
            object_ends: Vec::new(),
        })
    }

    /// Moves the vertices: the same triangles, with other corners. Vertices that no triangle names may become more or fewer.
    ///
    /// A structure over the mesh must follow it, as [`WideBvh::update`](crate::WideBvh::update) does.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`]; then all vertices remain where they were.
    pub fn move_vertices<V: Into<[f32; 3]>>(
        &mut self,
        positions: impl IntoIterator<Item = V>,
    ) -> Result<(), MeshError> {
        self.swap_vertices(&mut positions.into_iter().map(|p| p.into().into()).collect())
    }

    /// The same without copies: the mesh gets the positions, and the list those that the mesh had, to be written over for
    /// the next frame.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`]; then nothing is exchanged.
    pub fn swap_vertices(&mut self, positions: &mut Vec<Vec3>) -> Result<(), MeshError> {
        // The triangles name none beyond the old ones, so mostly one look at each vertex is enough.
        let finite = |part: &[Vec3]| part.iter().fold(true, |all, p| all & p.is_finite());
        if positions.len() < self.positions.len() || !positions.chunks(1024).all(finite) {
            check_corners(positions, &self.triangles)?;
        }
        mem::swap(&mut self.positions, positions);
        Ok(())
    }

    /// The same mesh, knowing that its triangles belong to several objects: the first one ends before triangle
    /// `ends[0]`, the second one before `ends[1]`, … Only [`Primitives::object_end`] tells of it. Ends that do not ascend
    /// are brought into order.
    #[must_use]
    pub fn with_objects(mut self, ends: impl IntoIterator<Item = u32>) -> Self {
        self.object_ends = ends.into_iter().collect();
        self.object_ends.sort_unstable();
        self.object_ends.dedup();
        self
    }

    /// The vertices.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }
    /// The vertices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// The three corners of triangle `i`.
    ///
    /// # Panics
    /// When there is no such triangle.
    #[inline(always)]
    pub fn triangle(&self, i: usize) -> [Vec3; 3] {
        // Without a closure: kernels ask this.
        let [a, b, c] = self.triangles[i];
        let at = &*self.positions;
        [at[a as usize], at[b as usize], at[c as usize]]
    }
    /// The bytes that vertices and triangles take.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.positions) + size_of_val(&*self.triangles)
    }
}

/// Whether every corner is a vertex, and finite.
pub(super) fn check_corners(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        for &vertex in corners {
            match positions.get(vertex as usize) {
                None => {
                    return Err(MeshError::NoSuchVertex {
                        triangle,
                        vertex,
                        vertices: positions.len(),
                    });
                }
                Some(p) if !p.is_finite() => {
                    return Err(MeshError::NotFinite { triangle, vertex });
                }
                Some(_) => {}
            }
        }
    }
    Ok(())
}

#[inline(always)]
fn hit(meeting: Meeting, i: usize) -> Hit {
    Hit {
        t: meeting.t,
        u: meeting.u,
        v: meeting.v,
        primitive: i as u32,
        instance: 0,
    }
}

/// Shows triangle `i` to the query where the canonical test accepts it.
#[inline(always)]
pub(super) fn offer_triangle<Q: Query>(
    corners: [Vec3; 3],
    i: usize,
    ray: &PreparedRay,
    query: &mut Q,
) -> ControlFlow<()> {
    match watertight::intersect(corners, ray, query.t_max()) {
        Some((meeting, covered)) if covered || watertight::confirmed(corners, ray, &meeting) => {
            query.offer(hit(meeting, i))
        }
        _ => Continue(()),
    }
}

impl Primitives for TriangleMesh {
    #[inline]
    fn len(&self) -> usize {
        self.triangles.len()
    }
    #[inline]
    fn bounds(&self, i: usize) -> Aabb {
        Aabb::of(self.triangle(i))
    }
    fn clipped_bounds(&self, i: usize, within: &Aabb) -> Aabb {
        overlap::clipped_bounds(self.triangle(i), within)
    }
    fn overlaps(&self, i: usize, within: &Aabb) -> bool {
        overlap::overlaps(self.triangle(i), within)
    }
    #[inline(always)]
    fn corners(&self, i: usize) -> Option<[Vec3; 3]> {
        Some(self.triangle(i))
    }
    #[inline(always)]
    fn foresee(&self, i: usize, step: Foresight) {
        match step {
            Foresight::Far => prefetch(address(&self.triangles, i), 1),
            Foresight::Near => {
                let [a, b, c] = self.triangles.get(i).copied().unwrap_or_default();
                prefetch(address(&self.positions, a as usize), 1);
                prefetch(address(&self.positions, b as usize), 1);
                prefetch(address(&self.positions, c as usize), 1);
            }
        }
    }
    fn object_end(&self, i: usize) -> usize {
        // The number of ends that are not beyond `i` is the number of the object.
        let object = self.object_ends.partition_point(|&end| end as usize <= i);
        self.object_ends
            .get(object)
            .map_or(self.len(), |&end| end as usize)
    }
    #[inline(always)]
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        _: &mut C,
    ) -> ControlFlow<()> {
        offer_triangle(self.triangle(i), i, ray, query)
    }
    const WITHIN_SLACK: bool = true;
    const TRIANGLES: bool = true;
}

impl Triangles for TriangleMesh {
    #[inline(always)]
    fn triangle(&self, i: usize) -> [Vec3; 3] {
        self.triangle(i)
    }
}

impl Surfaces for TriangleMesh {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        triangle::surface(self.triangle(hit.primitive as usize), hit.u, hit.v, ray)
    }
}

/// A mesh whose triangles are met by the test of Möller & Trumbore 1997 instead of the canonical one: the same picture
/// to the eye, but other bits, and rays slip through shared edges. Every structure still agrees with the judge over the
/// same wrapped mesh.
///
/// ```
/// use boxwood::{BruteForce, Intersect, MollerTrumbore, Ray, TriangleMesh};
/// let mesh = TriangleMesh::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0_u32, 1, 2]])?;
/// let judge = BruteForce::new(MollerTrumbore(&mesh));
/// assert!(judge.occluded(&Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0])));
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct MollerTrumbore<M>(pub M);

impl<M: core::borrow::Borrow<TriangleMesh>> Primitives for MollerTrumbore<M> {
    #[inline]
    fn len(&self) -> usize {
        self.0.borrow().len()
    }
    #[inline]
    fn bounds(&self, i: usize) -> Aabb {
        self.0.borrow().bounds(i)
    }
    fn object_end(&self, i: usize) -> usize {
        self.0.borrow().object_end(i)
    }
    #[inline(always)]
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        _: &mut C,
    ) -> ControlFlow<()> {
        match moller_trumbore::intersect(self.0.borrow().triangle(i), ray, query.t_max()) {
            Some(meeting) => query.offer(hit(meeting, i)),
            None => Continue(()),
        }
    }
}

impl<M: core::borrow::Borrow<TriangleMesh>> Triangles for MollerTrumbore<M> {
    #[inline(always)]
    fn triangle(&self, i: usize) -> [Vec3; 3] {
        self.0.borrow().triangle(i)
    }
}

impl<M: core::borrow::Borrow<TriangleMesh>> Surfaces for MollerTrumbore<M> {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        self.0.borrow().surface(ray, hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_meshes_are_refused_in_a_sentence() {
        let refused = |r: Result<TriangleMesh, MeshError>| r.expect_err("refused").to_string();
        assert_eq!(
            refused(TriangleMesh::new([[0.0_f32; 3]], [[0_u32, 0, 9]])),
            "triangle 0 names vertex 9, but there are 1"
        );
        assert_eq!(
            refused(TriangleMesh::new([[0.0, f32::NAN, 0.0]], [[0_u32, 0, 0]])),
            "triangle 0 names vertex 0, which is not finite"
        );
        assert_eq!(
            refused(TriangleMesh::from_f64(
                [[0.0, 1.0e39, 0.0]],
                [[0_u32, 0, 0]]
            )),
            "triangle 0 names vertex 0, which is not finite"
        );
        assert_eq!(
            refused(TriangleMesh::from_flat(&[0.0; 4], &[0_u32; 3])),
            "the list of positions has 4 numbers, which is not a multiple of three"
        );
        assert_eq!(
            refused(TriangleMesh::from_flat(&[0.0; 3], &[0_u16; 2])),
            "the list of indices has 2 numbers, which is not a multiple of three"
        );
    }

    #[test]
    fn vertices_move_or_stay_where_they_were() {
        let first = [[0.0_f32; 3], [1.0; 3], [2.0; 3], [f32::NAN; 3]];
        let mut mesh = TriangleMesh::new(first, [[0_u32, 1, 2]]).expect("good");
        let place = |mesh: &TriangleMesh| mesh.triangle(0).map(|p| p.x);
        let mut next = Vec::from([Vec3::splat(1.0); 5]);
        mesh.swap_vertices(&mut next).expect("more vertices");
        assert_eq!((place(&mesh), next.len()), ([1.0; 3], 4));
        mesh.move_vertices([[7.0; 3]; 3])
            .expect("fewer, but enough");
        let refused = |r: Result<(), MeshError>| r.expect_err("refused").to_string();
        assert_eq!(
            refused(mesh.move_vertices([[8.0; 3]; 2])),
            "triangle 0 names vertex 2, but there are 2"
        );
        assert_eq!(
            refused(mesh.move_vertices([[8.0; 3], [f32::INFINITY; 3], [8.0; 3]])),
            "triangle 0 names vertex 1, which is not finite"
        );
        assert_eq!(place(&mesh), [7.0; 3]);
        let unnamed = [[9.0; 3], [9.0; 3], [9.0; 3], [f32::NAN; 3]];
        mesh.move_vertices(unnamed).expect("nobody looks there");
        assert_eq!(place(&mesh), [9.0; 3]);
    }

    #[test]
    fn what_no_triangle_names_may_be_anything() {
        assert!(TriangleMesh::new([[0.0; 3], [f32::NAN; 3]], [[0_u16, 0, 0]]).is_ok());
    }
}
