//! Meshes, rays and judges shared by tests, benches and fuzzing.
//!
//! *How it works.* [`scenes`] makes named meshes (of [`shapes`] and [`soups`]), [`rays`] makes rays that are hard on them,
//! [`structures`] is the one table of what is tested, and [`agreement`] asks every structure everything and holds the answers
//! against the judge. The judge itself is held against [`oracle`]. All of it follows from seeds: a failure says which.
//!
//! *Cost.* The ordinary run of all tests takes seconds; `BOXWOOD_TEST_RAYS=20` asks 20 times as many rays.
#![forbid(unsafe_code)]

pub mod adversary;
pub mod agreement;
pub mod bytes;
pub mod forged;
pub mod oracle;
pub mod placed;
pub mod random;
pub mod rays;
pub mod scenes;
pub mod shapes;
pub mod soups;
pub mod spheres;
pub mod structures;

pub use {random::Random, shapes::Model, spheres::Spheres};

/// `rays` times the whole number in the environment variable `BOXWOOD_TEST_RAYS`, which is 1 where it is not set.
///
/// # Panics
/// When the variable is set to anything else than a whole number from 1 to 1,000,000.
pub fn effort(rays: usize) -> usize {
    let times = match std::env::var("BOXWOOD_TEST_RAYS") {
        Err(_) => 1,
        Ok(text) => match text.parse() {
            Ok(times @ 1..=1_000_000) => times,
            _ => panic!("BOXWOOD_TEST_RAYS is `{text}`, expected a whole number from 1 to 1000000"),
        },
    };
    rays * times
}

/// The example in the project's README compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct Readme;
