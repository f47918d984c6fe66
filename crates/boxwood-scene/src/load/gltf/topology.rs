//! From a primitive's mode and its list of corners to triangles.
//!
//! *Source.* glTF 2.0, section 3.7.2.1: which corners make which triangle, and in which order, is its table.

/// The modes that have triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    /// How many triangles `corners` corners make; what is left over counts for nothing.
    pub fn triangle_count(self, corners: usize) -> usize {
        match self {
            Self::Triangles => corners / 3,
            Self::Strip | Self::Fan => corners.saturating_sub(2),
        }
    }

    /// How many of the corners belong to a triangle.
    pub fn used_corners(self, corners: usize) -> usize {
        match (self, self.triangle_count(corners)) {
            (_, 0) => 0,
            (Self::Triangles, n) => 3 * n,
            (Self::Strip | Self::Fan, n) => n + 2,
        }
    }

    /// Triangle `i`, counter-clockwise from the front.
    pub fn triangle(self, i: usize, corner: impl Fn(usize) -> u32) -> [u32; 3] {
        match self {
            Self::Triangles => [3 * i, 3 * i + 1, 3 * i + 2],
            Self::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Self::Fan => [i + 1, i + 2, 0],
        }
        .map(corner)
    }
}

/// Leaves out the vertices that no triangle names, and renumbers the rest in their old order.
///
/// Primitives often share one long list of vertices. Returns the old number of each new vertex; `triangles` is
/// rewritten. All of them name vertices below `vertex_count`.
pub fn compact(triangles: &mut [[u32; 3]], vertex_count: usize) -> Vec<u32> {
    if vertex_count / 4 > triangles.len() {
        // A few triangles of a long list: the list is not walked.
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        for vertex in triangles.iter_mut().flatten() {
            // Each is in the list that was made of them.
            *vertex = used.partition_point(|old| old < vertex) as u32;
        }
        return used;
    }
    let mut is_used = vec![false; vertex_count];
    for &vertex in triangles.iter().flatten() {
        is_used[vertex as usize] = true;
    }
    let used: Vec<u32> = (0..vertex_count as u32)
        .filter(|&v| is_used[v as usize])
        .collect();
    if used.len() < vertex_count {
        let mut new = vec![0; vertex_count];
        for (position, &old) in used.iter().enumerate() {
            new[old as usize] = position as u32;
        }
        for vertex in triangles.iter_mut().flatten() {
            *vertex = new[*vertex as usize];
        }
    }
    used
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(mode: Mode, corners: usize) -> Vec<[u32; 3]> {
        let corner = |i| i as u32;
        (0..mode.triangle_count(corners))
            .map(|i| mode.triangle(i, corner))
            .collect()
    }

    #[test]
    fn modes_follow_the_specification() {
        assert_eq!(all(Mode::Triangles, 8), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(all(Mode::Strip, 5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(all(Mode::Fan, 5), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        for mode in [Mode::Triangles, Mode::Strip, Mode::Fan] {
            assert_eq!(mode.used_corners(2), 0);
            assert_eq!(mode.used_corners(3), 3);
        }
        assert_eq!(Mode::Triangles.used_corners(8), 6);
    }

    #[test]
    fn both_ways_of_compacting_agree() {
        let triangles = [[7, 2, 9], [2, 7, 7], [4, 9, 2]];
        let expected = ([[2, 0, 3], [0, 2, 2], [1, 3, 0]], vec![2, 4, 7, 9]);
        for vertex_count in [10, 1000] {
            let mut renumbered = triangles;
            let used = compact(&mut renumbered, vertex_count);
            assert_eq!((renumbered, used), expected);
        }
        assert_eq!(compact(&mut [[0, 1, 2]], 3), [0, 1, 2]);
    }
}
