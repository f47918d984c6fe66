//! A ray that leaves a surface does not meet it where it left.

use crate::functions::{Distance, Gyroid, Ring, ring, ring_function};
use crate::generators::{Random, scene};
use crate::sampling::{at, merged, sampled};
use boxwood::{
    BruteForce, Cylinder, Formula, Implicit, ImplicitSurface, Intersect, Primitives, Ray, Shape,
    Shapes, Surfaces, Vec3,
};

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
                    assert!(side * f64::from(lean) > 0.0, "{surface:?} {lean} {side}");
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
