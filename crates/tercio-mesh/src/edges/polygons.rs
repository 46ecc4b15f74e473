//! Polygons of several triangles: where, seen from one of their triangles, the sides of the others are.

use std::sync::Arc;

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

/// Corners of triangles: where they are, and their vertex numbers among those that edges use.
pub struct Corners<P, V> {
    pub at: P,
    pub vertex: V,
}

/// What polygons of several triangles have besides sides of triangles.
pub struct OfPolygons {
    /// [`Edges::beyond`](super::Edges::beyond).
    pub beyond: Beyond,
    /// The sides that are no edges at which a polygon is bent.
    pub bent: Vec<BentSide>,
}

/// A side at which a polygon is bent.
pub struct BentSide {
    pub joined: Joined,
    /// The edges of the polygon that begin at its ends, each as a side of a triangle: seen from both triangles.
    pub edges: [Option<(u32, u8)>; 4],
}

/// `joined` are all sides that are no edges.
pub fn of_polygons<P, V>(
    sides: &[u8],
    joined: &[Joined],
    corners: Corners<P, V>,
    positions: &Arc<Vec<[f32; 3]>>,
) -> OfPolygons
where
    P: Fn(u32, u8) -> DVec3 + Sync,
    V: Fn(u32, u8) -> u32 + Sync,
{
    if joined.is_empty() {
        return OfPolygons { beyond: Beyond::Nothing, bent: Vec::new() };
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
    let positions = Arc::clone(positions);
    let beyond = match has_four {
        true => Beyond::Quadrilaterals(polygons.fourth_corners(positions)),
        false if is_bent.contains(&true) => Beyond::Ends(polygons.far_ends(positions)),
        false => match polygons.places_in_planes() {
            Some(places) => Beyond::Polygons(places),
            None => Beyond::Ends(polygons.far_ends(positions)),
        },
    };
    let bent = joined.par_iter().zip(&is_bent).filter(|(_, is_bent)| **is_bent);
    let bent =
        bent.map(|(pair, _)| BentSide { joined: *pair, edges: polygons.edges_at_ends(pair) }).collect();
    OfPolygons { beyond, bent }
}

/// A side of a triangle, which runs from this corner to the next one.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Side {
    triangle: u32,
    from: u8,
}

/// The side opposite to a corner of a triangle begins at the next corner.
fn side_opposite(triangle: u32, corner: u8) -> Side {
    Side { triangle, from: (corner + 1) % 3 }
}

/// No side.
const NONE: Side = Side { triangle: u32::MAX, from: 0 };

/// Triangles with what is on the other side of those of their sides that are no edges.
struct Polygons<'a, P, V> {
    /// By triangle, and by the corner from which its side runs.
    twins: &'a [[Side; 3]],
    corners: Corners<P, V>,
}

impl<P: Fn(u32, u8) -> DVec3 + Sync, V: Fn(u32, u8) -> u32 + Sync> Polygons<'_, P, V> {
    /// Are two triangles of a polygon in different planes?
    fn is_bent(&self, Joined { triangles: [a, b], corners: [of_a, of_b] }: &Joined) -> bool {
        let at = &self.corners.at;
        let [from, to, apex] = [0, 1, 2].map(|k| at(*a, (of_a + k) % 3));
        let both = normals_beside(from, to, [apex, at(*b, (of_b + 2) % 3)]);
        let (sin, cos) = bend(both);
        let is_sliver = |normal: DVec3| normal.length() <= LEAST_HEIGHT * from.distance_squared(to);
        sin > MOST_BENT * cos && !both.into_iter().any(is_sliver)
    }

    /// [`Beyond::Quadrilaterals`].
    fn fourth_corners(&self, positions: Arc<Vec<[f32; 3]>>) -> FourthCorners {
        let of_half = |twins: &[Side; 3]| {
            let twin = twins.iter().find(|twin| **twin != NONE);
            twin.map_or(Edge::NONE, |twin| (self.corners.vertex)(twin.triangle, (twin.from + 2) % 3))
        };
        FourthCorners { vertices: self.twins.par_iter().map(of_half).collect(), positions }
    }

    /// [`Beyond::Polygons`], of polygons that are flat; `None` if one has a reflex angle.
    fn places_in_planes(&self) -> Option<Vec<[[f32; 2]; 3]>> {
        let opposite = |t: u32, k: u8| self.places(side_opposite(t, k));
        let of_triangle = |t| Some([opposite(t, 0)?, opposite(t, 1)?, opposite(t, 2)?]);
        (0..self.twins.len() as u32).into_par_iter().map(of_triangle).collect()
    }

    /// [`Beyond::Ends`].
    fn far_ends(&self, positions: Arc<Vec<[f32; 3]>>) -> FarEnds {
        let of_triangle = |t: u32| {
            let of_side = move |k: u8| {
                let of_end = move |n: u8| {
                    let (_, end) = self.far_edge(side_opposite(t, k), (k + 1 + n) % 3)?;
                    Some((2 * k + n, end))
                };
                (0..2).filter_map(of_end)
            };
            (0..3).flat_map(of_side)
        };
        let triangles = 0..self.twins.len() as u32;
        let counts: Vec<u32> =
            triangles.clone().into_par_iter().map(|t| of_triangle(t).count() as u32).collect();
        let mut first = Vec::with_capacity(counts.len() + 1);
        first.push(0);
        for count in counts {
            first.push(first[first.len() - 1] + count);
        }
        let list: Vec<(u8, u32)> = triangles.into_par_iter().flat_map_iter(of_triangle).collect();
        let (sides, ends) = list.into_iter().unzip();
        FarEnds { first, sides, ends, positions }
    }

    /// The edges of the polygon that begin at the ends of a side, seen from both triangles.
    fn edges_at_ends(&self, pair: &Joined) -> [Option<(u32, u8)>; 4] {
        std::array::from_fn(|n| {
            let (triangle, from) = (pair.triangles[n / 2], pair.corners[n / 2]);
            let (side, _) = self.far_edge(Side { triangle, from }, (from + n as u8 % 2) % 3)?;
            Some((side.triangle, side.from))
        })
    }

    /// The next edge of the polygon round an end of a side of a triangle, beyond the side, and the vertex of the edge's other end. None if
    /// the side is an edge itself, or triangles are all round its end.
    fn far_edge(&self, side: Side, end: u8) -> Option<(Side, u32)> {
        let vertex = |side: Side, k: u8| (self.corners.vertex)(side.triangle, (side.from + k) % 3);
        let pivot = (self.corners.vertex)(side.triangle, end);
        let mut twin = self.twin(side);
        while twin != NONE && twin.triangle != side.triangle {
            let beyond =
                Side { from: (twin.from + if vertex(twin, 0) == pivot { 2 } else { 1 }) % 3, ..twin };
            let next = self.twin(beyond);
            if next == NONE {
                return Some((beyond, vertex(twin, 2)));
            }
            twin = next;
        }
        None
    }

    fn twin(&self, side: Side) -> Side {
        self.twins[side.triangle as usize][usize::from(side.from)]
    }

    /// The ends of a side, and the third corner.
    fn corners(&self, side: Side) -> [DVec3; 3] {
        [0, 1, 2].map(|k| (self.corners.at)(side.triangle, (side.from + k) % 3))
    }

    /// The edges of the polygon that begin at the ends of a side of a triangle and are beyond it: [`Beyond::Polygons`] has
    /// the meaning of the values, which are 0 if the side is an edge itself. `None` if the angle of the polygon there is reflex: the line of a
    /// side of the triangle would not end there.
    fn places(&self, side: Side) -> Option<[f32; 2]> {
        let [from, to, apex] = self.corners(side);
        let place = |pivot: DVec3, other: DVec3| {
            let turn = match self.turn(side, pivot) {
                Turn::Nowhere => return Some(0.0),
                Turn::Reflex => return None,
                Turn::To(turn) => turn,
            };
            // With the angle of the triangle itself.
            let both = turn.rotate(angle(pivot, other, apex));
            if is_reflex(both) {
                return None;
            }
            let place = both.y / (turn.y * other.distance_squared(pivot));
            // A line that is nearly the side itself; and none where it is nearly the other side of the triangle, or not a number.
            Some(if place > 0.0 { place.min(Beyond::MOST) as f32 } else { 0.0 })
        };
        Some([place(to, from)?, place(from, to)?])
    }

    /// The angle at an end of a side, from the side to the next edge of the polygon beyond it: all triangles in between are turned about
    /// their sides into the plane of this one.
    fn turn(&self, side: Side, pivot: DVec3) -> Turn {
        let mut twin = self.twin(side);
        let (mut turn, mut has_turned): (Option<DVec2>, bool) = (None, false);
        while twin != NONE && twin.triangle != side.triangle {
            let [from, to, next] = self.corners(twin);
            let other = if from == pivot { to } else { from };
            let step = angle(pivot, other, next);
            let sum = turn.map_or(step, |turn| turn.normalize_or_zero().rotate(step));
            has_turned |= is_reflex(sum);
            turn = Some(sum);
            let beyond = Side { from: (twin.from + if from == pivot { 2 } else { 1 }) % 3, ..twin };
            twin = self.twin(beyond);
        }
        match turn {
            Some(_) if twin == NONE && has_turned => Turn::Reflex,
            Some(turn) if twin == NONE => Turn::To(turn),
            _ => Turn::Nowhere,
        }
    }
}

/// The way round an end of a side to the next edge.
enum Turn {
    /// There is no edge: the side is one itself, or triangles are all round its end.
    Nowhere,
    /// More than 180 degrees.
    Reflex,
    /// The angle, as a vector in its direction.
    To(DVec2),
}

/// Is the angle of a vector above 180 degrees, by more than a degree? Sums of angles are below 360 degrees.
fn is_reflex(turn: DVec2) -> bool {
    turn.y < 0.0 && (turn.x > 0.0 || turn.y < MOST_BENT * turn.x)
}

/// The angle between the directions from a corner to two others, as a vector in its direction, from 0 to 180 degrees.
fn angle(at: DVec3, from: DVec3, to: DVec3) -> DVec2 {
    let (from, to) = (from - at, to - at);
    DVec2::new(from.dot(to), from.cross(to).length())
}
