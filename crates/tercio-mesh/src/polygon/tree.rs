//! The corners that an ear must not contain, in a k-d tree: for polygons of many corners.
//!
//! A grid is fast where corners are spread evenly. Where they crowd in a few cells (combs with long teeth, many
//! corners at one position) every query of such a cell costs as much as the polygon has corners. A query of the tree
//! visits only the parts that the triangle's border crosses, wherever the corners are.

use super::Demand;
use super::plane::orient;

/// Most positions in a leaf.
const LEAF: usize = 16;

/// Distinct positions with the number of blockers at each.
#[derive(Default)]
pub(super) struct Tree {
    /// The positions, leaf after leaf.
    points: Vec<[f64; 2]>,
    /// Number of blockers at each position.
    blocker_count: Vec<u32>,
    /// Index in `points` of each corner.
    places: Vec<u32>,
    /// The root, then the children of node `i` at `2 i + 1` and `2 i + 2`.
    nodes: Vec<Node>,
    order: Vec<u32>,
}

struct Node {
    min: [f64; 2],
    max: [f64; 2],
    /// Number of blockers in it.
    blocker_count: u32,
    /// Its range of `points`.
    first: u32,
    end: u32,
}

impl Node {
    fn middle(&self) -> u32 {
        self.first + (self.end - self.first) / 2
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        (0..2).all(|k| self.min[k] <= p[k] && p[k] <= self.max[k])
    }
}

impl Tree {
    /// Takes the corners of a new polygon; none of them is a blocker yet.
    pub(super) fn fill(&mut self, corners: &[[f64; 2]]) {
        let Self { points, blocker_count, places, nodes, order } = self;
        let at = |i: u32| corners[i as usize];
        order.clear();
        order.extend(0..corners.len() as u32);
        order.sort_unstable_by(|&a, &b| {
            let ([a, b], [c, d]) = (at(a), at(b));
            a.total_cmp(&c).then(b.total_cmp(&d))
        });
        // One entry per position: corners at the same position are tested together.
        places.clear();
        places.resize(corners.len(), 0);
        points.clear();
        for &i in &*order {
            if points.last() != Some(&at(i)) {
                points.push(at(i));
            }
            places[i as usize] = points.len() as u32 - 1;
        }
        blocker_count.clear();
        blocker_count.resize(points.len(), 0);

        let levels = points.len().div_ceil(LEAF).next_power_of_two().ilog2();
        order.clear();
        order.extend(0..points.len() as u32);
        nodes.clear();
        nodes.reserve((2 << levels) - 1);
        for i in 0..(2usize << levels) - 1 {
            let (first, end) = match i.checked_sub(1).map(|up| &nodes[up / 2]) {
                None => (0, points.len() as u32),
                Some(above) if i % 2 == 1 => (above.first, above.middle()),
                Some(above) => (above.middle(), above.end),
            };
            let here = &mut order[first as usize..end as usize];
            let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            for p in here.iter().map(|&i| points[i as usize]) {
                min = std::array::from_fn(|k| min[k].min(p[k]));
                max = std::array::from_fn(|k| max[k].max(p[k]));
            }
            let node = Node { min, max, blocker_count: 0, first, end };
            // Halves the children's ranges along the longer side.
            let along = usize::from(max[1] - min[1] > max[0] - min[0]);
            let half = (node.middle() - first) as usize;
            if half > 0 {
                here.select_nth_unstable_by(half, |&a, &b| {
                    points[a as usize][along].total_cmp(&points[b as usize][along])
                });
            }
            nodes.push(node);
        }
        // From indices in the sorted order to indices in the leaves.
        let old = std::mem::take(points);
        points.extend(order.iter().map(|&i| old[i as usize]));
        let mut moved = vec![0; old.len()];
        (0..).zip(&*order).for_each(|(to, &from)| moved[from as usize] = to);
        places.iter_mut().for_each(|p| *p = moved[*p as usize]);
    }

    /// Marks a corner as a blocker, or unmarks it.
    pub(super) fn set(&mut self, corner: u32, blocks: bool) {
        let place = self.places[corner as usize];
        let change = |n: &mut u32| *n = if blocks { *n + 1 } else { n.saturating_sub(1) };
        change(&mut self.blocker_count[place as usize]);
        let mut node = 0;
        while let Some(here) = self.nodes.get_mut(node) {
            change(&mut here.blocker_count);
            node = 2 * node + if place < here.middle() { 1 } else { 2 };
        }
    }

    /// Whether a triangle contains one of the blockers; `point_tests` counts the visited parts of the tree.
    pub(super) fn contains_blocker(
        &self,
        triangle: [[f64; 2]; 3],
        demand: Demand,
        point_tests: &mut u64,
    ) -> bool {
        let leaves = self.nodes.len() / 2;
        let query = Query::new(triangle, demand);
        // Each level leaves one sibling on the stack.
        let mut stack = [0u32; 40];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let i = stack[count] as usize;
            let node = &self.nodes[i];
            if node.blocker_count == 0 {
                continue;
            }
            *point_tests += 1;
            match query.at(node) {
                Overlap::None => {}
                Overlap::Whole => return true,
                Overlap::Part if i < leaves => {
                    stack[count] = 2 * i as u32 + 2;
                    stack[count + 1] = 2 * i as u32 + 1;
                    count += 2;
                }
                Overlap::Part => {
                    let stretch = node.first as usize..node.end as usize;
                    let mut here = self.points[stretch.clone()].iter().zip(&self.blocker_count[stretch]);
                    if here.any(|(&q, &count)| count > 0 && demand.contains_blocker(triangle, q)) {
                        return true;
                    }
                }
            }
        }
        false
    }
}

enum Overlap {
    /// The triangle contains no point of the box.
    None,
    Part,
    /// Every point of the box does.
    Whole,
}

/// A triangle that boxes are tested against.
struct Query {
    triangle: [[f64; 2]; 3],
    demand: Demand,
    min: [f64; 2],
    max: [f64; 2],
}

impl Query {
    fn new(triangle: [[f64; 2]; 3], demand: Demand) -> Self {
        let [a, b, c] = triangle;
        let min = std::array::from_fn(|k| a[k].min(b[k]).min(c[k]));
        let max = std::array::from_fn(|k| a[k].max(b[k]).max(c[k]));
        Self { triangle, demand, min, max }
    }

    /// Rounding is monotone, so the value of `orient` at any point of a box is between those at two of its corners:
    /// what is shown for a box holds for its points without a margin.
    #[inline]
    fn at(&self, node: &Node) -> Overlap {
        if (0..2).any(|k| node.max[k] < self.min[k] || node.min[k] > self.max[k]) {
            return Overlap::None;
        }
        let [a, b, c] = self.triangle;
        let mut whole = true;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (x, y) = (q[0] - p[0], q[1] - p[1]);
            let (low_x, high_x) =
                if y > 0.0 { (node.max[0], node.min[0]) } else { (node.min[0], node.max[0]) };
            let (low_y, high_y) =
                if x > 0.0 { (node.min[1], node.max[1]) } else { (node.max[1], node.min[1]) };
            if orient(p, q, [high_x, high_y]) < 0.0 {
                return Overlap::None;
            }
            whole &= self.demand.is_inside(orient(p, q, [low_x, low_y]));
        }
        if whole && !self.triangle.into_iter().any(|p| node.holds(p)) {
            Overlap::Whole
        } else {
            Overlap::Part
        }
    }
}
