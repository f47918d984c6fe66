//! Bounding volumes alone: one box around each object, and a ray that misses the box misses the object.
//!
//! *How it works.* Objects are runs of primitives ([`Primitives::object_end`]), such as the placed meshes of a scene. Every
//! ray is held against every object's box, in order; only where it enters one are the object's primitives tested. It is
//! the first step from testing everything to a hierarchy, and a hierarchy is the same idea repeated.
//!
//! *Cost.* Building looks at every primitive once. A ray pays one box per object, and the primitives of those it enters:
//! still linear in the size of the scene. 32 bytes per object.
//!
//! *Source.* Clark 1976, *Hierarchical Geometric Models for Visible Surface Algorithms*; Whitted 1980, *An Improved
//! Illumination Model for Shaded Display*, which put spheres around objects.

use super::limits::{Site, unlimited};
use super::settings::{Setting, Settings};
use super::{BuildError, Limits, sah};
use crate::accel::sah::half_area;
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{Cell, Statistics};
use crate::primitive::{self, Primitives};
use crate::query::{Counters, Intersect, Query, Step, Traverse, Verdict};
use crate::simd::exactly;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::Range;

/// The builder of [`BoundingBoxes`]: there is nothing to set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectBoxes;

/// The boxes of some objects; what [`ObjectBoxes`] makes and [`BoundingBoxes`] reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Objects {
    objects: Vec<Object>,
    bounds: Aabb,
    primitives: usize,
}

/// A run of primitives and the box around them, which may be empty.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Object {
    bounds: Aabb,
    first: u32,
    end: u32,
}

impl Object {
    fn places(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }
}

/// So many primitives are looked at between two reports of progress.
const STRIDE: usize = 1024;

impl ObjectBoxes {
    /// Puts a box around each object; it cannot fail.
    pub fn build(&self, primitives: &impl Primitives) -> Objects {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Puts a box around each object within limits.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within(
        &self,
        primitives: &impl Primitives,
        limits: &Limits<'_>,
    ) -> Result<Objects, BuildError> {
        exactly(|| self.objects(primitives, limits))
    }

    fn objects(
        &self,
        primitives: &impl Primitives,
        limits: &Limits<'_>,
    ) -> Result<Objects, BuildError> {
        let n = primitives.len();
        let site = Site::new(limits, n);
        let mut built = Objects {
            objects: Vec::new(),
            bounds: Aabb::EMPTY,
            primitives: n,
        };
        let count = core::iter::successors(Some(0), |&first| Some(end(primitives, first)))
            .take_while(|&first| first < n)
            .count();
        if !site.take(count.saturating_mul(size_of::<Object>())) {
            return site.finish(built);
        }
        built.objects.reserve_exact(count);
        let mut object = Object {
            bounds: Aabb::EMPTY,
            first: 0,
            end: 0,
        };
        for i in 0..n {
            if i == object.end as usize {
                object = Object {
                    bounds: Aabb::EMPTY,
                    first: i as u32,
                    end: end(primitives, i) as u32,
                };
            }
            let around = primitives.bounds(i);
            built.bounds = built.bounds.union(around);
            if !around.is_empty() {
                object.bounds = object.bounds.union(around);
            }
            if i + 1 == object.end as usize {
                built.objects.push(object);
            }
            if i % STRIDE == STRIDE - 1 && !site.advance(STRIDE) {
                break;
            }
        }
        site.finish(built)
    }
}

/// One past the last primitive of the object that begins at `first`, whatever the primitives claim.
fn end(primitives: &impl Primitives, first: usize) -> usize {
    let least = first + 1;
    primitives
        .object_end(first)
        .clamp(least, primitives.len().max(least))
}

impl Settings for ObjectBoxes {
    const NAME: &'static str = "boxes";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        Vec::new()
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        let objects = self.build_within(&primitives, limits)?;
        Ok(Box::new(BoundingBoxes::new(primitives, objects)))
    }
}

/// One box per object over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct BoundingBoxes<P> {
    primitives: P,
    objects: Objects,
}

impl<P: Primitives> BoundingBoxes<P> {
    /// Takes the boxes that the builder made for these primitives.
    ///
    /// # Panics
    /// When they were made for another number of primitives.
    pub fn new(primitives: P, objects: Objects) -> Self {
        assert_eq!(
            primitives.len(),
            objects.primitives,
            "boxes for other primitives"
        );
        Self {
            primitives,
            objects,
        }
    }

    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
}

impl<P: Primitives> Traverse for BoundingBoxes<P> {
    fn bounds(&self) -> Aabb {
        self.objects.bounds
    }

    fn statistics(&self) -> Statistics {
        let Objects {
            objects, bounds, ..
        } = &self.objects;
        let root = half_area(bounds);
        let cost = |object: &Object| {
            let tests = object.places().len() as f32 * sah::PRIMITIVE_COST;
            let share = half_area(&object.bounds) / root;
            // Without areas to compare, every object is as good as entered.
            f64::from(sah::NODE_COST) + f64::from(tests) * if share <= 1.0 { share } else { 1.0 }
        };
        let cost: f64 = objects.iter().map(cost).sum();
        Statistics {
            primitives: self.objects.primitives,
            leaves: objects.len(),
            references: self.objects.primitives,
            largest_leaf: objects.iter().map(|o| o.places().len()).max().unwrap_or(0),
            bytes: size_of_val(&**objects),
            sah_cost: if root > 0.0 && root < f64::INFINITY {
                cost as f32
            } else {
                0.0
            },
            ..Statistics::default()
        }
    }

    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        for (node, object) in (0..).zip(&self.objects.objects) {
            show(&Cell {
                node,
                depth: 0,
                bounds: object.bounds,
                primitives: Some(object.end - object.first),
                sides: &[],
            });
        }
    }

    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let Some(ray) = PreparedRay::new(ray, self.objects.bounds.scale()) else {
            return;
        };
        for (node, object) in self.objects.objects.iter().enumerate() {
            // Nothing is promised of an empty box, and nothing is in it.
            if object.bounds.is_empty() {
                continue;
            }
            counters.node();
            let entered = ray.enters(&object.bounds, query.t_max()).is_some();
            if C::EXPLAINS {
                counters.step(Step::of_box(
                    node as u32,
                    object.bounds,
                    ray.slabs(&object.bounds),
                    ray.t_min,
                    query.t_max(),
                    Verdict::Opened,
                ));
            }
            if !entered {
                continue;
            }
            counters.leaf();
            if C::EXPLAINS {
                counters.step(Step::Leaf {
                    node: node as u32,
                    primitives: object.end - object.first,
                });
            }
            for i in object.places() {
                if primitive::offer(&self.primitives, i, &ray, query, counters).is_break() {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Intersect, TraversalStats, TriangleMesh};
    use core::ops::ControlFlow::{Break, Continue};

    /// Two objects of two triangles each, one behind the other along x.
    fn mesh() -> TriangleMesh {
        let positions = (0..4).flat_map(|i| {
            let x = i as f32;
            [[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]
        });
        let triangles = (0..4_u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let mesh = TriangleMesh::new(positions, triangles).expect("a good mesh");
        mesh.with_objects([2, 4])
    }

    #[test]
    fn only_entered_objects_are_tested() {
        let mesh = mesh();
        let boxes = BoundingBoxes::new(&mesh, ObjectBoxes.build(&mesh));
        let found = Intersect::statistics(&boxes);
        assert_eq!((found.leaves, found.largest_leaf), (2, 2));
        let mut stats = TraversalStats::default();
        let ray = Ray::new([2.5, 0.2, 0.2], [1.0, 0.0, 0.0]);
        let hit = boxes.closest_hit_counted(&ray, &mut stats);
        assert_eq!(hit.map(|hit| hit.primitive), Some(3));
        assert_eq!((stats.nodes, stats.leaves, stats.primitives), (2, 1, 2));
    }

    #[test]
    fn limits_hold() {
        let mesh = mesh();
        let tight = Limits {
            memory: Some(size_of::<Object>()),
            ..Limits::NONE
        };
        let error = ObjectBoxes.build_within(&mesh, &tight);
        assert!(matches!(error, Err(BuildError::Memory { needed: 64, .. })));
        let watch = |share: f32| if share > 0.0 { Break(()) } else { Continue(()) };
        let watched = Limits {
            watch: Some(&watch),
            ..Limits::NONE
        };
        let error = ObjectBoxes.build_within(&mesh, &watched);
        assert_eq!(error, Err(BuildError::Cancelled));
    }
}
