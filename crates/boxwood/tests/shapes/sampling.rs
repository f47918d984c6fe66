//! The judge of roots: fine steps in double precision.

use boxwood::Ray;

pub fn at(ray: &Ray, t: f64) -> [f64; 3] {
    let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
    [0, 1, 2].map(|k| f64::from(o[k]) + t * f64::from(d[k]))
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// All roots from fine steps and bisection; `None` where the function comes nearer to zero than `doubt` without crossing.
pub fn sampled(
    f: impl Fn(f64) -> f64,
    from: f64,
    to: f64,
    steps: usize,
    doubt: f64,
) -> Option<Vec<f64>> {
    let t = |k: usize| from + (to - from) * (k as f64 / steps as f64);
    let bisect = |mut a: f64, mut b: f64| {
        let below = f(a) < 0.0;
        for _ in 0..100 {
            let m = 0.5 * (a + b);
            if (f(m) < 0.0) == below { a = m } else { b = m }
        }
        0.5 * (a + b)
    };
    let values: Vec<f64> = (0..=steps).map(|k| f(t(k))).collect();
    let mut roots = Vec::new();
    for k in 1..=steps {
        if (values[k - 1] < 0.0) != (values[k] < 0.0) {
            roots.push(bisect(t(k - 1), t(k)));
        }
        if k == steps {
            break;
        }
        let [a, m, b] = [values[k - 1], values[k], values[k + 1]];
        let sign = if m < 0.0 { -1.0 } else { 1.0 };
        let nearest_here = sign * m <= sign * a && sign * m <= sign * b;
        if !nearest_here || sign * a < 0.0 || sign * b < 0.0 {
            continue;
        }
        // The function turns here without having crossed: look closely (golden section).
        let (mut a, mut b) = (t(k - 1), t(k + 1));
        const GOLDEN: f64 = 0.618_033_988_749_895;
        for _ in 0..80 {
            let (c, d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
            if sign * f(c) < sign * f(d) {
                b = d
            } else {
                a = c
            }
        }
        let turn = 0.5 * (a + b);
        if f(turn).abs() <= doubt {
            return None;
        }
        if sign * f(turn) < 0.0 {
            roots.push(bisect(t(k - 1), turn));
            roots.push(bisect(turn, t(k + 1)));
        }
    }
    roots.sort_by(f64::total_cmp);
    Some(roots)
}

/// Roots nearer to each other than floats tell apart count once.
pub fn merged(roots: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::new();
    for t in roots {
        if kept.last().is_none_or(|&last| t - last > t.abs() * 5.0e-7) {
            kept.push(t);
        }
    }
    kept
}
