//! Asks every structure of the table about rays in every scene and prints a digest of all bits of all answers.
//!
//! `cargo run --release -p boxwood-testkit --example digest`: the same digest for every structure, on every machine, with
//! every instruction set. The example `architectures` runs it on several machines and compares. It needs neither threads nor files.

use boxwood::{BruteForce, Hit, Intersect, Isa, Ray, StructureKind};
use boxwood_testkit::rays::{KINDS, Targets, sample};
use boxwood_testkit::scenes::SCENES;
use boxwood_testkit::{Random, structures};

const TRIANGLES: usize = 60;
const RAYS_OF_EACH_KIND: usize = 3;
/// Rays side by side, which wide trees take together.
const PENCIL: usize = 64;

fn main() {
    let sets: Vec<&str> = Isa::available().into_iter().map(Isa::name).collect();
    println!("machine {}: {}", std::env::consts::ARCH, sets.join(", "));
    // What several threads build is only compared where there are threads: by the tests.
    let kinds: Vec<StructureKind> = structures::all()
        .filter(|entry| entry.threads().is_none())
        .map(|entry| entry.kind())
        .collect();
    let mut inputs = Digest::default();
    let mut answers = vec![Digest::default(); kinds.len()];
    let (mut count, mut found) = (0, 0);
    for (seed, (_, make)) in SCENES.into_iter().enumerate() {
        let mut random = Random::new(seed as u64);
        let mesh = make(TRIANGLES, &mut random).mesh();
        let (judge, targets) = (BruteForce::new(&mesh), Targets::of_mesh(&mesh));
        let mut rays = Vec::new();
        for (_, kind) in KINDS {
            rays.extend(sample(
                kind,
                RAYS_OF_EACH_KIND,
                &targets,
                &judge,
                &mut random,
            ));
        }
        let first = rays[0];
        rays.extend((0..PENCIL).map(|_| {
            let aside = random.in_cube() * (0.1 * first.direction.length());
            Ray::new(first.origin, first.direction + aside)
        }));
        mesh.positions()
            .iter()
            .for_each(|p| inputs.floats(&p.to_array()));
        for ray in &rays {
            inputs.floats(&ray.origin.to_array());
            inputs.floats(&ray.direction.to_array());
            inputs.floats(&[ray.t_min, ray.t_max]);
        }
        for (kind, digest) in kinds.iter().zip(&mut answers) {
            let structure = structures::over_mesh(*kind, &mesh);
            let mut closest = vec![None; rays.len()];
            let mut occluded = vec![false; rays.len()];
            structure.closest_hits(&rays, &mut closest);
            structure.occluded_each(&rays, &mut occluded);
            for ((ray, closest), occluded) in rays.iter().zip(closest).zip(occluded) {
                digest.hits(closest.as_slice());
                digest.hits(structure.closest_hit(ray).as_slice());
                digest.hits(&structure.all_hits(ray));
                digest.word(u32::from(occluded));
                digest.word(u32::from(structure.occluded(ray)));
            }
        }
        count += rays.len();
        found += rays.iter().filter(|ray| judge.occluded(ray)).count();
    }
    assert!(
        4 * found > count,
        "{found} hits of {count} rays test nothing"
    );
    println!("{:016x} {count} rays, {found} of which hit", inputs.0);
    for (kind, digest) in kinds.iter().zip(answers) {
        println!("{:016x} {kind}", digest.0);
    }
}

/// 64 bits that follow from all words in their order.
#[derive(Clone, Copy, Default)]
struct Digest(u64);

impl Digest {
    fn word(&mut self, word: u32) {
        // The mixing of `Random`: each word changes all bits.
        self.0 = Random::new(self.0 ^ u64::from(word)).bits();
    }
    fn floats(&mut self, floats: &[f32]) {
        // Which NaN it is depends on the machine, and means nothing.
        let bits = |x: f32| if x.is_nan() { f32::NAN } else { x }.to_bits();
        floats.iter().for_each(|&x| self.word(bits(x)));
    }
    fn hits(&mut self, hits: &[Hit]) {
        self.word(hits.len() as u32);
        for hit in hits {
            self.floats(&[hit.t, hit.u, hit.v]);
            self.word(hit.primitive);
            self.word(hit.instance);
        }
    }
}
