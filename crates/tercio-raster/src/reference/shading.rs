//! The reference formulas for the shading of one pixel.

use tercio_mesh::{Mesh, OctNormal};
use tercio_scene::{Scene, Surface};

use super::data::{colors_of, direct_alphas, direct_colors};
use super::edges;
use super::material::{bumped, evaluate, lights as seen_lights, material_of, phong, physical};
use super::texture::TexturePoint;
use crate::color::DECODE;
use crate::context::is_elaborate;
use crate::conventions::{SMALL_EXTENT, SUBPIXELS};
use crate::data::DataTable;
use crate::lighting::{LightRig, WideLight};
use crate::projection::clip::{barycentric_change, barycentrics_unclipped};
use crate::sampling::SampleShading;
use crate::settings::{Settings, Shading};
use crate::shadow_map::ObjectShadows;
use crate::tone::Tone;
use crate::view::{ObjectView, ScreenVertex};

/// The result of shading a pixel.
pub struct Shaded {
    /// Premultiplied.
    pub linear: [f32; 4],
    pub normal: [f32; 3],
}

pub type Vec3 = [f32; 3];

/// Light after tone mapping; unlit colours are not mapped.
fn toned(light: Vec3, shading: Shading, settings: &Settings) -> Vec3 {
    if shading == Shading::Unlit || settings.tone == Tone::NONE {
        return light;
    }
    settings.tone.map(light)
}

/// Linear light as a display shows it: from 0 to 1, NaN as 0.
pub fn shown(linear: f32) -> f32 {
    match linear {
        above if above >= 1.0 => 1.0,
        light if light > 0.0 => light,
        _ => 0.0,
    }
}

pub fn dot(a: Vec3, b: Vec3) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn each(f: impl Fn(usize) -> f32) -> Vec3 {
    [0, 1, 2].map(f)
}

/// A unit vector; `instead` if the length is close to zero.
pub fn normalize(v: Vec3, instead: Vec3) -> Vec3 {
    let square = dot(v, v);
    let inverse = 1.0 / square.sqrt();
    if square > 1e-30 { v.map(|c| c * inverse) } else { instead }
}

/// Bends a unit normal that points away from the viewer until it is perpendicular to the line of sight; returns any
/// other one unchanged. `to_viewer` need not be normalized.
fn bend(n: Vec3, to_viewer: Vec3) -> Vec3 {
    let away = dot(n, to_viewer);
    if away < 0.0 {
        let square = dot(to_viewer, to_viewer);
        normalize(each(|k| n[k] * square - to_viewer[k] * away), n)
    } else {
        n
    }
}

/// Shades a point, in sub-pixels from the upper left corner of the picture, at which triangle number `triangle` is
/// visible.
#[expect(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
pub fn shade(
    mesh: &Mesh,
    triangle: usize,
    scene: &Scene,
    instance: usize,
    object: &ObjectView,
    lights: &LightRig,
    shadows: Option<&ObjectShadows>,
    data: Option<&DataTable>,
    settings: &Settings,
    sample: [i32; 2],
) -> Shaded {
    let instance = &scene.instances[instance];
    let (surface, shading) = (&instance.surface, settings.shading.of(&instance.surface));
    let corners = Mesh::canonical(mesh.triangles[triangle]).map(|v| v as usize);
    let p = corners.map(|v| mesh.positions[v]);
    let Interpolation { area, scale, weight, right, down, slopes } =
        interpolation(object, p, sample, settings);
    let mix = |v: [f32; 3]| (weight[0] * v[0] + weight[1] * v[1]) + weight[2] * v[2];
    let mix3 = |v: [Vec3; 3]| each(|k| mix(v.map(|v| v[k])));

    let with_edges = |light: Vec3| match &instance.edges {
        Some(lines) => edges::over(
            lines,
            triangle,
            (object, p),
            (area, slopes[0], slopes[1]),
            scale,
            settings,
            sample,
            light,
        ),
        None => light,
    };

    let edge = |k: usize| each(|a| (p[k][a] - p[0][a]) * object.edge_scale);
    let clockwise = area.iter().any(|&a| a < 0.0);
    let to_world = |n: Vec3| each(|k| dot(n, object.normal_matrix[k]));
    let as_seen = |n: Vec3| if clockwise { n.map(|c| -c) } else { n };
    let plane = as_seen(to_world(cross(edge(1), edge(2))));

    let sight = &lights.sight;
    let position_of = |q: Vec3| {
        each(|k| {
            let r = object.eye_from_local[k];
            ((q[0] * r[0] + q[1] * r[1]) + q[2] * r[2]) + object.eye_from_pivot[k]
        })
    };
    // Unit normals are on the visible side of the triangle's plane, and do not point away from the viewer.
    let unit = |n: Vec3, to_viewer: Vec3| {
        let n = if dot(n, plane) < 0.0 { n.map(|c| -c) } else { n };
        bend(normalize(n, sight.base), to_viewer)
    };
    let normals = mesh.normals.as_ref();
    // The unit normal of a corner, times the corner's weight in perspective interpolation.
    let corner_normal = |n: &[OctNormal], k: usize| {
        normalize(to_world(n[corners[k]].decode()), sight.base).map(|c| c * scale[k])
    };

    // Positions relative to the pivot, as `position_of` expects them.
    let relative = p.map(|p| object.relative(p));
    let position = position_of(mix3(relative));
    let to_viewer = sight.at([0, 1].map(|k| sample[k] - sight.middle[k]));
    let normal = match normals {
        Some(normals) if shading != Shading::Flat => {
            let m = [0, 1, 2].map(|k| corner_normal(normals, k));
            each(|c| (area[0] * m[0][c] + area[1] * m[1][c]) + area[2] * m[2][c])
        }
        _ => plane,
    };
    let normal = unit(normal, to_viewer);
    // The colour and alpha of data or of the mesh, if the surface does not have its own.
    let of_data = data.and_then(|data| colors_of(data, mesh, triangle, weight, [right, down], settings));
    let corner_colors = |has_own: bool| match data {
        Some(data) => direct_colors(data, mesh, triangle),
        None if has_own => corner_colors(mesh, triangle, surface),
        None => None,
    };
    let corner_alphas = || match data {
        Some(data) => direct_alphas(data, mesh, triangle),
        None => corner_alphas(mesh, triangle, surface),
    };
    let has_materials = instance.materials.is_some() && instance.uses_mesh_colors();
    if has_materials || is_elaborate(settings, lights) {
        let texcoords = mesh.texcoords.as_ref().map(|t| corners.map(|v| t[v]));
        let point = texcoords.map(|t| {
            let uv = [0, 1].map(|k| mix(t.map(|t| t[k])));
            let change = |by: Vec3| [0, 1].map(|k| dot(by, t.map(|t| t[k] - uv[k])));
            TexturePoint { uv, right: change(right), down: change(down) }
        });
        let color = corner_colors(has_own_colors(mesh) || !has_materials).map(mix3);
        let own = color.map(|color| (color, corner_alphas().map_or(1.0, |a| alpha(a, weight)))).or(of_data);
        let material = material_of(scene, instance, mesh, triangle);
        let m = evaluate(scene, &material, settings.texture_filter, point.as_ref(), own);
        let mut lit_normal = normal;
        if let (Some(tangent), Some(t), Some(map)) = (m.normal, texcoords, &material.normal_map) {
            let in_world = |k: usize| {
                let e = edge(k);
                each(|axis| dot(e, object.eye_from_local[axis]))
            };
            let uv = |k: usize| [0, 1].map(|c| (t[k][c] - t[0][c]) * map.scale[c]);
            lit_normal = bend(bumped(normal, [in_world(1), in_world(2)], [uv(1), uv(2)], tangent), to_viewer);
        }
        let to_viewer = normalize(to_viewer, sight.base);
        let from_pivot = mix3(relative);
        let seen = seen_lights(lights, position, |light| match (shadows, &settings.shadows) {
            (Some(shadows), Some(maps)) => shadows.lit(maps, light, from_pivot, plane),
            _ => 1.0,
        });
        let light = match shading {
            Shading::Unlit => m.albedo,
            Shading::Flat | Shading::Gouraud | Shading::Phong => {
                phong(lights, &seen, &m, lit_normal, to_viewer)
            }
            Shading::Physical => physical(lights, &seen, &m, lit_normal, to_viewer),
        };
        let alpha = m.alpha * surface.opacity;
        let [r, g, b] = with_edges(toned(light, shading, settings)).map(|c| shown(c) * alpha);
        return Shaded { linear: [r, g, b, alpha], normal };
    }
    let albedo = match (of_data, corner_colors(true)) {
        (Some((color, _)), _) => color,
        (None, Some(colors)) => mix3(colors),
        (None, None) => surface.base_color,
    };
    let linear = match shading {
        Shading::Unlit => albedo,
        Shading::Flat | Shading::Phong => {
            let to_viewer = normalize(to_viewer, sight.base);
            let (diffuse, specular) = reflect(lights, surface, normal, to_viewer, position);
            each(|k| albedo[k] * diffuse[k] + specular[k])
        }
        Shading::Physical => unreachable!("has materials"),
        Shading::Gouraud => {
            let light = [0, 1, 2].map(|k| {
                let position = position_of(relative[k]);
                let to_viewer =
                    if object.perspective { normalize(position.map(|c| -c), sight.base) } else { sight.base };
                let normal = normals.map_or(plane, |n| as_seen(corner_normal(n, k)));
                reflect(lights, surface, unit(normal, to_viewer), to_viewer, position)
            });
            let (diffuse, specular) = (mix3(light.map(|l| l.0)), mix3(light.map(|l| l.1)));
            each(|k| albedo[k] * diffuse[k] + specular[k])
        }
    };
    let own_alpha = || corner_alphas().map_or(1.0, |a| alpha(a, weight));
    let alpha = of_data.map_or_else(own_alpha, |(_, alpha)| alpha) * surface.opacity;
    let [r, g, b] = with_edges(toned(linear, shading, settings)).map(|c| shown(c) * alpha);
    Shaded { linear: [r, g, b, alpha], normal }
}

/// Interpolates the alphas of corners: exactly theirs if they have the same.
fn alpha(a: [f32; 3], weight: [f32; 3]) -> f32 {
    let mixed = (a[0] + weight[1] * (a[1] - a[0])) + weight[2] * (a[2] - a[0]);
    mixed.clamp(0.0, 1.0)
}

/// Does a mesh have colours other than those of its materials?
fn has_own_colors(mesh: &Mesh) -> bool {
    mesh.face_colors.is_some() || mesh.vertex_colors.is_some()
}

/// Linear colours of a triangle's corners; `None` if the surface's own colour is used.
fn corner_colors(mesh: &Mesh, triangle: usize, surface: &Surface) -> Option<[Vec3; 3]> {
    let linear = |c: [u8; 4]| [0, 1, 2].map(|k| DECODE[usize::from(c[k])]);
    if !surface.use_mesh_colors {
        None
    } else if let Some(colors) = &mesh.face_colors {
        Some([linear(colors[triangle]); 3])
    } else if let Some(colors) = &mesh.vertex_colors {
        Some(Mesh::canonical(mesh.triangles[triangle]).map(|v| linear(colors[v as usize])))
    } else {
        let materials = mesh.triangle_materials.as_ref().filter(|_| !mesh.materials.is_empty())?;
        let level = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let color = match mesh.materials.get(materials[triangle] as usize) {
            Some(m) => linear([level(m.diffuse[0]), level(m.diffuse[1]), level(m.diffuse[2]), 255]),
            None => surface.base_color,
        };
        Some([color; 3])
    }
}

/// The alphas of a triangle's corners; `None` if the surface's own colour is used.
fn corner_alphas(mesh: &Mesh, triangle: usize, surface: &Surface) -> Option<[f32; 3]> {
    let alpha = |c: [u8; 4]| f32::from(c[3]) / 255.0;
    if !surface.use_mesh_colors {
        None
    } else if let Some(colors) = &mesh.face_colors {
        Some([alpha(colors[triangle]); 3])
    } else if let Some(colors) = &mesh.vertex_colors {
        Some(Mesh::canonical(mesh.triangles[triangle]).map(|v| alpha(colors[v as usize])))
    } else {
        let material = mesh.triangle_materials.as_ref()?[triangle];
        let opacity = |opacity: f32| if opacity < 1.0 { opacity.max(0.0) } else { 1.0 };
        mesh.materials.get(material as usize).map(|m| [opacity(m.opacity); 3])
    }
}

/// The position of a point in its triangle.
struct Interpolation {
    /// Twice the areas of the triangles between the sample and two corners: positive if the triangle appears
    /// counter-clockwise.
    area: [f32; 3],
    /// The weights of the corners in perspective interpolation, by which the areas are multiplied.
    scale: [f32; 3],
    /// The absolute products, normalized to add up to 1: perspective-correct barycentric coordinates.
    weight: [f32; 3],
    /// The change of something from pixel to pixel, to the right and downwards, is the sum of these times its differences
    /// between the corners and the point.
    right: [f32; 3],
    down: [f32; 3],
    /// The change of `area` from one sub-pixel to the next, likewise.
    slopes: [Vec3; 2],
}

/// Distance of the points at which a surface is shaded, in sub-pixels. Samples that are shaded by themselves are closer to each
/// other than pixels.
pub fn shading_distance(settings: &Settings) -> f32 {
    match settings.sampling.shading {
        SampleShading::Pixel => SUBPIXELS as f32,
        SampleShading::Sample => SUBPIXELS as f32 / (settings.sampling.pattern.count() as f32).sqrt(),
    }
}

fn interpolation(object: &ObjectView, p: [Vec3; 3], sample: [i32; 2], settings: &Settings) -> Interpolation {
    let step = shading_distance(settings);
    let v = p.map(|p| object.project(p));
    if v.iter().any(|v| !v.inside) {
        let from_middle = [0, 1].map(|k| f64::from(sample[k]) - f64::from(object.offset[k]));
        let (weight, clockwise) = barycentrics_unclipped(object, p, from_middle);
        let step = f64::from(step);
        let change = |x: f64, y: f64| {
            barycentric_change(object, p, from_middle, [from_middle[0] + x, from_middle[1] + y])
        };
        return Interpolation {
            area: weight.map(|w| if clockwise { -w } else { w }),
            scale: [1.0; 3],
            weight,
            right: change(step, 0.0),
            down: change(0.0, step),
            slopes: [change(1.0, 0.0), change(0.0, 1.0)],
        };
    }
    let area = areas(v.map(|v| v.x - sample[0]), v.map(|v| v.y - sample[1]));
    let scale = v.map(|v| if object.perspective { v.d * object.weight } else { 1.0 });
    let part = [0, 1, 2].map(|k| area[k].abs() * scale[k]);
    let sum = (part[0] + part[1]) + part[2];
    let inverse = 1.0 / sum;
    let weight = if sum > 0.0 { part.map(|p| p * inverse) } else { [1.0, 0.0, 0.0] };
    // Twice an area changes by the differences of the other two corners' coordinates.
    let per_sum = if sum > 0.0 { step / sum } else { 0.0 };
    let change = |difference: i32, k: usize| (difference as f32 * scale[k]) * per_sum;
    let right = [0, 1, 2].map(|k| change(v[(k + 2) % 3].y - v[(k + 1) % 3].y, k));
    let down = [0, 1, 2].map(|k| change(v[(k + 1) % 3].x - v[(k + 2) % 3].x, k));
    let difference = |axis: fn(&ScreenVertex) -> i32, k: usize, l: usize| {
        (axis(&v[(k + l) % 3]) - axis(&v[(k + 3 - l) % 3])) as f32
    };
    let slopes = [each(|k| difference(|v| v.y, k, 2)), each(|k| difference(|v| v.x, k, 1))];
    Interpolation { area, scale, weight, right, down, slopes }
}

/// Twice the areas of the triangles between the sample and two corners, which are given relative to the sample.
fn areas(x: [i32; 3], y: [i32; 3]) -> [f32; 3] {
    let is_near = |v: &i32| (-SMALL_EXTENT..SMALL_EXTENT).contains(v);
    if x.iter().chain(&y).all(is_near) {
        return [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            (y[i] * x[j] - x[i] * y[j]) as f32
        });
    }
    let (x, y) = (x.map(|v| v as f32), y.map(|v| v as f32));
    let area = [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        y[i] * x[j] - x[i] * y[j]
    });
    // Rounding may give one of them the wrong sign; it is then set to 0.
    let clockwise = (area[0] + area[1]) + area[2] < 0.0;
    area.map(|a| if (a < 0.0 && !clockwise) || (a > 0.0 && clockwise) { 0.0 } else { a })
}

/// Diffuse and specular light of all lights.
fn reflect(
    lights: &LightRig,
    surface: &Surface,
    normal: Vec3,
    to_viewer: Vec3,
    position: Vec3,
) -> (Vec3, Vec3) {
    let mut diffuse = wide(lights, normal);
    let mut specular = [0.0; 3];
    let highlight = |to_light: Vec3| {
        let half = normalize(each(|k| to_light[k] + to_viewer[k]), lights.sight.base);
        let lit = dot(normal, to_light) > 0.0;
        let mut power = dot(normal, half);
        power = if lit && power > 0.0 { power } else { 0.0 };
        (0..surface.shininess_log2).for_each(|_| power *= power);
        power * surface.specular
    };
    let distant = lights.distant.iter().map(|l| (l.to_light, l.color));
    let near = lights.near.iter().map(|l| {
        let to_light = normalize(each(|k| l.position[k] - position[k]), lights.sight.base);
        (to_light, l.color)
    });
    for (to_light, color) in distant.chain(near) {
        let cosine = dot(normal, to_light);
        let lit = cosine > 0.0;
        let cosine = if lit { cosine } else { 0.0 };
        diffuse = each(|k| diffuse[k] + cosine * color[k]);
        if surface.specular > 0.0 {
            let strength = highlight(to_light);
            specular = each(|k| specular[k] + strength * color[k]);
        }
    }
    if surface.specular > 0.0 {
        for light in &lights.highlights {
            let strength = highlight(light.to_light) * dot(normal, light.to_light).max(0.0);
            specular = each(|k| specular[k] + strength * light.color[k]);
        }
    }
    (diffuse, specular)
}

/// The light of all ambient and wide lights and of the environment for a normal.
pub fn wide(lights: &LightRig, normal: Vec3) -> Vec3 {
    polynomial(&lights.wide, normal)
}

/// The value of a polynomial for a unit vector.
pub fn polynomial(wide: &WideLight, [x, y, z]: Vec3) -> Vec3 {
    each(|k| {
        let (c, l, q) = (wide.constant[k], wide.linear[k], wide.quadratic[k]);
        let of_x = x * ((x * q[0] + y * q[1]) + (z * q[2] + l[0]));
        let of_y = y * ((y * q[3] + z * q[4]) + l[1]);
        let of_z = z * (z * q[5] + l[2]);
        if wide.is_constant { c } else { ((c + of_x) + of_y) + of_z }
    })
}
