//! Boxes as lines in space, for Blender and its like: OBJ and GLB, level by level.
//!
//! *How it works.* A box is eight vertices and twelve edges; a cell of slanted planes is the edges of its sides. OBJ has
//! `l` elements, glTF the mode LINES (1); each level is an object or node of its own, so that it can be switched off.

use super::short_name;
use crate::args::Levels;
use crate::failure::{Failure, Outcome};
use boxwood::inspect::Cell;
use boxwood::{Intersect, StructureKind, Vec3};
use boxwood_render::inferno;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// More than these would fill gigabytes that no program opens.
const MOST: u64 = 4_000_000;

/// Lines by level.
pub struct Boxes(BTreeMap<u32, Lines>);

/// Points, and pairs of them.
#[derive(Default)]
struct Lines {
    points: Vec<[f32; 3]>,
    edges: Vec<[u32; 2]>,
}

impl Lines {
    fn add(&mut self, cell: &Cell<'_>) {
        let first = self.points.len() as u32;
        if cell.sides.is_empty() {
            let b = cell.bounds;
            for corner in 0..8_u32 {
                let pick = |axis: usize| {
                    let upper = corner >> axis & 1 == 1;
                    if upper { b.upper[axis] } else { b.lower[axis] }
                };
                self.points.push([pick(0), pick(1), pick(2)]);
                let towards = (0..3).map(|axis| corner | 1 << axis);
                let edges = towards.filter(|&other| other != corner);
                self.edges
                    .extend(edges.map(|other| [first + corner, first + other]));
            }
            return;
        }
        for side in cell.sides {
            let (begin, n) = (self.points.len() as u32, side.len() as u32);
            self.points.extend(side.iter().map(|p: &Vec3| p.to_array()));
            self.edges
                .extend((0..n).map(|k| [begin + k, begin + (k + 1) % n]));
        }
    }
}

impl Boxes {
    /// Those of some levels. Boxes that nothing is in, or that have no end, are left out.
    ///
    /// # Errors
    /// When there are too many.
    pub fn of(structure: &dyn Intersect, levels: Levels) -> Outcome<Self> {
        let mut found = Self(BTreeMap::new());
        let mut count = 0;
        structure.cells(&mut |cell| {
            let b = cell.bounds;
            let finite = b.lower.is_finite() && b.upper.is_finite() && !b.is_empty();
            if finite && levels.contain(cell.depth) {
                count += 1;
                if count <= MOST {
                    found.0.entry(cell.depth).or_default().add(cell);
                }
            }
        });
        if count > MOST {
            return Err(Failure::new(format!(
                "{count} boxes are more than the {MOST} that a file of lines may hold; choose some with --levels"
            )));
        }
        found.0.retain(|_, lines| !lines.edges.is_empty());
        Ok(found)
    }

    pub fn obj(&self, scene: &str, kind: &StructureKind) -> String {
        let mut text = format!("# Boxes of {kind} over {}\n", one_line(&short_name(scene)));
        let mut first = 1;
        for (level, lines) in &self.0 {
            text += &format!("o level_{level}\n");
            for [x, y, z] in &lines.points {
                text += &format!("v {x} {y} {z}\n");
            }
            for [a, b] in &lines.edges {
                text += &format!("l {} {}\n", first + u64::from(*a), first + u64::from(*b));
            }
            first += lines.points.len() as u64;
        }
        text
    }

    /// # Errors
    /// When it would be larger than the four gigabytes of the format.
    pub fn glb(&self) -> Outcome<Vec<u8>> {
        let deepest = self.0.last_key_value().map_or(0, |(&level, _)| level);
        let mut bytes: Vec<u8> = Vec::new();
        let [
            mut views,
            mut accessors,
            mut meshes,
            mut materials,
            mut nodes,
        ]: [Vec<Value>; 5] = Default::default();
        for (number, (level, lines)) in self.0.iter().enumerate() {
            let name = format!("level {level}");
            // ARRAY_BUFFER and ELEMENT_ARRAY_BUFFER.
            let mut view = |data: &mut dyn Iterator<Item = [u8; 4]>, target: u32| {
                let begin = bytes.len();
                data.for_each(|word| bytes.extend(word));
                views.push(json!({
                    "buffer": 0, "byteOffset": begin, "byteLength": bytes.len() - begin, "target": target,
                }));
            };
            view(
                &mut lines.points.iter().flatten().map(|x| x.to_le_bytes()),
                34962,
            );
            view(
                &mut lines.edges.iter().flatten().map(|k| k.to_le_bytes()),
                34963,
            );
            let extent = |pick: fn(f32, f32) -> f32| {
                let fold = |a: [f32; 3], b: &[f32; 3]| [0, 1, 2].map(|k| pick(a[k], b[k]));
                let start = lines.points.first().copied().unwrap_or_default();
                lines.points.iter().fold(start, fold)
            };
            accessors.push(json!({
                "bufferView": 2 * number, "componentType": 5126, "count": lines.points.len(), "type": "VEC3",
                "min": extent(f32::min), "max": extent(f32::max),
            }));
            accessors.push(json!({
                "bufferView": 2 * number + 1, "componentType": 5125, "count": 2 * lines.edges.len(), "type": "SCALAR",
            }));
            let color = inferno(0.15 + 0.75 * *level as f32 / deepest.max(1) as f32);
            materials.push(json!({
                "name": name,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [color.x, color.y, color.z, 1.0], "metallicFactor": 0,
                },
                "extensions": { "KHR_materials_unlit": {} },
            }));
            meshes.push(json!({ "name": name, "primitives": [{
                "attributes": { "POSITION": 2 * number }, "indices": 2 * number + 1,
                "material": number, "mode": 1,
            }]}));
            nodes.push(json!({ "name": name, "mesh": number }));
        }
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "boxwood inspect" },
            "scene": 0,
            "scenes": [{ "name": "boxes" }],
        });
        // The format has no empty lists.
        if !nodes.is_empty() {
            document["scenes"][0]["nodes"] = (0..nodes.len()).collect();
            document["extensionsUsed"] = json!(["KHR_materials_unlit"]);
            document["buffers"] = json!([{ "byteLength": bytes.len() }]);
            for (name, list) in [
                ("nodes", nodes),
                ("meshes", meshes),
                ("materials", materials),
                ("accessors", accessors),
                ("bufferViews", views),
            ] {
                document[name] = list.into();
            }
        }
        container(serde_json::to_vec(&document)?, bytes)
    }
}

/// Puts both chunks into a GLB file; each ends at a multiple of four bytes.
fn container(mut json: Vec<u8>, mut bytes: Vec<u8>) -> Outcome<Vec<u8>> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let chunks: [(&[u8; 4], &[u8]); 2] = [(b"JSON", &json), (b"BIN\0", &bytes)];
    let chunks = chunks.iter().filter(|(_, data)| !data.is_empty());
    let total = 12
        + chunks
            .clone()
            .map(|(_, data)| 8 + data.len())
            .sum::<usize>();
    let total = u32::try_from(total)
        .map_err(|_| Failure::new("the boxes take more than the 4 GiB of a GLB file"))?;
    let mut file = Vec::with_capacity(total as usize);
    file.extend(b"glTF");
    file.extend(2_u32.to_le_bytes());
    file.extend(total.to_le_bytes());
    for (kind, data) in chunks {
        // No part is larger than the whole.
        file.extend((data.len() as u32).to_le_bytes());
        file.extend(*kind);
        file.extend(*data);
    }
    Ok(file)
}

fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use boxwood::Aabb;

    #[test]
    fn cells_are_their_sides_or_their_boxes() {
        let bounds = Aabb::new([0.0; 3], [1.0, 2.0, 3.0]);
        let side = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 3.0]];
        let sides = [side.map(Vec3::from).to_vec(), Vec::new()];
        let cell = |sides| Cell {
            node: 0,
            depth: 0,
            bounds,
            primitives: None,
            sides,
        };
        let mut lines = Lines::default();
        lines.add(&cell(&sides));
        assert_eq!(lines.points, side);
        assert_eq!(lines.edges, [[0, 1], [1, 2], [2, 0]]);
        lines.add(&cell(&[]));
        assert_eq!((lines.points.len(), lines.edges.len()), (3 + 8, 3 + 12));
        // Each edge of a box has the length of one of its sides.
        for [a, b] in &lines.edges[3..] {
            let [a, b] = [a, b].map(|&k| Vec3::from(lines.points[k as usize]));
            assert!([1.0, 2.0, 3.0].contains(&(a - b).length()));
        }
    }
}
