//! Lines, edges and points of the model, for one camera.

use std::borrow::Cow;

use anyhow::{Context, Result, bail};
use tercio::LoadReport;
use tercio::data::StrokeData;
use tercio::glyphs::{self, Glyphs};
use tercio::mesh::edges::Edges;
use tercio::mesh::strokes::Strokes;
use tercio::mesh::{Aabb, AttributeDomain};
use tercio::raster::view::View;
use tercio::scene::{Camera, Instance, Scene};
use tercio::strokes::{self, Eye, LineShape};

use super::{Loaded, Render};
use crate::messages;

/// What is drawn besides the surface.
pub(super) struct Drawable {
    /// Lines and points of the file.
    pub file: Strokes,
    /// What their colours show.
    data: Option<StrokeData>,
    edges: Option<Edges>,
    glyphs: Option<Glyphs>,
}

impl Drawable {
    /// What has to be in the picture besides the surface: lines and points of the file, and the ends of glyphs.
    pub fn framed(&self) -> Cow<'_, Strokes> {
        let Some(glyphs) = &self.glyphs else { return Cow::Borrowed(&self.file) };
        let mut framed = Strokes { origin: self.file.origin, ..Strokes::default() };
        framed.positions.clone_from(&self.file.positions);
        let ends = glyphs.list.iter().flat_map(|glyph| [glyph.place, glyph.place + glyph.vector]);
        framed.positions.extend(ends.map(|p| (p - framed.origin).as_vec3().to_array()));
        framed.points = (0..framed.positions.len() as u32).collect();
        Cow::Owned(framed)
    }
}

impl Render {
    /// The lines and points of the file that are drawn. Those of a model that is clipped are not, and the report says so.
    pub(super) fn strokes_of(&self, report: &mut LoadReport, strokes: Strokes) -> Strokes {
        if self.clip.clipping().is_none() {
            return strokes;
        }
        (report.lines, report.points) = (0, 0);
        Strokes::default()
    }

    /// If no triangle was drawn, is that because of where strokes are?
    pub(super) fn strokes_are_beside(&self, report: &LoadReport) -> bool {
        report.lines + report.points > 0 || report.mesh.triangles > 0 && !self.strokes.has_surface()
    }

    /// The edges of a scene's model, if they are drawn, beside lines and points of its file.
    pub(super) fn drawable(
        &self,
        scene: &Scene,
        (file, data): (Strokes, Option<StrokeData>),
        taken: u64,
    ) -> Result<Drawable> {
        let model = scene.instances.first();
        let is_at_cells = |model: &Instance| {
            let domain = model.data.as_ref().map(|data| data.domain(model.mesh.layout()));
            domain == Some(AttributeDomain::Triangle) && !model.mesh.clusters().is_empty()
        };
        if self.strokes.has_vertices() && model.is_some_and(is_at_cells) {
            bail!(
                "{}: --mode points shows data of vertices, those of --color-by are at faces",
                self.model.name()
            );
        }
        let edges = match (self.strokes.selection(), model) {
            (Some(selection), Some(model)) => {
                self.check_memory(taken, Edges::needed_bytes(&model.mesh))?;
                Some(Edges::of_clusters(&model.mesh, selection))
            }
            _ => None,
        };
        let glyphs = match (self.strokes.glyphs(), model) {
            (Some(options), Some(model)) => {
                self.check_memory(taken, glyph_bytes(model, &file))?;
                let glyphs = options.glyphs(model, &file, data.as_ref());
                Some(glyphs.with_context(|| self.model.name())?)
            }
            _ => None,
        };
        if let Some(glyphs) = glyphs.as_ref().filter(|_| self.running.verbose) {
            messages::note(&told(glyphs));
        }
        Ok(Drawable { file, data, edges, glyphs })
    }

    /// The scene with strokes for a camera.
    pub(super) fn with_strokes<'a>(&self, loaded: &'a Loaded, camera: &Camera) -> Result<Cow<'a, Scene>> {
        let Loaded { scene, drawable: Drawable { file, data, edges, glyphs }, .. } = loaded;
        let (has_surface, has_vertices) = (self.strokes.has_surface(), self.strokes.has_vertices());
        if file.is_empty() && edges.is_none() && glyphs.is_none() && !has_vertices && has_surface {
            return Ok(Cow::Borrowed(scene));
        }
        let (width, height) = self.drawing.size;
        let of_glyphs = glyphs.as_ref().map_or(Aabb::EMPTY, Glyphs::bounds);
        let bounds = scene.bounds().union(file.bounds()).union(of_glyphs);
        let view = View::new(camera, &bounds, width, height).with_context(|| self.model.name())?;
        let eye = Eye::new(view);
        let mut drawn = scene.clone();
        if !has_surface {
            drawn.instances.clear();
        }
        if let (Some(model), Some(edges)) = (scene.instances.first(), edges) {
            let (pen, only) = (self.strokes.edge_pen(), self.strokes.is_silhouette());
            let place = &model.world_from_object;
            drawn.instances.extend(match self.strokes.line_shape() {
                LineShape::Flat => strokes::edges(&eye, edges, place, &pen, only),
                LineShape::Tube => strokes::edge_tubes(&eye, edges, place, &pen),
            });
        }
        let pens = self.strokes.pens(self.drawing.color());
        if has_vertices {
            for model in &scene.instances {
                drawn.instances.extend(strokes::vertices(&eye, model, self.strokes.shape(), &pens.points));
            }
        }
        let (line_shape, shape, data) = (self.strokes.line_shape(), self.strokes.shape(), data.as_ref());
        drawn.instances.extend(strokes::lines(&eye, file, line_shape, &pens.lines, data));
        drawn.instances.extend(strokes::points(&eye, file, shape, &pens.points, data));
        if let Some(glyphs) = glyphs {
            drawn.instances.extend(glyphs::draw(&eye, glyphs, &self.strokes.glyph_pen()));
        }
        Ok(Cow::Owned(drawn))
    }
}

/// Bytes that the places of glyphs take while some of them are chosen.
fn glyph_bytes(model: &Instance, file: &Strokes) -> u64 {
    let vertices = model.mesh.clusters().len() as u64 * 128;
    (vertices + file.positions.len() as u64) * 128
}

/// How many glyphs there are, and why not more.
fn told(glyphs: &Glyphs) -> String {
    let Glyphs { zero, not_finite, places, scale, .. } = glyphs;
    let drawn = glyphs.list.len();
    let mut text = format!(
        "{drawn} glyphs at {places} places (--glyph-every), {scale:.4} times as long as their vectors"
    );
    if *zero > 0 {
        text += &format!("; {zero} vectors are 0");
    }
    if *not_finite > 0 {
        text += &format!("; {not_finite} are not numbers");
    }
    text
}
