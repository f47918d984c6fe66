//! Wide trees open as few nodes as they did: counts are recorded, and a dearer tree or walk fails.
//!
//! Times depend on the machine, counts do not: they are the same for every instruction set and any number of threads, and
//! the scenes are made of the same bits everywhere. Where a change makes counts fall,
//! `BOXWOOD_BLESS=1 cargo test -p boxwood-render --test counts -- --nocapture` prints the table anew.

use boxwood::{Intersect, Isa, Ray, TraversalStats, TriangleMesh, WideSah};
use boxwood_render::workload::{RayKind, Recorder};
use boxwood_scene::builtin;

/// Rays of each kind, at most.
const RAYS: u32 = 1500;
/// By how much counts may be higher than recorded before the test fails, and lower before it says so.
const TOLERANCE: f64 = 0.01;

const SCENES: [&str; 4] = [
    "teapot-in-stadium",
    "terrain:20000",
    "even-spheres:20",
    "plants:30",
];

/// Which rays are asked, and whether any hit is enough.
const QUESTIONS: [(RayKind, bool); 6] = [
    (RayKind::Primary, false),
    (RayKind::Diffuse, false),
    (RayKind::Shadow, false),
    (RayKind::Primary, true),
    (RayKind::Diffuse, true),
    (RayKind::Shadow, true),
];

const WHAT: [&str; 3] = ["nodes", "leaves", "triangles"];

/// Scene and structure; nodes, leaves and triangles of all rays, by question.
type Row = (&'static str, &'static str, [[u64; 3]; QUESTIONS.len()]);

#[rustfmt::skip]
const RECORDED: &[Row] = &[
    ("teapot-in-stadium", "wide8", [[16200, 2758, 11525], [13515, 3606, 15173], [10323, 2230, 9608], [6352, 1323, 4323], [8396, 1918, 7232], [10282, 2168, 9316]]),
    ("teapot-in-stadium", "wide16", [[10645, 2838, 11257], [9550, 3609, 14417], [7090, 2207, 9210], [3833, 1301, 4169], [5823, 1926, 7099], [7079, 2153, 8979]]),
    ("terrain:20000", "wide8", [[12728, 2050, 6793], [6267, 1264, 4845], [6431, 1066, 4063], [5638, 1243, 3539], [5510, 976, 3641], [6433, 1051, 4031]]),
    ("terrain:20000", "wide16", [[11041, 2096, 6729], [4612, 1272, 4638], [4831, 1083, 4014], [5253, 1203, 3257], [4084, 961, 3421], [4825, 1068, 3975]]),
    ("even-spheres:20", "wide8", [[3226, 650, 2394], [1345, 525, 1911], [1177, 435, 1599], [3117, 644, 2299], [1270, 477, 1730], [1135, 417, 1541]]),
    ("even-spheres:20", "wide16", [[2539, 652, 2213], [954, 529, 1730], [850, 436, 1412], [2526, 621, 2157], [892, 471, 1539], [797, 399, 1292]]),
    ("plants:30", "wide8", [[3648, 819, 2627], [1320, 520, 1736], [1049, 364, 1213], [3107, 492, 1570], [1205, 450, 1514], [1039, 353, 1140]]),
    ("plants:30", "wide16", [[3037, 763, 2134], [975, 492, 1422], [783, 334, 962], [2754, 485, 1358], [902, 431, 1262], [755, 324, 932]]),
];

fn counts(structure: &dyn Intersect, rays: &[Ray], any: bool) -> [u64; 3] {
    let mut stats = TraversalStats::default();
    for ray in rays {
        if any {
            structure.occluded_counted(ray, &mut stats);
        } else {
            structure.closest_hit_counted(ray, &mut stats);
        }
    }
    [stats.nodes, stats.leaves, stats.primitives]
}

fn structures<'a>(mesh: &'a TriangleMesh, width: &str) -> Vec<(Isa, Box<dyn Intersect + 'a>)> {
    let eight = (width == "wide8").then(|| WideSah::<8>::default().build(mesh));
    let sixteen = (width == "wide16").then(|| WideSah::<16>::default().build(mesh));
    let walked_with = |isa: Isa| -> Option<Box<dyn Intersect + 'a>> {
        match (&eight, &sixteen) {
            (Some(tree), _) => Some(Box::new(tree.clone().with_isa(isa))),
            (_, Some(tree)) => Some(Box::new(tree.clone().with_isa(isa))),
            _ => None,
        }
    };
    let all = Isa::available().into_iter();
    all.filter_map(|isa| Some((isa, walked_with(isa)?)))
        .collect()
}

fn measured() -> Vec<Row> {
    let mut rows = Vec::new();
    for name in SCENES {
        let scene = builtin::by_name(name).expect("it exists");
        let flat = scene.flatten().expect("a good scene");
        for width in ["wide8", "wide16"] {
            let structures = structures(&flat.mesh, width);
            let (_, first) = &structures[0];
            let camera = &scene.cameras[0];
            let recorder = Recorder::new(&scene, &flat.mesh, &**first, camera, 1.5, RAYS);
            let counts = QUESTIONS.map(|(kind, any)| {
                let rays = recorder.record(kind);
                let found = counts(&**first, &rays, any);
                for (isa, structure) in &structures {
                    let same = counts(&**structure, &rays, any);
                    assert_eq!(
                        same, found,
                        "{isa} counts otherwise: {name}, {width}, {kind}"
                    );
                }
                found
            });
            rows.push((name, width, counts));
        }
    }
    rows
}

fn question(number: usize) -> String {
    let (rays, any) = QUESTIONS[number];
    format!("{} hit of {rays} rays", if any { "any" } else { "nearest" })
}

#[test]
fn counts_are_no_higher_than_recorded() {
    let rows = measured();
    if std::env::var_os("BOXWOOD_BLESS").is_some() {
        for (scene, width, counts) in &rows {
            println!("    ({scene:?}, {width:?}, {counts:?}),");
        }
        return;
    }
    assert_eq!(rows.len(), RECORDED.len(), "the table is of other scenes");
    let (mut higher, mut lower) = (String::new(), String::new());
    for ((scene, width, now), (of_scene, of_width, then)) in rows.iter().zip(RECORDED) {
        assert_eq!((scene, width), (of_scene, of_width), "another order");
        for (number, (now, then)) in now.iter().zip(then).enumerate() {
            for (what, (&now, &then)) in WHAT.iter().zip(now.iter().zip(then)) {
                let more = now as f64 / then as f64 - 1.0;
                let line = format!(
                    "{scene}, {width}, {}: {now} {what} instead of {then} ({:+.1} %)\n",
                    question(number),
                    100.0 * more
                );
                if more > TOLERANCE {
                    higher += &line;
                } else if more < -TOLERANCE {
                    lower += &line;
                }
            }
        }
    }
    if !lower.is_empty() {
        println!("Lower than recorded, worth recording (this file's head says how):\n{lower}");
    }
    assert!(
        higher.is_empty(),
        "higher than recorded:\n{higher}If that is meant, record it (this file's head says how)."
    );
}
