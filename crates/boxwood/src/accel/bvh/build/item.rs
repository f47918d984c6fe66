//! What builders see of a primitive: its box and its number, in two rows of four lanes.

use crate::geometry::{Aabb, Vec3};
use crate::primitive::Primitives;
use crate::simd::{F, Floats, Lanes};
use alloc::vec::Vec;
#[cfg(feature = "parallel")]
use {super::top_down::SEQUENTIAL, crate::threads::Exactly, rayon::prelude::*};

/// A box as four lanes of lower planes and four of negated upper ones: all of it grows by one minimum. The fourth lane of
/// each row says nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sides([f32; 8]);

impl Sides {
    pub const EMPTY: Self = Self([f32::INFINITY; 8]);

    #[inline(always)]
    pub fn of(b: &Aabb) -> Self {
        let (l, u) = (b.lower, b.upper);
        Self([l.x, l.y, l.z, 0.0, -u.x, -u.y, -u.z, 0.0])
    }
    #[inline(always)]
    pub fn of_point(p: [f32; 4]) -> Self {
        Self([p[0], p[1], p[2], p[3], -p[0], -p[1], -p[2], -p[3]])
    }
    /// Around both; NaN in `other` is passed over.
    #[inline(always)]
    pub fn around(&self, other: &Self) -> Self {
        let mut sides = self.0;
        for (mine, &theirs) in sides.iter_mut().zip(&other.0) {
            *mine = if theirs < *mine { theirs } else { *mine };
        }
        Self(sides)
    }
    /// Lower x, y, z, negated upper x, y, z.
    #[inline(always)]
    pub fn of_planes(p: [f32; 6]) -> Self {
        Self([p[0], p[1], p[2], 0.0, p[3], p[4], p[5], 0.0])
    }
    /// One of those.
    #[inline(always)]
    pub fn plane(&self, plane: usize) -> f32 {
        self.0[plane + plane / 3]
    }
    /// All at once: of two boxes, `theirs.min(mine)` is around both, and passes over NaN in `theirs`.
    #[inline(always)]
    pub fn lanes<S: Lanes<8>>(&self, s: S) -> F<S, 8> {
        F::<S, 8>::load(s, &self.0)
    }
    #[inline(always)]
    pub fn of_lanes<S: Lanes<8>>(lanes: F<S, 8>) -> Self {
        Self(lanes.to_array())
    }
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let mut size = [0.0; 4];
        for k in 0..4 {
            let between = -self.0[k + 4] - self.0[k];
            size[k] = if between > 0.0 { between } else { 0.0 };
        }
        let [x, y, z, _] = size;
        x * y + y * z + z * x
    }
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        let s = &self.0;
        Aabb {
            lower: Vec3::new(s[0], s[1], s[2]),
            upper: Vec3::new(-s[4], -s[5], -s[6]),
        }
    }
}

/// Set in the lanes of the number: floats of about 2^23, that go through the operations of the other lanes as fast as they.
const NUMBER: u32 = 0x4b00_0000;

/// A primitive, or a part of one, on its way through a builder.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Item {
    /// Half of the number's bits lie in the fourth lane of each row.
    sides: Sides,
}

impl Item {
    #[inline(always)]
    pub fn new(bounds: &Aabb, id: u32) -> Self {
        let mut sides = Sides::of(bounds);
        sides.0[3] = f32::from_bits(NUMBER | id & 0xffff);
        sides.0[7] = f32::from_bits(NUMBER | id >> 16);
        Self { sides }
    }
    #[inline(always)]
    pub fn id(&self) -> u32 {
        self.sides.0[3].to_bits() & 0xffff | self.sides.0[7].to_bits() << 16
    }
    #[inline(always)]
    pub fn sides(&self) -> Sides {
        self.sides
    }
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        self.sides.bounds()
    }
    #[inline(always)]
    pub fn centroid(&self) -> Vec3 {
        let [x, y, z, _] = self.middle();
        Vec3::new(x, y, z)
    }
    /// The centroid, and a number.
    #[inline(always)]
    pub fn middle(&self) -> [f32; 4] {
        let s = &self.sides.0;
        let mut middle = [0.0; 4];
        for k in 0..4 {
            middle[k] = s[k] * 0.5 - s[k + 4] * 0.5;
        }
        middle
    }
    /// The same along one axis.
    #[inline(always)]
    pub fn middle_along(&self, axis: usize) -> f32 {
        let s = &self.sides.0;
        s[axis & 3] * 0.5 - s[axis & 3 | 4] * 0.5
    }
    /// The same number with another box.
    pub fn with_bounds(&self, bounds: &Aabb) -> Self {
        Self::new(bounds, self.id())
    }

    /// Around some items.
    #[inline(always)]
    pub fn around(items: &[Self]) -> Aabb {
        Self::sides_around(items).bounds()
    }
    /// The same, as sides.
    #[inline(always)]
    pub fn sides_around(items: &[Self]) -> Sides {
        let mut around = Sides::EMPTY;
        for item in items {
            around = around.around(&item.sides);
        }
        around
    }
    /// Around the middles of some items.
    #[inline(always)]
    pub fn around_middles(items: &[Self]) -> Sides {
        #[cfg(feature = "parallel")]
        if items.len() > 8 * SEQUENTIAL {
            return items
                .par_chunks(SEQUENTIAL)
                .exactly()
                .map(Self::around_middles)
                .reduce(|| Sides::EMPTY, |a, b| a.around(&b));
        }
        let mut around = Sides::EMPTY;
        for item in items {
            around = around.around(&Sides::of_point(item.middle()));
        }
        around
    }

    /// Orders items along an axis by their middles; `tie` decides between equal ones. Infinities and NaN have a place too.
    #[inline(always)]
    pub fn key(&self, axis: usize, tie: u32) -> u64 {
        let bits = self.middle_along(axis).to_bits();
        // Flips all bits of negative numbers and the sign of the others: then they ascend like whole numbers.
        let place = bits ^ (((bits as i32 >> 31) as u32) | 1 << 31);
        u64::from(place) << 32 | u64::from(tie)
    }
}

/// Every primitive with its box, in order.
pub(super) fn items(primitives: &(impl Primitives + Sync)) -> Vec<Item> {
    let item = |i| Item::new(&primitives.bounds(i), i as u32);
    #[cfg(feature = "parallel")]
    if primitives.len() > SEQUENTIAL {
        let all = (0..primitives.len()).into_par_iter();
        let all = all.with_min_len(SEQUENTIAL / 4).exactly();
        return all.map(item).collect();
    }
    (0..primitives.len()).map(item).collect()
}
