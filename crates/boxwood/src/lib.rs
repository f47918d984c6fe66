//! w
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;
pub mod geometry;
mod math;
pub use geometry::{Aabb, Affine, Hit, PreparedRay, Ray, Surface, Vec3};
