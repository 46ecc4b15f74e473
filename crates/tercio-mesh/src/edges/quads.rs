//! Triangles that are halves of quadrilaterals.

use glam::DVec3;

use super::{bend, normals_beside};

/// The bits of all sides of a triangle.
const ALL: u8 = 0b111;

/// Two triangles of one polygon at the side that they share: their numbers, and of each the corner from which the side runs to the
/// next one.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    pub triangles: [u32; 2],
    pub corners: [u8; 2],
}

/// [`Edges::fourths`](super::Edges::fourths), if no polygon has more than four corners, and all are flat. `at` is the place of a corner of a triangle;
/// triangles that are not `is_proper` have coinciding corners.
pub fn fourths(
    sides: &[u8],
    joined: &[Joined],
    is_proper: impl Fn(usize) -> bool,
    at: impl Fn(u32, u8) -> DVec3,
) -> Option<Vec<[f32; 2]>> {
    if joined.is_empty() {
        let is_whole = |(t, &sides): (usize, &u8)| sides == ALL || !is_proper(t);
        return sides.iter().enumerate().all(is_whole).then(Vec::new);
    }
    let is_half = |t: u32| sides[t as usize].count_ones() == 2;
    let mut fourths = vec![[0.0; 2]; sides.len()];
    let mut halves = 0;
    for Joined { triangles: [a, b], corners } in joined {
        if !is_half(*a) || !is_half(*b) {
            return None;
        }
        halves += 2;
        let [from, to, apex] = [0, 1, 2].map(|k| at(*a, (corners[0] + k) % 3));
        let [other_from, other_to, other_apex] = [0, 1, 2].map(|k| at(*b, (corners[1] + k) % 3));
        if !is_flat(from, to, apex, other_apex) {
            return None;
        }
        fourths[*a as usize] = fourth(from, to, apex, other_apex);
        fourths[*b as usize] = fourth(other_from, other_to, other_apex, apex);
    }
    let others = sides.iter().enumerate().filter(|(t, sides)| **sides != ALL && is_proper(*t));
    (others.count() == halves).then_some(fourths)
}

/// The tangent of the angle by which the halves of a quadrilateral may be bent: a degree. Where one of them is hidden behind the diagonal,
/// so are lines along its sides, although they are no farther from the diagonal than half of their width.
const MOST_BENT: f64 = 0.0175;

/// Are two triangles at the side between these ends in one plane, and on both sides of it?
fn is_flat(from: DVec3, to: DVec3, apex: DVec3, other_apex: DVec3) -> bool {
    let (sin, cos) = bend(normals_beside(from, to, [apex, other_apex]));
    sin <= MOST_BENT * cos
}

/// Of the half `from`, `to`, `apex` of a quadrilateral, whose diagonal is from `from` to `to`, where the `fourth` corner is after
/// the other half is turned about the diagonal into its plane.
fn fourth(from: DVec3, to: DVec3, apex: DVec3, fourth: DVec3) -> [f32; 2] {
    let along = to - from;
    let square = along.length_squared();
    // Coordinates along the diagonal, and across it on both sides, in lengths of the diagonal.
    let place = |p: DVec3| ((p - from).dot(along) / square, (p - from).cross(along).length() / square);
    let ((apex_along, apex_across), (fourth_along, fourth_across)) = (place(apex), place(fourth));
    let ratio = apex_across / fourth_across;
    let of_to = fourth_along * ratio + apex_along;
    // The side of the other half at a reflex corner does not reach this half.
    let or_none = |c: f64| if c > 0.0 && c < f64::from(f32::MAX) { c as f32 } else { 0.0 };
    [ratio + 1.0 - of_to, of_to].map(or_none)
}
