//! Polygons to triangles.
//!
//! Ear clipping (Meisters, "Polygons have ears", 1975) with a work list: when an ear is cut off, only its
//! two neighbours can become ears, because what is left lies inside what there was; so every corner is
//! tested a constant number of times. The corners that can spoil an ear stand in a uniform grid.
//!
//! Collinear corners are kept as corners of triangles that have an area wherever the polygon allows it:
//! leaving them out, as many triangulators do, would open T-junctions to the neighbours in the mesh.

/// How many looks at possible spoilers a corner of a polygon may cost on average before validity is given
/// up for an end in sight. Polygons of up to twice as many corners are never cut short.
const LOOKS_PER_CORNER: u64 = 4096;

/// Turns polygons into triangles; keeps its working memory from one polygon to the next.
#[derive(Default)]
pub struct Triangulator {
    /// The corners in the plane, turned to be counter-clockwise.
    points: Vec<[f64; 2]>,
    /// The corners not yet cut off, as a ring.
    prev: Vec<u32>,
    next: Vec<u32>,
    role: Vec<Role>,
    /// Corners to test, each once: an entry counts only if it is the corner's `latest`.
    queue: Vec<u32>,
    latest: Vec<u32>,
    grid: Grid,
    /// What the grid is made of; kept for its memory.
    members: Vec<u32>,
    /// Corners that turned reflex after the grid was made; only in polygons that cross themselves.
    late: Vec<u32>,
    /// Number of corners with [`Role::Blocker`].
    blockers: usize,
    looks_left: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Convex,
    /// Flat or reflex: may lie inside another corner's ear.
    Blocker,
    Gone,
}

/// What is asked of an ear; each step asks less, for polygons that cross or touch themselves.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd)]
enum Demand {
    /// A positive area and no other corner inside or on the edge.
    Clear,
    /// A positive area and no other corner inside.
    Touching,
    /// A positive area.
    Convex,
    Nothing,
}

impl Demand {
    fn less(self) -> Self {
        match self {
            Self::Clear => Self::Touching,
            Self::Touching => Self::Convex,
            _ => Self::Nothing,
        }
    }
}

impl Triangulator {
    /// Hands the triangles of a polygon to `emit`, as numbers of its corners, wound like the polygon.
    ///
    /// There are always exactly `corners.len() - 2` of them (none for fewer than three corners), and each
    /// keeps the cyclic order of its corners. If the polygon is simple and planar, they cover it exactly and
    /// all have a positive area. Corners that repeat their neighbour's position yield triangles without
    /// area; so may polygons that touch themselves. The triangles of polygons that cross themselves overlap.
    ///
    /// Quadrilaterals are cut along the shorter of the diagonals that lie inside. Larger polygons are
    /// projected along the coordinate axis closest to their Newell normal, which, unlike the projection along
    /// the normal itself, keeps coordinates exact and so collinear corners collinear.
    ///
    /// Time is about linear in the number of corners for polygons met in practice. Non-finite coordinates
    /// give some triangles.
    pub fn triangulate(&mut self, corners: &[[f64; 3]], mut emit: impl FnMut([usize; 3])) {
        match corners {
            [] | [_] | [_, _] => {}
            [_, _, _] => emit([0, 1, 2]),
            &[a, b, c, d] => quad([a, b, c, d]).into_iter().for_each(emit),
            _ => self.clip_ears(corners, &mut emit),
        }
    }

    fn clip_ears(&mut self, corners: &[[f64; 3]], emit: &mut impl FnMut([usize; 3])) {
        self.begin(corners);
        let mut left = corners.len();
        let mut read = 0;
        // Where the search for imperfect ears stands, and how far it has come since the last one.
        let (mut cursor, mut fruitless) = (0u32, 0);
        let mut demand = Demand::Clear;

        while left > 2 {
            let ear = if let Some(&i) = self.queue.get(read) {
                read += 1;
                if self.latest[i as usize] as usize != read - 1 || !self.is_ear(i, Demand::Clear) {
                    continue;
                }
                i
            } else {
                // No perfect ear is left, so the polygon is not simple (or rounding made it so).
                if demand < Demand::Convex && self.looks_left == 0 {
                    demand = Demand::Convex;
                }
                if fruitless > left {
                    demand = demand.less();
                    fruitless = 0;
                }
                let i = cursor;
                cursor = self.next[i as usize];
                fruitless += 1;
                if !self.is_ear(i, demand) {
                    continue;
                }
                fruitless = 0;
                i
            };

            let (p, n) = (self.prev[ear as usize], self.next[ear as usize]);
            emit([p as usize, ear as usize, n as usize]);
            left -= 1;
            self.remove(ear);
            if cursor == ear {
                cursor = n;
            }
            for i in [p, n] {
                self.update_role(i);
                self.latest[i as usize] = self.queue.len() as u32;
                self.queue.push(i);
            }
        }
    }

    /// Projects the corners and fills the work list.
    fn begin(&mut self, corners: &[[f64; 3]]) {
        let n = corners.len();
        let count = u32::try_from(n).expect("a polygon's corners are numbered in 32 bits");
        let normal = newell_normal(corners);
        let [x, y] = projection_axes(corners, normal);
        let first = corners[0];
        self.points.clear();
        self.points.extend(corners.iter().map(|c| [c[x] - first[x], c[y] - first[y]]));

        self.prev.clear();
        self.prev.extend((0..count).map(|i| if i == 0 { count - 1 } else { i - 1 }));
        self.next.clear();
        self.next.extend((0..count).map(|i| if i + 1 == count { 0 } else { i + 1 }));
        self.queue.clear();
        self.queue.extend(0..count);
        self.latest.clear();
        self.latest.extend(0..count);
        self.late.clear();
        self.looks_left = LOOKS_PER_CORNER * n as u64;
        self.role.clear();
        self.role.resize(n, Role::Convex);
        self.blockers = 0;
        for i in 0..n {
            if !self.turns_left(i) {
                self.role[i] = Role::Blocker;
                self.blockers += 1;
            }
        }
        self.grid.clear();
        if self.blockers > 0 {
            self.rebuild_grid(0);
        }
    }

    fn turns_left(&self, i: usize) -> bool {
        let (p, n) = (self.prev[i] as usize, self.next[i] as usize);
        orient(self.points[p], self.points[i], self.points[n]) > 0.0
    }

    fn update_role(&mut self, i: u32) {
        let now = if self.turns_left(i as usize) { Role::Convex } else { Role::Blocker };
        let role = &mut self.role[i as usize];
        match (*role, now) {
            (Role::Blocker, Role::Convex) => self.blockers -= 1,
            (Role::Convex, Role::Blocker) => {
                self.blockers += 1;
                self.late.push(i);
            }
            _ => {}
        }
        *role = now;
    }

    fn remove(&mut self, i: u32) {
        let (p, n) = (self.prev[i as usize], self.next[i as usize]);
        self.next[p as usize] = n;
        self.prev[n as usize] = p;
        if self.role[i as usize] == Role::Blocker {
            self.blockers -= 1;
        }
        self.role[i as usize] = Role::Gone;
    }

    /// The grid gets coarser as the polygon gets simpler: late ears are large and would meet many cells.
    fn rebuild_grid(&mut self, any_left: u32) {
        self.late.clear();
        self.members.clear();
        let mut i = any_left;
        loop {
            if self.role[i as usize] == Role::Blocker {
                self.members.push(i);
            }
            i = self.next[i as usize];
            if i == any_left {
                break;
            }
        }
        self.grid.fill(&self.points, &self.members);
    }

    fn is_ear(&mut self, i: u32, demand: Demand) -> bool {
        let (p, n) = (self.prev[i as usize], self.next[i as usize]);
        let [a, b, c] = [p, i, n].map(|k| self.points[k as usize]);
        // A repeated corner or a spike without width is best got rid of before it stands in anyone's way.
        if a == b || b == c || a == c || demand == Demand::Nothing {
            return true;
        }
        if self.role[i as usize] != Role::Convex {
            return false;
        }
        if self.blockers == 0 || demand == Demand::Convex {
            return true;
        }
        if self.looks_left == 0 {
            return false;
        }
        if self.blockers * 2 < self.grid.filled || self.late.len() > 32 {
            self.rebuild_grid(i);
        }

        let (points, role) = (&self.points, &self.role);
        let mut looks = 0;
        let mut blocks = |w: u32| {
            looks += 1;
            if role[w as usize] != Role::Blocker {
                return false;
            }
            let q = points[w as usize];
            let sides = [orient(a, b, q), orient(b, c, q), orient(c, a, q)];
            // Another corner at the very position of one of these three touches; it does not block.
            match demand {
                Demand::Clear => sides.iter().all(|&s| s >= 0.0) && q != a && q != b && q != c,
                _ => sides.iter().all(|&s| s > 0.0),
            }
        };
        let blocked = self.late.iter().any(|&w| blocks(w)) || self.grid.any_near([a, b, c], &mut blocks);
        self.looks_left = self.looks_left.saturating_sub(looks);
        !blocked
    }
}

/// Twice the signed area of a triangle, positive when counter-clockwise.
#[inline]
fn orient(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Twice the polygon's vector area (Newell), taken round the first corner so that polygons far from zero
/// keep their digits.
fn newell_normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let o = corners[0];
    corners.windows(2).skip(1).fold([0.0; 3], |sum, w| {
        let c = cross(sub(w[0], o), sub(w[1], o));
        [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]]
    })
}

/// The two coordinates to keep, in the order that makes the polygon counter-clockwise.
fn projection_axes(corners: &[[f64; 3]], normal: [f64; 3]) -> [usize; 2] {
    let mut weight = normal.map(f64::abs);
    if !weight.iter().any(|&w| w > 0.0) {
        // No area: look along the direction in which the polygon is thinnest.
        weight = std::array::from_fn(|k| {
            let (lo, hi) = corners
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c[k]), h.max(c[k])));
            lo - hi
        });
    }
    let drop = (1..3).fold(0, |best, k| if weight[k] > weight[best] { k } else { best });
    let (x, y) = ((drop + 1) % 3, (drop + 2) % 3);
    if normal[drop] < 0.0 { [y, x] } else { [x, y] }
}

fn quad([a, b, c, d]: [[f64; 3]; 4]) -> [[usize; 3]; 2] {
    let (ac, bd) = (sub(c, a), sub(d, b));
    let normal = cross(ac, bd);
    let faces_out = |p, q, r| dot(cross(sub(q, p), sub(r, p)), normal) > 0.0;
    let ac_inside = faces_out(a, b, c) && faces_out(a, c, d);
    let bd_inside = faces_out(a, b, d) && faces_out(b, c, d);
    let cut_ac = if ac_inside == bd_inside { dot(ac, ac) <= dot(bd, bd) } else { ac_inside };
    if cut_ac { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] }
}

/// Points in the cells of a uniform grid, about one a cell.
#[derive(Default)]
struct Grid {
    min: [f64; 2],
    /// Cells per unit of length.
    scale: [f64; 2],
    cells: [usize; 2],
    /// Where each cell's points begin in `items`; one more entry than cells.
    starts: Vec<u32>,
    items: Vec<u32>,
    filled: usize,
}

impl Grid {
    fn clear(&mut self) {
        self.cells = [0, 0];
        self.filled = 0;
    }

    fn cell_of(&self, p: [f64; 2]) -> usize {
        let at = |k: usize| (((p[k] - self.min[k]) * self.scale[k]) as usize).min(self.cells[k] - 1);
        at(1) * self.cells[0] + at(0)
    }

    fn fill(&mut self, points: &[[f64; 2]], members: &[u32]) {
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
        // Square cells, but at least one a direction and not more than points in all.
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

    /// Whether `test` holds for any of the points in the cells that a triangle meets.
    fn any_near(&self, triangle: [[f64; 2]; 3], test: &mut impl FnMut(u32) -> bool) -> bool {
        if self.filled == 0 {
            return false;
        }
        // In units of cells, with a margin far above rounding and far below a cell.
        const MARGIN: f64 = 1e-6;
        let t =
            triangle.map(|p| [(p[0] - self.min[0]) * self.scale[0], (p[1] - self.min[1]) * self.scale[1]]);
        let range = |lo: f64, hi: f64, cells: usize| {
            let first = ((lo - MARGIN) as usize).min(cells - 1);
            // Negative numbers saturate to 0, so that a triangle beside the grid must be told apart.
            let end = if hi + MARGIN < 0.0 { 0 } else { ((hi + MARGIN) as usize).min(cells - 1) + 1 };
            // Points at the upper border stand in the last cell although their number is one more.
            if lo - MARGIN > cells as f64 { 0..0 } else { first..end }
        };
        let y = t.map(|p| p[1]);
        let rows = range(y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]), self.cells[1]);
        for row in rows {
            // The triangle's extent inside the row: long thin triangles meet few cells of their box.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn triangles(corners: &[[f64; 3]]) -> Vec<[usize; 3]> {
        let mut out = Vec::new();
        Triangulator::default().triangulate(corners, |t| out.push(t));
        out
    }

    fn flat(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
        points.iter().map(|p| [p[0], p[1], 0.0]).collect()
    }

    fn area(corners: &[[f64; 3]], t: [usize; 3], unit: [f64; 3]) -> f64 {
        let [a, b, c] = t.map(|i| corners[i]);
        0.5 * dot(cross(sub(b, a), sub(c, a)), unit)
    }

    /// n - 2 triangles, all facing the polygon's way, of the polygon's area in all.
    fn check(corners: &[[f64; 3]], tolerance: f64) -> Result<(), TestCaseError> {
        let list = triangles(corners);
        prop_assert_eq!(list.len(), corners.len() - 2);
        let n = newell_normal(corners);
        let length = dot(n, n).sqrt();
        let unit = n.map(|x| x / length);
        let areas: Vec<f64> = list.iter().map(|&t| area(corners, t, unit)).collect();
        for (t, &a) in list.iter().zip(&areas) {
            prop_assert!(a > -tolerance * length, "{:?} has area {}", t, a);
        }
        let sum: f64 = areas.iter().sum();
        prop_assert!((sum - 0.5 * length).abs() <= 1e-9 * length, "{} != {}", sum, 0.5 * length);
        Ok(())
    }

    fn lift(points: &[[f64; 2]], u: [f64; 3], v: [f64; 3], o: [f64; 3]) -> Vec<[f64; 3]> {
        points.iter().map(|p| std::array::from_fn(|k| o[k] + u[k] * p[0] + v[k] * p[1])).collect()
    }

    fn star(radii: &[f64]) -> Vec<[f64; 2]> {
        let turn = std::f64::consts::TAU / radii.len() as f64;
        radii
            .iter()
            .enumerate()
            .map(|(i, r)| [r * (i as f64 * turn).cos(), r * (i as f64 * turn).sin()])
            .collect()
    }

    /// Teeth along the x axis with a collinear run below them.
    fn comb(heights: &[f64], below: usize) -> Vec<[f64; 2]> {
        let width = heights.len() as f64;
        let mut p: Vec<_> = (0..=below).map(|i| [width * i as f64 / below as f64, 0.0]).collect();
        for (i, h) in heights.iter().enumerate().rev() {
            p.extend([[i as f64 + 1.0, 1.0], [i as f64 + 0.5, 1.0 + h]]);
        }
        p.push([0.0, 1.0]);
        p
    }

    proptest! {
        #[test]
        fn stars_are_covered(
            radii in prop::collection::vec(0.05f64..1.0, 5..200),
            u in prop::array::uniform3(-1f64..1.0), v in prop::array::uniform3(-1f64..1.0),
            o in prop::array::uniform3(-10f64..10.0), backwards: bool,
        ) {
            let n = cross(u, v);
            prop_assume!(dot(n, n) > 1e-2);
            let mut p = star(&radii);
            check(&flat(&p), 0.0)?;
            if backwards {
                p.reverse();
            }
            check(&lift(&p, u, v, o), 1e-12)?;
        }

        #[test]
        fn combs_are_covered(
            heights in prop::collection::vec(0.01f64..100.0, 2..60), below in 1usize..40,
            u in prop::array::uniform3(-1f64..1.0), v in prop::array::uniform3(-1f64..1.0),
        ) {
            let n = cross(u, v);
            prop_assume!(dot(n, n) > 1e-2);
            let p = comb(&heights, below);
            check(&flat(&p), 0.0)?;
            check(&lift(&p, u, v, [0.0; 3]), 1e-12)?;
        }

        #[test]
        fn anything_ends_with_two_triangles_fewer_than_corners(
            p in prop::collection::vec(prop::array::uniform3(prop_oneof![
                (0i8..4).prop_map(f64::from), Just(f64::NAN), Just(f64::INFINITY), -1f64..1.0,
            ]), 3..60),
            finite in prop::collection::vec(prop::array::uniform3((0i8..3).prop_map(f64::from)), 3..200),
        ) {
            for p in [p, finite] {
                let list = triangles(&p);
                prop_assert_eq!(list.len(), p.len() - 2);
                for t in list {
                    // Increasing up to rotation: the order of the ring.
                    let falls = (0..3).filter(|&k| t[k] > t[(k + 1) % 3]).count();
                    prop_assert_eq!(falls, 1);
                }
            }
        }
    }

    #[test]
    fn quads_are_cut_inside_and_short() {
        // Convex, diagonal 1-3 shorter.
        assert_eq!(triangles(&flat(&[[-3., 0.], [0., -1.], [3., 0.], [0., 1.]])), [[0, 1, 3], [1, 2, 3]]);
        // A dart, reflex at each corner in turn.
        let dart = [[0., 0.], [1., -2.], [0., 3.], [-1., -2.]];
        for turn in 0..4 {
            let mut p = dart;
            p.rotate_left(turn);
            check(&flat(&p), 0.0).unwrap();
        }
        // A triangle with a corner more on an edge keeps its two real triangles.
        for turn in 0..4 {
            let mut p = [[0., 0.], [1., 0.], [2., 0.], [0., 2.]];
            p.rotate_left(turn);
            let p = flat(&p);
            assert!(triangles(&p).iter().all(|&t| area(&p, t, [0., 0., 1.]) > 0.0));
        }
    }

    #[test]
    fn a_square_with_a_run_on_each_side_has_no_flat_triangle() {
        let mut p = Vec::new();
        for k in 0..10 {
            p.push([k as f64, 0.]);
        }
        for k in 0..10 {
            p.push([10., k as f64]);
        }
        for k in 0..10 {
            p.push([10. - k as f64, 10.]);
        }
        for k in 0..10 {
            p.push([0., 10. - k as f64]);
        }
        let p = flat(&p);
        assert!(triangles(&p).iter().all(|&t| area(&p, t, [0., 0., 1.]) > 0.0));
        check(&p, 0.0).unwrap();
    }

    #[test]
    fn a_hole_reached_by_a_bridge_stays_open() {
        // Outer square, bridge to the inner one and back: positions of the bridge stand twice.
        let p = [
            [0., 0.],
            [4., 0.],
            [4., 4.],
            [0., 4.],
            [0., 0.],
            [1., 1.],
            [1., 3.],
            [3., 3.],
            [3., 1.],
            [1., 1.],
        ];
        for turn in 0..p.len() {
            let mut p = p;
            p.rotate_left(turn);
            let p = flat(&p);
            check(&p, 0.0).unwrap();
            let sum: f64 = triangles(&p).iter().map(|&t| area(&p, t, [0., 0., 1.])).sum();
            assert_eq!(sum, 12.0);
        }
    }

    #[test]
    fn repeated_corners_cost_only_flat_triangles() {
        let p = flat(&[[0., 0.], [2., 0.], [2., 0.], [2., 2.], [1., 0.5], [1., 0.5], [0., 2.], [0., 0.]]);
        check(&p, 1e-300).unwrap();
        let flat_ones = triangles(&p).iter().filter(|&&t| area(&p, t, [0., 0., 1.]) == 0.0).count();
        assert_eq!(flat_ones, 3);
    }

    #[test]
    fn polygons_of_a_hundred_thousand_corners_do_not_hang() {
        let mut noise = 1u32;
        let mut random = || {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(noise >> 8) / f64::from(1 << 24)
        };
        let n = 100_000;
        let radii: Vec<f64> = (0..n).map(|_| 0.1 + 0.9 * random()).collect();
        check(&flat(&star(&radii)), 1e-12).unwrap();
        let heights: Vec<f64> = (0..n / 2).map(|_| 1.0 + 1e5 * random()).collect();
        check(&lift(&comb(&heights, 10), [1., 1., 0.], [-1., 1., 0.], [0.; 3]), 1e-12).unwrap();
        // A spiral has two ears at any time.
        let half = n / 2;
        let arm = |i: usize, r: f64| {
            let t = i as f64 * 0.02;
            [(t + r) * t.cos(), (t + r) * t.sin()]
        };
        let spiral: Vec<_> =
            (0..half).map(|i| arm(i, 2.0)).chain((0..half).rev().map(|i| arm(i, 0.0))).collect();
        check(&flat(&spiral), 1e-12).unwrap();
        // Nonsense, crossing itself everywhere.
        let mess: Vec<_> = (0..n).map(|_| [random(), random(), random()]).collect();
        assert_eq!(triangles(&mess).len(), n - 2);
        assert_eq!(triangles(&vec![[1.0; 3]; n]).len(), n - 2);
        let line: Vec<_> = (0..n).map(|_| [random(), 0.0, 0.0]).collect();
        assert_eq!(triangles(&line).len(), n - 2);
    }
}
