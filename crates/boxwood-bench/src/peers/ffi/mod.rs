//! What lies outside of Rust: the only unsafe code of this crate. What leaves this room is safe.

#![allow(
    unsafe_code,
    reason = "C libraries and processor registers can be reached in no other way"
)]

pub mod embree;
mod flush;
#[cfg(feature = "tinybvh")]
mod tiny;

pub use flush::FlushToZero;
#[cfg(feature = "tinybvh")]
pub use tiny::TinyTree;
