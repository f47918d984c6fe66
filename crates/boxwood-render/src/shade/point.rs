//! The point that a ray met, with everything that shading asks of it.
//!
//! *How it works.* The geometric normal comes from the triangle and decides which side is which; the shading normal is
//! interpolated, bent by the normal map, turned to the ray's side and never faces away from it. Maps are read at the mip
//! level of the ray's footprint.

use super::fresnel;
use super::material::{Bound, Prepared};
use crate::world::{Attributes, Placement, Triangle, World};
use boxwood::{Hit, Ray, Surface, Vec3};
use boxwood_scene::Alpha;

/// A point on a surface, seen along a ray.
pub(crate) struct Point<'a> {
    /// Where secondary rays start.
    pub surface: Surface,
    pub material: &'a Prepared,
    /// Unit vector back along the ray.
    pub to_eye: Vec3,
    /// Unit normal of the triangle on the ray's side.
    pub facing: Vec3,
    /// Unit shading normal on the ray's side.
    pub normal: Vec3,
    /// Whether the ray came from outside.
    pub front: bool,
    pub base: Vec3,
    /// Coverage; 1 except where alpha blends.
    pub alpha: f32,
    pub metallic: f32,
    pub roughness: f32,
    pub transmission: f32,
    pub emission: Vec3,
}

/// What the three corners say about attributes.
struct Corners<'a> {
    mesh: &'a Attributes,
    /// Number of the triangle in its mesh.
    triangle: usize,
    vertices: [usize; 3],
    weights: [f32; 3],
}

impl Corners<'_> {
    fn uv(&self, set: usize) -> [f32; 2] {
        let uvs = &self.mesh.uvs[set];
        if uvs.is_empty() {
            return [0.0; 2];
        }
        let [a, b, c] = self.vertices.map(|v| uvs[v]);
        let [wa, wb, wc] = self.weights;
        [
            a[0] * wa + b[0] * wb + c[0] * wc,
            a[1] * wa + b[1] * wb + c[1] * wc,
        ]
    }

    /// The interpolated normal in object space, of any length.
    fn normal(&self) -> Option<Vec3> {
        let [a, b, c] = if let Some(corners) = self.mesh.corner_normals.get(self.triangle) {
            *corners
        } else if self.mesh.normals.is_empty() {
            return None;
        } else {
            self.vertices.map(|v| self.mesh.normals[v])
        };
        let w = self.weights;
        Some(Vec3::from(a) * w[0] + Vec3::from(b) * w[1] + Vec3::from(c) * w[2])
    }

    fn colour(&self) -> Option<[f32; 4]> {
        if self.mesh.colors.is_empty() {
            return None;
        }
        let [a, b, c] = self.vertices.map(|v| self.mesh.colors[v]);
        let w = self.weights;
        Some(std::array::from_fn(|i| {
            a[i] * w[0] + b[i] * w[1] + c[i] * w[2]
        }))
    }

    /// The vertices' coordinates in texture space as two edges.
    fn uv_edges(&self, set: usize) -> [[f32; 2]; 2] {
        let uvs = &self.mesh.uvs[set];
        if uvs.is_empty() {
            return [[0.0; 2]; 2];
        }
        let [a, b, c] = self.vertices.map(|v| uvs[v]);
        [[b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]]
    }
}

impl World {
    fn corners(&self, hit: &Hit) -> Corners<'_> {
        let located = self.layout.locate(hit);
        let mesh = &self.meshes[located.mesh as usize];
        Corners {
            vertices: mesh.triangles[located.triangle as usize].map(|v| v as usize),
            triangle: located.triangle as usize,
            weights: [1.0 - hit.u - hit.v, hit.u, hit.v],
            mesh,
        }
    }

    /// Coverage at a hit by the finest texture level, 0 where a mask cuts the surface away.
    pub fn coverage(&self, hit: &Hit) -> f32 {
        let corners = self.corners(hit);
        let material = &self.materials[corners.mesh.material];
        self.alpha(material, &corners, |_| 0.0)
    }

    fn alpha(
        &self,
        material: &Prepared,
        corners: &Corners<'_>,
        width: impl Fn(usize) -> f32,
    ) -> f32 {
        let mut alpha = material.plain.base_color[3];
        if let Some(map) = &material.base_color_map {
            alpha *= self
                .textures
                .sample(map, corners.uv(map.uv_set), width(map.uv_set))[3];
        }
        if let Some(map) = &material.alpha_map {
            alpha *= self
                .textures
                .coverage(map, corners.uv(map.uv_set), width(map.uv_set));
        }
        alpha *= corners.colour().map_or(1.0, |c| c[3]);
        match material.plain.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask { cutoff } => f32::from(u8::from(alpha >= cutoff)),
            Alpha::Blend => alpha.clamp(0.0, 1.0),
        }
    }

    /// The point at a hit. `width` is the footprint of the ray there, across the ray, in world units.
    pub fn point(&self, ray: &Ray, hit: &Hit, width: f32) -> Point<'_> {
        let surface = self.layout.surface(ray, hit);
        let (corners, placement) = (self.corners(hit), self.placement(hit));
        let material = &self.materials[corners.mesh.material];
        let to_eye = -ray.direction;
        let facing = surface.facing();

        let mut texture_width = [0.0; 2];
        if material.has_maps() {
            let [a, b, c] = self.layout.corners(hit);
            let area = (b - a).cross(c - a).length();
            // Stretched by the slant of the surface, but not without end: what is far too long is blurred across as well.
            let along = width / to_eye.dot(facing).max(0.3);
            for (set, texture_width) in texture_width.iter_mut().enumerate() {
                let [e, f] = corners.uv_edges(set);
                let share = (e[0] * f[1] - e[1] * f[0]).abs() / area;
                *texture_width = if share.is_finite() {
                    along * share.sqrt()
                } else {
                    0.0
                };
            }
        }
        let read = |map: &Bound| {
            self.textures
                .sample(map, corners.uv(map.uv_set), texture_width[map.uv_set])
        };

        let plain = &material.plain;
        let [r, g, b, _] = plain.base_color;
        let mut base = Vec3::new(r, g, b);
        if let Some(map) = &material.base_color_map {
            let [r, g, b, _] = read(map);
            base = base * Vec3::new(r, g, b);
        }
        if let Some([r, g, b, _]) = corners.colour() {
            base = base * Vec3::new(r, g, b);
        }
        let (mut metallic, mut roughness) = (plain.metallic, plain.roughness);
        if let Some(map) = &material.metallic_roughness_map {
            let [_, g, b, _] = read(map);
            roughness *= g;
            metallic *= b;
        }
        let mut transmission = plain.transmission;
        if let Some(map) = &material.transmission_map {
            transmission *= read(map)[0];
        }
        let mut emission = Vec3::from(plain.emissive);
        if let Some(map) = &material.emissive_map {
            let [r, g, b, _] = read(map);
            emission = emission * Vec3::new(r, g, b);
        }
        let alpha = if self.has_holes((hit.instance, hit.primitive)) {
            self.alpha(material, &corners, |set| texture_width[set])
        } else {
            1.0
        };
        // A mask was already asked on the way here, at its finest level.
        let alpha = if matches!(plain.alpha, Alpha::Blend) {
            alpha
        } else {
            1.0
        };

        let normal =
            self.shading_normal(&corners, &placement, material, hit, facing, &texture_width);
        Point {
            normal: towards(normal, facing, to_eye),
            front: surface.front != placement.turns_over,
            surface,
            material,
            to_eye,
            facing,
            base: sound(base),
            alpha,
            metallic: metallic.clamp(0.0, 1.0),
            roughness: roughness.clamp(0.0, 1.0),
            transmission: transmission.clamp(0.0, 1.0),
            emission: sound(emission),
        }
    }

    /// The emission at a point of a triangle.
    pub fn glow(&self, (instance, primitive): Triangle, [u, v]: [f32; 2]) -> Vec3 {
        let corners = self.corners(&Hit {
            t: 0.0,
            u,
            v,
            primitive,
            instance,
        });
        let material = &self.materials[corners.mesh.material];
        let emission = Vec3::from(material.plain.emissive);
        sound(material.emissive_map.as_ref().map_or(emission, |map| {
            let [r, g, b, _] = self.textures.sample(map, corners.uv(map.uv_set), 0.0);
            emission * Vec3::new(r, g, b)
        }))
    }

    /// On the side of `facing`.
    fn shading_normal(
        &self,
        corners: &Corners<'_>,
        placement: &Placement,
        material: &Prepared,
        hit: &Hit,
        facing: Vec3,
        texture_width: &[f32; 2],
    ) -> Vec3 {
        let mut normal = facing;
        if let Some(smooth) = corners.normal() {
            let placed = if placement.plain {
                smooth.normalized()
            } else {
                placement.transform.normal(smooth).normalized()
            };
            if placed != Vec3::ZERO {
                normal = placed;
            }
        }
        let side = if normal.dot(facing) < 0.0 { -1.0 } else { 1.0 };
        if let Some(map) = &material.normal_map
            && let Some((tangent, bitangent)) =
                self.tangents(corners, placement, hit, map.uv_set, normal)
        {
            let [r, g, b, _] =
                self.textures
                    .sample(map, corners.uv(map.uv_set), texture_width[map.uv_set]);
            let scale = material.plain.normal_scale;
            let (x, y, z) = (
                (2.0 * r - 1.0) * scale,
                (2.0 * g - 1.0) * scale,
                2.0 * b - 1.0,
            );
            let bent = (tangent * x + bitangent * y + normal * z.max(0.05)).normalized();
            if bent != Vec3::ZERO {
                normal = bent;
            }
        }
        normal * side
    }

    /// The directions of the normal map's x and y in world space.
    fn tangents(
        &self,
        corners: &Corners<'_>,
        placement: &Placement,
        hit: &Hit,
        uv_set: usize,
        normal: Vec3,
    ) -> Option<(Vec3, Vec3)> {
        let tangents = &corners.mesh.tangents;
        if !tangents.is_empty() {
            let [a, b, c] = corners.vertices.map(|v| tangents[v]);
            let vector = |t: [f32; 4]| Vec3::new(t[0], t[1], t[2]);
            let w = corners.weights;
            let object = vector(a) * w[0] + vector(b) * w[1] + vector(c) * w[2];
            let world = placement.transform.vector(object);
            let tangent = (world - normal * world.dot(normal)).normalized();
            let sign = if (a[3] < 0.0) == placement.mirrors {
                1.0
            } else {
                -1.0
            };
            if tangent != Vec3::ZERO {
                return Some((tangent, normal.cross(tangent) * sign));
            }
        }
        let [e, f] = corners.uv_edges(uv_set);
        let determinant = e[0] * f[1] - e[1] * f[0];
        let [p, q, r] = self.layout.corners(hit);
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        let along_u = ((q - p) * f[1] - (r - p) * e[1]) * sign;
        let tangent = (along_u - normal * along_u.dot(normal)).normalized();
        // v points down in the image, y of the map up.
        let up = ((q - p) * f[0] - (r - p) * e[0]) * sign;
        let across = normal.cross(tangent);
        let across = if across.dot(up) < 0.0 {
            -across
        } else {
            across
        };
        (determinant != 0.0 && tangent != Vec3::ZERO).then_some((tangent, across))
    }
}

/// A shading normal that does not face away from the eye: it is leaned towards the triangle's own just so far.
fn towards(normal: Vec3, facing: Vec3, to_eye: Vec3) -> Vec3 {
    const LEAST: f32 = 0.02;
    let seen = normal.dot(to_eye);
    let open = facing.dot(to_eye);
    if seen >= LEAST || open <= LEAST {
        return if seen > 0.0 { normal } else { facing };
    }
    let leaned = (normal + facing * ((LEAST - seen) / open)).normalized();
    if leaned == Vec3::ZERO { facing } else { leaned }
}

/// A finite colour without negative parts.
fn sound(c: Vec3) -> Vec3 {
    let fix = |x: f32| if x > 0.0 { x.min(1.0e6) } else { 0.0 };
    Vec3::new(fix(c.x), fix(c.y), fix(c.z))
}

impl Point<'_> {
    /// The mirrored direction of the ray, never below the surface.
    pub fn mirrored(&self) -> Vec3 {
        let reflected = fresnel::reflect(-self.to_eye, self.normal);
        let below = reflected.dot(self.facing);
        if below < 0.0 {
            // Folded back at the surface: no step, no angle of our own choosing.
            reflected - self.facing * (2.0 * below)
        } else {
            reflected
        }
    }

    /// Reflectance of a smooth surface here for light at an angle, metal and dielectric mixed.
    pub fn fresnel(&self, cos_in: f32) -> Vec3 {
        let specular = Vec3::from(self.material.plain.specular);
        let outside = if self.inside() {
            self.ior()
        } else {
            1.0 / self.ior()
        };
        let share = fresnel::dielectric(cos_in, outside);
        let coat = if share >= 1.0 && self.inside() {
            Vec3::splat(1.0)
        } else {
            specular * share
        };
        let coat = if self.material.plain.thin && self.transmission > 0.0 {
            // Both faces of the sheet, and all reflections between them.
            let both = |r: f32| 2.0 * r / (1.0 + r);
            Vec3::new(both(coat.x), both(coat.y), both(coat.z))
        } else {
            coat
        };
        coat * (1.0 - self.metallic) + fresnel::metal(cos_in, self.base) * self.metallic
    }

    /// Reflectance at normal incidence.
    pub fn at_normal(&self) -> Vec3 {
        let root = (self.ior() - 1.0) / (self.ior() + 1.0);
        let dielectric = Vec3::from(self.material.plain.specular) * (root * root);
        dielectric * (1.0 - self.metallic) + self.base * self.metallic
    }

    /// Index of refraction, put right where a file has it below that of vacuum.
    pub fn ior(&self) -> f32 {
        let ior = self.material.plain.ior;
        if ior >= 1.0 { ior.min(10.0) } else { 1.0 }
    }

    /// Whether the ray travels inside a clear body here.
    pub fn inside(&self) -> bool {
        !self.front && !self.material.plain.thin && self.material.transmits()
    }

    /// The colour that scatters: what is neither metal nor clear.
    pub fn diffuse(&self) -> Vec3 {
        self.base * ((1.0 - self.metallic) * (1.0 - self.transmission))
    }
}
