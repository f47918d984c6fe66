//! Rays that are hard on wide trees, by the billion: every way of asking, on every instruction set, against the judge.
//!
//! *How it works.* The work is numbered in rounds, each of which follows from the seed and its number alone. A round is a
//! small mesh of the [catalogue](crate::scenes), at a size and a place where floats get coarse, and some hundred rays: of all
//! [kinds](crate::rays), through the middles of edges, and in bundles that wide trees take together. All are asked of the judge
//! and then of every wide tree: one by one and many at once, for the nearest hit, for any and for all.
//!
//! *What a seed means* depends on all of this: where rounds change, so does [`EDITION`]. The second edition moves meshes along each axis by
//! a distance of its own, has two scenes more, and so numbers its rounds anew.
//!
//! *Cost.* About a millisecond and a half a round, in which some 15,000 answers are compared.

use crate::rays::{KINDS, Targets, sample};
use crate::scenes::SCENES;
use crate::{Model, Random};
use boxwood::{
    BinaryTree, BinnedSah, BruteForce, CompactBvh, Hit, Intersect, Isa, Ray, SpatialSplit,
    TriangleMesh, Vec3, WideBvh,
};

/// Seed and number mean the same round as long as this is the same.
pub const EDITION: u32 = 2;

/// Rays of each kind.
const OF_EACH_KIND: usize = 16;
/// Rays through the middles of edges.
const THROUGH_MIDDLES: usize = 32;
/// Rays that run together, and how many such bundles there are.
const BUNDLE: usize = 64;
const BUNDLES: usize = 4;
/// One ray of so many is asked for all of its hits.
const ALL_HITS_OF: usize = 8;

/// A structure and what it is called.
pub type Named<'a> = (String, Box<dyn Intersect + 'a>);

/// What a round found.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Rays.
    pub rays: u64,
    /// Those that hit something.
    pub hits: u64,
    /// Answers that were compared: rays by ways of asking by structures.
    pub answers: u64,
    /// What differs from the judge's answer, a sentence each.
    pub differences: Vec<String>,
}

/// Runs a round.
pub fn round(seed: u64, number: u64) -> Found {
    let mut random = Random::new(Random::new(seed).bits() ^ number);
    let (scene, model) = model(number, &mut random);
    let mesh = model.mesh();
    let rays = rays(&mesh, &mut random);
    let structures = wide_trees(&mesh, &tree(number, &mesh));
    let mut found = compare(&mesh, &rays, &structures, &mut random);
    for difference in &mut found.differences {
        *difference = format!("round {number} of seed {seed}, `{scene}`: {difference}");
    }
    found
}

/// One mesh of the catalogue, of 16 to 300 triangles, two times in three at another size and place.
fn model(number: u64, random: &mut Random) -> (String, Model) {
    let (name, make) = SCENES[(number % SCENES.len() as u64) as usize];
    let triangles = 16 + random.below(2) * random.below(70) + random.below(215);
    let model = make(triangles, random);
    if random.one_in(3) {
        return (format!("{name}, {triangles}"), model);
    }
    let scale = 10.0_f32.powi(random.below(10) as i32 - 3);
    let by = distances(random);
    let placed = model.clone().moved(by).placed(scale, 0.0);
    let is_finite = placed.positions.iter().flatten().all(|x| x.is_finite());
    let model = if is_finite { placed } else { model };
    (
        format!("{name}, {triangles}, moved by {by:?}, times {scale:e}"),
        model,
    )
}

/// How far a mesh is moved: not at all, along all axes alike, or along each by a distance of its own, which may be none.
fn distances(random: &mut Random) -> [f32; 3] {
    let far =
        |random: &mut Random| random.between(-1.0, 1.0) * 10.0_f32.powi(random.below(7) as i32);
    match random.below(3) {
        0 => [0.0; 3],
        1 => [far(random); 3],
        _ => [(); 3].map(|()| if random.one_in(3) { 0.0 } else { far(random) }),
    }
}

/// Every fourth tree cuts primitives.
fn tree(number: u64, mesh: &TriangleMesh) -> BinaryTree {
    // Not the scenes' own rhythm.
    if (number / SCENES.len() as u64).is_multiple_of(4) {
        return SpatialSplit::default().build(mesh);
    }
    BinnedSah {
        max_leaf: 4,
        ..Default::default()
    }
    .build(mesh)
}

fn wide_trees<'a>(mesh: &'a TriangleMesh, tree: &BinaryTree) -> Vec<Named<'a>> {
    let each = |isa: Isa| -> [Named<'a>; 3] {
        let eight = WideBvh::<_, 8>::new(mesh, tree).with_isa(isa);
        let sixteen = WideBvh::<_, 16>::new(mesh, tree).with_isa(isa);
        let compact = CompactBvh::of(mesh, tree).with_isa(isa);
        [
            (format!("wide8 {isa}"), Box::new(eight)),
            (format!("wide16 {isa}"), Box::new(sixteen)),
            (format!("compact {isa}"), Box::new(compact)),
        ]
    };
    Isa::available().into_iter().flat_map(each).collect()
}

/// Rays of all kinds in any order, then bundles.
fn rays(mesh: &TriangleMesh, random: &mut Random) -> Vec<Ray> {
    let (judge, targets) = (BruteForce::new(mesh), Targets::of_mesh(mesh));
    let mut rays = Vec::new();
    for (_, kind) in KINDS {
        rays.extend(sample(kind, OF_EACH_KIND, &targets, &judge, random));
    }
    if !mesh.triangles().is_empty() {
        rays.extend((0..THROUGH_MIDDLES).map(|_| through_middle(mesh, random)));
    }
    for i in (1..rays.len()).rev() {
        rays.swap(i, random.below(i + 1));
    }
    for _ in 0..BUNDLES {
        rays.extend(bundle(random.pick(&rays), random));
    }
    rays
}

/// Through the exact middle of an edge, as far as floats have one, from a place where a ray along an axis or askew begins.
fn through_middle(mesh: &TriangleMesh, random: &mut Random) -> Ray {
    let [a, b, c] = mesh.triangle(random.below(mesh.triangles().len()));
    let middle = a + (b - a) * 0.5;
    let away = match random.below(3) {
        0 => (b - a).cross(c - a),
        1 => random.direction() * (b - a).length(),
        _ => {
            let mut away = Vec3::ZERO;
            let length = (b - a).length() * random.pick(&[1.0, -1.0]);
            away[random.below(3)] = length;
            away
        }
    };
    Ray::new(middle + away, away * -1.0)
}

/// Rays that run beside another one: from the same place or from places side by side, some of them shorter.
fn bundle(ray: Ray, random: &mut Random) -> Vec<Ray> {
    let width = 10.0_f32.powi(-(random.below(6) as i32));
    let shared = random.one_in(2);
    let reach = width * ray.direction.length();
    let beside = |_| {
        let direction = ray.direction + random.in_cube() * reach;
        let origin = if shared {
            ray.origin
        } else {
            ray.origin + random.in_cube() * reach
        };
        Ray {
            origin,
            direction,
            t_max: if random.one_in(8) { 1.0 } else { ray.t_max },
            ..ray
        }
    };
    (0..BUNDLE).map(beside).collect()
}

/// A hit as bits: t, u, v, primitive, instance.
type Bits = [u32; 5];

fn bits(hit: Hit) -> Bits {
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
    [t, u, v, hit.primitive, hit.instance]
}

/// Asks the structures everything and compares with the judge of the mesh.
pub fn compare(
    mesh: &TriangleMesh,
    rays: &[Ray],
    structures: &[Named<'_>],
    random: &mut Random,
) -> Found {
    let judge = BruteForce::new(mesh);
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| judge.closest_hit(ray)).collect();
    // Another one of so many in each round.
    let first = random.below(ALL_HITS_OF);
    let all = |s: &dyn Intersect| -> Vec<Vec<Bits>> {
        let some = rays.iter().skip(first).step_by(ALL_HITS_OF);
        some.map(|ray| s.all_hits(ray).into_iter().map(bits).collect())
            .collect()
    };
    let expected_all = all(&judge);
    let mut found = Found {
        rays: rays.len() as u64,
        hits: expected.iter().flatten().count() as u64,
        ..Found::default()
    };
    let mut closest = vec![None; rays.len()];
    let mut occluded = vec![false; rays.len()];
    for (name, s) in structures {
        let mut note = |same: bool, what: &str, i: usize, answer: &dyn std::fmt::Debug| {
            found.answers += 1;
            if !same {
                found.differences.push(format!(
                    "{what} of {name}, ray {i}: {answer:?} instead of {:?}; {:?}",
                    expected[i], rays[i]
                ));
            }
        };
        s.closest_hits(rays, &mut closest);
        s.occluded_each(rays, &mut occluded);
        for (i, ray) in rays.iter().enumerate() {
            let judged = expected[i].map(bits);
            let nearest = |hit: Option<Hit>| hit.map(bits) == judged;
            let any = |is: bool| is == judged.is_some();
            let (hit, is) = (s.closest_hit(ray), s.occluded(ray));
            note(nearest(hit), "nearest hit", i, &hit);
            note(any(is), "any hit", i, &is);
            note(nearest(closest[i]), "nearest hit, batch", i, &closest[i]);
            note(any(occluded[i]), "any hit, batch", i, &occluded[i]);
        }
        for (k, (hits, judged)) in all(&**s).into_iter().zip(&expected_all).enumerate() {
            note(hits == *judged, "all hits", first + k * ALL_HITS_OF, &hits);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each scene once.
    #[test]
    fn some_rounds_agree() {
        let mut all = Found::default();
        for number in 0..SCENES.len() as u64 {
            let found = round(1, number);
            assert!(found.differences.is_empty(), "{}", found.differences[0]);
            all.rays += found.rays;
            all.hits += found.hits;
        }
        assert!(all.hits > all.rays / 5, "{all:?}");
    }

    #[test]
    fn rounds_follow_from_their_number() {
        let rays = |number| {
            let mut random = Random::new(Random::new(5).bits() ^ number);
            rays(&model(number, &mut random).1.mesh(), &mut random)
        };
        assert_eq!(format!("{:?}", rays(2)), format!("{:?}", rays(2)));
        assert_ne!(format!("{:?}", rays(2)), format!("{:?}", rays(29)));
    }

    /// A structure over another mesh is found out, by every way of asking.
    #[test]
    fn differences_are_noticed() {
        let mut random = Random::new(3);
        let model = crate::soups::random(40, &mut random);
        let mesh = model.mesh();
        let mut other = model.clone();
        other.triangles.pop();
        let other = other.mesh();
        let rays = rays(&mesh, &mut random);
        let wrong: Vec<Named<'_>> = vec![("wrong".into(), Box::new(BruteForce::new(&other)))];
        let found = compare(&mesh, &rays, &wrong, &mut random);
        for way in [
            "nearest hit of wrong",
            "any hit of wrong",
            "nearest hit, batch of wrong",
            "any hit, batch of wrong",
            "all hits of wrong",
        ] {
            let noticed = found.differences.iter().any(|d| d.starts_with(way));
            assert!(noticed, "{way}: {:?}", found.differences);
        }
    }
}
