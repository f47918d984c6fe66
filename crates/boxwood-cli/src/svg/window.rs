//! A view of space as seen along an axis, and its place on the paper.

use boxwood::{Aabb, Vec3};

/// A view along an axis: which axes run to the right and up.
///
/// Along z one looks at x and y, along x at z and y; along y one looks down on x and z, as on a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    across: usize,
    up: usize,
    /// Whether larger coordinates of `up` lie further down.
    downwards: bool,
}

impl View {
    pub fn along(axis: usize) -> Self {
        let (across, up) = [(2, 1), (0, 2), (0, 1)][axis.min(2)];
        Self {
            across,
            up,
            downwards: axis == 1,
        }
    }
    /// A point as it is seen.
    pub fn flat(&self, p: Vec3) -> [f64; 2] {
        [p[self.across], p[self.up]].map(f64::from)
    }
    /// Whether an axis is seen, and not looked along.
    pub fn shows(&self, axis: usize) -> bool {
        axis == self.across || axis == self.up
    }
    /// The letters of the axes to the right and up.
    pub fn letters(&self) -> [&'static str; 2] {
        [self.across, self.up].map(|axis| ["x", "y", "z"][axis])
    }
}

/// A part of a view, on a rectangle of the paper. The scale is the same along both axes.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    view: View,
    /// The middle of what is seen, and where it comes to lie.
    middle: [f64; 2],
    paper: [f64; 2],
    scale: f64,
}

impl Window {
    /// Shows all of a box within a rectangle given by corner and size.
    pub fn new(view: View, bounds: &Aabb, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> Self {
        let (lower, upper) = (view.flat(bounds.lower), view.flat(bounds.upper));
        let size = [upper[0] - lower[0], upper[1] - lower[1]];
        let fit = |paper: f64, size: f64| {
            if size > 0.0 {
                paper / size
            } else {
                f64::INFINITY
            }
        };
        let scale = fit(width, size[0]).min(fit(height, size[1]));
        Self {
            view,
            middle: [0, 1].map(|k| f64::midpoint(lower[k], upper[k])),
            paper: [x + 0.5 * width, y + 0.5 * height],
            scale: if scale.is_finite() { scale } else { 1.0 },
        }
    }

    /// Where a point comes to lie. Points far outside are brought near, so that every number stays short.
    pub fn place(&self, p: Vec3) -> [f64; 2] {
        let flat = self.view.flat(p);
        let shift = |k: usize| ((flat[k] - self.middle[k]) * self.scale).clamp(-1.0e5, 1.0e5);
        let up = if self.view.downwards {
            shift(1)
        } else {
            -shift(1)
        };
        [self.paper[0] + shift(0), self.paper[1] + up]
    }

    /// Corner and size of a box on the paper.
    pub fn rectangle(&self, b: &Aabb) -> [[f64; 2]; 2] {
        let (p, q) = (self.place(b.lower), self.place(b.upper));
        let corner = [p[0].min(q[0]), p[1].min(q[1])];
        [corner, [(p[0] - q[0]).abs(), (p[1] - q[1]).abs()]]
    }
}

/// Where a plane across an axis cuts a flat polygon.
pub fn section(polygon: &[Vec3], (axis, place): (usize, f32)) -> Option<[Vec3; 2]> {
    let mut ends = Vec::new();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (da, db) = (a[axis] - place, b[axis] - place);
        if (da < 0.0) != (db < 0.0) {
            ends.push(a + (b - a) * (da / (da - db)));
        }
    }
    match ends[..] {
        [a, b] => Some([a, b]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_upright() {
        let b = Aabb::new([0.0; 3], [4.0, 2.0, 1.0]);
        let window = |axis| Window::new(View::along(axis), &b, [10.0, 10.0], [80.0, 80.0]);
        assert_eq!(window(2).place(b.lower), [10.0, 70.0]);
        assert_eq!(window(2).place(b.upper), [90.0, 30.0]);
        // On a map larger z lies further down, nearer to who reads it.
        assert_eq!(window(1).place(b.lower), [10.0, 40.0]);
        assert_eq!(window(1).rectangle(&b), [[10.0, 40.0], [80.0, 20.0]]);
        assert_eq!(View::along(0).letters(), ["z", "y"]);
    }

    #[test]
    fn a_point_has_a_place_too() {
        let b = Aabb::new([3.0; 3], [3.0; 3]);
        let window = Window::new(View::along(2), &b, [0.0; 2], [10.0; 2]);
        assert_eq!(window.place(b.lower), [5.0; 2]);
        assert!(window.place(Vec3::splat(f32::MAX))[0] <= 1.1e5);
    }
}
