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
    ("teapot-in-stadium", "wide8", [[13118, 2679, 11510], [13350, 3567, 15197], [9879, 2143, 9353], [5768, 1319, 4193], [8182, 1919, 7483], [9657, 2079, 9084]]),
    ("teapot-in-stadium", "wide16", [[8668, 3028, 12437], [9289, 3674, 14932], [6729, 2261, 9215], [3451, 1294, 4067], [5685, 2013, 7601], [6599, 2202, 8998]]),
    ("terrain:20000", "wide8", [[11857, 2150, 7323], [6075, 1298, 5356], [6311, 1076, 4516], [4654, 1194, 3384], [5312, 999, 4036], [6276, 988, 4132]]),
    ("terrain:20000", "wide16", [[8941, 2176, 7724], [4336, 1315, 5123], [4491, 1088, 4228], [3913, 1185, 3286], [3823, 1008, 3866], [4470, 990, 3871]]),
    ("even-spheres:20", "wide8", [[3216, 705, 2925], [1335, 547, 2290], [1159, 460, 1924], [3084, 655, 2614], [1257, 504, 2036], [1134, 435, 1802]]),
    ("even-spheres:20", "wide16", [[2575, 704, 2462], [966, 546, 1951], [872, 460, 1645], [2506, 650, 2219], [919, 499, 1733], [849, 448, 1580]]),
    ("plants:30", "wide8", [[3510, 924, 3364], [1259, 540, 1969], [987, 372, 1394], [3113, 583, 2112], [1168, 488, 1744], [945, 364, 1350]]),
    ("plants:30", "wide16", [[2939, 858, 2728], [951, 514, 1672], [754, 359, 1135], [2668, 534, 1719], [916, 466, 1509], [726, 344, 1079]]),
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
