//! The cells as questions about space see them.

use super::KdTree;
use super::inspect::halves;
use crate::geometry::{Aabb, Vec3};
use crate::primitive::Triangles;
use crate::proximity::{Hierarchy, Numbered, Opened};

/// Above the cells stands one more node, because some primitives may lie in none of them.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// Cells and what lies in none.
    Everything,
    /// What lies in none.
    Everywhere,
    /// A node, and where it lies.
    Cell(u32, Aabb),
}

impl<P: Triangles> Hierarchy for KdTree<P> {
    type Primitives = P;
    type Node = Place;
    fn primitives(&self) -> &P {
        &self.primitives
    }
    fn root(&self) -> Option<Place> {
        (self.partition.primitives > 0).then_some(Place::Everything)
    }
    fn open(
        &self,
        node: Place,
    ) -> Opened<impl Iterator<Item = (Aabb, Place)>, impl Iterator<Item = Numbered>> {
        let partition = &self.partition;
        let space = &partition.space;
        let inner =
            |children: [Option<(Aabb, Place)>; 2]| Opened::Inner(children.into_iter().flatten());
        let triangle = move |&id: &u32| (id, self.primitives.triangle(id as usize));
        let (index, bounds) = match node {
            Place::Cell(index, bounds) => (index, bounds),
            Place::Everywhere => return Opened::Leaf(space.everywhere.iter().map(triangle)),
            Place::Everything => {
                let all = Vec3::splat(f32::INFINITY);
                let cells = (space.world, Place::Cell(0, space.world));
                let others = (Aabb::new(-all, all), Place::Everywhere);
                return inner([
                    (!partition.nodes.is_empty()).then_some(cells),
                    (!space.everywhere.is_empty()).then_some(others),
                ]);
            }
        };
        let node = partition.nodes[index as usize];
        if node.is_leaf() {
            return Opened::Leaf(partition.references[node.places()].iter().map(triangle));
        }
        let [below, above] = halves(&bounds, node.axis(), node.plane());
        let child = node.child() as u32;
        inner([
            Some((below, Place::Cell(child, below))),
            Some((above, Place::Cell(child + 1, above))),
        ])
    }
    fn number(&self, node: Place) -> usize {
        match node {
            Place::Everything => 0,
            Place::Everywhere => 1,
            Place::Cell(index, _) => index as usize + 2,
        }
    }
    /// A leaf names whatever reaches into its cell when that is padded: twice covers what was rounded since.
    fn slack(&self) -> f64 {
        // Cells name a primitive more than once, even where no padding is left.
        (2.0 * f64::from(self.partition.space.pad())).max(f64::MIN_POSITIVE)
    }
}
