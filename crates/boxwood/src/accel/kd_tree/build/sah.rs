//! Cuts where the surface-area heuristic is lowest, cutting off empty space with a bonus.
//!
//! *How it works.* A ray that meets a cell meets a half of it with the probability of the ratio of their areas; so a plane costs a
//! step and, weighted with these, the tests of both halves. That sum is a straight line between any two places where a primitive's
//! part begins or ends, hence least at such a place, and a [`sweep`](super::sweep) over all of them on each axis finds the least. A plane that cuts
//! off empty space is rebated. A cell is a leaf when no plane is cheaper than testing its primitives.
//! Cells of very many primitives are first counted into bins, and swept only around the best border
//! ([`bins`](super::bins)).
//!
//! *Cost.* O(n log n): in a large cell two bins per item and axis, in a small one a sort of at most a constant size.
//!
//! *Source.* MacDonald & Booth 1990; Wald & Havran 2006 (sweep, perfect splits, bonus); Hunt, Mark & Stoll 2006, Popov et al.
//! 2006 (bins, then exact in between).

use super::super::node::{MAX_DEPTH, Partition};
use super::bins::Bins;
use super::sweep::{Best, Events, Surface};
use super::{Caps, Cell, Cut, Depth, Rule, kd_builder, lecture};
use crate::accel::settings::Setting;
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;
use alloc::vec::Vec;

/// The builder by surface area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdSah {
    /// A cell of so few primitives is a leaf, 1 to 64. Larger leaves are made where cutting does not pay.
    pub max_leaf: usize,
    /// What share of its cost a plane is spared that cuts off empty space, 0 to 0.9.
    pub empty: f32,
    /// No cell lies deeper, 0 to [`MAX_DEPTH`]; `None` is 8 + 1.3 log₂ n.
    pub max_depth: Option<usize>,
    /// The most references and leaves per primitive, 1 to 64.
    pub budget: f32,
    /// The axes that may be divided.
    pub axes: Axes,
}

impl Default for KdSah {
    fn default() -> Self {
        Self {
            max_leaf: 1,
            empty: 0.2,
            max_depth: None,
            budget: 8.0,
            axes: Axes::XYZ,
        }
    }
}

/// What crossing a plane costs, in units of one primitive test. Measured: trees for cheaper planes have twice the nodes, and
/// what they save in tests they lose in memory.
const PLANE_COST: f64 = 1.5;
/// Cells of more primitives are counted into bins first.
const SWEEP_MOST: usize = 1 << 14;
/// How many primitives a leaf may hold at the end of the depth, where halving can still see to it.
const CROWD: usize = 8;

impl KdSah {
    fn caps(&self) -> Caps {
        Caps {
            leaf: self.max_leaf.max(1),
            depth: self.max_depth.map(|depth| depth.min(MAX_DEPTH)),
            budget: self.budget,
        }
    }
}

#[derive(Default)]
pub(super) struct Scratch {
    events: Events,
    middles: Vec<f32>,
}

impl Rule for KdSah {
    type Scratch = Scratch;

    fn cut(&self, cell: &Cell<'_>, scratch: &mut Scratch) -> Option<Cut> {
        let n = cell.items.len();
        // The heuristic may peel primitives off one by one until the depth is used up: halve while there is time.
        if n >> cell.levels.min(MAX_DEPTH - 1) > CROWD {
            let axis = self.axes.longest(cell.bounds.size());
            if let Some(cut) = lecture::halve(cell, axis, &mut scratch.middles) {
                return Some(cut);
            }
        }
        let surface = Surface::of(&cell.bounds, PLANE_COST, self.empty)?;
        // No plane is better than one whose cost is that of a leaf.
        let mut best = Best::at_most(n as f64);
        if n > SWEEP_MOST {
            let bins = Bins::of(cell.items, &cell.bounds);
            if let Some((axis, around)) = bins.least(n, self.axes, &surface) {
                scratch.events.gather(cell.items, axis, around);
                scratch.events.sweep(n, axis, &surface, &mut best);
            }
        } else {
            for axis in self.axes.iter() {
                let all = (cell.bounds.lower[axis], cell.bounds.upper[axis]);
                scratch.events.gather(cell.items, axis, all);
                scratch.events.sweep(n, axis, &surface, &mut best);
            }
        }
        best.cut
    }
}

kd_builder!(KdSah, "kd:sah", |builder| [
    Setting::count("leaf", &mut builder.max_leaf, 1..=64),
    Setting::real("empty", &mut builder.empty, 0.0..=0.9),
    Setting::new("depth", Depth(&mut builder.max_depth)),
    Setting::real("budget", &mut builder.budget, 1.0..=64.0),
    Setting::axes(&mut builder.axes),
]);
