//! Placed objects: transforms of every sort, and sets of instances of meshes and shapes, nested or not.

use crate::{Random, Spheres, soups};
use boxwood::{Affine, Instance, Instances, Intersect, Object, StructureKind, TriangleMesh, Vec3};
use std::sync::Arc;

/// Turned about a random axis.
pub fn turn(random: &mut Random) -> Affine {
    let x = random.direction();
    let y = x.cross(random.direction());
    let y = if y.length_squared() < 0.01 {
        return Affine::IDENTITY;
    } else {
        y.normalized()
    };
    let z = x.cross(y);
    Affine {
        rows: [0, 1, 2].map(|k| [x[k], y[k], z[k], 0.0]),
    }
}

/// Anything that a scene may do to an object: moved, turned, mirrored, stretched, sheared; by powers of two up to
/// `2^±spread` in size.
pub fn transform(spread: usize, random: &mut Random) -> Affine {
    let size = 2.0_f32.powi(random.below(2 * spread + 1) as i32 - spread as i32);
    let stretch = match random.below(4) {
        0 => [1.0; 3],
        1 => [1.0, 1.0, -1.0],
        2 => [random.between(0.2, 4.0), random.between(-4.0, -0.2), 1.0],
        _ => [0.01, 1.0, 3.0],
    };
    let turned = match random.below(3) {
        0 => Affine::IDENTITY,
        _ => turn(random),
    };
    let mut sheared = Affine::IDENTITY;
    if random.one_in(4) {
        sheared.rows[0][1] = random.between(-2.0, 2.0);
    }
    let to = random.in_cube() * random.pick(&[0.0, 4.0, 30.0]);
    Affine::scale(stretch.map(|x| x * size))
        .then(&turned)
        .then(&sheared)
        .then(&Affine::translation(to))
}

/// A mesh as an object. Not generic, so that the code of all structures over such meshes is made once.
pub fn mesh_object(kind: StructureKind, mesh: TriangleMesh) -> Object {
    let mesh = Arc::new(mesh);
    Object::new(&mesh, Arc::from(kind.build(mesh.clone())))
}

/// Instances as an object. Not generic either.
///
/// # Panics
/// When they are nested too deeply.
pub fn instances_object(kind: StructureKind, instances: Arc<Instances>) -> Object {
    let structure: Arc<dyn Intersect> = Arc::from(kind.build(instances.clone()));
    Object::of_instances(instances, structure).expect("not too deep")
}

/// How a set is made.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// How many instances.
    pub count: usize,
    /// Sizes differ by powers of two up to this one, up and down.
    pub spread: usize,
    /// Levels of instances within instances; 1 is none.
    pub depth: usize,
}

/// Instances of soups, of shapes and of sets of instances. The structures within come from `kinds` in turn; what is made follows
/// from the random numbers alone, not from the kinds.
///
/// # Panics
/// When `kinds` is empty.
pub fn set(recipe: Recipe, kinds: &[StructureKind], random: &mut Random) -> Instances {
    let mut turn_of = kinds.iter().cycle();
    let mut next = || *turn_of.next().expect("at least one kind");
    let mut objects = vec![
        mesh_object(next(), soups::random(30, random).mesh()),
        mesh_object(next(), soups::slivers(20, random).mesh()),
        mesh_object(next(), soups::flat(12, random.below(3), random).mesh()),
        mesh_object(next(), soups::grid(20, random).mesh()),
        mesh_object(next(), TriangleMesh::default()),
    ];
    let spheres = Arc::new(Spheres::random(8, false, random));
    let judge = boxwood::BruteForce::new(spheres.clone());
    objects.push(Object::new(&spheres, Arc::new(judge)));
    for _ in 1..recipe.depth {
        let inner = scatter(&objects, 6, recipe.spread.min(2), random);
        objects.push(instances_object(next(), Arc::new(inner)));
        let newest = objects.len() - 1;
        // So that the deepest are met often.
        objects.swap(0, newest);
    }
    scatter(&objects, recipe.count, recipe.spread, random)
}

fn scatter(objects: &[Object], count: usize, spread: usize, random: &mut Random) -> Instances {
    let mut instances: Vec<Instance> = Vec::new();
    for _ in 0..count {
        let object = if random.one_in(3) {
            0
        } else {
            random.below(objects.len())
        };
        let placed = match instances.last() {
            // Twice in the same place: the numbers decide.
            Some(last) if random.one_in(8) => *last,
            _ => Instance::new(object as u32, transform(spread, random)),
        };
        instances.push(placed.masked(random.pick(&[u32::MAX, 0b010, 0b101, u32::MAX])));
    }
    Instances::new(objects.to_vec(), instances).expect("good instances")
}

/// Small turned meshes all over a plain, many of them.
///
/// # Panics
/// Never, unless a plain is too large for floats.
pub fn plain(count: usize, kind: StructureKind, random: &mut Random) -> Instances {
    let side = (count as f32).sqrt();
    let objects = [
        mesh_object(kind, crate::shapes::sphere(8, 5).mesh()),
        mesh_object(kind, soups::random(20, random).mesh()),
    ];
    let instances: Vec<Instance> = (0..count)
        .map(|i| {
            let to = Vec3::new(random.unit() * side, 0.0, random.unit() * side);
            let placed = Affine::scale([random.between(0.2, 0.8); 3])
                .then(&turn(random))
                .then(&Affine::translation(to));
            Instance::new((i % 2) as u32, placed)
        })
        .collect();
    Instances::new(objects, instances).expect("good instances")
}
