//! Building a tree over a mesh that moves: one tree, fitted to each key.

use super::super::node::{Child, Node};
use super::super::refit::Fitting;
use super::super::{WideBvh, WideSah};
use super::{Key, MIDDLE, MotionBvh};
use crate::accel::BuildError;
use crate::accel::limits::{Limits, Site, unlimited};
use crate::geometry::frame::Frame;
use crate::geometry::{Aabb, Vec3};
use crate::primitive::{self, MovingMesh, Pose};
use crate::simd::{Level, Vectorize, exactly};
use alloc::vec::Vec;
use core::borrow::Borrow;
use core::ops::ControlFlow::Continue;

/// Where there is no child, so that what is mixed of it at two keys is the same again: infinite sides would become NaN. No tame ray enters it.
const NOWHERE: Aabb = Aabb {
    lower: Vec3::splat(f32::MAX),
    upper: Vec3::splat(f32::MIN),
};

impl<const N: usize> WideSah<N>
where
    Level: Vectorize<N>,
{
    /// Builds a tree over a mesh that moves. [`WideSah::precision`] is not asked: it is always exact.
    ///
    /// # Panics
    /// When there are more than a quarter of a billion triangles.
    pub fn build_moving<M: Borrow<MovingMesh>>(&self, mesh: M) -> MotionBvh<M, N> {
        unlimited(self.build_moving_within(mesh, &Limits::NONE))
    }

    /// The same within limits.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_moving_within<M: Borrow<MovingMesh>>(
        &self,
        mesh: M,
        limits: &Limits<'_>,
    ) -> Result<MotionBvh<M, N>, BuildError> {
        let moving = mesh.borrow();
        // A fitting takes about a tenth of a build.
        let built = 10.0 / (10 + moving.keys()) as f32;
        let watch = |share: f32| limits.watch.map_or(Continue(()), |watch| watch(share));
        let building = Limits {
            watch: Some(&|share| watch(built * share)),
            ..*limits
        };
        let fitting = Limits {
            watch: Some(&|share| watch(built + (1.0 - built) * share)),
            ..*limits
        };
        let middle = self.build_within(moving.at(MIDDLE), &building)?;
        let bounds = exactly(|| primitive::bounds_of(moving));
        // Only from the middle of all of the way are all differences exact.
        let frame = exactly(|| Frame::of(&bounds).in_motion());
        let root = middle.root;
        let keys = exactly(|| fit_to_keys(middle, moving, &frame, &fitting))?;
        Ok(MotionBvh {
            bounds,
            frame,
            root,
            keys,
            isa: self.isa,
            mesh,
        })
    }
}

/// The tree at each key.
fn fit_to_keys<'a, const N: usize>(
    mut tree: WideBvh<Pose<'a>, N>,
    mesh: &'a MovingMesh,
    frame: &Frame,
    limits: &Limits<'_>,
) -> Result<Vec<Key<N>>, BuildError>
where
    Level: Vectorize<N>,
{
    let site = Site::new(limits, mesh.keys());
    let (nodes, blocks) = (tree.nodes.len(), tree.leaves.len());
    let one = size_of_val(&*tree.nodes) + size_of_val(tree.leaves.words());
    let meanwhile = Fitting::bytes(nodes, blocks);
    let mut keys = Vec::new();
    if !site.take(meanwhile.saturating_add(one.saturating_mul(mesh.keys()))) {
        return site.finish(keys);
    }
    let mut found = Fitting::default();
    let mut fit = |tree: &mut WideBvh<Pose<'a>, N>, key| {
        tree.change(|pose| *pose = Pose::at_key(mesh, key));
        tree.follow(&mut found, |_| *frame);
        tree.nodes.iter_mut().for_each(close);
        site.advance(1)
    };
    let last = mesh.keys() - 1;
    for key in 0..last {
        if !fit(&mut tree, key) {
            return site.finish(keys);
        }
        keys.push(Key {
            nodes: tree.nodes.clone(),
            leaves: tree.leaves.clone(),
        });
    }
    fit(&mut tree, last);
    keys.push(Key {
        nodes: tree.nodes,
        leaves: tree.leaves,
    });
    site.finish(keys)
}

/// Puts [`NOWHERE`] where there is no child.
fn close<const N: usize>(node: &mut Node<N>) {
    for lane in 0..N {
        if node.child(lane) == Child::NOTHING {
            node.set_bounds(lane, &NOWHERE);
        }
    }
}
