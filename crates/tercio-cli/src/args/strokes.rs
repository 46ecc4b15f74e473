//! Options of lines, edges and points.

use std::collections::HashSet;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio::glyphs::{GlyphOptions, GlyphShape};
use tercio::mesh::ClusteredMesh;
use tercio::mesh::color::srgb_bytes;
use tercio::mesh::edges::{Beyond, Edge, EdgeKind, Edges, Selection};
use tercio::mesh::strokes::Strokes;
use tercio::scene::{Background, Surface, SurfaceEdges, srgb_to_linear};
use tercio::strokes::{EdgePart, Length, LineShape, Pen, PointShape};

use super::values;

/// What of the model is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ModeName {
    /// The surface.
    #[default]
    Surface,
    /// All edges, and no surface: hidden ones are seen, too.
    Wireframe,
    /// The edges that the surface does not hide, on a surface in the colour of the background.
    HiddenLine,
    /// The vertices, and no surface.
    Points,
    /// Feature edges, and no surface.
    Edges,
    /// The data of --color-by without light: bands of one colour (10, or as many as --bands or --isolines say) with lines between
    /// them. Between values that --isolines lists the colour is that of the middle of their interval.
    Contours,
}

/// Which edges are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EdgesName {
    /// All edges of polygons.
    All,
    /// Edges at which the surface is bent by more than --feature-angle, and those of boundary.
    Feature,
    /// Edges of one triangle, and those of more than two.
    Boundary,
    /// Edges of more than two triangles.
    NonManifold,
    /// Edges between what the camera sees from its front and from its back, and those of boundary.
    Silhouette,
}

/// How points look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ShapeName {
    /// Squares.
    Square,
    /// Discs.
    #[default]
    Round,
    /// Lit spheres, with their true depth.
    Sphere,
}

/// How lines look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LineName {
    /// Strips that face the camera.
    #[default]
    Flat,
    /// Lit, round tubes, with their true depth.
    Tube,
}

/// How glyphs look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum GlyphName {
    /// Arrows from the place to the end of the vector.
    #[default]
    Arrow,
    /// Lines from the place to the end of the vector.
    Line,
    /// Spheres around the place, as large as the vector is long.
    Sphere,
    /// Cones from the place to the end of the vector.
    Cone,
}

/// How lines and points of a file are drawn.
pub struct Pens {
    /// Lines.
    pub lines: Pen,
    /// Points.
    pub points: Pen,
}

/// Lines, edges and points.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Lines and points")]
pub struct StrokeArgs {
    /// What of the model is drawn; lines and points of the file always are.
    #[arg(long, alias = "style", value_name = "WHAT", value_enum, default_value_t = ModeName::Surface)]
    mode: ModeName,
    /// Draws edges on the surface, or chooses those of --mode [default: all; feature for --mode edges].
    /// Several with commas: --edges=feature,silhouette. All edges, at most 4 pixels wide, are shaded with a
    /// surface that is opaque, which is quick; others are strips in front of it.
    #[arg(long, alias = "show-edges", value_name = "WHICH", num_args = 0..=1, default_missing_value = "all", require_equals = true)]
    #[arg(value_enum, value_delimiter = ',')]
    edges: Option<Vec<EdgesName>>,
    /// Width of lines and edges: pixels of the picture, or with a u units of the model (0.1u) [default: 1.5; edges on a
    /// surface 1; tubes 4].
    #[arg(long, value_name = "WIDTH", value_parser = length)]
    line_width: Option<Length>,
    /// How lines and edges look; tubes need a width of some pixels, or in units of the model.
    #[arg(long, value_name = "SHAPE", value_enum, default_value_t = LineName::Flat)]
    line_shape: LineName,
    /// Diameter of points: pixels of the picture, or with a u units of the model (0.1u) [default: 3].
    #[arg(long, value_name = "SIZE", value_parser = length)]
    point_size: Option<Length>,
    /// How points look.
    #[arg(long, value_name = "SHAPE", value_enum, default_value_t = ShapeName::Round)]
    point_shape: ShapeName,
    /// Colour of edges, also translucent (#rrggbbaa); where these overlap, they are denser [default:
    /// #202428; in a picture without a surface, that of the data of --color-by].
    #[arg(long, value_name = "COLOR", value_parser = values::color)]
    edge_color: Option<[u8; 4]>,
    /// Draws glyphs of a vector: an attribute of two or three components, as --color-by names it, or @normal. They are at the vertices,
    /// at the middle of triangles for data of cells, or at lines and points where only these have it.
    #[arg(long, value_name = "NAME")]
    glyphs: Option<String>,
    /// How glyphs look.
    #[arg(long, value_name = "SHAPE", value_enum, default_value_t = GlyphName::Arrow, hide_short_help = true)]
    #[arg(requires = "glyphs")]
    glyph: GlyphName,
    /// Length of glyphs per length of vectors, in units of the model; auto: the longest is about as long as glyphs are apart.
    #[arg(long, value_name = "S|auto", value_parser = scale, default_value = "auto", hide_short_help = true)]
    #[arg(requires = "glyphs")]
    glyph_scale: Scale,
    /// One glyph for every N places, spread evenly; 1 for all of them [default: at most 2000 glyphs].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), hide_short_help = true)]
    #[arg(requires = "glyphs")]
    glyph_every: Option<u32>,
    /// Colour of glyphs [default: that of the data of --color-by at their places, or else dark].
    #[arg(long, value_name = "COLOR", value_parser = values::color, hide_short_help = true, requires = "glyphs")]
    glyph_color: Option<[u8; 4]>,
    /// Edges are features where the surface is bent by more than this many degrees [default: 30].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::crease_angle)]
    feature_angle: Option<f64>,
}

/// `--glyph-scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale(Option<f64>);

fn scale(text: &str) -> Result<Scale, String> {
    match text.trim() {
        "auto" => Ok(Scale(None)),
        number => values::positive(number).map(|scale| Scale(Some(scale))),
    }
}

impl StrokeArgs {
    /// Options without any effect are reported as a mistake, and those that are not possible.
    pub fn check(&self, in_parts: bool) -> Result<(), &'static str> {
        if in_parts && (self.has_edges() || self.mode != ModeName::Surface) {
            return Err(
                "--mode and --edges are not possible with --parts: the edges of a part are not those of the model",
            );
        }
        if in_parts && self.glyphs.is_some() {
            return Err(
                "--glyphs is not possible with --parts: which places have one depends on all of them",
            );
        }
        if self.mode == ModeName::Points && self.edges.is_some() {
            return Err("--edges has no effect with --mode points");
        }
        if self.line_shape == LineName::Tube && self.has_silhouette() {
            return Err("--line-shape tube has no silhouettes: --edges=silhouette are lines");
        }
        if self.edge_color.is_some() && !self.has_edges() {
            return Err("--edge-color has no effect without --edges or a --mode with edges");
        }
        if self.feature_angle.is_some() && !self.names().contains(&EdgesName::Feature) {
            return Err("--feature-angle has no effect without --edges=feature");
        }
        Ok(())
    }

    /// Which edges are drawn.
    fn names(&self) -> Vec<EdgesName> {
        match (&self.edges, self.mode) {
            (Some(names), _) => names.clone(),
            (None, ModeName::Surface | ModeName::Points | ModeName::Contours) => Vec::new(),
            (None, ModeName::Wireframe | ModeName::HiddenLine) => vec![EdgesName::All],
            (None, ModeName::Edges) => vec![EdgesName::Feature],
        }
    }

    /// Which edges are drawn besides silhouettes: what includes most of what is wanted.
    fn plain(&self) -> Option<EdgesName> {
        // Silhouettes have all edges of one and of more than two triangles.
        let order = [EdgesName::All, EdgesName::Feature, EdgesName::Boundary, EdgesName::NonManifold];
        let names = self.names();
        let found = order.into_iter().find(|name| names.contains(name));
        found.filter(|name| *name != EdgesName::NonManifold || !names.contains(&EdgesName::Silhouette))
    }

    /// Are edges drawn?
    pub fn has_edges(&self) -> bool {
        !self.names().is_empty()
    }

    /// How many times edges are searched for.
    pub fn searches(&self) -> u64 {
        u64::from(self.plain().is_some()) + u64::from(self.has_silhouette())
    }

    fn has_silhouette(&self) -> bool {
        self.names().contains(&EdgesName::Silhouette) && self.plain() != Some(EdgesName::All)
    }

    /// The edges of a mesh that are drawn, and what of them. No edge is listed twice.
    pub fn edges_of(&self, mesh: &ClusteredMesh) -> Vec<(Edges, EdgePart)> {
        let mut all = Vec::new();
        if let Some(plain) = self.plain() {
            let angle = self.feature_angle.unwrap_or(30.0).to_radians();
            let mut edges = Edges::of_clusters(
                mesh,
                match plain {
                    EdgesName::All => Selection::All,
                    EdgesName::Feature => Selection::Feature(angle),
                    _ => Selection::Boundary,
                },
            );
            if plain == EdgesName::NonManifold {
                edges.list.retain(|edge| edge.kind == EdgeKind::NonManifold);
            }
            all.push((edges, EdgePart::All));
        }
        if self.has_silhouette() {
            let mut edges = Edges::of_clusters(mesh, Selection::Silhouette);
            if let Some((plain, _)) = all.first() {
                // Both have a mesh's positions as they are.
                let ends = |edges: &Edges, edge: &Edge| {
                    let mut ends = edge.ends.map(|v| edges.positions[v as usize].map(f32::to_bits));
                    ends.sort_unstable();
                    ends
                };
                let known: HashSet<_> = plain.list.iter().map(|edge| ends(plain, edge)).collect();
                let keeps =
                    |edge: &Edge| edge.kind == EdgeKind::Inner && !known.contains(&ends(&edges, edge));
                edges.list = edges.list.iter().copied().filter(keeps).collect();
            }
            all.push((edges, EdgePart::Silhouette));
        }
        all
    }

    /// Is the surface drawn?
    pub fn has_surface(&self) -> bool {
        matches!(self.mode, ModeName::Surface | ModeName::HiddenLine | ModeName::Contours)
    }

    /// Does the picture have lines alone, without shaded surfaces?
    pub fn has_lines(&self) -> bool {
        !matches!(self.mode, ModeName::Surface | ModeName::Points)
    }

    /// Can anything show data: the surface or edges, unless it is a drawing of lines, or contours, points, lines of the file, or
    /// glyphs?
    pub fn shows_data(&self, is_drawing: bool, has_file: bool) -> bool {
        let of_surface = self.has_surface() && !is_drawing;
        of_surface
            || self.edges_show_data(is_drawing)
            || self.is_contours()
            || self.has_vertices()
            || has_file
            || self.glyphs.is_some()
    }

    /// Do edges show data: where there is no surface that does, they have no colour of their own, and it is no drawing of lines?
    pub fn edges_show_data(&self, is_drawing: bool) -> bool {
        let has_no_surface = matches!(self.mode, ModeName::Wireframe | ModeName::Edges);
        has_no_surface && self.edge_color.is_none() && !is_drawing
    }

    /// Are contours of data drawn?
    pub fn is_contours(&self) -> bool {
        self.mode == ModeName::Contours
    }

    /// Are the vertices drawn as points?
    pub fn has_vertices(&self) -> bool {
        self.mode == ModeName::Points
    }

    /// How edges are drawn.
    pub fn edge_pen(&self) -> Pen {
        let is_tube = self.line_shape == LineName::Tube;
        let width = match self.mode {
            _ if is_tube => TUBE,
            ModeName::Surface | ModeName::Contours => 1.0,
            _ => 1.5,
        };
        let color = self.edge_color.unwrap_or_else(|| if is_tube { opaque(None) } else { INK });
        Pen { width: self.line_width.unwrap_or(Length::Pixels(width)), color }
    }

    /// The edges of a surface that are drawn where the surface is shaded: all of them, as thin lines.
    pub fn on_surface(&self, edges: &Edges) -> Option<SurfaceEdges> {
        let Pen { width: Length::Pixels(width), color: [r, g, b, alpha] } = self.edge_pen() else {
            return None;
        };
        let is_thin = self.line_shape == LineName::Flat && width <= WIDEST_ON_SURFACE;
        if !self.has_surface() || !is_thin || self.plain() != Some(EdgesName::All) {
            return None;
        }
        let beyond = edges.beyond.clone();
        // Where polygons are bent, lines on the surface and strips lie over each other.
        if edges.folds.is_some() && alpha < 255 {
            return None;
        }
        let has_polygons = beyond != Beyond::Nothing;
        let lines = SurfaceEdges::new([r, g, b], width as f32, has_polygons.then(|| edges.sides.clone()));
        Some(SurfaceEdges { opacity: f32::from(alpha) / 255.0, beyond, ..lines })
    }

    /// How lines and points without colours of their own are drawn, if the model has this linear colour; `is_darkened` if an
    /// effect darkens them by their depth.
    pub fn pens(&self, color: Option<[f32; 3]>, is_darkened: bool) -> Pens {
        let ink = color.map_or(INK, |color| opaque(Some(color)));
        // Light makes the form of spheres and tubes visible, and effects that of clouds; both need a colour that is not dark.
        let of_points = match self.point_shape {
            ShapeName::Square | ShapeName::Round if !is_darkened => ink,
            _ => opaque(color),
        };
        let (width, of_lines) = match self.line_shape {
            LineName::Tube => (TUBE, opaque(color)),
            LineName::Flat => (1.5, ink),
        };
        Pens {
            lines: Pen { width: self.line_width.unwrap_or(Length::Pixels(width)), color: of_lines },
            points: Pen { width: self.point_size.unwrap_or(Length::Pixels(3.0)), color: of_points },
        }
    }

    /// What the lines and points of a file take beside their places, in world units; 0 if their widths are pixels.
    pub fn margin_of(&self, file: &Strokes) -> f64 {
        let lines = self.line_width.filter(|_| !file.segments.is_empty());
        let points = self.point_size.filter(|_| !file.points.is_empty());
        half(lines).max(half(points) * self.corners_of_points())
    }

    /// What edges and points of vertices take beside the surface.
    pub fn margin_of_mesh(&self) -> f64 {
        let lines = self.line_width.filter(|_| self.has_edges());
        let points = self.point_size.filter(|_| self.has_vertices());
        half(lines).max(half(points) * self.corners_of_points())
    }

    /// How much farther than its sides the corners of a point are.
    fn corners_of_points(&self) -> f64 {
        if self.point_shape == ShapeName::Square { std::f64::consts::SQRT_2 } else { 1.0 }
    }

    /// Is anything drawn as a body in space, which a drawing of lines cannot hold?
    pub fn has_bodies(&self) -> bool {
        self.glyphs.is_some() || self.line_shape == LineName::Tube
    }

    /// Which glyphs are drawn, if any.
    pub fn glyphs(&self) -> Option<GlyphOptions> {
        let shape = match self.glyph {
            GlyphName::Arrow => GlyphShape::Arrow,
            GlyphName::Line => GlyphShape::Line,
            GlyphName::Sphere => GlyphShape::Sphere,
            GlyphName::Cone => GlyphShape::Cone,
        };
        let (scale, every, color) = (self.glyph_scale.0, self.glyph_every, self.glyph_color);
        self.glyphs.as_ref().map(|by| GlyphOptions { shape, scale, every, color, ..GlyphOptions::new(by) })
    }

    /// The name of the vector of glyphs.
    pub fn glyph_vector(&self) -> Option<&str> {
        self.glyphs.as_deref()
    }

    /// How glyphs without a colour are drawn.
    pub fn glyph_pen(&self) -> Pen {
        Pen { width: self.line_width.unwrap_or(Length::Pixels(1.5)), color: INK }
    }

    /// How lines look.
    pub fn line_shape(&self) -> LineShape {
        match self.line_shape {
            LineName::Flat => LineShape::Flat,
            LineName::Tube => LineShape::Tube,
        }
    }

    /// How points look.
    pub fn shape(&self) -> PointShape {
        match self.point_shape {
            ShapeName::Square => PointShape::Square,
            ShapeName::Round => PointShape::Round,
            ShapeName::Sphere => PointShape::Sphere,
        }
    }

    /// The background of a hidden-line picture, if none is given: paper.
    pub fn dress_background(&self, background: &mut Background) {
        if self.mode == ModeName::HiddenLine && *background == Background::default() {
            *background = Background::Solid([1.0; 4]);
        }
    }

    /// Gives the surface of a hidden-line picture on this background its look: paper.
    pub fn dress_surface(&self, surface: &mut Surface, background: &Background) {
        if self.mode != ModeName::HiddenLine {
            return;
        }
        let paper = match *background {
            Background::Solid([.., alpha]) if alpha <= 0.0 => [1.0; 4],
            other => other.middle(),
        };
        let [r, g, b, _] = paper.map(|c| srgb_to_linear(f64::from(c)) as f32);
        (surface.base_color, surface.use_mesh_colors, surface.unlit) = ([r, g, b], false, true);
    }

    /// For reports.
    pub fn json(&self) -> Value {
        json!({
            "mode": values::name(&self.mode),
            "edges": self.has_edges().then(|| {
                self.names().iter().map(values::name).collect::<Option<Vec<_>>>().map(|names| names.join(","))
            }),
            "glyphs": self.glyphs,
            "line_shape": values::name(&self.line_shape),
            "point_shape": values::name(&self.point_shape),
        })
    }
}

/// Half of a length in world units.
fn half(length: Option<Length>) -> f64 {
    match length {
        Some(Length::Units(units)) => units * 0.5,
        _ => 0.0,
    }
}

/// A number above 0, of pixels, or of units with a `u` behind it.
fn length(text: &str) -> Result<Length, String> {
    let text = text.trim();
    let (number, is_units) = match text.strip_suffix('u') {
        Some(number) => (number, true),
        None => (text.strip_suffix("px").unwrap_or(text), false),
    };
    match values::positive(number) {
        Ok(units) if is_units => Ok(Length::Units(units)),
        Ok(pixels) if pixels <= MOST_PIXELS => Ok(Length::Pixels(pixels)),
        _ => Err(format!("expected pixels, above 0 and at most {MOST_PIXELS}, or units such as 0.1u")),
    }
}

/// A linear colour, or that of surfaces, in bytes.
fn opaque(color: Option<[f32; 3]>) -> [u8; 4] {
    let [r, g, b] = srgb_bytes(color.unwrap_or(Surface::default().base_color));
    [r, g, b, 0xff]
}

/// Width of tubes in pixels, unless it is given.
const TUBE: f64 = 4.0;

/// Lines that are wider than so many pixels are drawn as strips with round ends, beyond the triangles beside them.
const WIDEST_ON_SURFACE: f64 = 4.0;

/// Wider lines are areas.
const MOST_PIXELS: f64 = 1024.0;

/// Dark: it is seen on models and on the default background.
const INK: [u8; 4] = [0x20, 0x24, 0x28, 0xff];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_pixels_or_units() {
        assert_eq!(length("2"), Ok(Length::Pixels(2.0)));
        assert_eq!(length("1.5px"), Ok(Length::Pixels(1.5)));
        assert_eq!(length("0.25u"), Ok(Length::Units(0.25)));
        for bad in ["", "0", "-1", "u", "2000", "nan", "1e400u", "3mm"] {
            assert!(length(bad).is_err(), "{bad}");
        }
    }
}
