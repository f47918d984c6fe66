//! The machine that measures: where threads run, what their clocks say, and what it is.

use rayon::{ThreadPool, ThreadPoolBuilder};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use std::fs;

use crate::failure::Outcome;

/// A pool whose threads stay on one core each, counted from the last that this process may use: the first ones serve the
/// system's interrupts. Where there are fewer cores, several threads share one.
///
/// # Errors
/// When the system starts no threads.
pub fn pinned_pool(threads: usize) -> Outcome<ThreadPool> {
    let allowed = sched_getaffinity(None).map(cores).unwrap_or_default();
    let pin = move |i: usize| {
        if let Some(&core) = allowed.iter().rev().cycle().nth(i) {
            let mut one = CpuSet::new();
            one.set(core);
            // A system that does not allow it measures with more noise.
            let _ = sched_setaffinity(None, &one);
        }
    };
    Ok(ThreadPoolBuilder::new()
        .num_threads(threads)
        .start_handler(pin)
        .build()?)
}

fn cores(set: CpuSet) -> Vec<usize> {
    (0..CpuSet::MAX_CPU)
        .filter(|&core| set.is_set(core))
        .collect()
}

/// Seconds that this thread has run so far.
pub fn thread_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// What a reader must know to make sense of times.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    pub processor: String,
    pub cores: usize,
    pub system: &'static str,
    /// The instructions that Rust code was compiled for; Boxwood, Embree and tinybvh choose theirs by themselves.
    pub compiled_for: &'static str,
    /// `BOXWOOD_ISA`, which forces Boxwood's instruction set.
    pub isa: Option<String>,
}

impl Machine {
    /// This one.
    pub fn this() -> Self {
        let told = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = told
            .lines()
            .find_map(|line| line.strip_prefix("model name"));
        let name = name.map(|rest| rest.trim_start_matches([' ', '\t', ':']));
        Self {
            processor: name.unwrap_or(std::env::consts::ARCH).to_string(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: std::env::consts::OS,
            compiled_for: if cfg!(target_feature = "avx512f") {
                "AVX-512"
            } else if cfg!(target_feature = "avx2") {
                "AVX2"
            } else {
                "the baseline of its architecture"
            },
            isa: std::env::var("BOXWOOD_ISA").ok(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pinned_threads_may_use_one_core() {
        let pool = pinned_pool(1).expect("a thread");
        let allowed = pool.install(|| sched_getaffinity(None).map(cores).unwrap_or_default());
        assert_eq!(allowed.len(), 1);
    }

    #[test]
    fn time_passes_while_work_is_done() {
        let start = thread_seconds();
        let sum: u64 = (0..1_000_000_u64).map(std::hint::black_box).sum();
        assert!(sum > 0 && thread_seconds() > start);
    }
}
