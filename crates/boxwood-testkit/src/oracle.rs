//! The judge's judge: a brute force in double precision that knows how far a single-precision answer may be off.
//!
//! *How it works.* The ray's origin is moved to zero and its direction sheared onto its largest axis, as the canonical test
//! does, but in double precision. There a triangle is met for certain when zero lies deeper inside than the canonical
//! test's rounding (`12 u D`, `D` the largest distance of a corner along an axis, `u = 2⁻²⁴`), and missed for certain when
//! it lies that far outside. What lies between is doubtful: both answers are right. The distance is off by `10 u D`, and by
//! `12 u D` times the slope of the triangle's plane.

use boxwood::{Hit, Ray, TriangleMesh, Vec3};

const U: f64 = 1.0 / (1 << 24) as f64;

/// What is certain about a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// No correct test can say hit.
    Missed,
    /// Rounding decides.
    Doubtful,
    /// Every correct test says hit, with a `t` from the first to the second number.
    Met(f64, f64),
}

/// What is certain about an unlimited ray and a triangle: the interval of the ray does not count here.
pub fn verdict(triangle: [Vec3; 3], ray: &Ray) -> Verdict {
    let (o, d) = (double(ray.origin), double(ray.direction));
    let kz = ray.direction.abs().max_axis();
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let moved = triangle.map(|p| {
        let p = double(p);
        let z = p[kz] - o[kz];
        let x = p[kx] - o[kx] - d[kx] / d[kz] * z;
        let y = p[ky] - o[ky] - d[ky] / d[kz] * z;
        [x, y, z]
    });
    let reach = reach(triangle, ray);
    let doubt = 12.0 * U * reach;
    // Zero and the corners as seen along each edge's normal, and along the axes for triangles without area.
    let mut inside = true;
    for k in 0..3 {
        let (p, q, r) = (moved[k], moved[(k + 1) % 3], moved[(k + 2) % 3]);
        let along = [q[0] - p[0], q[1] - p[1]];
        let length = along[0].hypot(along[1]);
        let height = |s: [f64; 2]| (along[0] * (s[1] - p[1]) - along[1] * (s[0] - p[0])) / length;
        let (third, zero) = (height([r[0], r[1]]), height([0.0, 0.0]));
        if zero < third.min(0.0) - doubt || zero > third.max(0.0) + doubt {
            return Verdict::Missed;
        }
        // Written so that an edge without length is never inside.
        inside &= zero * third.signum() > doubt && third.abs() > 2.0 * doubt;
    }
    for axis in 0..2 {
        let along = moved.map(|p| p[axis]);
        if along.iter().all(|&x| x > doubt) || along.iter().all(|&x| x < -doubt) {
            return Verdict::Missed;
        }
    }
    if !inside {
        return Verdict::Doubtful;
    }
    // The plane z = z₀ + sx x + sy y through the three corners.
    let [a, b, c] = moved;
    let (e, f) = (
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]],
        [c[0] - a[0], c[1] - a[1], c[2] - a[2]],
    );
    let n = [
        e[1] * f[2] - e[2] * f[1],
        e[2] * f[0] - e[0] * f[2],
        e[0] * f[1] - e[1] * f[0],
    ];
    let z = a[2] + (n[0] * a[0] + n[1] * a[1]) / n[2];
    let slope = ((n[0] / n[2]).abs() + (n[1] / n[2]).abs()).max(0.0);
    let off = (10.0 * U * reach + doubt * slope) / d[kz].abs();
    Verdict::Met(z / d[kz] - off, z / d[kz] + off)
}

/// How far a hit's point on the ray and its point on the triangle are apart along any axis, over the bound that the
/// canonical test promises: `22 u D` by its rounding and `10 u D` by that of `t`, `u` and `v` themselves. Never above 1.
pub fn distance_over_bound(triangle: [Vec3; 3], ray: &Ray, hit: &Hit) -> f64 {
    let [a, b, c] = triangle.map(double);
    let (o, d) = (double(ray.origin), double(ray.direction));
    let (t, u, v) = (f64::from(hit.t), f64::from(hit.u), f64::from(hit.v));
    let apart = (0..3).map(|k| {
        let on_ray = o[k] + t * d[k];
        let on_triangle = a[k] * (1.0 - u - v) + b[k] * u + c[k] * v;
        (on_ray - on_triangle).abs()
    });
    apart.fold(0.0, f64::max) / (32.0 * U * reach(triangle, ray))
}

/// `D`: the largest distance of a corner from the origin along any axis.
fn reach(triangle: [Vec3; 3], ray: &Ray) -> f64 {
    let o = double(ray.origin);
    let along = triangle.iter().flat_map(|&p| {
        let p = double(p);
        [0, 1, 2].map(|k| (p[k] - o[k]).abs())
    });
    along.fold(0.0, f64::max)
}

/// What a judge's answer for an unlimited ray contradicts, in a sentence; `None` when it stands.
///
/// It must not miss when some triangle is met for certain, must not name one that is missed for certain, must give a `t`
/// within the bounds, and nothing may be nearer for certain.
pub fn contradicts(mesh: &TriangleMesh, ray: &Ray, found: Option<Hit>) -> Option<String> {
    for i in 0..mesh.triangles().len() {
        let verdict = verdict(mesh.triangle(i), ray);
        let own = found.filter(|hit| hit.primitive as usize == i);
        match (verdict, found, own) {
            (Verdict::Missed, _, Some(hit)) => {
                return Some(format!("{hit:?} is a miss for certain"));
            }
            (Verdict::Met(from, to), _, Some(hit)) if !(from..=to).contains(&f64::from(hit.t)) => {
                return Some(format!("{hit:?} lies outside {from:e} to {to:e}"));
            }
            (Verdict::Met(from, to), None, None) if from >= 0.0 => {
                return Some(format!(
                    "triangle {i} is met at {from:e} to {to:e}, not missed"
                ));
            }
            (Verdict::Met(from, to), Some(hit), None) if from >= 0.0 && to < f64::from(hit.t) => {
                return Some(format!(
                    "triangle {i} is met at {from:e} to {to:e}, before {hit:?}"
                ));
            }
            _ => {}
        }
    }
    None
}

fn double(v: Vec3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGHT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn certain_where_it_can_be() {
        let ask = |x: f32, y: f32| {
            let ray = Ray::new([x, y, -2.0], [0.0, 0.0, 2.0]);
            verdict(RIGHT.map(Vec3::from), &ray)
        };
        assert!(matches!(ask(0.2, 0.3), Verdict::Met(from, to) if from < 1.0 && 1.0 < to));
        assert_eq!(ask(0.0, 0.3), Verdict::Doubtful);
        assert_eq!(ask(0.6, 0.6), Verdict::Missed);
        assert_eq!(ask(-0.001, 0.3), Verdict::Missed);
    }

    #[test]
    fn wrong_answers_are_contradicted() {
        let squares = [RIGHT, RIGHT.map(|p| [p[0], p[1], 1.0])].concat();
        let mesh = TriangleMesh::new(squares, [[0_u32, 1, 2], [3, 4, 5]]).expect("good");
        let ray = Ray::new([0.2, 0.3, -2.0], [0.0, 0.0, 2.0]);
        let hit = |t: f32, primitive| Hit {
            t,
            u: 0.2,
            v: 0.3,
            primitive,
            instance: 0,
        };
        assert_eq!(contradicts(&mesh, &ray, Some(hit(1.0, 0))), None);
        assert!(contradicts(&mesh, &ray, None).is_some_and(|s| s.contains("not missed")));
        assert!(contradicts(&mesh, &ray, Some(hit(1.5, 1))).is_some_and(|s| s.contains("before")));
        assert!(contradicts(&mesh, &ray, Some(hit(1.1, 0))).is_some_and(|s| s.contains("outside")));
        assert!(distance_over_bound(mesh.triangle(0), &ray, &hit(1.0, 0)) < 1.0);
        assert!(distance_over_bound(mesh.triangle(0), &ray, &hit(1.001, 0)) > 1.0);
    }
}
