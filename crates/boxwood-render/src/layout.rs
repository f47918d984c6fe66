//! A scene's triangles under one structure, and the way back from a hit.
//!
//! *How it works.* What a scene places once is laid out in world space, as one mesh with a structure of its own. A mesh that is
//! placed several times, or by a group, is kept once with a structure of its own, and all of its placements are instances; the
//! structure that rays ask stands over the instances, of which the laid out mesh is the first. Where nothing is placed twice
//! there are no instances. A placement that flattens space has no way back into the mesh's space, so it is laid out too.
//!
//! *Cost.* Memory for each mesh once; 132 bytes an instance, and what the structure over them takes.

use crate::structure::{over_instances, over_mesh};
use crate::{RenderError, Shelf};
use boxwood::{
    Affine, Hit, Instances, Intersect, Object, Ray, StructureKind, Surface, Surfaces, TriangleMesh,
    Vec3,
};
use boxwood_scene::{FlatScene, Group, Instance, Located, PlacedGroup, Scene};
use std::sync::Arc;

/// A scene's triangles under one structure.
pub struct Layout {
    structure: Arc<dyn Intersect>,
    /// The structures within, each once.
    within: Vec<Arc<dyn Intersect>>,
    /// From triangles that are laid out to meshes; its own mesh has been moved to `mesh`.
    flat: FlatScene,
    mesh: Arc<TriangleMesh>,
    instances: Option<Arc<Instances>>,
    /// Meshes that are kept in a space of their own; empty where a mesh is not.
    repeated: Vec<Arc<TriangleMesh>>,
    /// The number of each mesh's first triangle among all unique triangles.
    firsts: Vec<u32>,
    /// Which placement of its mesh each of the instances is that are placed by the scene itself.
    nth: Vec<u32>,
    bytes: usize,
}

/// How structures come about.
#[derive(Clone, Copy)]
struct Made<'a> {
    kind: StructureKind,
    shelf: Option<&'a dyn Shelf>,
}

impl Made<'_> {
    fn over_mesh(self, mesh: &Arc<TriangleMesh>) -> Arc<dyn Intersect> {
        over_mesh(self.kind, mesh, self.shelf)
    }
    fn over_instances(self, set: &Arc<Instances>) -> Arc<dyn Intersect> {
        over_instances(self.kind, set, self.shelf)
    }
}

/// The number that the object of what is laid out has; meshes have their own.
const LAID_OUT: u32 = u32::MAX;

impl Layout {
    /// Lays a scene out and builds the structures. With `flatten` every placement is laid out in world space: the bits of
    /// one large mesh, and its memory.
    ///
    /// # Errors
    /// When a placement moves a vertex beyond the floats, or there are more triangles or placements than can be numbered.
    pub fn new(scene: &Scene, kind: StructureKind, flatten: bool) -> Result<Self, RenderError> {
        Self::kept(scene, kind, flatten, None)
    }

    /// The same; wide trees come from the shelf, where there is one.
    ///
    /// # Errors
    /// As [`Layout::new`].
    pub fn kept(
        scene: &Scene,
        kind: StructureKind,
        flatten: bool,
        shelf: Option<&dyn Shelf>,
    ) -> Result<Self, RenderError> {
        let made = Made { kind, shelf };
        let repeated = if flatten {
            vec![false; scene.meshes.len()]
        } else {
            repeated(scene)
        };
        let (apart, once): (Vec<Instance>, Vec<Instance>) =
            scene.instances.iter().copied().partition(|placed| {
                repeated[placed.mesh as usize] && Instances::can_place(&placed.transform)
            });
        if apart.is_empty() && (flatten || scene.placed_groups.is_empty()) {
            return Self::laid_out(scene.flatten()?, made, scene.first_triangles());
        }
        let base = Self::laid_out(scene.lay_out(&once)?, made, scene.first_triangles())?;
        base.with_instances(scene, made, &repeated, apart)
    }

    fn laid_out(
        mut flat: FlatScene,
        made: Made<'_>,
        firsts: Vec<u32>,
    ) -> Result<Self, RenderError> {
        let mesh = Arc::new(std::mem::take(&mut flat.mesh));
        let structure = made.over_mesh(&mesh);
        Ok(Self {
            bytes: structure.statistics().bytes,
            structure,
            within: Vec::new(),
            flat,
            mesh,
            instances: None,
            repeated: Vec::new(),
            firsts,
            nth: Vec::new(),
        })
    }

    fn with_instances(
        self,
        scene: &Scene,
        made: Made<'_>,
        repeated: &[bool],
        mut apart: Vec<Instance>,
    ) -> Result<Self, RenderError> {
        let mut within = vec![self.structure.clone()];
        let mut meshes = Vec::with_capacity(scene.meshes.len());
        // Of each mesh, and then of each group, the object, where there is one.
        let mut objects = Vec::with_capacity(scene.meshes.len() + scene.groups.len());
        for (number, (mesh, &repeated)) in (0..).zip(scene.meshes.iter().zip(repeated)) {
            let kept = if repeated {
                TriangleMesh::new(
                    mesh.positions.iter().copied(),
                    mesh.triangles.iter().copied(),
                )?
            } else {
                TriangleMesh::default()
            };
            let kept = Arc::new(kept);
            if repeated {
                within.push(made.over_mesh(&kept));
            }
            objects.push(
                repeated.then(|| {
                    Object::new(&*kept, within[within.len() - 1].clone()).numbered(number)
                }),
            );
            meshes.push(kept);
        }
        let mut bytes = self.bytes;
        for group in &scene.groups {
            let set = Self::set(scene, &objects, &group.instances, &group.groups, None)?;
            let set = Arc::new(set);
            bytes += set.bytes();
            let structure = made.over_instances(&set);
            within.push(structure.clone());
            objects.push(Some(Object::of_instances(set, structure)?));
        }
        // In the order of flat numbers.
        let mut nth = Vec::with_capacity(apart.len());
        let mut times = vec![0_u32; scene.meshes.len()];
        let mut numbered: Vec<(u32, Instance)> = apart
            .drain(..)
            .map(|instance| {
                let times = &mut times[instance.mesh as usize];
                *times += 1;
                (*times - 1, instance)
            })
            .collect();
        numbered.sort_by_key(|(nth, instance)| (*nth, instance.mesh));
        for (number, instance) in numbered {
            nth.push(number);
            apart.push(instance);
        }
        let laid_out = Object::new(&*self.mesh, self.structure.clone()).numbered(LAID_OUT);
        let set = Self::set(
            scene,
            &objects,
            &apart,
            &scene.placed_groups,
            Some(laid_out),
        )?;
        let set = Arc::new(set);
        let structure = made.over_instances(&set);
        bytes += set.bytes() + structure.statistics().bytes;
        bytes += within[1..]
            .iter()
            .map(|s| s.statistics().bytes)
            .sum::<usize>();
        Ok(Self {
            structure,
            within,
            instances: Some(set),
            repeated: meshes,
            nth,
            bytes,
            ..self
        })
    }

    /// Placed meshes and groups; in front of them, where there is any, what is laid out.
    fn set(
        scene: &Scene,
        objects: &[Option<Object>],
        instances: &[Instance],
        groups: &[PlacedGroup],
        laid_out: Option<Object>,
    ) -> Result<Instances, RenderError> {
        // Those that are placed here are numbered anew, in the order in which they are named.
        let mut numbers = vec![None; objects.len()];
        let mut placed = Vec::with_capacity(instances.len() + groups.len() + 1);
        let mut used = Vec::new();
        if let Some(object) = laid_out {
            used.push(object);
            placed.push(boxwood::Instance::new(0, Affine::IDENTITY));
        }
        let after = scene.meshes.len();
        let meshes = instances.iter().map(|i| (i.mesh as usize, i.transform));
        let groups = groups
            .iter()
            .map(|g| (after + g.group as usize, g.transform));
        for (thing, transform) in meshes.chain(groups) {
            let Some(object) = &objects[thing] else {
                continue;
            };
            let number = *numbers[thing].get_or_insert_with(|| {
                used.push(object.clone());
                used.len() as u32 - 1
            });
            placed.push(boxwood::Instance::new(number, transform));
        }
        Ok(Instances::new(used, placed)?)
    }

    /// What rays ask.
    pub fn structure(&self) -> &dyn Intersect {
        &*self.structure
    }

    /// The bytes that all structures and instances take, without meshes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// How many instances there are, nested ones multiplied; 0 where everything is laid out.
    pub fn placements(&self) -> u32 {
        self.instances.as_ref().map_or(0, |set| set.placements())
    }

    /// How many structures there are: one for each mesh and group that is kept apart, one for what is laid out, one over all.
    pub fn structures(&self) -> usize {
        self.within.len() + 1
    }

    /// The set that a hit's triangle lies in, if that is not laid out.
    fn apart(&self, instance: u32) -> Option<(&Arc<Instances>, u32)> {
        let set = self.instances.as_ref()?;
        let number = set.object_of(instance)?.number();
        (number != LAID_OUT).then_some((set, number))
    }

    /// What a hit met. `instance` is which placement of its mesh; for one that is placed by groups, its number among all
    /// placements.
    ///
    /// # Panics
    /// When the hit is none of this layout's.
    pub fn locate(&self, hit: &Hit) -> Located {
        match self.apart(hit.instance) {
            None => self.flat.locate(hit.primitive),
            Some((_, mesh)) => Located {
                mesh,
                triangle: hit.primitive,
                primitive: self.firsts[mesh as usize] + hit.primitive,
                // The first number is that of what is laid out.
                instance: (hit.instance.checked_sub(1))
                    .and_then(|i| self.nth.get(i as usize).copied())
                    .unwrap_or(hit.instance),
            },
        }
    }

    /// From a hit's mesh to the world, and whether the mesh is an instance: surfaces of those keep their front where the
    /// transform mirrors, while triangles that are laid out turn over.
    pub(crate) fn transform(&self, hit: &Hit) -> (Affine, bool) {
        match self.apart(hit.instance) {
            None => (*self.flat.locate_placed(hit.primitive).1, false),
            Some((set, _)) => (set.transform_of(hit.instance).unwrap_or_default(), true),
        }
    }

    /// The surface at a hit.
    ///
    /// # Panics
    /// When the hit is none of this layout's.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        match self.apart(hit.instance) {
            None => self.mesh.surface(ray, hit),
            Some((set, mesh)) => set.surface(ray, hit, |_, ray, hit| {
                self.repeated[mesh as usize].surface(ray, hit)
            }),
        }
    }

    /// The corners of a hit's triangle in the world.
    pub(crate) fn corners(&self, hit: &Hit) -> [Vec3; 3] {
        match self.apart(hit.instance) {
            None => self.mesh.triangle(hit.primitive as usize),
            Some((_, mesh)) => {
                let (transform, _) = self.transform(hit);
                let corners = self.repeated[mesh as usize].triangle(hit.primitive as usize);
                corners.map(|p| transform.point(p))
            }
        }
    }

    /// The triangles that are laid out in the world.
    pub(crate) fn laid_out_triangles(&self) -> u32 {
        self.mesh.triangles().len() as u32
    }

    /// The mesh of each instance that is not laid out, by number.
    pub(crate) fn instanced(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        (1..self.placements()).filter_map(|i| Some((i, self.apart(i)?.1)))
    }

    /// The mesh of a triangle by (instance, primitive).
    pub(crate) fn mesh_of(&self, (instance, primitive): (u32, u32)) -> u32 {
        match self.apart(instance) {
            None => self.flat.locate(primitive).mesh,
            Some((_, mesh)) => mesh,
        }
    }
}

/// Which meshes are placed more than once, or by a group.
fn repeated(scene: &Scene) -> Vec<bool> {
    let mut times = vec![0_u32; scene.meshes.len()];
    for placed in &scene.instances {
        times[placed.mesh as usize] += 1;
    }
    let mut repeated: Vec<bool> = times.into_iter().map(|times| times > 1).collect();
    let placed = scene
        .groups
        .iter()
        .flat_map(|group: &Group| &group.instances);
    placed.for_each(|placed| repeated[placed.mesh as usize] = true);
    repeated
}
