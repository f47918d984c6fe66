//! Objects that come, go and move: after each commit the answers are those of a scene that is put up at once.

use boxwood::{
    Affine, BruteForce, Committed, Handle, Instance, InstanceError, Instances, Intersect, Object,
    StructureKind, TopLevel, Vec3,
};
use boxwood_testkit::agreement::Judged;
use boxwood_testkit::rays::{KINDS, Targets};
use boxwood_testkit::{Random, effort, placed, shapes, soups};
use proptest::prelude::*;

fn objects(random: &mut Random) -> Vec<Object> {
    let kind = StructureKind::default();
    vec![
        placed::mesh_object(kind, soups::random(20, random).mesh()),
        placed::mesh_object(kind, shapes::sphere(8, 5).mesh()),
        placed::mesh_object(kind, soups::random(0, random).mesh()),
    ]
}

/// What a user would write down beside it.
struct Book {
    objects: Vec<Object>,
    placed: Vec<(Handle, Instance)>,
    gone: Vec<Handle>,
}

fn play(seed: u64, steps: usize) {
    let mut random = Random::new(seed);
    let mut book = Book {
        objects: objects(&mut random),
        placed: Vec::new(),
        gone: Vec::new(),
    };
    let mut scene = TopLevel::new(book.objects.clone())
        .expect("not deep")
        .for_rays(1.0e4);
    for step in 0..steps {
        let moves_only = random.one_in(2);
        for _ in 0..random.below(8) {
            change(&mut scene, &mut book, moves_only, &mut random);
        }
        let committed = scene.commit();
        assert!(
            !(moves_only && committed == Committed::Renewed),
            "step {step}"
        );
        assert_eq!(scene.commit(), Committed::Nothing);
        compare(
            &scene,
            &book,
            &format!("seed {seed}, step {step}"),
            &mut random,
        );
    }
}

fn change(scene: &mut TopLevel, book: &mut Book, moves_only: bool, random: &mut Random) {
    let some = random.below(book.placed.len());
    match random.below(if moves_only { 2 } else { 8 }) {
        0 | 1 => {
            if let Some((handle, instance)) = book.placed.get_mut(some) {
                instance.transform = placed::transform(2, random);
                assert_eq!(scene.move_to(*handle, instance.transform), Ok(true));
                let flat = Affine::scale([1.0, 0.0, 1.0]);
                assert!(scene.move_to(*handle, flat).is_err());
                assert_eq!(scene.get(*handle), Some(*instance));
            }
        }
        2..5 => {
            let object = random.below(book.objects.len()) as u32;
            let mask = random.pick(&[u32::MAX, 0b010, 0b101]);
            let instance = Instance::new(object, placed::transform(2, random)).masked(mask);
            let handle = scene.insert(instance).expect("good");
            assert!(!book.gone.contains(&handle));
            book.placed.push((handle, instance));
        }
        5 => {
            if some < book.placed.len() {
                let (handle, instance) = book.placed.remove(some);
                assert_eq!(scene.remove(handle), Some(instance));
                book.gone.push(handle);
            }
        }
        6 => {
            let mesh = soups::random(1 + random.below(9), random).mesh();
            let object = placed::mesh_object(StructureKind::default(), mesh);
            let number = random.below(book.objects.len());
            book.objects[number] = object.clone();
            scene.set_object(number as u32, object).expect("good");
        }
        _ => {
            if book.objects.len() < 5 {
                let inner = placed::plain(3, random).instances;
                let object = placed::instances_object(random.below(3), inner.into());
                book.objects.push(object.clone());
                let number = scene.add_object(object).expect("not deep");
                assert_eq!(number as usize, book.objects.len() - 1);
            }
        }
    }
    for &handle in &book.gone {
        assert_eq!(scene.get(handle), None);
        assert_eq!(scene.remove(handle), None);
        assert_eq!(scene.move_to(handle, Affine::IDENTITY), Ok(false));
    }
    assert_eq!(
        (scene.len(), scene.is_empty()),
        (book.placed.len(), book.placed.is_empty())
    );
}

fn compare(scene: &TopLevel, book: &Book, case: &str, random: &mut Random) {
    let instances = book.placed.iter().map(|p| p.1);
    let at_once = Instances::new(book.objects.clone(), instances).expect("good");
    let targets = Targets::of_boxes(&at_once);
    let rays: Vec<_> = (KINDS[..6].iter())
        .flat_map(|(_, kind)| {
            (0..effort(3))
                .map(|_| kind(&targets, random))
                .collect::<Vec<_>>()
        })
        .collect();
    Judged::new(&at_once, &rays).check(scene, "the top level", case);
    for ray in &rays {
        for hit in BruteForce::new(&at_once).all_hits(ray) {
            let number = at_once.path(hit.instance).next().expect("a placement");
            assert_eq!(scene.handle_of(&hit), Some(book.placed[number].0), "{case}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn every_history_leads_to_the_scene_that_is_there(seed in any::<u64>()) {
        play(seed, 12);
    }
}

#[test]
fn rays_see_changes_when_they_are_committed() {
    let mut random = Random::new(3);
    let mut scene = TopLevel::new(objects(&mut random)).expect("not deep");
    assert_eq!(scene.commit(), Committed::Nothing);
    assert!(scene.is_empty() && scene.bounds().is_empty());
    let handle = scene
        .insert(Instance::new(1, Affine::IDENTITY))
        .expect("good");
    assert!(scene.bounds().is_empty());
    assert_eq!(scene.commit(), Committed::Renewed);
    let before = scene.bounds();
    let to = Affine::translation([9.0, 0.0, 0.0]);
    assert_eq!(scene.move_to(handle, to), Ok(true));
    assert_eq!(scene.bounds(), before);
    assert!(matches!(scene.commit(), Committed::Moved(_)));
    assert!(scene.bounds().lower.x > before.upper.x);
    scene.remove(handle);
    assert!(!scene.bounds().is_empty());
    scene.commit();
    assert!(scene.bounds().is_empty());
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let mut random = Random::new(4);
    let mut scene = TopLevel::new(objects(&mut random)).expect("not deep");
    let nowhere = scene.insert(Instance::new(3, Affine::IDENTITY));
    assert!(matches!(
        nowhere,
        Err(InstanceError::NoSuchObject { object: 3, .. })
    ));
    let far = Affine::scale(Vec3::splat(1.0e38));
    let handle = scene
        .insert(Instance::new(2, far))
        .expect("nothing, but large");
    let ball = placed::mesh_object(StructureKind::default(), shapes::sphere(8, 5).mesh());
    let refused = scene.set_object(2, ball.clone());
    assert!(matches!(refused, Err(InstanceError::TooLarge { .. })));
    assert!(matches!(
        scene.set_object(7, ball),
        Err(InstanceError::NoSuchObject { object: 7, .. })
    ));
    assert_eq!(scene.len(), 1);
    assert_eq!(scene.get(handle).map(|i| i.object), Some(2));
}
