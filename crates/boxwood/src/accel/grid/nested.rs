//! Cells in blocks: what the two grids have in common, and the loop through it.
//!
//! *How it works.* The world is a lattice of blocks, and each block that holds anything is a lattice of cells. A ray walks
//! from block to block ([`Way`]), and through the cells of those that are not empty. After a cell with primitives it
//! stops where nothing beyond can be nearer. No primitive is tested twice as long as the mailbox remembers it.

use super::counted::Counted;
use super::lattice::Lattice;
use super::walk::{MOST_SCALES, Way};
use crate::accel::cells::{Mailbox, Space};
use crate::accel::sah::half_area;
use crate::accel::sah::{NODE_COST, PRIMITIVE_COST};
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{Cell, Statistics};
use crate::primitive::Primitives;
use crate::query::{Counters, Query, Step, Verdict};

/// What a grid keeps of its blocks.
pub(crate) trait Blocks {
    /// How many cells of the lattice make a block.
    fn edge(&self) -> [u32; 3];
    /// Whether nothing lies in a block.
    fn is_empty(&self, number: usize, cells: &Counted) -> bool;
    /// The cells of a block; none in an empty one, if need be.
    fn block(&self, number: usize) -> Block;
    /// Bytes of its arrays.
    fn bytes(&self) -> usize;
}

/// A block of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    /// The number of its first cell.
    pub first: u32,
    /// How many cells it has.
    pub parts: [u32; 3],
    /// From one cell to the next.
    pub strides: [i32; 3],
}

impl Block {
    /// The number of a cell.
    pub fn cell(&self, [x, y, z]: [u32; 3]) -> usize {
        let [sx, sy, sz] = self.strides.map(|s| s as u32);
        (self.first + x * sx + y * sy + z * sz) as usize
    }
    /// The place of the cell with a number.
    fn place(&self, cell: usize) -> [u32; 3] {
        let [_, sy, sz] = self.strides.map(|s| s as u32);
        let at = cell as u32 - self.first;
        [at % sy, at % sz / sy, at / sz]
    }
}

/// Blocks of cells, and what lies in them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Nested<B> {
    pub space: Space,
    /// How many primitives it was built for.
    pub primitives: usize,
    pub lattice: Lattice,
    pub blocks: B,
    pub cells: Counted,
}

impl<B: Blocks> Nested<B> {
    /// The lattice of blocks.
    pub fn top(&self) -> Lattice {
        let edge = self.blocks.edge();
        Lattice {
            lower: self.lattice.lower,
            size: core::array::from_fn(|k| self.lattice.size[k] * f64::from(edge[k])),
            resolution: self.top_resolution(),
        }
    }

    #[inline(always)]
    fn top_resolution(&self) -> [u32; 3] {
        let ([x, y, z], [ex, ey, ez]) = (self.lattice.resolution, self.blocks.edge());
        [x.div_ceil(ex), y.div_ceil(ey), z.div_ceil(ez)]
    }

    /// By what number steps name a block: cells come first.
    fn block_node(&self, number: usize) -> u32 {
        (self.cells.len() + number) as u32
    }

    /// See [`Traverse::traverse`](crate::Traverse::traverse).
    #[inline(always)]
    pub fn traverse<P: Primitives, Q: Query, C: Counters>(
        &self,
        primitives: &P,
        ray: &Ray,
        query: &mut Q,
        counters: &mut C,
    ) {
        let scale = self.space.bounds.scale();
        let Some(ray) = PreparedRay::new(ray, scale) else {
            return;
        };
        let reach = ray.origin.abs().max_element();
        if !ray.is_tame() || reach > MOST_SCALES * scale {
            return self.bisect_all(primitives, &ray, query, counters);
        }
        let everywhere = self.space.ask_everywhere(primitives, &ray, query, counters);
        if everywhere.is_break() {
            return;
        }
        let (way, mut enter, leave) = Way::through(&self.lattice, self.blocks.edge(), &ray);
        let end = query.t_max();
        let leave = if end < leave { end } else { leave };
        // Not `enter > leave`: NaN walks nowhere.
        if !(enter <= leave) {
            return;
        }
        let top = self.top_resolution();
        let strides = [1, top[0] as i32, (top[0] * top[1]) as i32];
        let mut mailbox = Mailbox::new();
        let mut walk = way.walk(top, strides, enter);
        loop {
            let exit = walk.exit();
            let block_leave = if exit < leave { exit } else { leave };
            counters.node();
            if C::EXPLAINS {
                let number = walk.cell();
                let bounds = self.top().cell(self.top().place(number));
                explain(
                    self.block_node(number),
                    bounds,
                    (enter, block_leave),
                    counters,
                );
            }
            if !self.blocks.is_empty(walk.cell(), &self.cells) {
                let block = self.blocks.block(walk.cell());
                let way = way.within(&walk, block.parts);
                let mut inner = way.walk(block.parts, block.strides, enter);
                loop {
                    let inner_exit = inner.exit();
                    let cell_leave = if inner_exit < block_leave {
                        inner_exit
                    } else {
                        block_leave
                    };
                    let cell = block.first as usize + inner.cell();
                    counters.node();
                    if C::EXPLAINS {
                        let bounds = self.cell_bounds(walk.cell(), cell);
                        explain(cell as u32, bounds, (enter, cell_leave), counters);
                        enter = cell_leave;
                    }
                    if self.cells.is_filled(cell) {
                        let list = self.cells.list(cell);
                        counters.leaf();
                        if C::EXPLAINS {
                            counters.step(Step::Leaf {
                                node: cell as u32,
                                primitives: list.len() as u32,
                            });
                        }
                        if mailbox
                            .offer(primitives, list, &ray, query, counters)
                            .is_break()
                        {
                            return;
                        }
                        // A hit exactly where the ray leaves may have an equal one in the next cell.
                        if query.t_max() < cell_leave {
                            return;
                        }
                    }
                    if inner_exit >= block_leave {
                        break;
                    }
                    inner.advance(&way, inner_exit);
                }
            }
            if exit >= leave {
                return;
            }
            enter = exit;
            walk.advance(&way, exit);
        }
    }

    fn cell_bounds(&self, number: usize, cell: usize) -> Aabb {
        let (top, block) = (self.top(), self.blocks.block(number));
        top.inside(top.place(number), block.parts)
            .cell(block.place(cell))
    }

    /// See [`Traverse::cells`](crate::Traverse::cells). Blocks are shown where they differ.
    pub fn show_cells(&self, with_blocks: bool, show: &mut dyn FnMut(&Cell<'_>)) {
        let (top, edge) = (self.top(), self.blocks.edge());
        let mut tell = |node, depth, bounds, primitives| {
            show(&Cell {
                node,
                depth,
                bounds,
                primitives,
                sides: &[],
            });
        };
        for number in 0..top.cells() as usize {
            let (place, block) = (top.place(number), self.blocks.block(number));
            if with_blocks {
                let nothing = self.blocks.is_empty(number, &self.cells).then_some(0);
                tell(self.block_node(number), 0, top.cell(place), nothing);
            }
            if block.parts.contains(&0) {
                continue;
            }
            let inner = top.inside(place, block.parts);
            for part in 0..inner.cells() as usize {
                let part = inner.place(part);
                let sticks_out = |k: usize| {
                    edge[k] > 1 && place[k] * edge[k] + part[k] >= self.lattice.resolution[k]
                };
                if !(0..3).any(sticks_out) {
                    let cell = block.cell(part);
                    let count = self.cells.count(cell);
                    tell(
                        cell as u32,
                        u32::from(with_blocks),
                        inner.cell(part),
                        Some(count),
                    );
                }
            }
        }
    }

    /// Blocks as nodes, filled cells as leaves. The cost is that of the walk: a node for every block, and for every cell
    /// in one that is not empty.
    pub fn statistics(&self) -> Statistics {
        let top = self.top();
        let block_area = half_area(&top.cell([0; 3]));
        let (mut cost, mut leaves) = (0.0, 0);
        for number in 0..top.cells() as usize {
            cost += f64::from(NODE_COST) * block_area;
            if self.blocks.is_empty(number, &self.cells) {
                continue;
            }
            let block = self.blocks.block(number);
            let cells: u32 = block.parts.iter().product();
            let area = half_area(&top.inside([0; 3], block.parts).cell([0; 3]));
            let mut references = 0;
            for cell in block.first..block.first + self.span(&block) {
                let count = self.cells.count(cell as usize);
                leaves += usize::from(count > 0);
                references += count;
            }
            let nodes = f64::from(NODE_COST) * f64::from(cells);
            let tests = f64::from(PRIMITIVE_COST) * f64::from(references);
            cost += (nodes + tests) * area;
        }
        let whole = half_area(&self.space.world);
        Statistics {
            primitives: self.primitives,
            nodes: top.cells() as usize,
            leaves,
            depth: 1,
            references: self.cells.references() + self.space.everywhere.len(),
            largest_leaf: self.cells.longest(),
            bytes: self.cells.bytes() + self.blocks.bytes() + size_of_val(&*self.space.everywhere),
            sah_cost: if whole > 0.0 && whole < f64::INFINITY {
                (cost / whole) as f32
            } else {
                0.0
            },
        }
    }

    /// How many numbers the cells of a block lie within.
    fn span(&self, block: &Block) -> u32 {
        match block.parts.contains(&0) {
            true => 0,
            false => block.cell(block.parts.map(|n| n - 1)) as u32 - block.first + 1,
        }
    }
}

/// A box that was opened.
#[cold]
fn explain<C: Counters>(node: u32, bounds: Aabb, (enter, leave): (f32, f32), counters: &mut C) {
    counters.step(Step::Box {
        node,
        bounds,
        enter,
        leave,
        verdict: Verdict::Opened,
    });
}
