//! Structures over shapes answer as the judge does, and boxes hold their shapes.

use crate::functions::{AROUND, Gyroid, Tangled, ring};
use crate::generators::{Random, scene};
use boxwood::{
    Aabb, BinnedSah, BruteForce, Bvh, Chain, Cylinder, Disc, ImplicitSurface, Intersect, Median,
    OrientedCuboid, Plane, Primitives, Ray, Shape, Shapes, Sphere, Surfaces, TriangleMesh, Vec3,
};

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
