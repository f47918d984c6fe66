//! Points in square cells, to find those near a triangle.

/// Points sorted by cell, row by row.
#[derive(Default)]
pub(super) struct Grid {
    low: [f64; 2],
    /// Cells per unit of length along each axis.
    scale: [f64; 2],
    size: usize,
    /// Where each cell begins in `ids`.
    starts: Vec<u32>,
    ids: Vec<u32>,
}

impl Grid {
    /// Sorts the points with these indices.
    pub(super) fn fill(&mut self, points: &[[f64; 2]], ids: &[u32]) {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for &id in ids {
            for axis in 0..2 {
                low[axis] = low[axis].min(points[id as usize][axis]);
                high[axis] = high[axis].max(points[id as usize][axis]);
            }
        }
        self.low = low;
        self.size = ((ids.len() as f64).sqrt() as usize).clamp(1, 1024);
        let size = self.size as f64;
        self.scale = std::array::from_fn(|axis| {
            let scale = size / (high[axis] - low[axis]);
            if scale.is_finite() { scale } else { 0.0 }
        });
        self.starts.clear();
        self.starts.resize(self.size * self.size + 1, 0);
        for &id in ids {
            let cell = self.cell(points[id as usize]);
            self.starts[cell] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        self.ids.clear();
        self.ids.resize(ids.len(), 0);
        // From the back, so that each start moves down to its place.
        for &id in ids.iter().rev() {
            let cell = self.cell(points[id as usize]);
            self.starts[cell] -= 1;
            self.ids[self.starts[cell] as usize] = id;
        }
    }

    fn coordinate(&self, value: f64, axis: usize) -> usize {
        // Saturates: below the grid is the first cell.
        (((value - self.low[axis]) * self.scale[axis]) as usize).min(self.size - 1)
    }

    fn cell(&self, point: [f64; 2]) -> usize {
        self.coordinate(point[1], 1) * self.size + self.coordinate(point[0], 0)
    }

    /// Calls `visit` with every point in the cells that the triangle touches (and perhaps a few more) until it returns
    /// `true`; `true` if it did. Adds the rows and points looked at to `work`.
    pub(super) fn any_near(
        &self,
        triangle: [[f64; 2]; 3],
        work: &mut u64,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        if self.ids.is_empty() {
            return false;
        }
        let rows = triangle.map(|p| self.coordinate(p[1], 1));
        let first = rows[0].min(rows[1]).min(rows[2]);
        let last = rows[0].max(rows[1]).max(rows[2]);
        for row in first..=last {
            let (left, right) = self.columns(triangle, row, (first, last));
            let cells = row * self.size + left..=row * self.size + right;
            let from = self.starts[*cells.start()] as usize;
            let to = self.starts[*cells.end() + 1] as usize;
            *work += 1;
            for &id in &self.ids[from..to] {
                *work += 1;
                if visit(id) {
                    return true;
                }
            }
        }
        false
    }

    /// The columns that the triangle touches in a row, one more on either side against rounding.
    fn columns(
        &self,
        triangle: [[f64; 2]; 3],
        row: usize,
        (first, last): (usize, usize),
    ) -> (usize, usize) {
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        let mut include = |x: f64| {
            low = low.min(x);
            high = high.max(x);
        };
        // A little higher than the row, so that rounding cannot hide an edge. Beyond the grid lie the outer rows.
        let bottom = (row as f64 - 0.01) / self.scale[1] + self.low[1];
        let top = (row as f64 + 1.01) / self.scale[1] + self.low[1];
        let is_single = first == last || self.scale[1] == 0.0;
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (triangle[a], triangle[b]);
            if is_single || row == 0 || row == self.size - 1 {
                include(a[0]);
                continue;
            }
            let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            if b[1] < bottom || a[1] > top {
                continue;
            }
            let slope = (b[0] - a[0]) / (b[1] - a[1]);
            let at = |y: f64, end: [f64; 2]| {
                let x = a[0] + (y - a[1]) * slope;
                if x.is_finite() { x } else { end[0] }
            };
            include(if a[1] >= bottom { a[0] } else { at(bottom, a) });
            include(if b[1] <= top { b[0] } else { at(top, b) });
        }
        let left = self.coordinate(low, 0).saturating_sub(1);
        let right = (self.coordinate(high, 0) + 1).min(self.size - 1);
        (left.min(right), right)
    }
}
