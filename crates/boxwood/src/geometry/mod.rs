//! Shapes and their tests; knows nothing of trees.

mod aabb;
mod hit;
mod ray;
mod surface;
mod transform;
pub mod triangle;
mod vec3;

pub use {
    aabb::Aabb, hit::Hit, ray::PreparedRay, ray::Ray, surface::Surface, transform::Affine,
    vec3::Vec3,
};
