//! Collects what a camera sees of lines.

use std::collections::HashMap;

use glam::{DAffine3, DVec2, DVec3};
use tercio_mesh::edges::{Edge, Edges};
use tercio_mesh::loops::prelude::*;
use tercio_mesh::mesh::power_of_two;
use tercio_mesh::strokes::Strokes;
use tercio_scene::Instance;

use super::hiders::{Hiders, OF_POSITIONS, stretch};
use super::page::{Cap, Page, Shape, Style};
use super::{chain, contours};
use crate::strokes::{Eye, Length, Pen, PointShape, Segment};

/// Segments of a thread at a time.
const CHUNK: usize = 1 << 10;
/// How much the width of a line in units changes inside of a piece, at most.
const WIDTH_STEP: f64 = 0.04;

/// The lines of a page.
#[derive(Debug)]
pub struct Sketch<'a> {
    eye: &'a Eye,
    hiders: Option<&'a Hiders>,
    shapes: Vec<Shape>,
}

/// What is drawn of a segment: a piece of a line, and its width.
type Piece = ([DVec2; 2], f64);
/// Those of one style.
type Pieces = Vec<[DVec2; 2]>;

impl<'a> Sketch<'a> {
    /// How many pixels beside the picture lines are drawn, unless they are so wide that even that is seen in it.
    pub const MARGIN: f64 = 8.0;

    /// An empty one. Without `hiders`, hidden lines are drawn, too.
    pub fn new(eye: &'a Eye, hiders: Option<&'a Hiders>) -> Self {
        Self { eye, hiders, shapes: Vec::new() }
    }

    /// How many pixels beside the picture lines of these widths may be seen in it: what hides them has to be known there.
    pub fn margin(eye: &Eye, widths: &[Length]) -> f64 {
        let margin = |width: &Length| match width {
            Length::Pixels(width) => (0.5 * width + 1.0).max(Self::MARGIN),
            Length::Units(_) => eye.size().max_element(),
        };
        widths.iter().map(margin).fold(Self::MARGIN, f64::max)
    }

    /// Adds edges of a mesh; of those that two triangles share, only the ones on the silhouette, if that is requested: between a
    /// front and a back, or at a triangle that is seen edge-on.
    pub fn edges(&mut self, edges: &Edges, place: &DAffine3, pen: &Pen, only_silhouette: bool) {
        let eye = self.eye;
        let at = |v: u32| eye.eye_space(place.transform_point3(edges.position(v)));
        let points: Vec<DVec3> = (0..edges.positions.len() as u32).into_par_iter().map(at).collect();
        let largest = edges.positions.as_flattened().iter().fold(0.0f32, |m, c| m.max(c.abs()));
        let grain = f64::from(largest) * power_of_two(edges.exponent) * stretch(place) * OF_POSITIONS;
        let is_drawn = |edge: &&Edge| {
            let [p, q] = edge.ends.map(|v| points[v as usize]);
            // Where the third corner of a triangle is beside the plane through the eye and the edge.
            let side = |v: u32| {
                let apex = points[v as usize];
                let (beside, length) = if eye.is_perspective() {
                    let plane = p.cross(q - p);
                    ((apex - p).dot(plane), plane.length())
                } else {
                    let along = (q - p).truncate();
                    (along.perp_dot((apex - p).truncate()), along.length())
                };
                if beside.abs() <= grain * length { 0.0 } else { beside.signum() }
            };
            !only_silhouette
                || edge.apexes.contains(&Edge::NONE)
                || edge.apexes.map(side).iter().product::<f64>() >= 0.0
        };
        let ends: Vec<[DVec3; 2]> =
            edges.list.iter().filter(is_drawn).map(|edge| edge.ends.map(|v| points[v as usize])).collect();
        self.add(&ends, |_| pen.color, pen.width);
    }

    /// Adds lines in world space.
    pub fn segments(&mut self, segments: &[Segment]) {
        // Those of one width together.
        for of_width in segments.chunk_by(|a, b| a.width == b.width) {
            let ends: Vec<_> = of_width.iter().map(|s| s.ends.map(|p| self.eye.eye_space(p))).collect();
            self.add(&ends, |number| of_width[number].color, of_width[0].width);
        }
    }

    /// Adds the lines of a file at a place, in colours of their own if they have any; the mean of both ends.
    pub fn lines(&mut self, strokes: &Strokes, place: &DAffine3, pen: &Pen) {
        let ends: Vec<_> = strokes
            .segments
            .iter()
            .map(|segment| segment.map(|v| self.eye.eye_space(place.transform_point3(strokes.position(v)))))
            .collect();
        let color = |number: usize| {
            let [a, b] = strokes.segments[number].map(|v| strokes.color(v).unwrap_or(pen.color));
            [0, 1, 2, 3].map(|k: usize| u16::midpoint(a[k].into(), b[k].into()) as u8)
        };
        self.add(&ends, color, pen.width);
    }

    /// Adds the points of a file, in colours of their own if they have any. Spheres are discs.
    pub fn points(&mut self, strokes: &Strokes, place: &DAffine3, shape: PointShape, pen: &Pen) {
        let at = |&v: &u32| self.eye.eye_space(place.transform_point3(strokes.position(v)));
        let places: Vec<_> = strokes.points.iter().map(at).collect();
        let color = |number: usize| strokes.color(strokes.points[number]).unwrap_or(pen.color);
        let cap = if shape == PointShape::Square { Cap::Square } else { Cap::Round };
        self.dots(&places, cap, color, pen.width);
    }

    /// Adds lines on which the data of an instance have the given values, in ascending order, each with its colour. Data are
    /// interpolated linearly in each triangle; data at triangles have no such lines.
    pub fn contours(&mut self, instance: &Instance, values: &[(f64, [u8; 4])], width: Length) {
        let levels: Vec<f64> = values.iter().map(|value| value.0).collect();
        let pieces = contours::contours(instance, &levels);
        let ends: Vec<_> = pieces.par_iter().map(|piece| piece.1.map(|p| self.eye.eye_space(p))).collect();
        self.add(&ends, |number| values[pieces[number].0].1, width);
    }

    /// Adds what is drawn before everything so far.
    pub fn shapes(&mut self, shapes: Vec<Shape>) {
        self.shapes.extend(shapes);
    }

    /// The page.
    pub fn page(self, background: Option<[u8; 4]>) -> Page {
        Page { size: self.eye.size().to_array(), background, shapes: self.shapes }
    }

    /// Adds what is visible of segments in eye space.
    fn add(&mut self, ends: &[[DVec3; 2]], color: impl Fn(usize) -> [u8; 4], width: Length) {
        let (eye, hiders) = (self.eye, self.hiders);
        let visible = |&ends: &[DVec3; 2]| -> Vec<Piece> {
            let is_finite = ends.iter().all(|p| p.is_finite());
            let margin = Self::margin(eye, &[width]);
            let Some(ends) = is_finite.then(|| eye.clip(ends, margin)).flatten() else { return Vec::new() };
            let parts = hiders.map_or_else(|| vec![[0.0, 1.0]], |hiders| hiders.visible(ends));
            parts.into_iter().flat_map(|part| pieces(eye, ends, part, width)).collect()
        };
        let all: Vec<Vec<Vec<Piece>>> =
            ends.par_chunks(CHUNK).map(|chunk| chunk.iter().map(visible).collect()).collect();
        // By style, in the order in which styles appear.
        let mut numbers: HashMap<([u8; 4], u64), usize> = HashMap::new();
        let mut groups: Vec<(Style, Pieces)> = Vec::new();
        for (number, pieces) in all.into_iter().flatten().enumerate() {
            for (piece, width) in pieces {
                let color = color(number);
                let group = *numbers.entry((color, width.to_bits())).or_insert_with(|| {
                    groups.push((Style { color, width, cap: Cap::Round }, Vec::new()));
                    groups.len() - 1
                });
                groups[group].1.push(piece);
            }
        }
        let joined: Vec<Shape> = groups
            .into_par_iter()
            .map(|(style, pieces)| Shape::Lines { style, lines: chain::join(&pieces) })
            .collect();
        self.shapes.extend(joined);
    }

    fn dots(&mut self, places: &[DVec3], cap: Cap, color: impl Fn(usize) -> [u8; 4], width: Length) {
        let (eye, hiders) = (self.eye, self.hiders);
        let visible = |&p: &DVec3| {
            let width = three_digits(width.pixels(eye, p.z));
            let is_seen = p.is_finite()
                && eye.clip([p, p], 0.5 * width).is_some()
                && hiders.is_none_or(|hiders| !hiders.visible([p, p]).is_empty());
            is_seen.then(|| (eye.screen(p), width))
        };
        let all: Vec<Option<(DVec2, f64)>> = places.par_iter().with_min_len(CHUNK).map(visible).collect();
        let mut numbers: HashMap<([u8; 4], u64), usize> = HashMap::new();
        let first = self.shapes.len();
        for (number, place) in all.into_iter().enumerate() {
            let Some((at, width)) = place else { continue };
            let color = color(number);
            let group = *numbers.entry((color, width.to_bits())).or_insert_with(|| {
                self.shapes.push(Shape::Lines { style: Style { color, width, cap }, lines: Vec::new() });
                self.shapes.len() - 1 - first
            });
            if let Shape::Lines { lines, .. } = &mut self.shapes[first + group] {
                lines.push(vec![at]);
            }
        }
    }
}

/// A visible part of a segment on the screen: one piece, or several if its width changes. What is seen end-on is left out.
fn pieces(eye: &Eye, [p, q]: [DVec3; 2], [from, to]: [f64; 2], width: Length) -> Vec<Piece> {
    let at = |t: f64| match t {
        t if t <= 0.0 => p,
        t if t >= 1.0 => q,
        t => p.lerp(q, t),
    };
    let [a, b] = [at(from), at(to)];
    let steps = match width {
        Length::Pixels(_) => 1,
        Length::Units(_) => {
            let [wide, narrow] = [a.z.max(b.z), a.z.min(b.z)].map(|z| width.pixels(eye, z));
            // Widths change like 1 / z.
            ((narrow / wide - 1.0) / WIDTH_STEP).ceil().clamp(1.0, 64.0) as usize
        }
    };
    let on_screen = [a, b].map(|p| eye.screen(p));
    let cut = |k: usize| match k {
        0 => on_screen[0],
        k if k == steps => on_screen[1],
        k => on_screen[0].lerp(on_screen[1], k as f64 / steps as f64),
    };
    let of_step = |k: usize| {
        let ends = [cut(k), cut(k + 1)];
        // The nearness, and with it the width, is linear on the screen.
        let share = (k as f64 + 0.5) / steps as f64;
        let nearness = eye.nearness(a.z) + share * (eye.nearness(b.z) - eye.nearness(a.z));
        let pixels = width.pixels(eye, eye.distance(nearness));
        let is_drawn = ends.iter().all(|p| p.is_finite()) && ends[0].distance(ends[1]) > 1e-6;
        is_drawn
            .then(|| (ends, if matches!(width, Length::Pixels(_)) { pixels } else { three_digits(pixels) }))
    };
    (0..steps).filter_map(of_step).collect()
}

/// A width to about three digits, so that few different ones are written.
fn three_digits(width: f64) -> f64 {
    let mut step = 1e-4;
    while width > step * 1e3 && step < 1e3 {
        step *= 2.0;
    }
    (width / step).round().max(1.0) * step
}
