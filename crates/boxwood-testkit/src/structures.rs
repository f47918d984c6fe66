//! The one table of structures: a new structure is one line here, and every test, fuzz target and comparison has it.

use boxwood::{Intersect, Isa, Primitives, StructureKind, TriangleMesh};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::OnceLock;

/// All structures with the settings worth testing, as [`StructureKind`] reads them. The first is the judge.
const TABLE: &[&str] = &[
    "brute",
    "boxes",
    "grid",
    "grid:c=auto",
    "grid:c=0",
    "grid:c=200",
    "grid:resolution=1x7x30",
    "grid:axes=xy",
    "grid2",
    "grid2:blocks=0,c=0",
    "grid2:blocks=0,c=100",
    "grid2:blocks=9,c=9",
    "grid2:axes=xy",
    "octree",
    "octree:leaf=1,depth=24",
    "octree:leaf=64,depth=1",
    "octree:axes=xy",
    "kd:lecture",
    "kd:lecture,leaf=1,axis=longest,split=median,budget=40",
    "kd:lecture,depth=64,split=median,axes=xy",
    "kd:sah",
    "kd:sah,leaf=1,empty=0.8,depth=64,budget=40",
    "kd:sah,leaf=64,depth=3,budget=1,axes=xy",
    "bsp",
    "bsp:leaf=64,depth=3",
    "bsp:limit=0,budget=3",
    "bsp:axes=xy",
    "bvh:median",
    "bvh:median,leaf=1",
    "bvh:median,leaf=64",
    "bvh:median,axes=xy",
    "bvh:middle",
    "bvh:middle,leaf=1,axes=xz",
    "bvh:equal",
    "bvh:equal,leaf=1,axes=yz,rotate=2",
    "bvh:sweep",
    "bvh:sweep,leaf=1,rotate=3,reinsert=2",
    "bvh:sweep,leaf=64,axes=xy",
    "bvh:binned",
    "bvh:binned,bins=2,leaf=1",
    "bvh:binned,leaf=64",
    "bvh:binned,axes=y",
    "bvh:lbvh",
    "bvh:lbvh,leaf=1,axes=y",
    "bvh:ploc",
    "bvh:ploc,radius=1,leaf=1",
    "bvh:ploc,radius=256,leaf=64,axes=xy,reinsert=1",
    "bvh:sbvh",
    "bvh:sbvh,budget=4,alpha=0,leaf=1",
    "bvh:sbvh,budget=2,alpha=0,bins=3,leaf=64,reinsert=2",
    "bvh:sbvh,budget=1.5,axes=xy",
    "wide8",
    "wide8:isa=avx2",
    "wide8:isa=neon",
    "wide8:isa=simd128",
    "wide8:isa=portable",
    "wide8:bins=2,axes=xy,reinsert=1",
    "wide16",
    "wide16:isa=avx2",
    "wide16:isa=neon",
    "wide16:isa=simd128",
    "wide16:isa=portable",
    "wide16:axes=z",
    "wide16:gathering=greedy",
    "wide8:rebraid=1",
    "wide16:rebraid=16,bins=8",
    "wide8:quality=fast",
    "wide8:quality=high",
    "wide8:quality=ultra",
    "wide16:quality=ultra",
    "compact",
    "compact:isa=avx2",
    "compact:isa=neon",
    "compact:isa=simd128",
    "compact:isa=portable",
    "compact:bins=2,axes=xy,reinsert=1",
    "compact:gathering=greedy",
    "compact:quality=fast",
    "compact:quality=ultra",
];

/// Those that are also built by 1 and by 3 threads, whatever pool the test runs in.
const THREADED: &[&str] = &[
    "grid",
    "grid2",
    "octree",
    "kd:sah",
    "bvh:binned",
    "bvh:sweep",
    "bvh:sbvh",
    "bvh:ploc,reinsert=1",
    "wide16",
    "wide8:quality=fast",
    "wide8:quality=ultra",
    "compact",
];

/// A structure of the table.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    kind: StructureKind,
    threads: Option<usize>,
}

impl Entry {
    /// As text: `bvh:binned`, `bvh:binned by 2 threads`.
    pub fn name(&self) -> String {
        match self.threads {
            None => self.kind.to_string(),
            Some(threads) => format!("{} by {threads} threads", self.kind),
        }
    }
    /// The structure and its settings.
    pub fn kind(&self) -> StructureKind {
        self.kind
    }
    /// By how many threads it is built, where that is not left to the test.
    pub fn threads(&self) -> Option<usize> {
        self.threads
    }
    /// Builds it.
    pub fn build<'a, P: Primitives + Send + Sync>(
        &self,
        primitives: &'a P,
    ) -> Box<dyn Intersect + 'a> {
        match self.threads {
            None => self.kind.build(primitives),
            Some(threads) => pool(threads).install(|| self.kind.build(primitives)),
        }
    }
}

/// The table. The first entry is the judge.
///
/// # Panics
/// When the table names what does not exist.
pub fn all() -> impl Iterator<Item = Entry> {
    let read = |text: &&str| text.parse().unwrap_or_else(|e| panic!("{e}"));
    // Instruction sets that this machine lacks are left out.
    let known = |text: &&&str| {
        let isa = text.split_once("isa=").map(|(_, name)| name);
        isa.is_none_or(|name| name.parse::<Isa>().is_ok())
    };
    let plain = TABLE.iter().filter(known).map(move |text| Entry {
        kind: read(text),
        threads: None,
    });
    let threaded = THREADED.iter().flat_map(move |text| {
        let kind = read(text);
        [1, 3].map(|threads| Entry {
            kind,
            threads: Some(threads),
        })
    });
    plain.chain(threaded)
}

/// A structure over a mesh. Not generic, so that the code of all structures over meshes is made once, in this crate, and
/// shared by all tests, which would otherwise spend minutes each on making it again.
pub fn over_mesh(kind: StructureKind, mesh: &TriangleMesh) -> Box<dyn Intersect + '_> {
    kind.build(mesh)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_structure_is_tested() {
        assert_eq!(
            all().next().map(|e| e.kind),
            Some("brute".parse().expect("the judge"))
        );
        for kind in StructureKind::all() {
            assert!(
                all().any(|entry| entry.kind == kind),
                "{kind} is not in the table"
            );
        }
    }
}
