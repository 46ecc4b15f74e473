//! Lines, edges and points of the model, for one camera.

use std::borrow::Cow;

use anyhow::{Context, Result};
use tercio::LoadReport;
use tercio::mesh::edges::Edges;
use tercio::mesh::strokes::Strokes;
use tercio::raster::view::View;
use tercio::scene::{Camera, Scene};
use tercio::strokes::{self, Eye};

use super::{Loaded, Render};

/// What is drawn besides the surface.
pub(super) struct Drawable {
    /// Lines and points of the file.
    pub file: Strokes,
    /// Edges, and whether only those on the silhouette are drawn.
    pub edges: Vec<(Edges, bool)>,
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
    pub(super) fn drawable(&self, scene: &Scene, file: Strokes, taken: u64) -> Result<Drawable> {
        let model = scene.instances.first();
        let edges = match model.filter(|_| self.strokes.has_edges()) {
            Some(model) => {
                let needed = Edges::needed_bytes(&model.mesh).saturating_mul(self.strokes.searches());
                self.check_memory(taken, needed)?;
                self.strokes.edges_of(&model.mesh)
            }
            None => Vec::new(),
        };
        self.report_edges(&edges);
        Ok(Drawable { file, edges })
    }

    /// The scene with strokes for a camera.
    pub(super) fn with_strokes<'a>(&self, loaded: &'a Loaded, camera: &Camera) -> Result<Cow<'a, Scene>> {
        let Loaded { scene, drawable: Drawable { file, edges }, .. } = loaded;
        let (has_surface, has_vertices) = (self.strokes.has_surface(), self.strokes.has_vertices());
        if file.is_empty() && edges.is_empty() && !has_vertices && has_surface {
            return Ok(Cow::Borrowed(scene));
        }
        let (width, height) = self.drawing.size;
        let bounds = scene.bounds().union(file.bounds());
        let view = View::new(camera, &bounds, width, height).with_context(|| self.model.name())?;
        let eye = Eye::new(view);
        let mut drawn = scene.clone();
        if !has_surface {
            drawn.instances.clear();
        }
        if let Some(model) = scene.instances.first() {
            let pen = self.strokes.edge_pen();
            for (edges, only_silhouette) in edges {
                let place = &model.world_from_object;
                drawn.instances.extend(strokes::edges(&eye, edges, place, &pen, *only_silhouette));
            }
        }
        let pens = self.strokes.pens(self.drawing.color());
        if has_vertices {
            for model in &scene.instances {
                let (mesh, place) = (&model.mesh, &model.world_from_object);
                drawn.instances.extend(strokes::vertices(
                    &eye,
                    mesh,
                    place,
                    self.strokes.shape(),
                    &pens.points,
                ));
            }
        }
        drawn.instances.extend(strokes::lines(&eye, file, &pens.lines));
        drawn.instances.extend(strokes::points(&eye, file, self.strokes.shape(), &pens.points));
        Ok(Cow::Owned(drawn))
    }
}
