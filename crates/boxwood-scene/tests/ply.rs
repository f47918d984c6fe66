//! PLY: every way to write the same mesh gives the same scene, and damaged files end in a sentence.

mod ply_encoder;

use boxwood_scene::{Format, Mesh, NoFiles, Scene, SceneError, Source};
use ply_encoder::{ENCODINGS, Element, encode};
use proptest::prelude::*;

fn read(bytes: &[u8]) -> Result<Scene, SceneError> {
    let source = Source {
        name: "folder/mesh.ply",
        files: &NoFiles,
    };
    Scene::from_bytes(Format::Ply, bytes, source)
}

/// The error, without the file's name that it must begin with.
fn error(bytes: impl AsRef<[u8]>) -> String {
    let sentence = read(bytes.as_ref()).expect_err("an error").to_string();
    sentence
        .strip_prefix("folder/mesh.ply")
        .expect("the name")
        .to_owned()
}

/// The only warning, likewise.
fn warning(scene: &Scene) -> &str {
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    scene.warnings[0]
        .strip_prefix("folder/mesh.ply")
        .expect("the name")
}

/// Vertices with x, y, z on lines 4 to 6 of the header and faces with `vertex_indices` on line 8; rows from line 10.
fn file(format: &str, vertices: usize, faces: usize, rows: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    [header.as_bytes(), rows].concat()
}

fn ascii(vertices: usize, faces: usize, rows: &str) -> Vec<u8> {
    file("ascii", vertices, faces, rows.as_bytes())
}

const POSITIONS: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [2.0, 3.0, 0.0],
    [0.0, 3.0, 0.0],
    [-3.0, 1.0, 7.0],
];
const BYTES: [[f64; 4]; 3] = [
    [255.0, 0.0, 188.0, 255.0],
    [0.0, 255.0, 0.0, 0.0],
    [99.0, 1.0, 2.0, 51.0],
];

/// A quad and a triangle with every attribute, among elements and properties without meaning.
fn elements<'a>(real: &'a str, list: &'a str, color: &'a str) -> Vec<Element<'a>> {
    let noise = |name| Element {
        name,
        properties: vec![("list ushort double", "weights"), ("char", "flag")],
        rows: (0..3).map(|i| vec![vec![0.5; i], vec![-1.0]]).collect(),
    };
    let vertex = |i: usize| {
        let mut row = vec![vec![9.0]];
        row.extend(POSITIONS[i].map(|c| vec![c]));
        row.extend([vec![1.0; i % 3], vec![0.0], vec![0.0], vec![1.0]]);
        row.extend([vec![0.25 * i as f64], vec![0.125 * i as f64]]);
        row.extend(BYTES[i % 3].map(|c| vec![c]));
        row
    };
    let vertices = Element {
        name: "vertex",
        properties: vec![
            ("short", "quality"),
            (real, "x"),
            (real, "y"),
            (real, "z"),
            ("list char float", "neighbours"),
            ("float", "nx"),
            ("double", "ny"),
            ("float32", "nz"),
            ("float", "s"),
            ("float64", "t"),
            (color, "red"),
            (color, "green"),
            (color, "blue"),
            (color, "alpha"),
        ],
        rows: (0..POSITIONS.len()).map(vertex).collect(),
    };
    let faces = Element {
        name: "face",
        properties: vec![
            ("float", "area"),
            (list, "vertex_indices"),
            ("list uint int8", "more"),
        ],
        rows: vec![
            vec![vec![6.0], vec![0.0, 1.0, 2.0, 3.0], vec![]],
            vec![vec![1.0], vec![3.0, 4.0, 0.0], vec![1.0, -1.0]],
        ],
    };
    vec![
        noise("before"),
        vertices,
        noise("between"),
        faces,
        noise("after"),
    ]
}

fn assert_same(a: &Mesh, b: &Mesh, what: &str) {
    assert_eq!(a.positions, b.positions, "{what}");
    assert_eq!(a.triangles, b.triangles, "{what}");
    assert_eq!(a.normals, b.normals, "{what}");
    assert_eq!(a.uvs, b.uvs, "{what}");
    assert_eq!(a.colors, b.colors, "{what}");
}

#[test]
fn every_encoding_and_type_gives_the_same_scene() {
    let first = read(&encode(
        "ascii",
        "\n",
        &elements("float", "list uchar int", "uchar"),
    ))
    .unwrap();
    let mesh = &first.meshes[0];
    assert_eq!(mesh.positions, POSITIONS.map(|p| p.map(|c| c as f32)));
    assert_eq!(mesh.triangles.len(), 3);
    assert_eq!(mesh.triangles[2], [3, 4, 0]);
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 5]);
    assert_eq!(mesh.uvs[2], [0.5, 0.75]);
    assert_eq!((mesh.colors[0][0], mesh.colors[0][1]), (1.0, 0.0));
    assert!((mesh.colors[0][2] - 0.5029).abs() < 1e-4);
    assert_eq!(mesh.colors[2][3], 0.2);
    assert_eq!(mesh.name, "mesh");
    assert!(mesh.smooth && first.warnings.is_empty());
    assert_eq!((first.instances.len(), first.materials.len()), (1, 1));
    assert_eq!(first.up, [0.0, 1.0, 0.0]);

    for encoding in ENCODINGS {
        for real in [
            "float", "float32", "double", "float64", "char", "int8", "short", "int16", "int",
            "int32",
        ] {
            for count in ["char", "uint8", "int16", "ushort", "int32", "uint"] {
                for item in ["int8", "uchar", "short", "uint16", "int", "uint32"] {
                    for (color, end) in [("uchar", "\n"), ("int", "\r\n"), ("short", "\r")] {
                        let list = format!("list {count} {item}");
                        let bytes = encode(encoding, end, &elements(real, &list, color));
                        let what = format!("{encoding} {real} {list} {color} {end:?}");
                        let scene = read(&bytes).unwrap_or_else(|e| panic!("{what}: {e}"));
                        assert!(scene.warnings.is_empty(), "{what}: {:?}", scene.warnings);
                        assert_same(&scene.meshes[0], mesh, &what);
                    }
                }
            }
        }
    }
}

#[test]
fn even_rows_are_read_as_uneven_ones_are() {
    for encoding in ENCODINGS {
        for color in ["uchar", "ushort", "float"] {
            let uneven = elements("float", "list uchar int", color);
            let mut even = elements("float", "list uchar int", color);
            even[1].properties.remove(4);
            even[1].rows.iter_mut().for_each(|row| drop(row.remove(4)));
            let [a, b] = [uneven, even].map(|e| read(&encode(encoding, "\n", &e)).unwrap());
            assert_same(&a.meshes[0], &b.meshes[0], encoding);
        }
    }
}

#[test]
fn faces_may_come_before_vertices_and_under_another_name() {
    for encoding in ENCODINGS {
        let right = read(&encode(
            encoding,
            "\n",
            &elements("float", "list uchar int", "uchar"),
        ))
        .unwrap();
        let mut swapped = elements("float", "list uchar int", "uchar");
        swapped.swap(1, 3);
        swapped[1].properties[1].1 = "vertex_index";
        let scene = read(&encode(encoding, "\n", &swapped)).unwrap();
        assert_eq!(scene.warnings, [""; 0]);
        assert_same(&scene.meshes[0], &right.meshes[0], encoding);
    }
}

#[test]
fn common_binary_layouts_mix_with_polygons() {
    for encoding in ["binary_little_endian", "binary_big_endian"] {
        let elements = [
            Element {
                name: "vertex",
                properties: vec![("float", "x"), ("float", "y"), ("float", "z")],
                rows: POSITIONS.map(|p| p.map(|c| vec![c]).to_vec()).to_vec(),
            },
            Element {
                name: "face",
                properties: vec![("list uchar int", "vertex_indices")],
                rows: [
                    vec![0.0, 1.0, 2.0],
                    vec![0.0, 1.0],
                    vec![0.0, 1.0, 2.0, 3.0],
                    vec![],
                    vec![4.0, 3.0, 0.0],
                ]
                .map(|list| vec![list])
                .to_vec(),
            },
        ];
        let scene = read(&encode(encoding, "\n", &elements)).unwrap();
        let triangles = &scene.meshes[0].triangles;
        assert_eq!(
            (triangles.len(), triangles[0], triangles[3]),
            (4, [0, 1, 2], [4, 3, 0])
        );
        let text = ": the first of 2 faces with fewer than three corners, which are skipped";
        assert!(warning(&scene).starts_with(", byte ") && warning(&scene).ends_with(text));
    }
}

#[test]
fn strips_become_triangles() {
    let strips = [0.0, 1.0, 2.0, 3.0, -1.0, 2.0, 3.0, 4.0];
    for encoding in ENCODINGS {
        let mut elements = elements("float", "list int int", "uchar");
        elements[3].name = "tristrips";
        elements[3].rows = vec![vec![vec![0.0], strips.to_vec(), vec![]]];
        let scene = read(&encode(encoding, "\n", &elements)).unwrap();
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    }
}

#[test]
fn a_file_without_faces_is_a_scene_with_a_warning() {
    let scene = read(&ascii(2, 0, "0 0 0\n1 1 1")).unwrap();
    assert!(scene.meshes.is_empty() && scene.instances.is_empty());
    assert_eq!(
        warning(&scene),
        ": a point cloud: 2 vertices without a face, nothing to show"
    );
    let scene = read(b"ply\nformat ascii 1.0\nend_header").unwrap();
    assert_eq!(
        warning(&scene),
        ": the file has neither vertices nor faces: nothing to show"
    );
}

#[test]
fn what_is_passed_over_is_said() {
    let scene = read(&ascii(
        3,
        1,
        "\n0 0 0 7\n\n1 0 0 7 8\n 0 1 0\t\n3 0 1 2 255 0 0\n",
    ))
    .unwrap();
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(
        warning(&scene),
        ", line 11: the first of 3 lines that end with values that the header does not promise; these are ignored"
    );
    let scene = read(&ascii(3, 1, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n4 5")).unwrap();
    assert_eq!(
        warning(&scene),
        ", line 14: the header promises nothing from here to the end of the file, which is ignored"
    );
    let scene = read(&ascii(3, 2, "0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2")).unwrap();
    assert_eq!(
        warning(&scene),
        ", line 13: a face with fewer than three corners is skipped"
    );
    let mut bytes = encode(
        "binary_big_endian",
        "\n",
        &elements("float", "list uchar int", "uchar"),
    );
    bytes.extend([0; 5]);
    assert!(warning(&read(&bytes).unwrap()).ends_with("the last 5 bytes of the file are ignored"));
}

#[test]
fn broken_headers_are_told_by_line() {
    let after = |lines: &str| error(format!("ply\nformat ascii 1.0\n{lines}\nend_header\n"));
    let cases = [
        (error(b""), ": the file is empty; expected `ply`"),
        (
            error("solid x\n"),
            ", line 1: the file begins with `solid`; expected `ply`",
        ),
        (
            error("plywood\n"),
            ", line 1: the file begins with `plywood`; expected `ply`",
        ),
        (
            error("ply\nformat ascii 1.0\nelement vertex 3\n"),
            ", line 3: the file ends within the header; expected `end_header`",
        ),
        (
            error("ply\nend_header\n"),
            ", line 2: the header ends without a format; expected `format ascii 1.0` or a binary one",
        ),
        (
            error("ply\nformat binary 1.0\nend_header\n"),
            ", line 2: unknown format `binary`; expected ascii, binary_little_endian or binary_big_endian",
        ),
        (
            error("ply\nformat ascii 2.0\n"),
            ", line 2: version `2.0` of PLY; expected 1.0",
        ),
        (
            after("element vertex -3"),
            ", line 3: element `vertex` has `-3` rows; expected a whole number",
        ),
        (
            after("property float x"),
            ", line 3: property `x` comes before any element",
        ),
        (
            after("element vertex 0\nproperty half x"),
            ", line 4: unknown type `half`; expected char, uchar, short, ushort, int, uint, float, double, or int8, \
             uint8, int16, uint16, int32, uint32, float32, float64",
        ),
        (
            after("element face 0\nproperty list float int vertex_indices"),
            ", line 4: the count of a list has type `float`; expected an integer type",
        ),
        (
            after("element face 0\nproperty list uchar vertex_indices"),
            ", line 4: a list property is incomplete; expected `property list COUNT_TYPE ITEM_TYPE NAME`",
        ),
        (
            after("elephant"),
            ", line 3: `elephant` is no line of a PLY header; expected `format NAME 1.0`, `element NAME COUNT`, \
             `property TYPE NAME`, `comment ...` or `end_header`",
        ),
        (
            after("element vertex 0\nelement vertex 0"),
            ", line 4: there is an element `vertex` already",
        ),
        (
            after("element vertex 0\nproperty float x\nproperty int x"),
            ", line 5: element `vertex` has a property `x` already",
        ),
    ];
    for (found, expected) in cases {
        assert_eq!(found, expected);
    }
}

#[test]
fn broken_rows_are_told_by_line() {
    let huge = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n";
    let flat = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar float vertex_indices\nend_header\n3 0 0 0\n";
    let cases = [
        (
            error(ascii(1_000_000_000, 1, "0 0 0\n")),
            ", line 3: 1000000000 rows of `vertex` take 6000000000 bytes or more, but the file has 7 left for them",
        ),
        (
            error(ascii(5, 1, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n 0 0 0 ")),
            ", line 14: the file ends after 0 of the 1 rows of `face` that line 7 promises",
        ),
        (
            error(ascii(2, 0, "0 0 0\n1 0\n 0")),
            ", line 11: the line of vertex 1 ends before `z`, which line 6 of the header promises",
        ),
        (
            error(ascii(1, 0, "0 0.5.5 0")),
            ", line 10: expected a number for `y` of vertex 0, found `0.5.5`",
        ),
        (
            error(ascii(1, 0, "0 1e400 0")),
            ", line 10: vertex 0 stands at (0, inf, 0) in single precision; expected finite coordinates",
        ),
        (
            error(ascii(1, 0, "nan 0 0")),
            ", line 10: vertex 0 stands at (NaN, 0, 0) in single precision; expected finite coordinates",
        ),
        (
            error(ascii(1, 1, "0 0 0\n3 0 0 1")),
            ", line 11: face 0 names vertex 1, but there are 1 (counted from 0)",
        ),
        (
            error(ascii(1, 1, "0 0 0\n3 0 -1 0")),
            ", line 11: face 0 names vertex -1, but there are 1 (counted from 0)",
        ),
        (
            error(ascii(1, 1, "0 0 0\n3 0 0")),
            ", line 11: the line of face 0 ends within `vertex_indices`, which line 8 of the header promises",
        ),
        (
            error(ascii(1, 1, "0 0 0\n-3 0 0 0")),
            ", line 11: expected a whole number, the count of `vertex_indices` of face 0, found `-3`",
        ),
        (
            error(ascii(1, 1, "0 0 0\n3 0 0.5 0")),
            ", line 11: expected a whole number, an index in `vertex_indices` of face 0, found `0.5`",
        ),
        (
            error(huge),
            ", line 3: element `vertex` has no number `y`; expected x, y and z",
        ),
        (
            error(flat),
            ", line 3: element `face` has no list of integers `vertex_indices` or `vertex_index`",
        ),
    ];
    for (found, expected) in cases {
        assert_eq!(found, expected);
    }
}

#[test]
fn broken_binary_rows_are_told_by_byte() {
    let vertex: Vec<u8> = [0.0_f32, 1.0, 2.0]
        .iter()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    let nan: Vec<u8> = [0.0_f32, 1.0, f32::NAN]
        .iter()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    let face = |count: u8, indices: &[i32]| {
        let indices = indices.iter().flat_map(|i| i.to_le_bytes());
        [vec![count], indices.collect()].concat()
    };
    let binary = |vertices, faces, rows: &[&[u8]]| {
        file("binary_little_endian", vertices, faces, &rows.concat())
    };
    let start = binary(1, 1, &[]).len();
    let cases = [
        (
            error(binary(1, 4_294_967_295, &[&vertex, &face(3, &[0; 3])])),
            ", line 7: 4294967295 rows of `face` take 4294967295 bytes or more, but the file has 13 left for them"
                .to_owned(),
        ),
        (
            error(binary(1, 2, &[&vertex, &face(3, &[0; 3]), &face(3, &[0; 2])])),
            format!(
                ", byte {}: the file ends within row 1 of `face`; the header promises 2 rows",
                start + 12 + 13 + 9
            ),
        ),
        (
            error(binary(2, 1, &[&vertex, &nan, &face(3, &[0; 3])])),
            format!(
                ", byte {}: vertex 1 stands at (0, 1, NaN) in single precision; expected finite coordinates",
                start + 12
            ),
        ),
        (
            error(binary(1, 1, &[&vertex, &face(3, &[0, 0, -1])])),
            format!(
                ", byte {}: face 0 names vertex -1, but there are 1 (counted from 0)",
                start + 12 + 9
            ),
        ),
        (
            error(binary(1, 1, &[&vertex, &face(3, &[1, 0, 0])])),
            format!(
                ", byte {}: face 0 names vertex 1, but there are 1 (counted from 0)",
                start + 12 + 1
            ),
        ),
    ];
    for (found, expected) in cases {
        assert_eq!(found, expected);
    }
    let signed = b"ply\nformat binary_big_endian 1.0\nelement vertex 0\nelement face 1\n\
                   property list char int vertex_index\nend_header\n\xff";
    let byte = signed.len() - 1;
    assert_eq!(
        error(signed),
        format!(", byte {byte}: a list of face 0 has -1 values; expected a count of 0 or more")
    );
}

#[test]
fn rows_of_nothing_cost_nothing() {
    for encoding in ENCODINGS {
        let text =
            format!("ply\nformat {encoding} 1.0\nelement empty 18446744073709551615\nend_header\n");
        assert!(read(text.as_bytes()).unwrap().meshes.is_empty());
    }
}

proptest! {
    #[test]
    fn any_bytes_end_in_a_scene_or_a_sentence(bytes in proptest::collection::vec(any::<u8>(), 0..400), kind in 0..4_usize) {
        let bytes = match ENCODINGS.get(kind) {
            Some(encoding) => file(encoding, 3, 5, &bytes),
            None => bytes,
        };
        let _ = read(&bytes);
    }

    #[test]
    fn a_damaged_file_ends_in_a_scene_or_a_sentence(
        kind in 0..3_usize,
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        end in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let mut bytes = encode(ENCODINGS[kind], "\n", &elements("float", "list uchar int", "uchar"));
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cut {
            bytes.truncate(end.index(bytes.len()));
        }
        match read(&bytes) {
            Err(error) => prop_assert!(error.to_string().starts_with("folder/mesh.ply")),
            Ok(scene) => for mesh in &scene.meshes {
                let count = mesh.positions.len();
                prop_assert!(mesh.triangles.as_flattened().iter().all(|i| (*i as usize) < count));
                prop_assert!(mesh.positions.as_flattened().iter().all(|c| c.is_finite()));
                prop_assert!([mesh.normals.len(), mesh.uvs.len(), mesh.colors.len()].iter().all(|n| *n == 0 || *n == count));
                prop_assert!(mesh.normals.iter().all(|n| (n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-4));
            },
        }
    }
}
