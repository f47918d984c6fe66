//! Every structure over instances, with any structure within them, returns the bits of brute force over brute force.

use boxwood::{BruteForce, Hit, Intersect};
use boxwood_testkit::agreement::{self, Compared};
use boxwood_testkit::placed::{self, Recipe};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::{Random, effort};

const PLAIN: Recipe = Recipe {
    count: 30,
    spread: 2,
    depth: 1,
};

fn agree(seed: u64, recipe: Recipe) {
    let set = |plain| placed::set(recipe, plain, &mut Random::new(seed));
    let (plain, mixed) = (set(true), set(false));
    let mut random = Random::new(100 + seed);
    let (judge, other) = (
        BruteForce::new(&plain.instances),
        BruteForce::new(&mixed.instances),
    );
    let targets = Targets::of_triangles(plain.aims);
    let mut found = Compared::default();
    for (kind, of_kind) in KINDS {
        let rays = sample(of_kind, effort(4), &targets, &judge, &mut random);
        let case = format!("instances, {recipe:?}, seed {seed}, rays `{kind}`");
        for ray in &rays {
            let [one, another] = [judge.all_hits(ray), other.all_hits(ray)];
            assert_eq!(bits(&one), bits(&another), "{case}, {ray:?}");
        }
        let compared = agreement::check(&mixed.instances, &rays, &case);
        found.rays += compared.rays;
        found.hits += compared.hits;
    }
    let enough = 4 * found.hits > found.rays || recipe.count == 0;
    assert!(enough, "{recipe:?} tests nothing: {found:?}");
}

fn bits(hits: &[Hit]) -> Vec<[u32; 5]> {
    let of = |h: &Hit| {
        let [t, u, v] = [h.t, h.u, h.v].map(f32::to_bits);
        [t, u, v, h.primitive, h.instance]
    };
    hits.iter().map(of).collect()
}

#[test]
fn few_and_none() {
    agree(0, Recipe { count: 0, ..PLAIN });
    agree(4, Recipe { count: 2, ..PLAIN });
}

#[test]
fn overlapping_mirrored_stretched_and_masked() {
    agree(2, PLAIN);
    agree(3, Recipe { count: 90, ..PLAIN });
}

#[test]
fn nested() {
    for depth in [2, 3, 7] {
        agree(10 + depth as u64, Recipe { depth, ..PLAIN });
    }
}

#[test]
fn of_all_sizes() {
    for (spread, depth) in [(12, 1), (30, 2), (40, 3)] {
        let recipe = Recipe {
            spread,
            depth,
            ..PLAIN
        };
        agree(20 + depth as u64, recipe);
    }
}
