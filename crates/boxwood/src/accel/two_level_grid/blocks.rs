//! Blocks that are each cut in their own way.

use crate::accel::grid::counted::Counted;
use crate::accel::grid::lattice::MAX_CELLS;
use crate::accel::grid::nested::{Block, Blocks};
use alloc::vec::Vec;

/// No axis of a block is cut into more cells.
pub(super) const MOST_PARTS: u32 = 255;

/// Where each block's cells begin, and how many it has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CutBlocks(Vec<CutBlock>);

/// ```text
/// first: the number of the first cell        parts: x | y << 8 | z << 16, all 0 in an empty block
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct CutBlock {
    first: u32,
    parts: u32,
}

/// Bytes for so many blocks.
pub(super) fn bytes_of_blocks(blocks: usize) -> usize {
    blocks * size_of::<CutBlock>()
}

impl CutBlocks {
    /// Blocks that are cut into so many parts; and how many cells those are. Where there would be more than
    /// [`MAX_CELLS`], the blocks that are left have one cell each.
    pub fn of(parts: impl Iterator<Item = [u32; 3]>) -> (Self, usize) {
        let mut cells = 0;
        let block = |mut parts: [u32; 3]| {
            let first = cells;
            if u64::from(cells) + u64::from(parts.iter().product::<u32>()) > MAX_CELLS {
                parts = parts.map(|n| n.min(1));
            }
            cells += parts.iter().product::<u32>();
            let [x, y, z] = parts;
            CutBlock {
                first,
                parts: x | y << 8 | z << 16,
            }
        };
        let blocks = parts.map(block).collect();
        (Self(blocks), cells as usize)
    }
}

impl Blocks for CutBlocks {
    #[inline(always)]
    fn edge(&self) -> [u32; 3] {
        [1; 3]
    }
    #[inline(always)]
    fn is_empty(&self, number: usize, _: &Counted) -> bool {
        self.0[number].parts == 0
    }
    #[inline(always)]
    fn block(&self, number: usize) -> Block {
        let CutBlock { first, parts } = self.0[number];
        let parts = [parts & 255, parts >> 8 & 255, parts >> 16];
        Block {
            first,
            parts,
            strides: [1, parts[0] as i32, (parts[0] * parts[1]) as i32],
        }
    }
    fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_lie_one_after_the_other() {
        let parts = [[2, 3, 4], [0; 3], [255, 1, 255], [1; 3]];
        let (blocks, cells) = CutBlocks::of(parts.into_iter());
        assert_eq!(cells, 24 + 255 * 255 + 1);
        for (number, (parts, first)) in parts.iter().zip([0, 24, 24, 24 + 255 * 255]).enumerate() {
            let block = blocks.block(number);
            assert_eq!((block.parts, block.first), (*parts, first));
            assert_eq!(
                blocks.is_empty(number, &Counted::default()),
                *parts == [0; 3]
            );
        }
        assert_eq!(blocks.block(0).cell([1, 2, 3]), 23);
    }
}
