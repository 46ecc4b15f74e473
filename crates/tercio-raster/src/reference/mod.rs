//! The reference renderer: one thread, one triangle at a time, one pixel at a time.
//!
//! It is short, simple and slow, and stays so. Every faster path must produce the same bytes. It draws the plain
//! [`Mesh`], before any partition, without clusters, tiles, SIMD lanes or threads. It shares some definitions with the
//! renderer: the projection of a vertex ([`ObjectView::project`]), the clipping of a triangle ([`clip_triangle`]) and what a
//! shadow map says of a point, which tests hold against rays.
//! Coverage, depth, visibility, shading and the filter it implements by itself.

mod data;
mod edges;
mod material;
mod resolve;
mod shading;
mod texture;

use std::cmp::Ordering;

use tercio_mesh::Mesh;
use tercio_scene::{Camera, Instance, Scene};

use crate::context::{check_light, check_range, shadows_on};
use crate::conventions::SUBPIXELS;
use crate::data::{DataTable, check_data};
use crate::error::RenderError;
use crate::frame::{Frame, NO_PRIMITIVE, Pixel, key_and_tie, wide_key};
use crate::lighting::LightRig;
use crate::projection::clip::clip_triangle;
use crate::sampling::SampleShading;
use crate::settings::{Cull, Settings};
use crate::stats::FrameStats;
use crate::surface_edges::check_edges;
use crate::view::{ObjectView, ScreenVertex, View};
use shading::shade;

/// A triangle at a sample.
#[derive(Clone, Copy)]
struct Layer {
    depth: f32,
    instance: usize,
    triangle: usize,
    /// Number of the triangle in the picture.
    primitive: u64,
    /// The samples of the pixel that the triangle covers, one bit each.
    covered: u32,
}

/// Draws one picture. `meshes` are the plain meshes of the scene's instances, in order.
///
/// # Errors
/// As [`crate::Renderer::render`].
///
/// # Panics
/// If the number of meshes is not that of the instances.
pub fn render(
    meshes: &[&Mesh],
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
) -> Result<Frame, RenderError> {
    assert_eq!(meshes.len(), scene.instances.len(), "one plain mesh per instance");
    settings.check()?;
    let (width, height) = (settings.width as usize, settings.height as usize);
    let view = View::new(camera, &scene.bounds(), settings.width, settings.height)?;
    check_range(scene, settings, &view)?;
    check_light(scene)?;
    check_data(scene)?;
    check_edges(scene)?;
    let objects: Vec<ObjectView> = scene.instances.iter().map(|i| view.object(i)).collect();
    let cells = settings.sampling.pattern.cells();
    let is_opaque = !scene.instances.iter().any(Instance::is_translucent);
    let (first_primitives, first_faces, is_wide) = first_numbers(meshes, scene);
    let mut samples: Vec<Vec<Layer>> = vec![Vec::new(); width * height * cells.count];

    for (instance, mesh) in meshes.iter().enumerate() {
        let object = &objects[instance];
        for (triangle, &corners) in mesh.triangles.iter().enumerate() {
            let positions = Mesh::canonical(corners).map(|v| mesh.positions[v as usize]);
            let projected = positions.map(|p| object.project(p));
            let mut draw = |corners: [ScreenVertex; 3]| {
                rasterize(corners, object.mirrored, settings, |[x, y], sample, covered, depth| {
                    let layers = &mut samples[(y * width + x) * cells.count + sample];
                    let primitive = first_primitives[instance] + triangle as u64;
                    let new = Layer { depth, instance, triangle, primitive, covered };
                    // Of the pieces of a clipped triangle, the nearer one counts, then the one that covers more, by the
                    // number that its mask is.
                    let is_same = |old: &&mut Layer| (old.instance, old.triangle) == (instance, triangle);
                    if let Some(old) = layers.last_mut().filter(is_same) {
                        if (depth, covered) > (old.depth, old.covered) {
                            *old = new;
                        }
                    } else if !is_opaque || layers.is_empty() {
                        layers.push(new);
                    } else if is_in_front(&new, &layers[0]).is_lt() {
                        layers[0] = new;
                    }
                });
            };
            if projected.iter().all(|v| v.inside) {
                draw(projected);
            } else {
                clip_triangle(object, positions, projected, draw);
            }
        }
    }

    let lights = LightRig::new(&scene.lights, scene.environment.as_ref(), &view);
    let shadows = shadows_on(scene, &objects, camera, settings)?;
    let data: Vec<Option<DataTable>> = scene.instances.iter().map(DataTable::of).collect();
    let mut shaded_samples = Vec::with_capacity(samples.len());
    for (index, layers) in samples.iter_mut().enumerate() {
        let (number, x, y) = (index % cells.count, index / cells.count % width, index / cells.count / width);
        // The nearest first.
        layers.sort_by(is_in_front);
        let mut pixel = Pixel::of_background(&scene.background, y as u32, settings.height);
        let (mut linear, mut passing) = ([0.0; 4], 1.0);
        for layer in &*layers {
            let (mesh, object) = (meshes[layer.instance], &objects[layer.instance]);
            let offset = match settings.sampling.shading {
                SampleShading::Pixel => cells.center(layer.covered),
                SampleShading::Sample => cells.offset(number),
            };
            let at = [0, 1].map(|k| [x, y][k] as i32 * SUBPIXELS + offset[k]);
            let shaded = shade(
                mesh,
                layer.triangle,
                scene,
                layer.instance,
                object,
                &lights,
                shadows.get(layer.instance),
                data[layer.instance].as_ref(),
                settings,
                at,
            );
            let passes = 1.0 - shaded.linear[3];
            // What is invisible is not there.
            if passes == 1.0 {
                continue;
            }
            if passing == 1.0 {
                let face =
                    mesh.face_of_triangle.as_ref().map_or(layer.triangle as u32, |f| f[layer.triangle]);
                (pixel.keys, pixel.ties) = key_and_tie(wide_key(layer.depth, layer.primitive), is_wide);
                pixel.depth = view.distance(layer.depth);
                pixel.ids = (first_faces[layer.instance] + u64::from(face)) as u32;
                pixel.normals = shaded.normal;
            }
            (0..4).for_each(|k| linear[k] += passing * shaded.linear[k]);
            passing *= passes;
        }
        if passing < 1.0 {
            if passing > 0.0 {
                (0..4).for_each(|k| linear[k] += passing * pixel.linear[k]);
            }
            resolve::set_colors(&mut pixel, linear);
        }
        shaded_samples.push(pixel);
    }
    let mut frame = Frame::default();
    frame.resize(settings);
    frame.stats = FrameStats::default();
    let pixels =
        if settings.unresolved { shaded_samples } else { resolve::pixels(&shaded_samples, scene, settings) };
    let rows = settings.rows();
    let first = rows.start as usize * frame.width as usize;
    let held = frame.width as usize * rows.len();
    for (index, pixel) in pixels[first..first + held].iter().enumerate() {
        frame.planes.put(index, pixel);
    }
    Ok(frame)
}

/// Orders triangles at a sample: the nearer one first, of equal depths the one with the lower number.
fn is_in_front(a: &Layer, b: &Layer) -> Ordering {
    b.depth.total_cmp(&a.depth).then(a.primitive.cmp(&b.primitive))
}

/// Numbers of each mesh's first triangle and first face, and whether the former need more than 32 bits.
fn first_numbers(meshes: &[&Mesh], scene: &Scene) -> (Vec<u64>, Vec<u64>, bool) {
    let (mut primitives, mut faces, mut is_wide) = (Vec::new(), Vec::new(), false);
    let mut next = [0; 2];
    for (mesh, instance) in meshes.iter().zip(&scene.instances) {
        next = instance.share.and_then(|share| share.base).unwrap_or(next);
        primitives.push(next[0]);
        faces.push(next[1]);
        let count = mesh.triangles.len() as u64;
        let of_faces = match &mesh.face_of_triangle {
            Some(faces) => faces.last().map_or(0, |&last| u64::from(last) + 1),
            None => count,
        };
        next = [next[0] + count, next[1] + of_faces];
        is_wide |= next[0] >= u64::from(NO_PRIMITIVE);
    }
    (primitives, faces, is_wide)
}

/// Calls `emit(pixel, sample, covered, depth)` for every sample that a triangle covers: `sample` is its number in the
/// pixel, `covered` the mask of all samples of the pixel that the triangle covers.
fn rasterize(
    v: [ScreenVertex; 3],
    mirrored: bool,
    settings: &Settings,
    mut emit: impl FnMut([usize; 2], usize, u32, f32),
) {
    // Positive if a, b, p are in clockwise order on the screen, whose y points downwards.
    let edge =
        |a: [i64; 2], b: [i64; 2], p: [i64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let at = v.map(|v| [i64::from(v.x), i64::from(v.y)]);
    let area = edge(at[0], at[1], at[2]);
    // Front faces are counter-clockwise, those of a mirrored instance clockwise.
    let culled = match settings.cull {
        Cull::Auto | Cull::None => false,
        Cull::Back => (area > 0) != mirrored,
        Cull::Front => (area < 0) != mirrored,
    };
    if area == 0 || culled {
        return;
    }
    // Depth is interpolated from the farthest corner.
    let farthest = [1, 2].into_iter().fold(0, |f, k| if v[k].d < v[f].d { k } else { f });
    let [a, b, c] = [0, 1, 2].map(|k| v[(farthest + k) % 3]);
    let [x1, y1, x2, y2] = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y].map(|d| d as f32);
    let (d1, d2) = (b.d - a.d, c.d - a.d);
    let inverse = 1.0 / area as f32;
    let (slope_x, slope_y) = ((d1 * y2 - d2 * y1) * inverse, (d2 * x1 - d1 * x2) * inverse);

    let cells = settings.sampling.pattern.cells();
    let clockwise = if area > 0 { at } else { [at[0], at[2], at[1]] };
    let pixels = |k: usize, size: u32| {
        let (least, most) = (at.map(|p| p[k]).into_iter().min(), at.map(|p| p[k]).into_iter().max());
        let pixel = |c: Option<i64>| c.unwrap_or(0).div_euclid(i64::from(SUBPIXELS));
        pixel(least).max(0)..=pixel(most).min(i64::from(size) - 1)
    };
    for y in pixels(1, settings.height) {
        for x in pixels(0, settings.width) {
            let position = |sample: usize| {
                let [right, down] = cells.offset(sample).map(i64::from);
                [x * i64::from(SUBPIXELS) + right, y * i64::from(SUBPIXELS) + down]
            };
            let is_covered = |sample: usize| {
                (0..3).all(|k| {
                    let (from, to) = (clockwise[k], clockwise[(k + 1) % 3]);
                    let value = edge(from, to, position(sample));
                    let top_left = from[1] > to[1] || (from[1] == to[1] && to[0] > from[0]);
                    value > 0 || (value == 0 && top_left)
                })
            };
            let covered: u32 = (0..cells.count).map(|s| u32::from(is_covered(s)) << s).sum();
            for sample in (0..cells.count).filter(|s| covered >> s & 1 == 1) {
                let dx = (position(sample)[0] - i64::from(a.x)) as f32;
                let dy = (position(sample)[1] - i64::from(a.y)) as f32;
                let depth = (dx * slope_x + dy * slope_y) + a.d;
                emit([x as usize, y as usize], sample, covered, depth.max(a.d).min(b.d.max(c.d)));
            }
        }
    }
}
