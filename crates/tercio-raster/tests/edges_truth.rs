//! Lines along the sides of triangles held against distances in `f64` on the picture, of rays' triangles: nothing is shared with the
//! renderer.

mod common;

use std::sync::Arc;

use common::*;
use glam::{DVec2, DVec3};
use tercio_mesh::Mesh;
use tercio_mesh::edges::{Beyond, Edges, Selection};
use tercio_raster::{Outputs, SamplePattern, Sampling, Settings, Shading};
use tercio_scene::camera::Projection;
use tercio_scene::{Camera, SurfaceEdges};
use tercio_testkit::ray_caster::RayCaster;

const SIZE: [u32; 2] = [120, 90];

fn cameras() -> [Camera; 3] {
    [
        perspective([0.4, 0.9, 2.6], [0.0; 3], 45.0),
        perspective([0.1, 0.2, 1.3], [0.2, 0.1, 0.0], 70.0),
        orthographic([1.0, -2.0, 0.7], [0.0; 3], 2.2),
    ]
}

/// A point of the world on the picture, in pixels.
fn on_picture(camera: &Camera, p: DVec3) -> DVec2 {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let [width, height] = SIZE.map(f64::from);
    let p = p - camera.eye;
    let scale = match camera.projection {
        Projection::Perspective { fov_y } => height / (2.0 * (fov_y / 2.0).tan()) / forward.dot(p),
        Projection::Orthographic { height: world } => height / world,
    };
    DVec2::new(width / 2.0 + right.dot(p) * scale, height / 2.0 - up.dot(p) * scale)
}

struct Model {
    mesh: Mesh,
    corners: Vec<[DVec3; 3]>,
    caster: RayCaster,
}

impl Model {
    fn new(mesh: Mesh) -> Self {
        let at = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
        // Sides have the numbers of the corners opposite to them, from the first corner that the renderer's rules choose.
        let corners: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|&t| Mesh::canonical(t).map(at)).collect();
        let caster = RayCaster::new(corners.iter().map(|t| t.map(|p| p.to_array())).collect());
        Self { mesh, corners, caster }
    }

    /// The triangle that is seen at a point of the picture.
    fn seen(&self, camera: &Camera, at: [f64; 2]) -> Option<usize> {
        let (from, towards) = ray(camera, SIZE, at);
        Some(self.caster.first_hit(from.to_array(), towards.to_array(), 0.0)?.triangle)
    }

    /// The distance of a point of the picture from the nearest of these sides of the triangle that is seen there, in pixels.
    fn distance(&self, camera: &Camera, at: [f64; 2], sides: impl Fn(usize) -> u8) -> Option<f64> {
        let triangle = self.seen(camera, at)?;
        let corners = self.corners[triangle].map(|p| on_picture(camera, p));
        let from_side = |k: usize| {
            let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            (b - a).perp_dot(DVec2::from(at) - a).abs() / a.distance(b)
        };
        let own = (0..3).filter(|k| sides(triangle) >> k & 1 == 1);
        Some(own.map(from_side).fold(f64::INFINITY, f64::min))
    }

    /// How much of each pixel is line in a picture of white lines on black.
    fn picture(
        &self,
        camera: &Camera,
        width: f32,
        sides: Option<Vec<u8>>,
        pattern: SamplePattern,
    ) -> Vec<f64> {
        self.picture_of(camera, SurfaceEdges::new([255; 3], width, sides), pattern)
    }

    /// The same, of white edges.
    fn picture_of(&self, camera: &Camera, edges: SurfaceEdges, pattern: SamplePattern) -> Vec<f64> {
        let mut scene = scene(&self.mesh);
        let instance = &mut scene.instances[0];
        instance.edges = Some(Arc::new(edges));
        (instance.surface.base_color, instance.surface.use_mesh_colors) = ([0.0; 3], false);
        let outputs = Outputs { linear: true, ..Outputs::NONE };
        let settings = Settings {
            shading: Shading::Unlit,
            outputs,
            sampling: Sampling::of(pattern),
            ..Settings::new(SIZE[0], SIZE[1])
        };
        draw(&scene, camera, &settings).planes.linear.iter().map(|light| f64::from(light[0])).collect()
    }
}

fn pixels() -> impl Iterator<Item = (usize, [f64; 2])> {
    (0..SIZE[0] * SIZE[1]).map(|i| (i as usize, [i % SIZE[0], i / SIZE[0]].map(f64::from)))
}

/// With one sample per pixel, a pixel is covered by as much of a line as its distance says.
#[test]
fn cover_is_that_of_the_distance_to_the_nearest_side() {
    let model = Model::new(sphere(9));
    let mut random = Random(4);
    let some: Vec<u8> = model.mesh.triangles.iter().map(|_| random.between(0.0, 8.0) as u8).collect();
    for camera in cameras() {
        for (width, sides) in [(1.0, None), (3.5, None), (0.5, None), (2.0, Some(some.clone()))] {
            let found = model.picture(&camera, width, sides.clone(), SamplePattern::ALL[0]);
            let width = f64::from(width);
            let (mut compared, mut lines) = (0, 0);
            for (i, corner) in pixels() {
                let middle = corner.map(|c| c + 0.5);
                let bits = |t: usize| sides.as_ref().map_or(7, |sides| sides[t]);
                let Some(distance) = model.distance(&camera, middle, bits) else { continue };
                // Corners are snapped to 1/256 pixel, so another triangle may be seen at a side.
                if model.distance(&camera, middle, |_| 7).is_none_or(|distance| distance < 0.02) {
                    continue;
                }
                let cover = (0.5 * width + 0.5 - distance).clamp(0.0, width.min(1.0));
                assert!((found[i] - cover).abs() < 0.02, "{corner:?}: {}, expected {cover}", found[i]);
                compared += 1;
                lines += usize::from(cover > 0.3);
            }
            assert!(compared > 2_500 && lines > 150, "{compared} {lines}");
        }
    }
}

/// With many samples per pixel, pixels at sides are covered by the area of the lines there, and lines are as wide as they should be.
#[test]
fn cover_is_the_area_of_the_lines() {
    const GRID: usize = 12;
    let model = Model::new(sphere(9));
    for camera in cameras() {
        for (width, pattern) in
            [(1.0, SamplePattern::ALL[2]), (1.0, SamplePattern::ALL[4]), (2.5, SamplePattern::ALL[2])]
        {
            let found = model.picture(&camera, width, None, pattern);
            let (mut sums, mut off, mut count, mut worst) = ([0.0; 2], 0.0, 0, 0.0f64);
            for (i, corner) in pixels() {
                let mut inside = 0;
                let mut seen = true;
                for k in 0..GRID * GRID {
                    let at = [0, 1].map(|axis| {
                        let place = if axis == 0 { k % GRID } else { k / GRID };
                        corner[axis] + (place as f64 + 0.5) / GRID as f64
                    });
                    match model.distance(&camera, at, |_| 7) {
                        Some(distance) => inside += usize::from(distance < 0.5 * f64::from(width)),
                        None => seen = false,
                    }
                    if !seen {
                        break;
                    }
                }
                // Beside the silhouette.
                if !seen {
                    continue;
                }
                let area = inside as f64 / (GRID * GRID) as f64;
                sums = [sums[0] + area, sums[1] + found[i]];
                off += (found[i] - area).abs();
                worst = worst.max((found[i] - area).abs());
                count += 1;
            }
            let (ink, mean) = (sums[1] / sums[0], off / f64::from(count));
            let what = format!(
                "{width} {pattern:?}: {ink} of the area of {count} pixels, off by {mean}, at most {worst}"
            );
            // Where lines meet, the one that covers a pixel most counts, not both: a twentieth of the area of these short lines. A width
            // that were wrong by a tenth would be seen.
            assert!(count > 2_000 && (0.92..1.02).contains(&ink) && mean < 0.045 && worst < 0.5, "{what}");
        }
    }
}

/// A box of flat quadrilaterals, each of two triangles: none is a square, some are narrow, and their diagonals run either way. For each
/// triangle the corners of its quadrilateral.
fn quads() -> (Mesh, Vec<Vec<DVec3>>) {
    const N: usize = 7;
    let mut random = Random(11);
    let (mut mesh, mut all) = (Mesh::default(), Vec::new());
    for face in 0..6 {
        let (axis, end) = (face / 2, (face % 2) as f64 * 2.0 - 1.0);
        let mut grid = [[[0.0; 2]; N + 1]; N + 1];
        for (i, row) in grid.iter_mut().enumerate() {
            for (j, p) in row.iter_mut().enumerate() {
                // Every other column is narrow.
                let across = [-1.0, -0.55, -0.45, -0.05, 0.05, 0.45, 0.55, 1.0][i];
                let down = j as f64 * 2.0 / N as f64 - 1.0;
                let shift = |k: usize, most: f64, random: &mut Random| match k {
                    0 | N => 0.0,
                    _ => random.between(-most, most),
                };
                *p = [across + shift(i, 0.03, &mut random), down + shift(j, 0.08, &mut random)];
            }
        }
        let at = |i: usize, j: usize| {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (end, grid[i][j][0], grid[i][j][1]);
            p.map(|c| c as f32)
        };
        for (i, j) in (0..N * N).map(|k| (k / N, k % N)) {
            let mut corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            corners.rotate_left((i + j) % 2);
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
            all.extend(vec![corners.map(|p| DVec3::from(p.map(f64::from))).to_vec(); 2]);
        }
    }
    mesh.face_of_triangle = Some((0..mesh.triangles.len() as u32).map(|t| t / 2).collect());
    (mesh, all)
}

/// Flat convex polygons of five to seven corners on the sides of a box, each of triangles with one corner in common, or of a strip. For
/// each triangle the corners of its polygon.
fn polygons() -> (Mesh, Vec<Vec<DVec3>>) {
    const N: usize = 3;
    let mut random = Random(12);
    let (mut mesh, mut all, mut faces) = (Mesh::default(), Vec::new(), Vec::new());
    for (face, i, j) in (0..6 * N * N).map(|k| (k / (N * N), k / N % N, k % N)) {
        let (axis, end) = (face / 2, (face % 2) as f64 * 2.0 - 1.0);
        let corners = 5 + (face + i + j) % 3;
        let polygon = (0..corners).map(|k| {
            let angle = (k as f64 + random.between(-0.2, 0.2)) * std::f64::consts::TAU / corners as f64;
            let middle = [i, j].map(|cell| (cell as f64 + 0.5) * 2.0 / N as f64 - 1.0);
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) =
                (end, middle[0] + 0.32 * angle.cos(), middle[1] + 0.28 * angle.sin());
            p.map(|c| c as f32)
        });
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(polygon);
        let of_polygon: Vec<_> = mesh.positions[first as usize..].iter().map(|p| at(*p)).collect();
        let n = corners as u32;
        for t in 0..n - 2 {
            // A strip takes its corners from both ends in turns.
            let triangle = match (i + j) % 2 {
                0 => [0, t + 1, t + 2],
                _ if t % 2 == 0 => [t / 2, t / 2 + 1, n - 1 - t / 2],
                _ => [t / 2 + 1, n - 2 - t / 2, n - 1 - t / 2],
            };
            mesh.triangles.push(triangle.map(|k| first + k));
            faces.push(all.len() as u32);
        }
        let face = faces[faces.len() - 1];
        faces.iter_mut().rev().take(n as usize - 2).for_each(|f| *f = face);
        all.extend(vec![of_polygon; n as usize - 2]);
    }
    mesh.face_of_triangle = Some(faces);
    (mesh, all)
}

fn at(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// Lines of polygons are not cut off at their diagonals: a pixel is covered by as much as the distance to the nearest of all sides says.
fn check_polygons(mesh: Mesh, polygons: &[Vec<DVec3>], least_compared: usize) {
    let edges = Edges::of_mesh(&mesh, Selection::All);
    let is_flat = edges.folds.is_none();
    let model = Model::new(mesh);
    let mut of_others = 0;
    for camera in cameras() {
        for width in [1.0, 3.5] {
            let draw = |beyond| {
                let edges = SurfaceEdges::new([255; 3], width, Some(edges.sides.clone()));
                model.picture_of(&camera, SurfaceEdges { beyond, ..edges }, SamplePattern::ALL[0])
            };
            let found = draw(edges.beyond.clone());
            let cut_off = draw(Beyond::Nothing);
            let width = f64::from(width);
            let (mut compared, mut lines) = (0, 0);
            for (i, corner) in pixels() {
                let middle = DVec2::from(corner.map(|c| c + 0.5));
                let Some(triangle) = model.seen(&camera, middle.to_array()) else { continue };
                let corners: Vec<_> = polygons[triangle].iter().map(|&p| on_picture(&camera, p)).collect();
                let side = |k: usize| (corners[k % corners.len()], corners[(k + 1) % corners.len()]);
                // A bent polygon may be folded on the picture: part of it may hide another, and lines that lead there.
                let turn = |k: usize| {
                    let [(a, b), (_, c)] = [k, k + 1].map(side);
                    (b - a).perp_dot(c - b)
                };
                if !(1..corners.len()).all(|k| turn(k) * turn(0) > 0.0) {
                    continue;
                }
                // A line that begins at no corner of a triangle is not drawn there, and one that begins at a corner has no round end at the
                // other: only narrow triangles of bent polygons are so near to one.
                let is_known = |k: usize| {
                    let corner = &polygons[triangle][k % corners.len()];
                    is_flat || model.corners[triangle].contains(corner)
                };
                let from_side = |k: usize| {
                    let (a, b) = side(k);
                    let along = (middle - a).dot(b - a) / a.distance_squared(b);
                    let is_drawn = match [is_known(k), is_known(k + 1)] {
                        [true, true] => true,
                        [true, false] => along <= 1.0,
                        [false, true] => along >= 0.0,
                        [false, false] => false,
                    };
                    if is_drawn { middle.distance(a.lerp(b, along.clamp(0.0, 1.0))) } else { f64::INFINITY }
                };
                let distance = (0..corners.len()).map(from_side).fold(f64::INFINITY, f64::min);
                if distance < 0.02 {
                    continue;
                }
                let cover = (0.5 * width + 0.5 - distance).clamp(0.0, width.min(1.0));
                assert!((found[i] - cover).abs() < 0.02, "{corner:?}: {}, expected {cover}", found[i]);
                compared += 1;
                lines += usize::from(cover > 0.3);
                of_others += usize::from((cut_off[i] - cover).abs() > 0.1);
            }
            assert!(compared > least_compared && lines > 150, "{compared} {lines}");
        }
    }
    assert!(of_others > 200, "{of_others} pixels of lines beyond a diagonal");
}

/// The same with bulges and dents.
fn bent((mut mesh, mut polygons): (Mesh, Vec<Vec<DVec3>>)) -> (Mesh, Vec<Vec<DVec3>>) {
    let moved = |p: DVec3| {
        let [x, y, z] = (p * 4.0).to_array().map(f64::sin);
        (p * (1.0 + 0.12 * (x + y * z))).as_vec3()
    };
    mesh.positions.iter_mut().for_each(|p| *p = moved(at(*p)).to_array());
    polygons.iter_mut().flatten().for_each(|p| *p = moved(*p).as_dvec3());
    (mesh, polygons)
}

#[test]
fn cover_of_bent_polygons_is_that_of_the_distance_to_their_sides_on_the_picture() {
    for (made, least_compared) in [(quads(), 2_000), (polygons(), 1_500)] {
        let (mesh, polygons) = bent(made);
        let edges = Edges::of_mesh(&mesh, Selection::All);
        assert!(edges.folds.is_some_and(|folds| folds.sides.list.len() * 2 > mesh.triangles.len() / 2));
        check_polygons(mesh, &polygons, least_compared);
    }
}

#[test]
fn cover_of_quadrilaterals_is_that_of_the_distance_to_all_their_sides() {
    let (mesh, quads) = quads();
    assert!(matches!(Edges::of_mesh(&mesh, Selection::All).beyond, Beyond::Quadrilaterals(_)));
    check_polygons(mesh, &quads, 2_500);
}

#[test]
fn cover_of_polygons_is_that_of_the_distance_to_all_their_sides() {
    let (mesh, polygons) = polygons();
    assert!(matches!(Edges::of_mesh(&mesh, Selection::All).beyond, Beyond::Polygons(_)));
    check_polygons(mesh, &polygons, 2_000);
}

/// Lines of quadrilaterals that reach behind the viewer are as wide as others.
#[test]
fn cover_of_clipped_quadrilaterals_is_that_of_the_distance_to_their_sides() {
    let mut mesh = Mesh::default();
    for k in 0..24u16 {
        let x = f32::from(k) * 0.25 - 3.0;
        // Their diagonals run either way.
        let mut corners = [[x, 0.0, 40.0], [x + 0.25, 0.0, 40.0], [x + 0.25, 0.0, -40.0], [x, 0.0, -40.0]];
        corners.rotate_left(usize::from(k % 2));
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
    }
    mesh.face_of_triangle = Some((0..mesh.triangles.len() as u32).map(|t| t / 2).collect());
    let edges = Edges::of_mesh(&mesh, Selection::All);
    let model = Model::new(mesh);
    let camera = Camera { near: Some(0.2), ..perspective([0.1, 1.2, 0.0], [0.3, 0.0, -3.0], 60.0) };
    let forward = (camera.target - camera.eye).normalize();
    for width in [1.0, 3.5] {
        let lines = SurfaceEdges::new([255; 3], width, Some(edges.sides.clone()));
        let lines = SurfaceEdges { beyond: edges.beyond.clone(), ..lines };
        let found = model.picture_of(&camera, lines, SamplePattern::ALL[0]);
        let width = f64::from(width);
        let (mut compared, mut inked) = (0, 0);
        for (i, corner) in pixels() {
            let middle = DVec2::from(corner.map(|c| c + 0.5));
            let Some(triangle) = model.seen(&camera, middle.to_array()) else { continue };
            let first = triangle / 2 * 4;
            let of_quad = &model.mesh.positions[first..first + 4];
            let from_side = |k: usize| {
                let ends = [at(of_quad[k]), at(of_quad[(k + 1) % 4])];
                // What of it is in front of the viewer, which is all of the line on the picture.
                let depth = ends.map(|p| forward.dot(p - camera.eye));
                let part = |k: usize| {
                    let share = ((0.5 - depth[k]) / (depth[1 - k] - depth[k])).max(0.0);
                    if depth[k] < 0.5 { ends[k].lerp(ends[1 - k], share) } else { ends[k] }
                };
                if depth.iter().all(|depth| *depth < 0.5) {
                    return f64::INFINITY;
                }
                let [a, b] = [0, 1].map(part).map(|p| on_picture(&camera, p));
                (b - a).perp_dot(middle - a).abs() / a.distance(b)
            };
            let distance = (0..4).map(from_side).fold(f64::INFINITY, f64::min);
            if distance < 0.02 {
                continue;
            }
            let cover = (0.5 * width + 0.5 - distance).clamp(0.0, width.min(1.0));
            // Where a triangle is clipped, distances are those of the slopes at the point, which perspective changes on the way.
            let most = 0.02 + 0.06 * distance;
            assert!((found[i] - cover).abs() < most, "{corner:?}: {}, expected {cover}", found[i]);
            compared += 1;
            inked += usize::from(cover > 0.3);
        }
        assert!(compared > 4_000 && inked > 400, "{compared} {inked}");
    }
}
