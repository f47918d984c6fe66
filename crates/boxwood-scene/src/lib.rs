//! Scenes from files: OBJ, PLY, STL and glTF in, one small [`Scene`] out.
//!
//! *How it works.* Each loader in [`load`] turns bytes into the same few tables: meshes, the places they stand in
//! (instances), materials, images, lights and cameras. [`Scene::flatten`] lays every placement out as one
//! [`TriangleMesh`](boxwood::TriangleMesh) for the structures, and knows the way back from a hit to mesh, placement
//! and material.
#![forbid(unsafe_code)]

pub mod builtin;
mod error;
mod flatten;
mod image;
pub mod load;
mod material;
mod normals;
mod scene;
mod srgb;
mod triangulate;

pub use error::{Place, SceneError};
pub use flatten::{FlatScene, Located};
pub use image::{Image, ImageData};
pub use load::{Files, Folder, Format, NoFiles, Source};
pub use material::{Alpha, Material, TextureMap, Wrap};
pub use scene::{
    Camera, Environment, Group, Instance, Light, LightKind, Mesh, PlacedGroup, Projection, Scene,
};
pub use srgb::srgb_to_linear;
