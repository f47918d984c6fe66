//! Whitted-style rendering.
#![forbid(unsafe_code)]
