//! Thousands of seats: one mesh per colour, placed row by row, with the name of the house in the upper tier.

use super::oval::{Oval, Station};
use super::solids::{frame, prism};
use super::stage::{Stage, paint};
use crate::scene::Mesh;
use boxwood::Vec3;

/// Rows of steps that rise outwards, all as deep and as high.
pub(super) struct Tier {
    pub rows: u32,
    /// Where the first row begins and the height of its floor.
    pub first: [f32; 2],
    /// Depth and rise of a row.
    pub step: [f32; 2],
    /// Whether its seats show the writing.
    pub writing: bool,
}

impl Tier {
    /// Where row `row` begins and the height of its floor.
    pub fn row(&self, row: u32) -> [f32; 2] {
        [0, 1].map(|k| self.first[k] + row as f32 * self.step[k])
    }
}

/// From the middle of a seat to the next, in metres.
const SPACING: f32 = 0.8;
/// Of so many seats along a straight side one is left out for an aisle. A letter and its gap are as wide.
const BLOCK: u32 = 12;
/// Aisles in a round corner.
const CORNER_AISLES: u32 = 4;

const COLORS: [(&str, [f32; 3]); 3] = [
    ("seat, navy", [0.012, 0.035, 0.14]),
    ("seat, blue", [0.03, 0.13, 0.42]),
    ("seat, cream", [0.85, 0.79, 0.64]),
];
const NAVY: usize = 0;
const BLUE: usize = 1;
const CREAM: usize = 2;

/// Seats for every row of the tiers.
pub(super) fn seats(stage: &mut Stage, oval: &Oval, tiers: &[Tier]) {
    let meshes = COLORS.map(|(name, color)| {
        let material = stage.material(paint(name, color, 0.45));
        stage.mesh(name, seat(), material)
    });
    for tier in tiers {
        for row in 0..tier.rows {
            let [begin, floor] = tier.row(row);
            let mut place = |station: Station, color: usize| {
                let up = Vec3::new(0.0, 1.0, 0.0);
                let origin = station.point(begin + 0.6 * tier.step[0], floor);
                let transform = frame(station.along(), up, station.outwards * -1.0, origin);
                stage.place(meshes[color], transform);
            };
            for (k, (middle, length)) in oval.sides().into_iter().enumerate() {
                let count = (length / SPACING) as u32;
                for column in (0..count).filter(|c| c % BLOCK != AISLE) {
                    let offset = (column as f32 + 0.5 - count as f32 / 2.0) * SPACING;
                    let at = middle.at + middle.along() * offset;
                    let long = k % 2 == 0;
                    place(
                        Station { at, ..middle },
                        color(tier, row, column, long.then_some(count)),
                    );
                }
                let arc = (oval.corner + begin) * std::f32::consts::FRAC_PI_2;
                let count = (arc / SPACING) as u32;
                for column in 0..count {
                    let share = (f64::from(column) + 0.5) / f64::from(count);
                    let block = share * f64::from(CORNER_AISLES);
                    let to_aisle = (block - libm::floor(block) - 0.5).abs() * f64::from(arc)
                        / f64::from(CORNER_AISLES);
                    if to_aisle > 0.6 {
                        place(
                            oval.in_corner(k, share),
                            color(tier, row, (share * 60.0) as u32, None),
                        );
                    }
                }
            }
        }
    }
}

/// A seat without legs, 0.7 m wide, its floor at y = 0 and the view towards +z: a solid L of 20 triangles.
fn seat() -> Mesh {
    let profile = [
        [0.43, -0.12],
        [0.43, 0.25],
        [-0.02, 0.25],
        [-0.02, -0.2],
        [0.85, -0.28],
        [0.85, -0.2],
    ];
    prism(&profile, -0.35, 0.35)
}

/// The colour of a seat; `side` is how many seats the row has where there is room for the writing.
fn color(tier: &Tier, row: u32, column: u32, side: Option<u32>) -> usize {
    if tier.writing {
        let written = side.is_some_and(|count| is_written(row, column, count));
        let border = row == 0 || row + 1 == tier.rows;
        [if border { BLUE } else { NAVY }, CREAM][usize::from(written)]
    } else {
        [BLUE, CREAM, BLUE, NAVY][((column + row) / 6 % 4) as usize]
    }
}

/// The letters of the writing: 5 by 7 points, a bit each, the leftmost highest.
const B: [u8; 7] = [
    0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110,
];
const O: [u8; 7] = [
    0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110,
];
const X: [u8; 7] = [
    0b10001, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001, 0b10001,
];
const W: [u8; 7] = [
    0b10001, 0b10001, 0b10101, 0b10101, 0b10101, 0b11111, 0b01010,
];
const D: [u8; 7] = [
    0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110,
];
const WRITING: [[u8; 7]; 7] = [B, O, X, W, O, O, D];

/// A point of a letter is two seats wide and two rows high; the gap after a letter is one point.
const POINT: u32 = 2;
/// The first column of the writing in a row of `count`, and the aisles that its gaps leave room for.
const fn first_column(count: u32) -> u32 {
    (count - (WRITING.len() as u32 * BLOCK - POINT)) / 2
}
/// The column of a block that is an aisle: the first of a gap in the rows that hold the writing.
const AISLE: u32 = (first_column(100) + BLOCK - POINT) % BLOCK;

fn is_written(row: u32, column: u32, count: u32) -> bool {
    let width = WRITING.len() as u32 * BLOCK - POINT;
    if count < width || column < first_column(count) || row == 0 || row > 7 * POINT {
        return false;
    }
    let (x, y) = (column - first_column(count), 7 - row.div_ceil(POINT));
    let (letter, point) = (x / BLOCK, x % BLOCK / POINT);
    x < width && point < 5 && WRITING[letter as usize][y as usize] >> (4 - point) & 1 == 1
}
