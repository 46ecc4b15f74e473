//! Polygons of several triangles: where, seen from one of their triangles, the sides of the others are.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::{DVec2, DVec3};

use super::{Beyond, Edge, FarEnds, FourthCorners, bend, normals_beside};
use crate::loops::prelude::*;

/// Two triangles of one polygon at the side that they share: their numbers, and of each the corner from which the side runs to the
/// next one.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    pub triangles: [u32; 2],
    pub corners: [u8; 2],
}

/// The tangent of the angle by which two triangles of a polygon may be bent and count as in one plane: a degree.
const MOST_BENT: f64 = 0.0175;

/// A triangle that is less high over a side than this many times the length of the side may have any direction, by rounding.
const LEAST_HEIGHT: f64 = 1e-3;

/// Corners of triangles.
pub struct Corners<P, V> {
    /// Where a corner of a triangle is.
    pub at: P,
    /// Its vertex in the mesh: the same for all corners at one position.
    pub vertex: V,
}

/// What polygons of several triangles have besides sides of triangles.
pub struct OfPolygons {
    /// [`Edges::beyond`](super::Edges::beyond).
    pub beyond: Beyond,
    /// The sides that are no edges at which a polygon is bent.
    pub bent: Vec<BentSide>,
    /// The sides, by their first corners, of triangles without height that are edges, if [`Beyond::Ends`] are what is beyond: the
    /// triangle beside one may have all of such an edge along its side, but none of its ends.
    pub slivers: Vec<(u32, u8)>,
}

/// A side at which a polygon is bent.
pub struct BentSide {
    pub joined: Joined,
    /// The edges of the polygon that begin at its ends, each as a side of a triangle: seen from both triangles.
    pub edges: [Option<(u32, u8)>; 4],
}

/// `joined` are all sides that are no edges; `numbers` those of vertices of the mesh among those that edges use.
pub fn of_polygons<P, V>(
    sides: &[u8],
    joined: &[Joined],
    corners: Corners<P, V>,
    numbers: &[u32],
    positions: &Arc<Vec<[f32; 3]>>,
) -> OfPolygons
where
    P: Fn(u32, u8) -> DVec3 + Sync,
    V: Fn(u32, u8) -> u32 + Sync,
{
    if joined.is_empty() {
        return OfPolygons { beyond: Beyond::Nothing, bent: Vec::new(), slivers: Vec::new() };
    }
    let mut twins = vec![[NONE; 3]; sides.len()];
    for Joined { triangles: [a, b], corners: [of_a, of_b] } in joined {
        twins[*a as usize][usize::from(*of_a)] = Side { triangle: *b, from: *of_b };
        twins[*b as usize][usize::from(*of_b)] = Side { triangle: *a, from: *of_a };
    }
    let is_half = |t: &u32| sides[*t as usize].count_ones() == 2;
    let has_four = joined.iter().flat_map(|pair| &pair.triangles).all(is_half);
    let polygons = Polygons { twins: &twins, corners };
    let is_bent: Vec<bool> = joined.par_iter().map(|pair| polygons.is_bent(pair)).collect();
    let is_any_bent = is_bent.contains(&true);
    let far = if has_four && !is_any_bent { Vec::new() } else { polygons.far_edges() };
    let positions = Arc::clone(positions);
    let beyond = if has_four {
        Beyond::Quadrilaterals(polygons.fourth_corners(numbers, positions))
    } else {
        match if is_any_bent { None } else { polygons.places(&far) } {
            Some(places) => Beyond::Polygons(places),
            None => Beyond::Ends(polygons.far_ends(&far, numbers, positions)),
        }
    };
    let bent = joined.par_iter().zip(&is_bent).filter(|(_, is_bent)| **is_bent);
    let bent = bent.map(|(pair, _)| BentSide { joined: *pair, edges: edges_at_ends(pair, &far) }).collect();
    let slivers = if matches!(beyond, Beyond::Ends(_)) { polygons.edges_of_slivers() } else { Vec::new() };
    OfPolygons { beyond, bent, slivers }
}

/// A side of a triangle, which runs from this corner to the next one.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Side {
    triangle: u32,
    from: u8,
}

/// No side.
const NONE: Side = Side { triangle: u32::MAX, from: 0 };

/// For each end of a side, which is opposite to a corner, the edge of the polygon that begins there beyond the side.
type FarEdges = [[AtomicU64; 2]; 3];

/// An edge that begins at one of its ends, from there on, as a side of a triangle.
#[derive(Clone, Copy)]
struct FarEdge {
    side: Side,
    /// It begins at the second end of the side.
    is_turned: bool,
}

impl FarEdge {
    fn encode(self) -> u64 {
        (u64::from(self.side.triangle) * 3 + u64::from(self.side.from)) * 2 + u64::from(self.is_turned)
    }

    fn decode(code: &AtomicU64) -> Option<Self> {
        let code = Some(code.load(Relaxed)).filter(|code| *code != u64::MAX)?;
        let side = Side { triangle: (code / 6) as u32, from: (code / 2 % 3) as u8 };
        Some(Self { side, is_turned: code % 2 == 1 })
    }

    /// The corner of the triangle at which the edge ends.
    fn end(self) -> u8 {
        if self.is_turned { self.side.from } else { (self.side.from + 1) % 3 }
    }
}

/// The edges of the polygon that begin at the ends of a side, seen from both triangles.
fn edges_at_ends(pair: &Joined, far: &[FarEdges]) -> [Option<(u32, u8)>; 4] {
    std::array::from_fn(|n| {
        let (triangle, from) = (pair.triangles[n / 2], pair.corners[n / 2]);
        let edge = FarEdge::decode(&far[triangle as usize][usize::from(from + 2) % 3][n % 2])?;
        Some((edge.side.triangle, edge.side.from))
    })
}

/// Triangles with what is on the other side of those of their sides that are no edges.
struct Polygons<'a, P, V> {
    /// By triangle, and by the corner from which its side runs.
    twins: &'a [[Side; 3]],
    corners: Corners<P, V>,
}

impl<P: Fn(u32, u8) -> DVec3 + Sync, V: Fn(u32, u8) -> u32 + Sync> Polygons<'_, P, V> {
    fn triangles(&self) -> Range<u32> {
        0..self.twins.len() as u32
    }

    fn twin(&self, side: Side) -> Side {
        self.twins[side.triangle as usize][usize::from(side.from)]
    }

    fn vertex(&self, triangle: u32, corner: u8) -> u32 {
        (self.corners.vertex)(triangle, corner % 3)
    }

    fn at(&self, triangle: u32, corner: u8) -> DVec3 {
        (self.corners.at)(triangle, corner % 3)
    }

    /// Are two triangles of a polygon in different planes?
    fn is_bent(&self, Joined { triangles: [a, b], corners: [of_a, of_b] }: &Joined) -> bool {
        let [from, to, apex] = [0, 1, 2].map(|k| self.at(*a, of_a + k));
        let both = normals_beside(from, to, [apex, self.at(*b, of_b + 2)]);
        let (sin, cos) = bend(both);
        let is_sliver = |normal: DVec3| normal.length() <= LEAST_HEIGHT * from.distance_squared(to);
        sin > MOST_BENT * cos && !both.into_iter().any(is_sliver)
    }

    /// For each triangle. From each end of each edge, the triangles round it that the polygon has there are passed once.
    fn far_edges(&self) -> Vec<FarEdges> {
        let none = |_| [0; 3].map(|_| [0; 2].map(|_| AtomicU64::new(u64::MAX)));
        let far: Vec<FarEdges> = self.triangles().into_par_iter().map(none).collect();
        self.triangles().into_par_iter().for_each(|triangle| {
            for (from, end) in (0..3).flat_map(|from| [(from, 0), (from, 1)]) {
                let side = Side { triangle, from };
                if self.twin(side) != NONE {
                    continue;
                }
                let edge = FarEdge { side, is_turned: end == 1 };
                let pivot = self.vertex(triangle, from + end);
                // The other side that begins or ends at the pivot.
                let mut next = Side { triangle, from: (from + if end == 0 { 2 } else { 1 }) % 3 };
                loop {
                    let twin = self.twin(next);
                    if twin == NONE {
                        break;
                    }
                    let end = usize::from(self.vertex(twin.triangle, twin.from) != pivot);
                    let of_side = &far[twin.triangle as usize][usize::from(twin.from + 2) % 3];
                    of_side[end].store(edge.encode(), Relaxed);
                    next = Side { from: (twin.from + if end == 0 { 2 } else { 1 }) % 3, ..twin };
                }
            }
        });
        far
    }

    /// [`Beyond::Quadrilaterals`].
    fn fourth_corners(&self, numbers: &[u32], positions: Arc<Vec<[f32; 3]>>) -> FourthCorners {
        let of_half = |twins: &[Side; 3]| {
            let twin = twins.iter().find(|twin| **twin != NONE);
            twin.map_or(Edge::NONE, |twin| numbers[self.vertex(twin.triangle, twin.from + 2) as usize])
        };
        FourthCorners::new(self.twins.par_iter().map(of_half).collect(), positions)
    }

    /// [`Beyond::Ends`].
    fn far_ends(&self, far: &[FarEdges], numbers: &[u32], positions: Arc<Vec<[f32; 3]>>) -> FarEnds {
        let of_triangle = |t: u32| {
            let all = far[t as usize].as_flattened().iter().zip(0..);
            all.filter_map(|(code, place): (_, u8)| {
                let edge = FarEdge::decode(code)?;
                Some((place, numbers[self.vertex(edge.side.triangle, edge.end()) as usize]))
            })
        };
        let counts: Vec<u64> =
            self.triangles().into_par_iter().map(|t| of_triangle(t).count() as u64).collect();
        let mut first = Vec::with_capacity(counts.len() + 1);
        first.push(0);
        for count in counts {
            first.push(first[first.len() - 1] + count);
        }
        let list: Vec<(u8, u32)> = self.triangles().into_par_iter().flat_map_iter(of_triangle).collect();
        let (sides, ends) = list.into_iter().unzip();
        FarEnds { first, sides, ends, positions }
    }

    /// [`OfPolygons::slivers`].
    fn edges_of_slivers(&self) -> Vec<(u32, u8)> {
        let of_triangle = |triangle: u32| {
            let is_edge = move |from: &u8| self.twin(Side { triangle, from: *from }) == NONE;
            let corners = [0, 1, 2].map(|corner| self.at(triangle, corner));
            let is_sliver = (0..3).any(|k| {
                let [a, b, c] = [0, 1, 2].map(|n| corners[(k + n) % 3]);
                (b - a).cross(c - a).length() <= LEAST_HEIGHT * a.distance_squared(b)
            });
            let is_of_polygon = is_sliver && !(0..3).all(|from| is_edge(&from));
            (0..if is_of_polygon { 3 } else { 0 }).filter(is_edge).map(move |from| (triangle, from))
        };
        self.triangles().into_par_iter().flat_map_iter(of_triangle).collect()
    }

    /// [`Beyond::Polygons`], of polygons that are flat; `None` if one has a reflex angle.
    fn places(&self, far: &[FarEdges]) -> Option<Vec<[[f32; 2]; 3]>> {
        let at_end = |t: u32, side: u8, end: u8| {
            let code = &far[t as usize][usize::from(side)][usize::from(end)];
            let Some(edge) = FarEdge::decode(code) else { return Some(0.0) };
            let [pivot, other] = [end, 1 - end].map(|end| self.at(t, side + 1 + end));
            place(pivot, other, self.at(t, side), self.at(edge.side.triangle, edge.end()))
        };
        let of_side = |t: u32, side: u8| Some([at_end(t, side, 1)?, at_end(t, side, 0)?]);
        let of_triangle = |t: u32| Some([of_side(t, 0)?, of_side(t, 1)?, of_side(t, 2)?]);
        self.triangles().into_par_iter().map(of_triangle).collect()
    }
}

/// The number of [`Beyond::Polygons`] of an edge from an end of a side to somewhere in the plane of a triangle, on the other side of the
/// side, given the other end of the side and the corner opposite to it; what is not in the plane is turned into it about the side. 0 if
/// there is none beside the sides of the triangle, `None` if the angle of the polygon there is reflex: the line of a side of the triangle
/// would not end there.
pub fn place(pivot: DVec3, other: DVec3, apex: DVec3, far: DVec3) -> Option<f32> {
    let [side, own, far] = [other, apex, far].map(|p| p - pivot);
    let normal = side.cross(own);
    let away = far.cross(side);
    let is_sliver = normal.length() <= LEAST_HEIGHT * side.length_squared();
    // The angle from the side to the edge, as a vector in its direction.
    let turn = DVec2::new(side.dot(far), away.length());
    let is_inside = !is_sliver && normal.dot(away) < 0.0;
    let is_along = turn.y <= MOST_BENT * turn.x;
    if is_inside && !is_along {
        return None;
    }
    // With the angle of the triangle itself.
    let both = turn.rotate(DVec2::new(side.dot(own), normal.length()));
    if is_reflex(both) {
        return None;
    }
    let place = both.y / (turn.y * side.length_squared());
    // A line that is nearly the side itself; and none where it is nearly the other side of the triangle, or not a number.
    Some(if place > 0.0 { place.min(Beyond::MOST) as f32 } else { 0.0 })
}

/// Is the angle of a vector above 180 degrees, by more than a degree? Sums of angles are below 360 degrees.
fn is_reflex(turn: DVec2) -> bool {
    turn.y < 0.0 && (turn.x > 0.0 || turn.y < MOST_BENT * turn.x)
}
