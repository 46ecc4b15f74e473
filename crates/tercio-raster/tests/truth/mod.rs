//! Ground truth for pictures, from a ray caster in `f64` with shading formulas of its own, and the comparison of frames
//! with it.
//!
//! The renderer rounds corners to `f32` and snaps them to 1/256 pixel: a point of a triangle appears at most [`SHIFT`]
//! pixels from its exact position. So a pixel is *decided* if the ray through its middle and those [`SHIFT`] around it
//! all hit the same triangle (or none): there the frame must show that triangle, and depth, normal and colour must be
//! within the range of these rays.
#![allow(dead_code, reason = "each test binary uses a part of it")]

use std::path::Path;

use glam::{DAffine3, DVec3};
use tercio_mesh::io::{self, ReadOptions};
use tercio_mesh::{Mesh, clean, normals};
use tercio_raster::frame::NO_PRIMITIVE;
use tercio_raster::{Frame, SamplePattern, Shading};
use tercio_scene::{Camera, Light, LightSpace, Projection, Scene, Surface};
use tercio_testkit::ray_caster::{Hit, RayCaster};

/// How far, in pixels, snapping and rounding may move a point: half a sub-pixel in x and in y for snapping, plus a
/// quarter for rounding to `f32` before.
const SHIFT: f64 = 0.75 / 256.0;
/// Maximum relative error of a depth, in addition to the effect of a shift: with twelve bits fewer than an `f32` has it
/// would be 2.4e-4.
const DEPTH_ERROR: f64 = 1e-5;
/// Maximum error of a normal in degrees, in addition to the effect of a shift. Stored normals have an error of 0.004.
const NORMAL_ERROR: f64 = 0.02;
/// Maximum error of a colour in 8-bit levels, in addition to the effect of a shift. Half a level is due to rounding.
const LEVEL_ERROR: f64 = 1.0;

/// A model of the shared data with normals and without colours; each triangle is a face.
pub fn real_model(data: &Path, name: &str) -> Mesh {
    let path = data.join("meshes").join(name);
    let mut mesh = io::read(&path, &ReadOptions::default()).expect("a model").mesh;
    clean::clean(&mut mesh);
    mesh.face_of_triangle = None;
    mesh.vertex_colors = None;
    mesh.materials.clear();
    if mesh.normals.is_none() {
        normals::make_normals(&mut mesh, Some(1.0));
    }
    mesh
}

/// The ray caster's copy of a scene, in `f64`.
pub struct Truth<'a> {
    scene: &'a Scene,
    shading: Shading,
    caster: RayCaster,
    corners: Vec<[DVec3; 3]>,
    /// Unit normals of corners in world space.
    normals: Option<Vec<[DVec3; 3]>>,
    /// sRGB levels of corners.
    colors: Option<Vec<[[f64; 3]; 3]>>,
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per world unit (orthographic), or per unit of the tangent of the viewing angle (perspective).
    scale: f64,
    perspective: bool,
    /// Where the line of sight meets the picture, in pixels.
    middle: [f64; 2],
    size: [usize; 2],
    near: f64,
    /// The points of a pixel that a frame shows, as distances from its upper left corner in pixels: one value of each
    /// plane per point, side by side.
    points: Vec<[f64; 2]>,
}

/// What a ray hits.
#[derive(Clone, Copy)]
struct Seen {
    triangle: usize,
    distance: f64,
    normal: DVec3,
    /// 8-bit levels, not rounded.
    levels: [f64; 3],
}

/// The result of a comparison.
#[derive(Debug, Default)]
pub struct Found {
    pub pixels: usize,
    pub decided: usize,
    pub shown: usize,
    /// Pixels that show another triangle, at the same depth as the right one.
    pub ties: usize,
    /// Descriptions of the first wrong pixels.
    pub wrong: Vec<String>,
    pub wrong_pixels: usize,
    /// The smallest cosine between a normal and the direction to the viewer.
    pub least_cosine: f64,
}

impl<'a> Truth<'a> {
    /// `meshes` are those of the scene's instances.
    pub fn new(
        meshes: &[&Mesh],
        scene: &'a Scene,
        camera: &Camera,
        shading: Shading,
        size: [u32; 2],
    ) -> Self {
        let (mut corners, mut normals, mut colors) = (Vec::new(), Vec::new(), Vec::new());
        for (mesh, instance) in meshes.iter().zip(&scene.instances) {
            let DAffine3 { matrix3, translation } = instance.world_from_object;
            let normal_matrix = matrix3.inverse().transpose() * matrix3.determinant().signum();
            for t in &mesh.triangles {
                let t = t.map(|v| v as usize);
                let local =
                    |v: usize| DVec3::from(mesh.positions[v].map(f64::from)) * mesh.unit() + mesh.origin;
                corners.push(t.map(|v| matrix3 * local(v) + translation));
                if let Some(n) = &mesh.normals {
                    let unit = |v: usize| DVec3::from(n[v].decode().map(f64::from)).normalize();
                    normals.push(t.map(|v| (normal_matrix * unit(v)).normalize()));
                }
                if let Some(c) = &mesh.vertex_colors {
                    colors.push(t.map(|v| [0, 1, 2].map(|k| f64::from(c[v][k]))));
                }
            }
        }
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let half = f64::from(size[1]) * 0.5;
        let [shift_right, shift_up] = camera.shift.map(|shift| shift * f64::from(size[1]));
        let (perspective, scale) = match camera.projection {
            Projection::Perspective { fov_y } => (true, half / (fov_y * 0.5).tan()),
            Projection::Orthographic { height } => (false, half * 2.0 / height),
        };
        Self {
            scene,
            shading,
            caster: RayCaster::new(corners.iter().map(|t| t.map(|p| p.to_array())).collect()),
            normals: (!normals.is_empty()).then_some(normals),
            colors: (!colors.is_empty()).then_some(colors),
            corners,
            eye: camera.eye,
            right,
            up: right.cross(forward),
            forward,
            scale,
            perspective,
            middle: [f64::from(size[0]) * 0.5 + shift_right, half - shift_up],
            size: size.map(|n| n as usize),
            near: camera.near.unwrap_or(0.0),
            points: vec![[0.5; 2]],
        }
    }

    /// The truth of a frame that holds samples.
    pub fn at_samples(self, pattern: SamplePattern) -> Self {
        let cells = pattern.cells();
        let points =
            (0..cells.count).map(|s| cells.offset(s).map(|offset| f64::from(offset) / 256.0)).collect();
        Self { points, ..self }
    }

    /// The ray through a point of the picture, in pixels. The length of its direction is such that distances on the ray
    /// are distances along the line of sight.
    fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let x = (x - self.middle[0]) / self.scale;
        let y = (self.middle[1] - y) / self.scale;
        let across = self.right * x + self.up * y;
        if self.perspective { (self.eye, self.forward + across) } else { (self.eye + across, self.forward) }
    }

    /// What the ray through a point of the picture hits.
    fn cast(&self, x: f64, y: f64) -> Option<Seen> {
        let (origin, direction) = self.ray(x, y);
        let hit = self.caster.first_hit(origin.to_array(), direction.to_array(), self.near)?;
        Some(self.shade(hit, origin, direction))
    }

    fn shade(&self, hit: Hit, origin: DVec3, direction: DVec3) -> Seen {
        let Hit { triangle, distance, weight } = hit;
        let [a, b, c] = self.corners[triangle];
        let mix = |v: [DVec3; 3]| v[0] * weight[0] + v[1] * weight[1] + v[2] * weight[2];
        let to_viewer = -direction.normalize();
        let plane = (b - a).cross(c - a).normalize();
        let plane = if plane.dot(to_viewer) < 0.0 { -plane } else { plane };
        let normal_of = |n: DVec3, to_viewer: DVec3| {
            let n = n.normalize();
            let n = if n.dot(plane) < 0.0 { -n } else { n };
            let away = n.dot(to_viewer);
            if away < 0.0 { (n - to_viewer * away).normalize() } else { n }
        };
        let smooth = self.normals.as_ref().filter(|_| self.shading != Shading::Flat);
        let normal = normal_of(smooth.map_or(plane, |n| mix(n[triangle])), to_viewer);
        let surface = &self.scene.instances[0].surface;
        let albedo = match self.colors.as_ref().filter(|_| surface.use_mesh_colors) {
            Some(colors) => {
                let linear = colors[triangle].map(|c| DVec3::from(c.map(|level| decode(level / 255.0))));
                mix(linear)
            }
            None => DVec3::from(surface.base_color.map(f64::from)),
        };
        let lit = match self.shading {
            Shading::Unlit => albedo,
            Shading::Flat | Shading::Phong => {
                let (diffuse, specular) =
                    self.light(surface, normal, to_viewer, origin + direction * distance);
                albedo * diffuse + specular
            }
            Shading::Gouraud => {
                let at = [0, 1, 2].map(|k| {
                    let p = [a, b, c][k];
                    let to_viewer = if self.perspective { (self.eye - p).normalize() } else { -self.forward };
                    let n = normal_of(smooth.map_or(plane, |n| n[triangle][k]), to_viewer);
                    self.light(surface, n, to_viewer, p)
                });
                albedo * mix(at.map(|l| l.0)) + mix(at.map(|l| l.1))
            }
            other => unreachable!("{other:?} shading is not implemented"),
        };
        Seen { triangle, distance, normal, levels: lit.to_array().map(|c| encode(c.clamp(0.0, 1.0)) * 255.0) }
    }

    /// Lambert's diffuse light and Blinn's specular light.
    fn light(&self, surface: &Surface, normal: DVec3, to_viewer: DVec3, at: DVec3) -> (DVec3, DVec3) {
        let (mut diffuse, mut specular) = (DVec3::ZERO, DVec3::ZERO);
        let from_camera = |v: DVec3| self.right * v.x + self.up * v.y - self.forward * v.z;
        for light in &self.scene.lights {
            let (to_light, color) = match *light {
                Light::Ambient { color } => {
                    diffuse += DVec3::from(color.map(f64::from));
                    continue;
                }
                Light::Directional { to_light, space, color } => match space {
                    LightSpace::World => (to_light, color),
                    LightSpace::Camera => (from_camera(to_light), color),
                },
                Light::Wide { to_light, space, color, highlight } => {
                    let world = if space == LightSpace::World { to_light } else { from_camera(to_light) };
                    let (to_light, color) = (world.normalize(), DVec3::from(color.map(f64::from)));
                    let cosine = normal.dot(to_light);
                    diffuse += color * (0.5 + 0.5 * cosine).powi(2);
                    if highlight && cosine > 0.0 {
                        let half = normal.dot((to_light + to_viewer).normalize()).max(0.0);
                        let power = half.powi(1 << surface.shininess_log2) * cosine;
                        specular += color * power * f64::from(surface.specular);
                    }
                    continue;
                }
                Light::Point { position, space, color } => match space {
                    LightSpace::World => (position - at, color),
                    LightSpace::Camera => (self.eye + from_camera(position) - at, color),
                },
                Light::Spot { position, direction, space, angle, color } => {
                    let (position, axis) = match space {
                        LightSpace::World => (position, direction),
                        LightSpace::Camera => (self.eye + from_camera(position), from_camera(direction)),
                    };
                    let cosine = (at - position).normalize().dot(axis.normalize());
                    // From the edge of the cone, a fifth of the way to the middle, as cosines.
                    let inside = (cosine - angle.cos()) / (0.2 * (1.0 - angle.cos()));
                    let share = inside.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * inside.clamp(0.0, 1.0));
                    (position - at, color.map(|c| c * share as f32))
                }
            };
            let (to_light, color) = (to_light.normalize(), DVec3::from(color.map(f64::from)));
            let cosine = normal.dot(to_light);
            if cosine > 0.0 {
                diffuse += color * cosine;
                let half = normal.dot((to_light + to_viewer).normalize()).max(0.0);
                let power = half.powi(1 << surface.shininess_log2);
                specular += color * power * f64::from(surface.specular);
            }
        }
        (diffuse, specular)
    }

    /// Compares all planes of a frame. Fails if a pixel is wrong, if less than half of the pixels are decided, or if
    /// too few of them show a triangle.
    #[track_caller]
    pub fn check(&self, frame: &Frame, what: &str) -> Found {
        let found = self.compare(frame);
        let Found { pixels, decided, shown, ties, least_cosine, .. } = found;
        assert_eq!(found.wrong_pixels, 0, "{what}: wrong of {decided} decided pixels: {:#?}", found.wrong);
        assert!(decided * 2 >= pixels, "{what}: only {decided} of {pixels} decided");
        assert!(ties * 100 <= decided, "{what}: {ties} ties of {decided}");
        assert!(shown * 20 >= pixels, "{what}: only {shown} pixels show a triangle");
        assert!(least_cosine >= -1e-6, "{what}: a normal points away from the viewer: {least_cosine}");
        found
    }

    /// Compares depth, ids, normals and colours.
    fn compare(&self, frame: &Frame) -> Found {
        let mut found = Found { least_cosine: 1.0, ..Found::default() };
        let [width, height] = self.size;
        let count = self.points.len();
        for index in 0..width * height * count {
            let (x, y) = (index / count % width, index / count / width);
            found.pixels += 1;
            let [right, down] = self.points[index % count];
            let (cx, cy) = (x as f64 + right, y as f64 + down);
            let middle = self.cast(cx, cy);
            let triangle = middle.map(|seen| seen.triangle);
            let around: Vec<Option<Seen>> = [-1.0, 0.0, 1.0]
                .iter()
                .flat_map(|dy| [-1.0, 0.0, 1.0].map(|dx| self.cast(cx + dx * SHIFT, cy + dy * SHIFT)))
                .collect();
            let shown = Some(frame.planes.ids[index]).filter(|&id| id != NO_PRIMITIVE).map(|id| id as usize);
            if shown.is_some() {
                let (_, direction) = self.ray(cx, cy);
                let normal = DVec3::from(frame.planes.normals[index].map(f64::from));
                found.least_cosine = found.least_cosine.min(-direction.normalize().dot(normal));
            }
            if around.iter().any(|seen| seen.map(|seen| seen.triangle) != triangle) {
                continue;
            }
            found.decided += 1;
            found.shown += usize::from(triangle.is_some());
            let around: Vec<Seen> = around.into_iter().flatten().collect();
            let wrong = match (middle, shown) {
                (None, None) => None,
                (Some(seen), Some(shown)) if shown == seen.triangle => {
                    self.difference(frame, index, seen, &around)
                }
                (Some(seen), Some(other)) if self.is_tie(other, [cx, cy], seen) => {
                    found.ties += 1;
                    None
                }
                (seen, shown) => Some(format!("shows {shown:?}, not {:?}", seen.map(|seen| seen.triangle))),
            };
            if let Some(wrong) = wrong {
                found.wrong_pixels += 1;
                if found.wrong.len() < 8 {
                    found.wrong.push(format!("pixel ({x}, {y}) {wrong}"));
                }
            }
        }
        found
    }

    /// Does another triangle cover this point, too, at the same depth as the visible one, within their precision?
    fn is_tie(&self, other: usize, [x, y]: [f64; 2], seen: Seen) -> bool {
        let mut is_here = false;
        let distances = [(0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(dx, dy)| {
            let (origin, direction) = self.ray(x + dx * SHIFT, y + dy * SHIFT);
            let hit = self.caster.meet(other, origin.to_array(), direction.to_array());
            is_here |= hit.is_some_and(|hit| hit.weight.iter().all(|&w| w >= 0.0));
            hit.map_or(f64::INFINITY, |hit| hit.distance)
        });
        if !is_here {
            return false;
        }
        let nearest = distances.into_iter().fold(f64::INFINITY, f64::min);
        let farthest = distances.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let error = self.depth_error(seen.distance);
        nearest - error <= seen.distance && seen.distance <= farthest + error
    }

    /// The maximum error of a depth: relative to the depth for a perspective camera, to the radius of the scene for an
    /// orthographic one.
    fn depth_error(&self, distance: f64) -> f64 {
        let scale = if self.perspective { distance.abs() } else { self.scene.bounds().radius() };
        scale * DEPTH_ERROR
    }

    /// Describes the difference of a pixel from the ray caster; `None` if it is within the range of the rays around it.
    fn difference(&self, frame: &Frame, index: usize, seen: Seen, around: &[Seen]) -> Option<String> {
        let range = |of: &dyn Fn(&Seen) -> f64| {
            let values = around.iter().map(of);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (nearest, farthest) = range(&|s| s.distance);
        let (error, depth) = (self.depth_error(seen.distance), f64::from(frame.planes.depth[index]));
        if !(nearest - error <= depth && depth <= farthest + error) {
            return Some(format!("depth {depth}, not {} ({nearest} to {farthest})", seen.distance));
        }
        let normal = DVec3::from(frame.planes.normals[index].map(f64::from));
        let degrees = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b)).to_degrees();
        let spread = around.iter().map(|s| degrees(s.normal, seen.normal)).fold(0.0, f64::max);
        let off = degrees(normal, seen.normal);
        if !(off <= spread + NORMAL_ERROR) || (normal.length() - 1.0).abs() > 1e-5 {
            return Some(format!("normal {normal}, not {}: {off} degrees, {spread} allowed", seen.normal));
        }
        for k in 0..3 {
            let (low, high) = range(&|s| s.levels[k]);
            let level = f64::from(frame.planes.color[index][k]);
            if !(low - LEVEL_ERROR <= level && level <= high + LEVEL_ERROR) {
                return Some(format!("colour {:?}, not {:?}", frame.planes.color[index], seen.levels));
            }
        }
        None
    }
}

fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn decode(srgb: f64) -> f64 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}
