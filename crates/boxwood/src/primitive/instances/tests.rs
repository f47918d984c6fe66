use super::*;
use crate::{BruteForce, Intersect, Ray, TriangleMesh, Vec3};
use alloc::string::{String, ToString};
use alloc::sync::Arc;
use alloc::vec::Vec;

fn object() -> Object {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]]).expect("a good mesh");
    Object::new(&mesh, Arc::new(BruteForce::new(mesh.clone())))
}

fn made_of(instances: Instances) -> Object {
    let instances = Arc::new(instances);
    let structure = Arc::new(BruteForce::new(instances.clone()));
    Object::of_instances(instances, structure).expect("not too deep")
}

/// Twice what is inside, over and over.
fn doubled(times: usize) -> Object {
    (0..times).fold(object(), |inner, _| {
        let two = [0.0, 2.0].map(|x| Instance::new(0, Affine::translation([x, 0.0, 0.0])));
        made_of(Instances::new([inner], two).expect("good instances"))
    })
}

#[test]
fn bad_instances_are_refused_in_a_sentence() {
    let refused = |object: Object, instance: Instance| -> String {
        let good = Instance::new(0, Affine::IDENTITY);
        Instances::new([object], [good, instance])
            .expect_err("refused")
            .to_string()
    };
    let scaled = |by: [f32; 3]| Instance::new(0, Affine::scale(by));
    assert_eq!(
        refused(object(), Instance::new(3, Affine::IDENTITY)),
        "instance 1 places object 3, but there are 1"
    );
    assert_eq!(
        refused(object(), scaled([1.0, f32::NAN, 1.0])),
        "the transform of instance 1 is not finite"
    );
    let lost = Affine::translation([0.0, f32::INFINITY, 0.0]);
    assert_eq!(
        refused(object(), Instance::new(0, lost)),
        "the transform of instance 1 is not finite"
    );
    let flat = "the transform of instance 1 flattens space";
    assert_eq!(refused(object(), scaled([1.0, 0.0, 1.0])), flat);
    assert_eq!(refused(object(), scaled([1.0, 1.0e-42, 1.0])), flat);
    let mut thirds = Affine::IDENTITY;
    thirds.rows[0] = [0.1, 0.2, 0.3, 0.0];
    thirds.rows[1] = [0.2, 0.4, 0.6, 1.0];
    assert_eq!(refused(object(), Instance::new(0, thirds)), flat);
    assert_eq!(
        refused(object(), scaled([3.0e38; 3])),
        "instance 1 reaches beyond the floats"
    );
    assert_eq!(
        refused(doubled(31), Instance::new(0, Affine::IDENTITY)),
        "there are 4294967296 placements, but at most 4294967295 can be numbered"
    );
    let inner = Arc::new((0..31).fold(
        Instances::new([object()], []).expect("nothing is good"),
        |inner, _| {
            let one = Instance::new(0, Affine::IDENTITY);
            Instances::new([made_of(inner)], [one]).expect("not too deep")
        },
    ));
    assert_eq!(inner.depth(), 32);
    let structure = Arc::new(BruteForce::new(inner.clone()));
    assert_eq!(
        Object::of_instances(inner, structure)
            .expect_err("refused")
            .to_string(),
        "objects are nested more than 32 deep"
    );
}

#[test]
fn every_placement_has_a_number_and_every_number_a_path() {
    let object = doubled(3);
    let places = [0.0, 100.0].map(|x| Instance::new(0, Affine::translation([x, 0.0, 0.0])));
    let set = Instances::new([object.numbered(7)], places).expect("good instances");
    assert_eq!((set.placements(), set.depth()), (16, 4));
    for number in 0..16_u32 {
        let digits = [3, 2, 1, 0].map(|bit| (number >> bit & 1) as usize);
        assert_eq!(set.path(number).collect::<Vec<_>>(), digits);
        let x = 100.0 * digits[0] as f32 + 2.0 * digits[1..].iter().sum::<usize>() as f32;
        let place = set.transform_of(number).expect("a placement");
        assert_eq!(place, Affine::translation([x, 0.0, 0.0]));
        let ray = Ray::new([x + 0.25, 0.25, 3.0], [0.0, 0.0, -1.0]);
        assert_eq!(
            set.ray_within(&ray, number).origin,
            Vec3::new(0.25, 0.25, 3.0)
        );
        let hits = BruteForce::new(&set).all_hits(&ray);
        assert!(hits.iter().any(|hit| hit.instance == number));
    }
    assert_eq!(set.path(16).count(), 0);
    assert!(set.object_of(16).is_none() && set.transform_of(16).is_none());
}

#[test]
fn masks_hide_instances() {
    let instances = [0b01, 0b10, 0].map(|mask| Instance::new(0, Affine::IDENTITY).masked(mask));
    let set = Instances::new([object()], instances).expect("good instances");
    let judge = BruteForce::new(&set);
    let ray = Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0]);
    let seen = |mask| judge.closest_hit_seen(&ray, mask, 0.0).map(|h| h.instance);
    assert_eq!(
        [0b01, 0b10, 0b11, 0b100].map(seen),
        [Some(0), Some(1), Some(0), None]
    );
    let numbers: Vec<u32> = judge.all_hits(&ray).iter().map(|h| h.instance).collect();
    assert_eq!(numbers, [0, 1]);
}

#[test]
fn steps_within_are_counted() {
    let set = Instances::new([object()], [Instance::new(0, Affine::IDENTITY)]).expect("good");
    let mut stats = TraversalStats::default();
    let ray = Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0]);
    BruteForce::new(&set).closest_hit_counted(&ray, &mut stats);
    // The instance and the triangle in it.
    assert_eq!(stats.primitives, 2);
}
