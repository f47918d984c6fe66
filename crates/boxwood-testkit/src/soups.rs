//! Meshes that are degenerate on purpose: what scanners, exporters and numerical bad luck produce, in concentrated form.
//!
//! All lie within about `[-1, 1]³` unless they say otherwise; [`Model::placed`] brings them elsewhere.

use crate::{Model, Random};
use boxwood::Vec3;
use libm::{cos, sin};

/// Small triangles anywhere.
pub fn random(count: usize, random: &mut Random) -> Model {
    Model::of_triangles((0..count).map(|_| {
        let middle = random.in_cube();
        [(); 3].map(|()| (middle + random.in_cube() * 0.2).to_array())
    }))
}

/// Corners on a grid of whole numbers from 0 to 6: ties and triangles without area are frequent, arithmetic is exact.
pub fn grid(count: usize, random: &mut Random) -> Model {
    Model::of_triangles((0..count).map(|_| {
        let corner = [(); 3].map(|()| random.below(5) as f32);
        [(); 3].map(|()| corner.map(|x| x + random.below(3) as f32))
    }))
}

/// Overlapping triangles in one plane at right angles to an axis.
pub fn flat(count: usize, axis: usize, random: &mut Random) -> Model {
    let height = random.between(-1.0, 1.0);
    let mut model = self::random(count, random);
    for p in &mut model.positions {
        p[axis] = height;
    }
    model
}

/// Long triangles whose width is 10⁻¹ to 10⁻⁷ of their length, or nothing.
pub fn slivers(count: usize, random: &mut Random) -> Model {
    Model::of_triangles((0..count).map(|_| {
        let (a, along, aside) = (random.in_cube(), random.direction(), random.direction());
        let width =
            10.0_f32.powi(-(random.below(8) as i32)) * if random.one_in(8) { 0.0 } else { 1.0 };
        let part = random.unit();
        [a, a + along, a + along * part + aside * width].map(Vec3::to_array)
    }))
}

/// Each triangle up to eight times, with its corners in any order: every hit is a tie.
pub fn duplicates(count: usize, random: &mut Random) -> Model {
    let some = self::random(count / 4 + 1, random);
    Model {
        triangles: (0..count)
            .map(|_| {
                let mut t = random.pick(&some.triangles);
                t.rotate_left(random.below(3));
                if random.one_in(2) {
                    t.swap(0, 1);
                }
                t
            })
            .collect(),
        ..some
    }
}

/// Many thin triangles around one vertex.
pub fn fan(count: usize, random: &mut Random) -> Model {
    let (hub, up) = (random.in_cube() * 0.2, random.direction());
    let rim = (0..=count).map(|i| {
        let turn = std::f64::consts::TAU * i as f64 / count.max(1) as f64;
        let ring = Vec3::new(cos(turn) as f32, sin(turn) as f32, 0.0);
        (hub + ring + up * (0.3 * sin(5.0 * turn)) as f32).to_array()
    });
    Model {
        positions: std::iter::once(hub.to_array()).chain(rim).collect(),
        triangles: (1..=count as u32).map(|i| [0, i, i + 1]).collect(),
    }
}

/// Needles from one end of the scene to the other: every box overlaps every other.
pub fn needles(count: usize, random: &mut Random) -> Model {
    Model::of_triangles((0..count).map(|_| {
        let (a, b) = (random.in_cube(), random.in_cube());
        [a, b, b + random.in_cube() * 0.01].map(Vec3::to_array)
    }))
}

/// Upright unit squares' halves, one behind the other along x. Each step is `growth` times the one before, so that a
/// `growth` above 1 makes distances grow exponentially and drives the surface-area heuristic deep.
pub fn line(count: usize, first_step: f64, growth: f64) -> Model {
    let (mut x, mut step) = (0.0_f64, first_step);
    Model::of_triangles((0..count).map(|_| {
        let at = x as f32;
        (x, step) = (x + step, step * growth);
        [[at, 0.0, 0.0], [at, 1.0, 0.0], [at, 0.0, 1.0]]
    }))
}

/// The same triangle again and again.
pub fn identical(count: usize) -> Model {
    Model {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]],
        triangles: vec![[0, 1, 2]; count],
    }
}

/// Sizes from 10⁻⁷ to 1 side by side.
pub fn mixed_sizes(count: usize, random: &mut Random) -> Model {
    Model::of_triangles((0..count).map(|_| {
        let size = 10.0_f32.powi(-(random.below(8) as i32));
        let middle = random.in_cube() * random.pick(&[1.0, size]);
        [(); 3].map(|()| (middle + random.in_cube() * size).to_array())
    }))
}

/// Tiny triangles of one size, far apart.
pub fn specks(count: usize, size: f32, random: &mut Random) -> Model {
    Model::of_triangles((0..count).map(|_| {
        let middle = random.in_cube();
        [(); 3].map(|()| (middle + random.in_cube() * size).to_array())
    }))
}

/// Corners of any finite bits: from subnormal to the largest float.
pub fn any_floats(count: usize, random: &mut Random) -> Model {
    Model::of_triangles((0..count).map(|_| {
        [(); 3].map(|()| {
            [(); 3].map(|()| {
                let x = f32::from_bits(random.bits() as u32);
                if x.is_finite() {
                    x
                } else {
                    f32::MAX.copysign(x)
                }
            })
        })
    }))
}
