//! The unit sphere, mapped from the six sides of a box of cells.

use crate::loops::prelude::*;

use super::grid_cell;
use crate::weld::weld;
use crate::{Mesh, OctNormal};

/// A closed sphere of radius 1 with about `count` triangles, at least 12.
///
/// The surface of a box of a by b by c cells, the three about equal, is mapped to the sphere by the smooth map x
/// sqrt(1 - y²/2 - z²/2 + y²z²/3) and so on; there are no poles and no slivers.
pub fn sphere(count: u64) -> Mesh {
    let cells = divisions(count);
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        // Seen from the end of the axis, u turns to v counter-clockwise; on the opposite side clockwise.
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            let (u, v) = if side > 0.0 { (u, v) } else { (v, u) };
            let (a, b) = (cells[u], cells[v]);
            let first = mesh.positions.len() as u64;
            mesh.positions.par_extend((0..(a + 1) * (b + 1)).into_par_iter().map(|n| {
                let mut p = [side; 3];
                p[u] = ((n % (a + 1)) * 2) as f64 / a as f64 - 1.0;
                p[v] = ((n / (a + 1)) * 2) as f64 / b as f64 - 1.0;
                on_sphere(p)
            }));
            mesh.triangles
                .par_extend((0..a * b).into_par_iter().flat_map_iter(|n| grid_cell(first, a, n % a, n / a)));
        }
    }
    weld(&mut mesh);
    mesh.normals = Some(mesh.positions.par_iter().map(|&p| OctNormal::encode(p)).collect());
    mesh
}

fn on_sphere(p: [f64; 3]) -> [f32; 3] {
    let s = p.map(|x| x * x);
    std::array::from_fn(|k| {
        // The lower axis first, so that both sides compute the same bits on their common border.
        let (y, z) = (s[if k == 0 { 1 } else { 0 }], s[if k == 2 { 1 } else { 2 }]);
        (p[k] * (1.0 - 0.5 * y - 0.5 * z + y * z / 3.0).max(0.0).sqrt()) as f32
    })
}

/// Cells along each axis, differing by at most one, whose surface comes closest to half of `count`.
fn divisions(count: u64) -> [u64; 3] {
    let n = ((count as f64 / 12.0).sqrt() as u64).max(1);
    let of = |[a, b, c]: [u64; 3]| 4 * (a * b + b * c + c * a);
    let near = [[n, n, n], [n + 1, n, n], [n + 1, n, n + 1], [n + 1, n + 1, n + 1]];
    near.into_iter().min_by_key(|&d| of(d).abs_diff(count)).unwrap_or([n; 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::analyze;

    #[test]
    fn a_sphere_is_closed_and_round() {
        for count in [1, 12, 100, 1000, 1100, 54_321] {
            let mesh = sphere(count);
            let found = analyze(&mesh);
            assert!(found.closed && found.consistently_wound && found.non_manifold_edges == 0, "{found:?}");
            assert_eq!((found.euler_characteristic(), found.components), (2, 1));
            assert_eq!(found.vertices as usize, mesh.positions.len());
            for p in &mesh.positions {
                assert!((p.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-6);
            }
            super::super::tests::check_normals(&mesh, 0.5);
        }
    }
}
