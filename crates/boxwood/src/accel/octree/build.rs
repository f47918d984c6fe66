//! The settings of an octree, and how its building begins.

use super::divide::{Cell, Item, Part, Work, leaf_bytes};
use super::node::{Node, OctreeData, Place};
use super::{MAX_DEPTH, Octree};
use crate::accel::cells::Space;
use crate::accel::limits::{Site, unlimited};
use crate::accel::settings::{Setting, Settings};
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;
use crate::query::Intersect;
use crate::simd::exactly;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// The builder of [`Octree`].
///
/// *Budget.* Nodes and references take at most 96 bytes per primitive (and 4 KiB), or a quarter of what
/// [`Limits::memory`] allows, if that is less: cells that would exceed their share stay whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OctreeBuilder {
    /// A cell with so many primitives or fewer is not divided, 1 to 64.
    pub leaf: usize,
    /// No cell lies deeper, 0 to [`MAX_DEPTH`].
    pub depth: usize,
    /// The axes that are divided.
    pub axes: Axes,
}

impl Default for OctreeBuilder {
    fn default() -> Self {
        Self {
            leaf: 12,
            depth: 20,
            axes: Axes::XYZ,
        }
    }
}

/// Bytes of nodes and references for each primitive, at most.
const BUDGET_EACH: usize = 96;
/// And for the whole.
const BUDGET_BASE: usize = 4096;
/// The units of work of a whole build, for those who watch: divided among the cells by their primitives.
const WORK: usize = 1 << 30;
/// Those of looking where the primitives lie.
const LOOKING: usize = WORK / 32;
/// So that places have 32 bits.
const MOST_BYTES: usize = if usize::BITS > 32 {
    4 * (u32::MAX as usize)
} else {
    usize::MAX / 8
};

impl OctreeBuilder {
    /// Builds an octree; it cannot fail.
    pub fn build(&self, primitives: &(impl Primitives + Sync)) -> OctreeData {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Builds an octree within limits. Little memory makes it shallower.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within<P: Primitives + Sync>(
        &self,
        primitives: &P,
        limits: &Limits<'_>,
    ) -> Result<OctreeData, BuildError> {
        exactly(|| self.tree(primitives, limits))
    }

    fn tree<P: Primitives + Sync>(
        &self,
        primitives: &P,
        limits: &Limits<'_>,
    ) -> Result<OctreeData, BuildError> {
        let site = Site::new(limits, WORK);
        let space = Space::within(primitives, &site, LOOKING);
        let mut data = OctreeData {
            root: Place::root(&space.world, self.axes),
            space,
            nodes: Vec::new(),
            references: Vec::new(),
            primitives: primitives.len(),
        };
        let n = primitives.len();
        if data.space.world.is_empty()
            || site.is_over()
            || !site.take(size_of::<Item>().saturating_mul(n))
        {
            return site.finish(data);
        }
        let mut items = Vec::with_capacity(n);
        for i in 0..n {
            let bounds = primitives.bounds(i);
            if !bounds.is_empty() && bounds.lower.is_finite() && bounds.upper.is_finite() {
                let id = i as u32;
                items.push(Item { bounds, id });
            }
        }
        let most = (BUDGET_EACH.saturating_mul(n) + BUDGET_BASE).min(MOST_BYTES);
        let budget = most.min(site.room() / 4).max(leaf_bytes(items.len()));
        let work = Work {
            primitives,
            space: &data.space,
            site: &site,
            axes: self.axes,
            leaf: self.leaf.clamp(1, 64),
            depth: self.depth.min(MAX_DEPTH),
            // Where memory is short, one thread after another, so that what is refused does not depend on them.
            #[cfg(feature = "parallel")]
            parallel: limits.memory.is_none() || site.room() / 8 > most,
        };
        let cell = Cell {
            place: data.root,
            // The root may reach beyond the world; nothing else does.
            bounds: data.root.bounds(&data.space.world).union(data.space.world),
            depth: 0,
            budget,
            units: WORK - LOOKING,
        };
        let mut part = Part::default();
        if site.reserve(&mut part.nodes, 1) {
            part.nodes.push(Node::leaf(0, 0));
            work.divide(&mut items, 0, &cell, 0, &mut part);
        }
        if !site.is_over() {
            part.nodes.shrink_to_fit();
            part.references.shrink_to_fit();
        }
        (data.nodes, data.references) = (part.nodes, part.references);
        site.finish(data)
    }
}

impl Settings for OctreeBuilder {
    const NAME: &'static str = "octree";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        alloc::vec![
            Setting::count("leaf", &mut self.leaf, 1..=64),
            Setting::count("depth", &mut self.depth, 0..=MAX_DEPTH),
            Setting::axes(&mut self.axes),
        ]
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        let data = self.build_within(&primitives, limits)?;
        Ok(Box::new(Octree::new(primitives, data)))
    }
}
