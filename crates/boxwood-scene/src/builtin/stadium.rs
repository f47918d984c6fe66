//! The building: two tiers of steps under a roof ring, with boards, ribs, lamps and flags. 186 m by 148 m, 26 m high.
//!
//! *How it works.* Everything that runs around is a profile swept along the [`Oval`]; everything that repeats is one
//! mesh with many placements. Parts that touch are sunk into each other, so that no two faces share a plane.

use super::oval::{Oval, Station};
use super::seats::{Tier, seats};
use super::solids::{cuboid, frame, prism, set_down};
use super::stage::{Stage, paint};
use boxwood::{Affine, Vec3};

/// The innermost curve: the front of the stands.
pub(super) const OVAL: Oval = Oval {
    half: [60.0, 41.0],
    corner: 20.0,
    pieces: 14,
};

const TIERS: [Tier; 2] = [
    Tier {
        rows: 14,
        first: [0.3, 1.2],
        step: [0.9, 0.45],
        writing: false,
    },
    Tier {
        rows: 16,
        first: [14.8, 10.2],
        step: [0.9, 0.7],
        writing: true,
    },
];

/// Puts the building up.
pub(super) fn stadium(stage: &mut Stage) {
    let concrete = stage.material(paint("concrete", [0.27, 0.265, 0.255], 0.9));
    let steel = stage.material(paint("steel, white", [0.78, 0.79, 0.8], 0.4));
    let membrane = stage.material(paint("roof membrane", [0.82, 0.82, 0.8], 0.7));

    stage.build("bowl", OVAL.sweep(&bowl()), concrete);
    stage.build("roof", OVAL.sweep(&ROOF), membrane);
    seats(stage, &OVAL, &TIERS);
    boards(stage);
    ribs(stage, steel);
    flags(stage, steel);
}

/// The cross-section of the stands.
fn bowl() -> Vec<[f32; 2]> {
    let mut profile = vec![[0.0, -0.5], [0.0, 2.0], [0.3, 2.0]];
    for (tier, end) in TIERS.iter().zip([14.5, 31.0]) {
        for row in 0..tier.rows {
            let [begin, floor] = tier.row(row);
            let end = if row + 1 < tier.rows {
                begin + tier.step[0]
            } else {
                end
            };
            profile.extend([[begin, floor], [end, floor]]);
        }
        // The parapet behind the last row.
        if end < 20.0 {
            profile.extend([[end, 11.0], [end + 0.3, 11.0]]);
        }
    }
    profile.extend([[31.0, 22.0], [31.6, 22.0], [31.6, -0.5]]);
    profile.reverse();
    profile
}

const ROOF: [[f32; 2]; 4] = [[25.0, 26.0], [33.0, 23.8], [33.0, 24.2], [25.0, 26.5]];

/// Where pennants fly to, in degrees from +z towards +x.
pub(super) const WIND: f64 = 75.0;

/// Bright boards along the pitch and between the tiers.
fn boards(stage: &mut Stage) {
    let fascia = stage.material(paint("fascia", [0.75, 0.2, 0.05], 0.5));
    stage.build(
        "fascia",
        OVAL.sweep(&[[14.4, 8.9], [14.6, 8.9], [14.6, 10.3], [14.4, 10.3]]),
        fascia,
    );
    let colors = [
        ("board, red", [0.62, 0.06, 0.04]),
        ("board, white", [0.8, 0.8, 0.78]),
        ("board, yellow", [0.85, 0.55, 0.05]),
    ];
    let meshes = colors.map(|(name, color)| {
        let material = stage.material(paint(name, color, 0.4));
        let board = cuboid([-2.48, -0.1, -0.1], [2.48, 1.1, 0.15]);
        stage.mesh(name, board, material)
    });
    for (middle, length) in OVAL.sides() {
        let count = (length / 5.0) as usize;
        for i in 0..count {
            let offset = (i as f32 + 0.5 - count as f32 / 2.0) * 5.0;
            let at = middle.at + middle.along() * offset;
            let transform = inwards(&Station { at, ..middle });
            stage.place(meshes[i % 3], transform);
        }
    }
}

/// A frame at a station: x along the curve, y up, z inwards.
fn inwards(station: &Station) -> Affine {
    let up = Vec3::new(0.0, 1.0, 0.0);
    frame(station.along(), up, station.outwards * -1.0, station.at)
}

/// Stations all around, evenly spread over sides and corners.
fn posts() -> Vec<Station> {
    let mut posts = Vec::new();
    for (k, (middle, length)) in OVAL.sides().into_iter().enumerate() {
        let count = (length / 8.0) as u32;
        for i in 0..=count {
            let offset = (i as f32 / count as f32 - 0.5) * length;
            let at = middle.at + middle.along() * offset;
            posts.push(Station { at, ..middle });
        }
        posts.extend((1..6).map(|i| OVAL.in_corner(k, f64::from(i) / 6.0)));
    }
    posts
}

/// Columns behind the stands, the beams that carry the roof, and lamps under its inner edge.
fn ribs(stage: &mut Stage, steel: u32) {
    let column = cuboid([-0.35, -0.5, -32.5], [0.35, 24.0, -31.5]);
    let column = stage.mesh("column", column, steel);
    // Corners as [height, −distance]; the upper two lie within the roof.
    let beam = [[25.65, -25.6], [22.3, -32.4], [24.1, -32.4], [26.0, -25.6]];
    let beam = stage.mesh("beam", prism(&beam, -0.15, 0.15), steel);
    let lamps = cuboid([-1.3, 25.55, -25.45], [1.3, 26.05, -25.15]);
    let lamps = stage.mesh("lamps", lamps, steel);
    for post in posts() {
        for part in [column, beam, lamps] {
            stage.place(part, inwards(&post));
        }
    }
}

/// Masts on the inner edge of the roof with pennants, all in the same wind.
fn flags(stage: &mut Stage, steel: u32) {
    let mast = cuboid([-0.07, 26.1, -25.97], [0.07, 31.4, -25.83]);
    let mast = stage.mesh("mast", mast, steel);
    let cloths = [
        ("pennant, red", [0.7, 0.05, 0.03]),
        ("pennant, yellow", [0.85, 0.6, 0.06]),
    ]
    .map(|(name, color)| {
        let material = stage.material(paint(name, color, 0.8));
        let corners = [[29.4, 0.05], [31.2, 0.05], [30.3, 3.4]];
        stage.mesh(name, prism(&corners, -0.02, 0.02), material)
    });
    for (i, post) in posts().iter().step_by(2).enumerate() {
        stage.place(mast, inwards(post));
        let foot = post.point(25.9, 0.0).to_array();
        stage.place(cloths[i % 2], set_down(WIND, 1.0, foot));
    }
}
