//! Numbered sets of things a ray may meet.

mod chain;
mod fingerprint;
mod instances;
mod mesh;
mod moving_mesh;
mod shapes;

pub use chain::Chain;
pub use fingerprint::fingerprint;
pub use instances::{Instance, InstanceError, Instances, Object};
pub use mesh::{MeshError, MollerTrumbore, TriangleMesh};
pub use moving_mesh::{MotionError, MovingMesh, Pose};
pub use shapes::{
    Cuboids, Cylinders, Discs, ImplicitSurfaces, OrientedCuboids, Planes, Shapes, Spheres, Tori,
};

use crate::geometry::{Aabb, Hit, PreparedRay, Ray, Surface, Vec3};
use crate::query::{Counters, Part, Query, Step};
use alloc::sync::Arc;
use core::ops::ControlFlow::{self, Continue};

/// A numbered set of things a ray may meet: what every structure is built over.
///
/// Implemented for meshes, the analytic shapes of this module, placed objects ([`Instances`]), and `&P` and `Arc<P>` of any of them; users write their
/// own by saying how many there are, where each lies and how a ray meets it.
pub trait Primitives {
    /// How many.
    fn len(&self) -> usize;
    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Around primitive `i`; an empty box for a primitive that nothing can hit.
    fn bounds(&self, i: usize) -> Aabb;
    /// Around the part of primitive `i` that lies in a box; empty when there is none. Structures that cut primitives ask
    /// this only where [`Primitives::WITHIN_SLACK`] holds, and else take the common part of both boxes.
    fn clipped_bounds(&self, i: usize, within: &Aabb) -> Aabb {
        self.bounds(i).intersection(*within)
    }
    /// Whether primitive `i` and a box may share a point: exact for triangles, by their boxes for anything else.
    fn overlaps(&self, i: usize, within: &Aabb) -> bool {
        !self.bounds(i).intersection(*within).is_empty()
    }
    /// The corners of primitive `i` where it is a triangle; `None` for anything else. Structures that divide space by
    /// slanted planes find them here.
    fn corners(&self, _i: usize) -> Option<[Vec3; 3]> {
        None
    }
    /// Begins to load what [`Primitives::corners`] will read; a hint for sets that are asked for many corners, in an order of
    /// their structure's. Any number may be asked for.
    #[inline(always)]
    fn foresee(&self, _i: usize, _step: Foresight) {}
    /// One past the last primitive of the object that primitive `i` belongs to: objects are runs of primitives, such as
    /// the placed meshes of a scene. By default each primitive is an object.
    fn object_end(&self, i: usize) -> usize {
        i + 1
    }
    /// Which queries see primitive `i`: those whose [`Query::mask`] shares a bit. All by default.
    #[inline(always)]
    fn mask(&self, _i: usize) -> u32 {
        u32::MAX
    }
    /// Shows primitive `i` to the query: offers each hit within `[ray.t_min, query.t_max()]`.
    ///
    /// The same call must always offer the same hits: structures agree because they all ask this.
    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()>;
    /// Whether every hit that [`Primitives::offer`] makes is *proven* to lie in the primitive's box padded by the slack
    /// (see [`PreparedRay`]). Where it is not, [`offer`] asks for each hit and drops those outside.
    const WITHIN_SLACK: bool = false;
    /// Whether primitives may consist of parts, by which wide trees hold them, and are so dear to meet that each deserves a box of its own in a
    /// tree: [`Instances`] are such.
    const COMPOSITE: bool = false;
    /// Shows what a part of primitive `i` consists of, in boxes from which no hit is farther away than [`PARTS_SLACK`] times the slack; nothing where it
    /// cannot be taken apart.
    fn parts(&self, _i: usize, _of: Part, _show: &mut dyn FnMut(Aabb, Part)) {}
    /// [`Primitives::offer`] of a part that was shown, or of everything ([`Part::ALL`]), for a ray that meets its box. By default of everything.
    #[inline(always)]
    fn offer_part<Q: Query, C: Counters>(
        &self,
        i: usize,
        _part: Part,
        ray: &PreparedRay,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<()> {
        self.offer(i, ray, query, counters)
    }
    /// Whether every primitive is the triangle that [`Primitives::corners`] gives, met by the canonical test: what wide
    /// structures may then do lane by lane. [`TriangleMesh`] is such a set.
    const TRIANGLES: bool = false;
}

/// How far from the boxes of [`Primitives::parts`] hits may be, in units of the slack that a ray has with whole primitives: a ray that comes from far
/// away is rounded within an object's space, and there is no box in the world that is padded for all distances.
pub const PARTS_SLACK: f32 = 8.0;

/// How far ahead of time [`Primitives::foresee`] is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foresight {
    /// Twice as far as later: time to load what tells where the corners are.
    Far,
    /// What was asked for earlier is there: time to load the corners.
    Near,
}

/// Primitives that can say what their surface is like where a ray met it.
pub trait Surfaces: Primitives {
    /// The surface at a hit that a structure over these primitives returned for the ray.
    ///
    /// # Panics
    /// When the hit names a primitive that does not exist.
    fn surface(&self, ray: &Ray, hit: &Hit) -> Surface;
}

/// Primitives that are all triangles: what is asked about [distances and insides](crate::proximity).
///
/// [`Primitives::bounds`] must hold all three corners.
pub trait Triangles: Primitives {
    /// The three corners of triangle `i`.
    ///
    /// # Panics
    /// When there is no such triangle.
    fn triangle(&self, i: usize) -> [Vec3; 3];
}

/// [`Primitives::offer`] as structures call it: masks are obeyed, the test is counted, and a hit counts only where it lies
/// in the primitive's own padded box. So a box on the way to it can never be passed over, whatever the shape claims.
#[inline(always)]
pub fn offer<P: Primitives + ?Sized, Q: Query, C: Counters>(
    primitives: &P,
    i: usize,
    ray: &PreparedRay,
    query: &mut Q,
    counters: &mut C,
) -> ControlFlow<()> {
    show(primitives, i, None, ray, query, counters)
}

/// The same of a part of the primitive whose box the ray was found to meet; a hit must lie in the padded box of the whole one, as if it had been
/// found there.
#[inline(always)]
pub fn offer_part<P: Primitives + ?Sized, Q: Query, C: Counters>(
    primitives: &P,
    i: usize,
    part: Part,
    ray: &PreparedRay,
    query: &mut Q,
    counters: &mut C,
) -> ControlFlow<()> {
    show(primitives, i, Some(part), ray, query, counters)
}

#[inline(always)]
fn show<P: Primitives + ?Sized, Q: Query, C: Counters>(
    primitives: &P,
    i: usize,
    part: Option<Part>,
    ray: &PreparedRay,
    query: &mut Q,
    counters: &mut C,
) -> ControlFlow<()> {
    if primitives.mask(i) & query.mask() == 0 {
        return Continue(());
    }
    counters.primitives(1);
    if C::EXPLAINS {
        counters.step(Step::Primitive {
            primitive: i as u32,
        });
    }
    if P::WITHIN_SLACK {
        return match part {
            None => primitives.offer(i, ray, query, counters),
            Some(part) => primitives.offer_part(i, part, ray, query, counters),
        };
    }
    let around = primitives.bounds(i);
    // A box with NaN is empty, and no box around it knows of it.
    if around.is_empty() {
        return Continue(());
    }
    let query = &mut InOwnBox { around, ray, query };
    match part {
        None => primitives.offer(i, ray, query, counters),
        Some(part) => primitives.offer_part(i, part, ray, query, counters),
    }
}

/// Shows every primitive to the query, as the judge does: for a ray that a structure cannot answer otherwise.
#[cold]
pub(crate) fn offer_all<P: Primitives, Q: Query, C: Counters>(
    primitives: &P,
    ray: &PreparedRay,
    query: &mut Q,
    counters: &mut C,
) {
    for i in 0..primitives.len() {
        if offer(primitives, i, ray, query, counters).is_break() {
            return;
        }
    }
}

struct InOwnBox<'a, Q> {
    around: Aabb,
    ray: &'a PreparedRay,
    query: &'a mut Q,
}

impl<Q: Query> Query for InOwnBox<'_, Q> {
    const ORDERED: bool = Q::ORDERED;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.query.t_max()
    }
    #[inline(always)]
    fn mask(&self) -> u32 {
        self.query.mask()
    }
    #[inline(always)]
    fn time(&self) -> f32 {
        self.query.time()
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> ControlFlow<()> {
        let counts = self.ray.t_min <= hit.t
            && hit.t <= self.query.t_max().min(f32::MAX)
            && self.ray.is_inside(&self.around, hit.t);
        if counts {
            self.query.offer(hit)
        } else {
            Continue(())
        }
    }
}

macro_rules! forward {
    ($($owner:ty),*) => {$(
        impl<P: Primitives + ?Sized> Primitives for $owner {
            #[inline]
            fn len(&self) -> usize {
                (**self).len()
            }
            #[inline]
            fn bounds(&self, i: usize) -> Aabb {
                (**self).bounds(i)
            }
            #[inline]
            fn clipped_bounds(&self, i: usize, within: &Aabb) -> Aabb {
                (**self).clipped_bounds(i, within)
            }
            #[inline]
            fn overlaps(&self, i: usize, within: &Aabb) -> bool {
                (**self).overlaps(i, within)
            }
            #[inline(always)]
            fn corners(&self, i: usize) -> Option<[Vec3; 3]> {
                (**self).corners(i)
            }
            #[inline(always)]
            fn foresee(&self, i: usize, step: Foresight) {
                (**self).foresee(i, step);
            }
            #[inline]
            fn object_end(&self, i: usize) -> usize {
                (**self).object_end(i)
            }
            #[inline(always)]
            fn mask(&self, i: usize) -> u32 {
                (**self).mask(i)
            }
            #[inline(always)]
            fn offer<Q: Query, C: Counters>(
                &self,
                i: usize,
                ray: &PreparedRay,
                query: &mut Q,
                counters: &mut C,
            ) -> ControlFlow<()> {
                (**self).offer(i, ray, query, counters)
            }
            const COMPOSITE: bool = P::COMPOSITE;
            fn parts(&self, i: usize, of: Part, show: &mut dyn FnMut(Aabb, Part)) {
                (**self).parts(i, of, show);
            }
            #[inline(always)]
            fn offer_part<Q: Query, C: Counters>(
                &self,
                i: usize,
                part: Part,
                ray: &PreparedRay,
                query: &mut Q,
                counters: &mut C,
            ) -> ControlFlow<()> {
                (**self).offer_part(i, part, ray, query, counters)
            }
            const WITHIN_SLACK: bool = P::WITHIN_SLACK;
            const TRIANGLES: bool = P::TRIANGLES;
        }
        impl<P: Surfaces + ?Sized> Surfaces for $owner {
            fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
                (**self).surface(ray, hit)
            }
        }
        impl<P: Triangles + ?Sized> Triangles for $owner {
            #[inline(always)]
            fn triangle(&self, i: usize) -> [Vec3; 3] {
                (**self).triangle(i)
            }
        }
    )*};
}
// Every structure can own its primitives, borrow them or share them.
forward!(&P, Arc<P>);

/// Around all primitives.
pub(crate) fn bounds_of(primitives: &impl Primitives) -> Aabb {
    (0..primitives.len()).fold(Aabb::EMPTY, |b, i| b.union(primitives.bounds(i)))
}
