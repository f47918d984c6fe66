//! glTF: files of every kind against their known counts, features against small scenes written here, and bad files
//! against the sentences they must end in.

mod any_bytes;
mod errors;
mod files;
mod geometry;
mod materials;
mod nodes;
mod real_files;

use boxwood_scene::{Format, NoFiles, Scene, SceneError, Source};

fn read(bytes: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    let source = Source {
        name: "test.gltf",
        files: &NoFiles,
    };
    Scene::from_bytes(Format::Gltf, bytes.as_ref(), source)
}

#[track_caller]
fn scene(bytes: impl AsRef<[u8]>) -> Scene {
    let scene = read(bytes).unwrap();
    check_promises(&scene);
    scene
}

#[track_caller]
fn error(bytes: impl AsRef<[u8]>) -> String {
    read(bytes).unwrap_err().to_string()
}

/// What [`Scene`] promises of every loader.
#[track_caller]
fn check_promises(scene: &Scene) {
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
        assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < n));
        let lengths = [
            mesh.normals.len(),
            mesh.tangents.len(),
            mesh.uvs.len(),
            mesh.uvs1.len(),
            mesh.colors.len(),
        ];
        assert!(lengths.iter().all(|&length| length == 0 || length == n));
        for [x, y, z] in &mesh.normals {
            assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5);
        }
        assert!((mesh.material as usize) < scene.materials.len());
    }
    let placed = |mesh| scene.instances.iter().any(|i| i.mesh as usize == mesh);
    assert!((0..scene.meshes.len()).all(placed));
    for material in &scene.materials {
        let maps = [
            material.base_color_map,
            material.metallic_roughness_map,
            material.normal_map,
            material.emissive_map,
            material.transmission_map,
        ];
        let images = scene.images.len();
        assert!(
            maps.iter()
                .flatten()
                .all(|map| (map.image as usize) < images)
        );
    }
}

/// The area of triangles in the plane z = 0, seen from above; what is seen from its back counts against it.
fn area_from_the_front(mesh: &boxwood_scene::Mesh) -> f32 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
    };
    mesh.triangles.iter().map(area).sum()
}
