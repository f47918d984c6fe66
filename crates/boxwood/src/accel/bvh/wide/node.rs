//! A wide node: boxes, eight rows of `N` words or a quarter of that, and two rows of what is in them.

use super::boxes::Boxes;
use crate::geometry::ray::Facing;
use crate::geometry::{Aabb, Vec3};
use crate::simd::{F, Floats, Lanes, Row, Rows, plain};

/// A reference to a node or to a run of leaf blocks.
///
/// ```text
/// 31      30 ............ 4   3 .... 0
/// 0       node
/// 1       first block         blocks - 1
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Child(pub u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    /// More blocks than this cannot be numbered; there are always fewer nodes.
    pub const MOST_BLOCKS: usize = (1 << 27) - 1;
    /// What an unused slot holds, and the root of a tree without primitives: the block after the last possible one.
    pub const NOTHING: Self = Self(Self::LEAF | (Self::MOST_BLOCKS as u32) << 4);

    pub fn node(index: usize) -> Self {
        Self(index as u32)
    }
    /// One to sixteen blocks.
    ///
    /// # Panics
    /// When there are more.
    pub fn leaf(first: usize, blocks: usize) -> Self {
        assert!((1..=16).contains(&blocks), "a leaf of {blocks} blocks");
        Self(Self::LEAF | (first << 4 | (blocks - 1)) as u32)
    }
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }
    #[inline(always)]
    pub fn blocks(self) -> core::ops::Range<usize> {
        let first = (self.0 & !Self::LEAF) as usize >> 4;
        first..first + (self.0 & 15) as usize + 1
    }
    /// The number of a child of this node: 0 is the root, and the children of node `i` are `i N + 1` and so on.
    pub fn number<const N: usize>(self, lane: usize) -> u32 {
        (self.index() * N + lane + 1) as u32
    }
}

/// Boxes, children and their order: 256 bytes for 8 children, 512 for 16; 128 for 8 whose boxes are
/// [quantised](super::quantised::Quantised).
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node<const N: usize, B: Boxes<N> = Rows<N, 6>> {
    boxes: B,
    children: [u32; N],
    /// Eight lists of `N` nibbles, one per octant: the children from far to near.
    order: [u32; N],
}
plain!(Node<N, B: Boxes<N>> { boxes: B, children: [u32; N], order: [u32; N] });

impl<const N: usize> Node<N> {
    /// Gives a child another box. When all have theirs, [`Node::set_order`] is due.
    #[inline(always)]
    pub fn set_bounds(&mut self, lane: usize, bounds: &Aabb) {
        self.boxes.set(lane, bounds);
    }

    /// Whether no ray enters a slot without a child, and no box has a side that is no number.
    pub fn is_closed(&self) -> bool {
        (0..N).all(|lane| {
            let Aabb { lower, upper } = self.bounds(lane);
            if self.child(lane) == Child::NOTHING {
                self.bounds(lane) == Aabb::EMPTY
            } else {
                !(lower.to_array().into_iter())
                    .chain(upper.to_array())
                    .any(f32::is_nan)
            }
        })
    }

    /// Half the surface of each child's box; zero where there is no child.
    #[inline(always)]
    pub fn half_areas(&self) -> [f64; N] {
        let rows = &self.boxes.0;
        let mut areas = [0.0; N];
        for lane in 0..N {
            let x = extent(rows[0][lane], rows[1][lane]);
            let y = extent(rows[2][lane], rows[3][lane]);
            let z = extent(rows[4][lane], rows[5][lane]);
            areas[lane] = x * y + y * z + z * x;
        }
        areas
    }
}

impl<const N: usize, B: Boxes<N>> Node<N, B> {
    /// A node of at most `N` children. Unused slots hold a box that no ray enters.
    pub fn new(children: &[(Aabb, Child)]) -> Self {
        let mut bounds = [Aabb::EMPTY; N];
        let mut references = [Child::NOTHING.0; N];
        for (lane, &(around, child)) in children.iter().enumerate().take(N) {
            (bounds[lane], references[lane]) = (around, child.0);
        }
        let mut node = Self {
            boxes: B::new(&bounds[..children.len().min(N)]),
            children: references,
            order: [0; N],
        };
        node.set_order();
        node
    }

    /// Finds the children's order for every octant: from far to near by the middles of their boxes, after slots without a child. The
    /// place of each is the number of those that are farther.
    #[inline(always)]
    pub fn set_order(&mut self) {
        let nothing = |&&child: &&u32| child == Child::NOTHING.0;
        let count = N - self.children.iter().rev().take_while(nothing).count();
        self.order = [0; N];
        let [x, y, z] = self.boxes.middles();
        for octant in 0..4 {
            let [sx, sy] = [octant & 1, octant >> 1].map(|down| if down == 1 { -1.0 } else { 1.0 });
            let mut keys = [0_i32; N];
            for lane in 0..N {
                let bits = (sx * x[lane] + sy * y[lane] + z[lane]).to_bits() as i32;
                // Negative floats ascend when all bits but the sign are flipped: then NaN has a place too. The last bits make a
                // number of each lane that no other has.
                let ascending = bits ^ ((bits >> 31) as u32 >> 1) as i32;
                keys[lane] = ascending & !(N as i32 - 1) | lane as i32;
            }
            let mut farther = [0_u32; N];
            for &key in &keys[..count] {
                for lane in 0..N {
                    farther[lane] += u32::from(key > keys[lane]);
                }
            }
            for lane in 0..N {
                let place = farther[lane] as usize;
                let [there, back] = if lane < count {
                    // What is far one way is near the other way.
                    [N - count + place, N - 1 - place]
                } else {
                    [lane - count; 2]
                };
                for (octant, place) in [(octant, there), (7 - octant, back)] {
                    let nibble = octant * N + place;
                    self.order[nibble / 8] |= (lane as u32) << (4 * (nibble % 8));
                }
            }
        }
    }

    /// The children from far to near for one octant, a nibble each, from bit 0 up.
    #[inline(always)]
    pub fn order(&self, octant: usize) -> u64 {
        // The masks say to the compiler what the types cannot: `octant * N` is inside.
        match N {
            4 => u64::from(self.order[(octant >> 1) & (N - 1)] >> (16 * (octant & 1))),
            8 => u64::from(self.order[octant & (N - 1)]),
            _ => {
                let at = (2 * octant) & (N - 2);
                u64::from(self.order[at]) | u64::from(self.order[at | 1]) << 32
            }
        }
    }

    /// Whether each of the eight lists names every lane once.
    pub fn is_ordered(&self) -> bool {
        (0..8).all(|octant| {
            let order = self.order(octant);
            let lanes = (0..N).map(|place| order >> (4 * place) & 15);
            lanes.fold(0, |found, lane| found | 1_u32 << lane) == (1 << N) - 1
        })
    }

    #[inline(always)]
    pub fn child(&self, lane: usize) -> Child {
        Child(self.children[lane & (N - 1)])
    }

    /// Puts another child where one is; its box stays.
    pub fn set_child(&mut self, lane: usize, child: Child) {
        self.children[lane] = child.0;
    }

    #[inline(always)]
    pub fn children(&self) -> &[u32; N] {
        &self.children
    }

    /// Where a child of this node is.
    #[inline(always)]
    pub fn lane(&self, child: Child) -> usize {
        // To the end, because lanes do that at once.
        (0..N).fold(0, |found, lane| {
            if self.children[lane] == child.0 {
                lane
            } else {
                found
            }
        })
    }

    /// The children that are there: lane, box in the tree's frame, and child.
    pub fn slots(&self) -> impl Iterator<Item = (usize, Aabb, Child)> {
        let used = |&lane: &usize| self.children[lane] != Child::NOTHING.0;
        (0..N)
            .filter(used)
            .map(|lane| (lane, self.bounds(lane), self.child(lane)))
    }

    /// The box of a child, as the tree's frame sees it.
    pub fn bounds(&self, lane: usize) -> Aabb {
        self.boxes.bounds(lane)
    }

    /// The planes across an axis, near and far.
    #[inline(always)]
    pub fn planes<S: Lanes<N>>(&self, s: S, axis: usize, heading: Heading) -> [F<S, N>; 2] {
        self.boxes.planes(s, axis, heading.row(axis))
    }

    /// How far rays go for each child, which is nowhere in a slot without one.
    #[inline(always)]
    pub fn ends<S: Lanes<N>>(&self, s: S, t_max: F<S, N>) -> F<S, N> {
        self.boxes.ends(s, t_max)
    }

    /// Where the ray enters and leaves each child within its interval, both erring to the outside by the slack; a child is
    /// entered where `entry <= exit`. As [`PreparedRay::slabs`](crate::PreparedRay::slabs), with fewer roundings where the level can fuse.
    #[inline(always)]
    pub fn slabs<S: Lanes<N>>(
        &self,
        s: S,
        ray: &WideRay<S, N>,
        t_max: F<S, N>,
    ) -> (F<S, N>, F<S, N>) {
        let [x, y, z] = ray.rows;
        ray.meet(
            self.boxes.planes(s, 0, x),
            self.boxes.planes(s, 1, y),
            self.boxes.planes(s, 2, z),
            self.boxes.ends(s, t_max),
        )
    }
}

impl<const N: usize> Node<N> {
    /// As [`slabs`](Self::slabs), of boxes on their way from here to where they are in another node of the same children, of which so much is gone. Neither
    /// may have infinite sides.
    #[inline(always)]
    pub fn slabs_towards<S: Lanes<N>>(
        &self,
        s: S,
        far: &Self,
        weight: F<S, N>,
        ray: &WideRay<S, N>,
        t_max: F<S, N>,
    ) -> (F<S, N>, F<S, N>) {
        let [x, y, z] = ray.rows;
        let planes = |near: Row<N, 6>| {
            [near, near.neighbour()].map(|row| self.row_towards(s, far, weight, row))
        };
        ray.meet(planes(x), planes(y), planes(z), t_max)
    }

    /// A row of planes on its way.
    #[inline(always)]
    fn row_towards<S: Lanes<N>>(
        &self,
        s: S,
        far: &Self,
        weight: F<S, N>,
        row: Row<N, 6>,
    ) -> F<S, N> {
        let here = F::<S, N>::load(s, self.boxes.at(row));
        let there = F::<S, N>::load(s, far.boxes.at(row));
        (there - here).times_more(weight, here)
    }
}

#[inline(always)]
fn extent(lower: f32, upper: f32) -> f64 {
    (f64::from(upper) - f64::from(lower)).max(0.0)
}

/// Which way a ray runs: bit `k` says that it runs down axis `k`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Heading(u32);

impl Heading {
    /// Of no ray.
    pub const NONE: Self = Self(0);

    #[inline(always)]
    pub fn of<S: Lanes<4>>(s: S, facing: &Facing<S>) -> Self {
        Self(facing.down(s))
    }

    /// Of a direction. Not the sign bits: a zero of either sign counts as going up.
    #[inline(always)]
    pub fn towards(d: Vec3) -> Self {
        let [x, y, z] = [d.x < 0.0, d.y < 0.0, d.z < 0.0].map(u32::from);
        Self(x | y << 1 | z << 2)
    }

    /// Which of a node's eight orders fits.
    #[inline(always)]
    pub fn octant(self) -> usize {
        self.0 as usize & 7
    }

    /// The row of the planes across an axis that are met first; the last ones are its neighbour.
    #[inline(always)]
    fn row<const N: usize>(self, axis: usize) -> Row<N, 6> {
        Row::new(2 * axis + (self.0 as usize >> axis & 1))
    }

    /// Those rows of all axes.
    #[inline(always)]
    pub fn rows<const N: usize>(self) -> [Row<N, 6>; 3] {
        [self.row(0), self.row(1), self.row(2)]
    }

    /// Whether the ray runs down an axis.
    #[inline(always)]
    pub fn is_down(self, axis: usize) -> bool {
        self.0 >> axis & 1 == 1
    }
}

/// A tame ray in every lane.
pub struct WideRay<S: Lanes<N>, const N: usize> {
    inverse: [F<S, N>; 3],
    enter: [F<S, N>; 3],
    leave: [F<S, N>; 3],
    t_min: F<S, N>,
    /// Of the planes that it meets first.
    rows: [Row<N, 6>; 3],
}

impl<S: Lanes<N>, const N: usize> WideRay<S, N> {
    #[inline(always)]
    pub fn new(
        s: S,
        [inverse, enter, leave]: [[f32; 4]; 3],
        t_min: f32,
        rows: [Row<N, 6>; 3],
    ) -> Self {
        Self {
            inverse: splat::<S, N>(s, inverse),
            enter: splat::<S, N>(s, enter),
            leave: splat::<S, N>(s, leave),
            t_min: F::<S, N>::splat(s, t_min),
            rows,
        }
    }

    /// Where it enters and leaves boxes within its interval, by the planes that it meets first and last across each axis.
    #[inline(always)]
    fn meet(
        &self,
        [x, far_x]: [F<S, N>; 2],
        [y, far_y]: [F<S, N>; 2],
        [z, far_z]: [F<S, N>; 2],
        t_max: F<S, N>,
    ) -> (F<S, N>, F<S, N>) {
        let near_x = x.times_more(self.inverse[0], self.enter[0]);
        let near_y = y.times_more(self.inverse[1], self.enter[1]);
        let near_z = z.times_more(self.inverse[2], self.enter[2]);
        let far_x = far_x.times_more(self.inverse[0], self.leave[0]);
        let far_y = far_y.times_more(self.inverse[1], self.leave[1]);
        let far_z = far_z.times_more(self.inverse[2], self.leave[2]);
        (
            near_x.max(near_y).max(near_z.max(self.t_min)),
            far_x.min(far_y).min(far_z.min(t_max)),
        )
    }
}

#[inline(always)]
fn splat<S: Lanes<N>, const N: usize>(s: S, [x, y, z, _]: [f32; 4]) -> [F<S, N>; 3] {
    [
        F::<S, N>::splat(s, x),
        F::<S, N>::splat(s, y),
        F::<S, N>::splat(s, z),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, Level, Simd, Vectorize};

    struct Order<'a, const N: usize>(&'a mut Node<N>);

    impl<const N: usize> Kernel<N> for Order<'_, N> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd + Lanes<N>>(self, _: S) {
            self.0.set_order();
        }
    }

    fn check<const N: usize>(children: &[(Aabb, Child)])
    where
        Level: Vectorize<N>,
    {
        let expected = Node::<N>::new(children);
        for octant in 0..8 {
            let order = expected.order(octant);
            let lanes: [usize; N] = core::array::from_fn(|i| (order >> (4 * i)) as usize & 15);
            let mut sorted = lanes;
            sorted.sort_unstable();
            assert!((0..N).eq(sorted), "each once: {lanes:?}");
            let far = |lane: usize| {
                let middle = |b: &Aabb, k: usize| f64::from(b.lower[k] + b.upper[k]);
                let sign = |k: usize| if octant >> k & 1 == 1 { -1.0 } else { 1.0 };
                let sum = |b: &Aabb| (0..3).map(|k| sign(k) * middle(b, k)).sum::<f64>();
                let bounds = children.get(lane).map(|c| &c.0).filter(|b| !b.is_empty());
                bounds.map(sum).filter(|sum| sum.is_finite())
            };
            let keys: [Option<f64>; N] = lanes.map(far);
            let known = keys.iter().flatten();
            assert!(known.is_sorted_by(|a, b| a >= b), "far to near: {keys:?}");
        }
        for level in Level::available() {
            let mut node = expected;
            node.order = [0x5555_5555; N];
            level.vectorize(Order(&mut node));
            assert_eq!(node.order, expected.order, "{}", level.name());
        }
    }

    #[test]
    fn children_are_ordered_far_to_near_at_every_level() {
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            // Small whole numbers: sums are exact and ties frequent.
            (seed >> 60) as f32 - 8.0
        };
        for count in 0..=16 {
            let child = |i: usize| {
                let corner = [next(), next(), next()];
                let bounds = match i % 7 {
                    5 => Aabb::EMPTY,
                    6 => Aabb::new([f32::MIN; 3], [f32::MAX; 3]),
                    3 => Aabb::new([f32::MAX; 3], [f32::MAX; 3]),
                    _ => Aabb::new(corner, corner.map(|x| x + 1.0)),
                };
                (bounds, Child::node(i))
            };
            let children: alloc::vec::Vec<_> = (0..count).map(child).collect();
            check::<16>(&children);
            check::<8>(&children[..count.min(8)]);
            check::<4>(&children[..count.min(4)]);
        }
    }
}
