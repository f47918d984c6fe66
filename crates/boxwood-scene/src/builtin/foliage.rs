//! Plants, each grown once from simple rules and then set many times.
//!
//! *How it works.* A plant is a few meshes, one for each material, with its foot at the origin. Leaves are folded
//! rhombs, blades and fronds strips of two or three triangles: hundreds of small things with air between them, which is
//! what plants are to a structure.

use super::crowd::add;
use super::random::Random;
use super::solids::facets;
use crate::scene::Mesh;
use boxwood::Vec3;

/// What a part of a plant is made of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Stuff {
    Bark,
    Birch,
    Leaf,
    Yellowing,
    Needle,
    Bush,
    Grass,
    Stalk,
    Red,
    White,
    Violet,
}

/// The parts of one plant.
pub(super) type Plant = Vec<(Stuff, Mesh)>;

/// A tree with a round crown, about 7 m tall.
pub(super) fn broadleaf(random: &mut Random, bark: Stuff, leaf: Stuff, slender: f32) -> Plant {
    let mut wood = facets(Vec::new(), Vec::new());
    let mut leaves = facets(Vec::new(), Vec::new());
    let top = Vec3::new(random.between(-0.3, 0.3), 5.2, random.between(-0.3, 0.3));
    limb(&mut wood, [Vec3::ZERO, top], [0.19, 0.05]);
    // Tufts of leaves sit at the ends of branches.
    for k in 0..9 {
        let turn = f64::from(k) * 2.4 + f64::from(random.unit());
        let (sin, cos) = libm::sincos(turn);
        let up = 0.35 + 0.65 * k as f32 / 8.0;
        let reach = slender * (1.9 - 1.2 * up) * random.between(0.8, 1.2);
        let from = top * (up * 0.8);
        let tip = top * up + Vec3::new(cos as f32 * reach, 0.9, sin as f32 * reach);
        limb(&mut wood, [from, tip], [0.07, 0.02]);
        let size = random.between(0.75, 1.1) * (0.6 + 0.4 * slender);
        for _ in 0..64 {
            let outwards = random.direction();
            let shell = 0.45 + 0.55 * random.unit();
            let at = tip + outwards * (size * shell) * Vec3::new(1.0, 0.75, 1.0);
            self::leaf(&mut leaves, random, at, outwards, 0.17);
        }
    }
    vec![(bark, wood), (leaf, leaves)]
}

/// A fir, about 8 m tall: whorls of drooping fronds, shorter towards the top.
pub(super) fn fir(random: &mut Random) -> Plant {
    let mut wood = facets(Vec::new(), Vec::new());
    let mut needles = facets(Vec::new(), Vec::new());
    limb(
        &mut wood,
        [Vec3::ZERO, Vec3::new(0.0, 7.8, 0.0)],
        [0.17, 0.01],
    );
    for whorl in 0..17 {
        let share = whorl as f32 / 16.0;
        let height = 0.9 + 6.7 * share;
        let reach = 1.75 * (1.0 - share) + 0.16;
        let begin = f64::from(random.unit()) * std::f64::consts::TAU;
        for k in 0..11 {
            let turn = begin
                + std::f64::consts::TAU * (f64::from(k) + 0.5 * f64::from(random.unit())) / 11.0;
            let (sin, cos) = libm::sincos(turn);
            let out = Vec3::new(cos as f32, 0.0, sin as f32);
            let side = Vec3::new(-out.z, 0.0, out.x) * (0.16 + 0.17 * reach);
            let length = reach * random.between(0.82, 1.1);
            let foot = Vec3::new(0.0, height, 0.0);
            let knee = foot + out * (0.55 * length) - Vec3::new(0.0, 0.13 * length, 0.0);
            let tip = foot + out * length - Vec3::new(0.0, 0.5 * length, 0.0);
            let drop = Vec3::new(0.0, -0.12, 0.0);
            for side in [side, side * -1.0] {
                add(&mut needles, [foot, knee + side + drop, knee]);
                add(&mut needles, [knee, knee + side + drop, tip]);
            }
        }
    }
    vec![(Stuff::Bark, wood), (Stuff::Needle, needles)]
}

/// A bush of leaves down to the ground, about 1 m tall.
pub(super) fn bush(random: &mut Random) -> Plant {
    let mut leaves = facets(Vec::new(), Vec::new());
    for _ in 0..260 {
        let mut outwards = random.direction();
        outwards.y = outwards.y.abs();
        let shell = 0.5 + 0.5 * random.unit();
        let at = outwards * shell * Vec3::new(0.85, 0.95, 0.85) + Vec3::new(0.0, 0.08, 0.0);
        leaf(&mut leaves, random, at, outwards, 0.1);
    }
    vec![(Stuff::Bush, leaves)]
}

/// A tuft of grass, half a metre tall.
pub(super) fn grass(random: &mut Random) -> Plant {
    let mut blades = facets(Vec::new(), Vec::new());
    for _ in 0..34 {
        let foot = random.in_cube() * Vec3::new(0.32, 0.0, 0.32);
        let height = random.between(0.22, 0.55);
        blade(&mut blades, random, foot, height, 0.012);
    }
    vec![(Stuff::Grass, blades)]
}

/// A few flowers on stalks, 30 to 60 cm tall.
pub(super) fn flowers(random: &mut Random, petal: Stuff) -> Plant {
    let mut stalks = facets(Vec::new(), Vec::new());
    let mut petals = facets(Vec::new(), Vec::new());
    for _ in 0..5 {
        let foot = random.in_cube() * Vec3::new(0.22, 0.0, 0.22);
        let height = random.between(0.3, 0.6);
        let head = blade(&mut stalks, random, foot, height, 0.008);
        let lean =
            Vec3::new(random.between(-0.5, 0.5), 1.0, random.between(-0.5, 0.5)).normalized();
        let x = lean.cross(Vec3::new(0.0, 0.0, 1.0)).normalized();
        let y = lean.cross(x);
        for k in 0..7 {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 7.0);
            let out = x * cos as f32 + y * sin as f32;
            let side = lean.cross(out) * 0.022;
            let tip = head + out * 0.06 + lean * 0.018;
            add(&mut petals, [head, tip - side, tip + side]);
        }
    }
    vec![(Stuff::Stalk, stalks), (petal, petals)]
}

/// A cone without ends between two points: 12 triangles.
fn limb(mesh: &mut Mesh, [from, to]: [Vec3; 2], radii: [f32; 2]) {
    const SIDES: u32 = 6;
    let axis = (to - from).normalized();
    let x = axis.cross(Vec3::new(0.6, 0.0, 0.8)).normalized();
    let y = axis.cross(x);
    let first = mesh.positions.len() as u32;
    for (end, radius) in [(from, radii[0]), (to, radii[1])] {
        for k in 0..SIDES {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / f64::from(SIDES));
            let p = end + (x * cos as f32 + y * sin as f32) * radius;
            mesh.positions.push(p.to_array());
        }
    }
    for k in 0..SIDES {
        let next = (k + 1) % SIDES;
        let [a, b] = [first + k, first + next];
        let [c, d] = [b + SIDES, a + SIDES];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
}

/// A rhomb folded along its length, turned roughly outwards.
fn leaf(mesh: &mut Mesh, random: &mut Random, at: Vec3, outwards: Vec3, size: f32) {
    let along = (random.direction() + Vec3::new(0.0, -0.4, 0.0)).normalized();
    let across = along
        .cross(outwards + random.direction() * 0.7)
        .normalized()
        * (0.5 * size);
    let length = along * (size * random.between(0.8, 1.2));
    let fold = outwards * (0.12 * size);
    let (foot, tip) = (at, at + length);
    let middle = at + length * 0.45 + fold;
    // Where the directions happen to be one line there is no leaf.
    if across.is_finite() && across != Vec3::ZERO {
        add(mesh, [foot, tip, middle + across]);
        add(mesh, [tip, foot, middle - across]);
    }
}

/// A blade that bends: three triangles. Where it ends.
fn blade(mesh: &mut Mesh, random: &mut Random, foot: Vec3, height: f32, half: f32) -> Vec3 {
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(random.unit()));
    let out = Vec3::new(cos as f32, 0.0, sin as f32);
    let side = Vec3::new(-out.z, 0.0, out.x) * half;
    let bend = random.between(0.1, 0.5) * height;
    let knee = foot + Vec3::new(0.0, 0.6 * height, 0.0) + out * (0.3 * bend);
    let tip = foot + Vec3::new(0.0, height, 0.0) + out * bend;
    add(mesh, [foot - side, foot + side, knee + side * 0.8]);
    add(mesh, [foot - side, knee + side * 0.8, knee - side * 0.8]);
    add(mesh, [knee - side * 0.8, knee + side * 0.8, tip]);
    tip
}
