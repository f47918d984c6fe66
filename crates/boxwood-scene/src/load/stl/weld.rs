//! Welding: vertices at the same position become one.

use crate::SceneError;
use crate::error::Place;
use crate::load::file::File;
use foldhash::fast::RandomState;
use std::collections::HashMap;

/// Vertices met so far, each position once, in the order of their first use.
///
/// Positions are the same if their bits are; only −0 equals 0. The hash has a random seed, so that no file can be made
/// to collide; the result does not depend on it.
#[derive(Debug, Default)]
pub struct Weld {
    /// The positions.
    pub positions: Vec<[f32; 3]>,
    numbers: HashMap<[u32; 3], u32, RandomState>,
}

impl Weld {
    /// Room for the vertices of a closed surface of so many triangles.
    pub fn for_triangles(triangles: usize) -> Self {
        let vertices = triangles / 2 + 2;
        Self {
            positions: Vec::with_capacity(vertices),
            numbers: HashMap::with_capacity_and_hasher(vertices, RandomState::default()),
        }
    }

    /// The number of the vertex at a position.
    #[inline]
    pub fn vertex(&mut self, position: [f32; 3]) -> u32 {
        // Adding 0 turns −0 into 0 and changes nothing else.
        let key = position.map(|c| (c + 0.0).to_bits());
        let next = self.positions.len() as u32;
        let number = *self.numbers.entry(key).or_insert(next);
        if number == next {
            self.positions.push(position);
        }
        number
    }
}

/// Three vertices fit a triangle's indices only up to this many triangles.
const MOST_TRIANGLES: usize = u32::MAX as usize / 3;

/// Refuses more triangles than indices of 32 bits can tell the vertices of.
pub fn check_count(
    file: &File<'_>,
    place: impl FnOnce() -> Place,
    triangles: usize,
) -> Result<(), SceneError> {
    if triangles <= MOST_TRIANGLES {
        return Ok(());
    }
    Err(SceneError::Unsupported {
        file: file.name.to_owned(),
        place: place(),
        what: format!("a mesh of {triangles} triangles (more than {MOST_TRIANGLES})"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_share_a_number() {
        let mut weld = Weld::default();
        let numbers = [
            [0.0, 1.0, 2.0],
            [1.0, 0.0, 2.0],
            [-0.0, 1.0, 2.0],
            [0.0, 1.0, 2.000_000_2],
        ]
        .map(|p| weld.vertex(p));
        assert_eq!(numbers, [0, 1, 0, 2]);
        assert_eq!(weld.positions.len(), 3);
    }
}
