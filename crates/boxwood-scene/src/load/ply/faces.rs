//! Faces: polygons and triangle strips in, triangles out.

use super::header::{Element, Kind};
use crate::SceneError;
use crate::error::Place;
use crate::load::file::File;
use crate::load::text::quote;

/// Ends a strip among the indices of [`Faces::strip`]: no vertex has this number.
pub const RESTART: u32 = u32::MAX;

/// What a row of indices stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One polygon.
    Polygon,
    /// Strips of triangles, −1 between them.
    Strips,
}

/// Which property of an element holds vertex indices.
#[derive(Clone, Copy, Debug)]
pub struct FacePlan {
    /// The list.
    pub property: usize,
    /// What its rows stand for.
    pub shape: Shape,
    /// How many vertices there are.
    pub vertices: usize,
}

impl FacePlan {
    /// Finds the list of indices; `None` if there are no rows at all.
    ///
    /// # Errors
    /// When it is absent, or no list of integers.
    pub fn new(
        file: &File<'_>,
        element: &Element,
        shape: Shape,
        vertices: usize,
    ) -> Result<Option<Self>, SceneError> {
        if element.count == 0 {
            return Ok(None);
        }
        let found = match element.property(file, "vertex_indices")? {
            None => element.property(file, "vertex_index")?,
            found => found,
        };
        let is_list = |i: &usize| matches!(element.properties[*i].kind, Kind::List { item, .. } if item.is_integer());
        match found.filter(is_list) {
            Some(property) => Ok(Some(Self {
                property,
                shape,
                vertices,
            })),
            None => Err(file.error(
                Place::Line(element.line),
                format!(
                    "element {} has no list of integers `vertex_indices` or `vertex_index`",
                    quote(&element.name)
                ),
            )),
        }
    }

    /// An index as the file has it, if it may stand there.
    #[inline]
    pub fn index(&self, value: i64) -> Option<u32> {
        if (0..self.vertices as i64).contains(&value) {
            Some(value as u32)
        } else {
            let restarts = matches!(value, -1 | 0xffff_ffff) && self.shape == Shape::Strips;
            restarts.then_some(RESTART)
        }
    }

    /// What to say about an index that may not stand there.
    pub fn no_such_vertex(&self, element: &Element, row: usize, value: i64) -> String {
        format!(
            "{} {row} names vertex {value}, but there are {} (counted from 0)",
            element.name, self.vertices
        )
    }
}

/// The triangles so far.
#[derive(Debug, Default)]
pub struct Faces {
    /// In file order.
    pub triangles: Vec<[u32; 3]>,
    /// Where the first face with fewer than three corners was, and how many there are.
    pub skipped: Option<(Place, usize)>,
}

impl Faces {
    /// Adds what a row of checked indices stands for; `place` is asked only if there is something to complain about.
    #[inline]
    pub fn add(
        &mut self,
        shape: Shape,
        indices: &[u32],
        positions: &[[f32; 3]],
        place: impl FnOnce() -> Place,
    ) {
        match (shape, indices) {
            (Shape::Strips, _) => self.strips(indices),
            (Shape::Polygon, [a, b, c]) => self.triangles.push([*a, *b, *c]),
            (Shape::Polygon, [] | [_] | [_, _]) => match &mut self.skipped {
                Some((_, count)) => *count += 1,
                none => *none = Some((place(), 1)),
            },
            (Shape::Polygon, _) => triangulate_polygon(positions, indices, &mut self.triangles),
        }
    }

    /// Every second triangle of a strip is turned round. Triangles that name a vertex twice only join one strip to
    /// the next: they are part of the notation, not of the surface.
    fn strips(&mut self, indices: &[u32]) {
        for strip in indices.split(|i| *i == RESTART) {
            for (at, corners) in strip.windows(3).enumerate() {
                let &[a, b, c] = corners else { continue };
                if a != b && b != c && c != a {
                    let turned = if at % 2 == 0 { [a, b, c] } else { [b, a, c] };
                    self.triangles.push(turned);
                }
            }
        }
    }

    /// The sentence about skipped faces, if there are any.
    pub fn warning(&self, file: &File<'_>) -> Option<String> {
        let (place, count) = self.skipped.as_ref()?;
        let text = match count {
            1 => "a face with fewer than three corners is skipped".to_owned(),
            _ => format!(
                "the first of {count} faces with fewer than three corners, which are skipped"
            ),
        };
        Some(file.warning(place.clone(), text))
    }
}

/// Cuts a polygon of four or more corners into `n - 2` triangles: a fan, right for convex ones.
fn triangulate_polygon(_positions: &[[f32; 3]], polygon: &[u32], out: &mut Vec<[u32; 3]>) {
    out.extend(
        polygon
            .windows(2)
            .skip(1)
            .map(|edge| [polygon[0], edge[0], edge[1]]),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_alternate_and_restart() {
        let mut faces = Faces::default();
        faces.strips(&[0, 1, 2, 3, RESTART, 4, 5, 6, RESTART, 7, 8]);
        assert_eq!(faces.triangles, [[0, 1, 2], [2, 1, 3], [4, 5, 6]]);
        faces.triangles.clear();
        // Two repeated vertices join the strips 0 1 2 and 3 4 5 and keep the turn of the second.
        faces.strips(&[0, 1, 2, 2, 3, 3, 4, 5]);
        assert_eq!(faces.triangles, [[0, 1, 2], [4, 3, 5]]);
    }

    #[test]
    fn polygons_make_two_triangles_fewer_than_corners() {
        let mut faces = Faces::default();
        for corners in 0..7 {
            let polygon: Vec<u32> = (0..corners).collect();
            let before = faces.triangles.len();
            faces.add(Shape::Polygon, &polygon, &[[0.0; 3]; 7], || Place::Line(4));
            let made = faces.triangles.len() - before;
            assert_eq!(made, (corners as usize).saturating_sub(2));
        }
        assert_eq!(faces.skipped, Some((Place::Line(4), 3)));
    }
}
