//! Whitted-style rendering on Boxwood: a [`Scene`](boxwood_scene::Scene) and a camera in, a picture out.
//!
//! *How it works.* [`Renderer::new`] lays the scene out once: triangles into a structure, images into filtered textures,
//! lights and environment into things that can be sampled. [`Renderer::render`] sends rays through the pixels of a
//! [`Camera`](boxwood_scene::Camera) ([`camera`] makes one), shades what they meet after Whitted 1980, and returns a
//! [`Film`]: linear light with what each pixel shows beside it, which becomes a PNG or an EXR.
//!
//! Beside pictures, [`workload`] records the rays that make them, for those who compare structures.
//!
//! *What can be relied on.* The film holds the same bits for any number of threads and on any machine: samples come from
//! hashed pixel numbers, and all mathematics from `libm` or from operations that round correctly. No pixel is infinite
//! or NaN.
//!
//! *Source.* Whitted 1980, *An Improved Illumination Model for Shaded Display*.
#![forbid(unsafe_code)]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "`!(x > 0.0)` refuses NaN along with what is too small, which `x <= 0.0` does not"
)]

pub mod camera;
mod colour;
mod environment;
mod error;
mod film;
mod layout;
mod render;
mod sample;
mod shade;
mod shelf;
mod structure;
mod views;
pub mod workload;
mod world;

pub use error::RenderError;
pub use film::{Film, Pixel, PngOptions};
pub use layout::Layout;
pub use render::{Options, Renderer, Setup};
pub use shelf::{Shelf, kept_wide8, kept_wide16};
pub use structure::{build_structure, kept_structure};
pub use views::{HeatScale, UnknownView, View, inferno, inferno_srgb};

/// The README's example compiles.
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct Readme;
