//! Meshes, rays and judges shared by tests, benches and fuzzing.
#![forbid(unsafe_code)]
