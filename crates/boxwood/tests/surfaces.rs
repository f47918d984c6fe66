//! From a hit to a surface: normal, side, place, and an origin for the next ray that does not meet the surface again.

use boxwood::{BruteForce, Intersect, MollerTrumbore, Ray, Surfaces, TriangleMesh, Vec3};
use boxwood_testkit::{Random, effort};
use std::sync::Arc;

#[test]
fn a_hit_knows_its_surface() {
    let corners = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let mesh = Arc::new(TriangleMesh::new(corners, [[0_u8, 1, 2]]).expect("a good mesh"));
    let judge = BruteForce::new(&mesh);
    for (z, front) in [(3.0, true), (-1.0, false)] {
        let ray = Ray::new([0.25, 0.5, z], [0.0, 0.0, 1.0 - z]);
        let hit = judge.closest_hit(&ray).expect("a hit");
        let surface = mesh.surface(&ray, &hit);
        assert_eq!(surface.normal, Vec3::new(0.0, 0.0, 1.0));
        assert_eq!(surface.front, front);
        assert_eq!(surface.facing().z, if front { 1.0 } else { -1.0 });
        assert_eq!(surface.uv, [0.25, 0.5]);
        assert_eq!(surface.position, Vec3::new(0.25, 0.5, 1.0));
        assert!(0.0 < surface.error && surface.error < 1.0e-5);
        assert!(surface.offset_origin([0.0, 0.3, 0.1]).z > 1.0);
        assert!(surface.offset_origin([0.0, 0.3, -0.1]).z < 1.0);
        assert_eq!(MollerTrumbore(&*mesh).surface(&ray, &hit), surface);
    }
}

/// A triangle of any shape, from well-formed to a sliver of width 10⁻⁶.
fn triangle(random: &mut Random) -> [Vec3; 3] {
    let (a, along, aside) = (random.in_cube(), random.direction(), random.direction());
    let width = 10.0_f32.powi(-(random.below(7) as i32));
    let part = random.between(-0.5, 1.5);
    [a, a + along, a + along * part + aside * width]
}

/// Random triangles at every scale and offset, met by a random ray; `check` gets mesh, ray and the surface there.
fn each_surface(
    check: impl Fn(&TriangleMesh, &Ray, boxwood::Hit, &boxwood::Surface, &mut Random, &str),
) {
    let mut met = 0;
    for scale in [1.0e-3_f32, 1.0, 1.0e6] {
        for offset in [0.0, 1.0, 1.0e3, 1.0e6_f32] {
            let seed = u64::from(scale.to_bits()) ^ u64::from(offset.to_bits()) << 20;
            let mut random = Random::new(seed);
            for i in 0..effort(1_500) {
                let moved = random.direction() * offset;
                let corners = triangle(&mut random).map(|p| (p + moved) * scale);
                let mesh = TriangleMesh::new(corners, [[0_u8, 1, 2]]).expect("a good mesh");
                let w = random.weights();
                let at = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
                let ray = Ray::new(at - random.direction() * (3.0 * scale), at - corners[0]);
                let ray = Ray::new(ray.origin, at - ray.origin);
                let Some(hit) = BruteForce::new(&mesh).closest_hit(&ray) else {
                    continue;
                };
                met += 1;
                let surface = mesh.surface(&ray, &hit);
                let case = format!("scale {scale:e}, offset {offset:e}, seed {seed}, {i}: {ray:?}");
                check(&mesh, &ray, hit, &surface, &mut random, &case);
            }
        }
    }
    assert!(met > 4_000, "only {met} rays hit");
}

#[test]
fn positions_are_within_their_error() {
    each_surface(|mesh, _, hit, surface, _, case| {
        let corners = mesh.triangle(0).map(|p| p.to_array().map(f64::from));
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        for (k, position) in surface.position.to_array().into_iter().enumerate() {
            let exact = corners[0][k] * (1.0 - u - v) + corners[1][k] * u + corners[2][k] * v;
            let off = (f64::from(position) - exact).abs();
            assert!(
                off <= f64::from(surface.error),
                "{off:e} > {:e}, {case}",
                surface.error
            );
        }
        // A bound that is no larger than it has to be: 64 roundings of the largest number in play.
        let largest = mesh
            .triangle(0)
            .iter()
            .fold(0.0_f32, |m, p| m.max(p.abs().max_element()));
        assert!(surface.error <= 128.0 * 6.0e-8 * largest, "{case}");
        let length = f64::from(surface.normal.length());
        assert!((length - 1.0).abs() < 1.0e-6, "{case}");
    });
}

#[test]
fn the_next_ray_leaves_the_surface() {
    each_surface(|mesh, _, _, surface, random, case| {
        let judge = BruteForce::new(mesh);
        let n = surface.normal;
        let aside = n.cross(random.direction()).normalized();
        let corners = mesh.triangle(0);
        let away = [
            n,
            -n,
            random.direction(),
            random.direction(),
            // Grazing: in the plane up to rounding, on either side, and towards a corner.
            aside,
            -aside,
            aside + n * 1.0e-7,
            aside - n * 1.0e-7,
            aside - n * 1.0e-3,
            corners[random.below(3)] - surface.position,
        ];
        for direction in away {
            let direction = direction * 2.0_f32.powi(random.below(40) as i32 - 20);
            let next = Ray::new(surface.offset_origin(direction), direction);
            let hit = judge.closest_hit(&next);
            assert_eq!(
                hit, None,
                "{case}; leaving along {direction:?} from {surface:?}"
            );
        }
    });
}
