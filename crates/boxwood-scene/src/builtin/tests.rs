mod stress;

use super::*;
use crate::scene::Mesh;
use boxwood::Aabb;
use std::collections::HashMap;

type Bits = [u32; 3];

fn bits(p: [f32; 3]) -> Bits {
    p.map(f32::to_bits)
}

fn corners(mesh: &Mesh, triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|k| mesh.positions[k as usize].into())
}

/// Twice the area times the normal.
fn area_normal(mesh: &Mesh, triangle: [u32; 3]) -> Vec3 {
    let [a, b, c] = corners(mesh, triangle);
    (b - a).cross(c - a)
}

/// How often each directed edge occurs, vertices told apart by position.
fn edges(mesh: &Mesh) -> HashMap<(Bits, Bits), u32> {
    let mut edges = HashMap::new();
    for t in &mesh.triangles {
        let p = t.map(|k| bits(mesh.positions[k as usize]));
        for k in 0..3 {
            *edges.entry((p[k], p[(k + 1) % 3])).or_insert(0) += 1;
        }
    }
    edges
}

/// Edges that no other triangle runs along the other way.
fn open_edges(mesh: &Mesh) -> Vec<[Bits; 2]> {
    let edges = edges(mesh);
    assert!(
        edges.values().all(|&n| n == 1),
        "{}: an edge occurs twice in the same direction",
        mesh.name
    );
    edges
        .keys()
        .filter(|(a, b)| !edges.contains_key(&(*b, *a)))
        .map(|&(a, b)| [a, b])
        .collect()
}

/// Positive when the triangles of a closed mesh face outwards.
fn volume(mesh: &Mesh) -> f64 {
    mesh.triangles
        .iter()
        .map(|&t| {
            let [a, b, c] = corners(mesh, t);
            f64::from(a.dot(b.cross(c))) / 6.0
        })
        .sum()
}

fn bounds(mesh: &Mesh) -> Aabb {
    Aabb::of(mesh.positions.iter().copied())
}

/// FNV-1a over the bits of everything that a structure or a renderer reads.
fn fingerprint(scene: &Scene) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut eat = |word: u32| {
        for byte in word.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    };
    for mesh in &scene.meshes {
        mesh.positions
            .iter()
            .chain(&mesh.normals)
            .flatten()
            .for_each(|x| eat(x.to_bits()));
        mesh.uvs.iter().flatten().for_each(|x| eat(x.to_bits()));
        mesh.triangles.iter().flatten().for_each(|&k| eat(k));
        eat(mesh.material);
    }
    for instance in &scene.instances {
        eat(instance.mesh);
        instance
            .transform
            .rows
            .iter()
            .flatten()
            .for_each(|x| eat(x.to_bits()));
    }
    for camera in &scene.cameras {
        [camera.eye, camera.forward, camera.up]
            .iter()
            .flatten()
            .for_each(|x| eat(x.to_bits()));
    }
    hash
}

#[test]
fn the_same_bits_everywhere() {
    let scene = teapot_in_stadium();
    assert_eq!(scene.triangle_count(), 392_712);
    assert_eq!(scene.unique_triangle_count(), 72_264);
    let found = fingerprint(&scene);
    assert_eq!(found, 0xb81f_995f_e6b3_a369, "{found:#x}");
}

#[test]
fn tables_fit_together() {
    let scene = teapot_in_stadium();
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        assert!((mesh.material as usize) < scene.materials.len());
        assert!(mesh.triangles.iter().flatten().all(|&k| (k as usize) < n));
        assert!([0, n].contains(&mesh.normals.len()) && [0, n].contains(&mesh.uvs.len()));
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
    }
    assert!(
        scene
            .instances
            .iter()
            .all(|i| (i.mesh as usize) < scene.meshes.len())
    );
    for (k, mesh) in scene.meshes.iter().enumerate() {
        assert!(
            scene.instances.iter().any(|i| i.mesh as usize == k),
            "{} stands nowhere",
            mesh.name
        );
    }
    for instance in &scene.instances {
        assert!(instance.transform.determinant() > 0.0);
    }
    let names: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["main", "overview"]);
    for camera in &scene.cameras {
        let (forward, up) = (Vec3::from(camera.forward), Vec3::from(camera.up));
        assert!((forward.length() - 1.0).abs() < 1.0e-6 && (up.length() - 1.0).abs() < 1.0e-6);
        assert!(forward.dot(up).abs() < 1.0e-6 && up.y > 0.9);
        // Level: the right-hand side of the picture lies in the horizon.
        assert!(forward.cross(up).y.abs() < 1.0e-6);
    }
}

#[test]
fn triangles_have_area_and_face_along_their_normals() {
    let scene = teapot_in_stadium();
    for mesh in &scene.meshes {
        for &t in &mesh.triangles {
            let face = area_normal(mesh, t);
            assert!(face.length() > 0.0, "{}: {t:?}", mesh.name);
            for k in t.into_iter().filter(|_| !mesh.normals.is_empty()) {
                let normal = Vec3::from(mesh.normals[k as usize]);
                assert!((normal.length() - 1.0).abs() < 1.0e-5);
                assert!(normal.dot(face) > 0.0, "{}: {t:?}", mesh.name);
            }
        }
    }
}

#[test]
fn solids_are_closed_and_the_ground_faces_up() {
    for mesh in &teapot_in_stadium().meshes {
        let name = mesh.name.as_str();
        if name == "teapot" {
            continue;
        }
        if bounds(mesh).upper.y - bounds(mesh).lower.y == 0.0 {
            assert!(
                mesh.triangles.iter().all(|&t| area_normal(mesh, t).y > 0.0),
                "{name}"
            );
        } else {
            assert!(open_edges(mesh).is_empty(), "{name}");
            assert!(volume(mesh) > 0.0, "{name}");
        }
    }
}

#[test]
fn balls_come_close_to_the_sphere() {
    for (level, triangles) in [(0, 20), (1, 80), (4, 5120)] {
        let ball = solids::ball(level);
        assert_eq!(ball.triangles.len(), triangles);
        assert!(open_edges(&ball).is_empty());
    }
    let sphere = 4.0 / 3.0 * std::f64::consts::PI;
    assert!((volume(&solids::ball(4)) / sphere - 1.0).abs() < 4.0e-3);
}

#[test]
fn a_teapot_of_each_fineness() {
    for n in [2, 3, 5, 16] {
        let pot = teapot(n);
        assert_eq!(pot.triangles.len() as u32, 64 * n * n - 8 * n);
        for &t in &pot.triangles {
            assert!(area_normal(&pot, t).length() > 0.0);
        }
        assert!(pot.uvs.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
    }
    assert_eq!(teapot(0).triangles, teapot(2).triangles);
}

#[test]
fn the_teapot_has_its_size_and_its_parts() {
    let pot = teapot(16);
    let around = bounds(&pot);
    assert!(
        (around.lower - Vec3::new(-3.0, 0.0, -2.0))
            .abs()
            .max_element()
            < 1.0e-3
    );
    assert!(
        (around.upper - Vec3::new(3.434, 3.15, 2.0))
            .abs()
            .max_element()
            < 1.0e-3
    );
    // Only the spout reaches beyond x = 2, only the handle beyond −2, only the lid above the rim.
    let beyond = |f: &dyn Fn(Vec3) -> bool| {
        let points = pot
            .positions
            .iter()
            .map(|&p| Vec3::from(p))
            .filter(|&p| f(p));
        Aabb::of(points)
    };
    let (spout, handle) = (beyond(&|p| p.x > 2.01), beyond(&|p| p.x < -2.01));
    assert!(spout.upper.y > 2.4 && spout.upper.z < 0.66);
    assert!(handle.lower.y < 1.0 && handle.upper.y > 2.0 && handle.upper.z < 0.31);
    assert!(beyond(&|p| p.y > 2.6).upper.x < 1.31);
}

#[test]
fn the_teapot_is_open_only_where_newell_left_it_open() {
    let n = 8;
    let pot = teapot(n);
    let open = open_edges(&pot);
    // Rim and lid end in rings of four patches each, both ends of handle and spout in rings of two.
    assert_eq!(open.len() as u32, (4 + 4 + 2 * (2 + 2)) * n);
    // Walls look outwards: at the belly, on the lid's pole, on the bottom's pole, at the tips of handle and spout.
    let at = |p: [f32; 3]| {
        let far = |q: &[f32; 3]| (Vec3::from(*q) - Vec3::from(p)).length();
        let near = (0..pot.positions.len())
            .min_by(|&a, &b| far(&pot.positions[a]).total_cmp(&far(&pot.positions[b])));
        Vec3::from(pot.normals[near.expect("the teapot has vertices")])
    };
    assert_eq!(at([0.0, 3.15, 0.0]), Vec3::new(0.0, 1.0, 0.0));
    assert_eq!(at([0.0, 0.0, 0.0]), Vec3::new(0.0, -1.0, 0.0));
    assert!(at([0.0, 0.9, 2.0]).z > 0.9);
    assert!(at([-3.0, 1.8, 0.0]).x < -0.9);
    assert!(at([2.6, 1.6, 0.66]).z > 0.5);
}
