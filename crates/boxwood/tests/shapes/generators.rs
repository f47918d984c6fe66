//! Random rays and scattered shapes.

use boxwood::{
    Aabb, BruteForce, Cuboid, Cylinder, Disc, Intersect, OrientedCuboid, Plane, Ray, Sphere,
    Surface, Surfaces, Torus, Vec3,
};

/// SplitMix64 (Steele, Lea & Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// From −1 to 1.
    pub fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
    pub fn point(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed()) * size
    }
    pub fn unit(&mut self) -> Vec3 {
        loop {
            let p = self.point(1.0);
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalized();
            }
        }
    }
    /// From outside or inside the ball of radius 2, through the ball of radius 1.2, of any length of direction.
    pub fn ray(&mut self) -> Ray {
        let origin = self.unit() * (1.0 + 1.5 * self.signed()).abs() * 2.0;
        let direction = self.point(0.7) - origin;
        Ray::new(
            origin,
            direction * 10.0_f32.powi((self.bits() % 7) as i32 - 3),
        )
    }
}

/// Random rays, and as many that pass a point of the surface nearly along it, off by 10⁻¹ to 10⁻⁸.
pub fn rays_at<S: Surfaces + Send + Sync>(primitives: &S, seed: u64, count: usize) -> Vec<Ray> {
    let mut random = Random(seed);
    let judge = BruteForce::new(primitives);
    let mut rays = Vec::new();
    while rays.len() < count {
        let ray = random.ray();
        rays.push(ray);
        let Some(hit) = judge.closest_hit(&ray) else {
            continue;
        };
        let Surface {
            position, normal, ..
        } = primitives.surface(&ray, &hit);
        let along = normal.cross(random.unit()).normalized();
        let off = 10.0_f32.powi(-1 - (random.bits() % 8) as i32) * random.signed();
        let speed = 10.0_f32.powi((random.bits() % 5) as i32 - 2);
        rays.push(Ray::new(
            position + normal * off - along * 3.0,
            along * speed,
        ));
    }
    rays
}

/// One of each, scattered.
pub struct Scene {
    pub spheres: Vec<Sphere>,
    pub planes: Vec<Plane>,
    pub discs: Vec<Disc>,
    pub cuboids: Vec<Cuboid>,
    pub oriented: Vec<OrientedCuboid>,
    pub cylinders: Vec<Cylinder>,
    pub tori: Vec<Torus>,
}

pub fn scene(random: &mut Random, count: usize, scale: f32, offset: Vec3) -> Scene {
    let mut s = Scene {
        spheres: vec![Sphere::new(offset, 0.0)],
        planes: vec![],
        discs: vec![],
        cuboids: vec![],
        oriented: vec![],
        cylinders: vec![],
        tori: vec![],
    };
    for _ in 0..count {
        let p = random.point(scale) + offset;
        let r = (random.signed().abs() + 0.01) * scale * 0.3;
        s.spheres.push(Sphere::new(p, r));
        let within = Aabb::new(p - Vec3::splat(r), p + Vec3::splat(r));
        s.planes.push(Plane::new(p, random.unit() * scale, within));
        s.discs
            .push(Disc::new(p, random.unit(), r).with_hole(0.4 * r));
        let corner = p + random.point(r);
        s.cuboids.push(Cuboid::new(p.min(corner), p.max(corner)));
        let (a, b) = (random.unit(), random.unit());
        let edges = [a * r, a.cross(b).normalized() * (0.5 * r), b * (0.3 * r)];
        s.oriented.push(OrientedCuboid::new(p, edges));
        let cylinder = Cylinder::new(p, p + random.unit() * r, 0.4 * r);
        s.cylinders.push(if random.signed() < 0.0 {
            cylinder
        } else {
            cylinder.open()
        });
        s.tori.push(Torus::new(p, random.unit(), r, 0.3 * r));
    }
    s
}
