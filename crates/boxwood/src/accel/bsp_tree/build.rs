//! Cutting cells by the cheapest planes, within a budget of references.
//!
//! *How it works.* From the top down. Large cells are boxes and their primitives are boxes too, cut again by every cell;
//! from a few hundred primitives on, the parts of triangles are kept as polygons and the cells as polyhedra, and slanted
//! planes come in. Halves are built side by side. The budget is divided among the halves by their primitives, so
//! that the tree does not depend on who builds what when.

use super::fragment::{Fragments, side_across};
use super::node::{BspData, MOST_IN_LEAF, Node, Plane, Shape, Slanted, halves};
use super::search::{self, Cut};
use super::{BspTree, MAX_DEPTH};
use crate::accel::cells::Space;
use crate::accel::limits::{Site, unlimited};
use crate::accel::settings::{Setting, Settings};
use crate::accel::{Axes, BuildError, Limits};
use crate::geometry::Aabb;
use crate::primitive::Primitives;
use crate::query::Intersect;
use crate::simd::exactly;
#[cfg(feature = "parallel")]
use crate::threads;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// The builder of [`BspTree`]: the surface-area heuristic over planes in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BspSah {
    /// A cell with so many primitives or fewer is not divided, 1 to 64.
    pub leaf: usize,
    /// No cell lies deeper, 0 to [`MAX_DEPTH`].
    pub depth: usize,
    /// The most primitives for which slanted planes are tried: above, all planes run across an axis, and
    /// [`BspData::is_slanted`] says so. 0 makes a kd-tree.
    pub limit: usize,
    /// The most references and nodes together for each primitive, 3 to 64. Cells that would exceed their share stay whole, and
    /// where [`Limits::memory`] is short, so does what exceeds that.
    pub budget: f32,
    /// The axes that are divided; with one of them off, no plane leans along it.
    pub axes: Axes,
}

impl Default for BspSah {
    fn default() -> Self {
        Self {
            leaf: 1,
            depth: 56,
            limit: 500_000,
            budget: 16.0,
            axes: Axes::XYZ,
        }
    }
}

/// Cells with so many primitives or fewer try slanted planes, and every plane where one begins or ends.
const EXACT: usize = 128;
/// The units of work of a whole build, for those who watch: divided among the cells by their primitives.
const WORK: usize = 1 << 30;
/// What a reference or node takes while it is worked on and afterwards, about: what the budget is cut down by.
const BYTES_EACH: usize = 64;
/// Halves with fewer primitives are built one after the other.
#[cfg(feature = "parallel")]
const SEQUENTIAL: usize = 256;

impl BspSah {
    /// Builds a tree; it cannot fail.
    pub fn build(&self, primitives: &(impl Primitives + Sync)) -> BspData {
        unlimited(self.build_within(primitives, &Limits::NONE))
    }

    /// Builds a tree within limits. Little memory makes it shallower.
    ///
    /// # Errors
    /// When the limits end the build.
    pub fn build_within<P: Primitives + Sync>(
        &self,
        primitives: &P,
        limits: &Limits<'_>,
    ) -> Result<BspData, BuildError> {
        exactly(|| self.tree(primitives, limits))
    }

    fn tree<P: Primitives + Sync>(
        &self,
        primitives: &P,
        limits: &Limits<'_>,
    ) -> Result<BspData, BuildError> {
        let site = Site::new(limits, WORK);
        let space = Space::of(primitives);
        let n = primitives.len();
        let mut data = BspData {
            slanted: space.is_exact::<P>() && n <= self.limit,
            space,
            nodes: Vec::new(),
            planes: Vec::new(),
            references: Vec::new(),
            primitives: n,
        };
        let mut pieces = Vec::new();
        if data.space.world.is_empty() || !site.reserve(&mut pieces, n) {
            return site.finish(data);
        }
        for i in 0..n {
            let bounds = primitives.bounds(i);
            if !bounds.is_empty() && bounds.lower.is_finite() && bounds.upper.is_finite() {
                let id = i as u32;
                pieces.push(Piece { bounds, id });
            }
        }
        let budget = (f64::from(self.budget.clamp(3.0, 64.0)) * n as f64) as usize + 64;
        let most = budget.min(site.room() / BYTES_EACH).min(MOST_IN_LEAF);
        let work = Work {
            primitives,
            space: &data.space,
            site: &site,
            axes: self.axes,
            leaf: self.leaf.clamp(1, 64),
            depth: self.depth.min(MAX_DEPTH),
            slanted: data.slanted,
            #[cfg(feature = "parallel")]
            parallel: limits.memory.is_none() || most == budget,
        };
        let cell = Place {
            depth: 0,
            budget: most.max(leaf_units(pieces.len())),
            units: WORK,
        };
        let part = work.pieces(pieces, data.space.world, &cell);
        (data.nodes, data.planes, data.references) = (part.nodes, part.planes, part.references);
        site.finish(data)
    }
}

/// What a leaf takes of the budget.
fn leaf_units(references: usize) -> usize {
    references + 1
}

/// A primitive of a large cell.
#[derive(Clone, Copy)]
struct Piece {
    bounds: Aabb,
    id: u32,
}

/// What a cell may take.
#[derive(Clone, Copy)]
struct Place {
    depth: usize,
    /// References and nodes below, this node included.
    budget: usize,
    units: usize,
}

impl Place {
    /// Those of the halves with so many primitives; `None` when the budget does not allow them.
    fn halves(&self, counts: [usize; 2]) -> Option<[Self; 2]> {
        let needed = counts.map(leaf_units);
        let spare = self.budget.checked_sub(needed[0] + needed[1] + 1)?;
        let total = (counts[0] + counts[1]).max(1) as f64;
        let half = |k: usize| {
            let share = counts[k] as f64 / total;
            Self {
                depth: self.depth + 1,
                budget: needed[k] + (spare as f64 * share) as usize,
                // The rest is this cell's own work.
                units: (self.units as f64 * 0.9 * share) as usize,
            }
        };
        Some([half(0), half(1)])
    }
}

/// A finished part of the tree: its root first, numbers and places counting from its own beginning.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    planes: Vec<Slanted>,
    references: Vec<u32>,
}

/// What all parts of one build share.
struct Work<'a, P> {
    primitives: &'a P,
    space: &'a Space,
    site: &'a Site<'a>,
    axes: Axes,
    leaf: usize,
    depth: usize,
    slanted: bool,
    #[cfg(feature = "parallel")]
    parallel: bool,
}

impl<P: Primitives + Sync> Work<'_, P> {
    /// The tree of what lies in a box.
    fn pieces(&self, pieces: Vec<Piece>, cell: Aabb, place: &Place) -> Part {
        if pieces.len() <= EXACT {
            let mut fragments = Fragments::default();
            for piece in &pieces {
                fragments.add(self.primitives, piece.id, piece.bounds, &cell, self.space);
            }
            self.site.release(pieces);
            let shape = Shape::Box(cell);
            let shape = if self.slanted {
                shape.with_sides()
            } else {
                shape
            };
            let mut part = Part::default();
            if !self.site.reserve(&mut part.nodes, 1) {
                return part;
            }
            part.nodes.push(Node::leaf(0, 0));
            self.fragments(&fragments, &shape, place, 0, &mut part);
            return part;
        }
        let (count, pad) = (pieces.len(), self.space.pad());
        let cut = self.may_divide(count, place).then(|| {
            let bounds = pieces.iter().map(|piece| piece.bounds);
            search::binned(bounds, count, &cell, self.axes, pad)
        });
        self.site.advance(place.units / 20);
        let Some(Some(Cut {
            plane: Plane::Across(axis, at),
            flat_below,
            ..
        })) = cut
        else {
            return self.large_leaf(pieces, place);
        };
        let cells = halves(&cell, axis, at);
        let mut parts = [Vec::new(), Vec::new()];
        for piece in &pieces {
            let side = side_across(&piece.bounds, axis, at, pad);
            let flat = !side.below && !side.above;
            let goes = [
                side.below || flat && flat_below,
                side.above || flat && !flat_below,
            ];
            for k in 0..2 {
                if !goes[k] {
                    continue;
                }
                let mut piece = *piece;
                if goes[1 - k] {
                    let id = piece.id as usize;
                    let inside = self.space.part(self.primitives, id, &cells[k]);
                    piece.bounds = piece.bounds.intersection(inside);
                    if piece.bounds.is_empty() {
                        continue;
                    }
                }
                if !self.site.reserve(&mut parts[k], 1) {
                    return Part::default();
                }
                parts[k].push(piece);
            }
        }
        let counts = [parts[0].len(), parts[1].len()];
        let Some(places) = place.halves(counts).filter(|_| counts != [count; 2]) else {
            for part in parts {
                self.site.release(part);
            }
            return self.large_leaf(pieces, place);
        };
        self.site.release(pieces);
        self.site.advance(place.units / 20);
        let [below, above] = parts;
        let build = [(below, 0), (above, 1)].map(|(pieces, k)| {
            let (cell, place) = (cells[k], places[k]);
            move || self.pieces(pieces, cell, &place)
        });
        let [below, above] = self.both(count, build);
        self.join(Plane::Across(axis, at), below, above)
    }

    fn large_leaf(&self, pieces: Vec<Piece>, place: &Place) -> Part {
        let mut part = Part::default();
        if self.site.reserve(&mut part.references, pieces.len())
            && self.site.reserve(&mut part.nodes, 1)
        {
            part.references.extend(pieces.iter().map(|piece| piece.id));
            part.nodes.push(Node::leaf(0, pieces.len() as u32));
        }
        self.site.release(pieces);
        self.site.advance(place.units);
        part
    }

    /// Makes the tree of what lies in a cell of any shape, and names it node `root`.
    fn fragments(
        &self,
        fragments: &Fragments,
        shape: &Shape,
        place: &Place,
        root: usize,
        part: &mut Part,
    ) {
        let (count, pad) = (fragments.list.len(), self.space.pad());
        let divided = self.may_divide(count, place).then(|| {
            let (axes, slanted) = (self.axes, self.slanted);
            let cut = search::exact(self.primitives, fragments, shape, axes, pad, slanted)?;
            let mut parts = [Fragments::default(), Fragments::default()];
            for fragment in &fragments.list {
                let side = fragments.side(fragment, &cut.plane, pad);
                let flat = !side.below && !side.above;
                match (
                    side.below || flat && cut.flat_below,
                    side.above || flat && !cut.flat_below,
                ) {
                    (true, true) => {
                        parts[0].add_part(fragments, fragment, &cut.plane, 1.0);
                        parts[1].add_part(fragments, fragment, &cut.plane, -1.0);
                    }
                    (true, false) => parts[0].add_whole(fragments, fragment),
                    (false, _) => parts[1].add_whole(fragments, fragment),
                }
            }
            let counts = [parts[0].list.len(), parts[1].list.len()];
            let places = place.halves(counts).filter(|_| counts != [count; 2])?;
            Some((cut.plane, parts, places))
        });
        let Some((plane, parts, places)) = divided.flatten() else {
            if self.site.reserve(&mut part.references, count) {
                part.nodes[root] = Node::leaf(part.references.len() as u32, count as u32);
                let ids = fragments.list.iter().map(|fragment| fragment.id);
                part.references.extend(ids);
            }
            self.site.advance(place.units);
            return;
        };
        let first = part.nodes.len();
        if !self.site.reserve(&mut part.nodes, 2) || !self.site.reserve(&mut part.planes, 1) {
            return;
        }
        part.nodes.extend([Node::leaf(0, 0); 2]);
        part.nodes[root] = inner(plane, first, &mut part.planes);
        self.site.advance(place.units / 10);
        let shapes = shape.cut(&plane);
        for k in 0..2 {
            self.fragments(&parts[k], &shapes[k], &places[k], first + k, part);
            if self.site.is_over() {
                return;
            }
        }
    }

    fn may_divide(&self, count: usize, place: &Place) -> bool {
        count > self.leaf && place.depth < self.depth && !self.site.is_over()
    }

    /// Both halves, at once where that pays.
    fn both(&self, count: usize, [below, above]: [impl FnOnce() -> Part + Send; 2]) -> [Part; 2] {
        #[cfg(feature = "parallel")]
        if self.parallel && count > SEQUENTIAL {
            return threads::join(below, above).into();
        }
        let _ = count;
        [below(), above()]
    }

    /// A node over two finished parts: both roots, then what is below the one and the other.
    fn join(&self, plane: Plane, below: Part, above: Part) -> Part {
        let mut part = Part::default();
        let halves = [below, above];
        let sum = |length: fn(&Part) -> usize| length(&halves[0]) + length(&halves[1]) + 1;
        let fits = self.site.reserve(&mut part.nodes, sum(|p| p.nodes.len()))
            && self.site.reserve(&mut part.planes, sum(|p| p.planes.len()))
            && self
                .site
                .reserve(&mut part.references, sum(|p| p.references.len()));
        if self.site.is_over() || !fits {
            return Part::default();
        }
        part.nodes.push(inner(plane, 1, &mut part.planes));
        let (planes, references) = (part.planes.len(), halves[0].references.len());
        // The first half's node 1 becomes node 3, the second half's node 1 comes behind the first half.
        let moves = [
            (2, planes, 0),
            (
                1 + halves[0].nodes.len(),
                planes + halves[0].planes.len(),
                references,
            ),
        ];
        let moves = moves.map(|(n, p, r)| (n as u32, p as u32, r as u32));
        for (half, (n, p, r)) in halves.iter().zip(moves) {
            part.nodes.push(half.nodes[0].moved(n, p, r));
        }
        for (half, (n, p, r)) in halves.into_iter().zip(moves) {
            part.nodes
                .extend(half.nodes[1..].iter().map(|node| node.moved(n, p, r)));
            part.planes.extend_from_slice(&half.planes);
            part.references.extend_from_slice(&half.references);
            self.site.release(half.nodes);
            self.site.release(half.planes);
            self.site.release(half.references);
        }
        part
    }
}

/// An inner node, its slanted plane put into the list.
fn inner(plane: Plane, first: usize, planes: &mut Vec<Slanted>) -> Node {
    match plane {
        Plane::Across(axis, at) => Node::axis(first as u32, axis, at),
        Plane::Slanted(plane) => {
            planes.push(plane);
            Node::slanted(first as u32, planes.len() as u32 - 1)
        }
    }
}

impl Settings for BspSah {
    const NAME: &'static str = "bsp";
    fn settings(&mut self) -> Vec<Setting<'_>> {
        alloc::vec![
            Setting::count("leaf", &mut self.leaf, 1..=64),
            Setting::count("depth", &mut self.depth, 0..=MAX_DEPTH),
            Setting::count("limit", &mut self.limit, 0..=usize::MAX),
            Setting::real("budget", &mut self.budget, 3.0..=64.0),
            Setting::axes(&mut self.axes),
        ]
    }
    fn structure<'a, P: Primitives + Send + Sync + 'a>(
        &self,
        primitives: P,
        limits: &Limits<'_>,
    ) -> Result<Box<dyn Intersect + 'a>, BuildError> {
        let data = self.build_within(&primitives, limits)?;
        Ok(Box::new(BspTree::new(primitives, data)))
    }
}
