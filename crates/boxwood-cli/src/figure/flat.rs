//! Scenes in the plane, with what is asked of them and how they are drawn.

use super::sheet::Panel;
use crate::failure::Outcome;
use crate::svg::{BODY, Element, INK, path};
use boxwood::geometry::Figure;
use boxwood::{Intersect, Ray, StructureKind, TraversalStats, Vec3, plane};
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
                .circle([9.4, 4.2], 0.8)
                .segment([10.0, 7.0], [12.0, 8.4])
                .triangle([[11.0, 1.0], [12.6, 1.2], [12.2, 2.8]])
                .rectangle([12.4, 4.6], [13.6, 6.0])
                .circle([14.4, 2.4], 0.7)
                .circle([14.6, 7.6], 0.8),
        )
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
