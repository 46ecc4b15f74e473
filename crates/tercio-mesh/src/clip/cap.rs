//! The inside of closed outlines in triangles.
//!
//! A constrained Delaunay triangulation (Chew, "Constrained Delaunay Triangulations", 1989), by the library `spade`, of
//! all points of a cut and all its edges. Then every triangle has one winding number, and those inside are the cap. The
//! points of the outline are not moved, and none is added between them, so that the cap continues the surface without
//! a crack. Only where outlines cross, which they do if the surface penetrates itself, the crossing becomes a point;
//! a triangle without an area then stitches the two parts of an edge to the whole one, so that the solid is closed for
//! the next plane, too, whatever rounding does.

use std::collections::HashMap;

use spade::handles::{DirectedEdgeHandle, FixedUndirectedEdgeHandle, FixedVertexHandle};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, Point2, PositionInTriangulation, Triangulation};

use super::outline::{Link, Outline, Rule};
use super::plane::LocalPlane;

/// The inside of the outlines of a cut.
#[derive(Default)]
pub(super) struct Cap {
    /// In the coordinates of the mesh.
    pub points: Vec<[f32; 3]>,
    /// Counter-clockwise seen from the side that was removed.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, how many solids it closes; negative where their surfaces are turned inside out.
    pub weights: Vec<i32>,
}

type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// How many crossings of edges are cut, at least and per point of the outline. Edges of any number of points could cross
/// each other in its square.
const CROSSINGS: (usize, usize) = (1 << 12, 4);

/// `None` if the edges cross each other too often.
pub(super) fn cap(outline: &Outline, plane: &LocalPlane) -> Option<Cap> {
    if outline.links.is_empty() {
        return Some(Cap::default());
    }
    let arrangement = Arrangement::new(outline)?;
    let axis = plane.main_axis();
    // Counter-clockwise in the projection is seen from the end of the axis.
    let is_seen_from_end = plane.normal[axis] < 0.0;
    let mut cap = Cap { points: outline.points.clone(), ..Cap::default() };
    let crossings = arrangement.delaunay.vertices().skip(arrangement.points.len());
    cap.points.extend(crossings.map(|v| lifted(v.position(), axis, plane)));
    let mut add = |[a, b, c]: [u32; 3], weight: i32| {
        cap.triangles.push(if is_seen_from_end { [a, b, c] } else { [a, c, b] });
        cap.weights.push(if is_seen_from_end { weight } else { -weight });
    };
    let windings = arrangement.windings(outline.rule);
    for (face, winding) in arrangement.delaunay.inner_faces().zip(windings).filter(|(_, w)| *w != 0) {
        add(face.vertices().map(|v| arrangement.number(v.index() as u32)), winding);
    }
    arrangement.stitches.iter().for_each(|&(triangle, weight)| add(triangle, weight));
    Some(cap)
}

/// The point of the plane above a point of the projection.
fn lifted(p: Point2<f64>, axis: usize, plane: &LocalPlane) -> [f32; 3] {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let n = plane.normal;
    let mut lifted = [0.0; 3];
    (lifted[u], lifted[v]) = (p.x as f32, p.y as f32);
    lifted[axis] = (-(n[u] * p.x + n[v] * p.y + plane.offset) / n[axis]) as f32 + 0.0;
    lifted
}

/// A triangulation with all edges of an outline, which meet at points only.
struct Arrangement {
    delaunay: Delaunay,
    /// How many edges of the outline are on an edge of the triangulation, from the lower point to the higher, less
    /// those in the other direction.
    weights: HashMap<(usize, usize), i32>,
    /// For the points of the triangulation the first of the outline that is there; crossings follow.
    points: Vec<u32>,
    /// Number of points of the outline.
    count: u32,
    /// Triangles without an area between edges of the outline and the edges that they became, by numbers of the outline.
    stitches: Vec<([u32; 3], i32)>,
}

impl Arrangement {
    fn new(outline: &Outline) -> Option<Self> {
        let mut places = HashMap::new();
        let (mut points, mut vertices) = (Vec::new(), Vec::new());
        let mut place_of = |(number, &[u, v]): (u32, &[f64; 2])| {
            *places.entry([u.to_bits(), v.to_bits()]).or_insert_with(|| {
                points.push(number);
                vertices.push(Point2::new(u, v));
                points.len() as u32 - 1
            })
        };
        let place: Vec<u32> = (0..).zip(&outline.flat).map(&mut place_of).collect();
        let mut arrangement = Self {
            // Keeps the order of the points.
            delaunay: Delaunay::bulk_load_cdt(vertices, Vec::new()).ok()?,
            weights: HashMap::with_capacity(outline.links.len()),
            points,
            count: outline.points.len() as u32,
            stitches: Vec::new(),
        };
        let mut links = Vec::with_capacity(outline.links.len());
        for &Link { from, to, weight } in outline.links.iter().rev() {
            let (a, b) = (place[from as usize], place[to as usize]);
            let [first, last] = [a, b].map(|v| arrangement.number(v));
            arrangement.stitch(&[from, first, last, to], weight);
            links.push(Link { from: a, to: b, weight });
        }
        let most = CROSSINGS.0.max(CROSSINGS.1 * outline.points.len());
        arrangement.insert(links, most)?;
        Some(arrangement)
    }

    /// The number of a point of the triangulation in the outline, where crossings follow.
    fn number(&self, vertex: u32) -> u32 {
        let crossing = |v: u32| self.count + (v - self.points.len() as u32);
        self.points.get(vertex as usize).copied().unwrap_or_else(|| crossing(vertex))
    }

    /// Adds what is between the edge from the first of these points to the last, and the way along all of them.
    fn stitch(&mut self, way: &[u32], weight: i32) {
        for pair in way.windows(2).skip(1) {
            let [a, b, c] = [way[0], pair[1], pair[0]];
            if a != b && b != c && c != a {
                self.stitches.push(([a, b, c], weight));
            }
        }
    }

    /// Inserts edges, last first. Where one crosses another, both get a point there, which is rounded, so that they
    /// may then cross others: `None` after more than so many crossings. Where that is at an end of one of them, as far as
    /// numbers tell, it is this end: edges that nearly coincide would cross each other again and again, each time an ulp
    /// further on.
    fn insert(&mut self, mut links: Vec<Link>, mut crossings: usize) -> Option<()> {
        while let Some(link) = links.pop() {
            if link.from == link.to || self.add(link) {
                continue;
            }
            crossings = crossings.checked_sub(1)?;
            let [from, to] = [link.from, link.to].map(handle);
            let crossed = self.delaunay.get_conflicting_edges_between_vertices(from, to).next()?;
            let ends = [from, to].map(|v| self.delaunay.vertex(v));
            let at = crossing(ends.map(|v| v.position()), crossed.positions());
            let near = ends.into_iter().chain(crossed.vertices()).find(|v| is_near(at, v.position()));
            let near = near.map(|v| v.index() as u32);
            let crossed = crossed.fix().as_undirected();
            let crossed = self.remove(crossed);
            let middle = match near {
                Some(end) => end,
                None => self.point(at, from, &mut links)?,
            };
            for link in [crossed, link] {
                let way = [link.from, middle, link.to].map(|v| self.number(v));
                self.stitch(&way, link.weight);
                links.extend([Link { from: middle, ..link }, Link { to: middle, ..link }]);
            }
        }
        Some(())
    }

    /// Inserts an edge; false if it crosses another.
    fn add(&mut self, link: Link) -> bool {
        let parts = self.delaunay.try_add_constraint(handle(link.from), handle(link.to));
        for &part in &parts {
            let [a, b] = self.delaunay.directed_edge(part).vertices().map(|v| v.index());
            let sum = self.weights.entry((a.min(b), a.max(b))).or_default();
            *sum = sum.saturating_add(if a < b { link.weight } else { -link.weight });
        }
        if parts.len() > 1 {
            let ends = parts.iter().map(|&part| self.delaunay.directed_edge(part).to().index() as u32);
            let way: Vec<u32> = [link.from].into_iter().chain(ends).map(|v| self.number(v)).collect();
            self.stitch(&way, link.weight);
        }
        !parts.is_empty()
    }

    fn remove(&mut self, edge: FixedUndirectedEdgeHandle) -> Link {
        let [a, b] = self.delaunay.undirected_edge(edge).vertices().map(|v| v.index());
        let (low, high) = (a.min(b), a.max(b));
        self.delaunay.remove_constraint_edge(edge);
        let weight = self.weights.remove(&(low, high)).unwrap_or_default();
        Link { from: low as u32, to: high as u32, weight }
    }

    /// The point here, a new one if there is none; an edge on which it is has to be inserted again.
    fn point(&mut self, at: Point2<f64>, near: FixedVertexHandle, links: &mut Vec<Link>) -> Option<u32> {
        if let PositionInTriangulation::OnEdge(edge) = self.delaunay.locate_with_hint(at, near)
            && self.delaunay.is_constraint_edge(edge.as_undirected())
        {
            links.push(self.remove(edge.as_undirected()));
        }
        self.delaunay.insert_with_hint(at, near).ok().map(|v| v.index() as u32)
    }

    /// The winding number of each triangle: they spread from the outside, where it is 0, across all edges.
    fn windings(&self, rule: Rule) -> Vec<i32> {
        let add = |winding: i32, step: i32| {
            let sum = winding.saturating_add(step);
            if rule == Rule::EvenOdd { sum.rem_euclid(2) } else { sum }
        };
        let mut windings: Vec<Option<i32>> = vec![None; self.delaunay.num_inner_faces()];
        // Triangles are numbered from 1; 0 is the outside.
        let mut next = Vec::new();
        for edge in self.delaunay.convex_hull() {
            let inside = edge.rev();
            if let Some(winding @ None) = inside.face().index().checked_sub(1).map(|f| &mut windings[f]) {
                *winding = Some(add(0, self.step(inside)));
                next.push(inside.face().fix());
            }
        }
        while let Some(face) = next.pop().and_then(|face| self.delaunay.face(face).as_inner()) {
            let winding = windings[face.index() - 1].unwrap_or_default();
            for edge in face.adjacent_edges() {
                let other = edge.rev().face();
                if let Some(unknown @ None) = other.index().checked_sub(1).map(|f| &mut windings[f]) {
                    *unknown = Some(add(winding, -self.step(edge)));
                    next.push(other.fix());
                }
            }
        }
        windings.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// By how much the winding number on the left of an edge is larger than that on its right.
    fn step(&self, edge: DirectedEdgeHandle<'_, Point2<f64>, (), CdtEdge<()>, ()>) -> i32 {
        if !edge.is_constraint_edge() {
            return 0;
        }
        let [a, b] = edge.vertices().map(|v| v.index());
        let weight = self.weights.get(&(a.min(b), a.max(b))).copied().unwrap_or_default();
        if a < b { weight } else { -weight }
    }
}

fn handle(point: u32) -> FixedVertexHandle {
    FixedVertexHandle::from_index(point as usize)
}

/// Whether two points are as near to each other as crossings are inexact, with room to spare. Coordinates of the outline are `f32`,
/// whose steps are some ten thousand times as large, except near 0.
fn is_near(p: Point2<f64>, q: Point2<f64>) -> bool {
    const NEAR: f64 = 1.0 / (1u64 << 40) as f64;
    let size = p.x.abs().max(p.y.abs()).max(q.x.abs()).max(q.y.abs());
    (p.x - q.x).abs().max((p.y - q.y).abs()) <= NEAR * size
}

/// Where the edge `[a, b]` crosses the other, on it.
fn crossing([a, b]: [Point2<f64>; 2], [c, d]: [Point2<f64>; 2]) -> Point2<f64> {
    let side = |p: Point2<f64>| (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    let (from, to) = (side(c), side(d));
    // The library knows exactly that they cross; this may be zero by rounding.
    let at = if from == to { 0.0 } else { (from / (from - to)).clamp(0.0, 1.0) };
    spade::mitigate_underflow(Point2::new(c.x + (d.x - c.x) * at, c.y + (d.y - c.y) * at))
}
