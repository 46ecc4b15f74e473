//! Lines of equal value on a surface, as segments in its triangles.

use glam::DVec3;
use tercio_mesh::AttributeDomain;
use tercio_mesh::loops::prelude::*;
use tercio_scene::data::DataReader;
use tercio_scene::{Instance, SurfaceData};

use super::hiders::before;

/// A segment in world space, and the number of its value.
pub type Piece = (usize, [DVec3; 2]);

/// Where the data of an instance have these values, which are in ascending order. Data are interpolated linearly over each
/// triangle; those at triangles have no such lines. A triangle with a corner that is not a number has none.
pub fn contours(instance: &Instance, values: &[f64]) -> Vec<Piece> {
    let Some(SurfaceData::Mapped { source, colors }) = instance.data.as_deref() else { return Vec::new() };
    let mesh = &instance.mesh;
    if source.domain(mesh.layout()) != AttributeDomain::Vertex {
        return Vec::new();
    }
    let reader = DataReader::new(source, instance, colors.offset);
    let pieces: Vec<Vec<Piece>> = (0..mesh.clusters().len())
        .into_par_iter()
        .map(|number| {
            let cluster = mesh.cluster(number);
            let mut data = vec![0.0f32; cluster.vertices()];
            reader.read_vertices(&cluster, &mut data);
            let at = |v: usize| instance.world_from_object.transform_point3(mesh.position(&cluster, v));
            let mut pieces = Vec::new();
            for t in 0..cluster.triangles() {
                let corners = cluster.corners_of(t).map(usize::from);
                in_triangle(corners.map(at), corners.map(|v| colors.full(data[v])), values, &mut pieces);
            }
            pieces
        })
        .collect();
    pieces.concat()
}

/// The lines in one triangle.
fn in_triangle(corners: [DVec3; 3], data: [f64; 3], values: &[f64], pieces: &mut Vec<Piece>) {
    if data.iter().any(|v| !v.is_finite()) || corners.iter().any(|p| !p.is_finite()) {
        return;
    }
    let least = data.iter().copied().fold(f64::INFINITY, f64::min);
    let most = data.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // A corner with the value itself counts as above it, so that a line along a side belongs to one triangle.
    let from = values.partition_point(|&value| value <= least);
    let to = values.partition_point(|&value| value <= most);
    for number in from..to.max(from) {
        let value = values[number];
        let mut ends = [DVec3::ZERO; 2];
        let mut count = 0;
        for k in 0..3 {
            let (mut a, mut b) = (k, (k + 1) % 3);
            if (data[a] < value) == (data[b] < value) || count == 2 {
                continue;
            }
            // The same point for the triangle on the other side.
            if before(corners[b], corners[a]) {
                std::mem::swap(&mut a, &mut b);
            }
            let share = (value - data[a]) / (data[b] - data[a]);
            ends[count] = match share {
                s if s <= 0.0 => corners[a],
                s if s >= 1.0 => corners[b],
                s => corners[a].lerp(corners[b], s),
            };
            count += 1;
        }
        if count == 2 && ends[0] != ends[1] {
            pieces.push((number, ends));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_where_the_value_is() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let lines = |data: [f64; 3], values: &[f64]| {
            let mut pieces = Vec::new();
            in_triangle(corners, data, values, &mut pieces);
            pieces
        };
        assert_eq!(lines([0.0, 1.0, 0.0], &[0.25]), [(0, [DVec3::X * 0.25, DVec3::new(0.25, 0.75, 0.0)])]);
        assert_eq!(lines([0.0, 1.0, 2.0], &[-1.0, 0.5, 1.5, 2.5]).len(), 2);
        // Along a side: in the triangle below it only.
        assert_eq!(lines([0.0, 1.0, 1.0], &[1.0]), [(0, [DVec3::X, DVec3::Y])]);
        assert!(lines([2.0, 1.0, 1.0], &[1.0]).is_empty());
        assert!(lines([1.0; 3], &[1.0]).is_empty());
        assert!(lines([f64::NAN, 0.0, 2.0], &[1.0]).is_empty());
    }
}
