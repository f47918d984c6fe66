//! What an instance consists of: the parts of its object's structure, with boxes in the world.
//!
//! *How it works.* A box that is turned grows; so a part's box is made of those of the parts that it consists of in turn. It is padded for the way
//! in as that of a whole instance is (`placement.rs`), but for rays from any distance, which is why it has to be met with
//! [`PARTS_SLACK`](crate::primitive::PARTS_SLACK) times the slack: whether a hit counts is decided by the whole instance's box alone, and no box of
//! a part may stand in its way.

use super::Instances;
use crate::geometry::Aabb;
use crate::query::Part;
use alloc::vec::Vec;

impl Instances {
    /// The parts of an instance's part, in boxes of the world; none where its object's structure has none, or there is no proof for their boxes.
    pub(super) fn parts_of(&self, i: usize, of: Part) -> Vec<(Aabb, Part)> {
        let placement = &self.placements[i];
        let object = &self.objects[placement.object as usize];
        let structure = object.structure();
        let mut parts = Vec::new();
        structure.parts(of, &mut |bounds, part| parts.push((bounds, part)));
        let mut boxes = Vec::new();
        for (bounds, part) in &mut parts {
            boxes.clear();
            structure.parts(*part, &mut |within, _| boxes.push(within));
            if boxes.is_empty() {
                boxes.push(*bounds);
            }
            let transform = &self.transforms[i];
            match placement.part_bounds(transform, object, &boxes, self.scale) {
                Some(placed) => *bounds = placed,
                None => return Vec::new(),
            }
        }
        // In what has no box there is nothing to hit.
        parts.retain(|(bounds, _)| !bounds.is_empty());
        parts
    }
}
