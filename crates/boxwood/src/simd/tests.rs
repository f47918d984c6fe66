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
            a.abs(),
            a.signed_as(b),
            a.product_error(b, a * b),
            a.permute(order),
            a.choose(a.le(b), b),
            a.choose(b.lt(a), b),
            F::<S, N>::splat(s, 3.0),
        ];
        let mut out: alloc::vec::Vec<u32> = floats
            .iter()
            .flat_map(|x| x.to_array())
            .map(|x| if x.is_nan() { 0 } else { x.to_bits() })
            .collect();
        let bytes: [u8; N] = core::array::from_fn(|i| (self.1 >> (i % 8)) as u8 ^ (37 * i) as u8);
        let bytes = F::<S, N>::from_bytes(s, &bytes).to_array();
        out.extend(bytes.map(f32::to_bits));
        // Signs of NaN too.
        let signs = [a.abs(), a.signed_as(b)];
        out.extend(signs.iter().flat_map(|x| x.to_array()).map(f32::to_bits));
        for mask in [a.le(b), a.lt(b), a.le(b) & b.le(a), a.lt(b) | b.lt(a)] {
            out.push(mask.bits());
            let mut stack = Stack::<99>::new();
            stack.begin(77);
            let children = U::<S, N>::load(s, &core::array::from_fn(|i| i as u32)).permute(order);
            for _ in 0..2 {
                stack.top::<N>().push::<S>(children, a, mask);
            }
            stack.forget_beyond::<S, N>(s, 1.5);
            stack.top::<N>().push::<S>(children, a, mask);
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
        1.2345679,
        -7.6543e-5,
        3.3333334e20,
        -1.7e-30,
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
            let rows: [[f32; N]; 3] = [row(0), row(1), row(2)];
            let found = level.vectorize(TimesMore::<N>(rows));
            for ((found, x), (by, more)) in
                found.iter().zip(rows[0]).zip(rows[1].iter().zip(rows[2]))
            {
                let (once, twice) = (x.mul_add(*by, more), x * by + more);
                assert!(
                    *found == once || *found == twice || found.is_nan() && twice.is_nan(),
                    "{level:?}: {x:e} * {by:e} + {more:e} is {found:e}"
                );
            }
        }
    }
}

/// The one operation that may round once or twice.
struct TimesMore<const N: usize>([[f32; N]; 3]);

impl<const N: usize> Kernel<N> for TimesMore<N> {
    type Output = [f32; N];
    #[inline(always)]
    fn run<S: Simd + Lanes<N>>(self, s: S) -> [f32; N] {
        let [x, by, more] = &self.0;
        let load = F::<S, N>::load;
        load(s, x).times_more(load(s, by), load(s, more)).to_array()
    }
}

#[test]
fn every_level_means_what_portable_means() {
    agree::<4>();
    agree::<8>();
    agree::<16>();
}

/// What a ray is made ready with: directions kept away from zero, and whither they run.
///
/// Headings come from comparisons. Packed from shifted sign bits, `to_bits() >> 31`, they were once seen to come out with bit 31
/// set for a ray that runs up, where AVX-512 was compiled for (rustc 1.95, LLVM 22.1; right without its SLP vectoriser).
struct Headings([f32; 3]);

impl Kernel<16> for Headings {
    type Output = [u32; 8];
    #[inline(always)]
    fn run<S: Simd + Lanes<16>>(self, _: S) -> [u32; 8] {
        let (d, mut q) = (self.0, [0; 8]);
        for k in 0..3 {
            let away = if d[k].abs() < 1.0e-18 {
                1.0e-18_f32.copysign(d[k])
            } else {
                d[k]
            };
            q[k] = away.to_bits();
        }
        let (a, b, c) = (
            u32::from(d[0] < 0.0),
            u32::from(d[1] < 0.0),
            u32::from(d[2] < 0.0),
        );
        q[4] = a * 32;
        q[5] = 64 + b * 32;
        q[6] = 128 + c * 32;
        q[7] = a | b << 1 | c << 2;
        q
    }
}

#[test]
fn headings_are_right_at_every_level() {
    for level in Level::available() {
        for octant in 0..8_u32 {
            let down = [octant & 1, octant >> 1 & 1, octant >> 2 & 1];
            let d = down.map(|down| if down == 1 { -0.75 } else { 0.75 });
            let [a, b, c] = d.map(f32::to_bits);
            assert_eq!(
                level.vectorize(Headings(core::hint::black_box(d))),
                [
                    a,
                    b,
                    c,
                    0,
                    down[0] * 32,
                    64 + down[1] * 32,
                    128 + down[2] * 32,
                    octant
                ],
                "{level:?}"
            );
        }
    }
}
