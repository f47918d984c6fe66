//! Shapes and implicit surfaces against dense double-precision sampling, against each other, and in structures.

use boxwood::{
    Aabb, BinnedSah, BruteForce, Bvh, Chain, Cuboid, Cylinder, Disc, Enclosure, Formula, Implicit,
    ImplicitSurface, Intersect, Median, OrientedCuboid, Plane, Primitives, Ray, Real, Segment,
    Shape, Shapes, Sphere, Surfaces, Torus, TriangleMesh, Vec3,
};

/// SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// From −1 to 1.
    fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
    fn point(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed()) * size
    }
    fn unit(&mut self) -> Vec3 {
        loop {
            let p = self.point(1.0);
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalized();
            }
        }
    }
    /// From outside or inside the ball of radius 2, through the ball of radius 1.2, of any length of direction.
    fn ray(&mut self) -> Ray {
        let origin = self.unit() * (1.0 + 1.5 * self.signed()).abs() * 2.0;
        let direction = self.point(0.7) - origin;
        Ray::new(
            origin,
            direction * 10.0_f32.powi((self.bits() % 7) as i32 - 3),
        )
    }
}

fn at(ray: &Ray, t: f64) -> [f64; 3] {
    let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
    [0, 1, 2].map(|k| f64::from(o[k]) + t * f64::from(d[k]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// All roots from fine steps and bisection; `None` where the function comes nearer to zero than `doubt` without crossing.
fn sampled(
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
fn merged(roots: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::new();
    for t in roots {
        if kept.last().is_none_or(|&last| t - last > t.abs() * 5.0e-7) {
            kept.push(t);
        }
    }
    kept
}

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
        let hits = judge.all_hits(&ray);
        let found = merged(hits.iter().map(|hit| f64::from(hit.t)));
        let roots = merged(roots);
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

/// Random rays, and as many that pass a point of the surface nearly along it, off by 10⁻¹ to 10⁻⁸.
fn rays_at<S: Surfaces + Send + Sync>(primitives: &S, seed: u64, count: usize) -> Vec<Ray> {
    let mut random = Random(seed);
    let judge = BruteForce::new(primitives);
    let mut rays = Vec::new();
    while rays.len() < count {
        let ray = random.ray();
        rays.push(ray);
        let Some(hit) = judge.closest_hit(&ray) else {
            continue;
        };
        let Surface {
            position, normal, ..
        } = primitives.surface(&ray, &hit);
        let along = normal.cross(random.unit()).normalized();
        let off = 10.0_f32.powi(-1 - (random.bits() % 8) as i32) * random.signed();
        let speed = 10.0_f32.powi((random.bits() % 5) as i32 - 2);
        rays.push(Ray::new(
            position + normal * off - along * 3.0,
            along * speed,
        ));
    }
    rays
}
use boxwood::Surface;

fn ball(p: [f64; 3]) -> f64 {
    dot(p, p) - 1.0
}

/// A tilted ring.
fn ring() -> Torus {
    Torus::new([0.1, -0.2, 0.05], [1.0, 2.0, -0.5], 0.7, 0.25)
}

fn ring_function<T: Real>(p: [T; 3]) -> T {
    let torus = ring();
    let [x, y, z] = [0, 1, 2].map(|k| p[k] - f64::from(torus.centre.to_array()[k]));
    let [a, b, c] = torus.axis.to_array().map(f64::from);
    let l = (a * a + b * b + c * c).sqrt();
    let height = (x * a + y * b + z * c) / l;
    let (major, minor) = (f64::from(torus.major), f64::from(torus.minor));
    let square = x.square() + y.square() + z.square();
    (square + (major * major - minor * minor)).square()
        - (square - height.square()) * (4.0 * major * major)
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

const AROUND: Aabb = Aabb {
    lower: Vec3::splat(-1.25),
    upper: Vec3::splat(1.25),
};

macro_rules! formula {
    ($name:ident, $p:ident => $value:expr) => {
        #[derive(Clone, Copy)]
        struct $name;
        impl Formula for $name {
            fn bounds(&self) -> Aabb {
                AROUND
            }
            fn at<T: Real>(&self, $p: [T; 3]) -> T {
                $value
            }
        }
    };
}
formula!(Ball, p => p[0].square() + p[1].square() + p[2].square() - 1.0);
formula!(Ring, p => ring_function(p));
formula!(Gyroid, p => {
    let [x, y, z] = p.map(|x| x * 5.0);
    x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
});
formula!(Metaballs, p => {
    let [x, y, z] = p;
    let blob = |cx: f64, cy: f64, cz: f64| {
        (-((x - cx).square() + (y - cy).square() + (z - cz).square()) * 9.0).exp()
    };
    T::from(0.3) - blob(0.4, 0.0, 0.0) - blob(-0.3, 0.3, 0.1) - blob(0.0, -0.5, -0.2)
});
// Touches zero on the whole sphere and never crosses it.
formula!(Touching, p => (p[0].square() + p[1].square() + p[2].square() - 1.0).square());
// Goursat's quartic with four double points; several sheets.
formula!(Tangled, p => {
    let [x, y, z] = p.map(|x| x * 2.6);
    let quartic = |x: T| x.powi(4) - x.square() * 5.0;
    quartic(x) + quartic(y) + quartic(z) + 11.8
});

/// A ball by its distance alone.
#[derive(Clone, Copy)]
struct Distance;
impl Implicit for Distance {
    fn bounds(&self) -> Aabb {
        AROUND
    }
    fn value(&self, p: [f64; 3]) -> f64 {
        dot(p, p).sqrt() - 1.0
    }
    fn enclose(&self, part: &Segment) -> Enclosure {
        part.lipschitz(self.value(part.middle()), 1.0)
    }
}

/// The gyroid by constants: its gradient has no more than √3 · 2 · 5 and changes by no more than 3 · 25 (each second
/// derivative is at most 2 · 25, most are 25).
#[derive(Clone, Copy)]
struct SmoothGyroid;
impl Implicit for SmoothGyroid {
    fn bounds(&self) -> Aabb {
        AROUND
    }
    fn value(&self, p: [f64; 3]) -> f64 {
        Gyroid.at(p)
    }
    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        Gyroid.gradient(p)
    }
    fn enclose(&self, part: &Segment) -> Enclosure {
        let m = part.middle();
        part.smooth(self.value(m), self.gradient(m), 100.0)
    }
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

/// One of each, scattered.
struct Scene {
    spheres: Vec<Sphere>,
    planes: Vec<Plane>,
    discs: Vec<Disc>,
    cuboids: Vec<Cuboid>,
    oriented: Vec<OrientedCuboid>,
    cylinders: Vec<Cylinder>,
    tori: Vec<Torus>,
}

fn scene(random: &mut Random, count: usize, scale: f32, offset: Vec3) -> Scene {
    let mut s = Scene {
        spheres: vec![Sphere::new(offset, 0.0)],
        planes: vec![],
        discs: vec![],
        cuboids: vec![],
        oriented: vec![],
        cylinders: vec![],
        tori: vec![],
    };
    for _ in 0..count {
        let p = random.point(scale) + offset;
        let r = (random.signed().abs() + 0.01) * scale * 0.3;
        s.spheres.push(Sphere::new(p, r));
        let within = Aabb::new(p - Vec3::splat(r), p + Vec3::splat(r));
        s.planes.push(Plane::new(p, random.unit() * scale, within));
        s.discs
            .push(Disc::new(p, random.unit(), r).with_hole(0.4 * r));
        let corner = p + random.point(r);
        s.cuboids.push(Cuboid::new(p.min(corner), p.max(corner)));
        let (a, b) = (random.unit(), random.unit());
        let edges = [a * r, a.cross(b).normalized() * (0.5 * r), b * (0.3 * r)];
        s.oriented.push(OrientedCuboid::new(p, edges));
        let cylinder = Cylinder::new(p, p + random.unit() * r, 0.4 * r);
        s.cylinders.push(if random.signed() < 0.0 {
            cylinder
        } else {
            cylinder.open()
        });
        s.tori.push(Torus::new(p, random.unit(), r, 0.3 * r));
    }
    s
}

fn agree<P: Primitives + Sync + Send>(primitives: &P, rays: &[Ray]) -> usize {
    let judge = BruteForce::new(primitives);
    let structures = [
        Bvh::new(primitives, BinnedSah::default().build(primitives)),
        Bvh::new(primitives, Median::default().build(primitives)),
    ];
    let mut hits = 0;
    for ray in rays {
        let all = judge.all_hits(ray);
        assert_eq!(judge.closest_hit(ray), all.first().copied());
        assert_eq!(judge.occluded(ray), !all.is_empty());
        assert_eq!(judge.first_hits(ray, 3), all[..all.len().min(3)]);
        for bvh in &structures {
            assert_eq!(bvh.closest_hit(ray), judge.closest_hit(ray), "{ray:?}");
            assert_eq!(bvh.occluded(ray), judge.occluded(ray), "{ray:?}");
            assert_eq!(bvh.all_hits(ray), all, "{ray:?}");
            assert_eq!(bvh.first_hits(ray, 3), judge.first_hits(ray, 3), "{ray:?}");
        }
        // The interval is closed, and changes no hit in it.
        if let Some(hit) = all.get(all.len() / 2) {
            let cut = ray.from(hit.t).until(hit.t);
            let same: Vec<_> = all
                .iter()
                .filter(|other| other.t == hit.t)
                .copied()
                .collect();
            assert_eq!(judge.all_hits(&cut), same, "{cut:?}");
        }
        hits += all.len();
    }
    hits
}

#[test]
fn structures_agree_with_the_judge() {
    let far = Vec3::new(1.0e4, -3.0e3, 5.0e3);
    for (scale, offset) in [
        (1.0, Vec3::ZERO),
        (1.0e-3, Vec3::ZERO),
        (1.0e6, Vec3::ZERO),
        (1.0, far),
        (1.0e-30, Vec3::ZERO),
        (1.0e30, Vec3::ZERO),
    ] {
        let mut random = Random(20);
        let s = scene(&mut random, 40, scale, offset);
        let mut rays: Vec<Ray> = (0..150)
            .map(|_| {
                let origin = random.point(2.0 * scale) + offset;
                let to = random.point(scale) + offset;
                Ray::new(
                    origin,
                    (to - origin) * 10.0_f32.powi((random.bits() % 5) as i32 - 2),
                )
            })
            .collect();
        // Along the axes, through corners and centres.
        for (k, sphere) in s.spheres.iter().enumerate() {
            let mut d = [0.0, -0.0, 0.0];
            d[k % 3] = if k % 2 == 0 { scale } else { -scale };
            rays.push(Ray::new(sphere.centre - Vec3::from(d) * 2.0, d));
            rays.push(Ray::new(s.cuboids[k % 40].lower, d));
        }
        let nan = f32::NAN;
        rays.push(Ray::new([nan; 3], [scale, 0.0, 0.0]));
        rays.push(Ray::new(offset, [0.0; 3]));
        rays.push(Ray::new(offset, [scale, 0.0, 0.0]).until(nan));
        let spheres = Shapes::new(s.spheres).unwrap();
        let planes = Shapes::new(s.planes).unwrap();
        let discs = Shapes::new(s.discs).unwrap();
        let cuboids = Shapes::new(s.cuboids).unwrap();
        let oriented = Shapes::new(s.oriented).unwrap();
        let cylinders = Shapes::new(s.cylinders).unwrap();
        let tori = Shapes::new(s.tori).unwrap();
        let hits = [
            agree(&spheres, &rays),
            agree(&planes, &rays),
            agree(&discs, &rays),
            agree(&cuboids, &rays),
            agree(&oriented, &rays),
            agree(&cylinders, &rays),
            agree(&tori, &rays),
        ];
        assert!(hits.iter().all(|&n| n > 20), "{hits:?} at {scale}");
        let corners = [[0.0; 3], [scale, 0.0, 0.0], [0.0, scale, 0.0]];
        let mesh = TriangleMesh::new(corners.map(|p| Vec3::from(p) + offset), [[0_u32, 1, 2]]);
        let shapes = Chain::new(Chain::new(&spheres, &tori).unwrap(), &cylinders).unwrap();
        let mixed = Chain::new(mesh.unwrap(), shapes).unwrap();
        let each = hits[0] + hits[6] + hits[5];
        let all = agree(&mixed, &rays);
        assert!((each..each + rays.len()).contains(&all), "{all} for {each}");
    }
    let gyroid = Shapes::new([ImplicitSurface(Gyroid)]).unwrap();
    let mut random = Random(21);
    let rays: Vec<Ray> = (0..150).map(|_| random.ray()).collect();
    let implicit = Chain::new(&gyroid, Shapes::new([ImplicitSurface(Tangled)]).unwrap()).unwrap();
    assert!(agree(&implicit, &rays) > 300);
}

/// Rays that leave a convex body from its surface never meet it again outwards, and once inwards.
#[test]
fn leaving_a_surface_never_meets_it_again() {
    fn check<S: Shape + Clone>(shapes: &[S], seed: u64, scale: f32, solid: bool, name: &str)
    where
        Shapes<S>: Primitives + Send + Sync,
    {
        let mut random = Random(seed);
        let mut left = [0; 2];
        for shape in shapes {
            let set = Shapes::new([shape.clone()]).unwrap();
            let judge = BruteForce::new(&set);
            let b = Intersect::bounds(&judge);
            if b.is_empty() {
                continue;
            }
            for _ in 0..40 {
                let size = b.size().max_element();
                let origin = b.centroid() + random.unit() * (2.0 * size);
                let to = b.centroid() + random.point(0.3 * size);
                let ray = Ray::new(
                    origin,
                    (to - origin) * 10.0_f32.powi((random.bits() % 5) as i32 - 2),
                );
                for hit in judge.all_hits(&ray) {
                    let surface = set.surface(&ray, &hit);
                    let n = surface.normal;
                    assert!((n.length() - 1.0).abs() < 1.0e-6);
                    assert_eq!(surface.uv, [hit.u, hit.v]);
                    assert!(
                        (surface.position - ray.at(hit.t)).length()
                            <= 4.0e-6 * (size + origin.length())
                    );
                    assert!(surface.error <= 4.0e-6 * (scale + b.scale()), "{surface:?}");
                    let along = n.cross(random.unit()).normalized();
                    for lean in [1.0, 0.1, 1.0e-2, 1.0e-3, 1.0e-5, -1.0e-5, -1.0e-2, -1.0] {
                        let direction = (along + n * lean) * random.signed().abs().max(1.0e-3);
                        let next = Ray::new(surface.offset_origin(direction), direction);
                        let again = judge.all_hits(&next);
                        let expected = usize::from(solid && lean < 0.0);
                        // An edge is nearer than the step now and then: then a ray inwards leaves at once or misses.
                        let near_edge = expected == 1 && again.len() != 1 && {
                            let far = judge.all_hits(&Ray::new(
                                surface.position - n * (64.0 * surface.error),
                                -along,
                            ));
                            far.first().is_none_or(|h| h.t < 1.0e-3 * size) || again.is_empty()
                        };
                        if !near_edge {
                            assert_eq!(
                                again.len(),
                                expected,
                                "{name} {scale} lean {lean}: {surface:?} {next:?} {again:?}"
                            );
                            left[expected] += 1;
                        }
                    }
                }
            }
        }
        assert!(
            left[0] > 200 && (!solid || left[1] > 200),
            "{name} {left:?}"
        );
    }
    for scale in [1.0e-3, 1.0, 1.0e3, 1.0e6] {
        for offset in [Vec3::ZERO, Vec3::new(10.0, -3.0, 5.0) * scale] {
            let s = scene(&mut Random(30), 12, scale, offset);
            check(&s.spheres, 31, scale, true, "sphere");
            check(&s.planes, 32, scale, false, "plane");
            check(&s.discs, 33, scale, false, "disc");
            check(&s.cuboids, 34, scale, true, "cuboid");
            check(&s.oriented, 35, scale, true, "oriented cuboid");
            let closed: Vec<_> = s
                .cylinders
                .iter()
                .map(|c| Cylinder { caps: true, ..*c })
                .collect();
            check(&closed, 36, scale, true, "cylinder");
        }
    }
}

/// What bends back is met again, but only where it does: each ray that leaves sees what dense sampling sees from there,
/// and the next hit is never the place that it left.
#[test]
fn leaving_a_torus_or_an_implicit_surface() {
    fn check<S: Shape>(shape: S, f: impl Fn([f64; 3]) -> f64, seed: u64, doubt: f64)
    where
        Shapes<S>: Primitives + Surfaces + Send + Sync,
    {
        let set = Shapes::new([shape]).unwrap();
        let judge = BruteForce::new(&set);
        let mut random = Random(seed);
        let mut left = 0;
        for _ in 0..400 {
            let ray = random.ray();
            for hit in judge.all_hits(&ray) {
                let surface = set.surface(&ray, &hit);
                let n = surface.normal;
                let along = n.cross(random.unit()).normalized();
                for lean in [1.0, 0.1, 1.0e-2, -1.0e-2, -0.1, -1.0] {
                    let direction = along + n * lean;
                    let next = Ray::new(surface.offset_origin(direction), direction);
                    let side = f(at(&next, 0.0));
                    assert!(side * lean > 0.0, "{surface:?} {lean} {side}");
                    let Some((_, to)) = Intersect::bounds(&judge).intersect(&next) else {
                        continue;
                    };
                    let to = f64::from(to);
                    let Some(roots) = sampled(|t| f(at(&next, t)), 0.0, to * 0.999, 4000, doubt)
                    else {
                        continue;
                    };
                    let found = judge.all_hits(&next.until((to * 0.999) as f32));
                    let found = merged(found.iter().map(|h| f64::from(h.t)));
                    assert_eq!(found.len(), merged(roots).len(), "{next:?} {found:?}");
                    left += 1;
                }
            }
        }
        assert!(left > 1000, "{left}");
    }
    check(ring(), ring_function::<f64>, 40, 1.0e-13);
    check(ImplicitSurface(Ring), ring_function::<f64>, 41, 1.0e-9);
    check(ImplicitSurface(Gyroid), |p| Gyroid.at(p), 42, 1.0e-9);
    check(
        ImplicitSurface(Distance),
        |p| Distance.value(p),
        43,
        1.0e-10,
    );
}

/// Boxes are tight, and hold every hit without any slack but that of `t`.
#[test]
fn boxes_are_tight() {
    fn check<S: Shape>(shape: S)
    where
        Shapes<S>: Primitives + Surfaces + Send + Sync,
    {
        let set = Shapes::new([shape]).unwrap();
        let judge = BruteForce::new(&set);
        let b = Intersect::bounds(&judge);
        let mut random = Random(50);
        let mut seen = Aabb::EMPTY;
        for _ in 0..60_000 {
            let origin = b.centroid() + random.unit() * (2.0 * b.scale());
            let ray = Ray::new(
                origin,
                b.centroid() + random.point(b.size().max_element() * 0.5) - origin,
            );
            for hit in judge.all_hits(&ray) {
                seen = seen.union(Aabb::of([set.surface(&ray, &hit).position]));
            }
        }
        // A normal of floats is a unit vector to 1e-7 only.
        let (lower, upper) = (seen.lower - b.lower, b.upper - seen.upper);
        let least = lower.min(upper);
        let most = lower.max(upper).max_element();
        let room = 1.0e-6 * b.scale();
        assert!(
            least.x.min(least.y).min(least.z) >= -room,
            "{seen:?} in {b:?}"
        );
        assert!(most < 0.03 * b.size().max_element(), "{seen:?} in {b:?}");
    }
    check(Sphere::new([0.3, 0.1, 0.0], 0.7));
    check(Disc::new([0.3, 0.1, 0.0], [1.0, 2.0, -1.0], 0.7));
    check(Cylinder::new([0.3, 0.1, 0.0], [1.0, 2.0, -1.0], 0.7));
    check(Plane::new([0.3, 0.1, 0.0], [1.0, 2.0, -3.0], AROUND));
    check(ring());
    check(OrientedCuboid::new(
        [0.1; 3],
        [[1.0, 0.2, 0.0], [0.0, 1.0, 0.3], [0.0, -0.3, 1.0]],
    ));
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
