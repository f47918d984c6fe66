//! The way from a hit back to the objects it lies in.

use super::{Instances, Object};
use crate::geometry::{Affine, Hit, Ray, Surface};
use crate::simd::exactly;

impl Instances {
    /// The numbers of the instances that a placement lies in, outermost first: the tree in the forest, the leaf on the tree.
    /// Ends early for a number that no placement has.
    pub fn path(&self, placement: u32) -> impl Iterator<Item = usize> + '_ {
        self.steps(placement).map(|(_, i)| i)
    }

    /// The innermost object of a placement, whose primitives [`Hit::primitive`] numbers; `None` for a number
    /// that no placement has.
    pub fn object_of(&self, placement: u32) -> Option<&Object> {
        let (set, i) = self.steps(placement).last()?;
        Some(set.object(i))
    }

    /// From the innermost object's space to that of this set; `None` for a number that no placement has.
    pub fn transform_of(&self, placement: u32) -> Option<Affine> {
        let mut steps = self.steps(placement);
        let (set, i) = steps.next()?;
        let first = set.transforms[i];
        Some(exactly(|| {
            steps.fold(first, |outer, (set, i)| set.transforms[i].then(&outer))
        }))
    }

    /// The ray in the space of a placement's innermost object, as its structure was asked. At each level on the way the
    /// origin becomes `L (o − c)` and the direction `L d`, in double precision, rounded once: `c` is where the transform puts the
    /// origin, `L` the inverse of its linear part in floats. `t` means the same in every space.
    pub fn ray_within(&self, ray: &Ray, placement: u32) -> Ray {
        exactly(|| {
            self.steps(placement)
                .fold(*ray, |ray, (set, i)| set.placements[i].ray(&ray, ray.t_max))
        })
    }

    /// The surface at a hit, with error bounds that hold in this set's space. `inner` gives that of the innermost object, by the
    /// ray and the hit in its space.
    ///
    /// ```
    /// # use boxwood::*;
    /// # use std::sync::Arc;
    /// let ball = Arc::new(Shapes::new([Sphere::new([0.0; 3], 1.0)])?);
    /// let object = Object::new(&ball, Arc::new(BruteForce::new(ball.clone())));
    /// let tall = Affine::scale([1.0, 3.0, 1.0]);
    /// let set = Instances::new([object], [Instance::new(0, tall)])?;
    /// let ray = Ray::new([0.0, 5.0, 0.0], [0.0, -1.0, 0.0]);
    /// let hit = BruteForce::new(&set).closest_hit(&ray).expect("below");
    /// let surface = set.surface(&ray, &hit, |_, ray, hit| ball.surface(ray, hit));
    /// assert_eq!(surface.position, [0.0, 3.0, 0.0].into());
    /// assert_eq!(surface.normal, [0.0, 1.0, 0.0].into());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// When the hit names a placement that does not exist.
    pub fn surface(
        &self,
        ray: &Ray,
        hit: &Hit,
        inner: impl FnOnce(&Object, &Ray, &Hit) -> Surface,
    ) -> Surface {
        exactly(|| self.surface_by(ray, hit, inner))
    }

    fn surface_by(
        &self,
        ray: &Ray,
        hit: &Hit,
        inner: impl FnOnce(&Object, &Ray, &Hit) -> Surface,
    ) -> Surface {
        // The path on the stack; nothing is deeper.
        let mut path = [(self, 0); super::object::MAX_DEPTH];
        let mut depth = 0;
        let mut ray = *ray;
        for step in self.steps(hit.instance) {
            path[depth] = step;
            depth += 1;
            let (set, i) = step;
            ray = set.placements[i].ray(&ray, ray.t_max);
        }
        let (set, i) = path[..depth].last().copied().expect("a placement's number");
        let within = Hit {
            instance: 0,
            ..*hit
        };
        let surface = inner(set.object(i), &ray, &within);
        path[..depth]
            .iter()
            .rev()
            .fold(surface, |surface, &(set, i)| {
                set.placements[i].surface(&set.transforms[i], &surface)
            })
    }

    fn object(&self, i: usize) -> &Object {
        &self.objects[self.placements[i].object as usize]
    }

    /// Sets and the instances in them, outermost first.
    fn steps(&self, placement: u32) -> impl Iterator<Item = (&Instances, usize)> {
        let mut next = Some((self, placement));
        core::iter::from_fn(move || {
            let (set, number) = next?;
            // Of instances of nothing, the last one that begins there is as good as any: nothing hits them.
            let after = set.placements.partition_point(|p| p.first <= number);
            let i = after.checked_sub(1).filter(|_| number < set.count)?;
            let within = number - set.placements[i].first;
            next = (set.object(i).instances()).map(|inner| (&**inner, within));
            Some((set, i))
        })
    }
}
