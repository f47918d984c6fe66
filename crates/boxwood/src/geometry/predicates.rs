//! On which side of a line or a plane a point lies, never wrong.
//!
//! *How it works.* Both questions are the sign of a determinant. It is computed in double precision first, with a bound for
//! its error; only where it lies within the bound, the determinant is multiplied out into products of the coordinates as
//! they are, each of which doubles hold exactly, and those are added without any loss as a sum of numbers that do not
//! overlap. Floats are so short, and doubles reach so far, that nothing overflows or vanishes on the way.
//!
//! *Cost.* A dozen operations, or two dozen in space; some hundreds where the point is nearly on the plane.
//!
//! *Source.* Shewchuk 1997, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*.

use super::Vec3;

/// Half a unit in the last place of one, in double precision.
const HALF_ULP: f64 = 1.0 / (1_u64 << 53) as f64;

/// 1 where `a`, `b`, `c` run counter-clockwise, −1 where clockwise, 0 where they lie on a line.
#[inline]
pub fn orient2d(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> i32 {
    let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(|p| p.map(f64::from));
    let left = (ax - cx) * (by - cy);
    let right = (ay - cy) * (bx - cx);
    let determinant = left - right;
    let bound = (3.0 + 16.0 * HALF_ULP) * HALF_ULP * (left.abs() + right.abs());
    // Without any product there is no error.
    if determinant.abs() > bound || bound == 0.0 {
        return sign(determinant);
    }
    let terms = [ax * by, -ay * bx, bx * cy, -by * cx, cx * ay, -cy * ax];
    exact_sign(&terms)
}

/// The sign of `(a − p) · ((b − p) × (c − p))`: 1 where the triangle runs clockwise as seen from `p`, so that `p` lies behind
/// it; −1 where `p` lies in front of it; 0 in its plane.
#[inline]
pub fn orient3d([a, b, c]: [Vec3; 3], p: Vec3) -> i32 {
    let wide = |v: Vec3| v.to_array().map(f64::from);
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = {
        let p = wide(p);
        [a, b, c].map(|v| {
            let v = wide(v);
            [v[0] - p[0], v[1] - p[1], v[2] - p[2]]
        })
    };
    let [bxcy, cxby] = [bx * cy, cx * by];
    let [cxay, axcy] = [cx * ay, ax * cy];
    let [axby, bxay] = [ax * by, bx * ay];
    let determinant = az * (bxcy - cxby) + bz * (cxay - axcy) + cz * (axby - bxay);
    let permanent = (bxcy.abs() + cxby.abs()) * az.abs()
        + (cxay.abs() + axcy.abs()) * bz.abs()
        + (axby.abs() + bxay.abs()) * cz.abs();
    let bound = (7.0 + 56.0 * HALF_ULP) * HALF_ULP * permanent;
    if determinant.abs() > bound || bound == 0.0 {
        return sign(determinant);
    }
    orient3d_exactly([a, b, c, p].map(wide))
}

#[cold]
fn orient3d_exactly([a, b, c, p]: [[f64; 3]; 4]) -> i32 {
    // det(a, b, c) − det(p, b, c) − det(a, p, c) − det(a, b, p)
    let determinants = [
        (1.0, [a, b, c]),
        (-1.0, [p, b, c]),
        (-1.0, [a, p, c]),
        (-1.0, [a, b, p]),
    ];
    const PERMUTATIONS: [([usize; 3], f64); 6] = [
        ([0, 1, 2], 1.0),
        ([1, 2, 0], 1.0),
        ([2, 0, 1], 1.0),
        ([0, 2, 1], -1.0),
        ([2, 1, 0], -1.0),
        ([1, 0, 2], -1.0),
    ];
    let mut terms = [0.0; MOST_TERMS];
    let mut count = 0;
    for (of_row, rows) in determinants {
        for ([i, j, k], of_place) in PERMUTATIONS {
            // 48 bits, cut in halves so that three factors fit too.
            let (high, low) = halves(rows[0][i] * rows[1][j]);
            let third = rows[2][k] * (of_row * of_place);
            [terms[count], terms[count + 1]] = [high * third, low * third];
            count += 2;
        }
    }
    exact_sign(&terms)
}

/// Two numbers of at most 26 bits whose sum it is. Dekker 1971.
fn halves(x: f64) -> (f64, f64) {
    let shifted = x * ((1_u64 << 27) + 1) as f64;
    let high = shifted - (shifted - x);
    (high, x - high)
}

fn sign(x: f64) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}

const MOST_TERMS: usize = 48;

/// The sign of the sum of some numbers, without any rounding.
#[cold]
fn exact_sign(terms: &[f64]) -> i32 {
    // Parts from small to large that do not overlap and are not zero; their sum is that of the terms so far.
    let mut parts = [0.0; MOST_TERMS];
    let mut count = 0;
    for &term in terms {
        let mut sum = term;
        let mut kept = 0;
        for i in 0..count {
            let part = parts[i];
            let rounded = sum + part;
            let virtually = rounded - sum;
            let lost = (sum - (rounded - virtually)) + (part - virtually);
            sum = rounded;
            if lost != 0.0 {
                parts[kept] = lost;
                kept += 1;
            }
        }
        if sum != 0.0 {
            parts[kept] = sum;
            kept += 1;
        }
        count = kept;
    }
    parts[..count].last().map_or(0, |&largest| sign(largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides() {
        let [o, x, y] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(
            (orient2d(o, x, y), orient2d(o, y, x), orient2d(o, x, x)),
            (1, -1, 0)
        );
        let triangle = [
            Vec3::ZERO,
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
        ];
        assert_eq!(orient3d(triangle, Vec3::new(5.0, 5.0, -1.0)), 1);
        assert_eq!(orient3d(triangle, Vec3::new(0.1, 0.1, 1.0)), -1);
        assert_eq!(orient3d(triangle, Vec3::new(7.0, -3.0, 0.0)), 0);
    }

    /// Against whole numbers of 128 bits, where most determinants are zero or nearly so.
    #[test]
    fn as_whole_numbers_say() {
        let mut state = 5_u64;
        let mut below = move |n: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let mut seen = [0; 3];
        for round in 0..20_000 {
            // Points near a line or a plane through the origin, up to 2²⁴: every step of one counts.
            let base = [(); 2].map(|()| [(); 3].map(|()| below(1 << 11) as i128 - 1024));
            let mut point = || {
                let [s, t] = [below(1 << 12) as i128 - 2048, below(1 << 12) as i128 - 2048];
                let off = if below(2) == 0 { 1 } else { 0 };
                let mut p: [i128; 3] = core::array::from_fn(|k| base[0][k] * s + base[1][k] * t);
                p[below(3) as usize] += off;
                p
            };
            let whole = [point(), point(), point(), point()];
            let floats = whole.map(|p| Vec3::from(p.map(|x| x as f32)));
            assert!((0..4).all(|i| (0..3).all(|k| floats[i][k] as i128 == whole[i][k])));
            let [a, b, c] =
                [0, 1, 2].map(|i| core::array::from_fn::<_, 3, _>(|k| whole[i][k] - whole[3][k]));
            let volume = a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
            let expected = volume.signum() as i32;
            seen[(expected + 1) as usize] += 1;
            let [p, q, r, s] = floats;
            assert_eq!(orient3d([p, q, r], s), expected, "{round}: {floats:?}");
            let area = (a[0] * b[1] - a[1] * b[0]).signum() as i32;
            let flat = |v: Vec3| [v.x, v.y];
            assert_eq!(
                orient2d(flat(p), flat(q), flat(s)),
                area,
                "{round}: {floats:?}"
            );
        }
        assert!(seen.iter().all(|&n| n > 1000), "{seen:?}");
    }

    #[test]
    fn at_the_ends_of_the_floats() {
        let (tiny, huge) = (f32::from_bits(1), f32::MAX);
        let [o, x, y] = [0.0, 1.0, 2.0].map(|_| [0.0_f32; 2]);
        assert_eq!(orient2d(o, x, y), 0);
        assert_eq!(
            orient2d([0.0, 0.0], [huge, huge], [huge, huge.next_down()]),
            -1
        );
        assert_eq!(orient2d([-huge, -huge], [huge, huge], [tiny, 0.0]), -1);
        assert_eq!(orient2d([0.0, 0.0], [tiny, 0.0], [0.0, tiny]), 1);
        let triangle = |s: f32| [Vec3::ZERO, Vec3::new(s, 0.0, 0.0), Vec3::new(0.0, s, 0.0)];
        for s in [tiny, 1.0, huge] {
            assert_eq!(orient3d(triangle(s), Vec3::new(huge, -huge, tiny)), -1);
            assert_eq!(orient3d(triangle(s), Vec3::new(huge, -huge, 0.0)), 0);
        }
        // The plane x + y + z = 0 through numbers of very different sizes.
        let slanted = [
            Vec3::new(huge, -huge, 0.0),
            Vec3::new(0.0, huge, -huge),
            Vec3::new(tiny, 0.0, -tiny),
        ];
        assert_eq!(orient3d(slanted, Vec3::new(tiny, -tiny, 0.0)), 0);
        assert_ne!(orient3d(slanted, Vec3::new(tiny, 0.0, 0.0)), 0);
    }
}
