//! A set that becomes another one: some instances go, some come, some move, most stay.

use super::{Instance, InstanceError, Instances, Object};
use alloc::vec::Vec;

impl Instances {
    /// Whether an instance can be in a set of these objects.
    pub(crate) fn check_one(objects: &[Object], instance: &Instance) -> Result<(), InstanceError> {
        super::place(objects, 0, instance).map(|_| ())
    }

    /// The set of these objects and instances, some of which this set had under the numbers beside them, with the same object: what is known
    /// of them is taken from here. It is the set that [`Instances::new`] makes.
    ///
    /// # Errors
    /// As [`Instances::new`].
    pub(crate) fn renewed(
        &self,
        objects: Vec<Object>,
        instances: &[(Instance, Option<u32>)],
    ) -> Result<Self, InstanceError> {
        let placements = super::each(instances, |number, &(instance, old)| {
            match old.and_then(|old| self.placements.get(old as usize)) {
                Some(&placement) => Ok(placement),
                None => super::place(&objects, number, &instance),
            }
        })?;
        let transforms = instances.iter().map(|(i, _)| i.transform).collect();
        let mut all = Self::number(objects, transforms, placements)?;
        // Boxes depend on how far the set reaches.
        all.scale = self.scale;
        if !all.set_scale() {
            for (number, (_, old)) in instances.iter().enumerate() {
                if old.is_none() {
                    let object = &all.objects[all.placements[number].object as usize];
                    all.placements[number].set_bounds(&all.transforms[number], object, all.scale);
                }
            }
        }
        Ok(all)
    }
}
