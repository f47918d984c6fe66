//! What instances place: a structure over primitives of its own.

use super::{InstanceError, Instances, outline};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use crate::query::Intersect;
use crate::simd::exactly;
use alloc::sync::Arc;
use core::fmt;

/// A structure that can be placed many times, in a space of its own. Copies share everything.
#[derive(Clone)]
pub struct Object {
    structure: Arc<dyn Intersect>,
    /// Around all of it, a few boxes.
    outline: Arc<[Aabb]>,
    bounds: Aabb,
    /// The placements inside, where there are any.
    instances: Option<Arc<Instances>>,
    number: u32,
}

/// Objects within objects: each level takes some kilobytes of a thread's stack while a ray is in it.
pub(super) const MAX_DEPTH: usize = 32;

impl Object {
    /// An object of a structure and the primitives that it was built over, which are only looked at: world boxes of placements
    /// are made from their boxes, so that these do not depend on the structure.
    ///
    /// Where the primitives are [`Instances`] themselves, [`Object::of_instances`] is meant: here all of them count as one.
    /// A structure over other primitives than these loses hits.
    ///
    /// ```
    /// use boxwood::{BinnedSah, Bvh, Object, TriangleMesh};
    /// use std::sync::Arc;
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Arc::new(TriangleMesh::new(corners, [[0_u32, 1, 2]])?);
    /// let tree = BinnedSah::default().build(&mesh);
    /// let object = Object::new(&mesh, Arc::new(Bvh::new(mesh.clone(), tree)));
    /// assert_eq!(object.bounds().upper, [1.0, 1.0, 0.0].into());
    /// # Ok::<(), boxwood::MeshError>(())
    /// ```
    pub fn new(primitives: &impl Primitives, structure: Arc<dyn Intersect>) -> Self {
        let outline = exactly(|| outline::of(primitives));
        Self {
            structure,
            bounds: outline.iter().fold(Aabb::EMPTY, |b, &part| b.union(part)),
            outline: outline.into(),
            instances: None,
            number: 0,
        }
    }

    /// An object that is made of placed objects: a tree of leaves, a forest of such trees, …
    ///
    /// # Errors
    /// [`InstanceError::TooDeep`] when these are already nested 32 deep.
    pub fn of_instances(
        instances: Arc<Instances>,
        structure: Arc<dyn Intersect>,
    ) -> Result<Self, InstanceError> {
        if instances.depth() >= MAX_DEPTH {
            return Err(InstanceError::TooDeep { most: MAX_DEPTH });
        }
        Ok(Self {
            instances: Some(instances.clone()),
            ..Self::new(&*instances, structure)
        })
    }

    /// The same object with a number of the caller's own, by which [`Instances::object_of`] tells what a hit met.
    #[must_use]
    pub fn numbered(self, number: u32) -> Self {
        Self { number, ..self }
    }

    /// The caller's own number; 0 unless it was set.
    pub fn number(&self) -> u32 {
        self.number
    }
    /// Around everything in it.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
    /// The structure.
    pub fn structure(&self) -> &Arc<dyn Intersect> {
        &self.structure
    }
    /// The placements it is made of; `None` for an object of other primitives.
    pub fn instances(&self) -> Option<&Arc<Instances>> {
        self.instances.as_ref()
    }
    /// How many placements one placement of it stands for: 1, or those of all that it is made of.
    pub fn placements(&self) -> u32 {
        (self.instances.as_ref()).map_or(1, |instances| instances.placements())
    }
    pub(super) fn depth(&self) -> usize {
        (self.instances.as_ref()).map_or(0, |instances| instances.depth())
    }
    pub(super) fn outline(&self) -> &[Aabb] {
        &self.outline
    }
}

impl fmt::Debug for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Object")
            .field("number", &self.number)
            .field("bounds", &self.bounds)
            .field("placements", &self.placements())
            .finish_non_exhaustive()
    }
}
