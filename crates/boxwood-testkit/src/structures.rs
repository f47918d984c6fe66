//! The one table of structures: a new structure is one line here, and every test, fuzz target and comparison has it.

use boxwood::{
    BinnedSah, BruteForce, Bvh, Closest, Hit, Intersect, Median, Primitives, Ray, Seen, Traverse,
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::OnceLock;

/// What the tests ask: [`Intersect`], and what only the full type can be asked.
pub trait Structure: Intersect {
    /// The closest hit as seen with a mask at a moment.
    fn closest_seen(&self, ray: &Ray, mask: u32, time: f32) -> Option<Hit>;
}

impl<T: Traverse + Send + Sync> Structure for T {
    fn closest_seen(&self, ray: &Ray, mask: u32, time: f32) -> Option<Hit> {
        let inner = Closest::new(ray);
        let mut query = Seen { inner, mask, time };
        self.traverse(ray, &mut query, &mut ());
        query.inner.hit()
    }
}

/// Makes a structure over borrowed primitives.
pub type Build<P> = for<'a> fn(&'a P) -> Box<dyn Structure + 'a>;

/// All structures with the settings worth testing, by name. The first is the judge.
pub fn all<P: Primitives + Send + Sync>() -> [(&'static str, Build<P>); 10] {
    [
        ("brute", |p| Box::new(BruteForce::new(p))),
        ("bvh:median", |p| bvh(p, Median::default().build(p))),
        ("bvh:median,leaf=1", |p| {
            bvh(p, Median { max_leaf: 1 }.build(p))
        }),
        ("bvh:median,leaf=64", |p| {
            bvh(p, Median { max_leaf: 64 }.build(p))
        }),
        ("bvh:binned", |p| bvh(p, BinnedSah::default().build(p))),
        ("bvh:binned,bins=2,leaf=1", |p| {
            let builder = BinnedSah {
                bins: 2,
                max_leaf: 1,
            };
            bvh(p, builder.build(p))
        }),
        ("bvh:binned,leaf=64", |p| {
            let builder = BinnedSah {
                max_leaf: 64,
                ..Default::default()
            };
            bvh(p, builder.build(p))
        }),
        ("bvh:binned by 1 thread", |p| bvh(p, built_by(1, p))),
        ("bvh:binned by 2 threads", |p| bvh(p, built_by(2, p))),
        ("bvh:binned by 3 threads", |p| bvh(p, built_by(3, p))),
    ]
}

fn bvh<P: Primitives + Send + Sync>(
    primitives: &P,
    tree: boxwood::BinaryTree,
) -> Box<dyn Structure + '_> {
    Box::new(Bvh::new(primitives, tree))
}

fn built_by<P: Primitives + Sync>(threads: usize, primitives: &P) -> boxwood::BinaryTree {
    pool(threads).install(|| BinnedSah::default().build(primitives))
}

/// A pool of 1 to 8 threads, made once.
///
/// # Panics
/// For any other number, and when the system gives no threads.
pub fn pool(threads: usize) -> &'static ThreadPool {
    static POOLS: [OnceLock<ThreadPool>; 8] = [const { OnceLock::new() }; 8];
    POOLS[threads - 1].get_or_init(|| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("the system gives threads")
    })
}
