//! Roots along a line: of spheres, of polynomials, and of anything that changes its sign.
//!
//! *Spheres* are met by the quadratic formula in the form of Haines, Günther & Akenine-Möller 2019, *Precision
//! Improvements for Ray/Sphere Intersection* (Ray Tracing Gems, chapter 7): the discriminant is the distance of the
//! sphere's centre from the line (Hearn & Baker), and the smaller root comes from the product of both. It is right for
//! small spheres far away, where the formula of textbooks loses all digits.
//!
//! *Polynomials* are cut at the roots of their derivative, and so on down to a line. Between two cuts a polynomial is
//! monotone and crosses zero at most once: none is skipped, whatever the coefficients (Yuksel 2022, *High-Performance
//! Polynomial Root Finding for Graphics*). A cut where the polynomial is zero up to its own rounding is a double root.

use super::double::{Double3, along, dot};
use crate::math::sqrt_f64;

/// Where `|l + t d| = radius`, in order; both equal where the line touches. `None` when it passes, or `d` is zero.
#[inline(always)]
pub(crate) fn sphere(l: Double3, d: Double3, radius: f64) -> Option<[f64; 2]> {
    let a = dot(d, d);
    let b = -dot(l, d);
    let middle = b / a;
    let nearest = along(l, d, middle);
    let reach = radius * radius - dot(nearest, nearest);
    if !(reach >= 0.0 && a > 0.0) {
        return None;
    }
    if reach == 0.0 {
        return Some([middle; 2]);
    }
    let z = b + sqrt_f64(a * reach).copysign(b);
    let (far, near) = (z / a, (dot(l, l) - radius * radius) / z);
    Some(if near < far { [near, far] } else { [far, near] })
}

/// Where `f` crosses zero between `a` and `b`, given that its signs there differ; right to about `2⁻⁴⁸` of the larger
/// end, or to the value's own noise. Usually about ten evaluations, never more than 250.
///
/// Steps of the Illinois method (Dowell & Jarratt 1971), with a halving wherever three of them did not halve the interval.
pub(crate) fn crossing(
    f: &mut impl FnMut(f64) -> f64,
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
) -> f64 {
    let narrow = a.abs().max(b.abs()) * (1.0 / (1_u64 << 48) as f64);
    // The values that the secant believes in, the end that moved last, and the width three steps ago.
    let (mut wa, mut wb) = (fa, fb);
    let mut moved_a = None;
    let mut width = f64::INFINITY;
    for step in 0..250 {
        if fa == 0.0 || fb == 0.0 || b - a <= narrow {
            break;
        }
        let mut m = b - wb * ((b - a) / (wb - wa));
        if step % 3 == 2 {
            let slow = b - a > 0.5 * width;
            width = if slow { 0.5 * (b - a) } else { b - a };
            if slow {
                m = f64::NAN;
            }
        }
        // Beside an end that is nearly the root, step over the root rather than onto it.
        m = m.clamp(a + 0.5 * narrow, b - 0.5 * narrow);
        if !(a < m && m < b) {
            m = 0.5 * a + 0.5 * b;
        }
        if !(a < m && m < b) {
            break;
        }
        let fm = f(m);
        let moves_a = (fm < 0.0) == (fa < 0.0);
        if moves_a {
            (a, fa, wa) = (m, fm, fm);
        } else {
            (b, fb, wb) = (m, fm, fm);
        }
        // An end that stays twice loses half its weight, so that the next step falls on its side of the root.
        if moved_a == Some(moves_a) {
            if moves_a {
                wb *= 0.5;
            } else {
                wa *= 0.5;
            }
        }
        moved_a = Some(moves_a);
    }
    if fa.abs() <= fb.abs() { a } else { b }
}

/// At most four roots, in order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Roots {
    roots: [f64; 4],
    count: usize,
}

impl Roots {
    pub fn as_slice(&self) -> &[f64] {
        &self.roots[..self.count]
    }
    fn push(&mut self, root: f64) {
        if self.count < self.roots.len() {
            self.roots[self.count] = root;
            self.count += 1;
        }
    }
}

/// The roots of `c[0] + c[1] x + …` (degree 4 at most) in the closed interval `[from, to]`, double ones once.
///
/// An even root counts where the polynomial comes as near to zero as `2⁻⁴⁹` of the sum of its terms' sizes: twice what
/// rounding may do to it.
pub(crate) fn polynomial(c: &[f64], from: f64, to: f64) -> Roots {
    let mut found = Roots::default();
    let mut value = |x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let in_order = from <= to;
    if c.len() < 2 || !in_order {
        return found;
    }
    let largest = from.abs().max(to.abs());
    let noise =
        c.iter().rev().fold(0.0, |sum, c| sum * largest + c.abs()) * (1.0 / (1_u64 << 49) as f64);
    let cuts = if c.len() > 2 {
        let mut slope = [0.0; 4];
        for (k, s) in slope.iter_mut().enumerate().take(c.len() - 1) {
            *s = c[k + 1] * (k + 1) as f64;
        }
        polynomial(&slope[..c.len() - 1], from, to)
    } else {
        Roots::default()
    };
    let zero = |f: f64| f.abs() <= noise;
    let mut before = (from, value(from));
    if zero(before.1) {
        found.push(from);
    }
    for &x in cuts.as_slice().iter().chain([&to]) {
        let here = (x, value(x));
        match (zero(before.1), zero(here.1)) {
            (false, false) if (before.1 < 0.0) != (here.1 < 0.0) => {
                found.push(crossing(&mut value, before, here));
            }
            (false, true) => found.push(x),
            // Two cuts on one flat spot are one root.
            (true, true) if !zero(value(0.5 * before.0 + 0.5 * x)) => found.push(x),
            _ => {}
        }
        before = here;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_have_their_roots() {
        let roots = |c: &[f64]| polynomial(c, -10.0, 10.0).as_slice().to_vec();
        assert_eq!(roots(&[-6.0, 2.0]), [3.0]);
        assert_eq!(roots(&[5.0, 0.0, 1.0]), []);
        // (x − 1)(x − 2)(x − 3)(x + 4)
        let four = roots(&[24.0, -38.0, 13.0, 2.0, -1.0].map(|c: f64| -c));
        assert_eq!(four.len(), 4);
        for (found, root) in four.iter().zip([-4.0, 1.0, 2.0, 3.0]) {
            assert!((found - root).abs() < 1.0e-13, "{four:?}");
        }
        // (x − 1)² (x + 2)²: two double roots.
        let two = roots(&[4.0, -4.0, -3.0, 2.0, 1.0]);
        assert_eq!(two.len(), 2, "{two:?}");
        assert!((two[0] + 2.0).abs() < 1.0e-7 && (two[1] - 1.0).abs() < 1.0e-7);
        // x⁴: one root of multiplicity four. (x − 1)³ (x + 1).
        assert_eq!(roots(&[0.0, 0.0, 0.0, 0.0, 1.0]).len(), 1);
        assert_eq!(roots(&[-1.0, 2.0, 0.0, -2.0, 1.0]).len(), 2);
        assert_eq!(roots(&[f64::NAN, 1.0, 1.0]), []);
    }

    #[test]
    fn small_spheres_far_away_keep_their_digits() {
        // At a distance of a million the roots of a sphere of radius 1/1024 are right to 1e-10.
        let [near, far] =
            sphere([0.0, 0.0, -1.0e6], [0.0, 0.0, 1.0], 1.0 / 1024.0).expect("through the middle");
        assert!((near - (1.0e6 - 1.0 / 1024.0)).abs() < 1.0e-9);
        assert!((far - (1.0e6 + 1.0 / 1024.0)).abs() < 1.0e-9);
        assert_eq!(
            sphere([1.0, 0.0, -5.0], [0.0, 0.0, 2.0], 1.0),
            Some([2.5; 2])
        );
        assert_eq!(sphere([0.0; 3], [0.0; 3], 1.0), None);
    }

    #[test]
    fn crossings_are_found_however_the_function_bends() {
        for (f, root) in [
            ((|x| x * x * x) as fn(f64) -> f64, 0.0),
            (|x| x * x * x - 2.0, 1.259_921_049_894_873_2),
            (|x| if x < 0.3 { -1.0e-300 } else { 1.0e300 }, 0.3),
            (|x| 1.0 / (x - 0.7), 0.7),
        ] {
            let mut f = f;
            let (a, b) = (-1.5, 1.7);
            let (fa, fb) = (f(a), f(b));
            let found = crossing(&mut f, (a, fa), (b, fb));
            assert!((found - root).abs() < 1.0e-13, "{found} for {root}");
        }
    }
}
