//! The scenes that come in any size.

use super::*;
use boxwood::{BinnedSah, Bvh, Intersect, Ray};

/// A scene with how many triangles it has and the box that holds it.
const SCENES: [(&str, u64, [[f32; 3]; 2]); 9] = [
    ("even-spheres:100", 32_000, [[-1.0; 3], [1.0; 3]]),
    ("even-spheres:1", 320, [[-1.0; 3], [1.0; 3]]),
    ("long-thin:500", 500, [[-1.0; 3], [1.0; 3]]),
    ("overlapping:60", 30 * 13, [[-1.3; 3], [1.3; 3]]),
    ("soup:1k", 1000, [[-1.0; 3], [1.0; 3]]),
    ("soup:1", 1, [[-1.0; 3], [1.0; 3]]),
    (
        "terrain:20k",
        20_002,
        [[-2000.0, 0.0, -2000.0], [2000.0, 2600.0, 2000.0]],
    ),
    (
        "city:300",
        0,
        [[-9000.0, -0.1, -9000.0], [9000.0, 400.0, 9000.0]],
    ),
    ("plants:400", 0, [[-25.0, -4.0, -25.0], [25.0, 15.0, 25.0]]),
];

fn made(name: &str) -> Scene {
    by_name(name).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn they_have_their_size_and_their_place() {
    for (name, triangles, [lower, upper]) in SCENES {
        let scene = made(name);
        let found = scene.triangle_count();
        assert!(triangles == 0 || found == triangles, "{name}: {found}");
        assert!(found > 0 && scene.warnings.is_empty(), "{name}");
        let around = Aabb::new(lower, upper);
        let bounds = scene.bounds();
        assert!(around.contains(&bounds), "{name}: {bounds:?}");
        // Not in a corner of it.
        assert!(
            bounds.size().max_element() > 0.04 * around.size().max_element(),
            "{name}"
        );
    }
}

#[test]
fn size_follows_the_number() {
    for name in names().filter(|name| *name != "teapot-in-stadium") {
        // One level more of a sponge is twenty times as much.
        let sizes = if name == "sponge" { [2, 3] } else { [40, 800] };
        let [few, many] = sizes.map(|size| made(&format!("{name}:{size}")).triangle_count());
        assert!(many > few && many < 40 * few, "{name}: {few}, {many}");
    }
}

#[test]
fn each_seed_is_one_scene_and_no_two_are_alike() {
    for (name, ..) in SCENES {
        let print = |seed: u64| fingerprint(&made(&format!("{name},seed={seed}")));
        assert_eq!(print(0), fingerprint(&made(name)), "{name}");
        assert_eq!(print(3), print(3), "{name}");
        assert_ne!(print(3), print(4), "{name}");
    }
}

/// Any machine and any number of threads makes the same.
#[test]
fn the_same_bits_as_ever() {
    let found = [
        "even-spheres:10",
        "long-thin:10",
        "overlapping:10",
        "plants:50",
        "city:20",
        "terrain:800",
        "soup:10",
    ]
    .map(|name| (name, fingerprint(&made(name))));
    let expected = PRINTS;
    assert_eq!(found, expected, "{found:#x?}");
}

const PRINTS: [(&str, u64); 7] = [
    ("even-spheres:10", 0x426506360da0410e),
    ("long-thin:10", 0xc4497b89abaa65b4),
    ("overlapping:10", 0x4bc91cbe0ef65b0c),
    ("plants:50", 0x173a54ad9ea6cf89),
    ("city:20", 0x8e4b659236c92492),
    ("terrain:800", 0x5ca705a11d8efdc7),
    ("soup:10", 0x285aa78b543f2ff9),
];

#[test]
fn tables_are_whole_and_triangles_have_area() {
    for (name, ..) in SCENES {
        let scene = made(name);
        let mut flat = 0;
        for mesh in &scene.meshes {
            let n = mesh.positions.len();
            assert!((mesh.material as usize) < scene.materials.len(), "{name}");
            assert!(mesh.triangles.iter().flatten().all(|&k| (k as usize) < n));
            for list in [mesh.normals.len(), mesh.uvs.len(), mesh.colors.len()] {
                assert!(list == 0 || list == n, "{name}: {}", mesh.name);
            }
            assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
            flat += mesh
                .triangles
                .iter()
                .filter(|&&t| area_normal(mesh, t).length() == 0.0)
                .count();
        }
        assert_eq!(flat, 0, "{name}");
        let images = scene.images.len() as u32;
        let maps = scene.materials.iter().filter_map(|m| m.base_color_map);
        assert!(maps.into_iter().all(|map| map.image < images), "{name}");
        assert_eq!(scene.cameras[0].name, "main");
        assert!(!scene.lights.is_empty(), "{name}");
        for k in 0..scene.meshes.len() {
            let placed = scene.instances.iter().any(|i| i.mesh as usize == k);
            assert!(placed, "{name}: {} stands nowhere", scene.meshes[k].name);
        }
    }
}

/// Walls, roofs and land face outwards and up.
#[test]
fn fronts_are_in_front() {
    let land = &made("terrain:50k").meshes[0];
    let mut steep = 0;
    for &t in &land.triangles {
        let face = area_normal(land, t).normalized();
        assert!(face.y > 0.0);
        let along = |k: u32| Vec3::from(land.normals[k as usize]).dot(face) > 0.0;
        steep += usize::from(!t.into_iter().all(along));
    }
    // On the sharpest ridges a vertex looks to the other side.
    assert!(200 * steep < land.triangles.len(), "{steep}");
    let city = made("city:200");
    for name in ["roof tiles", "flat roofs", "streets", "country", "pavement"] {
        let mesh = city.meshes.iter().find(|m| m.name == name).expect(name);
        let down = mesh
            .triangles
            .iter()
            .filter(|&&t| area_normal(mesh, t).y < 0.0);
        assert_eq!(down.count(), 0, "{name}");
    }
    // Who stands in the country sees the fronts of walls. Higher up, one may look under the eaves and behind parapets.
    let flat = city.flatten().expect("there is room").mesh;
    let bvh = Bvh::new(&flat, BinnedSah::default().build(&flat));
    let mut walls = 0;
    for i in 0..400 {
        let (sin, cos) = libm::sincosf(i as f32);
        let to = [
            ((i * 7) % 101 - 50) as f32,
            1.5,
            ((i * 11) % 101 - 50) as f32,
        ];
        let ray = Ray::between([900.0 * sin, 1.5, 900.0 * cos], to);
        let Some(hit) = bvh.closest_hit(&ray) else {
            continue;
        };
        let [a, b, c] = flat.triangle(hit.primitive as usize);
        let face = (b - a).cross(c - a);
        assert!(face.dot(ray.direction) < 0.0, "{ray:?}");
        walls += 1;
    }
    assert!(walls > 300, "{walls}");
}

/// How different the heights are: a few towers stand over many houses.
#[test]
fn a_city_has_towers() {
    let city = made("city:2000");
    let mut tops = Vec::new();
    for mesh in city.meshes.iter().filter(|m| !m.uvs.is_empty()) {
        tops.extend(mesh.positions.iter().map(|p| p[1]).filter(|&y| y > 0.0));
    }
    tops.sort_by(f32::total_cmp);
    let (middle, most) = (tops[tops.len() / 2], tops[tops.len() - 1]);
    assert!(middle < 25.0 && most > 90.0, "{middle} and {most}");
}

/// The most that a scene may be asked for. Some gigabytes and seconds: `cargo test --release -- --ignored`.
#[test]
#[ignore = "takes about a gigabyte"]
fn ten_million_triangles() {
    let scene = made("terrain:10M");
    let count = scene.triangle_count();
    assert!(count.abs_diff(10_000_000) < 10_000, "{count}");
    let flat = scene.flatten().expect("there is room");
    assert_eq!(flat.mesh.triangles().len() as u64, count);
}

#[test]
fn a_sponge_has_twenty_times_as_many_cubes_on_each_level() {
    for level in 1..=9 {
        let scene = made(&format!("sponge:{level}"));
        let cubes = 20_u64.pow(level);
        assert_eq!(scene.triangle_count(), 12 * (cubes + 1));
        assert!(scene.unique_triangle_count() <= 12 * 401);
        let bounds = scene.bounds();
        assert!((bounds.upper.y - 1.0).abs() < 1.0e-5, "{bounds:?}");
    }
    let flat = made("sponge:3").flatten().expect("there is room").mesh;
    let nested = made("sponge:2").flatten().expect("there is room").mesh;
    assert_eq!(
        flat.triangles().len() - 12,
        20 * (nested.triangles().len() - 12)
    );
    let colour = |text: &str| made(text).materials[0].base_color;
    assert_ne!(colour("sponge:1,seed=1"), colour("sponge:1,seed=2"));
}
