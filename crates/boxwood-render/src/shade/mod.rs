//! What a ray brings home: surfaces, lights and Whitted's tree of rays.

pub(crate) mod cutout;
pub(crate) mod direction;
pub(crate) mod emitters;
pub(crate) mod fresnel;
pub(crate) mod gloss;
pub(crate) mod light;
pub(crate) mod material;
pub(crate) mod point;
pub(crate) mod shadow;
pub(crate) mod texture;
pub(crate) mod whitted;
