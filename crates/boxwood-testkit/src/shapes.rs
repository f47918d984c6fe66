//! Well-behaved meshes: closed surfaces with shared vertices, a curved open one, terrain.

use crate::Random;
use boxwood::TriangleMesh;
use libm::{cos, sin};
use std::f64::consts::TAU;

/// Vertices and triangles on the way to a mesh: can still be moved and scaled.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Vertices.
    pub positions: Vec<[f32; 3]>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

impl Model {
    /// Three own vertices for every triangle.
    pub fn of_triangles(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Self {
        let positions: Vec<_> = triangles.into_iter().flatten().collect();
        let count = positions.len() as u32 / 3;
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Self {
            positions,
            triangles,
        }
    }
    /// First scaled, then moved by `offset` times the scale. Vertices that were one stay one.
    pub fn placed(mut self, scale: f32, offset: f32) -> Self {
        for p in &mut self.positions {
            *p = p.map(|x| (x + offset) * scale);
        }
        self
    }
    /// Moved along each axis by so much of its own. Vertices that were one stay one.
    pub fn moved(mut self, by: [f32; 3]) -> Self {
        for p in &mut self.positions {
            *p = [p[0] + by[0], p[1] + by[1], p[2] + by[2]];
        }
        self
    }
    /// With another model beside it.
    pub fn with(mut self, other: &Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        let moved = other.triangles.iter().map(|t| t.map(|v| v + first));
        self.triangles.extend(moved);
        self
    }
    /// The checked mesh.
    ///
    /// # Panics
    /// When a vertex is not finite or an index names none.
    pub fn mesh(&self) -> TriangleMesh {
        TriangleMesh::new(self.positions.iter().copied(), self.triangles.clone())
            .expect("models are made finite and whole")
    }

    /// Two triangles for every cell of a grid of `columns` × `rows` cells whose corners `vertex` numbers.
    fn add_grid(&mut self, columns: u32, rows: u32, vertex: impl Fn(u32, u32) -> u32) {
        for row in 0..rows {
            for column in 0..columns {
                let a = vertex(column, row);
                let b = vertex(column + 1, row);
                let c = vertex(column + 1, row + 1);
                let d = vertex(column, row + 1);
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
}

/// A closed sphere of radius 1 around the origin, `around` meridians and `up` parallels; the poles are one vertex each.
pub fn sphere(around: u32, up: u32) -> Model {
    let mut model = Model::default();
    // From the south, so that the grid's cells run counter-clockwise from outside.
    for row in (1..up).rev() {
        let polar = TAU / 2.0 * f64::from(row) / f64::from(up);
        for column in 0..around {
            let turn = TAU * f64::from(column) / f64::from(around);
            let (x, y) = (sin(polar) * cos(turn), sin(polar) * sin(turn));
            model.positions.push([x, y, cos(polar)].map(|x| x as f32));
        }
    }
    model.add_grid(around, up - 2, |column, row| row * around + column % around);
    let (north, south) = (
        model.positions.len() as u32,
        model.positions.len() as u32 + 1,
    );
    model.positions.extend([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
    let last = (up - 2) * around;
    for column in 0..around {
        let next = (column + 1) % around;
        model.triangles.push([south, next, column]);
        model.triangles.push([north, last + column, last + next]);
    }
    model
}

/// A closed torus around z: the tube of radius 0.4 runs around a circle of radius 1.
pub fn torus(around: u32, tube: u32) -> Model {
    let mut model = Model::default();
    for row in 0..tube {
        let within = TAU * f64::from(row) / f64::from(tube);
        for column in 0..around {
            let turn = TAU * f64::from(column) / f64::from(around);
            let out = 1.0 + 0.4 * cos(within);
            model
                .positions
                .push([out * cos(turn), out * sin(turn), 0.4 * sin(within)].map(|x| x as f32));
        }
    }
    model.add_grid(around, tube, |column, row| {
        (row % tube) * around + column % around
    });
    model
}

/// A closed cube from -1 to 1, each side of `n` × `n` cells; vertices are shared across the cube's edges too.
pub fn cube(n: u32) -> Model {
    let mut model = Model::default();
    let mut numbers = std::collections::BTreeMap::new();
    for axis in 0..3 {
        for side in [0, n] {
            let mut corner = |a: u32, b: u32| {
                let mut at = [side; 3];
                at[(axis + 1) % 3] = a;
                at[(axis + 2) % 3] = b;
                *numbers.entry(at).or_insert_with(|| {
                    let place = at.map(|k| (2.0 * f64::from(k) / f64::from(n) - 1.0) as f32);
                    model.positions.push(place);
                    model.positions.len() as u32 - 1
                })
            };
            let mut cells = Vec::new();
            for b in 0..n {
                for a in 0..n {
                    let [p, q, r, s] = [
                        corner(a, b),
                        corner(a + 1, b),
                        corner(a + 1, b + 1),
                        corner(a, b + 1),
                    ];
                    cells.extend([[p, q, r], [p, r, s]]);
                }
            }
            // Counter-clockwise from outside.
            let outward = |[a, b, c]: [u32; 3]| if side == 0 { [a, c, b] } else { [a, b, c] };
            model.triangles.extend(cells.into_iter().map(outward));
        }
    }
    model
}

/// An open curved surface of revolution with a bulge and a neck, like a teapot without handle and spout; radius about 1.
pub fn vase(around: u32, up: u32) -> Model {
    let mut model = Model::default();
    for row in 0..=up {
        let height = f64::from(row) / f64::from(up);
        let radius = 0.55 + 0.45 * sin(5.0 * height);
        for column in 0..around {
            let turn = TAU * f64::from(column) / f64::from(around);
            let place = [radius * cos(turn), radius * sin(turn), 2.0 * height - 1.0];
            model.positions.push(place.map(|x| x as f32));
        }
    }
    model.add_grid(around, up, |column, row| row * around + column % around);
    model
}

/// Random hills over the square from -1 to 1, `n` × `n` cells.
pub fn terrain(n: u32, random: &mut Random) -> Model {
    let mut model = Model::default();
    let waves: Vec<[f64; 4]> = (0..8)
        .map(|i| {
            let v = random.in_cube() * (1 << (i / 2)) as f32 * 2.0;
            [v.x, v.y, v.z, 0.3 / (1 + i) as f32].map(f64::from)
        })
        .collect();
    for row in 0..=n {
        for column in 0..=n {
            let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
            let (x, y) = (at(column), at(row));
            let height: f64 = waves
                .iter()
                .map(|w| w[3] * sin(w[0] * x + w[1] * y + w[2]))
                .sum();
            model.positions.push([x, y, height].map(|x| x as f32));
        }
    }
    model.add_grid(n, n, |column, row| row * (n + 1) + column);
    model
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Every edge of a closed surface belongs to two triangles, once in each direction.
    #[test]
    fn closed_shapes_are_closed() {
        for (name, model) in [
            ("sphere", sphere(7, 5)),
            ("torus", torus(6, 5)),
            ("cube", cube(3)),
        ] {
            let mut edges = BTreeMap::new();
            for t in &model.triangles {
                for k in 0..3 {
                    *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1;
                }
            }
            for (&(a, b), &times) in &edges {
                assert_eq!(times, 1, "{name}: edge {a} {b}");
                assert!(edges.contains_key(&(b, a)), "{name}: edge {a} {b} is open");
            }
            let (v, e, f) = (
                model.positions.len(),
                edges.len() / 2,
                model.triangles.len(),
            );
            assert_eq!(v + f - e, if name == "torus" { 0 } else { 2 }, "{name}");
        }
    }
}
