//! Objects that come, go and move from frame to frame, under one structure.
//!
//! *How it works.* [`TopLevel`] holds placed objects and a wide tree over them. Objects are inserted, removed and moved by handles; rays see all
//! that at the next [`commit`](TopLevel::commit), as they do in Embree. Where objects only moved, the tree is fitted to them, and built anew when
//! that pays ([`Upkeep`]); where some came or went it is built anew, which for thousands of objects is a matter of a millisecond or few
//! (`docs/decisions/0009-change.md`).
//!
//! *What the answer is.* That of [`Instances`] made of all that is there, in the order of insertion: whatever happened before, the
//! bits are those of a scene that is put up at once.
//!
//! *Cost.* About 400 bytes an object.

use super::bvh::{Updated, Upkeep, WideBvh, WideSah};
use crate::geometry::{Aabb, Affine, Hit, Ray};
use crate::inspect::{Cell, Statistics};
use crate::primitive::{Instance, InstanceError, Instances, Object};
use crate::query::{Counters, Query, Traverse};
use crate::simd::exactly;
use alloc::vec::Vec;
use core::mem;

/// Placed objects under a structure that changes from frame to frame.
///
/// ```
/// use boxwood::{Affine, BinnedSah, Bvh, Instance, Intersect, Object, Ray, TopLevel, TriangleMesh};
/// use std::sync::Arc;
///
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Arc::new(TriangleMesh::new(corners, [[0_u32, 1, 2]])?);
/// let tree = BinnedSah::default().build(&mesh);
/// let leaf = Object::new(&mesh, Arc::new(Bvh::new(mesh.clone(), tree)));
///
/// let mut scene = TopLevel::new([leaf])?;
/// let at = |z: f32| Affine::translation([0.0, 0.0, z]);
/// let near = scene.insert(Instance::new(0, at(5.0)))?;
/// let far = scene.insert(Instance::new(0, at(9.0)))?;
/// scene.commit();
/// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
/// let hit = scene.closest_hit(&ray).expect("the near leaf");
/// assert_eq!((hit.t, scene.handle_of(&hit)), (5.0, Some(near)));
///
/// scene.remove(near);
/// scene.move_to(far, at(2.0))?;
/// scene.commit();
/// let hit = scene.closest_hit(&ray).expect("the other one");
/// assert_eq!((hit.t, scene.handle_of(&hit)), (2.0, Some(far)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TopLevel {
    kept: Upkeep<Instances, 8>,
    /// As of the next commit, like all that follows.
    objects: Vec<Object>,
    /// In the order of insertion; without those that were removed since the last commit only when that is over.
    placed: Vec<Placed>,
    /// By the first number of a handle.
    slots: Vec<Slot>,
    free: Vec<u32>,
    /// How many objects are placed.
    len: usize,
    /// How many placements of innermost objects that makes.
    count: u64,
    /// By the number of an instance as of the last commit.
    handles: Vec<Handle>,
    /// Whether anything but moves has happened.
    renew: bool,
    /// Where objects moved that the tree knows.
    moved: Vec<u32>,
}

/// Names an object that was inserted, as long as it is there. Those of other scenes name nothing, or anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Handle {
    slot: u32,
    /// How often the slot was used before.
    turn: u32,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    turn: u32,
    /// Its place in the order; [`NOWHERE`] when it is free.
    place: u32,
}

const NOWHERE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Placed {
    /// `None` when it was removed.
    handle: Option<Handle>,
    instance: Instance,
    /// Its number in the set as of the last commit, while it is as it was there.
    number: Option<u32>,
}

/// What [`TopLevel::commit`] did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Committed {
    /// Nothing had happened.
    Nothing,
    /// Objects had moved; this was done to the tree.
    Moved(Updated),
    /// Objects had come or gone or become others: the tree was built anew.
    Renewed,
}

impl TopLevel {
    /// A scene of these objects, of which none is placed yet.
    ///
    /// # Errors
    /// When an object is too deeply nested.
    pub fn new(objects: impl IntoIterator<Item = Object>) -> Result<Self, InstanceError> {
        let objects: Vec<Object> = objects.into_iter().collect();
        let none = Instances::new(objects.clone(), [])?;
        Ok(Self {
            kept: Upkeep::new(none, WideSah::default(), INSTANCE * RAYS),
            objects,
            placed: Vec::new(),
            slots: Vec::new(),
            free: Vec::new(),
            len: 0,
            count: 0,
            handles: Vec::new(),
            renew: false,
            moved: Vec::new(),
        })
    }

    /// The same for so many rays between two commits: what makes a better tree worth its price. A million unless it is said.
    #[must_use]
    pub fn for_rays(mut self, rays: f64) -> Self {
        self.kept.rays = INSTANCE * rays;
        self
    }

    /// Adds an object, which [`Instance::object`] may name from now on, and says its number.
    ///
    /// # Errors
    /// When it is too deeply nested.
    pub fn add_object(&mut self, object: Object) -> Result<u32, InstanceError> {
        Instances::new([object.clone()], [])?;
        self.objects.push(object);
        self.renew = true;
        Ok(self.objects.len() as u32 - 1)
    }

    /// Puts another object where one was, wherever it is placed: a mesh that has bent, with its structure.
    ///
    /// # Errors
    /// When there is no such object, the other one is too deeply nested, cannot be placed where the first one is, or there would be too
    /// many placements. Then nothing changes.
    pub fn set_object(&mut self, number: u32, object: Object) -> Result<(), InstanceError> {
        let Some(old) = self.objects.get(number as usize) else {
            return Err(InstanceError::NoSuchObject {
                instance: self.placed.len(),
                object: number,
                objects: self.objects.len(),
            });
        };
        Instances::new([object.clone()], [])?;
        let here = |placed: &&Placed| placed.handle.is_some() && placed.instance.object == number;
        let there = self.placed.iter().filter(here).count() as u64;
        let count = self.count - there * u64::from(old.placements());
        let count = Self::counted(count + there * u64::from(object.placements()))?;
        let old = mem::replace(&mut self.objects[number as usize], object);
        let mut all = self.placed.iter().filter(here);
        if let Err(flaw) = all.try_for_each(|placed| self.check(&placed.instance)) {
            self.objects[number as usize] = old;
            return Err(flaw);
        }
        for placed in &mut self.placed {
            if placed.instance.object == number {
                placed.number = None;
            }
        }
        self.count = count;
        self.renew = true;
        Ok(())
    }

    /// Places an object.
    ///
    /// # Errors
    /// As [`Instances::new`]; the number of the instance in the message is 0.
    pub fn insert(&mut self, instance: Instance) -> Result<Handle, InstanceError> {
        self.check(&instance)?;
        let more = self.objects[instance.object as usize].placements();
        // Objects of nothing are numbered too, by structures over them.
        let count = Self::counted(self.count + u64::from(more))?;
        Self::counted(self.placed.len() as u64 + 1)?;
        self.count = count;
        self.len += 1;
        let slot = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Slot {
                turn: 0,
                place: NOWHERE,
            });
            self.slots.len() as u32 - 1
        });
        self.slots[slot as usize].place = self.placed.len() as u32;
        let turn = self.slots[slot as usize].turn;
        let handle = Handle { slot, turn };
        self.placed.push(Placed {
            handle: Some(handle),
            instance,
            number: None,
        });
        self.renew = true;
        Ok(handle)
    }

    /// Takes an object away; what it was, or `None` when it is not there any more.
    pub fn remove(&mut self, handle: Handle) -> Option<Instance> {
        let place = self.place(handle)?;
        let slot = &mut self.slots[handle.slot as usize];
        slot.place = NOWHERE;
        // A slot whose turns are used up is never used again.
        if let Some(turn) = slot.turn.checked_add(1) {
            slot.turn = turn;
            self.free.push(handle.slot);
        }
        self.placed[place].handle = None;
        self.len -= 1;
        self.renew = true;
        let instance = self.placed[place].instance;
        self.count -= u64::from(self.objects[instance.object as usize].placements());
        Some(instance)
    }

    /// Moves an object to where the transform says, and says whether it is still there.
    ///
    /// # Errors
    /// When it cannot be placed so; then it remains where it was. The number of the instance in the message is 0.
    pub fn move_to(&mut self, handle: Handle, transform: Affine) -> Result<bool, InstanceError> {
        let Some(place) = self.place(handle) else {
            return Ok(false);
        };
        let instance = Instance {
            transform,
            ..self.placed[place].instance
        };
        self.check(&instance)?;
        let placed = &mut self.placed[place];
        placed.instance = instance;
        self.moved
            .extend(placed.number.take().map(|_| place as u32));
        Ok(true)
    }

    /// An object as of the next commit; `None` when it is not there any more.
    pub fn get(&self, handle: Handle) -> Option<Instance> {
        Some(self.placed[self.place(handle)?].instance)
    }

    /// How many objects are placed, as of the next commit.
    pub fn len(&self) -> usize {
        self.len
    }
    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Shows rays all that has happened.
    pub fn commit(&mut self) -> Committed {
        if self.renew {
            self.renew();
            return Committed::Renewed;
        }
        if self.moved.is_empty() {
            return Committed::Nothing;
        }
        let moves: Vec<_> = (self.moved.iter())
            .map(|&place| {
                (
                    place as usize,
                    self.placed[place as usize].instance.transform,
                )
            })
            .collect();
        let (moved, updated) = self.kept.update(|instances| instances.move_to(&moves));
        moved.expect("they were looked at when they were moved");
        for place in self.moved.drain(..) {
            self.placed[place as usize].number = Some(place);
        }
        Committed::Moved(updated)
    }

    fn renew(&mut self) {
        self.placed.retain(|placed| placed.handle.is_some());
        let all: Vec<_> = self.placed.iter().map(|p| (p.instance, p.number)).collect();
        let old = self.kept.bvh().primitives();
        let set = exactly(|| old.renewed(self.objects.clone(), &all));
        self.kept.replace(set.expect("each was looked at before"));
        self.handles.clear();
        for (number, placed) in self.placed.iter_mut().enumerate() {
            placed.number = Some(number as u32);
            if let Some(handle) = placed.handle {
                self.slots[handle.slot as usize].place = number as u32;
                self.handles.push(handle);
            }
        }
        self.moved.clear();
        self.renew = false;
    }

    /// All that is placed as of the last commit, in the order of insertion.
    pub fn instances(&self) -> &Instances {
        self.kept.bvh().primitives()
    }

    /// The object that a hit met, as of the last commit. What it is made of, [`Instances::path`] tells.
    pub fn handle_of(&self, hit: &Hit) -> Option<Handle> {
        let number = self.instances().path(hit.instance).next()?;
        self.handles.get(number).copied()
    }

    fn bvh(&self) -> &WideBvh<Instances, 8> {
        self.kept.bvh()
    }

    fn place(&self, handle: Handle) -> Option<usize> {
        let slot = self.slots.get(handle.slot as usize)?;
        (slot.turn == handle.turn && slot.place != NOWHERE).then_some(slot.place as usize)
    }

    fn check(&self, instance: &Instance) -> Result<(), InstanceError> {
        exactly(|| Instances::check_one(&self.objects, instance))
    }

    /// A count of placements, if they can be numbered.
    fn counted(placements: u64) -> Result<u64, InstanceError> {
        if placements < MOST {
            Ok(placements)
        } else {
            Err(InstanceError::TooMany { placements })
        }
    }
}

/// More could not be numbered, or not by the tree.
const MOST: u64 = 1 << 28;
/// A ray that meets an instance goes on inside: that costs about so many times as much as a triangle.
const INSTANCE: f64 = 8.0;
/// Rays between two commits, unless somebody says better.
const RAYS: f64 = 1.0e6;

impl Traverse for TopLevel {
    fn bounds(&self) -> Aabb {
        Traverse::bounds(self.bvh())
    }
    fn statistics(&self) -> Statistics {
        Traverse::statistics(self.bvh())
    }
    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        Traverse::cells(self.bvh(), show);
    }
    #[inline]
    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        self.bvh().traverse(ray, query, counters);
    }
    fn traverse_each<Q: Query, C: Counters>(
        &self,
        rays: &[Ray],
        queries: &mut [Q],
        counters: &mut C,
    ) {
        self.bvh().traverse_each(rays, queries, counters);
    }
}
