//! Well spread sample points that depend on nothing but the pixel and the sample's number.
//!
//! *How it works.* The points are those of Sobol's first two dimensions, which fill the square evenly for every power of
//! two of samples (and well enough between). Hash-based Owen scrambling gives each pixel and each purpose its own set, so
//! that errors of neighbours do not look alike. There is no state: any thread may ask for any sample.
//!
//! *Source.* Burley 2020, *Practical Hash-based Owen Scrambling*; the integer hash is Wellons' `lowbias32`.

/// The samples of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    pixel: u32,
    /// Number of the sample in its pixel.
    pub index: u32,
}

impl Samples {
    /// Sample `index` of a pixel.
    pub fn new([x, y]: [u32; 2], index: u32) -> Self {
        Self {
            pixel: hash(x ^ hash(y ^ 0x9e37_79b9)),
            index,
        }
    }

    /// The `j`-th of `count` points in the unit square for a purpose; all samples of the pixel share one well spread set.
    pub fn pair(&self, purpose: u32, count: u32, j: u32) -> [f32; 2] {
        let seed = hash(self.pixel ^ hash(purpose));
        let index = self.index.wrapping_mul(count).wrapping_add(j);
        let i = scramble(index, seed);
        let x = scramble(i.reverse_bits(), hash(seed ^ 0x85eb_ca6b));
        let y = scramble(second_dimension(i), hash(seed ^ 0xc2b2_ae35));
        [unit(x), unit(y)]
    }
}

/// A hash of 32 bits in which every bit of the input stirs every bit of the output.
pub fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// `[0, 1)`.
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

/// Owen's nested uniform scrambling by the permutation of Laine and Karras, with Burley's constants.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits().wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// The second coordinate of Sobol's sequence; the first is the reversed index. Bit `k` of the index stands for `(1 + x)^k` modulo
/// 2, and `(1 + x)^(2^j) = 1 + x^(2^j)`: so the upper half of the bits is added to the lower one, then in both halves the same.
fn second_dimension(i: u32) -> u32 {
    let mut y = i.reverse_bits();
    y ^= y << 16;
    y ^= (y & 0x00ff_00ff) << 8;
    y ^= (y & 0x0f0f_0f0f) << 4;
    y ^= (y & 0x3333_3333) << 2;
    y ^ (y & 0x5555_5555) << 1
}

/// A tent of half width 0.75 around 0: where in its pixel (and a little beyond) a sample lies, so that the plain mean of
/// a pixel's samples is a filtered one.
pub fn tent(u: f32) -> f32 {
    let side = 2.0 * u - 1.0;
    0.75 * (1.0 - (1.0 - side.abs()).sqrt()).copysign(side)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sixteen samples: one in each cell of 16 × 1, 8 × 2, 4 × 4, 2 × 8 and 1 × 16.
    #[test]
    fn samples_are_stratified_every_way() {
        for pixel in 0..50 {
            for bits in 0..=4 {
                let (columns, rows) = (1 << bits, 16 >> bits);
                let mut seen = [false; 16];
                for index in 0..16 {
                    let [x, y] = Samples::new([pixel, 3], index).pair(7, 1, 0);
                    let cell = (x * columns as f32) as usize * rows + (y * rows as f32) as usize;
                    assert!(
                        !seen[cell],
                        "pixel {pixel}, {columns} columns: {cell} twice"
                    );
                    seen[cell] = true;
                }
            }
        }
    }

    /// Sobol's direction numbers one by one: each is the one before, added to itself moved by a bit.
    #[test]
    fn the_second_dimension_is_sobols() {
        for i in (0..4096).chain((0..4096).map(hash)) {
            let (mut sum, mut direction) = (0, 1_u32 << 31);
            for k in 0..32 {
                if i >> k & 1 == 1 {
                    sum ^= direction;
                }
                direction ^= direction >> 1;
            }
            assert_eq!(second_dimension(i), sum, "{i}");
        }
    }

    #[test]
    fn several_points_a_sample_continue_the_set() {
        let a = Samples::new([5, 6], 1).pair(2, 4, 3);
        let b = Samples::new([5, 6], 7).pair(2, 1, 0);
        assert_eq!(a, b);
    }

    #[test]
    fn the_tent_is_even_and_bounded() {
        assert_eq!(tent(0.5), 0.0);
        assert_eq!(tent(0.0), -0.75);
        assert!((tent(0.25) + tent(0.75)).abs() < 1.0e-6);
        assert!((tent(0.875) - 0.375).abs() < 1.0e-6);
    }
}
