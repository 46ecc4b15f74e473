//! Edges of an indexed mesh, and of one in clusters.

use crate::loops::prelude::*;

use super::{Edges, Selection, find};
use crate::{Attribute, ClusteredMesh, Mesh};

pub fn of_mesh(mesh: &Mesh, selection: Selection) -> Edges {
    let face = mesh.face_of_triangle.as_deref();
    let is_polygon = |a: &&Attribute| Attribute::is_polygon(&a.name, a.domain);
    let polygons = mesh.attributes.iter().find(is_polygon).map(|a| &a.values[..]);
    let polygon = |t: u32| {
        (face.map_or(t, |faces| faces[t as usize]), polygons.map_or(0, |all| all[t as usize].to_bits()))
    };
    find::edges(mesh, selection, polygon, Mesh::canonical)
}

/// Rebuilds the indexed mesh. Its vertices have other numbers, which the result does not depend on; triangles have the same.
pub fn of_clusters(mesh: &ClusteredMesh, selection: Selection) -> Edges {
    let clusters = mesh.clusters().len();
    let mut firsts = Vec::with_capacity(clusters);
    let (mut vertices, mut triangles) = (0u32, 0u32);
    for head in mesh.clusters() {
        firsts.push((vertices, triangles));
        vertices += u32::from(head.vertices);
        triangles += u32::from(head.triangles);
    }
    let positions: Vec<[f32; 3]> = (0..clusters)
        .into_par_iter()
        .flat_map_iter(|number| {
            let cluster = mesh.cluster(number);
            let [x, y, z] = cluster.positions();
            (0..cluster.vertices()).map(move |v| [x[v], y[v], z[v]])
        })
        .collect();
    let polygon =
        mesh.layout().attributes.iter().position(|(name, domain)| Attribute::is_polygon(name, *domain));
    let mut numbered: Vec<(u32, find::Polygon, [u32; 3])> = firsts
        .par_iter()
        .enumerate()
        .flat_map_iter(|(number, &(first, _))| {
            let cluster = mesh.cluster(number);
            (0..cluster.triangles()).map(move |t| {
                let corners = cluster.corners_of(t).map(|corner| first + u32::from(corner));
                let part = polygon.map_or(0, |attribute| cluster.attribute(attribute)[t].to_bits());
                (cluster.primitive(t), (mesh.face(number, t), part), corners)
            })
        })
        .collect();
    numbered.par_sort_unstable_by_key(|triangle| triangle.0);
    let polygons: Vec<find::Polygon> = numbered.par_iter().map(|triangle| triangle.1).collect();
    let triangles = numbered.into_par_iter().map(|triangle| triangle.2).collect();
    let indexed =
        Mesh { origin: mesh.origin, exponent: mesh.exponent, positions, triangles, ..Mesh::default() };
    // Clusters have canonical triangles already, in the numbers of the mesh.
    find::edges(&indexed, selection, |t| polygons[t as usize], |corners| corners)
}
