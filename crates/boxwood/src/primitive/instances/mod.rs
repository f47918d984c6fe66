//! Objects placed many times: a forest takes the memory of one tree.
//!
//! *How it works.* [`Instances`] are primitives like any others, so every structure can stand over them. An instance's box in the
//! world is that of its object, turned; a ray that meets the box is taken into the object's space and asked there, of the
//! object's own structure. Objects may be made of instances in turn, to any depth up to 32: a forest of trees of leaves.
//!
//! *What the answer is.* By definition that of the ray in the object's space (see [`Instances::ray_within`] for the operations): its
//! `t`, `u`, `v` and primitive, and the number of the placement. So hits of an instance are not the bits of the same
//! triangles laid out in the world, but every structure has the same ones, whatever stands over the instances and within the
//! objects, as long as each of those is exact.
//!
//! *Parts.* A wide tree may hold an instance by parts of its object's structure ([`Primitives::parts`]), each with a box in the world; a hit
//! in a part counts where it would count in the whole.
//!
//! *Numbers.* [`Hit::instance`] numbers the placements of innermost objects, all levels together: where a forest of 1000 trees has 5000
//! leaves each, it runs to 5 million, and [`Instances::path`] says which tree it is and which leaf of it. So a hit is as small as
//! ever and ties have one order everywhere. [`Hit::primitive`] is the innermost object's own number.
//!
//! *Cost.* 132 bytes an instance, besides the structure over them; taking a ray inside costs about as much as four triangles.
//!
//! *Source.* Rubin & Whitted 1980; Wald et al. 2014, *Embree*, for rays whose directions keep their length.

mod object;
mod outline;
mod parts;
mod path;
mod placement;
mod renew;

pub use object::Object;

use super::Primitives;
use crate::geometry::{Aabb, Affine, Hit, PreparedRay};
use crate::math;
use crate::query::{Counters, Part, Query, Relay, TraversalStats};
use crate::simd::exactly;
#[cfg(feature = "parallel")]
use crate::threads::Exactly;
use alloc::vec::Vec;
use core::ops::ControlFlow::{self, Continue};
use placement::{Flaw, Placement};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// One placement of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the object.
    pub object: u32,
    /// From the object's space to the space that the instances are in.
    pub transform: Affine,
    /// Which queries see it: those whose [`Query::mask`] shares a bit.
    pub mask: u32,
}

impl Instance {
    /// Seen by every query.
    pub fn new(object: u32, transform: Affine) -> Self {
        Self {
            object,
            transform,
            mask: u32::MAX,
        }
    }
    /// The same, seen only by queries whose mask shares a bit with this one.
    #[must_use]
    pub fn masked(self, mask: u32) -> Self {
        Self { mask, ..self }
    }
}

/// Why instances were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InstanceError {
    /// An index beyond the objects.
    #[error("instance {instance} places object {object}, but there are {objects}")]
    NoSuchObject {
        /// The instance.
        instance: usize,
        /// The object it names.
        object: u32,
        /// How many objects there are.
        objects: usize,
    },
    /// A number of the transform is infinite or NaN.
    #[error("the transform of instance {instance} is not finite")]
    NotFinite {
        /// The instance.
        instance: usize,
    },
    /// A number beyond the instances.
    #[error("there is no instance {instance}, but {instances} of them")]
    NoSuchInstance {
        /// The number.
        instance: usize,
        /// How many there are.
        instances: usize,
    },
    /// The transform has no inverse that floats can tell.
    #[error("the transform of instance {instance} flattens space")]
    Singular {
        /// The instance.
        instance: usize,
    },
    /// The placed object's box does not fit into floats.
    #[error("instance {instance} reaches beyond the floats")]
    TooLarge {
        /// The instance.
        instance: usize,
    },
    /// Placements of all levels are numbered with 32 bits.
    #[error("there are {placements} placements, but at most 4294967295 can be numbered")]
    TooMany {
        /// How many.
        placements: u64,
    },
    /// Objects within objects within objects …
    #[error("objects are nested more than {most} deep")]
    TooDeep {
        /// How deep they may be.
        most: usize,
    },
}

/// Placed objects, numbered: what the outer structure of a two-level scene stands over.
///
/// ```
/// use boxwood::{
///     Affine, BinnedSah, BruteForce, Bvh, Instance, Instances, Intersect, Object, Ray, TriangleMesh,
/// };
/// use std::sync::Arc;
///
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Arc::new(TriangleMesh::new(corners, [[0_u32, 1, 2]])?);
/// let leaf = Object::new(&mesh, Arc::new(BruteForce::new(mesh.clone())));
///
/// // Two leaves on a twig, three twigs one behind the other.
/// let step = |by: f32| Affine::translation([0.0, 0.0, by]);
/// let twig = Instances::new([leaf], [0.0, 1.0].map(|z| Instance::new(0, step(z))))?;
/// let twig = Arc::new(twig);
/// let bvh = Bvh::new(twig.clone(), BinnedSah::default().build(&twig));
/// let twig = Object::of_instances(twig, Arc::new(bvh))?;
/// let bush = Instances::new([twig], [0.0, 4.0, 8.0].map(|z| Instance::new(0, step(z))))?;
///
/// let bvh = Bvh::new(&bush, BinnedSah::default().build(&bush));
/// let ray = Ray::new([0.2, 0.2, 20.0], [0.0, 0.0, -1.0]);
/// let hit = bvh.closest_hit(&ray).expect("the last leaf");
/// assert_eq!((hit.t, hit.primitive, hit.instance), (11.0, 0, 5));
/// assert_eq!(bush.path(hit.instance).collect::<Vec<_>>(), [2, 1]);
/// assert_eq!(BruteForce::new(&bush).closest_hit(&ray), Some(hit));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Instances {
    objects: Vec<Object>,
    transforms: Vec<Affine>,
    placements: Vec<Placement>,
    count: u32,
    depth: usize,
    /// The largest |coordinate| of all, up to the next power of two.
    scale: f64,
}

impl Instances {
    /// Checks and keeps placed objects, in order.
    ///
    /// # Errors
    /// When an instance names no object, its transform has no inverse, or its box leaves the floats; when there are more than can
    /// be numbered, or objects are nested too deeply.
    pub fn new(
        objects: impl IntoIterator<Item = Object>,
        instances: impl IntoIterator<Item = Instance>,
    ) -> Result<Self, InstanceError> {
        let objects: Vec<Object> = objects.into_iter().collect();
        let instances: Vec<Instance> = instances.into_iter().collect();
        exactly(|| Self::check(objects, &instances))
    }

    fn check(objects: Vec<Object>, instances: &[Instance]) -> Result<Self, InstanceError> {
        let placements = each(instances, |number, i| place(&objects, number, i))?;
        let transforms = instances.iter().map(|i| i.transform).collect();
        let mut all = Self::number(objects, transforms, placements)?;
        all.set_scale();
        Ok(all)
    }

    /// The set of these placements, whose boxes are still to be made.
    fn number(
        objects: Vec<Object>,
        transforms: Vec<Affine>,
        mut placements: Vec<Placement>,
    ) -> Result<Self, InstanceError> {
        let depth = 1 + objects.iter().map(Object::depth).max().unwrap_or(0);
        if depth > object::MAX_DEPTH {
            return Err(InstanceError::TooDeep {
                most: object::MAX_DEPTH,
            });
        }
        let mut count = 0_u64;
        for placement in &mut placements {
            placement.first = count as u32;
            count += u64::from(objects[placement.object as usize].placements());
        }
        // So many instances of nothing could still be numbered, but not by structures over them.
        let most = count.max(placements.len() as u64);
        if most >= u64::from(u32::MAX) {
            return Err(InstanceError::TooMany { placements: most });
        }
        Ok(Self {
            objects,
            transforms,
            placements,
            count: count as u32,
            depth,
            scale: 0.0,
        })
    }

    /// Moves some instances, each given by its number in this set: all of a frame's at once. Whatever stands over the instances
    /// must then be made anew or [refitted](crate::accel::bvh::refine::refit). The set becomes what it would be, had
    /// everything been placed there at first.
    ///
    /// # Errors
    /// As [`Instances::new`], and [`InstanceError::NoSuchInstance`]; then all remain where they were.
    pub fn move_to(&mut self, moves: &[(usize, Affine)]) -> Result<(), InstanceError> {
        exactly(|| {
            let moved = each(moves, |_, &(number, transform)| {
                let Some(old) = self.placements.get(number) else {
                    return Err(InstanceError::NoSuchInstance {
                        instance: number,
                        instances: self.len(),
                    });
                };
                let to = Instance {
                    transform,
                    ..self.instance(number)
                };
                let object = &self.objects[old.object as usize];
                let mut new = Placement::new(&to, object).map_err(|flaw| flaw.of(number))?;
                new.first = old.first;
                new.set_bounds(&transform, object, self.scale);
                Ok(new)
            })?;
            for (&(number, transform), new) in moves.iter().zip(moved) {
                self.placements[number] = new;
                self.transforms[number] = transform;
            }
            self.set_scale();
            Ok(())
        })
    }

    /// Finds out how far the set reaches; where that has changed, all boxes are made anew, which it says.
    fn set_scale(&mut self) -> bool {
        let reach = self.placements.iter().fold(0.0, |m: f32, p| m.max(p.reach));
        let scale = if reach > 0.0 {
            2.0 / f64::from(math::power_to_one(reach))
        } else {
            0.0
        };
        if scale == self.scale {
            return false;
        }
        self.scale = scale;
        let (objects, transforms) = (&self.objects, &self.transforms);
        let set = |(number, placement): (usize, &mut Placement)| {
            let object = &objects[placement.object as usize];
            placement.set_bounds(&transforms[number], object, scale);
        };
        #[cfg(feature = "parallel")]
        self.placements
            .par_iter_mut()
            .with_min_len(LEAST_SHARE)
            .enumerate()
            .exactly()
            .for_each(set);
        #[cfg(not(feature = "parallel"))]
        self.placements.iter_mut().enumerate().for_each(set);
        true
    }

    /// Whether an object can be placed by a transform: it is finite and has an inverse that floats can tell.
    pub fn can_place(transform: &Affine) -> bool {
        exactly(|| Placement::of(&Instance::new(0, *transform)).is_ok())
    }
    /// The objects.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }
    /// Instance `i`, as it was given or moved to.
    ///
    /// # Panics
    /// When there is no such instance.
    pub fn instance(&self, i: usize) -> Instance {
        let Placement { object, mask, .. } = self.placements[i];
        Instance {
            object,
            transform: self.transforms[i],
            mask,
        }
    }
    /// How many placements of innermost objects these are: one more than the largest [`Hit::instance`].
    pub fn placements(&self) -> u32 {
        self.count
    }
    /// How deep instances are nested: 1 where no object is made of instances.
    pub fn depth(&self) -> usize {
        self.depth
    }
    /// The bytes that the instances of this set take, without the objects.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.placements) + size_of_val(&*self.transforms)
    }
}

/// One instance, by its number; its box is still to be made.
fn place(objects: &[Object], number: usize, at: &Instance) -> Result<Placement, InstanceError> {
    let Some(object) = objects.get(at.object as usize) else {
        return Err(InstanceError::NoSuchObject {
            instance: number,
            object: at.object,
            objects: objects.len(),
        });
    };
    Placement::new(at, object).map_err(|flaw| flaw.of(number))
}

/// What is made of each of many things, or the first error.
fn each<T: Sync, A: Send>(
    things: &[T],
    make: impl Fn(usize, &T) -> Result<A, InstanceError> + Sync + Send,
) -> Result<Vec<A>, InstanceError> {
    #[cfg(feature = "parallel")]
    if things.len() > LEAST_SHARE {
        let made: Vec<_> = (things.par_iter())
            .with_min_len(LEAST_SHARE)
            .enumerate()
            .exactly()
            .map(|(i, thing)| make(i, thing))
            .collect();
        return made.into_iter().collect();
    }
    things.iter().enumerate().map(|(i, t)| make(i, t)).collect()
}

/// Fewer instances than this are not worth another thread.
#[cfg(feature = "parallel")]
const LEAST_SHARE: usize = 256;

impl Flaw {
    fn of(self, instance: usize) -> InstanceError {
        match self {
            Self::NotFinite => InstanceError::NotFinite { instance },
            Self::Singular => InstanceError::Singular { instance },
            Self::TooLarge => InstanceError::TooLarge { instance },
        }
    }
}

impl Primitives for Instances {
    #[inline]
    fn len(&self) -> usize {
        self.placements.len()
    }
    #[inline]
    fn bounds(&self, i: usize) -> Aabb {
        self.placements[i].bounds
    }
    #[inline(always)]
    fn mask(&self, i: usize) -> u32 {
        self.placements[i].mask
    }
    #[inline]
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        // Hits count only in this box, so nothing is lost; and many boxes in a leaf are met by few rays.
        if ray
            .enters(&self.placements[i].bounds, query.t_max())
            .is_none()
        {
            return Continue(());
        }
        self.offer_part(i, Part::ALL, ray, query, counters)
    }
    const COMPOSITE: bool = true;
    fn parts(&self, i: usize, of: Part, show: &mut dyn FnMut(Aabb, Part)) {
        for (bounds, part) in self.parts_of(i, of) {
            show(bounds, part);
        }
    }
    #[inline]
    fn offer_part<Q: Query, C: Counters>(
        &self,
        i: usize,
        part: Part,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        let placement = &self.placements[i];
        let object = &self.objects[placement.object as usize];
        let made_of_instances = object.instances().is_some();
        let within = placement.ray(ray, query.t_max());
        let mut stats = TraversalStats::default();
        let mut flow = Continue(());
        let asked = Relay {
            part,
            ordered: Q::ORDERED,
            mask: query.mask(),
            time: query.time(),
            stats: C::COUNTS.then_some(&mut stats),
            visit: &mut |hit| {
                let number = if made_of_instances { hit.instance } else { 0 };
                flow = query.offer(Hit {
                    // Wraps only where a structure stands over other things than it should.
                    instance: placement.first.wrapping_add(number),
                    ..hit
                });
                flow.map_continue(|()| query.t_max())
            },
        };
        (object.structure()).relay(&within, asked);
        if C::COUNTS {
            (0..stats.nodes).for_each(|_| counters.node());
            (0..stats.leaves).for_each(|_| counters.leaf());
            counters.primitives(stats.primitives as usize);
        }
        flow
    }
}

#[cfg(test)]
mod tests;
