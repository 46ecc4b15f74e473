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
//! Where strokes that are not opaque overlap, each of them is a layer of its own: the picture is denser there.

mod eye;
mod line;
mod point;
mod sheet;

use glam::{DAffine3, DVec3};
use tercio_mesh::edges::Edges;
use tercio_mesh::mesh::power_of_two;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{Aabb, ClusteredMesh};
use tercio_scene::{Instance, Surface};

pub use eye::Eye;
use line::Line;

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

/// How points look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// The surface of strokes: their plain colours.
fn plain() -> Surface {
    Surface { unlit: true, specular: 0.0, ..Surface::default() }
}

/// Line segments as instances for the camera of `eye`.
pub fn segments(eye: &Eye, segments: &[Segment]) -> Vec<Instance> {
    sheet::draw(eye, &plain(), segments, |sheet, segment| {
        let pen = Pen { width: segment.width, color: segment.color };
        let ends = segment.ends.map(|p| eye.eye_space(p));
        line::draw(sheet, &free(ends), &pen, [segment.color; 2]);
    })
}

/// A line that is no edge.
fn free(ends: [DVec3; 2]) -> Line {
    Line { ends, apexes: [None; 2], hides_back: false, only_silhouette: false }
}

/// Edges of an instance's mesh as instances for the camera of `eye`; of those that two triangles share, only those on the
/// silhouette, if that is requested.
pub fn edges(
    eye: &Eye,
    edges: &Edges,
    world_from_object: &DAffine3,
    pen: &Pen,
    only_silhouette: bool,
) -> Vec<Instance> {
    let at = |v: u32| eye.eye_space(world_from_object.transform_point3(edges.position(v)));
    let hides_back = edges.is_solid && !is_inside(eye, edges, world_from_object);
    let mirrored = world_from_object.matrix3.determinant() < 0.0;
    sheet::draw(eye, &plain(), &edges.list, |sheet, edge| {
        let ends = edge.ends.map(at);
        let mut apexes = edge.apexes.map(|v| (v != tercio_mesh::edges::Edge::NONE).then(|| at(v)));
        if mirrored && apexes[1].is_some() {
            apexes.swap(0, 1);
        }
        let line = Line { ends, apexes, hides_back, only_silhouette };
        line::draw(sheet, &line, pen, [pen.color; 2]);
    })
}

/// Is the eye in the box of the edges?
fn is_inside(eye: &Eye, edges: &Edges, world_from_object: &DAffine3) -> bool {
    let mut bounds = Aabb::EMPTY;
    (0..edges.positions.len() as u32).for_each(|v| bounds.add(edges.position(v)));
    let at = world_from_object.inverse().transform_point3(eye.position());
    bounds.is_empty() || at.cmpge(bounds.min).all() && at.cmple(bounds.max).all()
}

/// The lines of a file, at a place in the world, as instances for the camera of `eye`, in colours of their own if they have any.
pub fn lines(eye: &Eye, strokes: &Strokes, world_from_object: &DAffine3, pen: &Pen) -> Vec<Instance> {
    sheet::draw(eye, &plain(), &strokes.segments, |sheet, &ends| {
        let [a, b] = ends.map(|v| world_from_object.transform_point3(strokes.position(v)));
        if a.is_finite() && b.is_finite() {
            line::draw(
                sheet,
                &free([a, b].map(|p| eye.eye_space(p))),
                pen,
                ends.map(|v| color(strokes, v, pen)),
            );
        }
    })
}

/// The points of a file, at a place in the world, as instances for the camera of `eye`, in colours of their own if they have any.
pub fn points(
    eye: &Eye,
    strokes: &Strokes,
    world_from_object: &DAffine3,
    shape: PointShape,
    pen: &Pen,
) -> Vec<Instance> {
    sheet::draw(eye, &of_points(shape), &strokes.points, |sheet, &v| {
        let p = world_from_object.transform_point3(strokes.position(v));
        if p.is_finite() {
            point::draw(sheet, eye.eye_space(p), shape, pen, color(strokes, v, pen));
        }
    })
}

/// The vertices of an instance's mesh as points, each once for every cluster that it is in.
pub fn vertices(
    eye: &Eye,
    mesh: &ClusteredMesh,
    world_from_object: &DAffine3,
    shape: PointShape,
    pen: &Pen,
) -> Vec<Instance> {
    let unit = power_of_two(mesh.exponent);
    let numbers: Vec<usize> = (0..mesh.clusters().len()).collect();
    // Chunks of clusters have as many points as chunks of points.
    let chunks: Vec<&[usize]> = numbers.chunks(512).collect();
    let sheets = chunks.iter().flat_map(|numbers| {
        let points = numbers.iter().flat_map(|&number| {
            let cluster = mesh.cluster(number);
            let color = move |v: usize| cluster.vertex_colors().map_or(pen.color, |colors| colors[v]);
            let at = move |v: usize| mesh.origin + DVec3::from(cluster.position(v).map(f64::from)) * unit;
            (0..cluster.vertices()).map(move |v| (at(v), color(v)))
        });
        let points: Vec<(DVec3, [u8; 4])> = points.collect();
        sheet::draw(eye, &of_points(shape), &points, |sheet, &(p, color)| {
            point::draw(sheet, eye.eye_space(world_from_object.transform_point3(p)), shape, pen, color);
        })
    });
    sheets.collect()
}

fn of_points(shape: PointShape) -> Surface {
    match shape {
        PointShape::Sphere => Surface { specular: 0.1, ..Surface::default() },
        PointShape::Square | PointShape::Round => plain(),
    }
}

fn color(strokes: &Strokes, vertex: u32, pen: &Pen) -> [u8; 4] {
    strokes.colors.as_ref().map_or(pen.color, |colors| colors[vertex as usize])
}
