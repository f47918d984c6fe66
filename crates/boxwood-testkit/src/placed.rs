//! Placed objects: transforms of every sort, and sets of instances of meshes and shapes, nested or not.

use crate::{Model, Random, Spheres, shapes, soups};
use boxwood::{
    Affine, BinnedSah, BruteForce, Bvh, Instance, Instances, Intersect, Lbvh, Object, Primitives,
    StructureKind, TriangleMesh, Vec3, WideBvh,
};
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

/// Instances as an object, under one of three structures in turn.
///
/// # Panics
/// When they are nested too deeply.
pub fn instances_object(which: usize, instances: Arc<Instances>) -> Object {
    let structure: Arc<dyn Intersect> = match which % 3 {
        0 => Arc::new(BruteForce::new(instances.clone())),
        1 => {
            let tree = BinnedSah::default().build(&instances);
            Arc::new(Bvh::new(instances.clone(), tree))
        }
        _ => {
            let tree = Lbvh::default().build(&instances);
            Arc::new(WideBvh::<_, 8>::new(instances.clone(), &tree))
        }
    };
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

/// Instances, and where their triangles are for rays to be aimed at.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The set.
    pub instances: Instances,
    /// Triangles in the world, up to rounding; of a sphere one that lies in it.
    pub aims: Vec<[Vec3; 3]>,
}

/// An object and its triangles.
type Aimed = (Object, Vec<[Vec3; 3]>);

/// Instances of soups, of shapes and of sets of instances. What is made follows from the random numbers alone: the structures
/// within are the judge when `plain`, and else any, in turn.
pub fn set(recipe: Recipe, plain: bool, random: &mut Random) -> Placed {
    let kinds: Vec<StructureKind> = StructureKind::all().collect();
    let mut built = 0;
    let mut next = || {
        built += 1;
        if plain { 0 } else { built }
    };
    let soups = [
        soups::random(30, random),
        soups::slivers(20, random),
        soups::flat(12, random.below(3), random),
        soups::grid(20, random),
        Model::default(),
    ];
    let mut objects: Vec<Aimed> = soups
        .iter()
        .map(|model| {
            // Far from each other in the table, so that few soups have met many kinds.
            let kind = kinds[next() * 5 % kinds.len()];
            let mesh = model.mesh();
            let aims = (0..mesh.len()).map(|i| mesh.triangle(i)).collect();
            (mesh_object(kind, mesh), aims)
        })
        .collect();
    let spheres = Arc::new(Spheres::random(8, false, random));
    let judge = BruteForce::new(spheres.clone());
    let aims = spheres.0.iter().map(|&(centre, radius)| {
        [[radius, 0.0], [0.0, radius], [0.0, 0.0]].map(|[x, y]| centre + Vec3::new(x, y, 0.0))
    });
    objects.push((Object::new(&spheres, Arc::new(judge)), aims.collect()));
    for _ in 1..recipe.depth {
        // Few, because what they stand for multiplies.
        let inner = scatter(&objects, 3, recipe.spread.min(2), random);
        let object = instances_object(next(), Arc::new(inner.instances));
        objects.push((object, inner.aims));
        let newest = objects.len() - 1;
        // So that the deepest are met often.
        objects.swap(0, newest);
    }
    scatter(&objects, recipe.count, recipe.spread, random)
}

fn scatter(objects: &[Aimed], count: usize, spread: usize, random: &mut Random) -> Placed {
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
    place(objects, instances)
}

/// Small turned meshes all over a plain, many of them.
///
/// # Panics
/// Never, unless a plain is too large for floats.
pub fn plain(count: usize, random: &mut Random) -> Placed {
    let side = (count as f32).sqrt();
    let kind = StructureKind::default();
    let models = [shapes::sphere(8, 5), soups::random(20, random)];
    let objects = models.map(|model| {
        let mesh = model.mesh();
        let aims = (0..mesh.len()).map(|i| mesh.triangle(i)).collect();
        (mesh_object(kind, mesh), aims)
    });
    let instances: Vec<Instance> = (0..count)
        .map(|i| {
            let to = Vec3::new(random.unit() * side, 0.0, random.unit() * side);
            let placed = Affine::scale([random.between(0.2, 0.8); 3])
                .then(&turn(random))
                .then(&Affine::translation(to));
            Instance::new((i % 2) as u32, placed)
        })
        .collect();
    place(&objects, instances)
}

fn place(objects: &[Aimed], instances: Vec<Instance>) -> Placed {
    let aims = instances.iter().flat_map(|instance| {
        let (_, aims) = &objects[instance.object as usize];
        let place = instance.transform;
        aims.iter().map(move |t| t.map(|p| place.point(p)))
    });
    let aims = aims.collect();
    let objects = objects.iter().map(|(object, _)| object.clone());
    Placed {
        instances: Instances::new(objects, instances).expect("good instances"),
        aims,
    }
}
