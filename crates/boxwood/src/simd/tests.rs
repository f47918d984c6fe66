use super::*;

/// Asks one level, at width `N`, for the result of every operation, as bits.
struct Everything<const N: usize>([[f32; N]; 2], u64);

impl<const N: usize> Kernel<N> for Everything<N> {
    type Output = alloc::vec::Vec<u32>;
    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, s: S) -> Self::Output {
        let [a, b] = self.0.map(|row| F::<S, N>::load(s, &row));
        let order = U::<S, N>::from_nibbles(s, self.1);
        let floats = [
            a + b,
            a - b,
            a * b,
            a / b,
            a.min(b),
            a.max(b),
            a.product_error(b, a * b),
            a.permute(order),
            F::<S, N>::splat(s, 3.0),
        ];
        let mut out: alloc::vec::Vec<u32> = floats
            .iter()
            .flat_map(|x| x.to_array())
            .map(|x| if x.is_nan() { 0 } else { x.to_bits() })
            .collect();
        for mask in [a.le(b), a.lt(b), a.le(b) & b.le(a), a.lt(b) | b.lt(a)] {
            out.push(mask.bits());
            let mut stack = Stack::new();
            stack.push::<S, N>(
                U::<S, N>::load(s, &core::array::from_fn(|i| i as u32)).permute(order),
                a,
                mask,
            );
            while let Some((child, entry)) = stack.pop() {
                out.extend([child, entry.to_bits()]);
            }
        }
        out
    }
}

fn agree<const N: usize>()
where
    Level: Vectorize<N>,
{
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.5,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        3.0e-39,
        7.25,
    ];
    for seed in 0..200_usize {
        let row = |k: usize| {
            core::array::from_fn(|i| {
                special[(seed * 7 + i * (3 + k) + k * seed / 3) % special.len()]
            })
        };
        let packed = (0..16).fold(0, |bits, i| {
            bits | (((seed * 5 + i * 11) % N) as u64) << (4 * i)
        });
        let expected =
            Level::Portable(Portable).vectorize(Everything::<N>([row(0), row(1)], packed));
        for level in Level::available() {
            assert_eq!(
                expected,
                level.vectorize(Everything::<N>([row(0), row(1)], packed)),
                "{level:?} seed {seed}"
            );
        }
    }
}

#[test]
fn every_level_means_what_portable_means() {
    agree::<4>();
    agree::<8>();
    agree::<16>();
}
