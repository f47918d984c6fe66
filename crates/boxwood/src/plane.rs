//! Scenes in the plane: the same structures, drawn on paper.
//!
//! *How it works.* Every figure of a [`Scene`] becomes a tall [`Prism`] with one common extent along z, and every ray runs
//! at z = 0. Structures whose builders may not divide z (`axes=xy`) then do in the plane what they do in space: a grid has
//! one layer of cells, an octree splits four ways, and because the prisms are tall the area that a tree weighs is the
//! perimeter. No code knows of dimensions.
//!
//! *Cost.* That of the same scene in space. Since the scale of the scene is the height of its prisms, boxes are met as if
//! they were larger by 2⁻¹⁴ of the scene's size instead of 2⁻¹⁹ or so: seen by nobody but the counters.
//!
//! ```
//! use boxwood::{Intersect, StructureKind, plane};
//! let scene = plane::Scene::new()
//!     .circle([4.0, 1.0], 1.0)
//!     .segment([6.0, -1.0], [6.0, 3.0])
//!     .triangle([[0.0, 3.0], [2.0, 3.0], [1.0, 5.0]])
//!     .rectangle([8.0, 0.0], [9.0, 2.0])
//!     .prisms()?;
//! let kind: StructureKind = "bvh:binned,leaf=1,axes=xy".parse().expect("a structure");
//! let structure = kind.build(&scene);
//!
//! let hits = structure.all_hits(&plane::ray([0.0, 1.0], [1.0, 0.0]));
//! let seen: Vec<_> = hits.iter().map(|hit| (hit.t, hit.primitive)).collect();
//! assert_eq!(seen, [(3.0, 0), (5.0, 0), (6.0, 1), (8.0, 3), (9.0, 3)]);
//! # Ok::<(), boxwood::ShapeError>(())
//! ```

use crate::geometry::shape::ShapeError;
use crate::geometry::{Figure, Prism, Ray};
use crate::primitive::Shapes;
use alloc::vec::Vec;

/// A ray in the plane.
pub fn ray([x, y]: [f32; 2], [dx, dy]: [f32; 2]) -> Ray {
    Ray::new([x, y, 0.0], [dx, dy, 0.0])
}

/// A set of prisms: figures of the plane as structures take them.
pub type Prisms = Shapes<Prism>;

/// Figures of the plane, numbered in the order they are added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    figures: Vec<Figure>,
}

impl Scene {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }
    /// With a straight line between two points.
    #[must_use]
    pub fn segment(self, from: [f32; 2], to: [f32; 2]) -> Self {
        self.with(Figure::Segment { from, to })
    }
    /// With a circle and all in it.
    #[must_use]
    pub fn circle(self, centre: [f32; 2], radius: f32) -> Self {
        self.with(Figure::Circle { centre, radius })
    }
    /// With a triangle.
    #[must_use]
    pub fn triangle(self, corners: [[f32; 2]; 3]) -> Self {
        self.with(Figure::Triangle { corners })
    }
    /// With a box along the axes.
    #[must_use]
    pub fn rectangle(self, lower: [f32; 2], upper: [f32; 2]) -> Self {
        self.with(Figure::Rectangle { lower, upper })
    }
    /// With any figure.
    #[must_use]
    pub fn with(mut self, figure: Figure) -> Self {
        self.figures.push(figure);
        self
    }
    /// The figures.
    pub fn figures(&self) -> &[Figure] {
        &self.figures
    }

    /// The figures as prisms, checked: what structures are built over. All reach equally far up and down, so far that what
    /// they measure along z outweighs the plane.
    ///
    /// # Errors
    /// The first figure that makes no sense: a number that is infinite or NaN, a negative radius, a segment without length,
    /// a triangle without area.
    pub fn prisms(&self) -> Result<Prisms, ShapeError> {
        let half_height = self.half_height();
        Shapes::new(self.figures.iter().map(|&figure| Prism {
            figure,
            half_height,
        }))
    }

    /// A power of two that is 16 to 32 times the scene's size, where floats reach that far.
    fn half_height(&self) -> f32 {
        let mut around = [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]];
        for figure in &self.figures {
            let [lower, upper] = figure.bounds();
            for k in 0..2 {
                around[0][k] = around[0][k].min(lower[k]);
                around[1][k] = around[1][k].max(upper[k]);
            }
        }
        let [lower, upper] = around;
        let size = (upper[0] - lower[0]).max(upper[1] - lower[1]);
        let mut height = 1.0_f32;
        while height < 16.0 * size && height < f32::MAX / 4.0 {
            height *= 2.0;
        }
        while height > 32.0 * size && height > 8.0 * f32::MIN_POSITIVE {
            height *= 0.5;
        }
        // Of one point, or of numbers that `prisms` refuses.
        if size > 0.0 && size.is_finite() {
            height
        } else {
            1.0
        }
    }
}

impl FromIterator<Figure> for Scene {
    fn from_iter<T: IntoIterator<Item = Figure>>(figures: T) -> Self {
        Self {
            figures: figures.into_iter().collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::Primitives;

    #[test]
    fn prisms_are_tall_at_every_scale() {
        for size in [1.0e-37, 1.0e-20, 1.0e-3, 1.0, 3.0, 1.0e6, 1.0e30, 3.0e37] {
            let scene = Scene::new().rectangle([0.0; 2], [size, 0.5 * size]);
            let prisms = scene.prisms().expect("a good scene");
            let height = prisms.bounds(0).upper.z;
            let most = if size < 1.0e36 { 32.0 } else { f32::INFINITY };
            assert!(
                (1.0..=most).contains(&(height / size)),
                "{height} over {size}"
            );
            if 1.0e-36 < size && size < 1.0e36 {
                assert!(height >= 16.0 * size);
            }
        }
        let point = Scene::new().rectangle([3.0; 2], [3.0; 2]).prisms();
        assert_eq!(point.expect("a good scene").bounds(0).upper.z, 1.0);
        assert!(Scene::new().prisms().expect("nothing is fine").is_empty());
    }
}
