//! Polygon triangulation.
//!
//! Ear clipping (Meisters, "Polygons have ears", 1975) with a work list: when an ear is cut off, only its two
//! neighbours can become ears, because the remaining polygon is inside the previous one; so every corner is tested a
//! constant number of times. The corners that an ear must not contain are kept in a uniform grid, or, for polygons
//! whose corners crowd in few cells of the grid, in a tree, which gives the same answers.
//!
//! Collinear corners are kept as corners of triangles with an area wherever the polygon allows it: omitting them, as
//! many triangulators do, would open T-junctions to the neighbours in the mesh.

mod grid;
mod plane;
mod tree;

use grid::Grid;
use plane::{newell_normal, orient, projection_axes, quad};
use tree::Tree;

/// Polygons of this many corners may have a tree in place of the grid, and the work on them is counted step by step.
const MANY: usize = 512;

/// They get it once the number of tests of points and grid rows reaches this many per corner.
const GRID_TESTS_PER_CORNER: u64 = 24;

/// How many tests of points a corner of a polygon may cost on average before termination takes precedence over
/// validity. Polygons of up to twice as many corners are never affected.
const POINT_TESTS_PER_CORNER: u64 = 4096;

/// The same for steps from corner to corner in search of imperfect ears, in polygons of [`MANY`] corners or more.
/// Steps over corners that are not convex need no test of a point.
const STEPS_PER_CORNER: u64 = 64;

/// Triangulates polygons; keeps its working memory from one polygon to the next.
#[derive(Default)]
pub struct Triangulator {
    /// The corners projected to the plane, counter-clockwise.
    points: Vec<[f64; 2]>,
    /// The corners not yet cut off, as a ring.
    prev: Vec<u32>,
    next: Vec<u32>,
    role: Vec<Role>,
    /// Corners to test, each once: an entry is valid only if it is the corner's `latest`.
    queue: Vec<u32>,
    latest: Vec<u32>,
    grid: Grid,
    tree: Tree,
    has_tree: bool,
    /// Tests of points and rows of cells that remain before a tree is built.
    grid_tests_left: u64,
    /// The points of the grid; kept for its memory.
    members: Vec<u32>,
    /// Corners that became reflex after the grid was made; only in polygons that cross themselves.
    new_reflex: Vec<u32>,
    /// Number of corners with [`Role::Blocker`].
    blockers: usize,
    point_tests_left: u64,
    /// Has so many corners that steps around the ring are counted.
    is_large: bool,
    steps_left: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Convex,
    /// Flat or reflex: may be inside another corner's ear.
    Blocker,
    Gone,
}

/// Requirements for an ear; they are relaxed step by step for polygons that cross or touch themselves.
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
    fn relaxed(self) -> Self {
        match self {
            Self::Clear => Self::Touching,
            Self::Touching => Self::Convex,
            _ => Self::Nothing,
        }
    }

    /// Is a point at this distance from an edge (positive to the left) on the triangle's side of it?
    #[inline]
    fn is_inside(self, side: f64) -> bool {
        if self == Self::Clear { side >= 0.0 } else { side > 0.0 }
    }

    /// Does the ear contain a blocker at this position? Another corner at exactly the position of one of these three
    /// touches the ear; it is not inside.
    #[inline]
    fn contains_blocker(self, [a, b, c]: [[f64; 2]; 3], q: [f64; 2]) -> bool {
        let sides = [orient(a, b, q), orient(b, c, q), orient(c, a, q)];
        match self {
            Self::Clear => sides.iter().all(|&s| s >= 0.0) && q != a && q != b && q != c,
            _ => sides.iter().all(|&s| s > 0.0),
        }
    }
}

impl Triangulator {
    /// Passes the triangles of a polygon to `emit`, as indices of its corners, with the winding of the polygon.
    ///
    /// There are always exactly `corners.len() - 2` of them (none for fewer than three corners), and each
    /// keeps the cyclic order of its corners. If the polygon is simple and planar, they cover it exactly and
    /// all have a positive area. Corners that repeat their neighbour's position yield triangles without
    /// area; so may polygons that touch themselves. The triangles of polygons that cross themselves overlap.
    ///
    /// Quadrilaterals are split along the shorter of the diagonals that are inside. Larger polygons are projected
    /// along the coordinate axis closest to their Newell normal, which, unlike a projection along the normal itself,
    /// keeps coordinates exact and so collinear corners collinear.
    ///
    /// Time is linear in the number of corners except for a logarithm. Some polygons that cross themselves would take
    /// longer; some of their triangles are cut off without testing what is inside. Non-finite coordinates give
    /// arbitrary triangles.
    pub fn triangulate(&mut self, corners: &[[f64; 3]], mut emit: impl FnMut([usize; 3])) {
        match corners {
            [] | [_] | [_, _] => {}
            [_, _, _] => emit([0, 1, 2]),
            &[a, b, c, d] => quad([a, b, c, d]).into_iter().for_each(emit),
            _ => {
                self.begin(corners, MANY);
                self.cut(corners.len(), &mut emit);
            }
        }
    }

    /// Splits the remaining `left` corners into triangles.
    fn cut(&mut self, mut left: usize, emit: &mut impl FnMut([usize; 3])) {
        let mut read = 0;
        // Position of the search for imperfect ears, and the number of steps since the last one was found.
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
                // No perfect ear is left, so the polygon is not simple (or not so after rounding).
                if demand < Demand::Convex && self.point_tests_left == 0 {
                    demand = Demand::Convex;
                }
                if fruitless > left {
                    demand = demand.relaxed();
                    fruitless = 0;
                }
                if self.is_large {
                    self.steps_left = self.steps_left.saturating_sub(1);
                    if self.steps_left == 0 {
                        demand = Demand::Nothing;
                    }
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
            if self.is_large && demand > Demand::Clear {
                // Continue near the corner that has just changed, not all the way around the ring.
                cursor = p;
            }
            for i in [p, n] {
                self.update_role(i);
                self.latest[i as usize] = self.queue.len() as u32;
                self.queue.push(i);
            }
        }
    }

    /// Projects the corners and fills the work list.
    fn begin(&mut self, corners: &[[f64; 3]], many: usize) {
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
        self.new_reflex.clear();
        self.point_tests_left = POINT_TESTS_PER_CORNER * n as u64;
        self.is_large = n >= many;
        self.steps_left = STEPS_PER_CORNER * n as u64;
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
        self.has_tree = false;
        self.grid_tests_left = if n < many { u64::MAX } else { GRID_TESTS_PER_CORNER * n as u64 };
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
        let before = std::mem::replace(role, now);
        match (before, now) {
            (Role::Blocker, Role::Convex) => self.blockers -= 1,
            (Role::Convex, Role::Blocker) => {
                self.blockers += 1;
                if !self.has_tree {
                    self.new_reflex.push(i);
                }
            }
            _ => return,
        }
        if self.has_tree {
            self.tree.set(i, now == Role::Blocker);
        }
    }

    fn remove(&mut self, i: u32) {
        let (p, n) = (self.prev[i as usize], self.next[i as usize]);
        self.next[p as usize] = n;
        self.prev[n as usize] = p;
        if self.role[i as usize] == Role::Blocker {
            self.blockers -= 1;
            if self.has_tree {
                self.tree.set(i, false);
            }
        }
        self.role[i as usize] = Role::Gone;
    }

    /// The grid gets coarser as the polygon gets simpler: late ears are large and would meet many cells.
    fn rebuild_grid(&mut self, any_left: u32) {
        self.new_reflex.clear();
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
        self.grid_tests_left = self.grid_tests_left.saturating_sub(self.members.len() as u64);
    }

    fn build_tree(&mut self) {
        self.tree.fill(&self.points);
        for (i, _) in (0..).zip(&self.role).filter(|(_, role)| **role == Role::Blocker) {
            self.tree.set(i, true);
        }
        self.has_tree = true;
        self.new_reflex.clear();
    }

    fn is_ear(&mut self, i: u32, demand: Demand) -> bool {
        let (p, n) = (self.prev[i as usize], self.next[i as usize]);
        let [a, b, c] = [p, i, n].map(|k| self.points[k as usize]);
        // Repeated corners and spikes without width are best removed before they block other ears.
        if a == b || b == c || a == c || demand == Demand::Nothing {
            return true;
        }
        if self.role[i as usize] != Role::Convex {
            return false;
        }
        if self.blockers == 0 || demand == Demand::Convex {
            return true;
        }
        if self.point_tests_left == 0 {
            return false;
        }
        if !self.has_tree && self.grid_tests_left == 0 {
            self.build_tree();
        }
        let (mut point_tests, mut rows) = (0, 0);
        let blocked = if self.has_tree {
            self.tree.contains_blocker([a, b, c], demand, &mut point_tests)
        } else {
            if self.blockers * 2 < self.grid.filled || self.new_reflex.len() > 32 {
                self.rebuild_grid(i);
            }
            let (points, role) = (&self.points, &self.role);
            let mut blocks = |w: u32| {
                point_tests += 1;
                role[w as usize] == Role::Blocker && demand.contains_blocker([a, b, c], points[w as usize])
            };
            self.new_reflex.iter().any(|&w| blocks(w))
                || self.grid.any_near([a, b, c], &mut rows, &mut blocks)
        };
        self.grid_tests_left = self.grid_tests_left.saturating_sub(point_tests + rows);
        self.point_tests_left = self.point_tests_left.saturating_sub(point_tests);
        !blocked
    }
}

#[cfg(test)]
mod tests;
