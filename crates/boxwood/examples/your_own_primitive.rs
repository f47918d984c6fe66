//! How do I trace rays against a shape that the library does not have?
//!
//! Say how many there are, where each lies and where a ray meets it: [`Primitives`]. Every structure and every query then
//! works with it. Here: a field of bowls, each a paraboloid `z = x² + y²` up to a height. Run by
//! `cargo run --example your_own_primitive`.

use boxwood::{
    Aabb, BinnedSah, Bvh, Counters, Hit, Intersect, PreparedRay, Primitives, Query, Ray, Surface,
    Surfaces, Vec3,
};
use std::ops::ControlFlow;

/// A bowl that opens upwards: `z − foot.z = x² + y²` around its foot, up to a height.
struct Bowl {
    foot: Vec3,
    height: f32,
}

struct Bowls(Vec<Bowl>);

impl Primitives for Bowls {
    fn len(&self) -> usize {
        self.0.len()
    }

    // The rim has the radius √height. Boxes may be larger than need be, never smaller.
    fn bounds(&self, i: usize) -> Aabb {
        let Bowl { foot, height } = &self.0[i];
        let rim = height.sqrt().next_up();
        let top = (foot.z + height).next_up();
        Aabb::new(
            [foot.x - rim, foot.y - rim, foot.z],
            [foot.x + rim, foot.y + rim, top],
        )
    }

    fn offer<Q: Query, C: Counters>(
        &self,
        i: usize,
        ray: &PreparedRay,
        query: &mut Q,
        _counters: &mut C,
    ) -> ControlFlow<()> {
        // In double precision: a t² + 2 b t + c = 0.
        let bowl = &self.0[i];
        let [ox, oy, oz] = (ray.origin - bowl.foot).to_array().map(f64::from);
        let [dx, dy, dz] = ray.direction.to_array().map(f64::from);
        let a = dx * dx + dy * dy;
        let b = ox * dx + oy * dy - 0.5 * dz;
        let c = ox * ox + oy * oy - oz;
        let root = (b * b - a * c).sqrt(); // NaN for a miss, and NaN passes none of the comparisons below.
        let q = -(b + root.copysign(b));
        for t in [q / a, c / q] {
            let height = oz + t * dz;
            let t = t as f32;
            let in_bowl = (0.0..=f64::from(bowl.height)).contains(&height);
            if in_bowl && ray.t_min <= t && t <= query.t_max() {
                query.offer(Hit {
                    t,
                    u: (height / f64::from(bowl.height)) as f32,
                    v: 0.0,
                    primitive: i as u32,
                    instance: 0,
                })?;
            }
        }
        ControlFlow::Continue(())
    }
}

// Only renderers ask this; queries do without.
impl Surfaces for Bowls {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let position = ray.at(hit.t);
        let p = position - self.0[hit.primitive as usize].foot;
        let normal = Vec3::new(2.0 * p.x, 2.0 * p.y, -1.0).normalized(); // outwards, down
        Surface {
            position,
            normal,
            front: normal.dot(ray.direction) < 0.0,
            uv: [hit.u, hit.v],
            error: 1.0e-6 * (position.abs().max_element() + hit.t * ray.direction.length()),
        }
    }
}

fn main() {
    let places = (0..100).map(|i| (i % 10, i / 10));
    let bowls = Bowls(
        places
            .map(|(x, y)| Bowl {
                foot: Vec3::new(x as f32, y as f32, 0.0),
                height: 0.2,
            })
            .collect(),
    );
    let bvh = Bvh::new(&bowls, BinnedSah::default().build(&bowls));
    let ray = Ray::new([-1.0, -0.9, 1.0], [1.0, 1.0, -0.12]);
    for hit in bvh.all_hits(&ray) {
        let surface = bowls.surface(&ray, &hit);
        println!(
            "bowl {:2} at t = {:.3}, {}, {:.0} % up",
            hit.primitive,
            hit.t,
            if surface.front { "outside" } else { "inside" },
            100.0 * hit.u
        );
    }
}
