//! The hierarchy, and what stands in it.

use crate::files::triangle;
use crate::{error, scene};
use boxwood_scene::{LightKind, Projection};

#[test]
fn shared_meshes_are_instances_in_depth_first_order() {
    let file = triangle();
    let rest = r#""meshes":[{"name":"unused","primitives":[{"attributes":{"POSITION":0}}]},{"name":"two","primitives":[{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"mode":1},{"attributes":{"POSITION":0}}]},{"name":"one","primitives":[{"attributes":{"POSITION":0}}]}],
        "nodes":[{"mesh":2,"translation":[0,0,5]},{"mesh":1,"children":[3,2],"translation":[1,0,0]},{"mesh":2,"translation":[0,1,0]},{"mesh":1,"scale":[-1,1,1],"translation":[0,0,2]}],
        "scene":1,"scenes":[{"nodes":[0]},{"nodes":[1,0]}]"#;
    let scene = scene(file.text(rest));
    let names: Vec<&str> = scene.meshes.iter().map(|m| &*m.name).collect();
    assert_eq!(names, ["two.0", "two.2", "one"]);
    let found: Vec<_> = scene
        .instances
        .iter()
        .map(|i| {
            (
                i.mesh,
                i.transform.point([0.0; 3]).into(),
                i.transform.mirrors(),
            )
        })
        .collect();
    let expected: [(u32, [f32; 3], bool); 6] = [
        (0, [1.0, 0.0, 0.0], false),
        (1, [1.0, 0.0, 0.0], false),
        (0, [1.0, 0.0, 2.0], true),
        (1, [1.0, 0.0, 2.0], true),
        (2, [1.0, 1.0, 0.0], false),
        (2, [0.0, 0.0, 5.0], false),
    ];
    assert_eq!(found, expected);
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("meshes[1].primitives[1]"));
}

#[test]
fn the_first_scene_is_shown_when_none_is_named_and_all_roots_when_there_is_none() {
    let file = triangle();
    let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0},{"mesh":0},{"mesh":0}]"#;
    let first = format!(r#"{mesh},"scenes":[{{"nodes":[2]}},{{"nodes":[0,1]}}]"#);
    assert_eq!(scene(file.text(&first)).instances.len(), 1);
    let second = format!(r#"{first},"scene":1"#);
    assert_eq!(scene(file.text(&second)).instances.len(), 2);
    assert_eq!(scene(file.text(mesh)).instances.len(), 3);
}

#[test]
fn a_child_may_be_listed_as_a_root_but_stands_only_once() {
    let file = triangle();
    let rest = |roots: &str| {
        format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"children":[1],"translation":[5,0,0]}},{{"mesh":0,"translation":[0,1,0]}}],"scenes":[{{"nodes":[{roots}]}}]"#
        )
    };
    let scene = scene(file.text(&rest("1")));
    let place: [f32; 3] = scene.instances[0].transform.point([0.0; 3]).into();
    assert_eq!(place, [0.0, 1.0, 0.0]);
    for roots in ["0,1", "1,0", "1,1"] {
        let sentence = error(file.text(&rest(roots)));
        assert!(
            sentence.contains("scenes[0].nodes: node 1 stands in the scene twice"),
            "{sentence}"
        );
    }
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_is_no_trouble() {
    let length = 100_000;
    let link = |n: usize| format!(r#"{{"children":[{}],"translation":[0.25,0,0]}}"#, n + 1);
    let links: Vec<String> = (0..length).map(link).collect();
    let rest = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{},{{"mesh":0}}]"#,
        links.join(",")
    );
    let scene = scene(triangle().text(&rest));
    let [x, ..]: [f32; 3] = scene.instances[0].transform.point([0.0; 3]).into();
    assert_eq!(x, 25_000.0);
}

#[test]
fn nodes_on_rings_and_with_two_parents_are_refused() {
    let nodes = |nodes: &str| {
        error(format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}]}}"#
        ))
    };
    let ring = nodes(r#"{"children":[1]},{"children":[2]},{"children":[0]}"#);
    assert!(
        ring.contains("nodes[2].children[0]: node 0 is its own descendant"),
        "{ring}"
    );
    let itself = nodes(r#"{},{"children":[1]}"#);
    assert!(itself.contains("nodes[1].children[0]"), "{itself}");
    let shared = nodes(r#"{"children":[2]},{"children":[2]},{}"#);
    assert!(
        shared.contains("nodes[1].children[0]: node 2 already has a parent, nodes[0]"),
        "{shared}"
    );
    let absent = nodes(r#"{"children":[7]}"#);
    assert!(
        absent.contains("nodes[0].children[0]: names node 7, but there is only one"),
        "{absent}"
    );
}

#[test]
fn cameras_and_lights_stand_where_their_nodes_do() {
    // The second node looks along +x: a quarter turn about −y.
    let file = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual"],
        "cameras":[{"name":"near","type":"perspective","perspective":{"yfov":0.5,"znear":0.1}},{"type":"orthographic","orthographic":{"xmag":1,"ymag":3,"znear":0,"zfar":1}}],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0.5,0],"intensity":4,"range":9},{"name":"sun","type":"directional"},{"type":"spot","spot":{"outerConeAngle":0.5}}]}},
        "nodes":[{"camera":0,"translation":[1,2,3],"extensions":{"KHR_lights_punctual":{"light":0}}},
                 {"name":"side","camera":1,"rotation":[0,-0.7071067811865476,0,0.7071067811865476],"extensions":{"KHR_lights_punctual":{"light":1}}},
                 {"name":"spot","scale":[2,2,2],"extensions":{"KHR_lights_punctual":{"light":2}}}]}"#;
    let scene = scene(file);
    let [near, side] = &scene.cameras[..] else {
        panic!("two cameras expected")
    };
    assert_eq!(
        (&*near.name, near.eye, near.forward),
        ("near", [1.0, 2.0, 3.0], [0.0, 0.0, -1.0])
    );
    assert_eq!(near.projection, Projection::Perspective { vfov: 0.5 });
    assert_eq!((&*side.name, side.up), ("side", [0.0, 1.0, 0.0]));
    assert!((side.forward[0] - 1.0).abs() < 1e-6, "{:?}", side.forward);
    assert_eq!(side.projection, Projection::Orthographic { height: 6.0 });

    let [point, sun, spot] = &scene.lights[..] else {
        panic!("three lights expected")
    };
    let expected = LightKind::Point {
        position: [1.0, 2.0, 3.0],
        intensity: [4.0, 2.0, 0.0],
        range: 9.0,
    };
    assert_eq!(point.kind, expected);
    assert_eq!(sun.name, "sun");
    let LightKind::Directional {
        direction,
        irradiance,
    } = sun.kind
    else {
        panic!("{sun:?}")
    };
    assert!((direction[0] - 1.0).abs() < 1e-6);
    assert_eq!(irradiance, [1.0; 3]);
    let LightKind::Spot {
        inner,
        outer,
        range,
        direction,
        ..
    } = spot.kind
    else {
        panic!("{spot:?}")
    };
    assert_eq!(
        (&*spot.name, inner, outer, range),
        ("spot", 0.0, 0.5, f32::INFINITY)
    );
    assert_eq!(direction, [0.0, 0.0, -1.0]);
}
