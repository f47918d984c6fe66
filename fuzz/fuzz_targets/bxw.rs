//! A saved tree that somebody tampered with is an error, or its answers are the judge's.
#![no_main]

use boxwood_testkit::forged;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    forged::check(data, "fuzzing");
});
