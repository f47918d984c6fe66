//! What the nodes of the scene hold: meshes, cameras and lights, with their places in the world.
//!
//! *Source.* glTF 2.0, sections 3.5.3 and 3.10, *Cameras*; `KHR_lights_punctual`.

use super::deform::{Deformation, Skin};
use super::file::File;
use super::hierarchy::Hierarchy;
use super::matrix::{Matrix, unit, unit_across};
use super::primitives;
use super::schema;
use crate::{Camera, Instance, Light, LightKind, Projection, Scene, SceneError};
use boxwood::{Aabb, Affine};
use std::collections::BTreeMap;

/// A glTF mesh as one node wants it: by number, and the node that deforms it in its own way (plus one; 0: nobody).
type Shape = (u32, u32);

/// Fills in meshes and instances. Their materials are numbers in the file's table, or `default_material`.
pub fn meshes(
    file: &File<'_>,
    hierarchy: &Hierarchy,
    default_material: u32,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let mut placements = Vec::new();
    // In the order of the file, whatever the order of the nodes is.
    let mut shapes: BTreeMap<Shape, Vec<u32>> = BTreeMap::new();
    for &number in &hierarchy.order {
        let Some(node) = file.root.nodes.get(number as usize) else {
            continue;
        };
        let Some(index) = node.mesh else { continue };
        let path = || format!("nodes[{number}].mesh");
        file.at(&file.root.meshes, index, "mesh", path)?;
        let is_own = node.skin.is_some() || !node.weights.is_empty();
        let shape = (index.0, if is_own { number + 1 } else { 0 });
        shapes.insert(shape, Vec::new());
        placements.push((number, shape));
    }
    for (&shape, made) in &mut shapes {
        *made = read_shape(file, hierarchy, shape, default_material, scene)?;
    }
    let bounds: Vec<Aabb> = scene
        .meshes
        .iter()
        .map(|mesh| Aabb::of(mesh.positions.iter().copied()))
        .collect();
    for (number, shape) in placements {
        let meshes = &shapes[&shape];
        let path = || format!("nodes[{number}]");
        file.spend((meshes.len() * size_of::<Instance>()) as u64, path)?;
        let is_skinned = file
            .root
            .nodes
            .get(number as usize)
            .is_some_and(|n| n.skin.is_some());
        let transform = if is_skinned {
            Affine::IDENTITY
        } else {
            rounded(file, hierarchy, number)?
        };
        for &mesh in meshes {
            let stands = transform.bounds(&bounds[mesh as usize]);
            if ![stands.lower, stands.upper].iter().all(|p| p.is_finite()) {
                let problem = "the node takes its mesh beyond the range of numbers";
                return Err(file.malformed(path(), problem));
            }
            scene.instances.push(Instance { mesh, transform });
        }
    }
    Ok(())
}

/// Makes one mesh of each primitive that has triangles; returns their numbers.
fn read_shape(
    file: &File<'_>,
    hierarchy: &Hierarchy,
    (number, deforming): Shape,
    default_material: u32,
    scene: &mut Scene,
) -> Result<Vec<u32>, SceneError> {
    let said = &file.root.meshes[number as usize];
    let mut deformation = Deformation {
        weights: &said.weights,
        skin: None,
    };
    if let Some(node) = deforming.checked_sub(1)
        && let Some(said) = file.root.nodes.get(node as usize)
    {
        if !said.weights.is_empty() {
            deformation.weights = &said.weights;
        }
        if let Some(skin) = said.skin {
            let path = || format!("nodes[{node}].skin");
            deformation.skin = Some(Skin::read(file, skin, &hierarchy.world, path)?);
            file.warn(
                path(),
                "a skinned mesh is shown at rest, as its joints stand in the file",
            );
        }
    }
    let mut made = Vec::new();
    for (n, primitive) in said.primitives.iter().enumerate() {
        let place = primitives::Place {
            mesh: number as usize,
            number: n,
            primitive,
        };
        let Some(mut mesh) = primitives::read(file, place, &deformation)? else {
            continue;
        };
        mesh.material = match primitive.material {
            None => default_material,
            Some(index) => {
                let path = || place.path(".material");
                file.at(&file.root.materials, index, "material", path)?;
                index.0
            }
        };
        let name_bytes = said.name.len() + size_of::<crate::Mesh>();
        file.spend(name_bytes as u64, || place.path(""))?;
        mesh.name = match said.primitives.len() {
            1 => said.name.to_string(),
            _ => format!("{}.{n}", said.name),
        };
        made.push(scene.meshes.len() as u32);
        scene.meshes.push(mesh);
    }
    Ok(made)
}

fn rounded(file: &File<'_>, hierarchy: &Hierarchy, node: u32) -> Result<Affine, SceneError> {
    let transform = hierarchy.world[node as usize].rounded();
    transform.ok_or_else(|| {
        let problem = "the node's transform leaves the range of numbers";
        file.malformed(format!("nodes[{node}]"), problem)
    })
}

/// Fills in cameras and lights, in the order of the nodes.
pub fn cameras_and_lights(
    file: &File<'_>,
    hierarchy: &Hierarchy,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let root = &file.root;
    let lights: &[schema::Light] = root.extensions.lights.as_ref().map_or(&[], |l| &l.lights);
    for &number in &hierarchy.order {
        let Some(node) = root.nodes.get(number as usize) else {
            continue;
        };
        let world = &hierarchy.world[number as usize];
        if let Some(index) = node.camera {
            let path = || format!("nodes[{number}].camera");
            let camera = file.at(&root.cameras, index, "camera", path)?;
            let name = own_name(file, &camera.name, &node.name, path)?;
            rounded(file, hierarchy, number)?;
            match place_camera(camera, world) {
                Ok((eye, forward, up, projection)) => scene.cameras.push(Camera {
                    name,
                    eye,
                    forward,
                    up,
                    projection,
                }),
                Err(flaw) => file.warn(format!("cameras[{}]", index.0), flaw),
            }
        }
        if let Some(light) = node.extensions.as_ref().and_then(|e| e.light.as_ref()) {
            let path = || format!("nodes[{number}].extensions.KHR_lights_punctual.light");
            let said = file.at(lights, light.light, "light", path)?;
            let name = own_name(file, &said.name, &node.name, path)?;
            rounded(file, hierarchy, number)?;
            match place_light(said, world) {
                Some(kind) => scene.lights.push(Light { name, kind }),
                None => file.warn(path(), "a light without direction is left out"),
            }
        }
    }
    Ok(())
}

/// The name of a thing, else the name of the node that holds it.
fn own_name(
    file: &File<'_>,
    name: &str,
    node: &str,
    path: impl Fn() -> String,
) -> Result<String, SceneError> {
    let name = if name.is_empty() { node } else { name };
    file.spend(name.len() as u64 + size_of::<Light>() as u64, path)?;
    Ok(name.to_owned())
}

fn single(v: [f64; 3]) -> [f32; 3] {
    v.map(|x| x as f32)
}

type Stand = ([f32; 3], [f32; 3], [f32; 3], Projection);

/// Cameras look along −z, with y up in the image.
fn place_camera(camera: &schema::Camera, world: &Matrix) -> Result<Stand, &'static str> {
    let projection = match (camera.kind, &camera.perspective, &camera.orthographic) {
        (schema::CameraKind::Perspective, Some(said), _) => {
            if !(said.yfov > 0.0 && said.yfov < std::f64::consts::PI) {
                return Err("a camera whose yfov is not between 0 and π is left out");
            }
            let vfov = said.yfov as f32;
            Projection::Perspective { vfov }
        }
        (schema::CameraKind::Orthographic, _, Some(said)) => {
            let height = (2.0 * said.ymag.abs()) as f32;
            if !(height > 0.0 && height.is_finite()) {
                return Err("a camera whose ymag is 0 is left out");
            }
            Projection::Orthographic { height }
        }
        _ => return Err("a camera without its projection is left out"),
    };
    let forward = unit(world.column(2).map(|x| -x));
    let up = forward.and_then(|forward| unit_across(world.column(1), forward));
    match (forward, up) {
        (Some(forward), Some(up)) => Ok((
            single(world.column(3)),
            single(forward),
            single(up),
            projection,
        )),
        _ => Err("a camera without direction is left out"),
    }
}

/// Lights shine along −z. Candela and lux are taken as radiometric numbers, as they stand in the file: only their
/// proportions matter to a picture that is exposed by eye.
fn place_light(light: &schema::Light, world: &Matrix) -> Option<LightKind> {
    let power = light.intensity.unwrap_or(1.0);
    let color = light.color.unwrap_or([1.0; 3]);
    let intensity = color.map(|c| (c * power).clamp(0.0, f64::from(f32::MAX)) as f32);
    let position = single(world.column(3));
    let range = match light.range {
        Some(range) if range > 0.0 => range as f32,
        _ => f32::INFINITY,
    };
    let direction = || unit(world.column(2).map(|x| -x)).map(single);
    Some(match light.kind {
        schema::LightKind::Point => LightKind::Point {
            position,
            intensity,
            range,
        },
        schema::LightKind::Directional => LightKind::Directional {
            direction: direction()?,
            irradiance: intensity,
        },
        schema::LightKind::Spot => {
            let spot = light.spot.as_ref();
            let outer = spot.and_then(|s| s.outer_cone_angle);
            let outer = outer.unwrap_or(std::f64::consts::FRAC_PI_4);
            let outer = outer.clamp(0.0, std::f64::consts::FRAC_PI_2);
            let inner = spot.and_then(|s| s.inner_cone_angle).unwrap_or(0.0);
            LightKind::Spot {
                position,
                direction: direction()?,
                intensity,
                inner: inner.clamp(0.0, outer) as f32,
                outer: outer as f32,
                range,
            }
        }
    })
}
