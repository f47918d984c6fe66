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
    ("teapot-in-stadium", "wide8", [[13036, 2880, 11745], [13096, 3812, 15421], [9666, 2269, 9390], [5831, 1325, 3744], [8049, 2013, 7389], [9441, 2212, 9159]]),
    ("teapot-in-stadium", "wide16", [[8547, 2953, 11108], [9256, 3915, 14688], [6677, 2387, 9042], [3429, 1297, 3634], [5626, 2111, 7456], [6552, 2361, 8922]]),
    ("terrain:20000", "wide8", [[11859, 2149, 7294], [6069, 1297, 5333], [6280, 1068, 4398], [4658, 1202, 3419], [5306, 995, 3984], [6245, 980, 4011]]),
    ("terrain:20000", "wide16", [[8936, 2171, 7712], [4330, 1307, 5154], [4482, 1079, 4205], [3918, 1183, 3273], [3824, 1010, 3887], [4456, 985, 3853]]),
    ("even-spheres:20", "wide8", [[3207, 682, 2833], [1322, 540, 2253], [1150, 452, 1927], [3087, 648, 2597], [1260, 495, 2023], [1123, 424, 1775]]),
    ("even-spheres:20", "wide16", [[2589, 695, 2396], [973, 543, 1854], [875, 460, 1580], [2524, 645, 2233], [917, 498, 1680], [847, 444, 1513]]),
    ("plants:30", "wide8", [[3532, 900, 3154], [1266, 531, 1937], [995, 377, 1345], [3122, 563, 1988], [1160, 475, 1738], [952, 373, 1340]]),
    ("plants:30", "wide16", [[2949, 852, 2664], [956, 517, 1610], [771, 346, 1032], [2695, 527, 1616], [917, 467, 1469], [747, 337, 1007]]),
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
