//! The reference formulas for the colours of data at a point.

use tercio_mesh::Mesh;
use tercio_scene::Vertex;

use super::shading::{Vec3, dot, each, shading_distance};
use crate::conventions::SUBPIXELS;
use crate::data::{DataTable, spread};
use crate::settings::Settings;

/// The values at the corners of a triangle, of one component.
fn at_corners(data: &DataTable, mesh: &Mesh, triangle: usize, component: usize) -> [f32; 3] {
    let reader = data.reader(component);
    if data.is_at_triangles() {
        let face = mesh.face_of_triangle.as_ref().map_or(triangle as u32, |faces| faces[triangle]);
        let color = mesh.face_colors.as_ref().map(|colors| colors[triangle]);
        return [reader.of_triangle(face, color, |number| mesh.attributes[number].values[triangle]); 3];
    }
    Mesh::canonical(mesh.triangles[triangle]).map(|v| {
        let v = v as usize;
        let vertex = Vertex {
            position: mesh.positions[v],
            normal: mesh.normals.as_ref().map(|normals| normals[v].decode()),
            texcoord: mesh.texcoords.as_ref().map(|texcoords| texcoords[v]),
            color: mesh.vertex_colors.as_ref().map(|colors| colors[v]),
        };
        reader.of_vertex(&vertex, |number| mesh.attributes[number].values[v])
    })
}

/// The linear colours at the corners, if the data are colours.
pub fn direct_colors(data: &DataTable, mesh: &Mesh, triangle: usize) -> Option<[Vec3; 3]> {
    direct(data, mesh, triangle).map(|colors| colors.map(|[r, g, b, _]| [r, g, b]))
}

/// The alphas at the corners, if the data are colours.
pub fn direct_alphas(data: &DataTable, mesh: &Mesh, triangle: usize) -> Option<[f32; 3]> {
    direct(data, mesh, triangle).map(|colors| colors.map(|color| color[3]))
}

fn direct(data: &DataTable, mesh: &Mesh, triangle: usize) -> Option<[[f32; 4]; 3]> {
    let corner = |k: usize| data.color(|component| at_corners(data, mesh, triangle, component)[k]);
    data.is_direct().then(|| [corner(0), corner(1), corner(2)])
}

/// The linear colour and alpha of values at a point with these weights of the corners; `None` if the data are colours themselves.
/// `gradients` are the changes of the weights from one shaded point to the next, to the right and downwards.
pub fn colors_of(
    data: &DataTable,
    mesh: &Mesh,
    triangle: usize,
    weight: [f32; 3],
    gradients: [Vec3; 2],
    settings: &Settings,
) -> Option<(Vec3, f32)> {
    if data.is_direct() {
        return None;
    }
    let mapping = &data.mapping;
    let values = at_corners(data, mesh, triangle, 0);
    let [a, b, c] = values;
    let [nan, below, above] = mapping.special;
    let mut cover = 0.0;
    let entry = if !mapping.categories.is_empty() {
        let nearest = if weight[1] > weight[0] { 1 } else { 0 };
        let nearest = if weight[2] > weight[nearest] { 2 } else { nearest };
        let found = mapping.categories.iter().position(|&category| category == values[nearest]);
        found.map_or(nan, |number| number as i32)
    } else {
        let value = (a + weight[1] * (b - a)) + weight[2] * (c - a);
        let [low, high] = [values.into_iter().fold(a, f32::min), values.into_iter().fold(a, f32::max)];
        let value = if a == b && b == c {
            a
        } else if value < low {
            low
        } else if value > high {
            high
        } else {
            value
        };
        if value.is_nan() || values.iter().any(|v| v.is_nan()) {
            nan
        } else {
            if !mapping.isolines.is_empty() {
                let [x, y] = gradients.map(|change| dot(change, each(|k| values[k] - value)));
                let nearest =
                    mapping.isolines.iter().map(|line| (value - line).abs()).fold(f32::INFINITY, f32::min);
                let pixels =
                    (nearest / (x * x + y * y).sqrt()) * (shading_distance(settings) / SUBPIXELS as f32);
                let within = (mapping.half_width + 0.5) - pixels;
                cover = if within > 0.0 { within.min(1.0) } else { 0.0 } * mapping.line[3];
            }
            let [first, last] = mapping.range;
            let position =
                (spread(mapping.spread, value.clamp(first, last)) - mapping.start) / mapping.length;
            let place = position * mapping.index[0] + mapping.index[1];
            match value {
                v if v < first => below,
                v if v > last => above,
                _ => (place as i32).clamp(0, mapping.last),
            }
        }
    };
    let [r, g, b, alpha] = mapping.entries[entry as usize];
    if mapping.isolines.is_empty() {
        return Some(([r, g, b], alpha));
    }
    let whole = alpha + (1.0 - alpha) * cover;
    let share = if whole > 0.0 { cover / whole } else { 0.0 };
    let color = [r, g, b];
    Some((each(|k| color[k] + (mapping.line[k] - color[k]) * share), whole))
}
