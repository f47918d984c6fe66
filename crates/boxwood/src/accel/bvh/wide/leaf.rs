//! What lies in the leaves: triangles lane by lane, or the numbers of anything else, and of triangles where memory counts.

use super::layout::Layout;
use crate::geometry::Aabb;
use crate::geometry::triangle::block::{BlockRay, LANES, Stop, TriangleBlock};
use crate::primitive::{self, Foresight, Primitives, Triangles};
use crate::proximity::Numbered;
use crate::query::{Counters, Part, Query, each_pair};
use crate::simd::{Isa, Kernel, Lanes, Pages, Simd, Vectorize, address, words, words_mut};
use core::mem::MaybeUninit;
use core::ops::ControlFlow::{self, Break, Continue};
use core::ops::Range;

/// No primitive in this place.
pub const NONE: u32 = u32::MAX;

/// So many blocks are brought up to date by one thread at a time.
const CHUNK: usize = 1024;

/// So many blocks ahead corners are asked for, and twice as many ahead the vertices' numbers.
const AHEAD: usize = 6;

/// The blocks of all leaves. One of the lists is empty: which, is decided by [`Layout::has_corners`].
#[derive(Clone, Debug, Default)]
pub struct Leaves {
    triangles: Pages<TriangleBlock>,
    ids: Pages<[u32; LANES]>,
}

/// Some blocks, to be written.
pub struct Blocks<'a> {
    triangles: &'a mut [TriangleBlock],
    ids: &'a mut [[u32; LANES]],
}

impl<'a> Blocks<'a> {
    /// Takes the first ones off.
    pub fn take(&mut self, count: usize) -> Blocks<'a> {
        fn take<'a, T>(list: &mut &'a mut [T], count: usize) -> &'a mut [T] {
            let all = core::mem::take(list);
            let (taken, rest) = all.split_at_mut(count.min(all.len()));
            *list = rest;
            taken
        }
        Blocks {
            triangles: take(&mut self.triangles, count),
            ids: take(&mut self.ids, count),
        }
    }

    /// Writes a leaf into them. The numbers must ascend.
    pub fn write<P: Primitives>(self, primitives: &P, ids: &[u32]) {
        let corners = |i| primitives.corners(i).expect("a triangle");
        for (block, ids) in self.triangles.iter_mut().zip(ids.chunks(LANES)) {
            *block = TriangleBlock::new(ids, corners);
        }
        for (block, ids) in self.ids.iter_mut().zip(ids.chunks(LANES)) {
            *block = [NONE; LANES];
            block[..ids.len()].copy_from_slice(ids);
        }
    }
}

impl Leaves {
    /// How many primitives a block holds.
    pub const LANES: usize = LANES;

    /// How many of so many blocks go to which list.
    fn lists(corners: bool, blocks: usize) -> (usize, usize) {
        if corners { (blocks, 0) } else { (0, blocks) }
    }

    /// With room for so many blocks, of corners or of numbers.
    pub fn with_capacity(corners: bool, blocks: usize) -> Self {
        let (triangles, ids) = Self::lists(corners, blocks);
        Self {
            triangles: Pages::with_room(triangles),
            ids: Pages::with_room(ids),
        }
    }

    /// So many blocks of zeros, to be written over; `None` where there is no memory for them.
    pub fn zeroed(corners: bool, blocks: usize) -> Option<Self> {
        let (triangles, ids) = Self::lists(corners, blocks);
        Some(Self {
            triangles: Pages::zeroed(triangles)?,
            ids: Pages::zeroed(ids)?,
        })
    }

    /// All blocks as words.
    pub fn words(&self) -> &[u32] {
        if self.triangles.is_empty() {
            words(&self.ids)
        } else {
            words(&self.triangles)
        }
    }

    /// The same, to be written.
    pub fn words_mut(&mut self) -> &mut [u32] {
        if self.triangles.is_empty() {
            words_mut(&mut self.ids)
        } else {
            words_mut(&mut self.triangles)
        }
    }

    /// The numbers in all places of a block; [`NONE`] in those without a primitive.
    pub fn places(&self, block: usize) -> [u32; LANES] {
        match self.triangles.get(block) {
            Some(triangles) => *triangles.lanes(),
            None => self.ids[block],
        }
    }

    /// Whether a block holds the corners of the triangles whose numbers it holds, bit by bit; these must be numbers of
    /// triangles. Holds of anything that is no triangle.
    pub fn is_of<P: Primitives>(&self, primitives: &P, block: usize, ids: &[u32]) -> bool {
        let Some(found) = self.triangles.get(block) else {
            return true;
        };
        let corners = |i| primitives.corners(i).expect("a triangle");
        words(&[*found]) == words(&[TriangleBlock::new(ids, corners)])
    }

    /// All blocks, to be written.
    pub fn blocks(&mut self) -> Blocks<'_> {
        Blocks {
            triangles: &mut self.triangles,
            ids: &mut self.ids,
        }
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
    pub fn block_bytes(corners: bool) -> usize {
        if corners {
            size_of::<TriangleBlock>()
        } else {
            size_of::<[u32; LANES]>()
        }
    }

    /// A block that holds the corners of its triangles.
    #[inline(always)]
    pub fn corners(&self, block: usize) -> Option<&TriangleBlock> {
        self.triangles.get(block)
    }

    /// The triangles in a block: as they lie there, or fetched into the room that is given. Only of blocks that hold triangles.
    #[inline(always)]
    pub fn triangles<'a, S: Lanes<LANES>, L: Layout, P: Primitives>(
        &'a self,
        s: S,
        block: usize,
        primitives: &P,
        room: &'a mut MaybeUninit<TriangleBlock>,
    ) -> &'a TriangleBlock {
        if L::CORNERS {
            &self.triangles[block]
        } else {
            room.write(TriangleBlock::fetched(s, self.ids[block], primitives))
        }
    }

    /// Begins to load what will be read of the primitives that a block names, if there is such a block.
    #[inline(always)]
    pub fn foresee<P: Primitives>(&self, block: usize, primitives: &P, step: Foresight) {
        if let Some(ids) = self.ids.get(block) {
            for &id in ids {
                primitives.foresee(id as usize, step);
            }
        }
    }

    /// Where a block lies.
    #[inline(always)]
    pub fn address<L: Layout>(&self, block: usize) -> *const u8 {
        if L::CORNERS {
            address(&self.triangles, block)
        } else {
            address(&self.ids, block)
        }
    }

    /// Gives all primitives that are no triangles other numbers.
    pub fn renumber(&mut self, number: impl Fn(u32) -> u32) {
        for id in self.ids.as_flattened_mut() {
            if *id != NONE {
                *id = number(*id);
            }
        }
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
    pub fn offer<L: Layout, S: Lanes<LANES>, P: Primitives, Q: Query, C: Counters>(
        &self,
        blocks: Range<usize>,
        primitives: &P,
        parts: &[Part],
        at: &BlockRay<'_, S>,
        query: &mut Q,
        counters: &mut C,
    ) -> ControlFlow<Stop> {
        if P::TRIANGLES {
            let mask = query.mask();
            let seen = |id| primitives.mask(id as usize) & mask != 0;
            if L::CORNERS {
                for block in &self.triangles[blocks] {
                    counters.primitives(block.count());
                    block.offer(at, query, seen)?;
                }
            } else {
                for &ids in &self.ids[blocks] {
                    let block = TriangleBlock::fetched(at.s, ids, primitives);
                    counters.primitives(block.count());
                    block.offer(at, query, seen)?;
                }
            }
        } else {
            // One that lies alone has the box that the ray was found to meet.
            if P::COMPOSITE
                && blocks.len() == 1
                && let [id, NONE, ..] = self.ids[blocks.start]
            {
                let (id, part) = (id as usize, parts.get(blocks.start).copied());
                let part = part.unwrap_or(Part::ALL);
                return primitive::offer_part(primitives, id, part, at.ray, query, counters)
                    .map_break(|()| Stop::Enough);
            }
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
