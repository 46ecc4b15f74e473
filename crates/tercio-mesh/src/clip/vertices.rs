//! The vertices of cut edges, and the arrays of what is left.

use crate::loops::prelude::*;
use glam::Vec3;

use super::plane::LocalPlane;
use crate::color::{linear_to_srgb, srgb_to_linear};
use crate::{AttributeDomain, Mesh, OctNormal};

/// An edge from a vertex that is kept to one that is not.
#[derive(Clone, Copy)]
struct Crossing {
    kept: u32,
    removed: u32,
    /// Where it meets the plane: 0 at the vertex that is kept, 1 at the other.
    at: f64,
}

/// Appends a vertex for each of these edges, which lead from a vertex that is kept to one that is not: where the edge
/// meets the plane, with everything that vertices have interpolated, colours in linear light.
///
/// The position follows from those of the two ends alone, so that it is the same on both sides of a seam, where
/// vertices of several numbers have the same position.
pub(super) fn append_crossings(mesh: &mut Mesh, edges: &[(u32, u32)], plane: &LocalPlane) {
    let positions = &mesh.positions;
    let crossings: Vec<Crossing> = edges
        .par_iter()
        .map(|&(kept, removed)| {
            let [from, to] = [kept, removed].map(|v| plane.distance(positions[v as usize]));
            Crossing { kept, removed, at: from / (from - to) }
        })
        .collect();
    let crossings = crossings.as_slice();
    append(&mut mesh.positions, crossings, |a, b, at| [0, 1, 2].map(|k| mix(a[k], b[k], at)));
    if let Some(normals) = &mut mesh.normals {
        append(normals, crossings, mix_normals);
    }
    if let Some(colors) = &mut mesh.vertex_colors {
        let linear: Vec<f64> = (0..=255).map(|level| srgb_to_linear(f64::from(level) / 255.0)).collect();
        append(colors, crossings, |a, b, at| mix_colors(&linear, a, b, at));
    }
    if let Some(texcoords) = &mut mesh.texcoords {
        append(texcoords, crossings, |a, b, at| [0, 1].map(|k| mix(a[k], b[k], at)));
    }
    for attribute in mesh.attributes.iter_mut().filter(|a| a.domain == AttributeDomain::Vertex) {
        append(&mut attribute.values, crossings, mix);
    }
}

fn append<T: Copy + Send + Sync>(
    array: &mut Vec<T>,
    crossings: &[Crossing],
    mix: impl Fn(T, T, f64) -> T + Sync,
) {
    let old = array.as_slice();
    let new: Vec<T> =
        crossings.par_iter().map(|c| mix(old[c.kept as usize], old[c.removed as usize], c.at)).collect();
    array.extend(new);
}

fn mix(a: f32, b: f32, at: f64) -> f32 {
    let (from, to) = (f64::from(a), f64::from(b));
    // Zero is positive, so that equal positions have equal bits.
    (from + (to - from) * at) as f32 + 0.0
}

fn mix_normals(a: OctNormal, b: OctNormal, at: f64) -> OctNormal {
    let [from, to] = [a, b].map(|n| Vec3::from(n.decode()).normalize_or_zero());
    let mixed = from + (to - from) * at as f32;
    if mixed.length_squared() > 1e-12 { OctNormal::encode(mixed.to_array()) } else { a }
}

fn mix_colors(linear: &[f64], a: [u8; 4], b: [u8; 4], at: f64) -> [u8; 4] {
    if a == b {
        return a;
    }
    let between = |from: f64, to: f64| from + (to - from) * at;
    let level = |part: f64| (part * 255.0 + 0.5) as u8;
    std::array::from_fn(|k| {
        let [from, to] = [a[k], b[k]].map(usize::from);
        if k == 3 {
            level(between(from as f64 / 255.0, to as f64 / 255.0))
        } else {
            level(linear_to_srgb(between(linear[from], linear[to])))
        }
    })
}

/// Makes the arrays of triangles those of new triangles, which are pieces of the old ones with these numbers, in
/// ascending order. Faces keep their numbers.
pub(super) fn inherit(mesh: &mut Mesh, sources: &[u32]) {
    fn take<T: Copy + Send + Sync>(array: &mut Vec<T>, sources: &[u32]) {
        *array = sources.par_iter().map(|&s| array[s as usize]).collect();
    }
    if let Some(colors) = &mut mesh.face_colors {
        take(colors, sources);
    }
    if let Some(materials) = &mut mesh.triangle_materials {
        take(materials, sources);
    }
    match &mut mesh.face_of_triangle {
        Some(faces) => take(faces, sources),
        none => *none = Some(sources.to_vec()),
    }
    for attribute in mesh.attributes.iter_mut().filter(|a| a.domain == AttributeDomain::Triangle) {
        take(&mut attribute.values, sources);
    }
}

/// Drops the vertices that no triangle uses; the others keep their order.
pub(super) fn drop_unused(mesh: &mut Mesh) {
    let used = used(mesh);
    let mut count = 0;
    let numbers: Vec<u32> = used
        .iter()
        .map(|&is_used| {
            let number = count;
            count += u32::from(is_used);
            number
        })
        .collect();
    mesh.triangles.par_iter_mut().for_each(|t| *t = t.map(|v| numbers[v as usize]));
    retain(&mut mesh.positions, &used);
    if let Some(normals) = &mut mesh.normals {
        retain(normals, &used);
    }
    if let Some(colors) = &mut mesh.vertex_colors {
        retain(colors, &used);
    }
    if let Some(texcoords) = &mut mesh.texcoords {
        retain(texcoords, &used);
    }
    for attribute in mesh.attributes.iter_mut().filter(|a| a.domain == AttributeDomain::Vertex) {
        retain(&mut attribute.values, &used);
    }
}

/// For each vertex whether a triangle uses it.
pub(super) fn used(mesh: &Mesh) -> Vec<bool> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
    used
}

fn retain<T>(array: &mut Vec<T>, used: &[bool]) {
    let mut number = 0;
    array.retain(|_| {
        number += 1;
        used[number - 1]
    });
    array.shrink_to_fit();
}
