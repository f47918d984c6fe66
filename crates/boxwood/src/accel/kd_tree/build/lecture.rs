//! The lecture's builder: axes in turn or the longest one, the plane in the middle or at the median.
//!
//! *How it works.* Until few primitives are left or the depth is reached, a cell is cut in the middle of its axis, or
//! where half of its primitives have their middles on each side. Nothing is weighed.
//!
//! *Cost.* O(n log n) references looked at, plus those that the cuts make.
//!
//! *Source.* Kaplan 1985 (axis in turn); Bentley 1975 (median).

use super::super::node::{MAX_DEPTH, Partition};
use super::{Caps, Cell, Cut, Depth, Rule, kd_builder};
use crate::accel::settings::{Setting, Value};
use crate::accel::{Axes, BuildError, Limits};
use crate::primitive::Primitives;
use alloc::string::String;
use alloc::vec::Vec;

/// Which axis a cell is cut across.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AxisRule {
    /// x, y, z, x, … by depth.
    #[default]
    Turn,
    /// The cell's longest.
    Longest,
}

/// Where on its axis a cell is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlaneRule {
    /// In the middle of the cell.
    #[default]
    Middle,
    /// At the median of the middles of its primitives' parts.
    Median,
}

/// The lecture's builder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdLecture {
    /// Which axis a cell is cut across.
    pub axis: AxisRule,
    /// Where it is cut.
    pub split: PlaneRule,
    /// A cell of so few primitives is a leaf, 1 to 64.
    pub max_leaf: usize,
    /// No cell lies deeper, 0 to [`MAX_DEPTH`]; `None` is 8 + 1.3 log₂ n.
    pub max_depth: Option<usize>,
    /// The most references and leaves per primitive, 1 to 64.
    pub budget: f32,
    /// The axes that may be divided.
    pub axes: Axes,
}

impl Default for KdLecture {
    fn default() -> Self {
        Self {
            axis: AxisRule::Turn,
            split: PlaneRule::Middle,
            max_leaf: 5,
            max_depth: None,
            budget: 16.0,
            axes: Axes::XYZ,
        }
    }
}

impl KdLecture {
    fn caps(&self) -> Caps {
        Caps {
            leaf: self.max_leaf.max(1),
            depth: self.max_depth.map(|depth| depth.min(MAX_DEPTH)),
            budget: self.budget,
        }
    }

    /// Where the cell is cut across one axis.
    fn plane(&self, cell: &Cell<'_>, axis: usize, middles: &mut Vec<f32>) -> Option<Cut> {
        match self.split {
            PlaneRule::Middle => {
                let (lower, upper) = (cell.bounds.lower[axis], cell.bounds.upper[axis]);
                inside(cell, axis, 0.5 * lower + 0.5 * upper)
            }
            PlaneRule::Median => halve(cell, axis, middles),
        }
    }
}

/// A cut at a plane that is strictly inside the cell.
fn inside(cell: &Cell<'_>, axis: usize, plane: f32) -> Option<Cut> {
    let is_inside = cell.bounds.lower[axis] < plane && plane < cell.bounds.upper[axis];
    is_inside.then_some(Cut {
        axis,
        plane,
        flat_below: true,
    })
}

/// The cut at the median of the middles of the primitives' parts.
pub(super) fn halve(cell: &Cell<'_>, axis: usize, middles: &mut Vec<f32>) -> Option<Cut> {
    middles.clear();
    middles.extend(cell.items.iter().map(|item| item.bounds.centroid()[axis]));
    if middles.is_empty() {
        return None;
    }
    let half = middles.len() / 2;
    let (_, median, _) = middles.select_nth_unstable_by(half, f32::total_cmp);
    inside(cell, axis, *median)
}

impl Rule for KdLecture {
    type Scratch = Vec<f32>;

    /// The first axis, from the one whose turn it is on, that can be cut at all.
    fn cut(&self, cell: &Cell<'_>, scratch: &mut Vec<f32>) -> Option<Cut> {
        let first = match self.axis {
            AxisRule::Turn => {
                let turn = cell.depth % self.axes.count();
                self.axes.iter().nth(turn).unwrap_or(0)
            }
            AxisRule::Longest => self.axes.longest(cell.bounds.size()),
        };
        (first..first + 3)
            .map(|axis| axis % 3)
            .filter(|&axis| self.axes.has(axis))
            .find_map(|axis| self.plane(cell, axis, scratch))
    }
}

/// One of a few words.
struct Word<'a, T: 'static>(&'a mut T, &'static [(&'static str, T)]);

impl<T: Copy + PartialEq> Value for Word<'_, T> {
    fn read(&mut self, text: &str) -> bool {
        let found = self.1.iter().find(|(word, _)| *word == text);
        found.map(|(_, value)| *self.0 = *value).is_some()
    }
    fn write(&self) -> String {
        let found = self.1.iter().find(|(_, value)| *value == *self.0);
        found.map_or("", |(word, _)| word).into()
    }
    fn expected(&self) -> String {
        let words: Vec<&str> = self.1.iter().map(|(word, _)| *word).collect();
        words.join("|")
    }
}

const AXIS_RULES: &[(&str, AxisRule)] = &[("turn", AxisRule::Turn), ("longest", AxisRule::Longest)];
const PLANE_RULES: &[(&str, PlaneRule)] =
    &[("middle", PlaneRule::Middle), ("median", PlaneRule::Median)];

kd_builder!(KdLecture, "kd:lecture", |builder| [
    Setting::new("axis", Word(&mut builder.axis, AXIS_RULES)),
    Setting::new("split", Word(&mut builder.split, PLANE_RULES)),
    Setting::count("leaf", &mut builder.max_leaf, 1..=64),
    Setting::new("depth", Depth(&mut builder.max_depth)),
    Setting::real("budget", &mut builder.budget, 1.0..=64.0),
    Setting::axes(&mut builder.axes),
]);
