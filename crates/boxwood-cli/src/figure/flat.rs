//! Scenes in the plane, with what is asked of them and how they are drawn.

use super::resolution::inverse;
use super::sheet::Panel;
use crate::failure::Outcome;
use crate::svg::{BODY, Element, INK, path};
use boxwood::geometry::Figure;
use boxwood::{Intersect, Ray, StructureKind, TraversalStats, TriangleMesh, Vec3, plane};
use std::f32::consts::TAU;

/// A scene in the plane.
pub struct Flat {
    pub scene: plane::Scene,
    pub prisms: plane::Prisms,
}

/// Corners of what stands for a circle.
const CORNERS: usize = 40;

impl Flat {
    pub fn new(scene: plane::Scene) -> Outcome<Self> {
        let prisms = scene.prisms()?;
        Ok(Self { scene, prisms })
    }

    /// Thirteen things that lie about, and a ray that passes some of them and hits one.
    pub fn yard() -> Outcome<Self> {
        Self::new(
            plane::Scene::new()
                .circle([1.9, 7.0], 0.75)
                .triangle([[1.0, 1.2], [2.6, 1.0], [1.9, 2.6]])
                .triangle([[4.0, 7.6], [5.6, 7.4], [5.6, 5.35]])
                .circle([5.0, 1.7], 0.6)
                .segment([3.4, 2.8], [6.0, 4.0])
                .triangle([[7.0, 0.8], [8.6, 1.4], [7.4, 2.4]])
                .rectangle([7.2, 6.4], [8.4, 8.0])
                .circle([9.0, 4.1], 0.8)
                .segment([10.0, 7.0], [12.0, 8.4])
                .triangle([[11.0, 1.0], [12.6, 1.2], [12.2, 2.8]])
                .rectangle([12.4, 4.6], [13.6, 6.0])
                .circle([14.4, 2.4], 0.7)
                .circle([14.6, 7.6], 0.8),
        )
    }
    /// A dozen triangles, as prisms and, flat in the plane, as a mesh, which knows exactly what it overlaps.
    pub fn triangles() -> Outcome<(Self, TriangleMesh)> {
        let all: Vec<[[f32; 2]; 3]> = (1..=12_u32)
            .map(|k| {
                let (a, b, c) = (inverse(k, 2), inverse(k, 3), inverse(k, 5));
                let (x, y) = (2.0 + 12.0 * a, 1.8 + 5.4 * b);
                let corner = |turn: f32, r: f32| {
                    let (sin, cos) = (TAU * (turn + c)).sin_cos();
                    [x + r * cos, y + r * sin]
                };
                [corner(0.0, 1.5), corner(0.3, 0.8), corner(0.55, 1.4)]
            })
            .collect();
        let corners = all.iter().flatten().map(|[x, y]| [*x, *y, 0.0]);
        let count = all.len() as u32;
        let numbers = (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
        let mesh = TriangleMesh::new(corners, numbers)?;
        let scene = plane::Scene::new();
        let scene = all.into_iter().fold(scene, plane::Scene::triangle);
        Ok((Self::new(scene)?, mesh))
    }
    /// What is seen of [`Flat::yard`].
    pub const YARD: [[f32; 2]; 2] = [[0.0, 0.2], [16.0, 9.0]];
    pub fn yard_ray() -> Ray {
        plane::ray([0.3, 6.6], [1.0, -0.25])
    }

    /// A structure by name.
    pub fn build(&self, kind: &str) -> Outcome<Box<dyn Intersect + '_>> {
        Ok(kind.parse::<StructureKind>()?.build(&self.prisms))
    }

    /// The corners of a figure.
    pub fn outline(&self, i: usize) -> Vec<Vec3> {
        let flat = |[x, y]: [f32; 2]| Vec3::new(x, y, 0.0);
        match self.scene.figures()[i] {
            Figure::Segment { from, to } => vec![flat(from), flat(to)],
            Figure::Triangle { corners } => corners.map(flat).to_vec(),
            Figure::Rectangle {
                lower: [l, b],
                upper: [r, t],
            } => [[l, b], [r, b], [r, t], [l, t]].map(flat).to_vec(),
            Figure::Circle {
                centre: [x, y],
                radius,
            } => (0..CORNERS)
                .map(|k| TAU * k as f32 / CORNERS as f32)
                .map(|a| flat([x + radius * a.cos(), y + radius * a.sin()]))
                .collect(),
            // A kind of figure that is yet to be invented.
            _ => Vec::new(),
        }
    }

    /// Some of the figures, filled.
    pub fn draw(&self, panel: &Panel, which: impl IntoIterator<Item = usize>) -> Element {
        let outlines: Vec<Vec<[f64; 2]>> = which
            .into_iter()
            .map(|i| self.outline(i))
            .map(|corners| corners.into_iter().map(|p| panel.window.place(p)).collect())
            .collect();
        path(outlines.iter().map(Vec::as_slice), true)
            .with("fill", BODY)
            .with("stroke", INK)
            .with("stroke-width", 1.1)
    }

    /// All figures.
    pub fn draw_all(&self, panel: &Panel) -> Element {
        self.draw(panel, 0..self.scene.figures().len())
    }
}

/// Rays from a point into a range of directions, given in turns.
pub fn fan(origin: [f32; 2], [from, to]: [f32; 2], count: usize) -> Vec<Ray> {
    (0..count)
        .map(|k| from + (to - from) * (k as f32 + 0.5) / count as f32)
        .map(|turn| plane::ray(origin, [(TAU * turn).cos(), (TAU * turn).sin()]))
        .collect()
}

/// What rays cost in all.
pub fn asked(structure: &dyn Intersect, rays: &[Ray]) -> TraversalStats {
    let mut stats = TraversalStats::default();
    for ray in rays {
        structure.closest_hit_counted(ray, &mut stats);
    }
    stats
}

/// A number per ray, to one digit.
pub fn each(total: u64, rays: &[Ray]) -> String {
    format!("{:.1}", total as f64 / rays.len().max(1) as f64)
}

/// A straight wall, from end to end.
pub type Wall = [[f32; 2]; 2];

/// Each wall as one tall triangle: triangles are cut exactly, and BSP trees cut along them. The plane z = 0 cuts all of
/// it but the last hundredth.
pub fn tall(walls: &[Wall]) -> Outcome<TriangleMesh> {
    let corners = walls.iter().flat_map(|[[ax, ay], [bx, by]]| {
        [
            Vec3::new(*ax, *ay, -2.0),
            Vec3::new(*bx, *by, -2.0),
            Vec3::new(*bx, *by, 320.0),
        ]
    });
    let count = walls.len() as u32;
    Ok(TriangleMesh::new(
        corners.map(Vec3::to_array),
        (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]),
    )?)
}
