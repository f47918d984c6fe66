//! A small random generator: the same numbers for the same seed, on every machine and in every year.
//!
//! *Source.* Steele, Lea & Flood 2014, *Fast Splittable Pseudorandom Number Generators* (SplitMix64).

use boxwood::Vec3;

/// A stream of random numbers that follows from its seed.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream of a seed. Streams of different seeds have nothing in common.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// A whole number below `n`; 0 when `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        // The product's upper half: no bias that a test could see.
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }
    /// Whether a coin with the chance `1 / n` falls right.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
    /// One of some values.
    ///
    /// # Panics
    /// When there are none.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
    /// In `[0, 1)`, a multiple of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }
    /// In `[from, to)`, up to rounding.
    pub fn between(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * self.unit()
    }
    /// In the cube `[-1, 1)³`.
    pub fn in_cube(&mut self) -> Vec3 {
        let mut coordinate = || self.between(-1.0, 1.0);
        Vec3::new(coordinate(), coordinate(), coordinate())
    }
    /// A direction of length 1, each as likely as any other.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.in_cube();
            let square = v.length_squared();
            if (0.01..=1.0).contains(&square) {
                return v.normalized();
            }
        }
    }
    /// Weights of three corners that add up to 1.
    pub fn weights(&mut self) -> [f32; 3] {
        let (mut a, mut b) = (self.unit(), self.unit());
        if a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        [1.0 - a - b, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Other tests record figures of scenes made with it, so the stream must never change.
    #[test]
    fn the_stream_is_fixed() {
        let mut random = Random::new(0);
        assert_eq!(random.bits(), 0xe220_a839_7b1d_cdaf);
        assert_eq!(random.bits(), 0x6e78_9e6a_a1b9_65f4);
        assert_eq!(random.below(0), 0);
        assert!((0..1000).all(|_| random.below(3) < 3 && random.unit() < 1.0));
    }
}
