//! Builds of every quality keep to the memory that they are given, need what was forecast, and end when they are told to.
//!
//! An allocator counts. One test, because it counts for all threads.

use boxwood::{
    BuildError, Job, Limits, Quality, StructureKind, Survey, Traverse, TriangleMesh, WideSah,
};
use boxwood_testkit::{Random, shapes, soups};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ops::ControlFlow::{Break, Continue};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator, and how many bytes are in use.
struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;
static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

impl Counting {
    fn add(bytes: usize) {
        let now = IN_USE.fetch_add(bytes, Relaxed) + bytes;
        MOST.fetch_max(now, Relaxed);
    }
}

// SAFETY: everything is the system's allocator's; counting allocates nothing. A list that grows is counted twice while it may be
// copied, as `realloc` of this trait does by default.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::add(layout.size());
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// The most bytes in use at once while something is done, beyond those before.
fn most_bytes<T>(work: impl FnOnce() -> T) -> (usize, T) {
    let before = IN_USE.load(Relaxed);
    MOST.store(before, Relaxed);
    let done = work();
    (MOST.load(Relaxed).saturating_sub(before), done)
}

/// What may be in use beside the large arrays: queues of threads, stacks of subtrees.
const BESIDE: usize = 32 << 10;

/// Few enough that no array is so large that it is asked of the system itself, where nobody counts; enough for several threads.
fn scenes() -> [(&'static str, TriangleMesh); 6] {
    let mut random = Random::new(21);
    [
        ("terrain", shapes::terrain(75, &mut random).mesh()),
        ("sphere", shapes::sphere(120, 50).mesh()),
        ("random", soups::random(11_000, &mut random).mesh()),
        ("needles", soups::needles(9_000, &mut random).mesh()),
        ("identical", soups::identical(9_000).mesh()),
        ("few", soups::random(900, &mut random).mesh()),
    ]
}

fn presets() -> impl Iterator<Item = StructureKind> {
    Quality::ALL.into_iter().flat_map(|quality| {
        let eight = WideSah {
            quality,
            ..WideSah::default()
        };
        let sixteen = WideSah {
            quality,
            ..WideSah::default()
        };
        [StructureKind::Wide8(eight), StructureKind::Wide16(sixteen)]
    })
}

fn the_cap_is_never_passed(kind: StructureKind, name: &str, mesh: &TriangleMesh) {
    let forecast = kind
        .forecast(&Survey::of(mesh), 1)
        .expect("a preset has one");
    for eighths in 1..=8 {
        let cap = forecast.peak_bytes / 8 * eighths + forecast.peak_bytes % 8;
        let limits = Limits {
            memory: Some(cap),
            ..Limits::NONE
        };
        let (most, built) = most_bytes(|| kind.build_within(mesh, &limits));
        let case = format!("{kind} of {name}, {cap} of {} bytes", forecast.peak_bytes);
        assert!(most <= cap + BESIDE, "{most}: {case}");
        match built {
            // What was forecast is enough, and two thirds of it is not.
            Ok(_) => assert!(eighths > 5, "{case}"),
            Err(error) => {
                let refused = matches!(error, BuildError::Memory { needed, allowed } if allowed == cap && needed > cap);
                assert!(refused && eighths < 8, "{error}: {case}");
            }
        }
    }
}

fn the_finished_tree_is_as_large_as_forecast(kind: StructureKind, name: &str, mesh: &TriangleMesh) {
    let forecast = kind
        .forecast(&Survey::of(mesh), 1)
        .expect("a preset has one");
    let bytes = kind.build(mesh).statistics().bytes as f64;
    let share = bytes / forecast.resident_bytes as f64;
    assert!((0.67..1.5).contains(&share), "{share}: {kind} of {name}");
}

fn it_ends_when_it_is_told_to(kind: StructureKind, mesh: &TriangleMesh) {
    for end in [0.0, 0.2, 0.5, 0.7, 0.8, 0.95, 1.0] {
        let watch = |share: f32| {
            if share >= end {
                Break(())
            } else {
                Continue(())
            }
        };
        let limits = Limits {
            watch: Some(&watch),
            ..Limits::NONE
        };
        let before = IN_USE.load(Relaxed);
        let ended = kind.build_within(mesh, &limits).err();
        assert_eq!(ended, Some(BuildError::Cancelled), "{kind} at {end}");
        let left = IN_USE.load(Relaxed).saturating_sub(before);
        assert!(left <= BESIDE, "{left} bytes left: {kind} at {end}");
    }
}

fn a_job_has_the_memory_that_it_allows(mesh: &TriangleMesh) {
    let job = |bytes| Job {
        bytes: Some(bytes),
        ..Job::default()
    };
    let refused = WideSah::<8>::build_for(mesh, &job(100)).err();
    assert!(matches!(
        refused,
        Some(BuildError::Memory { allowed: 100, .. })
    ));
    let survey = Survey::of(mesh);
    let least = job(0).plan::<8>(&survey);
    let built = WideSah::<8>::build_for(mesh, &job(least.peak_bytes)).expect("as much as planned");
    assert!(Traverse::statistics(&built).bytes <= least.peak_bytes);
}

#[test]
fn every_quality_keeps_to_its_memory_and_ends_when_told() {
    let scenes = scenes();
    a_job_has_the_memory_that_it_allows(&scenes[0].1);
    for threads in [1, 2, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        // Threads make room for their queues when they first work.
        pool.broadcast(|_| ());
        pool.install(|| {
            for kind in presets() {
                for (name, mesh) in &scenes {
                    the_cap_is_never_passed(kind, &format!("{name}, {threads} threads"), mesh);
                }
                it_ends_when_it_is_told_to(kind, &scenes[0].1);
                if threads == 1 {
                    for (name, mesh) in &scenes[..2] {
                        the_finished_tree_is_as_large_as_forecast(kind, name, mesh);
                    }
                }
            }
        });
    }
}
