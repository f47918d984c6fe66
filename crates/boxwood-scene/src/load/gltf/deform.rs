//! Morph targets and skins: where a mesh's vertices are when nothing moves.
//!
//! *How it works.* The file's default weights blend the morph targets. A skin then moves each vertex by the weighted
//! mean of its joints' matrices, as the node hierarchy places them; the result is in world space, because the skinned
//! node's own transform does not count. A mesh that several nodes deform differently becomes several meshes.
//!
//! *Source.* glTF 2.0, sections 3.7.2.2, *Morph Targets*, and 3.7.3, *Skins*.

use super::accessors::{Accessor, Component};
use super::file::File;
use super::matrix::{Matrix, unit};
use super::primitives::Attributes;
use super::schema::{ElementKind, Index};
use crate::{Mesh, SceneError};

/// How a mesh is deformed.
#[derive(Default)]
pub struct Deformation<'f> {
    /// The weights of the morph targets; absent ones are zero.
    pub weights: &'f [f64],
    /// The joint matrices of a skin and the skin's number.
    pub skin: Option<Skin>,
}

/// A skin with its matrices.
pub struct Skin {
    number: u32,
    joints: Vec<Matrix>,
}

impl Skin {
    /// Reads a skin. `world` has the place of every node.
    pub fn read(
        file: &File<'_>,
        index: Index,
        world: &[Matrix],
        path: impl FnOnce() -> String,
    ) -> Result<Self, SceneError> {
        let number = index.0;
        let skin = file.at(&file.root.skins, index, "skin", path)?;
        let place = |key: &str| format!("skins[{number}].{key}");
        let bytes = (skin.joints.len() * size_of::<Matrix>()) as u64;
        file.spend(bytes, || place("joints"))?;
        let bind = match skin.inverse_bind_matrices {
            None => None,
            Some(index) => {
                let key = || place("inverseBindMatrices");
                let bind = file.accessor(index, &[ElementKind::Mat4], key)?;
                if bind.component != Component::F32 {
                    let problem = format!("accessors[{}] is not made of floats", index.0);
                    return Err(file.malformed(key(), problem));
                }
                if bind.count < skin.joints.len() {
                    let problem = format!(
                        "has {} matrices, but there are {} joints",
                        bind.count,
                        skin.joints.len()
                    );
                    return Err(file.malformed(key(), problem));
                }
                Some(bind)
            }
        };
        let mut joints = Vec::with_capacity(skin.joints.len());
        for (n, &joint) in skin.joints.iter().enumerate() {
            let joint = file.at(world, joint, "node", || place(&format!("joints[{n}]")))?;
            joints.push(match &bind {
                None => *joint,
                Some(bind) => joint.after(&Matrix::from_columns(&bind.numbers(n))),
            });
        }
        if joints.is_empty() {
            return Err(file.malformed(place("joints"), "there are none"));
        }
        Ok(Self { number, joints })
    }
}

impl Deformation<'_> {
    /// Moves the vertices of `mesh`, which holds what `attributes` speak of. May leave numbers that are not finite.
    pub fn apply(
        &self,
        attributes: &Attributes<'_, '_>,
        mesh: &mut Mesh,
    ) -> Result<(), SceneError> {
        self.morph(attributes, mesh)?;
        match &self.skin {
            Some(skin) => skin.apply(attributes, mesh),
            None => Ok(()),
        }
    }

    fn morph(&self, attributes: &Attributes<'_, '_>, mesh: &mut Mesh) -> Result<(), SceneError> {
        let targets = &attributes.place.primitive.targets;
        for (n, (target, &weight)) in targets.iter().zip(self.weights).enumerate() {
            if weight == 0.0 {
                continue;
            }
            let key = |name: &str| format!(".targets[{n}].{name}");
            let kinds = [ElementKind::Vec3];
            // Nothing is kept, but it takes time, and targets may share their data.
            let bytes = size_of_val(attributes.vertices) as u64;
            let path = || attributes.place.path(".targets");
            attributes.file.spend(bytes, path)?;
            let add = |to: &mut [[f32; 3]], moves: &Accessor<'_>| {
                for (p, &vertex) in to.iter_mut().zip(attributes.vertices) {
                    let by = moves.numbers::<3>(vertex as usize);
                    *p = std::array::from_fn(|k| (f64::from(p[k]) + weight * by[k]) as f32);
                }
            };
            if let Some(moves) = attributes.accessor(target.position, &kinds, &key("POSITION"))? {
                add(&mut mesh.positions, &moves);
            }
            if let Some(turns) = attributes.accessor(target.normal, &kinds, &key("NORMAL"))? {
                add(&mut mesh.normals, &turns);
                for normal in &mut mesh.normals {
                    let direction = unit(normal.map(f64::from));
                    *normal = direction.map_or([f32::NAN; 3], |n| n.map(|x| x as f32));
                }
            }
        }
        Ok(())
    }
}

impl Skin {
    fn apply(&self, attributes: &Attributes<'_, '_>, mesh: &mut Mesh) -> Result<(), SceneError> {
        let said = &attributes.place.primitive.attributes;
        let sets = [
            (said.joints_0, said.weights_0, ["JOINTS_0", "WEIGHTS_0"]),
            (said.joints_1, said.weights_1, ["JOINTS_1", "WEIGHTS_1"]),
        ];
        let mut influences = Vec::new();
        for (joints, weights, names) in sets {
            let [joints_key, weights_key] = names.map(|name| format!(".attributes.{name}"));
            let kinds = [ElementKind::Vec4];
            let joints = attributes.accessor(joints, &kinds, &joints_key)?;
            let weights = attributes.accessor(weights, &kinds, &weights_key)?;
            if let (Some(mut joints), Some(mut weights)) = (joints, weights) {
                joints.normalized = false;
                weights.normalized = weights.component != Component::F32;
                influences.push((joints, weights, joints_key));
            }
        }
        for (n, &vertex) in attributes.vertices.iter().enumerate() {
            let mut blended = [[0.0; 4]; 3];
            let mut sum = 0.0;
            for (joints, weights, key) in &influences {
                let weights = weights.numbers::<4>(vertex as usize);
                for (joint, weight) in joints
                    .indices::<4>(vertex as usize)
                    .into_iter()
                    .zip(weights)
                {
                    // Negative weights, and those that are no numbers, count as nothing.
                    if weight > 0.0 && weight.is_finite() {
                        let matrix = self.joint(joint, attributes, key)?;
                        sum += weight;
                        for (to, from) in
                            blended.iter_mut().flatten().zip(matrix.0.iter().flatten())
                        {
                            *to += weight * from;
                        }
                    }
                }
            }
            // Without any weight a vertex goes with the first joint.
            let matrix = if sum > 0.0 {
                Matrix(blended.map(|row| row.map(|x| x / sum)))
            } else {
                self.joints[0]
            };
            let rounded = |v: [f64; 3]| v.map(|x| x as f32);
            let turned = |v: Option<[f64; 3]>| v.map_or([f32::NAN; 3], rounded);
            mesh.positions[n] = rounded(matrix.point(mesh.positions[n].map(f64::from)));
            if let Some(normal) = mesh.normals.get_mut(n) {
                *normal = turned(unit(matrix.normal(normal.map(f64::from))));
            }
            if let Some([x, y, z, _]) = mesh.tangents.get_mut(n) {
                [*x, *y, *z] = turned(unit(matrix.vector([*x, *y, *z].map(f64::from))));
            }
        }
        if mesh.tangents.iter().any(|t| t[0].is_nan()) {
            mesh.tangents = Vec::new();
        }
        Ok(())
    }

    fn joint(
        &self,
        joint: u32,
        attributes: &Attributes<'_, '_>,
        key: &str,
    ) -> Result<&Matrix, SceneError> {
        self.joints.get(joint as usize).ok_or_else(|| {
            let problem = format!(
                "names joint {joint}, but skins[{}] has {} (counted from 0)",
                self.number,
                self.joints.len()
            );
            attributes
                .file
                .malformed(attributes.place.path(key), problem)
        })
    }
}
