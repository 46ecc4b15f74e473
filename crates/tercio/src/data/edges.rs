//! Data of edges.

use std::sync::Arc;

use glam::DAffine3;
use tercio_mesh::AttributeDomain;
use tercio_mesh::cluster::ClusterView;
use tercio_mesh::edges::{Edge, Edges};
use tercio_mesh::loops::prelude::*;
use tercio_scene::{DataColors, DataReader, Instance, SurfaceData};

use super::strokes::{StrokeData, direct};

/// The data of an instance at both ends of each of these edges of its mesh, for [`crate::strokes::edges`]; `None` if it has none.
/// An edge has the values that the first of its triangles has at its ends, or the value of that triangle: so the result does not
/// depend on how the mesh is split into clusters.
///
/// # Panics
/// If the edges are not those of [`Edges::of_clusters`] of this mesh.
pub fn of_edges(instance: &Instance, edges: &Edges) -> Option<StrokeData> {
    of_edges_at(instance, edges, &[instance.world_from_object]).pop()
}

/// As [`of_edges`], for each of these places of the instance in the world; none if it has no data.
///
/// # Panics
/// As [`of_edges`].
pub fn of_edges_at(instance: &Instance, edges: &Edges, places: &[DAffine3]) -> Vec<StrokeData> {
    let Some(data) = instance.data.as_deref() else { return Vec::new() };
    let order = Order::new(instance, edges);
    let at_place = |&world_from_object: &DAffine3| {
        let placed = Instance { world_from_object, ..instance.clone() };
        match data {
            SurfaceData::Mapped { source, colors } => {
                let values = order.values(&DataReader::new(source, &placed, colors.offset));
                // Lines of equal value would cross edges.
                let colors = Arc::new(DataColors { isolines: None, ..(**colors).clone() });
                StrokeData::Mapped { values, colors }
            }
            SurfaceData::Direct { components, scale, offset } => {
                let values = |source| order.values(&DataReader::new(source, &placed, 0.0));
                let components: Vec<Vec<f32>> = components.iter().map(values).collect();
                direct(&components, *scale, *offset)
            }
        }
    };
    places.iter().map(at_place).collect()
}

/// Where the values of edges are.
struct Order<'a> {
    instance: &'a Instance,
    edges: &'a Edges,
    domain: AttributeDomain,
    /// The cluster of each triangle, and its number there, in the order of [`Edges::sides`].
    triangles: Vec<(u32, u32)>,
}

impl<'a> Order<'a> {
    fn new(instance: &'a Instance, edges: &'a Edges) -> Self {
        let mesh = &instance.mesh;
        let mut triangles: Vec<(u32, (u32, u32))> = (0..mesh.clusters().len())
            .into_par_iter()
            .flat_map_iter(|number| {
                let cluster = mesh.cluster(number);
                (0..cluster.triangles()).map(move |t| (cluster.primitive(t), (number as u32, t as u32)))
            })
            .collect();
        triangles.par_sort_unstable();
        let triangles = triangles.into_iter().map(|(_, place)| place).collect();
        let data = instance.data.as_deref();
        let domain = data.map_or(AttributeDomain::Vertex, |data| data.domain(mesh.layout()));
        Self { instance, edges, domain, triangles }
    }

    /// Two values an edge.
    fn values(&self, reader: &DataReader) -> Vec<f32> {
        let mesh = &self.instance.mesh;
        let of_edge = |edge: &Edge| {
            let (number, triangle) = self.triangles[edge.triangle as usize];
            let (number, triangle) = (number as usize, triangle as usize);
            let cluster = mesh.cluster(number);
            match self.domain {
                AttributeDomain::Triangle => [reader.triangle(mesh, number, &cluster, triangle); 2],
                AttributeDomain::Vertex => edge.ends.map(|end| {
                    let at = self.edges.positions[end as usize];
                    reader.vertex(&cluster, corner_at(&cluster, triangle, at))
                }),
            }
        };
        self.edges.list.par_iter().flat_map_iter(of_edge).collect()
    }
}

/// The vertex of a triangle at this position.
fn corner_at(cluster: &ClusterView, triangle: usize, at: [f32; 3]) -> usize {
    let corners = cluster.corners_of(triangle).map(usize::from);
    corners.into_iter().find(|&corner| cluster.position(corner) == at).unwrap_or(corners[0])
}
