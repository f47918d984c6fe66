//! The public interface from outside: foreign vectors, ownership, filters, masks, moments, threads.

use boxwood::{
    BinnedSah, BruteForce, Bvh, Closest, Filter, Hit, Intersect, Median, Ray, Seen, StructureKind,
    TraversalStats, Traverse, TriangleMesh, Vec3,
};
use boxwood_testkit::Spheres;
use std::ops::ControlFlow::{Break, Continue};
use std::sync::Arc;

/// Three unit squares at z = 1, 2, 3: triangles 0 to 5.
fn squares() -> TriangleMesh {
    let corner = |z: f32| {
        [
            [0.0_f32, 0.0, z],
            [1.0, 0.0, z],
            [1.0, 1.0, z],
            [0.0, 1.0, z],
        ]
    };
    let positions = [1.0, 2.0, 3.0].into_iter().flat_map(corner);
    let triangles =
        (0..3).flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]);
    TriangleMesh::new::<_, u32>(positions, triangles).expect("a good mesh")
}

fn up() -> Ray {
    Ray::new([0.2, 0.1, 0.0], [0.0, 0.0, 1.0])
}

fn ids(hits: &[Hit]) -> Vec<u32> {
    hits.iter().map(|h| h.primitive).collect()
}

#[test]
fn any_vector_type_will_do() {
    let glam = [glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y];
    let nalgebra = glam.map(|p| nalgebra::Vector3::new(p.x, p.y, p.z));
    assert!(TriangleMesh::new(glam, [[0_u32, 1, 2]]).is_ok());
    assert!(TriangleMesh::new(nalgebra, [[0_u32, 1, 2]]).is_ok());
    let ray = Ray::new(
        glam::Vec3::new(0.2, 0.2, -1.0),
        nalgebra::Vector3::new(0.0, 0.0, 1.0),
    );
    assert_eq!(ray, Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]));
    let point: glam::Vec3 = ray.origin.to_array().into();
    assert_eq!(point.z, -1.0);
}

#[test]
fn meshes_come_from_many_kinds_of_lists() {
    let triangle = |mesh: Result<TriangleMesh, _>| {
        let mesh = mesh.expect("a good mesh");
        assert_eq!(mesh.triangles(), [[0, 1, 2]]);
        mesh.triangle(0)
    };
    let flat = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let double = points.map(|p| p.map(f64::from));
    let expected = points.map(Vec3::from);
    assert_eq!(
        triangle(TriangleMesh::from_flat(&flat, &[0_u8, 1, 2])),
        expected
    );
    assert_eq!(
        triangle(TriangleMesh::from_flat(&flat, &[0_u16, 1, 2])),
        expected
    );
    assert_eq!(
        triangle(TriangleMesh::from_flat(&flat, &[0_u32, 1, 2])),
        expected
    );
    assert_eq!(
        triangle(TriangleMesh::new(points, [[0_u8, 1, 2]])),
        expected
    );
    assert_eq!(
        triangle(TriangleMesh::new(points, [[0_u16, 1, 2]])),
        expected
    );
    assert_eq!(
        triangle(TriangleMesh::from_f64(double, [[0_u16, 1, 2]])),
        expected
    );
    // Rounded to the nearest float, not cut off.
    let third = TriangleMesh::from_f64([[1.0 / 3.0; 3]], [[0_u8; 3]]).expect("a good mesh");
    assert_eq!(third.positions()[0].x, 1.0 / 3.0);
}

#[test]
fn structures_own_borrow_or_share() {
    let mesh = Arc::new(squares());
    let tree = Median::default().build(&mesh);
    let borrowed: Box<dyn Intersect + '_> = Box::new(Bvh::new(&*mesh, tree.clone()));
    let shared: Box<dyn Intersect> = Box::new(Bvh::new(Arc::clone(&mesh), tree.clone()));
    let owned: Box<dyn Intersect> = Box::new(Bvh::new(squares(), tree.clone()));
    let named: Box<dyn Intersect> = StructureKind::default().build(Arc::clone(&mesh));
    let checked = Bvh::checked(&mesh, tree).expect("a whole tree");
    let expected = borrowed.closest_hit(&up());
    assert_eq!(expected.map(|h| (h.t, h.primitive)), Some((1.0, 0)));
    for other in [&*shared, &*owned, &*named, &checked] {
        assert_eq!(other.closest_hit(&up()), expected);
    }
}

#[test]
fn a_filter_wraps_a_query() {
    let mesh = squares();
    let bvh = Bvh::new(&mesh, BinnedSah::default().build(&mesh));
    let mut query = Filter {
        inner: Closest::new(&up()),
        keep: |hit: &Hit| hit.primitive >= 2,
    };
    let mut stats = TraversalStats::default();
    bvh.traverse(&up(), &mut query, &mut stats);
    assert_eq!(query.inner.hit().map(|h| h.t), Some(2.0));
    assert!(stats.primitives > 0);

    // The same without knowing the type.
    let any: &dyn Intersect = &bvh;
    let hit = any.closest_hit_where(&up(), &mut |hit| hit.primitive >= 2);
    assert_eq!(hit.map(|h| h.t), Some(2.0));
    assert!(any.occluded_where(&up(), &mut |hit| hit.primitive == 4));
    assert!(!any.occluded_where(&up(), &mut |hit| hit.primitive == 5));
    let mut first = None;
    any.visit(&up(), &mut |hit| {
        if hit.primitive < 2 {
            return Continue(2.5);
        }
        first = Some(hit);
        Break(())
    });
    assert_eq!(first.map(|h| h.t), Some(2.0));
}

#[test]
fn hits_come_sorted_and_as_many_as_asked() {
    let bvh = StructureKind::default().build(squares());
    assert_eq!(ids(&bvh.all_hits(&up())), [0, 2, 4]);
    assert_eq!(ids(&bvh.all_hits(&up().from(2.0))), [2, 4]);
    assert_eq!(ids(&bvh.all_hits(&up().until(2.0))), [0, 2]);
    for k in 0..5 {
        assert_eq!(ids(&bvh.first_hits(&up(), k)), [0, 2, 4][..k.min(3)]);
    }
    // The squares' diagonals belong to two triangles each.
    let diagonal = Ray::new([0.5, 0.5, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(ids(&bvh.all_hits(&diagonal)), [0, 1, 2, 3, 4, 5]);
    assert_eq!(bvh.closest_hit(&diagonal).map(|h| h.primitive), Some(0));
}

/// Of equal hits of one primitive the first counts, in every query.
#[test]
fn a_touched_sphere_is_hit_once() {
    let spheres = Spheres(vec![(Vec3::new(0.0, 0.0, 5.0), 1.0)]);
    let judge = BruteForce::new(&spheres);
    let touching = Ray::new([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let hits = judge.all_hits(&touching);
    assert_eq!(
        hits.iter().map(|h| (h.t, h.u)).collect::<Vec<_>>(),
        [(5.0, 0.0)]
    );
    assert_eq!(judge.closest_hit(&touching), Some(hits[0]));
    assert_eq!(judge.first_hits(&touching, 9), hits);
    let through = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(judge.all_hits(&through).len(), 2);
}

/// Sphere `i` is seen by bit `i % 3`, and stands one unit further along x at moment 1.
#[test]
fn masks_and_moments_reach_the_primitives() {
    let spheres = Spheres(
        (1..4)
            .map(|i| (Vec3::new(0.0, 0.0, 4.0 * i as f32), 1.0))
            .collect(),
    );
    let bvh = Bvh::new(
        &spheres,
        Median {
            max_leaf: 1,
            ..Default::default()
        }
        .build(&spheres),
    );
    let ask = |ray: Ray, mask, time| {
        let inner = Closest::new(&ray);
        let mut query = Seen { inner, mask, time };
        bvh.traverse(&ray, &mut query, &mut ());
        query.inner.hit().map(|h| (h.t, h.primitive))
    };
    let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(ask(ray, u32::MAX, 0.0), Some((3.0, 0)));
    assert_eq!(ask(ray, 0b110, 0.0), Some((7.0, 1)));
    assert_eq!(ask(ray, 0b100, 0.0), Some((11.0, 2)));
    assert_eq!(ask(ray, 0, 0.0), None);
    let beside = Ray::new([1.5, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(ask(beside, u32::MAX, 0.0), None);
    assert!(ask(beside, u32::MAX, 1.0).is_some_and(|(t, id)| t > 3.0 && id == 0));
}

/// A hit lies somewhere: an infinite `t_max` is the largest float, in every query.
#[test]
fn nothing_is_hit_at_infinity() {
    let far = 1.0e4;
    let triangle = [[-far, -far, far], [far, -far, far], [0.0, far, far]];
    let mesh = TriangleMesh::new(triangle, [[0_u8, 1, 2]]).expect("a good mesh");
    for entry in boxwood_testkit::structures::all() {
        let name = entry.name();
        let structure = entry.build(&mesh);
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0e-38]);
        assert_eq!(structure.closest_hit(&ray), None, "{name}");
        assert!(structure.all_hits(&ray).is_empty(), "{name}");
        assert!(!structure.occluded_where(&ray, &mut |_| true), "{name}");
        assert!(
            structure.occluded(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])),
            "{name}"
        );
    }
}

/// Everything can be shared between threads.
#[test]
fn structures_are_send_and_sync() {
    fn check<T: Send + Sync>() {}
    check::<Bvh<Arc<TriangleMesh>>>();
    check::<BruteForce<&TriangleMesh>>();
    check::<Box<dyn Intersect>>();
}
