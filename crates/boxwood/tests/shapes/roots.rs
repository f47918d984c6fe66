//! All roots are found, each once, where dense sampling finds them.

use crate::functions::*;
use crate::generators::{Random, rays_at};
use crate::sampling::{at, dot, merged, sampled};
use boxwood::{
    Aabb, BruteForce, Enclosure, Implicit, ImplicitSurface, Intersect, Primitives, Ray, Segment,
    Shape, Shapes, Sphere, Surfaces,
};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// How many rays were compared, and how many roots they had together.
fn same_roots<F: Shape>(
    shape: F,
    f: impl Fn([f64; 3]) -> f64,
    rays: impl IntoIterator<Item = Ray>,
    doubt: f64,
) -> (usize, usize)
where
    Shapes<F>: Primitives + Send + Sync,
{
    let judge = BruteForce::new(Shapes::new([shape]).expect("a good shape"));
    let (mut compared, mut total) = (0, 0);
    for ray in rays {
        let Some((from, to)) = Intersect::bounds(&judge).intersect(&ray) else {
            assert_eq!(judge.all_hits(&ray), []);
            continue;
        };
        let (from, to) = (f64::from(from) * 0.9999, f64::from(to) * 1.0001);
        let Some(roots) = sampled(|t| f(at(&ray, t)), from, to, 4000, doubt) else {
            continue;
        };
        // What lies outside the box does not exist; who can tell on its sides?
        let b = Intersect::bounds(&judge);
        let outside = |t: &f64| {
            let p = at(&ray, *t);
            let beyond =
                |k: usize| (f64::from(b.lower[k]) - p[k]).max(p[k] - f64::from(b.upper[k]));
            beyond(0).max(beyond(1)).max(beyond(2))
        };
        if roots.iter().any(|t| outside(t).abs() < 1.0e-6) {
            continue;
        }
        let roots = merged(roots.into_iter().filter(|t| outside(t) < 0.0));
        let hits = judge.all_hits(&ray);
        let found = merged(hits.iter().map(|hit| f64::from(hit.t)));
        assert_eq!(found.len(), roots.len(), "{ray:?}: {found:?} for {roots:?}");
        for (found, root) in found.iter().zip(&roots) {
            assert!(
                (found - root).abs() <= 2.0e-7 * root.abs(),
                "{ray:?}: {found} for {root}"
            );
        }
        compared += 1;
        total += roots.len();
    }
    (compared, total)
}

#[test]
fn spheres_have_the_roots_of_dense_sampling() {
    let sphere = Sphere::new([0.0; 3], 1.0);
    let rays = rays_at(&Shapes::new([sphere]).unwrap(), 1, 3000);
    let (compared, roots) = same_roots(sphere, ball, rays, 1.0e-14);
    assert!(compared > 2000 && roots > 2500, "{compared} {roots}");
}

#[test]
fn tori_have_the_roots_of_dense_sampling() {
    let rays = rays_at(&Shapes::new([ring()]).unwrap(), 2, 4000);
    let (compared, roots) = same_roots(ring(), ring_function::<f64>, rays, 1.0e-13);
    assert!(compared > 2500 && roots > 4000, "{compared} {roots}");
}

#[test]
fn implicit_surfaces_have_the_roots_of_dense_sampling() {
    fn check<F: Implicit + Copy + Send + Sync>(f: F, seed: u64, doubt: f64, roots: usize) {
        let shape = ImplicitSurface(f);
        let rays = rays_at(&Shapes::new([shape]).unwrap(), seed, 1500);
        let (compared, found) = same_roots(shape, |p| f.value(p), rays, doubt);
        assert!(compared > 800 && found > roots, "{compared} {found}");
    }
    check(Ball, 3, 1.0e-10, 1200);
    check(Ring, 4, 1.0e-9, 1200);
    check(Gyroid, 5, 1.0e-9, 2500);
    check(Metaballs, 6, 1.0e-9, 800);
    check(Tangled, 7, 1.0e-8, 2500);
    check(Distance, 8, 1.0e-10, 1200);
    check(SmoothGyroid, 9, 1.0e-9, 2500);
}

/// A function that never changes its sign has all its roots all the same, each once.
#[test]
fn double_roots_are_found_once() {
    let sphere = Shapes::new([Sphere::new([0.0; 3], 1.0)]).unwrap();
    let exact = BruteForce::new(&sphere);
    let touching = BruteForce::new(Shapes::new([ImplicitSurface(Touching)]).unwrap());
    let (mut hits, mut misses) = (0, 0);
    for ray in rays_at(&sphere, 10, 3000) {
        let d = ray.direction.to_array().map(f64::from);
        let o = ray.origin.to_array().map(f64::from);
        let middle = -dot(o, d) / dot(d, d);
        let clear = dot(at(&ray, middle), at(&ray, middle)).sqrt() - 1.0;
        // Nearer than that, two roots are one, and a near miss is a touch.
        if clear.abs() < 1.0e-5 {
            continue;
        }
        let expected = merged(exact.all_hits(&ray).iter().map(|hit| f64::from(hit.t)));
        let found: Vec<f64> = touching
            .all_hits(&ray)
            .iter()
            .map(|hit| f64::from(hit.t))
            .collect();
        assert_eq!(
            found.len(),
            expected.len(),
            "{ray:?}: {found:?} for {expected:?}"
        );
        let speed = dot(d, d).sqrt();
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() * speed < 2.0e-5,
                "{ray:?}: {found} for {expected}"
            );
        }
        hits += expected.len();
        misses += usize::from(expected.is_empty());
    }
    assert!(hits > 2500 && misses > 200, "{hits} {misses}");
}

/// The same surface by a formula of its own and by the general search.
#[test]
fn analytic_and_implicit_agree() {
    fn check<A: Shape, B: Shape>(a: A, b: B, seed: u64)
    where
        Shapes<A>: Primitives + Send + Sync,
        Shapes<B>: Primitives + Send + Sync,
    {
        let a = Shapes::new([a]).unwrap();
        let b = Shapes::new([b]).unwrap();
        let (x, y) = (BruteForce::new(&a), BruteForce::new(&b));
        let mut random = Random(seed);
        let mut hits = 0;
        for _ in 0..3000 {
            let ray = random.ray();
            let (x, y) = (x.all_hits(&ray), y.all_hits(&ray));
            assert_eq!(x.len(), y.len(), "{ray:?}");
            for (x, y) in x.iter().zip(&y) {
                assert!((x.t - y.t).abs() <= 3.0e-7 * x.t, "{ray:?}");
                let (p, q) = (a.surface(&ray, x), b.surface(&ray, y));
                assert!((p.position - q.position).length() < 1.0e-6);
                assert!(p.normal.dot(q.normal) > 0.999_99, "{p:?} {q:?}");
                assert_eq!(p.front, q.front);
                hits += 1;
            }
        }
        assert!(hits > 2000, "{hits}");
    }
    check(Sphere::new([0.0; 3], 1.0), ImplicitSurface(Ball), 11);
    check(Sphere::new([0.0; 3], 1.0), ImplicitSurface(Distance), 12);
    check(ring(), ImplicitSurface(Ring), 13);
}

#[test]
fn bad_functions_end() {
    #[derive(Clone, Copy)]
    struct Bad(fn([f64; 3]) -> f64, f64);
    impl Implicit for Bad {
        fn bounds(&self) -> Aabb {
            AROUND
        }
        fn value(&self, p: [f64; 3]) -> f64 {
            (self.0)(p)
        }
        fn enclose(&self, part: &Segment) -> Enclosure {
            part.lipschitz(self.value(part.middle()), self.1)
        }
    }
    let count = |f: fn([f64; 3]) -> f64, constant: f64| {
        let judge = BruteForce::new(Shapes::new([ImplicitSurface(Bad(f, constant))]).unwrap());
        let ray = Ray::new([-3.0, 0.1, 0.2], [1.0, 0.01, 0.02]);
        judge.all_hits(&ray).len()
    };
    // Zero on a whole segment is one root.
    assert_eq!(count(|_| 0.0, 1.0), 1);
    assert_eq!(count(|_| 0.0, 0.0), 1);
    assert_eq!(count(|p| (p[0].abs() - 0.5).max(0.0), 1.0), 1);
    for constant in [0.0, 1.0e-3, -1.0, 1.0e30, f64::INFINITY, f64::NAN] {
        assert_eq!(count(|_| f64::NAN, constant), 0);
        assert_eq!(count(|_| f64::INFINITY, constant), 0);
        // Whatever is found or not, it ends.
        count(|p| p[0].sin() * 1.0e300, constant);
        count(|p| if p[0] > 0.0 { f64::NAN } else { p[0] + 0.5 }, constant);
        count(|p| (p[0] * 1.0e9).sin(), constant);
    }
}

/// Far origins and small spheres: what is decided is right to the accuracy of doubles, not of floats.
#[test]
fn small_spheres_from_far_away() {
    let mut random = Random(60);
    let (mut hits, mut misses) = (0, 0);
    for _ in 0..20_000 {
        let origin = random.unit() * 10.0_f32.powi((random.bits() % 7) as i32);
        let sphere = Sphere::new(
            random.point(1.0),
            10.0_f32.powi(-((random.bits() % 4) as i32)),
        );
        let judge = BruteForce::new(Shapes::new([sphere]).unwrap());
        let to = sphere.centre + random.unit() * (sphere.radius * 2.0 * random.signed());
        let ray = Ray::new(origin, to - origin);
        // The distance of the centre from the line, by the cross product.
        let o = origin.to_array().map(f64::from);
        let c = sphere.centre.to_array().map(f64::from);
        let d = ray.direction.to_array().map(f64::from);
        let l = [c[0] - o[0], c[1] - o[1], c[2] - o[2]];
        let cross = [
            l[1] * d[2] - l[2] * d[1],
            l[2] * d[0] - l[0] * d[2],
            l[0] * d[1] - l[1] * d[0],
        ];
        let r = f64::from(sphere.radius);
        let distance = (dot(cross, cross) / dot(d, d)).sqrt();
        if dot(l, l).sqrt() < r * 1.001 || (distance - r).abs() < 1.0e-9 * r {
            continue;
        }
        let found = judge.occluded(&ray);
        let ahead = dot(l, d) > 0.0;
        assert_eq!(found, distance < r && ahead, "{sphere:?} {ray:?}");
        hits += usize::from(found);
        misses += usize::from(!found);
    }
    assert!(hits > 5000 && misses > 3000, "{hits} {misses}");
}

/// The search takes about as many pieces as its module says.
#[test]
fn searches_are_short() {
    struct Counted<F>(F, AtomicUsize);
    impl<F: Implicit> Implicit for Counted<F> {
        fn bounds(&self) -> Aabb {
            self.0.bounds()
        }
        fn value(&self, p: [f64; 3]) -> f64 {
            self.0.value(p)
        }
        fn enclose(&self, part: &Segment) -> Enclosure {
            self.1.fetch_add(1, Relaxed);
            self.0.enclose(part)
        }
    }
    /// The mean and the largest number of pieces of random rays, and the largest of grazing ones.
    fn pieces<F: Implicit + Send + Sync>(f: F) -> [usize; 3] {
        let set = Shapes::new([ImplicitSurface(Counted(f, AtomicUsize::new(0)))]).unwrap();
        let judge = BruteForce::new(&set);
        let count = |ray: &Ray| {
            let counter = &set.as_slice()[0].0.1;
            counter.store(0, Relaxed);
            judge.all_hits(ray);
            counter.load(Relaxed)
        };
        let mut random = Random(70);
        let counts: Vec<usize> = (0..2000).map(|_| count(&random.ray())).collect();
        let hardest = rays_at(&set, 71, 1000).iter().map(count).max();
        [
            counts.iter().sum::<usize>() / counts.len(),
            counts.into_iter().max().unwrap_or(0),
            hardest.unwrap_or(0),
        ]
    }
    for (name, pieces, limits) in [
        ("formula", pieces(Ball), [20, 60, 200]),
        ("gyroid", pieces(Gyroid), [60, 200, 400]),
        ("touching", pieces(Touching), [200, 2000, 20000]),
        ("constant", pieces(Distance), [300, 3000, 60000]),
    ] {
        println!("{name}: {pieces:?}");
        assert!(
            pieces.iter().zip(limits).all(|(p, l)| *p <= l),
            "{name}: {pieces:?}"
        );
    }
}
