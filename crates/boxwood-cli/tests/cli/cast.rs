//! `boxwood cast`: its arrays are read back with another NumPy library than wrote them.

use crate::bench::{Bench, LAYERS, scenes};
use crate::numpy::{Arrays, npy};
use npyz::Order;

const NONE: u32 = u32::MAX;
const INF: f32 = f32::INFINITY;

/// Rays down −z: through both layers, beside them, one that is not a number, and up from below.
const RAYS: [[f32; 6]; 4] = [
    [0.25, 0.5, 5.0, 0.0, 0.0, -2.0],
    [5.0, 5.0, 5.0, 0.0, 0.0, -1.0],
    [f32::NAN, 0.0, 0.0, 0.0, 0.0, -1.0],
    [0.25, 0.25, -3.0, 0.0, 0.0, 1.0],
];

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    bench.write("rays.npy", npy(6, RAYS.as_flattened(), Order::C));
    bench
}

#[test]
fn the_nearest_hits() {
    let bench = bench();
    let report = bench.json("cast layers.obj --rays rays.npy -o hits.npz --normals --json");
    let arrays = Arrays::read(bench.read("hits.npz"));
    assert_eq!(
        arrays.names(),
        ["geometry", "instance", "normal", "primitive", "t", "u", "v"]
    );
    assert_eq!(arrays.get::<f32>("t", &[4]), [2.5, INF, INF, 2.0]);
    assert_eq!(arrays.get::<f32>("u", &[4]), [0.25, 0.0, 0.0, 0.25]);
    assert_eq!(arrays.get::<f32>("v", &[4]), [0.5, 0.0, 0.0, 0.25]);
    assert_eq!(arrays.get::<u32>("primitive", &[4]), [0, NONE, NONE, 1]);
    assert_eq!(arrays.get::<u32>("geometry", &[4]), [0, NONE, NONE, 0]);
    assert_eq!(arrays.get::<u32>("instance", &[4]), [0, NONE, NONE, 0]);
    let normals = arrays.get::<f32>("normal", &[4, 3]);
    assert_eq!(normals, [0., 0., 1., 0., 0., 0., 0., 0., 0., 0., 0., 1.]);

    let fields: Vec<_> = report.as_object().expect("an object").keys().collect();
    assert_eq!(
        fields,
        [
            "build_seconds",
            "bytes",
            "cache",
            "hits",
            "mrays_per_second",
            "rays",
            "structure",
            "threads",
            "trace_seconds"
        ]
    );
    assert_eq!((&report["rays"], &report["hits"]), (&4.into(), &2.into()));
    assert_eq!(report["structure"], "wide8");
    assert!(report["mrays_per_second"].as_f64() > Some(0.0));
}

#[test]
fn all_hits() {
    let bench = bench();
    let report = bench.json("cast layers.obj --rays rays.npy -o hits.npz --all --normals --json");
    assert_eq!(report["hits"], 4);
    let arrays = Arrays::read(bench.read("hits.npz"));
    assert_eq!(arrays.get::<u64>("offsets", &[5]), [0, 2, 2, 2, 4]);
    assert_eq!(arrays.get::<f32>("t", &[4]), [2.5, 3.0, 2.0, 3.0]);
    assert_eq!(arrays.get::<u32>("primitive", &[4]), [0, 1, 1, 0]);
    assert_eq!(arrays.get::<f32>("normal", &[4, 3])[..3], [0.0, 0.0, 1.0]);
}

#[test]
fn any_hit() {
    let bench = bench();
    let report = bench.json("cast layers.obj --rays rays.npy -o hits.npz --any --json --threads 1");
    assert_eq!(
        (&report["hits"], &report["threads"]),
        (&2.into(), &1.into())
    );
    let arrays = Arrays::read(bench.read("hits.npz"));
    assert_eq!(arrays.names(), ["occluded"]);
    assert_eq!(
        arrays.get::<bool>("occluded", &[4]),
        [true, false, false, true]
    );
}

#[test]
fn intervals_are_closed_and_eight_columns_have_them() {
    let bench = bench();
    let ray = |t_min: f64, t_max: f64| [0.25, 0.25, 1.0, t_min, 0.0, 0.0, -1.0, t_max];
    let rays = [
        ray(0.0, 0.99),
        ray(1.0, 1.0),
        ray(1.01, 9.0),
        ray(2.01, f64::INFINITY),
    ];
    // The same in Fortran's order: column by column.
    let columns: Vec<f64> = (0..8)
        .flat_map(|c| rays.iter().map(move |ray| ray[c]))
        .collect();
    for (name, bytes) in [
        ("c.npy", npy(8, rays.as_flattened(), Order::C)),
        ("f.npy", npy(8, &columns, Order::Fortran)),
    ] {
        bench.write(name, bytes);
        bench.good(&format!("cast layers.obj --rays {name} -o hits.npz"));
        let arrays = Arrays::read(bench.read("hits.npz"));
        assert_eq!(arrays.get::<f32>("t", &[4]), [INF, 1.0, 2.0, INF], "{name}");
    }
}

#[test]
fn every_structure_and_any_threads_give_the_same_file() {
    let bench = bench();
    let mut seed = 1_u32;
    let mut random = move || {
        seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let rays: Vec<f32> = (0..6 * 1000).map(|_| random()).collect();
    bench.write("rays.npy", npy(6, &rays, Order::C));
    for mode in ["", "--normals", "--any", "--all --normals"] {
        let mut first = None;
        for kind in [
            "brute",
            "bvh:median",
            "bvh:median,leaf=1",
            "bvh:binned",
            "bvh:binned,bins=4",
        ] {
            for threads in [1, 2] {
                let words = format!(
                    "cast layers.obj --rays rays.npy -o hits.npz --accel {kind} --threads {threads} {mode}"
                );
                bench.good(&words);
                let bytes = bench.read("hits.npz");
                let first = first.get_or_insert_with(|| bytes.clone());
                assert!(*first == bytes, "boxwood {words} differs");
            }
        }
    }
}

#[test]
fn placements_are_told_apart() {
    let bench = bench();
    // Straight down on the table of the built-in scene and into its stands.
    let rays: Vec<f32> = (0..40)
        .flat_map(|i| [4.0 * i as f32 - 80.0, 200.0, 3.0, 0.0, -1.0, 0.0])
        .collect();
    bench.write("rays.npy", npy(6, &rays, Order::C));
    bench.good("cast teapot-in-stadium --rays rays.npy -o hits.npz");
    let info = bench.json("info teapot-in-stadium --json");
    let arrays = Arrays::read(bench.read("hits.npz"));
    let below = |name: &str, field: &str| {
        let end = info[field].as_u64().expect("a number") as u32;
        let found = arrays.get::<u32>(name, &[40]);
        assert!(
            found.iter().all(|&i| i < end || i == NONE),
            "{name}: {found:?}"
        );
        found
    };
    below("primitive", "unique_triangles");
    below("geometry", "meshes");
    let instances = below("instance", "instances");
    assert!(
        instances.iter().any(|&i| i != 0 && i != NONE),
        "{instances:?}"
    );
}

#[test]
fn no_rays_are_legal_and_no_output_is_no_file() {
    let bench = bench();
    bench.write("rays.npy", npy::<f32>(6, &[], Order::C));
    let report = bench.json("cast layers.obj --rays rays.npy -o hits.npz --all --json");
    assert_eq!(
        (&report["rays"], &report["mrays_per_second"]),
        (&0.into(), &0.0.into())
    );
    let arrays = Arrays::read(bench.read("hits.npz"));
    assert_eq!(arrays.get::<u64>("offsets", &[1]), [0]);
    assert!(arrays.get::<f32>("t", &[0]).is_empty());

    let before = bench.files();
    let text = bench.good("cast layers.obj --rays rays.npy --repeat 3");
    assert!(
        text.starts_with("0 rays, 0 hits\n") && text.contains("(median of 3 runs)"),
        "{text}"
    );
    assert_eq!(bench.files(), before);
}

#[test]
fn files_may_be_pipes() {
    let bench = bench();
    bench.good("cast layers.obj --rays rays.npy -o hits.npz");
    let mut command = bench.command("cast layers.obj --rays - -o -");
    command.stdin(std::fs::File::open(bench.path("rays.npy")).expect("rays"));
    let output = command.output().expect("it runs");
    assert!(output.status.success());
    assert!(output.stdout == bench.read("hits.npz"));
    let report = String::from_utf8(output.stderr).expect("text");
    assert!(report.starts_with("4 rays, 2 hits\n"), "{report}");
}

#[test]
fn errors_name_the_file_and_what_was_expected() {
    let bench = bench();
    bench.write("hits.npz", "mine");
    bench.write("seven.npy", npy(7, &[0.0_f32; 7], Order::C));
    bench.write("whole.npy", npy(6, &[0_i32; 6], Order::C));
    bench.write("cut.npy", &npy(6, &[0.0_f32; 12], Order::C)[..150]);
    for (words, sentence) in [
        ("--rays absent.npy", "absent.npy: cannot be read: "),
        (
            "--rays seven.npy",
            "seven.npy: has the shape (1, 7); expected (n, 6) ",
        ),
        (
            "--rays whole.npy",
            "whole.npy: holds numbers of type <i4; expected (n, 6) ",
        ),
        (
            "--rays cut.npy",
            "cut.npy: promises 2 rays of 24 bytes, but ",
        ),
        ("--rays layers.obj", "layers.obj: is not a NumPy .npy file"),
        (
            "--rays rays.npy -o ./rays.npy",
            "./rays.npy: cannot be written: it is what is to be read",
        ),
        (
            "--rays rays.npy -o layers.obj",
            "layers.obj: cannot be written: it is what is to be read",
        ),
        (
            "--rays rays.npy -o absent/hits.npz",
            "absent/hits.npz: cannot be written: there is no folder absent",
        ),
        (
            "--rays rays.npy -o rays.npy/hits.npz",
            "rays.npy/hits.npz: cannot be written: ",
        ),
    ] {
        let words = if words.contains("-o") {
            words.to_string()
        } else {
            format!("{words} -o hits.npz")
        };
        let error = bench.refused(&format!("cast layers.obj {words}"));
        assert!(error.starts_with(sentence), "{error}");
    }
    assert_eq!(bench.read("hits.npz"), b"mine");
    let files = [
        "cut.npy",
        "hits.npz",
        "layers.obj",
        "rays.npy",
        "seven.npy",
        "whole.npy",
    ];
    assert_eq!(bench.files(), files);
    for (words, sentence) in [
        ("--any --all", "cannot be used with"),
        ("--any --normals", "cannot be used with"),
        ("--accel quadtree", "no structure is called `quadtree`"),
        ("--threads 0", "0 is not in 1..=1024"),
        ("--repeat 0", "0 is not in 1.."),
    ] {
        let error = bench.misused(&format!("cast layers.obj --rays rays.npy {words}"));
        assert!(error.contains(sentence), "{error}");
    }
}

/// Rays from around the bunny towards it: all structures give the same bytes, and the judge agrees on a sample.
#[test]
fn the_bunny_looks_the_same_to_all() {
    let Some(scenes) = scenes() else { return };
    let bench = Bench::new();
    let mut seed = 7_u32;
    let mut random = move || {
        seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let rays: Vec<f32> = (0..6000)
        .flat_map(|_| {
            let [x, y, z] = [random() - 0.5, random() - 0.4, random() - 0.5];
            let target = [
                0.15 * random() - 0.095,
                0.15 * random() + 0.03,
                0.12 * random() - 0.06,
            ];
            [x, y, z, target[0] - x, target[1] - y, target[2] - z]
        })
        .collect();
    bench.write("rays.npy", npy(6, &rays, Order::C));
    bench.write("few.npy", npy(6, &rays[..600], Order::C));
    let bunny = scenes.join("bunny/bunny.ply");
    let cast = |rays: &str, kind: &str, threads: u32| {
        let report = bench.json(&format!(
            "cast {} --rays {rays} -o hits.npz --normals --accel {kind} --threads {threads} --json",
            bunny.display()
        ));
        assert!(report["hits"].as_u64() > report["rays"].as_u64().map(|n| n / 3));
        bench.read("hits.npz")
    };
    let expected = cast("rays.npy", "bvh:binned", 1);
    for (kind, threads) in [("bvh:binned", 2), ("bvh:median", 1), ("bvh:median", 2)] {
        assert!(
            cast("rays.npy", kind, threads) == expected,
            "{kind} with {threads} threads differs"
        );
    }
    assert!(
        cast("few.npy", "brute", 2) == cast("few.npy", "bvh:binned", 1),
        "the judge differs"
    );
}
