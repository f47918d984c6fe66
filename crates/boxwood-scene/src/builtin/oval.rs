//! The ground plan of a stadium: a rectangle with round corners, and all the curves that run beside it.
//!
//! *How it works.* Stations stand along the innermost curve, each with the direction outwards. The curve at a distance
//! `d` goes through every station moved out by `d`, so that straight sides stay straight, corners stay round, and
//! everything built along the curves shares its stations. [`Oval::sweep`] leads a profile around and closes on itself.

use super::solids::facets;
use crate::scene::Mesh;
use boxwood::Vec3;

/// A rectangle with round corners on the plane `y = 0`, its middle at the origin.
pub(super) struct Oval {
    /// Half the length along x and along z.
    pub half: [f32; 2],
    /// Radius of the corners.
    pub corner: f32,
    /// Pieces that a corner is cut into.
    pub pieces: u32,
}

/// A place on the curve.
#[derive(Clone, Copy)]
pub(super) struct Station {
    /// On the innermost curve.
    pub at: Vec3,
    /// Unit vector outwards.
    pub outwards: Vec3,
}

impl Station {
    /// The way on, clockwise from above: to the right for somebody who stands inside and looks outwards.
    pub fn along(&self) -> Vec3 {
        Vec3::new(-self.outwards.z, 0.0, self.outwards.x)
    }
    /// `distance` further out, at a height.
    pub fn point(&self, distance: f32, height: f32) -> Vec3 {
        self.at + self.outwards * distance + Vec3::new(0.0, height, 0.0)
    }
}

impl Oval {
    /// The straight sides: the middle of each, and its length. First the one at −z, then clockwise from above.
    pub fn sides(&self) -> [(Station, f32); 4] {
        std::array::from_fn(|k| {
            let outwards = quarter(k);
            let (reach, length) = if k % 2 == 0 {
                (self.half[1], self.half[0])
            } else {
                (self.half[0], self.half[1])
            };
            let middle = Station {
                at: outwards * reach,
                outwards,
            };
            (middle, 2.0 * (length - self.corner))
        })
    }

    /// A place in corner `k`, which follows side `k`, at a share between 0 and 1 of the way through it.
    pub fn in_corner(&self, k: usize, share: f64) -> Station {
        let (from, to) = (quarter(k), quarter(k + 1));
        let inner = [self.half[0] - self.corner, self.half[1] - self.corner];
        let center = (from + to) * Vec3::new(inner[0], 0.0, inner[1]);
        let (sin, cos) = libm::sincos(share * std::f64::consts::FRAC_PI_2);
        let outwards = from * cos as f32 + to * sin as f32;
        Station {
            at: center + outwards * self.corner,
            outwards,
        }
    }

    /// All stations in their order; the last piece leads back to the first.
    pub fn stations(&self) -> Vec<Station> {
        let share = |i: u32| f64::from(i) / f64::from(self.pieces);
        (0..4)
            .flat_map(|k| (0..=self.pieces).map(move |i| self.in_corner(k, share(i))))
            .collect()
    }

    /// Leads a closed profile of points `[distance outwards, height]` around the curve: a closed ring.
    ///
    /// The profile is counter-clockwise with outwards to the right and height up.
    pub fn sweep(&self, profile: &[[f32; 2]]) -> Mesh {
        let stations = self.stations();
        let (rings, n) = (stations.len() as u32, profile.len() as u32);
        let positions = stations
            .iter()
            .flat_map(|s| profile.iter().map(|&[d, y]| s.point(d, y).to_array()))
            .collect();
        let mut triangles = Vec::new();
        for ring in 0..rings {
            let (here, there) = (ring * n, (ring + 1) % rings * n);
            for j in 0..n {
                let next = (j + 1) % n;
                let [a, b, c, d] = [here + j, here + next, there + next, there + j];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        facets(positions, triangles)
    }
}

/// −z, +x, +z, −x: outwards from side `k`.
fn quarter(k: usize) -> Vec3 {
    match k % 4 {
        0 => Vec3::new(0.0, 0.0, -1.0),
        1 => Vec3::new(1.0, 0.0, 0.0),
        2 => Vec3::new(0.0, 0.0, 1.0),
        _ => Vec3::new(-1.0, 0.0, 0.0),
    }
}
