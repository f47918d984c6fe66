//! Cuts the ears off a polygon in the plane until a triangle is left.

use super::grid::Grid;
use super::orient;

/// The corners that are left, linked in a ring, and the order in which they are tried.
#[derive(Default)]
pub(super) struct Ears {
    previous: Vec<u32>,
    next: Vec<u32>,
    /// Whether a corner is left.
    alive: Vec<bool>,
    /// Whether a corner turns to the right or not at all, so that it may stand in the way of an ear.
    reflex: Vec<bool>,
    /// Corners to be tried, and those of zero area, to be cut when nothing else is left.
    queue: Vec<u32>,
    flat: Vec<u32>,
    blockers: Vec<u32>,
    grid: Grid,
}

/// Corners looked at in all, per corner of the polygon, before the rest becomes a fan.
const WORK_PER_CORNER: u64 = 1024;

impl Ears {
    /// Appends the `n − 2` triangles of a polygon that turns to the left as a whole.
    pub(super) fn cut(&mut self, points: &[[f64; 2]], triangles: &mut Vec<[u32; 3]>) {
        let count = points.len() as u32;
        self.link(points);
        let mut left = count;
        let mut work = u64::from(count) * WORK_PER_CORNER;
        let mut cursor = 0;
        while left > 3 && work > 0 {
            let ear = match self.true_ear(points, &mut work) {
                Some(ear) => ear,
                None => match self.flat_corner(points) {
                    Some(corner) => corner,
                    None => match self.convex_corner(points, cursor, left, &mut work) {
                        Some(corner) => corner,
                        None => break,
                    },
                },
            };
            cursor = self.next[ear as usize];
            triangles.push([self.previous[ear as usize], ear, cursor]);
            self.remove(ear, points);
            left -= 1;
        }
        let mut corner = self.next[cursor as usize];
        for _ in 2..left {
            let after = self.next[corner as usize];
            triangles.push([cursor, corner, after]);
            corner = after;
        }
    }

    fn link(&mut self, points: &[[f64; 2]]) {
        let count = points.len() as u32;
        self.previous.clear();
        self.previous
            .extend((0..count).map(|i| (i + count - 1) % count));
        self.next.clear();
        self.next.extend((0..count).map(|i| (i + 1) % count));
        self.alive.clear();
        self.alive.resize(points.len(), true);
        self.reflex.clear();
        for corner in 0..count {
            let is_reflex = self.turn(corner, points) <= 0.0;
            self.reflex.push(is_reflex);
        }
        self.queue.clear();
        self.queue.extend((0..count).rev());
        self.flat.clear();
        self.blockers.clear();
        let reflex = &self.reflex;
        self.blockers
            .extend((0..count).filter(|&corner| reflex[corner as usize]));
        self.grid.fill(points, &self.blockers);
    }

    /// Twice the signed area of the triangle at a corner.
    fn turn(&self, corner: u32, points: &[[f64; 2]]) -> f64 {
        let [a, b, c] = self.triangle(corner, points);
        orient(a, b, c)
    }

    fn triangle(&self, corner: u32, points: &[[f64; 2]]) -> [[f64; 2]; 3] {
        let corner = corner as usize;
        [
            points[self.previous[corner] as usize],
            points[corner],
            points[self.next[corner] as usize],
        ]
    }

    fn remove(&mut self, corner: u32, points: &[[f64; 2]]) {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        self.alive[corner as usize] = false;
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        // Only the neighbours can have become ears.
        for neighbour in [before, after] {
            self.reflex[neighbour as usize] = self.turn(neighbour, points) <= 0.0;
            self.queue.push(neighbour);
        }
    }

    /// The next corner with area whose triangle nothing reaches into.
    fn true_ear(&mut self, points: &[[f64; 2]], work: &mut u64) -> Option<u32> {
        while let Some(corner) = self.queue.pop() {
            if !self.alive[corner as usize] || *work == 0 {
                continue;
            }
            let turn = self.turn(corner, points);
            if turn == 0.0 {
                self.flat.push(corner);
            } else if turn > 0.0 && self.is_free(corner, points, work) {
                return Some(corner);
            }
        }
        None
    }

    fn flat_corner(&mut self, points: &[[f64; 2]]) -> Option<u32> {
        while let Some(corner) = self.flat.pop() {
            if self.alive[corner as usize] && self.turn(corner, points) == 0.0 {
                return Some(corner);
            }
        }
        None
    }

    /// Any corner that turns to the left: the last resort for polygons that cross themselves.
    fn convex_corner(
        &self,
        points: &[[f64; 2]],
        from: u32,
        left: u32,
        work: &mut u64,
    ) -> Option<u32> {
        let mut corner = from;
        for _ in 0..left {
            *work = work.saturating_sub(1);
            if self.turn(corner, points) > 0.0 {
                return Some(corner);
            }
            corner = self.next[corner as usize];
        }
        None
    }

    /// Whether nothing of the polygon reaches into a corner's triangle.
    fn is_free(&self, corner: u32, points: &[[f64; 2]], work: &mut u64) -> bool {
        let triangle = self.triangle(corner, points);
        let own = [
            self.previous[corner as usize],
            corner,
            self.next[corner as usize],
        ];
        let mut done = 0;
        let blocked = self.grid.any_near(triangle, &mut done, |other| {
            self.alive[other as usize]
                && self.reflex[other as usize]
                && !own.contains(&other)
                && self.reaches_into(other, triangle, points)
        });
        *work = work.saturating_sub(done);
        !blocked
    }

    /// Whether a corner lies inside the triangle, or on its border with an edge that leads inside.
    fn reaches_into(&self, corner: u32, [a, b, c]: [[f64; 2]; 3], points: &[[f64; 2]]) -> bool {
        let [before, point, after] = self.triangle(corner, points);
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (from, to, orient(from, to, point)));
        if sides.iter().any(|side| side.2 < 0.0) {
            return false;
        }
        // Inside of the sides that the point lies on: all that an edge must be to lead into the triangle.
        let leads_inside = |end: [f64; 2]| {
            (sides.iter()).all(|&(from, to, side)| side > 0.0 || orient(from, to, end) > 0.0)
        };
        leads_inside(before) || leads_inside(after)
    }
}
