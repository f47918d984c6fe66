//! Every structure equals the judge on small meshes of whole numbers.
#![no_main]

use boxwood_testkit::{agreement, bytes};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let (mesh, rays) = bytes::case(data);
    agreement::check(&mesh, &rays, "fuzzing");
});
