//! Four by four by four cells are a brick: 64 bits say which of them hold anything, and one look passes an empty brick.

use super::counted::Counted;
use super::nested::{Block, Blocks};

/// How cells are numbered: brick after brick, each with 64 numbers, whether it needs them or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bricks {
    /// How many there are.
    counts: [u32; 3],
    /// How many cells of a brick are used: 4, or fewer where the whole grid has fewer.
    edge: [u32; 3],
}

const EDGE: u32 = 4;
/// From one cell of a brick to the next.
const STRIDES: [i32; 3] = [1, EDGE as i32, (EDGE * EDGE) as i32];
/// The numbers of a brick.
const CELLS: usize = (EDGE * EDGE * EDGE) as usize;

impl Bricks {
    /// For a grid with so many cells.
    pub fn of(resolution: [u32; 3]) -> Self {
        Self {
            counts: resolution.map(|n| n.div_ceil(EDGE)),
            edge: resolution.map(|n| n.min(EDGE)),
        }
    }
    /// How many numbers there are.
    pub fn cells(&self) -> usize {
        self.counts.iter().map(|&n| n as usize).product::<usize>() * CELLS
    }
    /// The number of a cell.
    #[inline]
    pub fn cell(&self, [x, y, z]: [u32; 3]) -> u32 {
        let [nx, ny, _] = self.counts;
        let brick = x / EDGE + nx * (y / EDGE + ny * (z / EDGE));
        let within = x % EDGE + EDGE * (y % EDGE + EDGE * (z % EDGE));
        brick * CELLS as u32 + within
    }
}

impl Blocks for Bricks {
    #[inline(always)]
    fn edge(&self) -> [u32; 3] {
        self.edge
    }
    #[inline(always)]
    fn is_empty(&self, number: usize, cells: &Counted) -> bool {
        cells.word(number) == 0
    }
    #[inline(always)]
    fn block(&self, number: usize) -> Block {
        Block {
            first: (number * CELLS) as u32,
            parts: self.edge,
            strides: STRIDES,
        }
    }
    fn bytes(&self) -> usize {
        0
    }
}
