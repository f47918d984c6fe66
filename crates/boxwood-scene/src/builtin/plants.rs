//! A meadow at the edge of a wood: a few plants, each grown in some variants and set thousands of times.
//!
//! *How it works.* Places follow an even sequence in the plane; slow noise says where the wood is, and chance what grows
//! there. *Source.* Deussen et al. 1998, *Realistic Modeling and Rendering of Plant Ecosystems*, whose scenes made
//! instances famous: few plants, placed without end.

use super::foliage::{Plant, Stuff, broadleaf, bush, fir, flowers, grass};
use super::random::{Noise, Random};
use super::solids::{facets, set_down};
use super::stage::{Stage, paint};
use super::{camera, sun};
use crate::scene::{Mesh, Scene};
use boxwood::Vec3;

/// Ground for each plant, in square metres.
const ROOM: f64 = 0.32;

/// `n` plants on rolling ground.
pub(super) fn plants(n: u32, seed: u64) -> Scene {
    let mut random = Random::new(seed, 5);
    let meadow = Meadow {
        noise: Noise::new(seed),
        half: 0.5 * libm::sqrt(f64::from(n) * ROOM).max(2.0),
    };
    let mut stage = Stage::default();
    let species = species(&mut stage, &mut random);
    let soil = stage.material(paint("soil", [0.085, 0.088, 0.03], 1.0));
    stage.build("ground", meadow.ground(), soil);

    let start = [f64::from(random.unit()), f64::from(random.unit())];
    for i in 0..n {
        let [x, z] = meadow.place(start, i);
        let kind = meadow.kind(x, z, &mut random);
        let variants = &species[kind as usize];
        let size = random.between(0.7, 1.25);
        let turn = f64::from(random.between(0.0, 360.0));
        let at = [x as f32, meadow.height(x, z) as f32 - 0.02, z as f32];
        for &part in &variants[random.below(variants.len())] {
            stage.place(part, set_down(turn, size, at));
        }
    }
    stage.drop_unplaced();
    let mut scene = stage.scene;
    scene.lights = vec![sun([0.66, -0.5, -0.3])];
    let reach = meadow.half.min(28.0);
    let stand =
        |x: f64, z: f64, above: f64| [x as f32, (meadow.height(x, z) + above) as f32, z as f32];
    let half = meadow.half as f32;
    scene.cameras = vec![
        camera(
            "main",
            stand(0.25 * reach, 0.97 * meadow.half, 1.9),
            stand(-0.1 * reach, 0.97 * meadow.half - reach, 1.6),
            50.0,
        ),
        camera(
            "overview",
            [-half, half, 1.7 * half],
            [0.0, 0.0, 0.08 * half],
            45.0,
        ),
    ];
    scene
}

#[derive(Clone, Copy)]
enum Kind {
    Grass,
    Flowers,
    Bush,
    Broadleaf,
    Fir,
}

/// Grows every plant; for each kind its variants, for each variant the meshes of its parts.
fn species(stage: &mut Stage, random: &mut Random) -> [Vec<Vec<u32>>; 5] {
    let materials = [
        (Stuff::Bark, "bark", [0.12, 0.075, 0.045]),
        (Stuff::Birch, "birch bark", [0.55, 0.52, 0.47]),
        (Stuff::Leaf, "leaves", [0.085, 0.2, 0.03]),
        (Stuff::Yellowing, "leaves, yellowing", [0.3, 0.27, 0.04]),
        (Stuff::Needle, "needles", [0.03, 0.095, 0.045]),
        (Stuff::Bush, "bush", [0.06, 0.14, 0.035]),
        (Stuff::Grass, "grass", [0.17, 0.27, 0.06]),
        (Stuff::Stalk, "stalks", [0.12, 0.2, 0.05]),
        (Stuff::Red, "poppy", [0.65, 0.04, 0.02]),
        (Stuff::White, "daisy", [0.8, 0.78, 0.7]),
        (Stuff::Violet, "bellflower", [0.28, 0.14, 0.55]),
    ]
    .map(|(stuff, name, color)| (stuff, name, stage.material(paint(name, color, 0.75))));
    let mut grow = |plant: Plant| -> Vec<u32> {
        let part = |(stuff, mesh): (Stuff, Mesh)| {
            let known = materials.iter().find(|(other, ..)| *other == stuff);
            known.map(|&(_, name, material)| stage.mesh(name, mesh, material))
        };
        plant.into_iter().filter_map(part).collect()
    };
    let tree = [
        (Stuff::Bark, Stuff::Leaf, 1.0),
        (Stuff::Bark, Stuff::Leaf, 0.8),
        (Stuff::Birch, Stuff::Yellowing, 0.55),
    ];
    [
        [(); 3].map(|()| grow(grass(random))).to_vec(),
        [Stuff::Red, Stuff::White, Stuff::Violet]
            .map(|petal| grow(flowers(random, petal)))
            .to_vec(),
        [(); 2].map(|()| grow(bush(random))).to_vec(),
        tree.map(|(bark, leaf, slender)| grow(broadleaf(random, bark, leaf, slender)))
            .to_vec(),
        [(); 2].map(|()| grow(fir(random))).to_vec(),
    ]
}

struct Meadow {
    noise: Noise,
    /// Half the side of the square, in metres.
    half: f64,
}

impl Meadow {
    /// Point `i` of an even sequence in the square (Roberts 2018).
    fn place(&self, start: [f64; 2], i: u32) -> [f64; 2] {
        /// The real root of x³ = x + 1.
        const RATIO: f64 = 1.324_717_957_244_746;
        let share = |begin: f64, step: f64| {
            let x = begin + f64::from(i) * step;
            x - x.floor()
        };
        let u = share(start[0], 1.0 / RATIO);
        let v = share(start[1], 1.0 / (RATIO * RATIO));
        [u, v].map(|u| (2.0 * u - 1.0) * self.half)
    }

    /// Of the ground, in metres.
    fn height(&self, x: f64, z: f64) -> f64 {
        1.6 * self.noise.octaves(x / 24.0 + 3.3, z / 24.0 + 8.1, 3)
    }

    /// What grows at a place.
    fn kind(&self, x: f64, z: f64, random: &mut Random) -> Kind {
        // The wood begins away from the near edge.
        let near = 1.0 - (self.half - z) / self.half.min(16.0);
        let wood =
            self.noise.octaves(x / 17.0, z / 17.0 + 40.0, 2) as f32 - 1.2 * near.max(0.0) as f32;
        let firs = self.noise.at(x / 30.0 + 70.0, z / 30.0) > 0.05;
        let luck = random.unit();
        let bloom = self.noise.at(x / 5.0, z / 5.0 + 90.0) > 0.12;
        match luck {
            l if l < 0.016 + 0.12 * wood.max(-0.1) && firs => Kind::Fir,
            l if l < 0.016 + 0.12 * wood.max(-0.1) => Kind::Broadleaf,
            l if l < 0.045 + 0.06 * wood.max(-0.4) => Kind::Bush,
            l if l > if bloom { 0.6 } else { 0.95 } => Kind::Flowers,
            _ => Kind::Grass,
        }
    }

    /// The square, a little larger than what grows on it.
    fn ground(&self) -> Mesh {
        const CELLS: u32 = 96;
        let at = |k: u32| 1.08 * self.half * (2.0 * f64::from(k) / f64::from(CELLS) - 1.0);
        let mut mesh = facets(Vec::new(), Vec::new());
        for row in 0..=CELLS {
            for column in 0..=CELLS {
                let (x, z) = (at(column), at(row));
                mesh.positions
                    .push([x as f32, self.height(x, z) as f32, z as f32]);
                let slope = |dx: f64, dz: f64| {
                    (self.height(x + dx, z + dz) - self.height(x - dx, z - dz)) as f32 / 0.2
                };
                let normal = Vec3::new(-slope(0.1, 0.0), 1.0, -slope(0.0, 0.1)).normalized();
                mesh.normals.push(normal.to_array());
            }
        }
        let vertex = |column: u32, row: u32| row * (CELLS + 1) + column;
        for row in 0..CELLS {
            for column in 0..CELLS {
                let [a, b] = [vertex(column, row), vertex(column + 1, row)];
                let [c, d] = [vertex(column + 1, row + 1), vertex(column, row + 1)];
                mesh.triangles.extend([[a, d, c], [a, c, b]]);
            }
        }
        Mesh {
            smooth: true,
            ..mesh
        }
    }
}
