//! Lines, edges and points, as triangles that face a camera.
//!
//! They are made in `f64` for one camera and added to the scene as further instances, so samples, layers, ranks and bands draw
//! them like all others, with the same bytes. Their widths are measured on the picture in pixels, or in units of the world.
//!
//! ```
//! use tercio::glam::DVec3;
//! use tercio::strokes::{self, Eye, Length, Segment};
//! use tercio::raster::view::View;
//!
//! let mut scene = tercio::Scene::from_mesh(tercio::load("builtin:teapot@1k")?.mesh);
//! let settings = tercio::Settings::new(320, 240);
//! let camera = settings.framing().camera_for_scene(&scene);
//! let eye = Eye::new(View::new(&camera, &scene.bounds(), 320, 240).expect("a camera"));
//! let diagonal = [scene.bounds().min, scene.bounds().max];
//! let line = Segment { ends: diagonal, width: Length::Pixels(3.0), color: [200, 0, 0, 255] };
//! scene.instances.extend(strokes::segments(&eye, &[line]));
//! let frame = tercio::Renderer::new().render(&scene, &camera, &settings)?;
//! # Ok::<(), tercio::Error>(())
//! ```
//!
//! All edges of a surface cost less where the surface is shaded ([`Instance::edges`]); [`EdgePart::BesideSurface`] is the rest of them.
//! Where strokes that are not opaque overlap, each of them is a layer of its own: the picture is denser there.

mod eye;
mod glyph;
mod line;
mod point;
mod sheet;
mod tube;

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use tercio_mesh::cluster::ClusterView;
use tercio_mesh::edges::{Edge, Edges, Viewer};
use tercio_mesh::loops::prelude::*;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{AttributeDomain, FileMaterial};
use tercio_scene::{DataReader, Instance, Surface, SurfaceData};

pub use eye::Eye;
pub(crate) use glyph::is_shown;
pub use glyph::{GlyphShape, draw as glyphs};
use line::Line;
use sheet::{Ink, Look};

use crate::data::StrokeData;

/// A length on the picture or in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// Pixels, whatever the distance.
    Pixels(f64),
    /// World units.
    Units(f64),
}

impl Length {
    /// In pixels, at a distance from the eye.
    pub(crate) fn pixels(self, eye: &Eye, z: f64) -> f64 {
        match self {
            Self::Pixels(pixels) => pixels,
            Self::Units(units) => units / eye.pixel(z),
        }
    }
}

/// How lines look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineShape {
    /// Strips parallel to the picture.
    #[default]
    Flat,
    /// Round tubes, lit, with their true depth, joined by spheres.
    Tube,
}

/// How points look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum PointShape {
    /// Squares parallel to the picture.
    Square,
    /// Discs parallel to the picture.
    #[default]
    Round,
    /// Spheres, lit, with their true depth.
    Sphere,
}

/// The width of strokes, and their colour where they have none of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Width of lines, diameter of points.
    pub width: Length,
    /// sRGB and linear alpha.
    pub color: [u8; 4],
}

/// A line segment in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Its ends.
    pub ends: [DVec3; 2],
    /// Its width.
    pub width: Length,
    /// sRGB and linear alpha.
    pub color: [u8; 4],
}

/// Strokes in plain colours.
fn plain() -> Look {
    Look { surface: Surface { unlit: true, specular: 0.0, ..Surface::default() }, colors: None }
}

/// Strokes with a form.
fn lit() -> Look {
    Look { surface: Surface { specular: 0.1, ..Surface::default() }, colors: None }
}

/// Line segments as instances for the camera of `eye`.
pub fn segments(eye: &Eye, segments: &[Segment]) -> Vec<Instance> {
    sheet::draw(eye, &plain(), segments, |sheet, segment| {
        let pen = Pen { width: segment.width, color: segment.color };
        let ends = segment.ends.map(|p| eye.eye_space(p));
        line::draw(sheet, &free(ends), &pen, [segment.color.into(); 2]);
    })
}

/// A line that is no edge.
fn free(ends: [DVec3; 2]) -> Line {
    Line { ends, apexes: [None; 2], hides_back: false, part: EdgePart::All }
}

/// What of edges is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgePart {
    /// All of them.
    All,
    /// Of those that two triangles share, only those on the silhouette.
    Silhouette,
    /// The halves of [`EdgePart::Silhouette`] that are on no triangle: what [`SurfaceEdges`] leave out, unless it is certainly hidden by
    /// the surface, which is opaque.
    ///
    /// [`SurfaceEdges`]: tercio_scene::SurfaceEdges
    BesideSurface,
}

/// Edges of an instance's mesh, or parts of them, as instances for the camera of `eye`, in the colours of `data`
/// ([`of_edges`](crate::data::of_edges)), if there are any.
pub fn edges(
    eye: &Eye,
    (edges, world_from_object): (&Edges, &DAffine3),
    pen: &Pen,
    part: EdgePart,
    data: Option<&StrokeData>,
) -> Vec<Instance> {
    let unit = edges.unit();
    let at = |p: [f32; 3]| {
        let p = edges.origin + DVec3::from(p.map(f64::from)) * unit;
        eye.eye_space(world_from_object.transform_point3(p))
    };
    let hides_back = edges.is_solid && !is_inside(eye, edges, world_from_object);
    let mirrored = world_from_object.matrix3.determinant() < 0.0;
    let mut list: Vec<u32> = match part {
        EdgePart::All => (0..edges.list.len() as u32).collect(),
        EdgePart::Silhouette => edges.silhouettes(viewer(eye, edges, world_from_object)),
        EdgePart::BesideSurface => outlines(eye, edges, world_from_object),
    };
    let whole = around_folds(eye, (edges, world_from_object), part);
    list.retain(|number| whole.binary_search(number).is_err());
    let look = colored(plain(), data);
    let of_part = |list: &[u32], part: EdgePart| {
        sheet::draw_together(eye, &look, list, |sheet, numbers| {
            edges.for_each_corners(numbers, |number, corners| {
                let ends = corners.ends.map(at);
                let mut apexes = corners.apexes.map(|apex| apex.map(at));
                if mirrored && apexes[1].is_some() {
                    apexes.swap(0, 1);
                }
                let line = Line { ends, apexes, hides_back, part };
                sheet.begin();
                line::draw(sheet, &line, pen, edge_inks(number, pen, data));
            });
        })
    };
    let mut drawn = of_part(&list, part);
    drawn.extend(of_part(&whole, EdgePart::All));
    drawn
}

/// The numbers of the edges that may be on an outline of the surface, in order.
fn outlines(eye: &Eye, edges: &Edges, world_from_object: &DAffine3) -> Vec<u32> {
    let viewer = viewer(eye, edges, world_from_object);
    match is_in_front(eye, edges, world_from_object) {
        true => edges.outlines(viewer),
        false => edges.silhouettes(viewer),
    }
}

/// The numbers of the edges, in order, whose lines may reach over an outline that is no edge but the fold of a bent polygon, so that half of
/// such a line is on no triangle, and of those whose triangles have no height.
fn around_folds(eye: &Eye, (edges, world_from_object): (&Edges, &DAffine3), part: EdgePart) -> Vec<u32> {
    let Some(folds) = edges.folds.as_deref().filter(|_| part == EdgePart::BesideSurface) else {
        return Vec::new();
    };
    let of_fold = |fold: u32| folds.edges[fold as usize].into_iter().filter(|&edge| edge != Edge::NONE);
    let mut list: Vec<u32> =
        outlines(eye, &folds.sides, world_from_object).into_iter().flat_map(of_fold).collect();
    list.extend(&folds.slivers);
    list.sort_unstable();
    list.dedup();
    list
}

/// The colours of an edge's ends.
fn edge_inks(number: u32, pen: &Pen, data: Option<&StrokeData>) -> [Ink; 2] {
    [0, 1].map(|end| data_ink(data, 2 * number as usize + end, pen.color))
}

/// Edges of an instance's mesh as tubes for the camera of `eye`, in the colours of `data` ([`of_edges`](crate::data::of_edges)), if
/// there are any; where several meet, the joint has that of the first.
pub fn edge_tubes(
    eye: &Eye,
    (edges, world_from_object): (&Edges, &DAffine3),
    pen: &Pen,
    data: Option<&StrokeData>,
) -> Vec<Instance> {
    let at = |v: u32| world_from_object.transform_point3(edges.position(v));
    let segments: Vec<[u32; 2]> = edges.list.iter().map(|edge| edge.ends).collect();
    let inks = |number: usize| edge_inks(number as u32, pen, data);
    let mut joints = vec![Ink::from(pen.color); if data.is_some() { edges.positions.len() } else { 0 }];
    for (number, ends) in segments.iter().enumerate().rev().filter(|_| data.is_some()) {
        for (&v, ink) in ends.iter().zip(inks(number)) {
            joints[v as usize] = ink;
        }
    }
    let joint = |v: u32| joints.get(v as usize).copied().unwrap_or(pen.color.into());
    tubes(eye, &colored(lit(), data), &segments, at, (inks, joint), pen)
}

/// Tubes between points of the world, and spheres at these points.
fn tubes(
    eye: &Eye,
    look: &Look,
    segments: &[[u32; 2]],
    at: impl Fn(u32) -> DVec3 + Sync,
    (inks, joint): (impl Fn(usize) -> [Ink; 2] + Sync, impl Fn(u32) -> Ink + Sync),
    pen: &Pen,
) -> Vec<Instance> {
    let is_there = |ends: &[u32; 2]| ends.iter().all(|&v| at(v).is_finite());
    let mut joints: Vec<u32> =
        segments.par_iter().filter(|ends| is_there(ends)).flatten_iter().copied().collect();
    joints.par_sort_unstable();
    joints.dedup();
    let numbers: Vec<u32> = (0..segments.len() as u32).collect();
    let mut instances = sheet::draw(eye, look, &numbers, |sheet, &number| {
        let ends = segments[number as usize];
        if is_there(&ends) {
            tube::draw(sheet, ends.map(|v| eye.eye_space(at(v))), pen, inks(number as usize));
        }
    });
    instances.extend(sheet::draw(eye, look, &joints, |sheet, &v| {
        point::draw(sheet, eye.eye_space(at(v)), PointShape::Sphere, pen, joint(v));
    }));
    instances
}

/// Is the eye in the box of the edges?
fn is_inside(eye: &Eye, edges: &Edges, world_from_object: &DAffine3) -> bool {
    let bounds = edges.bounds();
    let at = world_from_object.inverse().transform_point3(eye.position());
    bounds.is_empty() || at.cmpge(bounds.min).all() && at.cmple(bounds.max).all()
}

/// Is the box of the edges in front of the near plane, so that no surface is cut by it?
fn is_in_front(eye: &Eye, edges: &Edges, world_from_object: &DAffine3) -> bool {
    let bounds = edges.bounds();
    let is_in_front =
        |corner: DVec3| eye.eye_space(world_from_object.transform_point3(corner)).z > eye.near();
    bounds.corners().into_iter().all(is_in_front)
}

/// Where edges at a place in the world are seen from.
fn viewer(eye: &Eye, edges: &Edges, world_from_object: &DAffine3) -> Viewer {
    let object_from_world = world_from_object.inverse();
    if eye.is_perspective() {
        let eye = object_from_world.transform_point3(eye.position());
        return Viewer::At((eye - edges.origin) / edges.unit());
    }
    Viewer::Along(object_from_world.transform_vector3(eye.world_axes(DVec3::Z)))
}

/// The lines of a file, at a place in the world, as instances for the camera of `eye`, in the colours of `data`, if there are any, or
/// else in colours of their own if they have any.
pub fn lines(
    eye: &Eye,
    (strokes, world_from_object): (&Strokes, &DAffine3),
    shape: LineShape,
    pen: &Pen,
    data: Option<&StrokeData>,
) -> Vec<Instance> {
    let at = |v: u32| world_from_object.transform_point3(strokes.position(v));
    let ink = |v: u32| ink(strokes, v, pen, data);
    match shape {
        LineShape::Tube => {
            let look = colored(lit(), data);
            let inks = |number: usize| strokes.segments[number].map(ink);
            tubes(eye, &look, &strokes.segments, at, (inks, ink), pen)
        }
        LineShape::Flat => sheet::draw(eye, &colored(plain(), data), &strokes.segments, |sheet, &ends| {
            let [a, b] = ends.map(at);
            if a.is_finite() && b.is_finite() {
                line::draw(sheet, &free([a, b].map(|p| eye.eye_space(p))), pen, ends.map(ink));
            }
        }),
    }
}

/// The points of a file, at a place in the world, as instances for the camera of `eye`, in the colours of `data`, if there are any, or
/// else in colours of their own if they have any.
pub fn points(
    eye: &Eye,
    (strokes, world_from_object): (&Strokes, &DAffine3),
    shape: PointShape,
    pen: &Pen,
    data: Option<&StrokeData>,
) -> Vec<Instance> {
    sheet::draw(eye, &colored(of_points(shape), data), &strokes.points, |sheet, &v| {
        let p = world_from_object.transform_point3(strokes.position(v));
        if p.is_finite() {
            point::draw(sheet, eye.eye_space(p), shape, pen, ink(strokes, v, pen, data));
        }
    })
}

/// The vertices of an instance's mesh as points, each once for every cluster that it is in, in the colours of the instance's data, if
/// there are any at vertices, or else of the mesh: those of vertices, or of faces and their materials that have no texture. Where faces of
/// several colours meet, it is one of them.
pub fn vertices(eye: &Eye, instance: &Instance, shape: PointShape, pen: &Pen) -> Vec<Instance> {
    let (mesh, place) = (&instance.mesh, &instance.world_from_object);
    let data = instance.data.as_deref().filter(|data| data.domain(mesh.layout()) == AttributeDomain::Vertex);
    let (mut look, mut readers) = (of_points(shape), Vec::new());
    let (mut scale, mut offset) = (1.0, 0.0);
    match data {
        Some(SurfaceData::Mapped { source, colors }) => {
            readers.push(DataReader::new(source, instance, colors.offset));
            look.colors = Some(Arc::clone(colors));
        }
        Some(SurfaceData::Direct { components, scale: times, offset: plus }) => {
            readers.extend(components.iter().map(|source| DataReader::new(source, instance, 0.0)));
            (scale, offset) = (*times, *plus);
        }
        None => {}
    }
    let byte = |value: f32| ((value * scale + offset).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let is_mapped = look.colors.is_some();
    let has_own_colors = readers.is_empty() && instance.surface.use_mesh_colors;
    let numbers: Vec<usize> = (0..mesh.clusters().len()).collect();
    // Chunks of clusters have as many points as chunks of points.
    let sheets = numbers.par_chunks(128).flat_map_iter(|numbers| {
        let points = numbers.iter().flat_map(|&number| {
            let cluster = mesh.cluster(number);
            let own_colors = has_own_colors.then(|| vertex_colors(&cluster, &mesh.materials));
            let ink = |v: usize| {
                let value = |reader: &DataReader| reader.vertex(&cluster, v);
                match &readers[..] {
                    [reader] if is_mapped => Ink { color: pen.color, value: value(reader) },
                    [] => own_colors.as_ref().and_then(|colors| colors[v]).unwrap_or(pen.color).into(),
                    all => {
                        let byte = |k: usize| all.get(k).map_or(255, |reader| byte(value(reader)));
                        Ink::from(std::array::from_fn(byte))
                    }
                }
            };
            (0..cluster.vertices()).map(|v| (mesh.position(&cluster, v), ink(v))).collect::<Vec<_>>()
        });
        let points: Vec<(DVec3, Ink)> = points.collect();
        sheet::draw(eye, &look, &points, |sheet, &(p, ink)| {
            point::draw(sheet, eye.eye_space(place.transform_point3(p)), shape, pen, ink);
        })
    });
    sheets.collect()
}

/// The colours of a cluster's vertices: their own, or else that of the first triangle that has one, by itself or by its material.
fn vertex_colors(cluster: &ClusterView, materials: &[FileMaterial]) -> Vec<Option<[u8; 4]>> {
    if let Some(colors) = cluster.vertex_colors() {
        return colors.iter().copied().map(Some).collect();
    }
    let mut colors = vec![None; cluster.vertices()];
    let (of_faces, numbers) = (cluster.face_colors(), cluster.triangle_materials());
    // That of a texture is not known here, and what it is multiplied by mostly white.
    let is_plain = |material: &&FileMaterial| material.textures.diffuse.is_none();
    let of_material = |triangle: usize| {
        materials.get(numbers?[triangle] as usize).filter(is_plain).map(FileMaterial::flat_color)
    };
    for triangle in 0..cluster.triangles() {
        let Some(color) = of_faces.map(|colors| colors[triangle]).or_else(|| of_material(triangle)) else {
            continue;
        };
        for corner in cluster.corners_of(triangle) {
            colors[usize::from(corner)].get_or_insert(color);
        }
    }
    colors
}

fn of_points(shape: PointShape) -> Look {
    match shape {
        PointShape::Sphere => lit(),
        PointShape::Square | PointShape::Round => plain(),
    }
}

/// A look in the colours of data.
fn colored(look: Look, data: Option<&StrokeData>) -> Look {
    match data {
        Some(StrokeData::Mapped { colors, .. }) => Look { colors: Some(Arc::clone(colors)), ..look },
        _ => look,
    }
}

/// The colour of a vertex.
fn ink(strokes: &Strokes, vertex: u32, pen: &Pen, data: Option<&StrokeData>) -> Ink {
    let own = strokes.color(vertex).unwrap_or(pen.color);
    data_ink(data, vertex as usize, own)
}

/// The colour of a place that has this number in data; `own` is its colour without them.
fn data_ink(data: Option<&StrokeData>, number: usize, own: [u8; 4]) -> Ink {
    match data {
        Some(StrokeData::Mapped { values, .. }) => Ink { color: own, value: values[number] },
        Some(StrokeData::Direct(colors)) => colors[number].into(),
        None => own.into(),
    }
}
