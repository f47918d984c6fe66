//! Cuts polygons into triangles, `n − 2` for `n` corners, whatever their shape.
//!
//! *How it works.* A quad is cut along the diagonal whose worse triangle is the larger, a convex polygon becomes a fan.
//! Any other polygon is seen along the axis next to its normal (Newell's, which also holds for corners not quite in
//! one plane) and loses one *ear* after the other: a corner whose triangle nothing of the polygon reaches into. Corners
//! may stand on each other or on edges, as at the slits by which files cut holes: such a corner blocks an ear only if an
//! edge leads from it into the ear's triangle. Corners of zero area are cut when no true ear is left, and where not even
//! those are left (the polygon crosses itself) any convex corner is. Differences and products of `f32` coordinates are
//! exact in `f64` unless their magnitudes differ by much, so that corners in one line are recognised.
//!
//! *Cost.* Linear for quads and convex polygons. Otherwise each corner is tested at most a few times against those
//! reflex corners that a grid finds near its triangle, about `√n`; a bound on the total work makes what is left of
//! a pathological polygon a fan. *Source.* Meisters 1975, *Polygons Have Ears*; Held 2001, *FIST*; Newell's normal from
//! Sutherland, Sproull & Schumacker 1974.

mod ears;
mod grid;

use ears::Ears;

/// Triangulates one polygon after the other, reusing its memory.
#[derive(Default)]
pub(crate) struct Triangulator {
    points: Vec<[f64; 2]>,
    ears: Ears,
}

impl Triangulator {
    /// Appends the `n − 2` triangles of the polygon with these `n` corners, each as three indices of `corners`, turning
    /// like the polygon; nothing for fewer than three corners. Coordinates must be finite.
    pub(crate) fn triangulate(&mut self, corners: &[[f32; 3]], triangles: &mut Vec<[u32; 3]>) {
        match corners {
            [] | [_] | [_, _] => return,
            [_, _, _] => return triangles.push([0, 1, 2]),
            [a, b, c, d] => return quad([a, b, c, d], triangles),
            _ => {}
        }
        let normal = newell(corners);
        let axis = largest(normal);
        if normal[axis] == 0.0 {
            return fan(corners.len(), triangles);
        }
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            (u, v) = (v, u);
        }
        self.points.clear();
        self.points
            .extend(corners.iter().map(|p| [f64::from(p[u]), f64::from(p[v])]));
        if is_convex(&self.points) {
            return fan(corners.len(), triangles);
        }
        self.ears.cut(&self.points, triangles);
    }
}

/// Twice the signed area of the triangle, positive when it turns to the left.
#[inline]
fn orient(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn fan(count: usize, triangles: &mut Vec<[u32; 3]>) {
    triangles.extend((1..count as u32 - 1).map(|i| [0, i, i + 1]));
}

fn quad(corners: [&[f32; 3]; 4], triangles: &mut Vec<[u32; 3]>) {
    let p = corners.map(|p| p.map(f64::from));
    let edge = |from: usize, to: usize| std::array::from_fn(|k| p[to][k] - p[from][k]);
    let normal = cross(edge(0, 2), edge(1, 3));
    // Twice the area of the triangle at each corner, seen along the normal: negative where the corner is reflex.
    let area = |a, b, c| dot(cross(edge(a, b), edge(b, c)), normal);
    let even = area(3, 0, 1).min(area(1, 2, 3));
    let odd = area(0, 1, 2).min(area(2, 3, 0));
    if odd > 0.0 || odd >= even {
        triangles.extend([[0, 1, 2], [0, 2, 3]]);
    } else {
        triangles.extend([[1, 2, 3], [1, 3, 0]]);
    }
}

/// The normal, as long as twice the area; zero when all corners lie in a line.
fn newell(corners: &[[f32; 3]]) -> [f64; 3] {
    let origin = corners[0].map(f64::from);
    let from_origin =
        |p: &[f32; 3]| -> [f64; 3] { std::array::from_fn(|k| f64::from(p[k]) - origin[k]) };
    let mut normal = [0.0; 3];
    for pair in corners.windows(2) {
        let part = cross(from_origin(&pair[0]), from_origin(&pair[1]));
        for (sum, part) in normal.iter_mut().zip(part) {
            *sum += part;
        }
    }
    normal
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn largest(v: [f64; 3]) -> usize {
    let [x, y, z] = v.map(f64::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Whether every corner turns to the left, once around in all.
fn is_convex(points: &[[f64; 2]]) -> bool {
    let count = points.len();
    let mut turns = 0;
    let mut rising = points[0][1] > points[count - 1][1];
    for i in 0..count {
        let (a, b, c) = (points[i], points[(i + 1) % count], points[(i + 2) % count]);
        if orient(a, b, c) <= 0.0 {
            return false;
        }
        if b[1] != a[1] {
            turns += u32::from((b[1] > a[1]) != rising);
            rising = b[1] > a[1];
        }
    }
    turns <= 2
}

#[cfg(test)]
mod tests;
