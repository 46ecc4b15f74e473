//! Polygons of several triangles: where, seen from one of their triangles, the sides of the others are.

use glam::{DVec2, DVec3};

use super::{Beyond, bend, normals_beside};
use crate::loops::prelude::*;

/// Two triangles of one polygon at the side that they share: their numbers, and of each the corner from which the side runs to the
/// next one.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    pub triangles: [u32; 2],
    pub corners: [u8; 2],
}

/// The tangent of the angle by which two triangles of a polygon may be bent: a degree. Where one of them is hidden behind the other, or seen
/// nearly edge-on, so are lines along its sides, but not what they would be in the plane of the other.
const MOST_BENT: f64 = 0.0175;

/// A triangle that is less high over a side than this many times the length of the side may have any direction, by rounding.
const LEAST_HEIGHT: f64 = 1e-3;

/// [`Edges::beyond`](super::Edges::beyond); `joined` are all sides that are no edges, `at` is the place of a corner of a triangle.
pub fn beyond(sides: &[u8], joined: &[Joined], at: impl Fn(u32, u8) -> DVec3 + Sync) -> Option<Beyond> {
    if joined.is_empty() {
        return Some(Beyond::Nothing);
    }
    let is_flat = |Joined { triangles: [a, b], corners: [of_a, of_b] }: &Joined| {
        let [from, to, apex] = [0, 1, 2].map(|k| at(*a, (of_a + k) % 3));
        let both = normals_beside(from, to, [apex, at(*b, (of_b + 2) % 3)]);
        let (sin, cos) = bend(both);
        let is_sliver = |normal: DVec3| normal.length() <= LEAST_HEIGHT * from.distance_squared(to);
        sin <= MOST_BENT * cos || both.into_iter().any(is_sliver)
    };
    if !joined.par_iter().all(is_flat) {
        return None;
    }
    let mut twins = vec![[NONE; 3]; sides.len()];
    for Joined { triangles: [a, b], corners: [of_a, of_b] } in joined {
        twins[*a as usize][usize::from(*of_a)] = Side { triangle: *b, from: *of_b };
        twins[*b as usize][usize::from(*of_b)] = Side { triangle: *a, from: *of_a };
    }
    let polygons = Polygons { twins: &twins, at };
    let triangles = (0..sides.len() as u32).into_par_iter();
    let is_half = |t: &u32| sides[*t as usize].count_ones() == 2;
    if joined.iter().flat_map(|pair| &pair.triangles).all(is_half) {
        let diagonal = |t: u32| (0..3).find(|&from| twins[t as usize][usize::from(from)] != NONE);
        let of_half =
            |t| diagonal(t).map_or(Some([0.0; 2]), |from| polygons.places(Side { triangle: t, from }));
        return triangles.map(of_half).collect::<Option<_>>().map(Beyond::Quadrilaterals);
    }
    // The side opposite to a corner begins at the next corner.
    let opposite = |t: u32, k: u8| polygons.places(Side { triangle: t, from: (k + 1) % 3 });
    let of_triangle = |t| Some([opposite(t, 0)?, opposite(t, 1)?, opposite(t, 2)?]);
    triangles.map(of_triangle).collect::<Option<_>>().map(Beyond::Polygons)
}

/// A side of a triangle, which runs from this corner to the next one.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Side {
    triangle: u32,
    from: u8,
}

/// No side.
const NONE: Side = Side { triangle: u32::MAX, from: 0 };

/// Triangles with what is on the other side of those of their sides that are no edges.
struct Polygons<'a, F> {
    /// By triangle, and by the corner from which its side runs.
    twins: &'a [[Side; 3]],
    at: F,
}

impl<F: Fn(u32, u8) -> DVec3> Polygons<'_, F> {
    fn twin(&self, side: Side) -> Side {
        self.twins[side.triangle as usize][usize::from(side.from)]
    }

    /// The ends of a side, and the third corner.
    fn corners(&self, side: Side) -> [DVec3; 3] {
        [0, 1, 2].map(|k| (self.at)(side.triangle, (side.from + k) % 3))
    }

    /// The edges of the polygon that begin at the ends of a side of a triangle and are beyond it: [`Beyond::Quadrilaterals`] has
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
