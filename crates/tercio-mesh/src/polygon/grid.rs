//! The corners that an ear must not contain, in a uniform grid: for polygons of usual sizes.

/// Points in the cells of a uniform grid, about one per cell.
#[derive(Default)]
pub(super) struct Grid {
    min: [f64; 2],
    /// Cells per unit of length.
    scale: [f64; 2],
    cells: [usize; 2],
    /// Where each cell's points begin in `items`, plus one end entry.
    starts: Vec<u32>,
    items: Vec<u32>,
    /// Number of points.
    pub(super) filled: usize,
}

impl Grid {
    pub(super) fn clear(&mut self) {
        self.cells = [0, 0];
        self.filled = 0;
    }

    fn cell_of(&self, p: [f64; 2]) -> usize {
        let at = |k: usize| (((p[k] - self.min[k]) * self.scale[k]) as usize).min(self.cells[k] - 1);
        at(1) * self.cells[0] + at(0)
    }

    pub(super) fn fill(&mut self, points: &[[f64; 2]], members: &[u32]) {
        let mut max = [f64::NEG_INFINITY; 2];
        self.min = [f64::INFINITY; 2];
        for &m in members {
            let p = points[m as usize];
            for k in 0..2 {
                self.min[k] = self.min[k].min(p[k]);
                max[k] = max[k].max(p[k]);
            }
        }
        let size = [max[0] - self.min[0], max[1] - self.min[1]];
        // Square cells, but at least one per direction and at most as many as points in total.
        let count = members.len().max(1) as f64;
        let across = (count * size[0] / size[1]).sqrt();
        let nx = if across.is_finite() { across.clamp(1.0, count) } else { count };
        let ny = (count / nx).clamp(1.0, count);
        self.cells = if members.len() <= 16 { [1, 1] } else { [nx as usize, ny as usize] };
        self.scale = std::array::from_fn(|k| {
            let s = self.cells[k] as f64 / size[k];
            if s.is_finite() { s } else { 0.0 }
        });

        // Counting sort by cell.
        self.starts.clear();
        self.starts.resize(self.cells[0] * self.cells[1] + 1, 0);
        for &m in members {
            let cell = self.cell_of(points[m as usize]);
            self.starts[cell] += 1;
        }
        let mut sum = 0;
        for s in &mut self.starts {
            sum += *s;
            *s = sum;
        }
        self.items.clear();
        self.items.resize(members.len(), 0);
        for &m in members.iter().rev() {
            let cell = self.cell_of(points[m as usize]);
            self.starts[cell] -= 1;
            self.items[self.starts[cell] as usize] = m;
        }
        self.filled = members.len();
    }

    /// Whether `test` is true for any of the points in the cells that a triangle meets; counts the visited `rows` of
    /// cells.
    pub(super) fn any_near(
        &self,
        triangle: [[f64; 2]; 3],
        rows_met: &mut u64,
        test: &mut impl FnMut(u32) -> bool,
    ) -> bool {
        if self.filled == 0 {
            return false;
        }
        // In units of cells, with a margin much larger than rounding errors and much smaller than a cell.
        const MARGIN: f64 = 1e-6;
        let t =
            triangle.map(|p| [(p[0] - self.min[0]) * self.scale[0], (p[1] - self.min[1]) * self.scale[1]]);
        let range = |lo: f64, hi: f64, cells: usize| {
            let first = ((lo - MARGIN) as usize).min(cells - 1);
            // Negative numbers saturate to 0, so a triangle outside the grid needs a test of its own.
            let end = if hi + MARGIN < 0.0 { 0 } else { ((hi + MARGIN) as usize).min(cells - 1) + 1 };
            // Points at the upper border are in the last cell although their cell index is one more.
            if lo - MARGIN > cells as f64 { 0..0 } else { first..end }
        };
        let y = t.map(|p| p[1]);
        let rows = range(y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]), self.cells[1]);
        for row in rows {
            *rows_met += 1;
            // The triangle's extent in the row: long thin triangles meet few cells of their box.
            let last = row + 1 == self.cells[1];
            let (bottom, top) =
                (row as f64 - MARGIN, if last { f64::INFINITY } else { (row + 1) as f64 + MARGIN });
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in 0..3 {
                let (p, q) = (t[k], t[(k + 1) % 3]);
                let (p, q) = if p[1] <= q[1] { (p, q) } else { (q, p) };
                if q[1] < bottom || p[1] > top {
                    continue;
                }
                let x_at = |y: f64| p[0] + (q[0] - p[0]) * ((y - p[1]) / (q[1] - p[1]));
                let x0 = if p[1] < bottom { x_at(bottom) } else { p[0] };
                let x1 = if q[1] > top { x_at(top) } else { q[0] };
                lo = lo.min(x0).min(x1);
                hi = hi.max(x0).max(x1);
            }
            let columns = range(lo, hi, self.cells[0]);
            if columns.is_empty() {
                continue;
            }
            let first = row * self.cells[0];
            let items =
                self.starts[first + columns.start] as usize..self.starts[first + columns.end] as usize;
            if self.items[items].iter().any(|&i| test(i)) {
                return true;
            }
        }
        false
    }
}
