//! Shapes and their tests; knows nothing of trees.

mod aabb;
pub(crate) mod cover;
mod cuboid;
mod cylinder;
mod disc;
pub(crate) mod double;
pub(crate) mod frame;
mod hit;
pub mod implicit;
mod interval;
pub(crate) mod morton;
pub(crate) mod motion;
pub(crate) mod pair;
mod plane;
pub(crate) mod predicates;
mod prism;
pub(crate) mod ray;
pub mod real;
mod roots;
mod search;
pub mod shape;
mod sphere;
mod surface;
mod torus;
mod transform;
pub mod triangle;
mod vec3;

pub use {
    aabb::Aabb, hit::Hit, ray::PreparedRay, ray::Ray, surface::Surface, transform::Affine,
    vec3::Vec3,
};
pub use {
    cuboid::{Cuboid, OrientedCuboid},
    cylinder::Cylinder,
    disc::Disc,
    double::Line,
    implicit::ImplicitSurface,
    interval::Interval,
    plane::Plane,
    prism::{Figure, Prism},
    sphere::Sphere,
    torus::Torus,
};
