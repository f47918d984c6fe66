//! The nodes: who stands on whom, where each is in the world, and in which order a scene shows them.
//!
//! *How it works.* Every node may have one parent. When that holds, whatever cannot be reached from a node without
//! parent hangs on a ring, and is refused. Nothing here recurses: a chain of a million nodes is a legal file.
//!
//! *Source.* glTF 2.0, section 3.5, *Scenes*.

use super::file::File;
use super::matrix::Matrix;
use super::schema::Index;
use crate::SceneError;

/// The checked hierarchy.
pub struct Hierarchy {
    /// From each node's space to the world.
    pub world: Vec<Matrix>,
    /// The nodes of the scene, each parent before its children, children in order.
    pub order: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Hierarchy {
    /// Checks all nodes and lists those of the scene to be shown: the default one, else the first, else all nodes.
    pub fn read(file: &File<'_>) -> Result<Self, SceneError> {
        let nodes = &file.root.nodes;
        // A matrix and the numbers in the lists below.
        let bytes = (nodes.len() * (size_of::<Matrix>() + 32)) as u64;
        file.spend(bytes, || "nodes".to_owned())?;
        let parents = parents(file)?;
        let roots: Vec<u32> = (0..nodes.len() as u32)
            .filter(|&node| parents[node as usize] == NONE)
            .collect();

        let mut world = vec![Matrix::IDENTITY; nodes.len()];
        let (everything, is_reached) = match place(file, &roots, &mut world) {
            Ok(reached) => reached,
            Err(node) => return Err(ring(file, &parents, node)),
        };
        if let Some(node) = is_reached.iter().position(|reached| !reached) {
            return Err(ring(file, &parents, node as u32));
        }
        let Some((path, roots)) = scene_roots(file)? else {
            return Ok(Self {
                world,
                order: everything,
            });
        };
        for (n, &root) in roots.iter().enumerate() {
            file.at(nodes, root, "node", || format!("{path}[{n}]"))?;
        }
        // Some writers list a node here that is another's child. It stands as if it were a root.
        let roots: Vec<u32> = roots.iter().map(|root| root.0).collect();
        match place(file, &roots, &mut world) {
            Ok((order, _)) => Ok(Self { world, order }),
            Err(node) => {
                let problem = format!("node {node} stands in the scene twice");
                Err(file.malformed(path, problem))
            }
        }
    }
}

/// Each node's parent.
fn parents(file: &File<'_>) -> Result<Vec<u32>, SceneError> {
    let nodes = &file.root.nodes;
    let mut parents = vec![NONE; nodes.len()];
    for (number, node) in nodes.iter().enumerate() {
        for (n, &child) in node.children.iter().enumerate() {
            let path = || format!("nodes[{number}].children[{n}]");
            file.at(nodes, child, "node", path)?;
            let parent = &mut parents[child.0 as usize];
            if *parent != NONE {
                let problem = format!(
                    "node {} already has a parent, nodes[{parent}]; only one is allowed",
                    child.0
                );
                return Err(file.malformed(path(), problem));
            }
            *parent = number as u32;
        }
    }
    Ok(parents)
}

/// Lists the nodes from `roots` down and says where they stand. Returns the list and which nodes are in it, or a node
/// that is met for the second time.
fn place(
    file: &File<'_>,
    roots: &[u32],
    world: &mut [Matrix],
) -> Result<(Vec<u32>, Vec<bool>), u32> {
    let mut order = Vec::new();
    let mut is_reached = vec![false; world.len()];
    let mut stack: Vec<(u32, u32)> = roots.iter().rev().map(|&root| (root, NONE)).collect();
    while let Some((number, parent)) = stack.pop() {
        if std::mem::replace(&mut is_reached[number as usize], true) {
            return Err(number);
        }
        order.push(number);
        let Some(node) = file.root.nodes.get(number as usize) else {
            continue;
        };
        let local = Matrix::of_node(node);
        world[number as usize] = match parent {
            NONE => local,
            parent => world[parent as usize].after(&local),
        };
        stack.extend(node.children.iter().rev().map(|child| (child.0, number)));
    }
    Ok((order, is_reached))
}

/// Names a link of the ring that `node` hangs on.
fn ring(file: &File<'_>, parents: &[u32], node: u32) -> SceneError {
    let mut node = node;
    // After as many steps as there are nodes, one is on the ring itself. No node on the way lacks a parent.
    for _ in 0..parents.len() {
        node = parents[node as usize];
    }
    // The lowest number on the ring, so that the message does not depend on where the search began.
    let mut lowest = node;
    let mut next = parents[node as usize];
    while next != node {
        lowest = lowest.min(next);
        next = parents[next as usize];
    }
    let parent = parents[lowest as usize];
    let children = file
        .root
        .nodes
        .get(parent as usize)
        .map(|node| &node.children);
    let n = children.and_then(|c| c.iter().position(|child| child.0 == lowest));
    let path = format!("nodes[{parent}].children[{}]", n.unwrap_or(0));
    file.malformed(path, format!("node {lowest} is its own descendant"))
}

/// The root nodes of the scene to be shown, and their path.
fn scene_roots<'f>(file: &'f File<'_>) -> Result<Option<(String, &'f [Index])>, SceneError> {
    let root = &file.root;
    let (number, scene) = match root.scene {
        Some(index) => {
            let scene = file.at(&root.scenes, index, "scene", || "scene".to_owned())?;
            (index.0, scene)
        }
        None => match root.scenes.get(0) {
            Some(scene) => (0, scene),
            None => return Ok(None),
        },
    };
    Ok(Some((format!("scenes[{number}].nodes"), &scene.nodes)))
}
