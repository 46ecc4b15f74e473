//! A plain ray caster in `f64`: what a renderer should draw, from code that shares nothing with it.
//!
//! Triangles are two-sided. A bounding volume hierarchy makes models of a hundred thousand triangles affordable;
//! nothing else is done for speed.

/// A point or a direction.
pub type Vec3 = [f64; 3];

/// Triangles to intersect with rays.
#[derive(Debug)]
pub struct RayCaster {
    corners: Vec<[Vec3; 3]>,
    /// Triangle numbers, ordered by leaf.
    order: Vec<usize>,
    nodes: Vec<Node>,
}

/// Intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Number of the triangle.
    pub triangle: usize,
    /// Distance from the ray's origin, in lengths of its direction.
    pub distance: f64,
    /// Weights of the three corners; they add up to 1.
    pub weight: [f64; 3],
}

#[derive(Debug)]
struct Node {
    min: Vec3,
    max: Vec3,
    /// Leaf: first entry of `order`. Inner node: first of its two children, which are adjacent.
    first: usize,
    /// Number of triangles of a leaf, 0 for an inner node.
    count: usize,
}

/// Maximum number of triangles of a leaf.
const LEAF: usize = 4;
/// Tolerance of the hit test outside the edges, as a weight, so that rays do not slip through a shared edge.
const RIM: f64 = 1e-12;

fn minus(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl RayCaster {
    /// Builds the hierarchy; triangles keep their numbers.
    pub fn new(corners: Vec<[Vec3; 3]>) -> Self {
        let order = (0..corners.len()).collect();
        let mut caster = Self { corners, order, nodes: Vec::new() };
        caster.nodes.push(Node { min: [0.0; 3], max: [0.0; 3], first: 0, count: caster.order.len() });
        let mut open = vec![0];
        while let Some(node) = open.pop() {
            if let Some(children) = caster.split(node) {
                open.extend([children, children + 1]);
            }
        }
        caster
    }

    /// Computes the box of a node; splits it at the median triangle along its longest side if it holds many. Returns
    /// the first of two new nodes.
    fn split(&mut self, node: usize) -> Option<usize> {
        let (first, count) = (self.nodes[node].first, self.nodes[node].count);
        let corners = &self.corners;
        let own = &mut self.order[first..first + count];
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in own.iter().flat_map(|&t| corners[t]) {
            for k in 0..3 {
                min[k] = min[k].min(p[k]);
                max[k] = max[k].max(p[k]);
            }
        }
        (self.nodes[node].min, self.nodes[node].max) = (min, max);
        if count <= LEAF {
            return None;
        }
        let size = minus(max, min);
        let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let middle = |t: usize| corners[t].iter().map(|p| p[axis]).sum::<f64>();
        own.select_nth_unstable_by(count / 2, |&a, &b| middle(a).total_cmp(&middle(b)));
        let children = self.nodes.len();
        for (first, count) in [(first, count / 2), (first + count / 2, count - count / 2)] {
            self.nodes.push(Node { min, max, first, count });
        }
        (self.nodes[node].first, self.nodes[node].count) = (children, 0);
        Some(children)
    }

    /// The nearest triangle hit by a ray at a distance above `from`.
    pub fn first_hit(&self, origin: Vec3, direction: Vec3, from: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut open = vec![0];
        while let Some(node) = open.pop() {
            let node = &self.nodes[node];
            let farthest = best.map_or(f64::INFINITY, |hit| hit.distance);
            if !crosses(node, origin, direction, farthest) {
                continue;
            }
            if node.count == 0 && !self.order.is_empty() {
                open.extend([node.first, node.first + 1]);
                continue;
            }
            for &t in &self.order[node.first..node.first + node.count] {
                let hit = self
                    .meet(t, origin, direction)
                    .filter(|hit| hit.distance > from && hit.weight.iter().all(|&w| w >= -RIM));
                if let Some(hit) = hit
                    && best.is_none_or(|best| hit.distance < best.distance)
                {
                    best = Some(hit);
                }
            }
        }
        best
    }

    /// Intersection of a ray with the plane of a triangle, inside the triangle or not; `None` if they are parallel.
    pub fn meet(&self, triangle: usize, origin: Vec3, direction: Vec3) -> Option<Hit> {
        let [a, b, c] = self.corners[triangle];
        let (u, v, from_a) = (minus(b, a), minus(c, a), minus(origin, a));
        let p = cross(direction, v);
        let determinant = dot(u, p);
        if determinant == 0.0 {
            return None;
        }
        let q = cross(from_a, u);
        let (second, third) = (dot(from_a, p) / determinant, dot(direction, q) / determinant);
        let distance = dot(v, q) / determinant;
        Some(Hit { triangle, distance, weight: [1.0 - second - third, second, third] })
    }
}

/// Whether a ray enters a node's box before a distance.
fn crosses(node: &Node, origin: Vec3, direction: Vec3, farthest: f64) -> bool {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, farthest);
    for k in 0..3 {
        if direction[k] == 0.0 {
            if origin[k] < node.min[k] || origin[k] > node.max[k] {
                return false;
            }
            continue;
        }
        let at = [node.min[k], node.max[k]].map(|side| (side - origin[k]) / direction[k]);
        enter = enter.max(at[0].min(at[1]));
        leave = leave.min(at[0].max(at[1]));
    }
    // A box may be flat: a ray through its side must not miss it by a rounding error.
    enter <= leave + 1e-9 * leave.abs().min(1e300)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_many_triangles_is_hit_where_it_stands() {
        // Squares one behind the other, of two triangles each, with the diagonal from (0, 0) to (1, 1).
        let square = |z: f64| {
            let p = |x: f64, y: f64| [x, y, z];
            [[p(0., 0.), p(1., 0.), p(1., 1.)], [p(0., 0.), p(1., 1.), p(0., 1.)]]
        };
        let caster = RayCaster::new((1..40).rev().flat_map(|z| square(f64::from(z))).collect());
        let hit = caster.first_hit([0.75, 0.25, 0.0], [0.0, 0.0, 0.5], 0.0).unwrap();
        assert_eq!((hit.triangle, hit.distance), (76, 2.0));
        assert_eq!(hit.weight, [0.25, 0.5, 0.25]);
        // Behind the first one, from the other side, beside all of them.
        assert_eq!(caster.first_hit([0.25, 0.75, 0.0], [0.0, 0.0, 1.0], 1.5).unwrap().triangle, 75);
        assert_eq!(caster.first_hit([0.25, 0.75, 99.0], [0.0, 0.0, -1.0], 0.0).unwrap().triangle, 1);
        assert!(caster.first_hit([1.25, 0.75, 0.0], [0.0, 0.0, 1.0], 0.0).is_none());
        // No ray slips through the diagonal.
        assert!(caster.first_hit([0.1, 0.1, 0.0], [0.0, 0.0, 1.0], 0.0).is_some());
        assert!(RayCaster::new(Vec::new()).first_hit([0.0; 3], [1.0, 0.0, 0.0], 0.0).is_none());
    }
}
