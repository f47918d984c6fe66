//! Random numbers that are the same on every machine.

use boxwood::Vec3;

/// A generator with 64 bits of state. *Source.* Steele, Lea & Flood 2014, *Fast splittable pseudorandom number generators*
/// (SplitMix64).
pub(super) struct Random(u64);

impl Random {
    /// A generator of its own for each pair of seed and stream.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(mix(seed ^ mix(stream)))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        mix(self.0)
    }

    /// From 0 to 1, without 1: a multiple of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / (1 << 24) as f32)
    }

    /// From `low` to `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A number below `n`, which is at least 1.
    pub fn below(&mut self, n: usize) -> usize {
        (((self.bits() >> 32) * n as u64) >> 32) as usize
    }

    /// A point in the cube from −1 to 1.
    pub fn in_cube(&mut self) -> Vec3 {
        let [x, y, z] = [(); 3].map(|()| self.between(-1.0, 1.0));
        Vec3::new(x, y, z)
    }

    /// A unit vector, all directions alike.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let p = self.in_cube();
            let square = p.length_squared();
            if 0.01 < square && square < 1.0 {
                return p.normalized();
            }
        }
    }
}

const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Smooth random hills: a value for each point of the plane, and no two seeds alike.
///
/// *How it works.* A hash gives every whole point a slope; between them the slopes are blended by a quintic. *Source.*
/// Perlin 2002, *Improving Noise*.
#[derive(Clone, Copy)]
pub(super) struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(mix(seed.wrapping_add(STEP)))
    }

    /// About −1 to 1, with hills one unit wide.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (column, row) = (x.floor(), y.floor());
        let (fx, fy) = (x - column, y - row);
        let corner = |i: i64, j: i64| {
            let key = (column as i64 + i) as u64 & 0xffff_ffff | ((row as i64 + j) as u64) << 32;
            let [gx, gy] = SLOPES[(mix(self.0 ^ mix(key)) >> 60) as usize];
            gx * (fx - i as f64) + gy * (fy - j as f64)
        };
        let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let blend = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let (u, v) = (fade(fx), fade(fy));
        1.5 * blend(
            blend(corner(0, 0), corner(1, 0), u),
            blend(corner(0, 1), corner(1, 1), u),
            v,
        )
    }

    /// Hills upon hills: each octave is half as wide and half as high.
    pub fn octaves(&self, x: f64, y: f64, count: u32) -> f64 {
        let mut sum = 0.0;
        let (mut width, mut height) = (1.0, 0.5);
        for _ in 0..count {
            sum += height * self.at(x * width, y * width);
            (width, height) = (width * 2.03, height * 0.5);
        }
        sum
    }
}

/// Sixteen directions around the circle.
const SLOPES: [[f64; 2]; 16] = {
    let (c1, s1) = (0.923_879_532_511_286_7, 0.382_683_432_365_089_8);
    let h = std::f64::consts::FRAC_1_SQRT_2;
    [
        [1.0, 0.0],
        [c1, s1],
        [h, h],
        [s1, c1],
        [0.0, 1.0],
        [-s1, c1],
        [-h, h],
        [-c1, s1],
        [-1.0, 0.0],
        [-c1, -s1],
        [-h, -h],
        [-s1, -c1],
        [0.0, -1.0],
        [s1, -c1],
        [h, -h],
        [c1, -s1],
    ]
};
