//! STL: ascii, binary and what pretends to be either; damaged files end in a sentence.

use boxwood_scene::{Format, NoFiles, Scene, SceneError, Source};
use proptest::prelude::*;

fn read(bytes: &[u8]) -> Result<Scene, SceneError> {
    let source = Source {
        name: "folder/part.stl",
        files: &NoFiles,
    };
    Scene::from_bytes(Format::Stl, bytes, source)
}

/// The error, without the file's name that it must begin with.
fn error(bytes: impl AsRef<[u8]>) -> String {
    let sentence = read(bytes.as_ref()).expect_err("an error").to_string();
    sentence
        .strip_prefix("folder/part.stl")
        .expect("the name")
        .to_owned()
}

type Triangle = [[f32; 3]; 3];

const TWO: [Triangle; 2] = [
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, -0.0]],
    [[1.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
];

fn binary(header: &[u8], count: u32, triangles: &[Triangle]) -> Vec<u8> {
    let mut out = header.to_vec();
    out.resize(80, b' ');
    out.extend(count.to_le_bytes());
    for triangle in triangles {
        let floats = [[9.0; 3], triangle[0], triangle[1], triangle[2]];
        out.extend(floats.as_flattened().iter().flat_map(|f| f.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

fn solid(name: &str, triangles: &[Triangle]) -> String {
    let mut out = format!("solid {name}\n");
    for triangle in triangles {
        out += "facet normal 0 0 nan\n outer loop\n";
        for [x, y, z] in triangle {
            out += &format!("  vertex {x} {y:e} {z}\n");
        }
        out += " endloop\nendfacet\n";
    }
    out + &format!("endsolid {name}\n")
}

#[test]
fn ascii_and_binary_are_the_same_scene() {
    let text = solid("two parts", &TWO);
    let scenes = [
        binary(b"any header", 2, &TWO),
        binary(b"solid facet", 2, &TWO),
        text.clone().into_bytes(),
        text.to_uppercase().into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        text.replace('\n', "\r").into_bytes(),
        text.replace(' ', "\t  ").into_bytes(),
        [b"\xef\xbb\xbf\n ", text.as_bytes()].concat(),
        text.replace('\n', " ").into_bytes(),
    ];
    for (number, bytes) in scenes.iter().enumerate() {
        let scene = read(bytes).unwrap_or_else(|e| panic!("{number}: {e}"));
        let mesh = &scene.meshes[0];
        assert_eq!(
            mesh.positions,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.0]],
            "{number}"
        );
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 2, 2]], "{number}");
        assert_eq!((scene.instances.len(), scene.materials.len()), (1, 1));
        assert_eq!((scene.up, mesh.smooth), ([0.0, 0.0, 1.0], false));
        assert_eq!(scene.warnings, [""; 0]);
    }
    let names = [0, 1, 2, 8].map(|i| read(&scenes[i]).unwrap().meshes[0].name.clone());
    assert_eq!(names, ["part", "part", "two parts", "two parts"]);
}

#[test]
fn each_solid_with_triangles_is_a_mesh() {
    let text = solid("a", &TWO) + &solid("empty", &[]) + &solid("", &TWO[..1]);
    for text in [text.clone(), text.replace('\n', " ")] {
        let scene = read(text.as_bytes()).unwrap();
        let meshes: Vec<_> = scene
            .meshes
            .iter()
            .map(|m| (m.name.as_str(), m.triangles.len()))
            .collect();
        assert_eq!(meshes, [("a", 2), ("part", 1)]);
        assert_eq!(scene.instances.len(), 2);
    }
    // A name may hold any word.
    let scene = read((solid("my solid facet", &TWO) + &solid("b", &TWO)).as_bytes()).unwrap();
    assert_eq!(scene.meshes[0].name, "my solid facet");
    assert_eq!(scene.meshes.len(), 2);
}

#[test]
fn nothing_to_show_is_a_warning() {
    for bytes in [solid("x", &[]).into_bytes(), binary(b"", 0, &[])] {
        let scene = read(&bytes).unwrap();
        assert!(scene.meshes.is_empty());
        assert_eq!(
            scene.warnings,
            ["folder/part.stl: the file has no triangles: nothing to show"]
        );
    }
}

#[test]
fn surplus_bytes_are_a_warning() {
    for header in [&b""[..], b"solid "] {
        let scene = read(&binary(header, 1, &TWO)).unwrap();
        assert_eq!(scene.triangle_count(), 1);
        assert_eq!(
            scene.warnings,
            [
                "folder/part.stl, byte 134: the count promises 1 triangles; the 50 bytes after them are ignored"
            ]
        );
    }
}

#[test]
fn damage_is_told_by_line_or_byte() {
    let mut infinite = TWO;
    infinite[1][2][1] = f32::INFINITY;
    let text = solid("s", &TWO);
    let cases = [
        (error(b""), ": the file is empty; expected an STL model"),
        (
            error(b"hello"),
            ": neither ascii nor binary STL; expected `solid` at the start or at least 84 bytes, found 5",
        ),
        (
            error(binary(b"solid", 4_000_000_000, &TWO)),
            ", byte 80: the count promises 4000000000 triangles, but the file has room for 2",
        ),
        (
            error(binary(b"", 2, &infinite)),
            ", byte 174: vertex 2 of triangle 1 has a coordinate inf; expected a finite number",
        ),
        (
            error("solid"),
            ", line 1: the file ends within a solid; expected `facet` or `endsolid`",
        ),
        (
            error(&text[..text.len() / 2]),
            ", line 9: the file ends within a solid; expected `facet` or `endsolid`, found `f`",
        ),
        (
            error(text.replace("endsolid s\n", "")),
            ", line 15: the file ends within a solid; expected `facet` or `endsolid`",
        ),
        (
            error(&text[..text.find("loop\nendfacet").unwrap()]),
            ", line 7: the file ends within a solid; expected `endloop`, found `end`",
        ),
        (
            error(text.replacen("vertex 1 ", "vertex 1,5 ", 1)),
            ", line 5: expected a finite coordinate, found `1,5`",
        ),
        (
            error(text.replacen("vertex 1 ", "vertex inf ", 1)),
            ", line 5: expected a finite coordinate, found `inf`",
        ),
        (
            error(text.replacen("endloop", "vertex 0 0 0 endloop", 1)),
            ", line 7: expected `endloop`, found `vertex`",
        ),
        (
            error(text.replacen("endfacet", "", 1)),
            ", line 9: expected `endfacet`, found `facet`",
        ),
        (
            error(text + "color 1 2 3"),
            ", line 17: expected `solid`, found `color`",
        ),
    ];
    for (found, expected) in cases {
        assert_eq!(found, expected);
    }
}

proptest! {
    #[test]
    fn any_bytes_end_in_a_scene_or_a_sentence(bytes in proptest::collection::vec(any::<u8>(), 0..300), text in any::<bool>()) {
        let start: &[u8] = if text { b"solid x\nfacet normal 0 0 1 outer loop vertex " } else { b"" };
        let _ = read(&[start, &bytes].concat());
    }

    #[test]
    fn a_damaged_file_ends_in_a_scene_or_a_sentence(
        text in any::<bool>(),
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        end in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let mut bytes = if text { solid("s", &TWO).into_bytes() } else { binary(b"", 2, &TWO) };
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cut {
            bytes.truncate(end.index(bytes.len()));
        }
        match read(&bytes) {
            Err(error) => prop_assert!(error.to_string().starts_with("folder/part.stl")),
            Ok(scene) => for mesh in &scene.meshes {
                prop_assert!(mesh.triangles.as_flattened().iter().all(|i| (*i as usize) < mesh.positions.len()));
                prop_assert!(mesh.positions.as_flattened().iter().all(|c| c.is_finite()));
            },
        }
    }
}

/// Finding the line of each solid from the start of the file made this take minutes.
#[test]
fn a_flood_of_solids_is_read_in_one_go() {
    let solid = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                 endloop\nendfacet\nendsolid a\n";
    let text = solid.repeat(50_000);
    let source = Source {
        name: "flood.stl",
        files: &NoFiles,
    };
    let scene = Scene::from_bytes(Format::Stl, text.as_bytes(), source).expect("a good file");
    assert_eq!(scene.triangle_count(), 50_000);
}
