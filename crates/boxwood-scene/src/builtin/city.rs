//! A city: blocks of houses of very different heights, low at the edge and towers in the middle.
//!
//! *How it works.* Lots lie four by two in blocks between streets, and are built on from the middle outwards, so that a
//! city of any size is round. Heights have a long tail that grows towards the middle. Walls are dressed in pictures of one
//! window; each house brings whole windows to each of its sides.

use super::facade::FACADES;
use super::random::Random;
use super::solids::facets;
use super::stage::{Stage, paint};
use super::{camera, sun};
use crate::material::{Material, TextureMap};
use crate::scene::{Mesh, Scene};

/// The sides of a lot, in metres.
const LOT: [f32; 2] = [17.0, 19.0];
/// Lots in a block, along x and z.
const BLOCK: [i32; 2] = [4, 2];
/// Width of a street from wall to wall.
const STREET: f32 = 15.0;
/// A house lower than this has a gable.
const LOW: f32 = 13.0;

/// `n` houses on streets. What a uniform grid finds empty above the roofs, and full at the towers.
pub(super) fn city(n: u32, seed: u64) -> Scene {
    let mut random = Random::new(seed, 4);
    let lots = lots(n);
    let radius = lots.last().map_or(1.0, |lot| lot.far).max(60.0);
    let mut town = Town::default();
    for lot in &lots {
        town.build(lot, lot.far / radius, &mut random);
    }
    let mut scene = town.scene(&lots, radius);
    scene.lights = vec![sun([0.62, -0.48, -0.42])];
    let r = radius;
    scene.cameras = vec![
        camera(
            "main",
            [-0.5 * r, 45.0 + 0.2 * r, 0.84 * r],
            [0.02 * r, 0.05 * r, 0.0],
            38.0,
        ),
        camera(
            "street",
            [1.0 + block_size()[0] - 0.5 * STREET, 12.0, 0.72 * r],
            [block_size()[0] - 0.5 * STREET, 26.0, 0.0],
            55.0,
        ),
    ];
    scene
}

/// The ground of one house, `[x₀, z₀]` to `[x₁, z₁]`.
struct Lot {
    lower: [f32; 2],
    upper: [f32; 2],
    /// From the middle of the city.
    far: f32,
}

fn block_size() -> [f32; 2] {
    [0, 1].map(|k| BLOCK[k] as f32 * LOT[k] + STREET)
}

/// The `n` lots that are nearest to the middle, nearest first.
fn lots(n: u32) -> Vec<Lot> {
    let [width, depth] = block_size();
    let each = (BLOCK[0] * BLOCK[1]) as f32;
    // A circle that holds n lots, and a little more.
    let reach = (n as f32 / each * width * depth / 3.1).sqrt() + width + depth;
    let blocks = [reach / width, reach / depth].map(|count| count.ceil() as i32);
    let mut lots = Vec::new();
    for row in -blocks[1]..=blocks[1] {
        for column in -blocks[0]..=blocks[0] {
            for j in 0..BLOCK[1] {
                for i in 0..BLOCK[0] {
                    let x = column as f32 * width + i as f32 * LOT[0];
                    let z = row as f32 * depth + j as f32 * LOT[1];
                    let (dx, dz) = (x + 0.5 * LOT[0], z + 0.5 * LOT[1]);
                    lots.push(Lot {
                        lower: [x, z],
                        upper: [x + LOT[0], z + LOT[1]],
                        far: (dx * dx + dz * dz).sqrt(),
                    });
                }
            }
        }
    }
    // Stable, so that lots equally far keep one order.
    lots.sort_by(|a, b| a.far.total_cmp(&b.far));
    lots.truncate(n as usize);
    lots
}

/// Everything of one material in one mesh.
struct Town {
    walls: [Mesh; FACADES.len()],
    tiles: Mesh,
    flat: Mesh,
    pavement: Mesh,
}

impl Default for Town {
    fn default() -> Self {
        let empty = || facets(Vec::new(), Vec::new());
        Self {
            walls: FACADES.map(|_| empty()),
            tiles: empty(),
            flat: empty(),
            pavement: empty(),
        }
    }
}

impl Town {
    /// One house; `far` is 0 in the middle of the city and 1 at its edge.
    fn build(&mut self, lot: &Lot, far: f32, random: &mut Random) {
        let luck = random.unit();
        let middle = (1.0 - 1.25 * far).max(0.0);
        let tail = luck * luck * luck;
        let height = 6.5
            + 7.0 * random.unit()
            + 26.0 * middle * luck
            + 150.0 * middle * middle * tail * luck;
        // Now and then a tower stands where nobody expects it.
        let height = if random.below(150) == 0 {
            height + 45.0
        } else {
            height
        };
        let [x0, z0] = lot.lower;
        let [x1, z1] = lot.upper;
        // Neighbours share a wall, or nearly: faces never coincide.
        let edge = |random: &mut Random| random.between(0.05, if height < LOW { 3.0 } else { 1.2 });
        let lower = [x0 + edge(random), z0 + edge(random)];
        let upper = [x1 - edge(random), z1 - edge(random)];
        let kind = match height {
            h if h < LOW => random.below(3),
            h if h < 40.0 => random.below(4),
            _ => 3 + random.below(3),
        };
        let floor = FACADES[kind].module[1];
        let whole = |h: f32| (h / floor).round().max(1.0) * floor;
        if height < LOW {
            let top = whole(height - 3.0);
            self.wall(kind, lower, upper, [0.0, top]);
            self.gable(kind, lower, upper, top, random.below(2) == 0);
            return;
        }
        // Towers step back twice.
        let tiers = match height {
            h if h < 45.0 => 1,
            h if h < 80.0 => 2,
            _ => 3,
        };
        let (mut lower, mut upper, mut base) = (lower, upper, 0.0);
        for tier in 0..tiers {
            let top = if tier + 1 == tiers {
                height
            } else {
                height * [0.55, 0.82][tier]
            };
            let top = base + whole(top - base);
            self.wall(kind, lower, upper, [base, top + 0.9]);
            self.roof(lower, upper, top);
            base = top;
            let step = 0.14 * (upper[0] - lower[0]).min(upper[1] - lower[1]);
            lower = lower.map(|x| x + step);
            upper = upper.map(|x| x - step);
        }
        // The machine room of the lift.
        let [x, z] = [0, 1].map(|k| lower[k] + (upper[k] - lower[k]) * random.between(0.2, 0.5));
        let room = [[x, z], [x + 3.1, z + 2.6]];
        block(&mut self.flat, room[0], room[1], [base, base + 2.7]);
    }

    /// Four walls, with a whole number of windows along each.
    fn wall(&mut self, kind: usize, [x0, z0]: [f32; 2], [x1, z1]: [f32; 2], [low, high]: [f32; 2]) {
        let mesh = &mut self.walls[kind];
        let [width, floor] = FACADES[kind].module;
        let rows = (high - low) / floor;
        for ([ax, az], [bx, bz]) in [
            ([x0, z1], [x1, z1]),
            ([x1, z1], [x1, z0]),
            ([x1, z0], [x0, z0]),
            ([x0, z0], [x0, z1]),
        ] {
            let length = (bx - ax).abs() + (bz - az).abs();
            let columns = (length / width).round().max(1.0);
            let corners = [[ax, low, az], [bx, low, bz], [bx, high, bz], [ax, high, az]];
            quad(mesh, corners);
            // From the foot up, so that windows stand on floors.
            mesh.uvs
                .extend([[0.0, 0.0], [columns, 0.0], [columns, -rows], [0.0, -rows]]);
        }
    }

    /// A flat roof.
    fn roof(&mut self, [x0, z0]: [f32; 2], [x1, z1]: [f32; 2], y: f32) {
        quad(
            &mut self.flat,
            [[x0, y, z1], [x1, y, z1], [x1, y, z0], [x0, y, z0]],
        );
    }

    /// A roof with a ridge along x or z, its eaves beyond the walls, and the two triangles of wall below it.
    fn gable(&mut self, kind: usize, lower: [f32; 2], upper: [f32; 2], base: f32, along_x: bool) {
        let across = usize::from(along_x);
        let half = 0.5 * (upper[across] - lower[across]);
        let (pitch, eaves) = (0.75, 0.45);
        let middle = lower[across] + half;
        let ridge = base + pitch * half;
        // A point by its place along the ridge, its place across, and its height.
        let point = |along: f32, across: f32, y: f32| {
            if along_x {
                [along, y, across]
            } else {
                [across, y, along]
            }
        };
        let (from, to) = (lower[1 - across], upper[1 - across]);
        for (side, end) in [
            (lower[across] - eaves, 1.0_f32),
            (upper[across] + eaves, -1.0),
        ] {
            let foot = base - pitch * eaves;
            let mut corners = [
                point(from - eaves, side, foot),
                point(to + eaves, side, foot),
                point(to + eaves, middle, ridge),
                point(from - eaves, middle, ridge),
            ];
            // Counter-clockwise from above, whichever way the ridge runs.
            if (end > 0.0) == along_x {
                corners.reverse();
            }
            quad(&mut self.tiles, corners);
        }
        let mesh = &mut self.walls[kind];
        for (end, outwards) in [(from, -1.0_f32), (to, 1.0)] {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([
                point(end, lower[across], base),
                point(end, upper[across], base),
                point(end, middle, ridge - 0.02),
            ]);
            // Plain wall: the corner of the picture.
            mesh.uvs.extend([[0.02, 0.02]; 3]);
            let [a, b, c] = [first, first + 1, first + 2];
            mesh.triangles.push(if (outwards > 0.0) == along_x {
                [a, c, b]
            } else {
                [a, b, c]
            });
        }
    }

    fn scene(mut self, lots: &[Lot], radius: f32) -> Scene {
        let mut stage = Stage::default();
        for lot in lots {
            // Pavements of neighbours meet and do not overlap.
            let [x0, z0] = lot.lower;
            let [x1, z1] = lot.upper;
            block(&mut self.pavement, [x0, z0], [x1, z1], [0.0, 0.12]);
        }
        for (facade, mesh) in FACADES.iter().zip(self.walls) {
            if mesh.triangles.is_empty() {
                continue;
            }
            let glassy = if facade.name == "glass" { 0.15 } else { 0.7 };
            let mut material = paint(facade.name, [1.0; 3], glassy);
            if let Some(picture) = facade.picture() {
                stage.scene.images.push(picture);
                let image = stage.scene.images.len() as u32 - 1;
                material = Material {
                    base_color_map: Some(TextureMap::new(image)),
                    ..material
                };
            }
            let material = stage.material(material);
            stage.build(facade.name, mesh, material);
        }
        for (name, color, mesh) in [
            ("roof tiles", [0.3, 0.085, 0.045], self.tiles),
            ("flat roofs", [0.3, 0.29, 0.28], self.flat),
            ("pavement", [0.36, 0.35, 0.33], self.pavement),
        ] {
            if !mesh.triangles.is_empty() {
                let material = stage.material(paint(name, color, 0.9));
                stage.build(name, mesh, material);
            }
        }
        let asphalt = stage.material(paint("asphalt", [0.1, 0.1, 0.105], 0.95));
        let meadow = stage.material(paint("meadow", [0.13, 0.19, 0.06], 1.0));
        let mut ground = facets(Vec::new(), Vec::new());
        let (town, country) = (radius + 60.0, 12.0 * radius);
        disc(&mut ground, town, 0.0);
        stage.build("streets", ground, asphalt);
        let mut around = facets(Vec::new(), Vec::new());
        disc(&mut around, country, -0.05);
        stage.build("country", around, meadow);
        stage.scene
    }
}

/// A box with a top and four sides; nobody sees it from below.
fn block(mesh: &mut Mesh, [x0, z0]: [f32; 2], [x1, z1]: [f32; 2], [low, high]: [f32; 2]) {
    quad(
        mesh,
        [
            [x0, high, z1],
            [x1, high, z1],
            [x1, high, z0],
            [x0, high, z0],
        ],
    );
    for ([ax, az], [bx, bz]) in [
        ([x0, z1], [x1, z1]),
        ([x1, z1], [x1, z0]),
        ([x1, z0], [x0, z0]),
        ([x0, z0], [x0, z1]),
    ] {
        quad(
            mesh,
            [[ax, low, az], [bx, low, bz], [bx, high, bz], [ax, high, az]],
        );
    }
}

/// Two triangles with corners of their own, counter-clockwise from the front.
fn quad(mesh: &mut Mesh, corners: [[f32; 3]; 4]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles
        .extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|k| first + k)));
}

/// A disc about the origin that faces up.
fn disc(mesh: &mut Mesh, radius: f32, y: f32) {
    const PIECES: u32 = 64;
    mesh.positions.push([0.0, y, 0.0]);
    for i in 0..PIECES {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(PIECES));
        mesh.positions
            .push([radius * cos as f32, y, radius * sin as f32]);
        mesh.triangles.push([0, 1 + (i + 1) % PIECES, 1 + i]);
    }
}
