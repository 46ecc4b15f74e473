//! Splits triangles, to make larger models of the same shape.

use std::collections::HashMap;

use crate::{Mesh, OctNormal};

/// Splits every triangle into four, at the midpoints of its edges; the shape is unchanged. Positions, normals,
/// triangle colours and materials are kept, everything else is dropped.
///
/// Triangle t becomes triangles 4t to 4t + 3; the midpoints of the edges come after the old vertices.
///
/// # Panics
/// If the result has more vertices than can be numbered.
pub fn subdivide(mesh: &Mesh) -> Mesh {
    let mut positions = mesh.positions.clone();
    let mut normals = mesh.normals.clone();
    let mut triangles = Vec::with_capacity(mesh.triangles.len() * 4);
    let mut middles = HashMap::with_capacity(mesh.triangles.len() * 3 / 2);
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let (p, q) = (positions[a.min(b) as usize], positions[a.max(b) as usize]);
            positions.push([0, 1, 2].map(|k| p[k] * 0.5 + q[k] * 0.5));
            if let Some(normals) = &mut normals {
                let (m, n) = (unit(normals[a.min(b) as usize]), unit(normals[a.max(b) as usize]));
                normals.push(OctNormal::encode((m + n).to_array()));
            }
            u32::try_from(positions.len() - 1).expect("vertices are numbered in 32 bits")
        })
    };
    for &[a, b, c] in &mesh.triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    let four_times = |v: &Vec<_>| v.iter().flat_map(|&v| [v; 4]).collect();
    Mesh {
        origin: mesh.origin,
        exponent: mesh.exponent,
        positions,
        normals,
        triangles,
        face_colors: mesh.face_colors.as_ref().map(|v| v.iter().flat_map(|&v| [v; 4]).collect()),
        materials: mesh.materials.clone(),
        triangle_materials: mesh.triangle_materials.as_ref().map(four_times),
        ..Mesh::default()
    }
}

fn unit(n: OctNormal) -> glam::Vec3 {
    glam::Vec3::from(n.decode()).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::analyze;

    #[test]
    fn the_surface_stays_closed_and_as_large() {
        let area = |mesh: &Mesh| -> f64 {
            let p = |v: u32| glam::Vec3::from(mesh.positions[v as usize]).as_dvec3();
            let twice = |t: &[u32; 3]| (p(t[1]) - p(t[0])).cross(p(t[2]) - p(t[0])).length();
            mesh.triangles.iter().map(twice).sum()
        };
        let sphere = crate::builtin::make("builtin:sphere@2k").expect("a sphere");
        let split = subdivide(&sphere);
        assert_eq!(split.triangles.len(), 4 * sphere.triangles.len());
        assert!(analyze(&split).closed && analyze(&split).consistently_wound);
        assert_eq!(analyze(&split).euler_characteristic(), 2);
        assert!((area(&split) / area(&sphere) - 1.0).abs() < 1e-6);
    }
}
