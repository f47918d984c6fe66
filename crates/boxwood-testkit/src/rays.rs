//! Kinds of rays: what cameras send, and what finds the weak places of tests and traversals.

use crate::Random;
use boxwood::{Aabb, Intersect, Primitives, Ray, TriangleMesh, Vec3};

/// What rays are aimed at.
#[derive(Clone, Debug)]
pub struct Targets {
    corners: Vec<[Vec3; 3]>,
    middle: Vec3,
    /// Half the largest edge of the bounds; 1 when there are none.
    size: f32,
}

impl Targets {
    /// The triangles of a mesh.
    pub fn of_mesh(mesh: &TriangleMesh) -> Self {
        Self::new((0..mesh.len()).map(|i| mesh.triangle(i)))
    }
    /// Three corners of each box.
    pub fn of_boxes(primitives: &impl Primitives) -> Self {
        Self::new((0..primitives.len()).map(|i| {
            let b = primitives.bounds(i);
            [b.lower, b.upper, b.centroid()]
        }))
    }
    /// Triangles, wherever they come from.
    pub fn of_triangles(corners: impl IntoIterator<Item = [Vec3; 3]>) -> Self {
        Self::new(corners.into_iter())
    }
    fn new(corners: impl Iterator<Item = [Vec3; 3]>) -> Self {
        let corners: Vec<_> = corners.collect();
        let bounds = Aabb::of(corners.iter().flatten().copied());
        let half = bounds.size().max_element() * 0.5;
        Self {
            corners,
            middle: if bounds.is_empty() {
                Vec3::ZERO
            } else {
                bounds.centroid()
            },
            size: if half > 0.0 {
                half.min(f32::MAX / 4.0)
            } else {
                1.0
            },
        }
    }
    fn triangle(&self, random: &mut Random) -> [Vec3; 3] {
        if self.corners.is_empty() {
            return [random.in_cube(), random.in_cube(), random.in_cube()];
        }
        random.pick(&self.corners)
    }
    fn vertex(&self, random: &mut Random) -> Vec3 {
        let corner = random.below(3);
        self.triangle(random)[corner]
    }
    fn on_edge(&self, random: &mut Random) -> Vec3 {
        let [a, b, _] = self.triangle(random);
        a + (b - a) * random.unit()
    }
    fn on_surface(&self, random: &mut Random) -> Vec3 {
        let ([a, b, c], w) = (self.triangle(random), random.weights());
        a * w[0] + b * w[1] + c * w[2]
    }
    /// A point around the scene, mostly outside.
    fn around(&self, random: &mut Random) -> Vec3 {
        self.middle + random.in_cube() * (3.0 * self.size)
    }
}

/// Makes a ray of one kind.
pub type Kind = fn(&Targets, &mut Random) -> Ray;

/// All kinds, by name.
pub const KINDS: [(&str, Kind); 16] = [
    ("camera", |t, r| {
        let eye = t.middle + r.direction() * (2.5 * t.size);
        Ray::new(eye, (t.middle + r.in_cube() * t.size - eye).normalized())
    }),
    ("at a vertex", |t, r| aimed(t.around(r), t.vertex(r))),
    ("at an edge", |t, r| aimed(t.around(r), t.on_edge(r))),
    ("at the surface", |t, r| aimed(t.around(r), t.on_surface(r))),
    ("from the surface", |t, r| {
        Ray::new(t.on_surface(r), r.direction() * t.size)
    }),
    ("from a vertex", |t, r| aimed(t.vertex(r), t.on_surface(r))),
    ("up to the surface", |t, r| {
        Ray::between(t.around(r), t.on_surface(r))
    }),
    ("in the plane", in_plane),
    ("axis-parallel", |t, r| axis_parallel(t, r, 2)),
    ("along a coordinate plane", |t, r| axis_parallel(t, r, 1)),
    ("far", |t, r| {
        let far = t.middle + r.direction() * (2.0e4 * t.size);
        aimed(far, t.vertex(r))
    }),
    ("far, at the surface", |t, r| {
        let far = t.middle + r.direction() * (2.0e4 * t.size);
        aimed(far, t.on_surface(r))
    }),
    ("tiny and huge directions", |t, r| {
        let ray = aimed(t.around(r), t.on_surface(r));
        let power = r.pick(&[-120, -41, -39, -30, -20, 20, 30, 39, 41, 100]);
        let by = 2.0_f32.powi(power) / t.size;
        Ray::new(ray.origin, ray.direction * by)
    }),
    ("nearly along an axis", |t, r| {
        let (origin, axis) = (t.around(r), r.below(3));
        let mut d = t.on_surface(r) - origin;
        for k in 0..3 {
            if k != axis {
                d = scaled(d, k, 10.0_f32.powi(-(r.below(46) as i32)));
            }
        }
        Ray::new(t.on_surface(r) - d, d)
    }),
    ("turned round", |t, r| {
        let ray = aimed(t.around(r), t.on_surface(r));
        let (a, b) = (r.between(-2.0, 2.0), r.between(-2.0, 2.0));
        ray.from(a).until(b)
    }),
    ("special values", |t, r| {
        const SPECIAL: [f32; 12] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            1.0e-45,
            -1.0e-38,
            1.0e30,
            f32::MAX,
            f32::MIN,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
        ];
        let ray = aimed(t.around(r), t.vertex(r));
        let mut values = [
            ray.origin.x,
            ray.origin.y,
            ray.origin.z,
            ray.t_min,
            ray.direction.x,
            ray.direction.y,
            ray.direction.z,
            ray.t_max,
        ];
        for _ in 0..=r.below(2) {
            let place = r.below(8);
            values[place] = r.pick(&SPECIAL);
        }
        let [x, y, z, t_min, dx, dy, dz, t_max] = values;
        Ray::new([x, y, z], [dx, dy, dz]).from(t_min).until(t_max)
    }),
];

/// Through a point, with a direction that ends there or goes on, of any ordinary length.
fn aimed(from: Vec3, at: Vec3) -> Ray {
    Ray::new(from, at - from)
}

/// In a triangle's own plane, from outside: the edge functions are nearly or exactly zero.
fn in_plane(t: &Targets, r: &mut Random) -> Ray {
    let [a, b, c] = t.triangle(r);
    let point = |r: &mut Random, reach: f32| {
        a + (b - a) * r.between(-reach, reach) + (c - a) * r.between(-reach, reach)
    };
    let from = point(r, 4.0);
    let at = if r.one_in(2) { b } else { point(r, 1.0) };
    aimed(from, at)
}

/// Through a vertex, hence in the side of a box, with `zeros` coordinates of the direction zero of either sign.
fn axis_parallel(t: &Targets, r: &mut Random, zeros: usize) -> Ray {
    let (vertex, first) = (t.vertex(r), r.below(3));
    let mut d = r.direction() * t.size;
    for k in 0..zeros {
        d = scaled(d, (first + k) % 3, 0.0);
    }
    let start = if r.one_in(4) { 0.0 } else { -3.0 };
    let mut origin = vertex + d * start;
    if r.one_in(3) {
        // Exactly in the plane of another vertex.
        origin = with(origin, first, t.vertex(r)[first]);
    }
    Ray::new(origin, d)
}

fn scaled(v: Vec3, axis: usize, by: f32) -> Vec3 {
    with(v, axis, v[axis] * by)
}

fn with(mut v: Vec3, axis: usize, value: f32) -> Vec3 {
    v[axis] = value;
    v
}

/// `count` rays of one kind. Every fourth that the judge sees hit gets an interval that ends or begins at a hit, or at
/// the float before or after it.
pub fn sample(
    kind: Kind,
    count: usize,
    targets: &Targets,
    judge: &dyn Intersect,
    random: &mut Random,
) -> Vec<Ray> {
    let mut ray = |_| {
        let ray = kind(targets, random);
        if !random.one_in(4) {
            return ray;
        }
        let hits = judge.all_hits(&ray);
        if hits.is_empty() {
            return ray;
        }
        let t = hits[random.below(hits.len())].t;
        let t = random.pick(&[t, t, t.next_up(), t.next_down()]);
        match random.below(3) {
            0 => ray.until(t),
            1 => ray.from(t),
            _ => ray.from(t).until(t),
        }
    };
    (0..count).map(&mut ray).collect()
}
