//! `boxwood query`: what is near points, and what is around them.

use crate::bench::{Bench, LAYERS};
use crate::numpy::{Arrays, npy};
use npyz::Order;

const NONE: u32 = u32::MAX;

/// Above the upper layer, between the layers but nearer to the lower, and nowhere.
const POINTS: [[f64; 3]; 3] = [[0.25, 0.25, 2.0], [0.0, 0.0, -0.75], [f64::NAN, 0.0, 0.0]];

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    bench.write("points.npy", npy(3, POINTS.as_flattened(), Order::C));
    bench
}

#[test]
fn the_closest_points() {
    let bench = bench();
    let report = bench.json("query layers.obj --points points.npy -o near.npz --json closest");
    assert_eq!(
        (&report["points"], &report["found"]),
        (&3.into(), &2.into())
    );
    let arrays = Arrays::read(bench.read("near.npz"));
    assert_eq!(
        arrays.names(),
        [
            "distance",
            "geometry",
            "instance",
            "point",
            "primitive",
            "u",
            "v"
        ]
    );
    assert_eq!(
        arrays.get::<f32>("distance", &[3]),
        [2.0, 0.25, f32::INFINITY]
    );
    let points = arrays.get::<f32>("point", &[3, 3]);
    assert_eq!(points, [0.25, 0.25, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0]);
    assert_eq!(arrays.get::<u32>("primitive", &[3]), [0, 1, NONE]);
    assert_eq!(arrays.get::<f32>("u", &[3]), [0.25, 0.0, 0.0]);
}

#[test]
fn lists_of_triangles() {
    let bench = bench();
    // Options may follow the question.
    bench.good("query layers.obj --points points.npy nearest -k 2 -o near.npz");
    let arrays = Arrays::read(bench.read("near.npz"));
    assert_eq!(arrays.get::<u64>("offsets", &[4]), [0, 2, 4, 4]);
    assert_eq!(arrays.get::<u32>("primitive", &[4]), [0, 2, 1, 0]);
    let text = bench.good("query layers.obj --points points.npy --threads 1 within -r 0.75");
    assert!(
        text.starts_with("3 points, 2 triangles found\nbuilt   a tree in "),
        "{text}"
    );
    assert!(text.contains("with 1 thread"), "{text}");
}

#[test]
fn insides() {
    let bench = Bench::new();
    let mut stl = String::from("solid tetrahedron\n");
    let corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]];
    for triangle in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        stl += "facet normal 0 0 0\nouter loop\n";
        for corner in triangle {
            let [x, y, z] = corners[corner];
            stl += &format!("vertex {x} {y} {z}\n");
        }
        stl += "endloop\nendfacet\n";
    }
    bench.write("tetrahedron.stl", stl + "endsolid tetrahedron\n");
    let points = [
        [1.0_f32, 1.0, 1.0],
        [3.0, 3.0, 3.0],
        [1.0, 1.0, 2.0],
        [1.0, 1.0, 0.0],
    ];
    bench.write("points.npy", npy(3, points.as_flattened(), Order::C));
    bench.good("query tetrahedron.stl --points points.npy -o in.npz inside");
    let arrays = Arrays::read(bench.read("in.npz"));
    assert_eq!(arrays.names(), ["inside", "on_surface", "winding"]);
    assert_eq!(
        arrays.get::<bool>("inside", &[4]),
        [true, false, true, true]
    );
    assert_eq!(
        arrays.get::<bool>("on_surface", &[4]),
        [false, false, true, true]
    );
    assert_eq!(arrays.get::<i64>("winding", &[4])[..2], [1, 0]);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let bench = bench();
    bench.write("rays.npy", npy(6, &[0.0_f32; 6], Order::C));
    assert_eq!(
        bench.refused("query layers.obj --points rays.npy closest"),
        "rays.npy: has the shape (1, 6); expected (n, 3) `x y z` of float32 or float64"
    );
    for words in ["", "nearest", "nearest -k 0", "within -r -1", "inside -k 2"] {
        bench.misused(&format!("query layers.obj --points points.npy {words}"));
    }
}
