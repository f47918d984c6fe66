//! What lies in the leaves: triangles lane by lane, or the numbers of anything else.

use crate::geometry::Aabb;
use crate::geometry::triangle::block::{BlockRay, LANES, Stop, TriangleBlock};
use crate::primitive::{self, Foresight, Primitives, Triangles};
use crate::proximity::Numbered;
use crate::query::{Counters, Query, each_pair};
use crate::simd::{Isa, Kernel, Lanes, Pages, Simd, Vectorize, address};
use core::ops::ControlFlow::{self, Break, Continue};
use core::ops::Range;

/// No primitive in this place.
const NONE: u32 = u32::MAX;

/// So many blocks are brought up to date by one thread at a time.
const CHUNK: usize = 1024;

/// So many blocks ahead corners are asked for, and twice as many ahead the vertices' numbers.
const AHEAD: usize = 6;

/// The blocks of all leaves. One of the lists is empty: which, is decided by [`Primitives::TRIANGLES`].
#[derive(Clone, Debug, Default)]
pub struct Leaves {
    triangles: Pages<TriangleBlock>,
    ids: Pages<[u32; LANES]>,
}

impl Leaves {
    /// How many primitives a block holds.
    pub const LANES: usize = LANES;

    /// With room for so many blocks.
    pub fn with_capacity<P: Primitives>(blocks: usize) -> Self {
        let (triangles, ids) = if P::TRIANGLES {
            (blocks, 0)
        } else {
            (0, blocks)
        };
        Self {
            triangles: Pages::with_room(triangles),
            ids: Pages::with_room(ids),
        }
    }

    /// Appends a leaf and says which blocks it got. The numbers must ascend.
    pub fn push<P: Primitives>(&mut self, primitives: &P, ids: &[u32]) -> Range<usize> {
        let first = self.len();
        for ids in ids.chunks(LANES) {
            if P::TRIANGLES {
                let corners = |i| primitives.corners(i).expect("a triangle");
                self.triangles.push(TriangleBlock::new(ids, corners));
            } else {
                let mut block = [NONE; LANES];
                block[..ids.len()].copy_from_slice(ids);
                self.ids.push(block);
            }
        }
        first..self.len()
    }

    /// Appends a leaf that others hold, and says which blocks it got.
    pub fn push_copy(&mut self, from: &Self, blocks: Range<usize>) -> Range<usize> {
        let first = self.len();
        for block in blocks {
            match from.triangles.get(block) {
                Some(&triangles) => self.triangles.push(triangles),
                None => self.ids.push(from.ids[block]),
            }
        }
        first..self.len()
    }

    /// Takes the corners of all triangles anew and finds the box around each block, of which there are as many.
    pub fn refit<P: Primitives + Sync>(&mut self, primitives: &P, boxes: &mut [Aabb], isa: Isa) {
        if P::TRIANGLES {
            each_pair(CHUNK, &mut self.triangles, boxes, |_, blocks, boxes| {
                isa.level().vectorize(Follow {
                    primitives,
                    blocks,
                    boxes,
                });
            });
        } else {
            each_pair(CHUNK, &mut self.ids, boxes, |_, blocks, boxes| {
                for (block, around) in blocks.iter().zip(boxes) {
                    let ids = block.iter().take_while(|&&id| id != NONE);
                    *around = ids.fold(Aabb::EMPTY, |b, &id| {
                        b.union(primitives.bounds(id as usize))
                    });
                }
            });
        }
    }

    /// How many blocks.
    pub fn len(&self) -> usize {
        self.triangles.len() + self.ids.len()
    }

    /// The bytes of one block.
    pub fn block_bytes<P: Primitives>() -> usize {
        if P::TRIANGLES {
            size_of::<TriangleBlock>()
        } else {
            size_of::<[u32; LANES]>()
        }
    }

    /// The triangles in some blocks; none where the primitives are something else.
    #[inline(always)]
    pub fn triangles(&self, blocks: Range<usize>) -> &[TriangleBlock] {
        self.triangles.get(blocks).unwrap_or(&[])
    }

    /// Where a block lies, if it is one of triangles.
    #[inline(always)]
    pub fn address(&self, block: usize) -> *const u8 {
        address(&self.triangles, block)
    }

    /// The primitives in some blocks.
    pub fn ids(&self, blocks: Range<usize>) -> impl Iterator<Item = u32> {
        blocks
            .flat_map(|block| match self.triangles.get(block) {
                Some(triangles) => triangles.ids().iter(),
                None => self.ids[block].iter(),
            })
            .copied()
            .filter(|&id| id != NONE)
    }

    /// The triangles in some blocks, with their numbers.
    #[inline(always)]
    pub fn numbered<P: Triangles>(
        &self,
        primitives: &P,
        blocks: Range<usize>,
    ) -> impl Iterator<Item = Numbered> {
        blocks.flat_map(move |block| {
            let lanes = self.triangles.get(block);
            let ids = lanes.map_or(&self.ids[..], |_| &[]).get(block);
            (0..LANES).map_while(move |lane| match (lanes, ids) {
                (Some(lanes), _) => lanes.numbered(lane),
                (None, Some(ids)) if ids[lane] != NONE => {
                    Some((ids[lane], primitives.triangle(ids[lane] as usize)))
                }
                _ => None,
            })
        })
    }

    /// Shows the primitives in some blocks to the query.
    #[inline(always)]
    pub fn offer<S: Lanes<LANES>, P: Primitives, Q: Query, C: Counters>(
        &self,
        blocks: Range<usize>,
        primitives: &P,
        at: &BlockRay<'_, S>,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<Stop> {
        if P::TRIANGLES {
            let mask = query.mask();
            for block in &self.triangles[blocks] {
                counters.primitives(block.count());
                block.offer(at, query, |id| primitives.mask(id as usize) & mask != 0)?;
            }
        } else {
            for block in &self.ids[blocks] {
                for &id in block {
                    if id == NONE {
                        break;
                    }
                    if primitive::offer(primitives, id as usize, at.ray, query, counters).is_break()
                    {
                        return Break(Stop::Enough);
                    }
                }
            }
        }
        Continue(())
    }
}

/// Takes the corners of some blocks' triangles anew.
struct Follow<'a, P> {
    primitives: &'a P,
    blocks: &'a mut [TriangleBlock],
    boxes: &'a mut [Aabb],
}

impl<P: Primitives> Follow<'_, P> {
    #[inline(always)]
    fn foresee(&self, block: usize, step: Foresight) {
        if let Some(block) = self.blocks.get(block) {
            for &id in block.lanes() {
                self.primitives.foresee(id as usize, step);
            }
        }
    }
}

impl<P: Primitives> Kernel<LANES> for Follow<'_, P> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd + Lanes<LANES>>(self, s: S) {
        for i in 0..2 * AHEAD {
            self.foresee(i, Foresight::Far);
        }
        for i in 0..AHEAD {
            self.foresee(i, Foresight::Near);
        }
        for i in 0..self.blocks.len() {
            self.foresee(i + 2 * AHEAD, Foresight::Far);
            self.foresee(i + AHEAD, Foresight::Near);
            self.boxes[i] = self.blocks[i].refit(s, self.primitives);
        }
    }
}
