//! The Utah teapot (Martin Newell, 1975): 32 bicubic Bézier patches.
//!
//! Body, rim, lid and bottom are swept around the axis: a ring of control points of radius r is r times (1, 0), (1,
//! k), (k, 1), (0, 1) and its three rotations by a quarter turn, k = 0.56. So the 306 control points of the classic
//! data reduce to profiles for the swept parts and the rows of one half of handle and spout. The bottom is the one
//! that Frank Crow added in 1987.
//!
//! Adjacent patches share control points, and a Bézier patch's border depends on nothing else: as every patch is
//! evaluated by the same operations in the same order, the borders get the same bits, and welding by position makes
//! the parts watertight.

use crate::loops::prelude::*;
use glam::DVec3;

use crate::weld::{position_representatives, weld};
use crate::{Mesh, OctNormal};

const K: f64 = 0.56;
/// Radius, height and k of the rings of the swept parts; the patches of a part share their border rings.
type Ring = (f64, f64, f64);
const SWEPT: [[Ring; 4]; 6] = [
    // Rim.
    [(1.4, 2.4, K), (1.3375, 2.53125, K), (1.4375, 2.53125, K), (1.5, 2.4, K)],
    // Body.
    [(1.5, 2.4, K), (1.75, 1.875, K), (2.0, 1.35, K), (2.0, 0.9, K)],
    [(2.0, 0.9, K), (2.0, 0.45, K), (1.5, 0.225, K), (1.5, 0.15, K)],
    // Lid, from the top of the knob.
    [(0.0, 3.15, K), (0.8, 3.15, 0.5625), (0.0, 2.85, K), (0.2, 2.7, K)],
    [(0.2, 2.7, K), (0.4, 2.55, K), (1.3, 2.55, K), (1.3, 2.4, K)],
    // Bottom.
    [(1.5, 0.15, K), (1.5, 0.075, K), (1.425, 0.0, K), (0.0, 0.0, K)],
];
/// Patches whose first or last row is a single point.
const WITH_POLE: u64 = 2 * 4;

/// A row of a half tube: x and z on its inner side, x and z on its outer side, and how far it extends to -y.
type Row = [f64; 5];
const HALF_TUBES: [[Row; 4]; 4] = [
    // Handle.
    [
        [-1.6, 2.025, -1.5, 2.25, 0.3],
        [-2.3, 2.025, -2.5, 2.25, 0.3],
        [-2.7, 2.025, -3.0, 2.25, 0.3],
        [-2.7, 1.8, -3.0, 1.8, 0.3],
    ],
    [
        [-2.7, 1.8, -3.0, 1.8, 0.3],
        [-2.7, 1.575, -3.0, 1.35, 0.3],
        [-2.5, 1.125, -2.65, 0.9375, 0.3],
        [-2.0, 0.9, -1.9, 0.6, 0.3],
    ],
    // Spout.
    [
        [1.7, 1.425, 1.7, 0.6, 0.66],
        [2.6, 1.425, 3.1, 0.825, 0.66],
        [2.3, 2.1, 2.4, 2.025, 0.25],
        [2.7, 2.4, 3.3, 2.4, 0.25],
    ],
    [
        [2.7, 2.4, 3.3, 2.4, 0.25],
        [2.8, 2.475, 3.525, 2.49375, 0.25],
        [2.9, 2.475, 3.45, 2.5125, 0.15],
        [2.8, 2.4, 3.2, 2.4, 0.15],
    ],
];

/// Four rows of four control points, z up, and whether u turns to v clockwise seen from outside.
#[derive(Clone, Copy)]
struct Patch {
    rows: [[DVec3; 4]; 4],
    clockwise: bool,
    pole: Option<Pole>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Pole {
    First,
    Last,
}

/// The teapot with its bottom, of about `count` triangles, at least 56; 6.4 units long, +Y up, the spout towards +X.
///
/// Four parts: body, lid, handle and spout. They are open where the classic data is: at the mouth under the lid,
/// around the lid, at the tip of the spout, and inside the body where handle and spout end.
pub fn teapot(count: u64) -> Mesh {
    let (a, b) = divisions(count);
    let patches = patches();
    // The handle touches the body in one vertex (the classic data share that control point), which must not take the
    // body's normal: so the tubes are welded separately.
    let (swept, tubes) = patches.split_at(SWEPT.len() * 4);
    let (mut mesh, tubes) = (tessellate(swept, a, b), tessellate(tubes, a, b));
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(tubes.positions);
    mesh.triangles.extend(tubes.triangles.iter().map(|t| t.map(|v| v + first)));
    if let (Some(all), Some(more)) = (&mut mesh.normals, tubes.normals) {
        all.extend(more);
    }
    mesh
}

/// Patches of `a` by `b` cells, welded.
fn tessellate(patches: &[Patch], a: u64, b: u64) -> Mesh {
    let each = (a + 1) * (b + 1);

    let mut mesh = Mesh::default();
    let mut normals: Vec<OctNormal> = Vec::new();
    for (n, patch) in patches.iter().enumerate() {
        let (points, normal): (Vec<_>, Vec<_>) = (0..each)
            .into_par_iter()
            .map(|k| patch.at((k % (a + 1)) as f64 / a as f64, (k / (a + 1)) as f64 / b as f64))
            .unzip();
        mesh.positions.extend(points);
        normals.extend(normal);

        let first = n as u64 * each;
        mesh.triangles.par_extend((0..a * b).into_par_iter().flat_map_iter(|k| {
            let (i, j) = (k % a, k / a);
            let [mut s, mut t] = super::grid_cell(first, a, i, j);
            // At a pole one of the two triangles of a cell has no area.
            let whole_s = !(patch.pole == Some(Pole::First) && j == 0);
            let whole_t = !(patch.pole == Some(Pole::Last) && j + 1 == b);
            if patch.clockwise {
                s.swap(1, 2);
                t.swap(1, 2);
            }
            [whole_s.then_some(s), whole_t.then_some(t)].into_iter().flatten()
        }));
    }
    // Adjacent patches compute the normal on their border from different control points: take that of the first.
    let same = position_representatives(&mesh);
    mesh.normals = Some(same.par_iter().map(|&s| normals[s as usize]).collect());
    weld(&mut mesh);
    mesh
}

/// Cells along u and v whose number of triangles comes closest to `count`, u and v about equal.
fn divisions(count: u64) -> (u64, u64) {
    let n = ((count as f64 / 64.0).sqrt() as u64).max(1);
    let of = |(a, b): (u64, u64)| 64 * a * b - WITH_POLE * a;
    let widest = if n < 16 { n / 2 + 2 } else { 2 };
    (n.saturating_sub(widest).max(1)..=n + widest)
        .map(|a| {
            let b = (count as f64 / (64 * a) as f64 + 0.125).round().max(1.0) as u64;
            (a, b)
        })
        // A count within about 2 % is close enough; among those the most square division wins.
        .min_by_key(|&(a, b)| (of((a, b)).abs_diff(count) * 50 / count.max(1), a.abs_diff(b)))
        .unwrap_or((n, n))
}

fn patches() -> Vec<Patch> {
    let mut list = Vec::with_capacity(32);
    for rings in &SWEPT {
        let pole = match (rings[0].0 == 0.0, rings[3].0 == 0.0) {
            (true, _) => Some(Pole::First),
            (_, true) => Some(Pole::Last),
            _ => None,
        };
        let mut rows = rings.map(|(r, z, k)| {
            [DVec3::new(r, 0.0, z), DVec3::new(r, r * k, z), DVec3::new(r * k, r, z), DVec3::new(0.0, r, z)]
        });
        for _ in 0..4 {
            list.push(Patch { rows, clockwise: true, pole });
            // A rotation by a quarter turn is exact.
            rows = rows.map(|row| row.map(|p| DVec3::new(-p.y, p.x, p.z)));
        }
    }
    for half in &HALF_TUBES {
        for side in [-1.0, 1.0] {
            let rows = half.map(|[x0, z0, x1, z1, y]| {
                [
                    DVec3::new(x0, 0.0, z0),
                    DVec3::new(x0, side * y, z0),
                    DVec3::new(x1, side * y, z1),
                    DVec3::new(x1, 0.0, z1),
                ]
            });
            list.push(Patch { rows, clockwise: side > 0.0, pole: None });
        }
    }
    list
}

/// Cubic Bernstein polynomials; exactly (1, 0, 0, 0) and (0, 0, 0, 1) at the ends.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// A third of the derivatives of [`bernstein`].
fn bernstein_slope(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-s * s, s * s - 2.0 * s * t, 2.0 * s * t - t * t, t * t]
}

fn blend(p: [DVec3; 4], w: [f64; 4]) -> DVec3 {
    ((p[0] * w[0] + p[1] * w[1]) + p[2] * w[2]) + p[3] * w[3]
}

impl Patch {
    /// Position and outward normal, +Y up.
    fn at(&self, u: f64, v: f64) -> ([f32; 3], OctNormal) {
        let (bu, bv) = (bernstein(u), bernstein(v));
        let p = blend(self.rows.map(|row| blend(row, bu)), bv);
        let du = blend(self.rows.map(|row| blend(row, bernstein_slope(u))), bv);
        let dv = blend(self.rows.map(|row| blend(row, bu)), bernstein_slope(v));
        let at_pole = match self.pole {
            Some(Pole::First) => v == 0.0,
            Some(Pole::Last) => v == 1.0,
            None => false,
        };
        let normal = if at_pole {
            // The profile meets the axis there at a right angle.
            DVec3::Z * if self.pole == Some(Pole::First) { 1.0 } else { -1.0 }
        } else if self.clockwise {
            dv.cross(du)
        } else {
            du.cross(dv)
        };
        let y_up = |p: DVec3| [p.x as f32, p.z as f32, -p.y as f32];
        (y_up(p), OctNormal::encode(y_up(normal)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::analyze;

    #[test]
    fn the_teapot_has_four_watertight_parts_with_the_classic_openings() {
        for count in [10_000, 150_000] {
            let (a, _) = divisions(count);
            let mesh = teapot(count);
            let found = analyze(&mesh);
            // Four, but the handle touches the body in a vertex, which makes them one component.
            assert_eq!(found.components, 3);
            assert!(found.consistently_wound);
            assert_eq!((found.non_manifold_edges, found.flipped_edges), (0, 0));
            // Mouth and lid are rings of four patches; handle and spout have rings of two patches at both ends.
            assert_eq!(found.boundary_edges, (2 * 4 + 4 * 2) * a);
            // Two discs and two tubes, less the vertex where two of them touch.
            assert_eq!(found.euler_characteristic(), 1);
            assert_eq!(found.triangles as usize, mesh.triangles.len());
        }
    }

    #[test]
    fn normals_point_outwards() {
        let mesh = teapot(200_000);
        super::super::tests::check_normals(&mesh, 0.8);
        // Seen from the axis at half height, the body faces away.
        let normals = mesh.normals.as_ref().unwrap();
        let mut looked_at = 0;
        for (p, n) in mesh.positions.iter().zip(normals) {
            let radius = (p[0] * p[0] + p[2] * p[2]).sqrt();
            if (0.7..2.3).contains(&p[1]) && (1.45..1.999).contains(&radius) && p[0].abs() < 0.5 {
                let n = n.decode();
                assert!(p[0] * n[0] + p[2] * n[2] > 0.0);
                looked_at += 1;
            }
        }
        assert!(looked_at > 100);
        let top = mesh.positions.iter().position(|&p| p == [0.0, 3.15, 0.0]).unwrap();
        assert_eq!(normals[top].decode(), OctNormal::encode([0.0, 1.0, 0.0]).decode());
        let bounds = mesh.bounds();
        assert!((bounds.min - DVec3::new(-3.0, 0.0, -2.0)).length() < 0.01, "{bounds:?}");
        assert!((bounds.max - DVec3::new(3.434, 3.15, 2.0)).length() < 0.01, "{bounds:?}");
    }
}
