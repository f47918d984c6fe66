//! Four triangles side by side, met by the canonical test lane by lane.
//!
//! *How it works.* The corners lie in memory as the test wants them: a row of four floats for each vertex and axis, so that
//! the ray's axes choose rows and nothing is moved. The operations and their order are those of [`watertight`], so the bits
//! are too; only the filter is left out: rays that start on a surface pass it anyway, and one branch after `t` is faster.
//!
//! [`watertight`]: super::watertight

use super::watertight::TINY;
use crate::geometry::ray::Leaning;
use crate::geometry::{Aabb, Hit, PreparedRay, Vec3};
use crate::primitive::Primitives;
use crate::query::Query;
use crate::simd::{F, Floats, Lanes, Mask, plain};
use core::ops::ControlFlow::{self, Break, Continue};

/// How many triangles a block holds.
pub const LANES: usize = 4;

/// Up to four triangles with their numbers; 160 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    /// By vertex, axis and lane. Lanes without a triangle hold NaN, which nothing hits.
    corners: [[[f32; LANES]; 3]; 3],
    ids: [u32; LANES],
}
plain!(TriangleBlock {
    corners: [[[f32; LANES]; 3]; 3],
    ids: [u32; LANES]
});

impl TriangleBlock {
    /// Packs at most four triangles; their numbers should ascend.
    pub fn new(ids: &[u32], triangle: impl Fn(usize) -> [Vec3; 3]) -> Self {
        let mut block = Self {
            corners: [[[f32::NAN; LANES]; 3]; 3],
            ids: [u32::MAX; LANES],
        };
        for (lane, &id) in ids.iter().enumerate() {
            block.ids[lane] = id;
            for (rows, corner) in block.corners.iter_mut().zip(triangle(id as usize)) {
                for (axis, row) in rows.iter_mut().enumerate() {
                    row[lane] = corner[axis];
                }
            }
        }
        block
    }

    /// The triangles of these numbers, at least one and as many as come before the first `u32::MAX`, for one look at them: of a lane
    /// without only what the test needs is NaN.
    #[inline(always)]
    pub fn fetched<S: Lanes<LANES>, P: Primitives>(
        s: S,
        ids: [u32; LANES],
        primitives: &P,
    ) -> Self {
        let triangles = all_corners(primitives, &ids);
        let [p, q, r, t] = ids;
        let numbers = [
            f32::from_bits(p),
            f32::from_bits(q),
            f32::from_bits(r),
            f32::from_bits(t),
        ];
        let numbers = F::<S, LANES>::load(s, &numbers);
        let nan = F::<S, LANES>::splat(s, f32::NAN);
        // No number of a triangle has the bits of a NaN, but `u32::MAX` has. Any coordinate that is none leaves no edge and no `t`.
        let first = row(s, &triangles, 0, 0).choose(numbers.le(numbers), nan);
        let rows = [
            [
                first.to_array(),
                row(s, &triangles, 0, 1).to_array(),
                row(s, &triangles, 0, 2).to_array(),
            ],
            [
                row(s, &triangles, 1, 0).to_array(),
                row(s, &triangles, 1, 1).to_array(),
                row(s, &triangles, 1, 2).to_array(),
            ],
            [
                row(s, &triangles, 2, 0).to_array(),
                row(s, &triangles, 2, 1).to_array(),
                row(s, &triangles, 2, 2).to_array(),
            ],
        ];
        Self { corners: rows, ids }
    }

    /// Takes the corners of its triangles anew, and says what box is around them.
    #[inline(always)]
    pub fn refit<S: Lanes<LANES>, P: Primitives>(&mut self, s: S, primitives: &P) -> Aabb {
        let triangles = all_corners(primitives, &self.ids);
        let first = F::<S, LANES>::load(s, &self.corners[0][0]);
        let there = first.le(first);
        let [a, b, c] = [
            row(s, &triangles, 0, 0),
            row(s, &triangles, 1, 0),
            row(s, &triangles, 2, 0),
        ];
        self.keep(s, there, 0, [a, b, c]);
        let x = least_and_most::<S>(a.min(b).min(c), a.max(b).max(c));
        let [a, b, c] = [
            row(s, &triangles, 0, 1),
            row(s, &triangles, 1, 1),
            row(s, &triangles, 2, 1),
        ];
        self.keep(s, there, 1, [a, b, c]);
        let y = least_and_most::<S>(a.min(b).min(c), a.max(b).max(c));
        let [a, b, c] = [
            row(s, &triangles, 0, 2),
            row(s, &triangles, 1, 2),
            row(s, &triangles, 2, 2),
        ];
        self.keep(s, there, 2, [a, b, c]);
        let z = least_and_most::<S>(a.min(b).min(c), a.max(b).max(c));
        Aabb {
            lower: Vec3::new(x.0, y.0, z.0),
            upper: Vec3::new(x.1, y.1, z.1),
        }
    }

    /// Writes one coordinate of three corners, where there are triangles.
    #[inline(always)]
    fn keep<S: Lanes<LANES>>(
        &mut self,
        s: S,
        there: S::M,
        axis: usize,
        [a, b, c]: [F<S, LANES>; 3],
    ) {
        let [p, q, r] = &mut self.corners;
        let nan = F::<S, LANES>::splat(s, f32::NAN);
        p[axis] = a.choose(there, nan).to_array();
        q[axis] = b.choose(there, nan).to_array();
        r[axis] = c.choose(there, nan).to_array();
    }

    /// The same triangles on their way from here to where they are in another block, of which so much is gone: the operations of
    /// `geometry/motion.rs` lane by lane.
    #[inline(always)]
    pub fn towards<S: Lanes<LANES>>(&self, s: S, far: &Self, weight: f32) -> Self {
        let weight = F::<S, LANES>::splat(s, weight);
        let mut block = *self;
        for corner in 0..3 {
            for axis in 0..3 {
                let here = F::<S, LANES>::load(s, &self.corners[corner][axis]);
                let there = F::<S, LANES>::load(s, &far.corners[corner][axis]);
                block.corners[corner][axis] = (here - (here - there) * weight).to_array();
            }
        }
        block
    }

    /// The numbers in all lanes, `u32::MAX` in one without a triangle.
    #[inline(always)]
    pub fn lanes(&self) -> &[u32; LANES] {
        &self.ids
    }

    /// The numbers of its triangles.
    pub fn ids(&self) -> &[u32] {
        &self.ids[..self.count()]
    }

    /// One of its triangles, with its number; `None` in a lane without.
    #[inline(always)]
    pub fn numbered(&self, lane: usize) -> Option<(u32, [Vec3; 3])> {
        let lane = lane % LANES;
        let id = self.ids[lane];
        let corner = |[x, y, z]: &[[f32; LANES]; 3]| Vec3::new(x[lane], y[lane], z[lane]);
        let [a, b, c] = &self.corners;
        (id != u32::MAX).then(|| (id, [corner(a), corner(b), corner(c)]))
    }

    /// How many triangles it holds.
    #[inline(always)]
    pub fn count(&self) -> usize {
        let [a, b, c, d] = self.ids;
        let there = |id: u32| usize::from(id != u32::MAX);
        there(a) + there(b) + there(c) + there(d)
    }

    /// Shows the hits within `[t_min, query.t_max()]` to the query, of those triangles that `seen` lets through.
    ///
    /// Breaks with [`Stop::Uncovered`] at a hit that the proof of the slack does not cover, without showing it: looking at
    /// it again here would cost every ray registers, and such hits are rarer than one in many millions.
    #[inline(always)]
    pub fn offer<S: Lanes<LANES>, Q: Query>(
        &self,
        at: &BlockRay<'_, S>,
        query: &mut Q,
        seen: impl Fn(u32) -> bool,
    ) -> ControlFlow<Stop> {
        let s = at.s;
        let splat = F::<S, LANES>::splat;
        let &[kx, ky, kz] = at.leaning.axes;
        let [ox, oy, oz, _] = at.leaning.origin;
        let [ox, oy, oz] = [splat(s, ox), splat(s, oy), splat(s, oz)];
        let [sx, sy, iz] = at.leaning.shear;
        let [sx, sy, iz] = [splat(s, sx), splat(s, sy), splat(s, iz)];
        let [a, b, c] = &self.corners;
        let z0 = F::<S, LANES>::load(s, &a[kz]) - oz;
        let z1 = F::<S, LANES>::load(s, &b[kz]) - oz;
        let z2 = F::<S, LANES>::load(s, &c[kz]) - oz;
        let x0 = (F::<S, LANES>::load(s, &a[kx]) - ox) - sx * z0;
        let x1 = (F::<S, LANES>::load(s, &b[kx]) - ox) - sx * z1;
        let x2 = (F::<S, LANES>::load(s, &c[kx]) - ox) - sx * z2;
        let y0 = (F::<S, LANES>::load(s, &a[ky]) - oy) - sy * z0;
        let y1 = (F::<S, LANES>::load(s, &b[ky]) - oy) - sy * z1;
        let y2 = (F::<S, LANES>::load(s, &c[ky]) - oy) - sy * z2;
        let (u, v, w) = if at.exact {
            (
                difference_of_products(x2, y1, y2, x1),
                difference_of_products(x0, y2, y0, x2),
                difference_of_products(x1, y0, y1, x0),
            )
        } else {
            (x2 * y1 - y2 * x1, x0 * y2 - y0 * x2, x1 * y0 - y1 * x0)
        };
        let zero = F::<S, LANES>::splat(s, 0.0);
        // A NaN may get lost in `min` and `max`; it comes back in `t`.
        let inside = zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero);
        let determinant = (u + v) + w;
        let r = F::<S, LANES>::splat(s, 1.0) / determinant;
        let t = (((u * z0 + v * z1) + w * z2) * iz) * r;
        let t_max = F::<S, LANES>::splat(s, query.t_max());
        let mut found = (inside & splat(s, at.leaning.t_min).le(t) & t.le(t_max)).bits();
        if found == 0 {
            return Continue(());
        }
        let (t, u, v) = (t.to_array(), (v * r).to_array(), (w * r).to_array());
        let determinant = determinant.to_array();
        while found != 0 {
            let lane = found.trailing_zeros() as usize % LANES;
            found &= found - 1;
            let hit = Hit {
                t: t[lane],
                u: u[lane],
                v: v[lane],
                primitive: self.ids[lane],
                instance: 0,
            };
            // An earlier lane may have shortened the interval.
            if hit.t <= query.t_max() && seen(hit.primitive) {
                if at.exact && determinant[lane].abs() < TINY {
                    return Break(Stop::Uncovered);
                }
                if query.offer(hit).is_break() {
                    return Break(Stop::Enough);
                }
            }
        }
        Continue(())
    }
}

#[inline(always)]
fn corners(primitives: &impl Primitives, id: u32) -> [Vec3; 3] {
    primitives.corners(id as usize).expect("a triangle")
}

/// Of four triangles. No branch on how many there are: a lane without looks at the first one.
#[inline(always)]
fn all_corners(primitives: &impl Primitives, &[p, q, r, t]: &[u32; LANES]) -> [[Vec3; 3]; LANES] {
    [
        corners(primitives, p),
        corners(primitives, if q == u32::MAX { p } else { q }),
        corners(primitives, if r == u32::MAX { p } else { r }),
        corners(primitives, if t == u32::MAX { p } else { t }),
    ]
}

/// One coordinate of one corner of four triangles.
#[inline(always)]
fn row<S: Lanes<LANES>>(
    s: S,
    [p, q, r, t]: &[[Vec3; 3]; LANES],
    corner: usize,
    axis: usize,
) -> F<S, LANES> {
    F::<S, LANES>::load(
        s,
        &[
            p[corner][axis],
            q[corner][axis],
            r[corner][axis],
            t[corner][axis],
        ],
    )
}

/// Of all lanes.
#[inline(always)]
fn least_and_most<S: Lanes<LANES>>(least: F<S, LANES>, most: F<S, LANES>) -> (f32, f32) {
    let ([a, b, c, d], [e, f, g, h]) = (least.to_array(), most.to_array());
    (
        less(less(a, b), less(c, d)),
        -less(less(-e, -f), less(-g, -h)),
    )
}

#[inline(always)]
fn less(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Why the triangles were not all shown.
pub enum Stop {
    /// The query has seen enough.
    Enough,
    /// A hit must be [confirmed](super::watertight::confirmed) first: the ray is for a loop that does so.
    Uncovered,
}

/// `a b − c d`, as in the canonical test.
#[inline(always)]
fn difference_of_products<const N: usize, T: Floats<N>>(a: T, b: T, c: T, d: T) -> T {
    let (p, q) = (a * b, c * d);
    (p - q) + (a.product_error(b, p) - c.product_error(d, q))
}

/// A tame ray at a leaf.
pub struct BlockRay<'r, S> {
    pub s: S,
    pub ray: &'r PreparedRay,
    /// The ray's own, wherever it is at hand.
    pub leaning: &'r Leaning,
    /// Whether edges are met with the errors of their products.
    pub exact: bool,
}

/// Sixteen tame rays with the same axes.
pub struct RayGroup<'a> {
    /// Whether edges are met with the errors of their products.
    pub exact: bool,
    pub axes: [usize; 3],
    /// In the order of `axes`.
    pub origin: [&'a [f32; RayGroup::LANES]; 3],
    pub shear: [&'a [f32; RayGroup::LANES]; 3],
    pub t_min: &'a [f32; RayGroup::LANES],
}

impl RayGroup<'_> {
    /// How many rays.
    pub const LANES: usize = 16;
}

/// Where some rays of a group meet a triangle.
pub struct Meetings<S: Lanes<{ RayGroup::LANES }>> {
    /// Which ones.
    pub rays: S::M,
    pub t: F<S, { RayGroup::LANES }>,
    pub u: F<S, { RayGroup::LANES }>,
    pub v: F<S, { RayGroup::LANES }>,
    /// Those whose hit the proof of the slack does not cover, a bit each; see [`Stop::Uncovered`].
    pub uncovered: u32,
}

/// A triangle's corners by axis, in the order of the rays' axes, seen from the rays and sheared along their directions.
type Corners<S> = [[F<S, { RayGroup::LANES }>; 3]; 3];

impl TriangleBlock {
    /// Which rays of a group may meet each triangle, wherever along the ray: a bit each, by triangle. Without a branch, so
    /// that one triangle need not wait for the other.
    #[inline(always)]
    pub fn may_meet<S: Lanes<{ RayGroup::LANES }>>(
        &self,
        s: S,
        rays: &RayGroup<'_>,
    ) -> [u32; LANES] {
        let zero = F::<S, { RayGroup::LANES }>::splat(s, 0.0);
        let mut met = [0; LANES];
        for (lane, met) in met.iter_mut().enumerate() {
            let [[x0, x1, x2], [y0, y1, y2], _] = self.seen_by(s, lane, rays);
            // Rounding is monotone: what the exact edge functions accept passes this.
            let (u, v, w) = (x2 * y1 - y2 * x1, x0 * y2 - y0 * x2, x1 * y0 - y1 * x0);
            *met = (zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero)).bits();
        }
        met
    }

    #[inline(always)]
    fn seen_by<S: Lanes<{ RayGroup::LANES }>>(
        &self,
        s: S,
        lane: usize,
        rays: &RayGroup<'_>,
    ) -> Corners<S> {
        let [kx, ky, kz] = rays.axes;
        let [a, b, c] = &self.corners;
        let load = F::<S, { RayGroup::LANES }>::load;
        let splat = F::<S, { RayGroup::LANES }>::splat;
        let [ox, oy, oz] = [
            load(s, rays.origin[0]),
            load(s, rays.origin[1]),
            load(s, rays.origin[2]),
        ];
        let [sx, sy] = [load(s, rays.shear[0]), load(s, rays.shear[1])];
        let z0 = splat(s, a[kz][lane]) - oz;
        let z1 = splat(s, b[kz][lane]) - oz;
        let z2 = splat(s, c[kz][lane]) - oz;
        let x0 = (splat(s, a[kx][lane]) - ox) - sx * z0;
        let x1 = (splat(s, b[kx][lane]) - ox) - sx * z1;
        let x2 = (splat(s, c[kx][lane]) - ox) - sx * z2;
        let y0 = (splat(s, a[ky][lane]) - oy) - sy * z0;
        let y1 = (splat(s, b[ky][lane]) - oy) - sy * z1;
        let y2 = (splat(s, c[ky][lane]) - oy) - sy * z2;
        [[x0, x1, x2], [y0, y1, y2], [z0, z1, z2]]
    }

    /// One of the triangles against a group of rays, each up to its `t_max`.
    #[inline(always)]
    pub fn meet<S: Lanes<{ RayGroup::LANES }>>(
        &self,
        s: S,
        triangle: usize,
        rays: &RayGroup<'_>,
        t_max: F<S, { RayGroup::LANES }>,
    ) -> Option<Meetings<S>> {
        let lane = triangle % LANES;
        let load = F::<S, { RayGroup::LANES }>::load;
        let splat = F::<S, { RayGroup::LANES }>::splat;
        let [[x0, x1, x2], [y0, y1, y2], [z0, z1, z2]] = self.seen_by(s, lane, rays);
        let zero = splat(s, 0.0);
        let (u, v, w) = if rays.exact {
            (
                difference_of_products(x2, y1, y2, x1),
                difference_of_products(x0, y2, y0, x2),
                difference_of_products(x1, y0, y1, x0),
            )
        } else {
            (x2 * y1 - y2 * x1, x0 * y2 - y0 * x2, x1 * y0 - y1 * x0)
        };
        let inside = zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero);
        let determinant = (u + v) + w;
        let r = splat(s, 1.0) / determinant;
        let t = (((u * z0 + v * z1) + w * z2) * load(s, rays.shear[2])) * r;
        let met = inside & load(s, rays.t_min).le(t) & t.le(t_max);
        if met.bits() == 0 {
            return None;
        }
        let thin = determinant.abs().lt(splat(s, TINY));
        Some(Meetings {
            rays: met,
            t,
            u: v * r,
            v: w * r,
            uncovered: if rays.exact { (met & thin).bits() } else { 0 },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriangleMesh;
    use crate::simd::{Kernel, Level, Simd, Vectorize};
    use alloc::vec::Vec;

    struct Refit<'a>(&'a mut TriangleBlock, &'a TriangleMesh);

    impl Kernel<LANES> for Refit<'_> {
        type Output = Aabb;
        #[inline(always)]
        fn run<S: Simd + Lanes<LANES>>(self, s: S) -> Aabb {
            self.0.refit(s, self.1)
        }
    }

    #[test]
    fn a_block_follows_its_triangles_at_every_level() {
        let corner = |i: usize| [i as f32, (i * i % 7) as f32 - 3.0, -0.5 * i as f32];
        let corners = (0..30).map(corner);
        let triangles = (0..10_u32).map(|i| [i, (7 * i + 3) % 30, 29 - i]);
        let mut mesh = TriangleMesh::new(corners, triangles).expect("a good mesh");
        for ids in [&[4_u32][..], &[2, 9], &[0, 1, 5], &[3, 4, 6, 8]] {
            let before = TriangleBlock::new(ids, |i| mesh.triangle(i));
            let to = mesh.positions().iter().map(|&p| p * -3.0);
            mesh.move_vertices(to.collect::<Vec<_>>()).expect("finite");
            let expected = TriangleBlock::new(ids, |i| mesh.triangle(i));
            let around = ids.iter().flat_map(|&i| mesh.triangle(i as usize));
            let around = Aabb::of(around);
            for level in Level::available() {
                let mut block = before;
                assert_eq!(level.vectorize(Refit(&mut block, &mesh)), around);
                for lane in 0..LANES {
                    assert_eq!(block.numbered(lane), expected.numbered(lane));
                    // What is not there is hit by nothing.
                    let there = lane < ids.len();
                    let rows = block.corners.iter().flatten();
                    assert!(rows.into_iter().all(|row| row[lane].is_nan() != there));
                }
            }
        }
    }
}
