//! A mesh whose vertices move while the shutter is open.
//!
//! *How it works.* All keys have the same triangles; each has vertices of its own. Where a vertex is at a moment, says
//! `geometry/motion.rs`; what a ray meets there, the canonical triangle test. The moment is the query's
//! ([`Query::time`]): [`Timed`](crate::Timed) asks any structure at one.
//!
//! *Cost.* 12 bytes a vertex and key, 12 a triangle. Structures that know nothing of motion hold each triangle in a box around all of its
//! sweep; [`MotionBvh`](crate::MotionBvh) has boxes that move.
//!
//! *Source.* Cook, Porter & Carpenter 1984, *Distributed Ray Tracing* (a time for each ray).

use super::mesh::{check_corners, offer_triangle};
use super::{MeshError, Primitives, Surfaces, TriangleMesh, Triangles};
use crate::geometry::motion::Moment;
use crate::geometry::triangle::{self, overlap};
use crate::geometry::{Aabb, Hit, PreparedRay, Ray, Surface, Vec3};
use crate::query::{Counters, Query};
use crate::simd::exactly;
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// Triangles whose vertices move evenly from key to key; keys are evenly spread over the shutter, which is open from time 0 to 1.
///
/// A time before 0 counts as 0, one after 1 as 1, NaN as 0.
///
/// ```
/// use boxwood::{BruteForce, Intersect, MovingMesh, Ray, Timed, TriangleMesh};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let first = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
/// let last = corners.map(|[x, y, _]| [x, y, 4.0]);
/// let mesh = MovingMesh::new(first, [last])?;
///
/// let judge = BruteForce::new(&mesh);
/// let ray = Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]);
/// let hit = judge.at(0.25).closest_hit(&ray);
/// assert_eq!(hit.map(|hit| hit.t), Some(2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct MovingMesh {
    /// At the first key.
    first: TriangleMesh,
    /// The vertices at each later key.
    later: Vec<Vec<Vec3>>,
}

/// Why a motion was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// The vertices of a key do not fit the triangles.
    #[error("at key {key}, {flaw}")]
    Key {
        /// Which key; the first one is 0.
        key: usize,
        /// What a mesh would say.
        flaw: MeshError,
    },
    /// The way of a vertex from one key to the next is longer than any float.
    #[error("vertex {vertex} moves farther than floats reach on the way to key {key}")]
    TooFar {
        /// The vertex.
        vertex: u32,
        /// The key at the end of its way.
        key: usize,
    },
    /// More keys than their numbers have exact floats for.
    #[error("there are {keys} keys, but at most {most} can be told apart", most = MovingMesh::MOST_KEYS)]
    TooMany {
        /// How many.
        keys: usize,
    },
}

impl MovingMesh {
    /// So many keys can be told apart in a time.
    pub const MOST_KEYS: usize = 1 << 16;

    /// A mesh at time 0, and its vertices at each later key. With none, nothing moves.
    ///
    /// # Errors
    /// When at a key a triangle names a vertex that is not there or not finite, or one is too far away from where it was.
    pub fn new<V: Into<[f32; 3]>>(
        first: TriangleMesh,
        later: impl IntoIterator<Item = impl IntoIterator<Item = V>>,
    ) -> Result<Self, MotionError> {
        let mut mesh = Self {
            first,
            later: Vec::new(),
        };
        for positions in later {
            let positions = positions.into_iter().map(|p| p.into().into()).collect();
            mesh.push(positions)?;
        }
        Ok(mesh)
    }

    /// Appends a key, after the same checks.
    fn push(&mut self, positions: Vec<Vec3>) -> Result<(), MotionError> {
        let key = self.keys();
        if key == Self::MOST_KEYS {
            return Err(MotionError::TooMany { keys: key + 1 });
        }
        check_corners(&positions, self.triangles())
            .map_err(|flaw| MotionError::Key { key, flaw })?;
        let before = self.positions(key - 1);
        for &vertex in self.triangles().iter().flatten() {
            let way = positions[vertex as usize] - before[vertex as usize];
            if !way.is_finite() {
                return Err(MotionError::TooFar { vertex, key });
            }
        }
        self.later.push(positions);
        Ok(())
    }

    /// How many keys there are: at least one.
    pub fn keys(&self) -> usize {
        1 + self.later.len()
    }
    /// The vertices at a key.
    ///
    /// # Panics
    /// When there is no such key.
    #[inline(always)]
    pub fn positions(&self, key: usize) -> &[Vec3] {
        match key {
            0 => self.first.positions(),
            _ => &self.later[key - 1],
        }
    }
    /// The vertices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.first.triangles()
    }
    /// The bytes that vertices and triangles take.
    pub fn bytes(&self) -> usize {
        let later = self.later.iter().map(|key| size_of_val(&**key));
        self.first.bytes() + later.sum::<usize>()
    }
    /// The mesh as it is at a moment.
    pub fn at(&self, time: f32) -> Pose<'_> {
        Pose {
            mesh: self,
            moment: Moment::new(time, self.keys()),
        }
    }
}

/// A [`MovingMesh`] as it is at a moment: triangles at rest, without a copy of any vertex.
#[derive(Clone, Copy, Debug)]
pub struct Pose<'a> {
    mesh: &'a MovingMesh,
    moment: Moment,
}

impl<'a> Pose<'a> {
    /// At one of the keys.
    pub(crate) fn at_key(mesh: &'a MovingMesh, key: usize) -> Self {
        let moment = Moment {
            near: key,
            far: key,
            weight: 0.0,
        };
        Self { mesh, moment }
    }

    /// The same triangles as a mesh of their own.
    ///
    /// # Errors
    /// None that [`MovingMesh::new`] has not met before.
    pub fn to_mesh(&self) -> Result<TriangleMesh, MeshError> {
        let [near, far] = [self.moment.near, self.moment.far].map(|key| self.mesh.positions(key));
        let places = near.iter().zip(far);
        let mut mesh = self.mesh.first.clone();
        exactly(|| mesh.move_vertices(places.map(|(&near, &far)| self.moment.place(near, far))))?;
        Ok(mesh)
    }
}

impl Primitives for MovingMesh {
    #[inline]
    fn len(&self) -> usize {
        self.first.len()
    }
    /// Around all of its way.
    fn bounds(&self, i: usize) -> Aabb {
        let at_key = |key| Pose::at_key(self, key).bounds(i);
        (0..self.keys()).fold(Aabb::EMPTY, |b, key| b.union(at_key(key)))
    }
    fn object_end(&self, i: usize) -> usize {
        self.first.object_end(i)
    }
    #[inline(always)]
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        self.at(query.time()).offer(i, ray, query, counters)
    }
    /// A hit lies within the slack of the triangle as it is at the moment, which never leaves the box around its keys.
    const WITHIN_SLACK: bool = true;
}

impl Primitives for Pose<'_> {
    #[inline]
    fn len(&self) -> usize {
        self.mesh.len()
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
    fn object_end(&self, i: usize) -> usize {
        self.mesh.object_end(i)
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

impl Triangles for Pose<'_> {
    #[inline(always)]
    fn triangle(&self, i: usize) -> [Vec3; 3] {
        let [a, b, c] = self.mesh.triangles()[i];
        let [near, far] = [
            self.mesh.positions(self.moment.near),
            self.mesh.positions(self.moment.far),
        ];
        [
            self.moment.place(near[a as usize], far[a as usize]),
            self.moment.place(near[b as usize], far[b as usize]),
            self.moment.place(near[c as usize], far[c as usize]),
        ]
    }
}

impl Surfaces for Pose<'_> {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        triangle::surface(self.triangle(hit.primitive as usize), hit.u, hit.v, ray)
    }
}
